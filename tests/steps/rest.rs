//! Systems at rest, nearly at rest, and at every scale: a step has a solution there, and rounding is not its absence.

mod scales;
mod stepper;

use fixtures::rest;
use wzvi::prelude::*;

/// Parts of what `tests/laws` runs.
#[test]
fn wells_at_rest_stay_there() {
    rest::wells_at_rest_stay_there(2000);
}

#[test]
fn small_amplitudes_in_a_well() {
    rest::small_amplitudes_in_a_well(2000);
}

#[test]
fn every_amplitude_at_every_scale() {
    rest::every_amplitude_at_every_scale(2000);
}

#[test]
fn pendula_at_rest_on_any_turn() {
    rest::pendula_at_rest_on_any_turn(20_000);
}

#[test]
fn relative_equilibria() {
    rest::relative_equilibria(20_000);
}

#[test]
fn atoms_at_their_distance() {
    rest::atoms_at_their_distance(20_000);
}

#[test]
fn cold_ensembles_lose_no_path() {
    rest::cold_ensembles_lose_no_path(16);
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + e * (0.25 * (q / s).powi(4) - 0.5 * (q / s).powi(2)),
    embedding = Midpoint,
)]
struct Tiny {
    s: f64,
    e: f64,
}

/// The slope of the equation of this step has `1 / s⁴`, beyond all numbers. Its fixed point needs no slope, and is that of the system in units of `s`.
#[test]
fn a_slope_beyond_all_numbers_is_not_needed() {
    let end = |s: f64, e: f64| {
        let mut state = State::new([1.5 * s], [0.0]);
        Tiny { s, e }.stepper::<Midpoint>(0.05).unwrap().step(&mut state, &[]).unwrap();
        [state.q[0] / s, state.p[0] / s]
    };
    let [[q, p], [of_tiny_q, of_tiny_p]] = [end(1.0, 1.0), end(1e-100, 1e-200)];
    // A few roundings of the powers of `s`.
    assert!(
        (q - of_tiny_q).abs() < 1e-14 && (p - of_tiny_p).abs() < 1e-14 * p.abs().max(1.0),
        "{of_tiny_q} {of_tiny_p}"
    );
}
