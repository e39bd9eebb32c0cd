//! Compensated sums of the state: what rounding does to first integrals over ten million steps.
#![allow(clippy::unwrap_used, reason = "a test may stop")]

use wzvi::prelude::*;

#[hamiltonian(
    drift = |[x, y], [px, py]| (px * px + py * py) / 2.0 - 1.0 / x.hypot(y),
    embedding = Midpoint,
    invariant = |[x, y], [px, py]| x * py - y * px,
)]
struct Kepler;

/// Eccentricity 0.5, semi-major axis 1, at perihelion.
fn start() -> State<<Kepler as Hamiltonian>::Vector> {
    State::new([0.5, 0.0], [0.0, 3.0_f64.sqrt()])
}

/// The largest relative error of the angular momentum, looked at every thousand steps.
fn drift(mut step: impl FnMut(&mut State<<Kepler as Hamiltonian>::Vector>), steps: u32) -> f64 {
    let mut state = start();
    let exact = Kepler.invariant(0, &state);
    let mut worst = 0.0_f64;
    for i in 1..=steps {
        step(&mut state);
        if i % 1000 == 0 {
            worst = worst.max((Kepler.invariant(0, &state) / exact - 1.0).abs());
        }
    }
    worst
}

/// With what rounding takes carried along, the rounding of the increments remains: h = 0.01 times smaller than that of
/// the state. 2e-14 is what the best fixed-step codes reach; a stopping test at 1e-14 would give 2.6e-11.
#[test]
fn angular_momentum_over_ten_million_steps() {
    let mut plain = Kepler.stepper::<Midpoint>(0.01).unwrap().plain();
    let mut compensated = Kepler.stepper::<Midpoint>(0.01).unwrap().compensated();
    assert!(!plain.is_compensated() && compensated.is_compensated());
    let steps = 10_000_000;
    let kept = drift(|state| assert!(compensated.step(state, &[]).is_ok()), steps);
    let lost = drift(|state| assert!(plain.step(state, &[]).is_ok()), steps);
    println!("angular momentum after {steps} steps: {kept:.1e} compensated, {lost:.1e} plain");
    assert!(kept <= 2e-14, "{kept:.1e}");
    assert!(kept < lost, "{kept:.1e} {lost:.1e}");
}

/// The carried part belongs to one state: another one starts without it, and gives what a fresh stepper gives.
#[test]
fn another_state_starts_without_what_was_carried() {
    let mut used = Kepler.stepper::<Midpoint>(0.01).unwrap().compensated();
    let mut state = start();
    for _ in 0..10 {
        used.step(&mut state, &[]).unwrap();
    }
    let (mut first, mut second) = (start(), start());
    let mut fresh = Kepler.stepper::<Midpoint>(0.01).unwrap().compensated();
    for _ in 0..10 {
        used.step(&mut first, &[]).unwrap();
        fresh.step(&mut second, &[]).unwrap();
        assert_eq!(first, second);
    }
}
