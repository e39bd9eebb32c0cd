//! Systems at rest, nearly at rest, and at every scale: a step has a solution there, and rounding is not its absence.

mod scales;
mod stepper;

use std::f64::consts::{PI, TAU};

use fixtures::rounding::{Well, run, walk};
use wzvi::prelude::*;

/// A well at `scale`, whatever the unit of length.
#[hamiltonian(
    drift = |q, p| {
        let x = q / scale;
        0.5 * p * p + 0.25 * scale * scale * (x * x - 1.0) * (x * x - 1.0)
    },
    embedding = Midpoint,
)]
struct ScaledWell {
    scale: f64,
}

/// An atom on springs to its neighbours, its place far from the origin.
#[hamiltonian(drift = |q, p| 0.5 * p * p + 1.0 - (q - place).cos() + 0.1 * (q - place).powi(4), embedding = Midpoint)]
struct Far {
    place: f64,
}

#[hamiltonian(drift = |q, p| 0.5 * p * p + 1.0 - q.cos(), embedding = Midpoint)]
struct Pendulum;

#[hamiltonian(
    drift = |[theta, phi], [ptheta, pphi]| {
        let s = theta.sin();
        0.5 * (ptheta * ptheta + pphi * pphi / (s * s)) - theta.cos()
    },
    embedding = Midpoint,
)]
struct ConicalPendulum;

#[hamiltonian(
    drift = |[r, phi], [pr, pphi]| 0.5 * (pr * pr + pphi * pphi / (r * r)) - 1.0 / r,
    noise = [|[r, phi], [pr, pphi]| sigma * r],
    embedding = Midpoint,
)]
struct NoisyOrbit {
    sigma: f64,
}

#[hamiltonian(
    drift = |[r, phi], [pr, pphi]| 0.5 * (pr * pr + pphi * pphi / (r * r)) - 1.0 / r,
    embedding = Midpoint,
)]
struct PolarKepler;

#[hamiltonian(drift = |r, p| 0.5 * p * p + 4.0 * (r.powi(-12) - r.powi(-6)), embedding = Midpoint)]
struct LennardJones;

/// A part of what `tests/laws` runs.
#[test]
fn wells_at_rest_stay_there() {
    fixtures::rounding::wells_at_rest_stay_there(10_000);
}

#[test]
fn small_amplitudes_in_a_well() {
    let mut hard = 0;
    for (amplitude, count) in [(1e-10, 100), (1e-8, 50), (1e-6, 20)] {
        for i in 0..count {
            let a = 0.5 + 5.0 * f64::from(i) / f64::from(count);
            let start = State::new([a.sqrt() + amplitude], [0.0]);
            let seen = run(&Well { a }, start, 0.05, 20_000)
                .unwrap_or_else(|error| panic!("a = {a}, {amplitude:e}: {error}"));
            // From one side to the other: in p it is ω amplitude, ω² = 2a < 12.
            assert!(
                seen.moved <= 4.0 * amplitude + walk(2.0 * a.powf(1.5), 0.05, 20_000),
                "a = {a}: {seen:?}"
            );
            hard += seen.hard;
        }
    }
    println!("{hard} hard");
    // Few, where the increment crosses zero: 1 in 200.
    assert!(hard <= 170 * 100, "{hard}");
}

#[test]
fn every_amplitude_at_every_scale() {
    for scale in [1.0, 1e6, 1e-6, 1e100] {
        for exponent in [-300, -200, -100, -30, -20, -17, -16, -15, -14, -12, -10, -8, -6, -4, -3] {
            let amplitude = 10.0_f64.powi(exponent) * scale;
            let bound = 2.1 * amplitude + scale * walk(2.0, 0.1, 20_000);
            for start in [State::new([scale + amplitude], [0.0]), State::new([scale], [amplitude])] {
                let seen = run(&ScaledWell { scale }, start, 0.1, 20_000)
                    .unwrap_or_else(|error| panic!("{scale:e}, 1e{exponent}: {error}"));
                assert!(seen.moved <= bound, "{scale:e}, 1e{exponent}: {seen:?}");
            }
        }
    }
    for place in [1.0, 1e6, 1e-6, -3e12] {
        for exponent in [-300, -20, -16, -12, -10, -8, -5, -3] {
            let amplitude = 10.0_f64.powi(exponent);
            for start in [State::new([place + amplitude], [0.0]), State::new([place], [amplitude])] {
                let seen = run(&Far { place }, start, 0.1, 20_000)
                    .unwrap_or_else(|error| panic!("{place:e}, 1e{exponent}: {error}"));
                // The coordinate is on a grid of ε |place|.
                let bound = 2.1 * amplitude + walk(place.abs().max(1.0), 0.1, 20_000);
                assert!(seen.moved <= bound, "{place:e}, 1e{exponent}: {seen:?}");
            }
        }
    }
}

#[test]
fn pendula_at_rest_on_any_turn() {
    for turn in [0.0, 1.0, -1.0, 1000.0] {
        for h in [0.01, 0.1, 0.5] {
            let seen = run(&Pendulum, State::new([TAU * turn], [0.0]), h, 200_000).unwrap();
            assert!(seen.moved <= walk(TAU * turn.abs() + 1.0, h, 200_000), "{turn}, {h}: {seen:?}");
        }
        // Upside down it leaves, and has a solution on the way.
        run(&Pendulum, State::new([TAU * turn + PI], [0.0]), 0.1, 200_000).unwrap();
    }
}

#[test]
fn relative_equilibria() {
    for i in 1..15 {
        let theta = 0.1 * f64::from(i);
        // p_φ²  cos θ / sin³ θ = sin θ
        let spin = theta.sin().powi(2) / theta.cos().sqrt();
        let start = State::new([theta, 0.0], [0.0, spin]);
        let mut stepper = ConicalPendulum.stepper::<Midpoint>(0.05).unwrap();
        let mut state = start;
        for n in 0..200_000 {
            stepper.step(&mut state, &[]).unwrap_or_else(|error| panic!("θ = {theta}, step {n}: {error}"));
        }
        assert!((state.q[0] - theta).abs() <= 1e3 * walk(1.0, 0.05, 200_000), "{theta}: {state:?}");
    }
    for (r, h) in [(1.0_f64, 0.05), (1.0, 0.01), (0.37, 0.01), (25.0, 1.0)] {
        let mut state = State::new([r, 0.0], [0.0, r.sqrt()]);
        let mut stepper = PolarKepler.stepper::<Midpoint>(h).unwrap();
        for n in 0..200_000 {
            stepper.step(&mut state, &[]).unwrap_or_else(|error| panic!("r = {r}, step {n}: {error}"));
        }
        assert!((state.q[0] / r - 1.0).abs() <= 1e3 * walk(1.0, 0.05, 200_000), "{r}: {state:?}");
    }
}

#[test]
fn atoms_at_their_distance() {
    let r = 2.0_f64.powf(1.0 / 6.0);
    for h in [1e-4, 0.001, 0.01] {
        for offset in [0.0, 1e-15, 1e-12, 1e-9] {
            let seen = run(&LennardJones, State::new([r + offset], [0.0]), h, 200_000).unwrap();
            // The force has terms of 24, the frequency is 7.6.
            assert!(seen.moved <= 10.0 * offset + walk(50.0, h, 200_000), "{h}, {offset:e}: {seen:?}");
        }
    }
}

#[test]
fn cold_ensembles_lose_no_path() {
    for sigma in [0.0, 1e-16, 1e-12, 1e-6] {
        let orbits = NoisyOrbit { sigma };
        let statistics = orbits
            .ensemble::<Midpoint>(0.05)
            .start(State::new([1.0, 0.0], [0.0, 1.0]))
            .paths(64)
            .seed(7)
            .until(100.0)
            .threads(1)
            .observe("q", |state| state.q[0])
            .run()
            .unwrap();
        assert_eq!(statistics.failed(), 0, "sigma = {sigma:e}");
    }
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + e * (0.25 * (q / s).powi(4) - 0.5 * (q / s).powi(2)),
    embedding = Midpoint,
)]
struct Tiny {
    s: f64,
    e: f64,
}

/// The slope of the equation of this step has `1 / s⁴`, beyond all numbers: an error, not a step that does not move.
#[test]
fn a_slope_beyond_all_numbers_is_an_error() {
    let start = State::new([1.5e-100], [0.0]);
    let tiny = Tiny { s: 1e-100, e: 1e-200 };
    let mut state = start;
    let error = tiny.stepper::<Midpoint>(0.05).unwrap().step(&mut state, &[]).unwrap_err();
    assert_eq!((error.step, &state), (0, &start), "{error}");
}
