//! From Ito to Stratonovich, for `calculus = Ito`.
//!
//! ```text
//! dX = a dt + Σ_k X_k dW_k   is   dX = (a + c) dt + Σ_k X_k ∘ dW_k,   c = -1/2 Σ_k (X_k · ∇) X_k
//! X_k = (∂H_k/∂p, -∂H_k/∂q) of a noise, (0, f_k) of a noise force
//! ```
//!
//! (P. E. Kloeden, E. Platen, *Numerical Solution of Stochastic Differential Equations*, Springer 1992, section 4.9.) With the half of
//! the defect `D_k = ∂H_k/∂q · ∂H_k/∂p`, `c` is the vector field of the Hamiltonian `-D_k/2` or `D_k/2` in the cases that have one:
//! it then joins the drift. If it changes momenta alone, it is a force. Otherwise it is neither, and the system is refused: in general
//! `c` expands or contracts phase space, at the rate `-1/2 Σ_k tr (∂X_k/∂X)²`.

use super::collect::parted;
use crate::diagnostics::{Diagnostics, ito as messages};
use crate::discretise::{Calculus, Increments, Space, Sum, weighted};
use crate::model::{Atom, Conversion, Element, Half, Index, Local, System, Term};
use crate::symbolic::{Graph, Rational, Symbol};

const HALF: Rational = Rational::HALF;
const MINUS_HALF: Rational = Rational::HALF.negate();

/// `c` in parts: of its vector field `∂K/∂p`, `-∂K/∂q` the Hamiltonian; of what is left, `-2 c · δ` and `2 c · δ` for
/// coordinates and momenta.
#[derive(Default)]
struct Correction {
    hamiltonian: Sum,
    of_coordinates: Sum,
    of_momenta: Sum,
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
    let correction = noises.iter().try_fold(Correction::default(), |mut all, (noise, is_force)| {
        calculus.add_correction(&mut all, noise, *is_force)?;
        Some(all)
    });
    let Some(Correction { hamiltonian, of_coordinates, of_momenta }) = correction else {
        diagnostics.report(messages::beyond_indices(extent));
        return;
    };
    if !calculus.is_zero(&of_coordinates) {
        let [of_q, of_p] = [(&of_coordinates, MINUS_HALF), (&of_momenta, HALF)]
            .map(|(sum, factor)| space.display(&mut system.graph, sum, factor));
        let rate = expansion(&mut system.graph, &of_coordinates, &of_momenta);
        diagnostics.report(messages::no_force(extent, &of_q, &of_p, &rate));
        return;
    }
    if !hamiltonian.is_empty() && !system.parts.is_empty() {
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

    /// Whether `one = sign other`.
    fn agree(&mut self, one: &Sum, other: &Sum, sign: Rational) -> bool {
        let difference = self.combine(&[(one, Rational::ONE), (other, sign.negate())]);
        self.is_zero(&difference)
    }

    /// Adds `-1/2 (X · ∇) X` of one noise, or one family; `None` if an index is beyond this arithmetic.
    fn add_correction(&mut self, all: &mut Correction, noise: &Sum, is_force: bool) -> Option<()> {
        let (q, p) = (Half::Coordinates, Half::Momenta);
        if is_force {
            // c · δq = -1/2 (f · ∂/∂p) f · δq
            let own = self.contract((noise, Half::Displacements), (noise, p), Increments::Diagonal)?;
            all.of_momenta = self.combine(&[(&all.of_momenta, Rational::ONE), (&own, Rational::MINUS_ONE)]);
            return Some(());
        }
        // `(X · ∇) ∂H/∂p · δ` and `(X · ∇) ∂H/∂q · δ`: -2 c · δ of coordinates, 2 c · δ of momenta.
        let [of_p, of_q] = [p, q].map(|half| self.displaced(noise, half));
        let of_coordinates = self.along(noise, &of_p)?;
        let of_momenta = self.along(noise, &of_q)?;
        if self.is_zero(&of_coordinates) && self.is_zero(&of_momenta) {
            return Some(());
        }
        let defect = self.contract((noise, q), (noise, p), Increments::Diagonal)?;
        let [by_p, by_q] = [p, q].map(|half| self.displaced(&defect, half));
        // K = ∓D/2 has the field (∓1/2 ∂D/∂p, ±1/2 ∂D/∂q).
        for sign in [Rational::ONE, Rational::MINUS_ONE] {
            if self.agree(&of_coordinates, &by_p, sign) && self.agree(&of_momenta, &by_q, sign) {
                let factor = if sign.is_negative() { HALF } else { MINUS_HALF };
                all.hamiltonian = self.combine(&[(&all.hamiltonian, Rational::ONE), (&defect, factor)]);
                return Some(());
            }
        }
        all.of_coordinates =
            self.combine(&[(&all.of_coordinates, Rational::ONE), (&of_coordinates, Rational::ONE)]);
        all.of_momenta = self.combine(&[(&all.of_momenta, Rational::ONE), (&of_momenta, Rational::ONE)]);
        Some(())
    }

    /// `(H_p · ∂/∂q - H_q · ∂/∂p) S`, both of the same noise.
    fn along(&mut self, noise: &Sum, of: &Sum) -> Option<Sum> {
        let (q, p) = (Half::Coordinates, Half::Momenta);
        let one = self.contract((noise, p), (of, q), Increments::Diagonal);
        let other = self.contract((noise, q), (of, p), Increments::Diagonal);
        self.difference(one, other)
    }
}

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

/// The elements of a sum with the variables of the system: for values, and parted for derivatives.
fn elements(system: &mut System, sum: Sum) -> (Vec<Element>, Vec<Element>) {
    let mut values = Vec::new();
    for part in sum {
        let System { graph, symbols, tables, .. } = system;
        let mut images = std::collections::HashMap::new();
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
