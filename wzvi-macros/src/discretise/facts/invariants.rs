//! First integrals: the rates of a function along the drift, the noises and the forces. Tests:
//! `lower/tests/identities.rs`, `tests/steps/invariants.rs`.

use super::constraints::vanishes_on_manifold;
use super::forces::{self, Forces};
use super::form::is_quadratic;
use super::{Hamiltonians, NumberedSum, PreservedForm, boundaries_in, kept_across};
use std::collections::HashMap;

use crate::diagnostics::Extent;
use crate::discretise::{Calculus, Increments, KnownSum, Sum, Weighted};
use crate::model::Element;
use crate::symbolic::{Expr, Knowledge, Node, Rational};

/// A declared first integral with its rate of change.
pub(crate) struct Invariant {
    pub(crate) extent: Extent,
    /// Empty if it has none.
    pub(crate) name: String,
    pub(crate) value: Sum,
    /// The first rate that is not proven zero.
    pub(crate) failure: Option<Failure>,
    pub(crate) form: PreservedForm,
}

/// A term that prevents a function from being a first integral.
pub(crate) struct Failure {
    /// The flow along which it changes, with the formula of the rate; or the place
    /// where it jumps.
    pub(crate) along: String,
    /// The rate and what is known of it. A jump has no rate.
    pub(crate) found: KnownSum,
}

/// Checks the rates and the jumps of a function, up to the first that is not proven to vanish.
struct Rates<'r, 'c> {
    sums: &'r mut Calculus<'c>,
    constraints: &'r [NumberedSum],
    failure: Option<Failure>,
}

impl Rates<'_, '_> {
    fn check(&mut self, along: String, rate: impl FnOnce(&mut Calculus<'_>) -> Option<Sum>) {
        if self.failure.is_none() {
            let rate = rate(self.sums);
            let found = vanishes_on_manifold(self.sums, rate, self.constraints);
            self.failure = Some(Failure { along, found }).filter(|failure| !failure.found.known.is_proven());
        }
    }

    fn state(&mut self, along: String, known: Knowledge) {
        if self.failure.is_none() && !known.is_proven() {
            self.failure = Some(Failure { along, found: KnownSum { sum: None, known } });
        }
    }
}

pub(super) fn invariant(
    sums: &mut Calculus<'_>,
    hamiltonians: &Hamiltonians,
    extent: Extent,
    name: String,
    value: Sum,
) -> Invariant {
    let Hamiltonians { noise, numbers, forces, constraints, t, .. } = hamiltonians;
    let mut rates = Rates { sums: &mut *sums, constraints, failure: None };
    rates.check(along_drift(forces), |sums| rate_of_drift(sums, hamiltonians, &value));
    let named = |number: &str| number.trim_start_matches('_').to_owned();
    for (number, hamiltonian) in numbers.iter().zip(noise) {
        let along = format!("noise {}: {{H{number}, F}}", named(number));
        rates.check(along, |sums| sums.bracket(hamiltonian, &value));
    }
    for NumberedSum { number, sum: constraint } in constraints {
        let along = format!("constraint {}: {{g{number}, F}}", named(number));
        rates.check(along, |sums| sums.bracket(constraint, &value));
    }
    for (number, force) in forces.numbers.iter().zip(&forces.noise) {
        let along = format!("noise force {}: F{number} · ∂F/∂p", named(number));
        rates.check(along, |sums| forces::along(sums, force, &value));
    }
    if forces.is_warm && value.iter().any(|weighted| weighted.element.reads().p) {
        let reason = "a bath with a temperature acts on every momentum with friction".to_owned();
        rates.state("the bath".to_owned(), Knowledge::Unknown(reason));
    }
    // The derivatives are the derivatives of the pieces. No motion crosses a surface on which another first
    // integral is constant.
    for Weighted { element, .. } in &value {
        for boundary in boundaries_in(rates.sums.graph, element, *t) {
            let known = kept_across("it", &boundary);
            if !known.is_proven() && !stays(rates.sums, hamiltonians, element, boundary.surface) {
                rates.state(format!("motions across {}", boundary.place), known);
            }
        }
    }
    let failure = rates.failure;
    let form = form_of(sums, hamiltonians, &value);
    Invariant { extent, name, form, value, failure }
}

/// The form of a first integral, or of the first integrals of which it is a function: `(x p_y - y p_x)²` is
/// kept where `x p_y - y p_x` is.
pub(super) fn form_of(sums: &mut Calculus<'_>, of: &Hamiltonians, value: &Sum) -> PreservedForm {
    if !is_exact(sums, of, value) {
        return PreservedForm::NONE;
    }
    let form = PreservedForm::of(sums.graph, value);
    if form.is_known() || value.iter().any(|weighted| !weighted.element.loops.is_empty()) {
        return form;
    }
    let terms: Vec<Expr> = value.iter().map(|weighted| weighted.element.value).collect();
    let whole = sums.graph.sum(&terms);
    form_of_part(sums, of, whole, &mut HashMap::new())
}

/// Steps take friction as a flow of its own, and explicit time at the nodes of a quadrature: what depends on
/// both parts is not kept exactly.
fn is_exact(sums: &mut Calculus<'_>, of: &Hamiltonians, value: &Sum) -> bool {
    let reads_time = value.iter().any(|weighted| weighted.element.reads_time(sums.graph, of.t));
    let damping = forces::along(sums, &of.forces.friction, value);
    !reads_time && sums.vanishes(damping, Increments::Each).known.is_proven()
}

/// The form of a part of a first integral: its own, if it is a polynomial of degree two and a first integral,
/// else the common form of its operands.
fn form_of_part(
    sums: &mut Calculus<'_>,
    of: &Hamiltonians,
    part: Expr,
    known: &mut HashMap<Expr, PreservedForm>,
) -> PreservedForm {
    if let Some(&form) = known.get(&part) {
        return form;
    }
    let element = sums.space.element_of(sums.graph, part);
    let form = if element.moving().is_empty() && !sums.graph.depends_on(part, &[of.t]) {
        PreservedForm::CONSTANT
    } else {
        let value = vec![Weighted { element, increments: Vec::new() }];
        let form = PreservedForm::of(sums.graph, &value);
        if form.is_known() {
            let is_kept = is_exact(sums, of, &value) && is_constant(sums, of, &value);
            if is_kept { form } else { PreservedForm::NONE }
        } else {
            form_of_operands(sums, of, part, known)
        }
    };
    known.insert(part, form);
    form
}

fn form_of_operands(
    sums: &mut Calculus<'_>,
    of: &Hamiltonians,
    part: Expr,
    known: &mut HashMap<Expr, PreservedForm>,
) -> PreservedForm {
    let operands = match sums.graph.node(part).clone() {
        Node::Sum { terms, .. } => {
            // Terms of degree two are one first integral together.
            let (low, mut rest): (Vec<_>, Vec<_>) = terms.iter().copied().partition(|&(term, _)| {
                let element = sums.space.element_of(sums.graph, term);
                is_quadratic(sums.graph, &element)
            });
            if !low.is_empty() {
                rest.insert(0, (sums.graph.linear_combination(&low), Rational::ONE));
            }
            rest.into_iter().map(|(term, _)| term).collect()
        }
        node => node.operands(),
    };
    let mut form = PreservedForm::CONSTANT;
    for operand in operands {
        // A polynomial of degree two has been tried as a whole.
        form = if operand == part {
            PreservedForm::NONE
        } else {
            form.and(form_of_part(sums, of, operand, known))
        };
        if !form.is_known() {
            return PreservedForm::NONE;
        }
    }
    if sums.graph.as_symbol(part).is_some() { PreservedForm::NONE } else { form }
}

/// Whether a function of the variables of an element without loops is constant along the motion.
fn stays(sums: &mut Calculus<'_>, of: &Hamiltonians, element: &Element, function: Expr) -> bool {
    if !element.loops.is_empty() {
        return false;
    }
    let element = sums.space.element_of(sums.graph, function);
    is_constant(sums, of, &vec![Weighted { element, increments: Vec::new() }])
}

/// Whether all rates of a function vanish.
fn is_constant(sums: &mut Calculus<'_>, of: &Hamiltonians, value: &Sum) -> bool {
    let Hamiltonians { noise, forces, constraints, .. } = of;
    let rate = rate_of_drift(sums, of, value);
    let vanishes =
        |sums: &mut Calculus<'_>, rate| vanishes_on_manifold(sums, rate, constraints).known.is_proven();
    if forces.is_warm || !vanishes(sums, rate) {
        return false;
    }
    for hamiltonian in noise.iter().chain(constraints.iter().map(|constraint| &constraint.sum)) {
        let rate = sums.bracket(hamiltonian, value);
        if !vanishes(sums, rate) {
            return false;
        }
    }
    forces.noise.iter().all(|force| {
        let rate = forces::along(sums, force, value);
        vanishes(sums, rate)
    })
}

/// The formula of the rate along the drift with its forces.
fn along_drift(forces: &Forces) -> String {
    let force = if forces.force.is_empty() { "" } else { " + F0 · ∂F/∂p" };
    let friction = if forces.friction.is_empty() { "" } else { " less that of the friction" };
    format!("the drift: {{H0, F}} + ∂F/∂t{force}{friction}")
}

pub(super) fn rate_of_drift(sums: &mut Calculus<'_>, of: &Hamiltonians, value: &Sum) -> Option<Sum> {
    let Hamiltonians { drift, forces: Forces { force, friction, .. }, t, .. } = of;
    let rates = [
        (sums.bracket(drift, value)?, Rational::ONE),
        (sums.partial(value, *t), Rational::ONE),
        (forces::along(sums, force, value)?, Rational::ONE),
        (forces::along(sums, friction, value)?, Rational::MINUS_ONE),
    ];
    Some(sums.combine(&rates.each_ref().map(|(rate, factor)| (rate, *factor))))
}
