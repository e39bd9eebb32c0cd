//! The clock of a sum over pairs, for a kinetic energy that is a sum of squares,
//!
//! ```text
//! H = Σ p_i²/(2 m_i) + Σ_(i,j) U_ij(r_ij),   Q = (Σ_(i,j) ω_ij²)^(-1/2)
//! ω² = (1/m_i + 1/m_j) √(U''² + U'²/r²),     in one dimension (1/m_i + 1/m_j) |U''|
//! ```
//!
//! For gravity, `U = -g m_i m_j/r`, a term is `√5 g (m_i + m_j)/r³`. Its rate is as cheap as a force.
//!
//! `1/m_i + 1/m_j` follows from the elements of the kinetic energy, wherever their loops place them:
//! `∂T/∂p_s = p_s/m_s` is contracted with displacements of both points, and momenta then become 1.

use std::collections::HashMap;

use super::{Derived, factored, of_value, root, total};
use crate::diagnostics::facts as messages;
use crate::discretise::{Calculus, Increments, Kinetic, Space, Sum, Weighted, unweighted};
use crate::model::{Element, Half, Index, Local, Slot, System, Term};
use crate::symbolic::{Expr, Function, Graph, Node, Rational, Symbol, SymbolKind, ZeroTest};

/// Derives the clock.
pub(super) fn derive(system: &mut System, term: &Term) -> syn::Result<Derived> {
    let extent = term.extent;
    if !matches!(Kinetic::of(system), Some(Kinetic { is_diagonal: true })) {
        return Err(messages::pairs_without_masses(extent));
    }
    let (kinetic, potential): (Vec<Element>, Vec<Element>) =
        system.drift.elements.iter().cloned().partition(|element| element.reads().p);
    let components = system.components;
    let mut space = Space::of(system);
    let sums = &mut Calculus { space: &mut space, graph: &mut system.graph };
    let kinetic = unweighted(&kinetic);
    let mut all: Vec<Sum> = Vec::new();
    for element in &potential {
        let no_pair = |sums: &mut Calculus<'_>, value: Expr| {
            let term = sums.space.element(sums.graph, element.loops.clone(), value);
            let term = sums.space.display(sums.graph, &unweighted(&[term]), Rational::ONE);
            messages::no_pair(extent, &term)
        };
        if element.is_collective() {
            return Err(no_pair(sums, element.value));
        }
        for bond in bonds(sums.graph, element, components).map_err(|term| no_pair(sums, term))? {
            let square = bond.square_of_frequency(sums.graph).ok_or_else(|| no_pair(sums, bond.value))?;
            let Some(sum) = bond.with_masses(sums, element, &kinetic, square) else {
                return Err(messages::masses_of_components(extent));
            };
            all.push(sum);
        }
    }
    let all: Vec<(&Sum, Rational)> = all.iter().map(|sum| (sum, Rational::ONE)).collect();
    let squares: Vec<Element> = sums.combine(&all).into_iter().map(|weighted| weighted.element).collect();
    if squares.is_empty() {
        return Err(messages::no_pairs(extent));
    }
    let sum = match squares.iter().all(|element| element.loops.is_empty()) {
        true => {
            let terms: Vec<Expr> = squares.iter().map(|element| element.value).collect();
            system.graph.sum(&terms)
        }
        false => total(system, &squares),
    };
    let q = root(&mut system.graph, sum, Rational::HALF.negate());
    of_value(system, extent, q)
}

/// The terms of an element that read one pair of points.
struct Bond {
    value: Expr,
    /// The coordinates of both points, by component: those that are read.
    components: Vec<[(Symbol, Index); 2]>,
}

/// Two points, and the terms that read both.
type PairTerms = ([Index; 2], Vec<(Expr, Rational)>);

/// The pairs of points in an element; the term that reads no two points is an error. Constants are left out.
fn bonds(graph: &mut Graph, element: &Element, components: i128) -> Result<Vec<Bond>, Expr> {
    let mut pairs: Vec<PairTerms> = Vec::new();
    let mut pending = vec![(element.value, Rational::ONE)];
    let mut terms = Vec::new();
    while let Some((value, factor)) = pending.pop() {
        match graph.node(value) {
            Node::Sum { terms: inner, .. } => {
                for &(term, coefficient) in inner {
                    let product = coefficient.multiply(factor).ok_or(value)?;
                    pending.push((term, product));
                }
            }
            _ => terms.push((value, factor)),
        }
    }
    // In the order of their writing.
    terms.reverse();
    for (term, factor) in terms {
        let whole = graph.scale(term, factor);
        let mut points: Vec<Index> = Vec::new();
        for (symbol, index) in element.coordinates() {
            if graph.depends_on(term, &[symbol]) {
                let (point, _) = index.divided(components).ok_or(whole)?;
                if !points.contains(&point) {
                    points.push(point);
                }
            }
        }
        let pair: [Index; 2] = match points.len() {
            0 => continue,
            2 => {
                points.sort();
                points.try_into().map_err(|_| whole)?
            }
            _ => return Err(whole),
        };
        match pairs.iter_mut().find(|(known, _)| *known == pair) {
            Some((_, terms)) => terms.push((term, factor)),
            None => pairs.push((pair, vec![(term, factor)])),
        }
    }
    let mut bonds = Vec::new();
    for (pair, terms) in pairs {
        let value = graph.linear_combination(&terms);
        let of_component = |component: i128| {
            let at = |point: &Index| {
                let index = point.multiply(&Index::integer(components))?.shifted(component)?;
                element.coordinates().find(|(_, known)| **known == index).map(|(symbol, _)| (symbol, index))
            };
            Some([at(&pair[0])?, at(&pair[1])?])
        };
        let components: Vec<[(Symbol, Index); 2]> = (0..components).filter_map(of_component).collect();
        bonds.push(Bond { value, components });
    }
    Ok(bonds)
}

impl Bond {
    /// `√(U''² + U'²/r²)`, in one dimension `|U''|`, if the value is a function `U` of the distance; in one
    /// dimension of the difference, which has a sign.
    fn square_of_frequency(&self, graph: &mut Graph) -> Option<Expr> {
        let both = [false, true].map(|is_swapped| self.of_difference(graph, is_swapped));
        // As it is written, if it is written in one of them.
        let (found, _) = both.into_iter().flatten().max_by_key(|(_, is_literal)| *is_literal)?;
        Some(found)
    }

    /// The value as a function of the place of the second point less that of the first, or of the opposite,
    /// and whether it is written so: squares of both are written in different ways, and arguments of
    /// functions are compared as they are written.
    fn of_difference(&self, graph: &mut Graph, is_swapped: bool) -> Option<(Expr, bool)> {
        let two = Rational::integer(2);
        let is_line = self.components.len() == 1;
        // The difference, or the square of the distance.
        let symbol = match is_line {
            true => graph.new_symbol(SymbolKind::Auxiliary, "d"),
            false => graph.new_positive_symbol(SymbolKind::Auxiliary, "s"),
        };
        let (variable, zero) = (graph.symbol(symbol), graph.integer(0));
        let r = if is_line { variable } else { graph.power(variable, Rational::HALF) };
        // One point at the origin, the other on the first axis.
        let (mut places, mut differences) = (HashMap::new(), Vec::new());
        for [(first, _), (second, _)] in &self.components {
            let [from, to] = if is_swapped { [*second, *first] } else { [*first, *second] };
            places.insert(from, zero);
            places.insert(to, if differences.is_empty() { r } else { zero });
            let [from, to] = [from, to].map(|symbol| graph.symbol(symbol));
            differences.push(graph.subtract(to, from));
        }
        let of_variable = graph.substitute(&[self.value], &places)[0];
        let written = match (is_line, differences.as_slice()) {
            (true, &[difference]) => difference,
            _ => {
                let squares: Vec<Expr> = differences.iter().map(|&d| graph.power(d, two)).collect();
                graph.sum(&squares)
            }
        };
        let by = HashMap::from([(symbol, written)]);
        let same = graph.substitute(&[of_variable], &by)[0];
        let difference = graph.subtract(self.value, same);
        if graph.test_zero(difference) != ZeroTest::Zero {
            return None;
        }
        let first = graph.derivative(of_variable, symbol);
        let second = graph.derivative(first, symbol);
        let square = if is_line {
            graph.apply(Function::Abs, &[second])
        } else {
            // `U'/r = 2 dU/ds` and `U'' = U'/r + 4 s d²U/ds²` with `s = r²`.
            let across = graph.scale(first, two);
            let rest = graph.multiply(variable, second);
            let second = graph.linear_combination(&[(across, Rational::ONE), (rest, Rational::integer(4))]);
            let [second, across] = [second, across].map(|x| graph.power(x, two));
            let sum = graph.add(second, across);
            root(graph, sum, Rational::HALF)
        };
        let is_literal = graph.is_zero(difference);
        Some((graph.substitute(&[square], &by)[0], is_literal))
    }

    /// `square (1/m_i + 1/m_j)` in the loops of an element. `None` if masses of a point differ by component.
    fn with_masses(
        &self,
        sums: &mut Calculus<'_>,
        element: &Element,
        kinetic: &Sum,
        square: Expr,
    ) -> Option<Sum> {
        let mut found: Option<Sum> = None;
        for pair in &self.components {
            let displaced: Vec<Expr> = pair
                .iter()
                .map(|(_, index)| {
                    let slot = Slot::State(Half::Displacements, index.clone());
                    let symbol = sums.space.symbol(sums.graph, &slot);
                    sums.graph.symbol(symbol)
                })
                .collect();
            let both = sums.graph.sum(&displaced);
            let value = sums.graph.multiply(square, both);
            let weighted = unweighted(&[sums.space.element(sums.graph, element.loops.clone(), value)]);
            let (momenta, displacements) = (Half::Momenta, Half::Displacements);
            let mut sum = sums.contract((kinetic, momenta), (&weighted, displacements), Increments::Each)?;
            for Weighted { element, .. } in &mut sum {
                let one = sums.graph.integer(1);
                let by = element.momenta().map(|(momentum, _)| (momentum, one)).collect();
                let value = sums.graph.substitute(&[element.value], &by)[0];
                let value = factored(sums.graph, value);
                *element = sums.space.element(sums.graph, element.loops.clone(), value);
            }
            match &found {
                None => found = Some(sum),
                Some(known) if is_same(known, &sum) => {}
                Some(_) => return None,
            }
        }
        found
    }
}

/// Whether two sums have the same terms in the same loops.
fn is_same(one: &Sum, other: &Sum) -> bool {
    let slots =
        |element: &Element| element.locals.iter().map(|Local { slot, .. }| slot.clone()).collect::<Vec<_>>();
    one.len() == other.len()
        && one.iter().zip(other).all(|(a, b)| {
            a.element.loops == b.element.loops
                && a.element.value == b.element.value
                && slots(&a.element) == slots(&b.element)
        })
}
