//! From Ito to Stratonovich, for `calculus = Ito`.
//!
//! ```text
//! dX = a dt + Σ_k X_k dW_k   is   dX = (a + c) dt + Σ_k X_k ∘ dW_k,   c = -1/2 Σ_k (X_k · ∇) X_k
//! X_k = (∂H_k/∂p, -∂H_k/∂q) of a noise, (0, f_k) of a noise force
//! ```
//!
//! (P. E. Kloeden, E. Platen, *Numerical Solution of Stochastic Differential Equations*, Springer 1992,
//! section 4.9.) If `c` is the vector field of a Hamiltonian `K`, that joins the drift. If it changes momenta
//! alone, it is a force. Otherwise it is neither, and the system is refused: in general `c` expands or
//! contracts phase space, at the rate `-1/2 Σ_k tr (∂X_k/∂X)²`.
//!
//! Candidates for `K` are compared with `c`, first noise by noise, then for what is left of their sum:
//!
//! | `K` | of |
//! |---|---|
//! | `∓D/2`, `D = ∂H_k/∂q · ∂H_k/∂p` | Hamiltonians where one of the two gradients is linear and the other constant along it |
//! | `-{m, H_k}/2 ∓ D_g/2` | `H_k = g + m` with a linear `m`: its field is constant, so that `(X_m · ∇) X_g` is the field of `{m, g}` |
//! | `Σ_n A_n/n`, `A = c_q · p - c_p · q` | polynomials: `A_n` are the terms of degree `n`, and `K = ∫_0^1 A(λ q, λ p)/λ dλ` |
//!
//! Tests: `tests/forces/ito.rs`.

use std::collections::HashMap;

use super::collect::parted;
use crate::diagnostics::{Diagnostics, ito as messages};
use crate::discretise::{Calculus, Increments, Space, Sum, Weighted, unweighted, weighted};
use crate::model::{Atom, Conversion, Element, Half, Index, Local, Slot, System, Term};
use crate::symbolic::{Expr, Graph, Node, Rational, Symbol};

const HALF: Rational = Rational::HALF;
const MINUS_HALF: Rational = Rational::HALF.negate();

/// `c` as `-2 c_q · δ` and `2 c_p · δ`.
#[derive(Clone, Default)]
struct VectorField {
    of_coordinates: Sum,
    of_momenta: Sum,
}

/// `c` in parts: a Hamiltonian with its vector field, and what is left.
#[derive(Default)]
struct ItoCorrection {
    hamiltonian: Sum,
    rest: VectorField,
    /// All of it.
    whole: VectorField,
}

/// Adds the correction to the drift and to the force.
pub(crate) fn ito(system: &mut System, diagnostics: &mut Diagnostics) {
    let Some(extent) = system.ito else { return };
    let mut space = Space::of(system);
    let noises: Vec<(Sum, bool)> = system
        .noise
        .iter()
        .map(|noise| {
            // Members of a family have numbers; different noises never meet.
            let number =
                noise.family.as_ref().map_or(Index::default(), |of| Index::atom(Atom::Loop(of.variable)));
            (weighted(&noise.term.elements, &[number]), noise.is_force)
        })
        .collect();
    let mut calculus = Calculus { space: &mut space, graph: &mut system.graph };
    let correction = noises.iter().try_fold(ItoCorrection::default(), |mut all, (noise, is_force)| {
        calculus.add_correction(&mut all, noise, *is_force)?;
        Some(all)
    });
    let Some(mut correction) = correction else {
        diagnostics.report(messages::beyond_indices(extent));
        return;
    };
    calculus.gather(&mut correction);
    let ItoCorrection { hamiltonian, rest: VectorField { of_coordinates, of_momenta }, whole } = correction;
    if !calculus.is_zero(&of_coordinates) {
        let VectorField { of_coordinates, of_momenta } = whole;
        let [of_q, of_p] = [(&of_coordinates, MINUS_HALF), (&of_momenta, HALF)]
            .map(|(sum, factor)| space.display(&mut system.graph, sum, factor));
        let rate = expansion(&mut system.graph, &of_coordinates, &of_momenta);
        diagnostics.report(messages::no_force(extent, &of_q, &of_p, &rate));
        return;
    }
    if !hamiltonian.is_empty() && !system.summands.is_empty() {
        let shown = space.display(&mut system.graph, &hamiltonian, Rational::ONE);
        diagnostics.report(messages::parted_drift(extent, &shown));
        return;
    }
    let mut calculus = Calculus { space: &mut space, graph: &mut system.graph };
    let force =
        if calculus.is_zero(&of_momenta) { Sum::new() } else { calculus.combine(&[(&of_momenta, HALF)]) };
    let shown =
        |graph: &mut Graph, sum: &Sum| (!sum.is_empty()).then(|| space.display(graph, sum, Rational::ONE));
    let (drift_text, force_text) = (shown(&mut system.graph, &hamiltonian), shown(&mut system.graph, &force));
    let reads_momenta = force.iter().any(|part| part.element.reads().p);
    system.conversion = Some(Conversion { drift: drift_text, force: force_text, reads_momenta });
    let (values, elements) = elements(system, hamiltonian);
    system.drift.values.extend(values);
    system.drift.elements.extend(elements);
    if !force.is_empty() {
        let (values, elements) = self::elements(system, force);
        let zero = system.graph.integer(0);
        let term = system.force.get_or_insert_with(|| Term {
            expression: zero,
            elements: Vec::new(),
            values: Vec::new(),
            extent,
        });
        term.values.extend(values);
        term.elements.extend(elements);
    }
}

impl Calculus<'_> {
    fn is_zero(&mut self, sum: &Sum) -> bool {
        sum.is_empty() || self.vanishes(Some(sum.clone()), Increments::Diagonal).known.is_proven()
    }

    /// Whether `one = factor other`.
    fn agree(&mut self, one: &Sum, other: &Sum, factor: Rational) -> bool {
        let difference = self.combine(&[(one, Rational::ONE), (other, factor.negate())]);
        self.is_zero(&difference)
    }

    /// Whether a field is that of the Hamiltonian `K`, `(∂K/∂p, -∂K/∂q)`.
    fn is_field_of(&mut self, field: &VectorField, k: &Sum) -> bool {
        let [by_p, by_q] = [Half::Momenta, Half::Coordinates].map(|half| self.displaced(k, half));
        let minus_two = Rational::integer(-2);
        self.agree(&field.of_coordinates, &by_p, minus_two) && self.agree(&field.of_momenta, &by_q, minus_two)
    }

    /// Adds a field to another.
    fn add_field(&mut self, to: &mut VectorField, field: &VectorField) {
        let VectorField { of_coordinates, of_momenta } = field;
        to.of_coordinates =
            self.combine(&[(&to.of_coordinates, Rational::ONE), (of_coordinates, Rational::ONE)]);
        to.of_momenta = self.combine(&[(&to.of_momenta, Rational::ONE), (of_momenta, Rational::ONE)]);
    }

    /// Looks for a Hamiltonian of what is left, or for a force in the whole, where noises have neither one by
    /// one.
    fn gather(&mut self, correction: &mut ItoCorrection) {
        if self.is_zero(&correction.rest.of_coordinates) {
            return;
        }
        if self.is_zero(&correction.whole.of_coordinates) {
            (correction.rest, correction.hamiltonian) = (correction.whole.clone(), Sum::new());
            return;
        }
        if let Some(k) = self.polynomial_of(&correction.rest)
            && self.is_field_of(&correction.rest, &k)
        {
            correction.hamiltonian =
                self.combine(&[(&correction.hamiltonian, Rational::ONE), (&k, Rational::ONE)]);
            correction.rest = VectorField::default();
        }
    }

    /// `K = Σ_n A_n/n` of `A = c_q · p - c_p · q`, if all is a polynomial of the state.
    fn polynomial_of(&mut self, field: &VectorField) -> Option<Sum> {
        let mut along = Sum::new();
        for (sum, half) in [(&field.of_coordinates, Half::Momenta), (&field.of_momenta, Half::Coordinates)] {
            for Weighted { element, increments } in sum {
                let mut images = HashMap::new();
                let places: Vec<(Symbol, Index)> =
                    element.displacements().map(|(symbol, place)| (symbol, place.clone())).collect();
                for (displacement, place) in places {
                    let symbol = self.space.symbol(self.graph, &Slot::State(half, place));
                    images.insert(displacement, self.graph.symbol(symbol));
                }
                let value = self.graph.substitute(&[element.value], &images)[0];
                let element = self.space.element(self.graph, element.loops.clone(), value);
                along.push(Weighted { element, increments: increments.clone() });
            }
        }
        for Weighted { element, .. } in &mut along {
            let state = state_of(element);
            let terms = by_degree(self.graph, element.value, &state)?;
            let weighted = (1..).zip(terms.get(1..).unwrap_or_default());
            let weighted: Vec<(Expr, Rational)> = weighted
                .map(|(degree, term)| Some((*term, Rational::new(1, degree)?)))
                .collect::<Option<_>>()?;
            element.value = self.graph.linear_combination(&weighted);
        }
        Some(self.combine(&[(&along, MINUS_HALF)]))
    }

    /// The terms of a sum that are linear in the state.
    fn linear_part(&mut self, sum: &Sum) -> Sum {
        let mut linear = sum.clone();
        for Weighted { element, .. } in &mut linear {
            let state = state_of(element);
            element.value = linear_terms(self.graph, element.value, &state);
        }
        self.combine(&[(&linear, Rational::ONE)])
    }

    /// `∂F/∂q · ∂G/∂p` of the same noise, without its weight.
    fn product(&mut self, f: &Sum, g: &Sum) -> Option<Sum> {
        let product = self.contract((f, Half::Coordinates), (g, Half::Momenta), Increments::Diagonal)?;
        Some(self.unweighted(&product))
    }

    /// Without increments: corrections of different noises may cancel.
    fn unweighted(&mut self, sum: &Sum) -> Sum {
        let elements: Vec<Element> = sum.iter().map(|weighted| weighted.element.clone()).collect();
        self.combine(&[(&unweighted(&elements), Rational::ONE)])
    }

    /// Hamiltonians that may have the correction of one noise as their field.
    fn candidates(&mut self, noise: &Sum) -> Option<Vec<Sum>> {
        let defect = self.product(noise, noise)?;
        let mut candidates = vec![self.combine(&[(&defect, MINUS_HALF)]), self.combine(&[(&defect, HALF)])];
        let linear = self.linear_part(noise);
        if !linear.is_empty() {
            let others = self.combine(&[(noise, Rational::ONE), (&linear, Rational::MINUS_ONE)]);
            // {m, H} = m_p · H_q - m_q · H_p
            let [one, other] = [self.product(noise, &linear)?, self.product(&linear, noise)?];
            let of_others = self.product(&others, &others)?;
            for factor in [Rational::ZERO, MINUS_HALF, HALF] {
                candidates.push(self.combine(&[(&one, MINUS_HALF), (&other, HALF), (&of_others, factor)]));
            }
        }
        Some(candidates)
    }

    /// Adds `-1/2 (X · ∇) X` of one noise, or one family; `None` if an index is beyond this arithmetic.
    fn add_correction(&mut self, all: &mut ItoCorrection, noise: &Sum, is_force: bool) -> Option<()> {
        let (q, p) = (Half::Coordinates, Half::Momenta);
        if is_force {
            // c · δq = -1/2 (f · ∂/∂p) f · δq
            let own = self.contract((noise, Half::Displacements), (noise, p), Increments::Diagonal)?;
            let own = self.unweighted(&own);
            let field = VectorField {
                of_coordinates: Sum::new(),
                of_momenta: self.combine(&[(&own, Rational::MINUS_ONE)]),
            };
            self.add_field(&mut all.rest, &field);
            self.add_field(&mut all.whole, &field);
            return Some(());
        }
        // `(X · ∇) ∂H/∂p · δ` and `(X · ∇) ∂H/∂q · δ`: -2 c · δ of coordinates, 2 c · δ of momenta.
        let [of_p, of_q] = [p, q].map(|half| self.displaced(noise, half));
        let field =
            VectorField { of_coordinates: self.along(noise, &of_p)?, of_momenta: self.along(noise, &of_q)? };
        if self.is_zero(&field.of_coordinates) && self.is_zero(&field.of_momenta) {
            return Some(());
        }
        self.add_field(&mut all.whole, &field);
        for k in self.candidates(noise)? {
            if self.is_field_of(&field, &k) {
                all.hamiltonian = self.combine(&[(&all.hamiltonian, Rational::ONE), (&k, Rational::ONE)]);
                return Some(());
            }
        }
        self.add_field(&mut all.rest, &field);
        Some(())
    }

    /// `(H_p · ∂/∂q - H_q · ∂/∂p) S`, both of the same noise, without its weight.
    fn along(&mut self, noise: &Sum, of: &Sum) -> Option<Sum> {
        let (q, p) = (Half::Coordinates, Half::Momenta);
        let one = self.contract((noise, p), (of, q), Increments::Diagonal);
        let other = self.contract((noise, q), (of, p), Increments::Diagonal);
        let along = self.difference(one, other)?;
        Some(self.unweighted(&along))
    }
}

/// The terms of each degree in some symbols, from 0 on; `None` if the expression is not a polynomial of them.
fn by_degree(graph: &mut Graph, expr: Expr, state: &[Symbol]) -> Option<Vec<Expr>> {
    if !graph.depends_on(expr, state) {
        return Some(vec![expr]);
    }
    let zero = graph.integer(0);
    match graph.node(expr).clone() {
        Node::Symbol(_) => Some(vec![zero, expr]),
        Node::Sum { terms, constant } => {
            let mut degrees: Vec<Vec<(Expr, Rational)>> = vec![vec![(graph.number(constant), Rational::ONE)]];
            for (term, factor) in terms {
                for (degree, part) in by_degree(graph, term, state)?.into_iter().enumerate() {
                    degrees.resize_with(degrees.len().max(degree + 1), Vec::new);
                    degrees[degree].push((part, factor));
                }
            }
            Some(degrees.iter().map(|terms| graph.linear_combination(terms)).collect())
        }
        Node::Product(factors) => {
            let one = graph.integer(1);
            let mut product = vec![one];
            for (base, exponent) in factors {
                if !graph.depends_on(base, state) {
                    let constant = graph.power(base, exponent);
                    product.iter_mut().for_each(|part| *part = graph.multiply(*part, constant));
                    continue;
                }
                let is_natural = exponent.is_integer() && !exponent.is_negative();
                let times = usize::try_from(exponent.numerator()).ok().filter(|_| is_natural)?;
                if times > MOST_DEGREES {
                    return None;
                }
                let of_base = by_degree(graph, base, state)?;
                for _ in 0..times {
                    if product.len() + of_base.len() > MOST_DEGREES {
                        return None;
                    }
                    let mut terms: Vec<Vec<(Expr, Rational)>> =
                        vec![Vec::new(); product.len() + of_base.len() - 1];
                    for (i, one) in product.iter().enumerate() {
                        for (j, other) in of_base.iter().enumerate() {
                            terms[i + j].push((graph.multiply(*one, *other), Rational::ONE));
                        }
                    }
                    product = terms.iter().map(|terms| graph.linear_combination(terms)).collect();
                }
            }
            Some(product)
        }
        _ => None,
    }
}

/// The terms of a sum that are linear in some symbols, where they can be told.
fn linear_terms(graph: &mut Graph, expr: Expr, state: &[Symbol]) -> Expr {
    let zero = graph.integer(0);
    match graph.node(expr).clone() {
        Node::Sum { terms, .. } => {
            let linear = |(term, factor): (Expr, Rational)| (linear_terms(graph, term, state), factor);
            let linear: Vec<(Expr, Rational)> = terms.into_iter().map(linear).collect();
            graph.linear_combination(&linear)
        }
        Node::Product(factors) => {
            let reads: Vec<bool> = factors.iter().map(|(base, _)| graph.depends_on(*base, state)).collect();
            let mut reading =
                factors.iter().zip(&reads).filter(|(_, reads)| **reads).map(|(factor, _)| *factor);
            let (Some((base, exponent)), None) = (reading.next(), reading.next()) else { return zero };
            if !exponent.is_one() {
                return zero;
            }
            let linear = linear_terms(graph, base, state);
            let constants =
                factors.iter().zip(&reads).filter(|(_, reads)| !**reads).map(|(factor, _)| *factor);
            let constants: Vec<(Expr, Rational)> = constants.collect();
            constants.into_iter().fold(linear, |product, (base, exponent)| {
                let power = graph.power(base, exponent);
                graph.multiply(product, power)
            })
        }
        Node::Symbol(symbol) if state.contains(&symbol) => expr,
        _ => zero,
    }
}

/// The highest degree of a polynomial that is looked for: more than the Hamiltonians of noises have.
const MOST_DEGREES: usize = 32;

/// `∇ · c` as text, of elements without loops; empty for others and for zero.
fn expansion(graph: &mut Graph, of_coordinates: &Sum, of_momenta: &Sum) -> String {
    let mut terms = Vec::new();
    for (sum, half, factor) in
        [(of_coordinates, Half::Coordinates, MINUS_HALF), (of_momenta, Half::Momenta, HALF)]
    {
        for part in sum {
            if !part.element.loops.is_empty() {
                return String::new();
            }
            let displaced: Vec<(Symbol, Index)> =
                part.element.displacements().map(|(symbol, place)| (symbol, place.clone())).collect();
            for (displacement, place) in displaced {
                let along = part.element.of_half(half).find(|(_, known)| **known == place);
                let Some((symbol, _)) = along else { continue };
                let component = graph.derivative(part.element.value, displacement);
                terms.push((graph.derivative(component, symbol), factor));
            }
        }
    }
    let rate = graph.linear_combination(&terms);
    if graph.is_zero(rate) { String::new() } else { graph.display(rate) }
}

/// The symbols of coordinates and momenta that an element reads.
fn state_of(element: &Element) -> Vec<Symbol> {
    let halves = element.of_half(Half::Coordinates).chain(element.of_half(Half::Momenta));
    halves.map(|(symbol, _)| symbol).collect()
}

/// The elements of a sum with the variables of the system: for values, and parted for derivatives.
fn elements(system: &mut System, sum: Sum) -> (Vec<Element>, Vec<Element>) {
    let mut values = Vec::new();
    for part in sum {
        let System { graph, symbols, tables, .. } = system;
        let mut images = HashMap::new();
        for Local { symbol, slot } in &part.element.locals {
            let known = symbols.local(graph, slot.clone(), tables);
            if known != *symbol {
                images.insert(*symbol, graph.symbol(known));
            }
        }
        let value = graph.substitute(&[part.element.value], &images)[0];
        let locals = symbols.locals_among(graph.symbols_in(value).into_iter());
        values.push(Element { loops: part.element.loops, value, locals });
    }
    let elements = parted(system, &values);
    (values, elements)
}
