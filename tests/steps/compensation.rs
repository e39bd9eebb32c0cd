//! Compensated sums of the state: what rounding does to first integrals in long runs.

use fixtures::rounding::{compensated_sums_keep_the_angular_momentum, perihelion};
use fixtures::small::Kepler;
use wzvi::prelude::*;

/// A part of what `tests/laws` runs.
#[test]
fn angular_momentum_over_a_hundred_thousand_steps() {
    compensated_sums_keep_the_angular_momentum(100_000);
}

/// The carried part belongs to one state: another one starts without it, and gives what a fresh stepper gives.
#[test]
fn another_state_starts_without_what_was_carried() {
    let mut used = Kepler.stepper::<Midpoint>(0.01).unwrap().compensated();
    let mut state = perihelion(0.5);
    for _ in 0..10 {
        used.step(&mut state, &[]).unwrap();
    }
    let (mut first, mut second) = (perihelion(0.5), perihelion(0.5));
    let mut fresh = Kepler.stepper::<Midpoint>(0.01).unwrap().compensated();
    for _ in 0..10 {
        used.step(&mut first, &[]).unwrap();
        fresh.step(&mut second, &[]).unwrap();
        assert_eq!(first, second);
    }
}
