//! Ensembles: the same bits however they are split, and the moments that are known exactly.

#![cfg(feature = "ensemble")]
#![allow(clippy::unwrap_used, reason = "a test that unwraps says what it expects")]
#![allow(missing_docs, reason = "test systems")]

use std::sync::Mutex;

use wzvi::ensemble::{InstructionSet, Statistics};
use wzvi::error::{ConfigError, Error, StepFailure};
use wzvi::prelude::*;

#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
    embedding = [Midpoint],
)]
pub struct Kubo {
    pub a: f64,
    pub sigma: f64,
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * (q * q - 1.0).powi(2),
    noise = [|q, p| s * q * p],
    embedding = [Midpoint],
)]
pub struct DoubleWell {
    pub s: f64,
}

/// Two coupled degrees of freedom, functions, two noises: a Newton block of several unknowns.
#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u + v * v) - x.cos() - (y - x).cos() + (0.1 * x * v).exp(),
    noise = [|[x, y], [u, v]| s * (x * u).sin(), |[x, y], [u, v]| s * y * v],
    embedding = [Midpoint, Corrected<DeltaPlus>],
)]
pub struct Coupled {
    pub s: f64,
}

/// Undefined for negative `q`, where some paths go.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + q * q.sqrt(),
    noise = [|q, p| -s * q],
    embedding = [DeltaPlus],
)]
pub struct Edge {
    pub s: f64,
}

/// The same run in every way to split it.
macro_rules! every_split {
    ($run:expr) => {{
        let reference: Statistics =
            $run.threads(1).instructions(InstructionSet::Baseline).run_in::<1>().unwrap();
        for set in [InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Avx512] {
            for threads in [1, 2, 3] {
                assert!(
                    $run.threads(threads).instructions(set).run().unwrap() == reference,
                    "{set:?}, {threads} threads"
                );
            }
            assert!($run.instructions(set).run_in::<4>().unwrap() == reference, "{set:?}, 4 lanes");
        }
        reference
    }};
}

#[test]
fn every_split_gives_the_same_bits() {
    let kubo = Kubo { a: 1.5, sigma: 1.0 };
    let start = || State::new([0.0], [1.0]);
    let all = every_split!(
        kubo.ensemble::<Midpoint>(0.05).start(start()).paths(1101).seed(3).steps(37).record_every(10)
    );
    assert_eq!(all.nodes().len(), 5);
    assert!(all.nodes().iter().all(|node| node.count() == 1101));
    let well = DoubleWell { s: 0.3 };
    every_split!(
        well.ensemble::<Midpoint>(0.01).start(State::new([0.5], [0.5])).paths(555).seed(4).steps(50)
    );
    let coupled = Coupled { s: 0.4 };
    let start = || State::new([0.3, -0.2], [0.5, 0.1]);
    every_split!(coupled.ensemble::<Midpoint>(0.05).start(start()).paths(530).seed(5).steps(25));
    every_split!(coupled.ensemble::<Corrected<DeltaPlus>>(0.05).start(start()).paths(530).seed(5).steps(25));
}

/// Steps so long that some need the careful way, or have no solution: still the same bits.
#[test]
fn hard_steps_and_failures_are_the_same_in_every_split() {
    let well = DoubleWell { s: 1.5 };
    let hard = every_split!(
        well.ensemble::<Midpoint>(0.5)
            .start(State::new([0.5], [2.0]))
            .paths(600)
            .seed(4)
            .steps(60)
            .record_every(20)
    );
    assert!(hard.last().unwrap().count() + hard.failed() == 600);
    let edge = Edge { s: 1.0 };
    let run = every_split!(
        edge.ensemble::<DeltaPlus>(0.1)
            .start(State::new([1.0], [0.0]))
            .paths(700)
            .seed(1)
            .steps(30)
            .record_every(3)
            .observe(|state| state.q[0])
            .observe(|state| state.p[0])
    );
    assert!(run.failed() > 0 && run.failed() < 700, "{}", run.failed());
    assert_eq!(run.failures().len() as u64, run.failed());
    assert!(run.failures().windows(2).all(|pair| pair[0].path < pair[1].path));
    for failure in run.failures() {
        assert!(failure.path < 700 && failure.error.step < 30, "{failure:?}");
        assert_eq!(failure.error.cause, StepFailure::NonFinite);
        assert_eq!(failure.error.t, failure.error.step as f64 * 0.1);
    }
    assert_eq!(run.last().unwrap().count(), 700 - run.failed());
    let counts: Vec<u64> = run.nodes().iter().map(|node| node.count()).collect();
    assert!(counts.windows(2).all(|pair| pair[0] >= pair[1]), "{counts:?}");
}

/// The path of a lane is that of `Stepper` with the same increments. They are read off a random walk with the same seed:
/// for `H = 0`, `H_1 = -s q`, `p` is `s W`. Its sums round, a unit of 1e-16 per step, which 40 steps of this system at most
/// amplify by a few.
#[test]
fn a_lane_is_the_path_of_a_stepper() {
    let (h, steps, paths) = (0.01, 40_u64, 20_u64);
    let states = |steps: u64, well: &DoubleWell| -> Vec<[f64; 2]> {
        let seen = Mutex::new(Vec::new());
        well.ensemble::<Midpoint>(h)
            .start(State::new([0.5], [0.5]))
            .paths(paths)
            .seed(9)
            .steps(steps)
            .threads(1)
            .observe(|state| {
                seen.lock().unwrap().push([state.q[0], state.p[0]]);
                0.0
            })
            .run()
            .unwrap();
        let all = seen.into_inner().unwrap();
        // Start and end of each group of 16.
        let (first, second) = all.split_at(32);
        [&first[16..], &second[4..]].concat()
    };
    let walk = Walk { s: 1.0 };
    let increments: Vec<Vec<f64>> = {
        let seen = Mutex::new(vec![Vec::new(); 1]);
        walk.ensemble::<DeltaPlus>(h)
            .start(State::new([0.0], [0.0]))
            .paths(1)
            .seed(9)
            .steps(steps)
            .record_every(1)
            .truncation(wzvi::noise::Truncation::On(4.0))
            .observe(|state| {
                seen.lock().unwrap()[0].push(state.p[0]);
                0.0
            })
            .run()
            .unwrap();
        seen.into_inner().unwrap()
    };
    // W rounds; the increments come back to a few units of the largest |W|.
    let well = DoubleWell { s: 0.3 };
    let mut state = State::new([0.5], [0.5]);
    let mut stepper = well.stepper::<Midpoint>(h).unwrap().plain();
    for pair in increments[0].windows(2) {
        stepper.step(&mut state, &[pair[1] - pair[0]]).unwrap();
    }
    let [q, p] = states(steps, &well)[0];
    assert!((q - state.q[0]).abs() < 1e-13 && (p - state.p[0]).abs() < 1e-13, "{q} {p} {state:?}");
}

/// A random walk in `p`.
#[hamiltonian(drift = |q, p| 0.0 * q * p, noise = [|q, p| -s * q], embedding = [DeltaPlus])]
pub struct Walk {
    pub s: f64,
}

/// `E z(t) = e^{-σ²t/2} R(at) z(0)` and `|z| = 1`: five standard errors, exceeded once in two million. At this step the
/// weak error of the scheme, about `0.4 h`, is one of them.
#[test]
fn kubo_has_its_exact_moments() {
    let kubo = Kubo { a: 1.5, sigma: 1.0 };
    let run = kubo
        .ensemble::<Midpoint>(0.01)
        .start(State::new([0.0], [1.0]))
        .paths(20_000)
        .seed(1)
        .until(1.0)
        .observe(|state| state.q[0])
        .named("q")
        .observe(|state| state.p[0])
        .named("p")
        .observe(|state| state.q[0].powi(2) + state.p[0].powi(2))
        .run()
        .unwrap();
    let decay = (-0.5f64).exp();
    for (name, exact) in [("q", decay * 1.5f64.sin()), ("p", decay * 1.5f64.cos())] {
        let (mean, error) = (run.mean(name), run.standard_error(name));
        assert!((mean - exact).abs() < 5.0 * error, "{name}: {mean} ± {error}, exactly {exact}");
        // Var = (1 - e^{-2})/2 of the fast angle and so on: between 0 and 1.
        assert!(error > 1e-3 && error < 1e-2, "{error}");
    }
    assert_eq!(run.observables(), ["q", "p", "observable2"]);
    assert!((run.mean("observable2") - 1.0).abs() < 1e-12);
    let end = run.last().unwrap();
    assert_eq!((end.count(), end.time()), (20_000, 1.0));
    // q² + p² = 1 links the second moments.
    let second = end.variance(0) + end.mean(0).powi(2) + end.variance(1) + end.mean(1).powi(2);
    assert!((second - 1.0).abs() < 1e-3, "{second}");
    assert_eq!(end.covariance(0, 1), end.covariance(1, 0));
    assert!(run.mean("nothing").is_nan());
}

#[test]
fn what_makes_no_sense_is_refused() {
    let kubo = Kubo { a: 1.5, sigma: 1.0 };
    let base = || kubo.ensemble::<Midpoint>(0.01).start(State::new([0.0], [1.0])).paths(4).seed(1).steps(2);
    assert!(base().run().is_ok());
    let config = |outcome: Result<Statistics, Error>| matches!(outcome, Err(Error::Config(_)));
    assert!(
        config(base().paths(0).run()) && config(base().threads(0).run()) && config(base().until(-1.0).run())
    );
    assert!(config(base().truncation(wzvi::noise::Truncation::On(0.5)).run()));
    let without_seed =
        kubo.ensemble::<Midpoint>(0.01).start(State::new([0.0], [1.0])).paths(4).steps(2).run();
    assert!(matches!(without_seed, Err(Error::Config(ConfigError::Missing(_)))));
    let zero_step =
        kubo.ensemble::<Midpoint>(0.0).start(State::new([0.0], [1.0])).paths(4).seed(1).steps(2).run();
    assert_eq!(zero_step, Err(Error::Config(ConfigError::StepSize(0.0))));
    let edge = Edge { s: 0.0 };
    let all_fail =
        edge.ensemble::<DeltaPlus>(0.1).start(State::new([-1.0], [0.0])).paths(20).seed(1).steps(3).run();
    assert!(matches!(all_fail, Err(Error::Step(error)) if error.step == 0), "{all_fail:?}");
}
