//! Products of the slopes of two sums, contracted over their common slots. Tests: `discretise/sums/tests.rs`.

use std::collections::HashMap;

use super::solve::{Coincidence, Equation, solve};
use super::{Calculus, Groups, Space, Sum, Weighted, variable};
use crate::model::{Atom, Element, Half, Index, Loop};
use crate::symbolic::{Expr, Graph, Rational, Symbol};

/// The treatment of the increments of two sums.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Increments {
    /// The product of two sums with independent increments.
    Each,
    /// The product of two sums with the same increments: `ΔW_j ΔW_k` is `ΔW_k ΔW_j`.
    Together,
    /// The mean of such a product over the increments: nonzero only if both belong to one noise.
    Diagonal,
}

/// A sum, and the half of the phase space by which it is differentiated.
type By<'s> = (&'s Sum, Half);

/// An element with its loop variables renamed apart from another's, and its slopes.
struct Factor {
    element: Element,
    increments: Vec<Index>,
    slopes: HashMap<Symbol, Expr>,
}

impl Factor {
    fn new(weighted: &Weighted, shift: u32) -> Option<Self> {
        let loops = &weighted.element.loops;
        let moved = |index: &Index| {
            loops.iter().try_fold(index.clone(), |index, known| {
                index.with(known.variable, &variable(known.variable + shift))
            })
        };
        let Weighted { mut element, increments } = weighted.mapped(&moved, &moved)?;
        element.loops.iter_mut().for_each(|known| known.variable += shift);
        Some(Self { element, increments, slopes: HashMap::new() })
    }

    fn slope(&mut self, graph: &mut Graph, symbol: Symbol) -> Expr {
        let value = self.element.value;
        *self.slopes.entry(symbol).or_insert_with(|| graph.derivative(value, symbol))
    }
}

/// A factor, and its slope by one of its variables.
struct FactorSlope<'f> {
    factor: &'f Factor,
    slope: Expr,
}

/// The places at which a sum reads one half of the phase space: constant ones and loop-dependent ones.
#[derive(Default)]
struct Readers {
    at: HashMap<i128, Vec<(usize, Symbol)>>,
    moving: Vec<(usize, Symbol, Index)>,
    fixed: Vec<(usize, Symbol, Index)>,
}

impl Readers {
    fn of(factors: &[Factor], half: Half) -> Self {
        let mut readers = Self::default();
        for (number, factor) in factors.iter().enumerate() {
            for (symbol, index) in factor.element.of_half(half) {
                match index.as_integer() {
                    Some(known) => {
                        readers.at.entry(known).or_default().push((number, symbol));
                        readers.fixed.push((number, symbol, index.clone()));
                    }
                    None => readers.moving.push((number, symbol, index.clone())),
                }
            }
        }
        readers
    }

    /// The readers that may share the slot `index`.
    fn meeting(&self, index: &Index) -> Vec<(usize, Symbol, Index)> {
        let fixed = match index.as_integer() {
            Some(known) => {
                let at = self.at.get(&known).map_or(&[][..], Vec::as_slice);
                at.iter().map(|&(number, symbol)| (number, symbol, index.clone())).collect()
            }
            None => self.fixed.clone(),
        };
        [fixed, self.moving.clone()].concat()
    }
}

impl Calculus<'_> {
    /// `Σ_s ∂F/∂x_s ∂G/∂y_s` over all slots `s`, for a half of the phase space each; `None` if an index
    /// exceeds this arithmetic.
    pub(crate) fn contract(&mut self, one: By<'_>, other: By<'_>, increments: Increments) -> Option<Sum> {
        let ((first, by), (second, other)) = (one, other);
        let beyond = self.space.first_free_variable();
        let factors =
            |sum: &Sum, shift: u32| sum.iter().map(|w| Factor::new(w, shift)).collect::<Option<Vec<_>>>();
        let [first, second] = [first, second].map(|sum| self.opened(sum));
        let (mut first, mut second) = (factors(&first, beyond)?, factors(&second, 2 * beyond)?);
        let readers = Readers::of(&second, other);
        let mut groups = Groups::default();
        for one in &mut first {
            let read: Vec<_> = one.element.of_half(by).map(|(x, place)| (x, place.clone())).collect();
            for (x, place) in read {
                for (number, y, there) in readers.meeting(&place) {
                    let two = &mut second[number];
                    let (slope, speed) = (one.slope(self.graph, x), two.slope(self.graph, y));
                    if self.graph.is_zero(slope) || self.graph.is_zero(speed) {
                        continue;
                    }
                    let equation = Equation { difference: place.subtract(&there)?, is_of_slots: true };
                    let slopes =
                        [FactorSlope { factor: one, slope }, FactorSlope { factor: two, slope: speed }];
                    self.add_product(slopes, equation, increments, &mut groups)?;
                }
            }
        }
        Some(groups.finish(self))
    }

    /// Adds the product of two slopes, restricted to the solutions of an equation.
    fn add_product(
        &mut self,
        slopes: [FactorSlope<'_>; 2],
        equation: Equation,
        increments: Increments,
        groups: &mut Groups,
    ) -> Option<()> {
        let [one, two] = slopes.each_ref().map(|slope| slope.factor);
        let numbers = joined(&one.increments, &two.increments, increments);
        let mut equations = vec![equation];
        if increments == Increments::Diagonal {
            for (a, b) in one.increments.iter().zip(&two.increments) {
                equations.push(Equation { difference: a.subtract(b)?, is_of_slots: false });
            }
        }
        if one.element.loops.is_empty()
            && two.element.loops.is_empty()
            && equations.iter().all(|e| e.difference == Index::default())
        {
            let product = self.graph.multiply(slopes[0].slope, slopes[1].slope);
            groups.add(Vec::new(), numbers, product, Rational::ONE);
            return Some(());
        }
        let loops = [one.element.loops.as_slice(), &two.element.loops].concat();
        let Self { space, graph } = self;
        let Some(coincidence) = solve(space, loops, equations, 3 * space.first_free_variable())? else {
            return Some(());
        };
        // All indices of both, to be moved together.
        let mut normal_form = NormalForm { loops: coincidence.loops.clone(), by: Vec::new() };
        let numbers =
            numbers.iter().map(|index| coincidence.image(space, index)).collect::<Option<Vec<_>>>()?;
        let read = space.images(&coincidence, &[one, two])?;
        normal_form.normalise(space, &read)?;
        let mut value = Vec::new();
        for FactorSlope { factor, slope } in slopes {
            let mut images = HashMap::new();
            for local in &factor.element.locals {
                let slot = local.slot.map(|index| normal_form.moved(&coincidence.image(space, index)?))?;
                let symbol = space.symbol(graph, &slot);
                if symbol != local.symbol {
                    images.insert(local.symbol, graph.symbol(symbol));
                }
            }
            value.extend(graph.substitute(&[slope], &images));
        }
        let product = graph.product(&value);
        let mut numbers = numbers.iter().map(|index| normal_form.moved(index)).collect::<Option<Vec<_>>>()?;
        if increments == Increments::Together {
            numbers.sort();
        }
        groups.add(normal_form.loops, numbers, product, Rational::ONE);
        Some(())
    }
}

impl Space {
    /// The indices of the state that the factors read at a placement.
    fn images(&self, coincidence: &Coincidence, factors: &[&Factor]) -> Option<Vec<Index>> {
        let halves = [Half::Coordinates, Half::Momenta];
        let read = factors.iter().flat_map(|factor| halves.map(|half| factor.element.of_half(half)));
        read.flatten().map(|(_, index)| coincidence.image(self, index)).collect()
    }
}

fn joined(one: &[Index], two: &[Index], increments: Increments) -> Vec<Index> {
    let mut numbers = match increments {
        Increments::Diagonal => Vec::new(),
        Increments::Each | Increments::Together => [one, two].concat(),
    };
    if increments == Increments::Together {
        numbers.sort();
    }
    numbers
}

/// Loops in canonical form.
struct NormalForm {
    loops: Vec<Loop>,
    by: Vec<(u32, Index)>,
}

impl NormalForm {
    /// Moves every loop so that the first point that it reads is its variable, and numbers the variables by
    /// depth.
    fn normalise(&mut self, space: &Space, read: &[Index]) -> Option<()> {
        for at in 0..self.loops.len() {
            let own = self.loops[at].variable;
            let offsets = read.iter().map(|index| offset(index, own, space.components));
            let offsets: Option<Vec<Option<i128>>> = offsets.collect();
            let first = offsets.and_then(|offsets| offsets.into_iter().flatten().min());
            let shift = first.unwrap_or(0);
            let settled = variable(space.variable(at));
            let known = &mut self.loops[at];
            known.variable = space.variable(at);
            known.start = known.start.shifted(shift)?;
            known.end = known.end.shifted(shift)?;
            let by = settled.shifted(-shift)?;
            for inner in &mut self.loops[at + 1..] {
                inner.start = inner.start.with(own, &by)?;
                inner.end = inner.end.with(own, &by)?;
            }
            self.by.push((own, by));
        }
        Some(())
    }

    fn moved(&self, index: &Index) -> Option<Index> {
        self.by.iter().try_fold(index.clone(), |index, (own, by)| index.with(*own, by))
    }
}

/// The offset, in points, of an index from the variable of a loop: `Some(None)` if it does not read the
/// variable, `None` if it reads it otherwise.
fn offset(index: &Index, own: u32, components: i128) -> Option<Option<i128>> {
    match index.slope(own)? {
        0 => Some(None),
        slope if slope == components => {
            let others_are_loops = index.terms.iter().all(|(atom, _)| matches!(atom, Atom::Loop(_)));
            others_are_loops.then(|| Some(index.constant.div_euclid(components)))
        }
        _ => None,
    }
}
