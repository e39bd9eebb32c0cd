//! First integrals: the rates of a function along the drift, the noises and the forces.

use super::forces::{self, Forces};
use super::{Form, Hamiltonians, boundaries_of, kept_across};
use crate::diagnostics::Extent;
use crate::discretise::{Calculus, Increments, Judged, Sum};
use crate::symbolic::{Knowledge, Rational};

/// A declared first integral with its rate of change.
pub(crate) struct Invariant {
    pub(crate) extent: Extent,
    /// Empty if it has none.
    pub(crate) name: String,
    pub(crate) value: Sum,
    /// The first rate that is not proven zero.
    pub(crate) failure: Option<Failure>,
    pub(crate) form: Form,
}

/// A term that prevents a function from being a first integral.
pub(crate) struct Failure {
    /// The flow along which it changes, with the formula of the rate; or the place
    /// where it jumps.
    pub(crate) along: String,
    /// Of the rate; a jump has none.
    pub(crate) found: Judged,
}

/// What is known of each rate of a function, or jump of it, until one is not proven to vanish.
struct Rates<'r, 'c> {
    sums: &'r mut Calculus<'c>,
    failure: Option<Failure>,
}

impl Rates<'_, '_> {
    fn check(&mut self, along: String, rate: impl FnOnce(&mut Calculus<'_>) -> Option<Sum>) {
        if self.failure.is_none() {
            let rate = rate(self.sums);
            let found = self.sums.vanishes(rate, Increments::Each);
            self.failure = Some(Failure { along, found }).filter(|failure| !failure.found.known.is_proven());
        }
    }

    fn state(&mut self, along: String, known: Knowledge) {
        if self.failure.is_none() && !known.is_proven() {
            self.failure = Some(Failure { along, found: Judged { sum: None, known } });
        }
    }
}

pub(super) fn invariant(
    sums: &mut Calculus<'_>,
    hamiltonians: &Hamiltonians,
    (extent, name, value): (Extent, String, Sum),
) -> Invariant {
    let Hamiltonians { noise, numbers, forces, t, .. } = hamiltonians;
    let mut rates = Rates { sums, failure: None };
    rates.check(along_drift(forces), |sums| rate_of_drift(sums, hamiltonians, &value));
    let named = |number: &str| number.trim_start_matches('_').to_owned();
    for (number, hamiltonian) in numbers.iter().zip(noise) {
        let along = format!("noise {}: {{H{number}, F}}", named(number));
        rates.check(along, |sums| sums.bracket(hamiltonian, &value));
    }
    for (number, force) in forces.numbers.iter().zip(&forces.noise) {
        let along = format!("noise force {}: F{number} · ∂F/∂p", named(number));
        rates.check(along, |sums| forces::along(sums, force, &value));
    }
    if forces.is_warm && value.iter().any(|weighted| weighted.element.reads().p) {
        let reason = "a bath with a temperature acts on every momentum with friction".to_owned();
        rates.state("the bath".to_owned(), Knowledge::Unknown(reason));
    }
    // Its derivatives are those of the pieces.
    for boundary in boundaries_of(rates.sums.graph, &value, *t) {
        rates.state(format!("motions across {}", boundary.place), kept_across("it", &boundary));
    }
    // Steps take friction as a flow of its own, and explicit time at the nodes of a quadrature: what depends on both parts is not kept exactly.
    let reads_time = value.iter().any(|weighted| rates.sums.graph.depends_on(weighted.element.value, &[*t]));
    let damping = forces::along(rates.sums, &forces.friction, &value);
    let is_exact = !reads_time && rates.sums.vanishes(damping, Increments::Each).known.is_proven();
    let form = if is_exact { Form::of(rates.sums.graph, &value) } else { Form::NONE };
    let failure = rates.failure;
    Invariant { extent, name, form, value, failure }
}

/// The formula of the rate along the drift with its forces.
fn along_drift(forces: &Forces) -> String {
    let force = if forces.force.is_empty() { "" } else { " + F0 · ∂F/∂p" };
    let friction = if forces.friction.is_empty() { "" } else { " less that of the friction" };
    format!("the drift: {{H0, F}} + ∂F/∂t{force}{friction}")
}

fn rate_of_drift(sums: &mut Calculus<'_>, of: &Hamiltonians, value: &Sum) -> Option<Sum> {
    let Hamiltonians { drift, forces: Forces { force, friction, .. }, t, .. } = of;
    let rates = [
        (sums.bracket(drift, value)?, Rational::ONE),
        (sums.partial(value, *t), Rational::ONE),
        (forces::along(sums, force, value)?, Rational::ONE),
        (forces::along(sums, friction, value)?, Rational::MINUS_ONE),
    ];
    Some(sums.combine(&rates.each_ref().map(|(rate, factor)| (rate, *factor))))
}
