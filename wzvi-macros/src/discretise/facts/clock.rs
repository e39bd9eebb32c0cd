//! Rates of clocks along the drift with what acts beside it, and along noises. Tests:
//! `passes/clock/tests.rs`.

use super::{Hamiltonians, forces, invariants};
use crate::discretise::{Calculus, Increments, KnownSum, Sum};
use crate::model::System;

/// The flow of the drift with its forces and friction.
pub(crate) struct DriftFlow(Hamiltonians);

impl DriftFlow {
    pub(crate) fn of(system: &System) -> Self {
        Self(Hamiltonians::of(system, |term| &term.values))
    }

    /// The rate of a function; `None` if its indices exceed their arithmetic.
    pub(crate) fn rate(&self, sums: &mut Calculus<'_>, of: &Sum) -> Option<Sum> {
        invariants::rate_of_drift(sums, &self.0, of)
    }
}

/// Facts about the clock.
#[derive(Default)]
pub(crate) struct ClockFacts {
    /// The first noise that is not proven to leave the clock as it is.
    pub(crate) noise: Option<NoiseOfClock>,
}

/// A noise along which the clock changes, or may change.
pub(crate) struct NoiseOfClock {
    /// The formula of its rate.
    pub(crate) along: String,
    pub(crate) rate: KnownSum,
}

/// The facts on a clock, if there is one.
pub(super) fn clock_facts(sums: &mut Calculus<'_>, of: &Hamiltonians, clock: Option<Sum>) -> ClockFacts {
    let Some(clock) = clock else { return ClockFacts::default() };
    let Hamiltonians { noise, numbers, forces, .. } = of;
    let mut found = None;
    for (number, hamiltonian) in numbers.iter().zip(noise) {
        let rate = sums.bracket(hamiltonian, &clock);
        found = found.or_else(|| changes(sums, format!("{{H{number}, Q}}"), rate));
    }
    for (number, force) in forces.numbers.iter().zip(&forces.noise) {
        let rate = forces::along(sums, force, &clock);
        found = found.or_else(|| changes(sums, format!("F{number} · ∂Q/∂p"), rate));
    }
    ClockFacts { noise: found }
}

fn changes(sums: &mut Calculus<'_>, along: String, rate: Option<Sum>) -> Option<NoiseOfClock> {
    let rate = sums.vanishes(rate, Increments::Each);
    (!rate.known.is_proven()).then_some(NoiseOfClock { along, rate })
}
