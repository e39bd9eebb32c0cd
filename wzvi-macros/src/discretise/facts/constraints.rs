//! Constraints `g(q, t) = 0`: what is wrong with one, and what moves the system off the manifold. Tests:
//! `tests/constraints`, `tests/compiler/ui/fail`.

use std::collections::BTreeMap;

use super::{Hamiltonians, NumberedSum};
use crate::diagnostics::{Extent, promised};
use crate::discretise::{Calculus, Increments, KnownSum, Sum, Weighted, weighted};
use crate::model::{Atom, Element, Index, System};
use crate::symbolic::sign::Sign;
use crate::symbolic::{Expr, Graph, Knowledge, Node, Rational, Symbol, ZeroTest};

/// A constraint, or a family of them.
pub(crate) struct Constraint {
    pub(crate) extent: Extent,
    /// The suffix of `g`.
    pub(crate) number: String,
    /// Its value; for a family with the number of the member as an increment, so that a sum that vanishes
    /// does for each member.
    pub(crate) value: Sum,
    /// Why it is no constraint, if it is none.
    pub(crate) mistake: Option<ConstraintMistake>,
    /// `{g, H_k}` of a noise that reads momenta, if it is not proven to vanish.
    pub(crate) noise: Option<NoiseOffManifold>,
}

/// Why a function is no constraint.
#[derive(Clone, Copy)]
pub(crate) enum ConstraintMistake {
    /// It reads no coordinates.
    NoCoordinates,
    /// It is not zero at any point.
    NoPoint,
    /// It is affine in the coordinates.
    Affine,
    /// It is a multiple of the constraint with this number, from 0.
    Multiple(usize),
}

/// A noise that would move the system off the manifold.
pub(crate) struct NoiseOffManifold {
    /// The suffix of `H`.
    pub(crate) number: String,
    /// `{g, H_k}`
    pub(crate) bracket: KnownSum,
}

/// The constraints of a system.
pub(super) fn constraints(system: &System) -> Vec<Constraint> {
    let numbers = system.constraint_numbers();
    let all = system.constraints.iter().zip(system.constraint_offsets()).zip(numbers);
    all.map(|((constraint, offset), number)| {
        let own = match &constraint.family {
            Some(family) => {
                let member = Index::atom(Atom::Loop(family.variable));
                promised(offset.add(&member), "numbers of constraints are integers")
            }
            None => offset,
        };
        let value = weighted(&constraint.term.values, &[own]);
        Constraint { extent: constraint.term.extent, number, value, mistake: None, noise: None }
    })
    .collect()
}

/// Finds mistakes, and noises that move the system off the manifold.
pub(super) fn examine(sums: &mut Calculus<'_>, of: &Hamiltonians, constraints: &mut [Constraint]) {
    for number in 0..constraints.len() {
        let (before, rest) = constraints.split_at_mut(number);
        let Some(constraint) = rest.first_mut() else { return };
        constraint.mistake = mistake(sums.graph, before, constraint, of.t);
        constraint.noise = noise_off_manifold(sums, of, constraint);
    }
}

fn mistake(
    graph: &mut Graph,
    before: &[Constraint],
    constraint: &Constraint,
    t: Symbol,
) -> Option<ConstraintMistake> {
    let elements: Vec<&Element> = constraint.value.iter().map(|weighted| &weighted.element).collect();
    if elements.iter().all(|element| element.coordinates().next().is_none()) {
        return Some(ConstraintMistake::NoCoordinates);
    }
    if elements.iter().all(|element| is_affine(graph, element, t)) {
        return Some(ConstraintMistake::Affine);
    }
    let [only] = elements.as_slice() else { return None };
    if has_no_zero(graph, only) {
        return Some(ConstraintMistake::NoPoint);
    }
    let multiple = before.iter().position(|known| match known.value.as_slice() {
        [other] => is_multiple(graph, only, &other.element),
        _ => false,
    });
    multiple.map(ConstraintMistake::Multiple)
}

/// Whether the slopes by all coordinates read neither coordinates nor the time: a plane that does not turn.
fn is_affine(graph: &mut Graph, element: &Element, t: Symbol) -> bool {
    let coordinates: Vec<Symbol> = element.coordinates().map(|(symbol, _)| symbol).collect();
    let moving = [coordinates.as_slice(), &[t]].concat();
    !graph.has_pieces(element.value, &coordinates)
        && coordinates.iter().all(|&q| {
            let slope = graph.derivative(element.value, q);
            !graph.depends_on(slope, &moving)
        })
}

/// Whether a function is positive everywhere, or negative everywhere.
fn has_no_zero(graph: &mut Graph, element: &Element) -> bool {
    let negative = graph.negate(element.value);
    graph.sign(element.value) == Sign::Positive || graph.sign(negative) == Sign::Positive
}

/// Whether the ratio of two functions does not depend on the coordinates: `g ∂f/∂q_i = f ∂g/∂q_i` for all.
fn is_multiple(graph: &mut Graph, one: &Element, other: &Element) -> bool {
    let coordinates = |element: &Element| element.coordinates().map(|(symbol, _)| symbol).collect::<Vec<_>>();
    let own = coordinates(one);
    own == coordinates(other)
        && own.iter().all(|&q| {
            let [slope, slope_of_other] = [one, other].map(|element| graph.derivative(element.value, q));
            let [first, second] =
                [graph.multiply(one.value, slope_of_other), graph.multiply(other.value, slope)];
            let difference = graph.subtract(first, second);
            matches!(graph.test_zero(difference), ZeroTest::Zero)
        })
}

/// The first noise Hamiltonian that reads momenta and whose bracket with the constraint is not proven to
/// vanish.
fn noise_off_manifold(
    sums: &mut Calculus<'_>,
    of: &Hamiltonians,
    constraint: &Constraint,
) -> Option<NoiseOffManifold> {
    for (number, noise) in of.numbers.iter().zip(&of.noise) {
        if noise.iter().all(|weighted| !weighted.element.reads().p) {
            continue;
        }
        let bracket = sums.bracket(&constraint.value, noise);
        let bracket = vanishes_on_manifold(sums, bracket, &of.constraints);
        if !bracket.known.is_proven() {
            return Some(NoiseOffManifold { number: number.clone(), bracket });
        }
    }
    None
}

/// Whether no constraint depends on the time: then the energy does not either.
pub(super) fn are_at_rest(sums: &mut Calculus<'_>, constraints: &[NumberedSum], t: Symbol) -> Knowledge {
    let rates = constraints.iter().map(|constraint| {
        let rate = sums.partial(&constraint.sum, t);
        sums.vanishes(Some(rate), Increments::Each).known
    });
    super::all(rates)
}

/// Whether a sum vanishes where all constraints do: it is a combination of these with constant coefficients,
/// as the bracket of a rotation with the constraints of a rigid body is. Only sums without loops are reduced
/// by constraints without loops.
pub(super) fn vanishes_on_manifold(
    sums: &mut Calculus<'_>,
    sum: Option<Sum>,
    constraints: &[NumberedSum],
) -> KnownSum {
    let known = sums.vanishes(sum, Increments::Each);
    let Some(whole) = known.sum.as_ref().filter(|_| !known.known.is_proven()).and_then(only_value) else {
        return known;
    };
    let basis: Vec<Expr> = constraints.iter().filter_map(|constraint| only_value(&constraint.sum)).collect();
    let Some(rest) = remainder(sums.graph, whole, &basis) else { return known };
    let element = sums.space.element_of(sums.graph, rest);
    let rest = vec![Weighted { element, increments: Vec::new() }];
    let of_rest = sums.vanishes(Some(rest), Increments::Each);
    if of_rest.known.is_proven() { KnownSum { sum: known.sum, known: Knowledge::Proven } } else { known }
}

/// The value of a sum of one element without loops.
fn only_value(sum: &Sum) -> Option<Expr> {
    match sum.as_slice() {
        [only] if only.element.loops.is_empty() => Some(only.element.value),
        _ => None,
    }
}

/// A linear form in terms, the constant among them.
type TermRow = BTreeMap<Expr, Rational>;

/// The remainder of an expression after elimination of constant multiples of others, term by term. `None`
/// where fractions leave the exact range.
fn remainder(graph: &mut Graph, whole: Expr, basis: &[Expr]) -> Option<Expr> {
    let mut rows: Vec<(Expr, TermRow)> = Vec::new();
    for &known in basis {
        let mut row = term_row(graph, known)?;
        for (pivot, other) in &rows {
            eliminate(&mut row, *pivot, other)?;
        }
        if let Some(pivot) = row.keys().next().copied() {
            rows.push((pivot, row));
        }
    }
    let mut rest = term_row(graph, whole)?;
    for (pivot, row) in &rows {
        eliminate(&mut rest, *pivot, row)?;
    }
    let terms: Vec<(Expr, Rational)> = rest.into_iter().collect();
    Some(graph.linear_combination(&terms))
}

/// The terms of an expression, with those of sums inside of sums.
fn term_row(graph: &mut Graph, expr: Expr) -> Option<TermRow> {
    let one = graph.integer(1);
    let mut row = TermRow::new();
    let mut open = vec![(expr, Rational::ONE)];
    while let Some((part, factor)) = open.pop() {
        match graph.node(part) {
            Node::Sum { terms, constant } => {
                for &(term, coefficient) in terms {
                    open.push((term, coefficient.multiply(factor)?));
                }
                add_to(&mut row, one, constant.multiply(factor)?)?;
            }
            _ => add_to(&mut row, part, factor)?,
        }
    }
    row.retain(|_, entry| !entry.is_zero());
    Some(row)
}

fn add_to(row: &mut TermRow, term: Expr, factor: Rational) -> Option<()> {
    let sum = row.entry(term).or_insert(Rational::ZERO);
    *sum = sum.add(factor)?;
    Some(())
}

/// Takes so much of `other` out of a row that its entry at the pivot vanishes.
fn eliminate(row: &mut TermRow, pivot: Expr, other: &TermRow) -> Option<()> {
    let (Some(own), Some(entry)) = (row.get(&pivot).copied(), other.get(&pivot)) else { return Some(()) };
    let factor = own.multiply(entry.recip()?)?.negate();
    for (&term, &entry) in other {
        add_to(row, term, entry.multiply(factor)?)?;
    }
    row.retain(|_, entry| !entry.is_zero());
    Some(())
}
