//! The energy of Hamiltonians in pieces: runs of those that are continuous are refused where their energy changes, runs of those that jump are not.

use std::f64::consts::PI;

use wzvi::error::StepFailure;
use wzvi::plan::EnergyWatch;
use wzvi::prelude::*;

/// A particle at the potential of Lennard and Jones, cut off at 2.5 and continuous for one value of `shift`.
#[hamiltonian(
    drift = |[x, y], [px, py]| {
        let r2 = x * x + y * y;
        0.5 * (px * px + py * py) + if r2 < 6.25 { 4.0 * (r2.powi(-6) - r2.powi(-3)) + shift } else { 0.0 }
    },
    embedding = [Verlet, Midpoint],
)]
struct CutOff {
    shift: f64,
}

/// The same between all pairs in a plane, at any number of atoms.
#[hamiltonian(
    drift = |q: &[[f64; 2]], p: &[[f64; 2]]| {
        let mut h = 0.0;
        for i in 0..q.len() {
            h += 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]);
            for j in 0..i {
                let r2 = (q[i][0] - q[j][0]).powi(2) + (q[i][1] - q[j][1]).powi(2);
                h += if r2 < 6.25 { 4.0 * (r2.powi(-6) - r2.powi(-3)) + shift } else { 0.0 };
            }
        }
        h
    },
    embedding = Verlet,
)]
struct Atoms {
    shift: f64,
}

/// Continuous, with an infinite force at 1.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + if q * q > 1.0 { (q * q - 1.0).sqrt() } else { 0.0 },
    embedding = [Verlet, Midpoint],
)]
struct Rooted;

/// In action and angle: no number where `j < 0`.
#[hamiltonian(drift = |theta, j| j + 0.5 * (2.0 * j).sqrt() * theta.cos(), embedding = Midpoint)]
struct Action;

/// Jumps by `2πc` in each turn.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y) + c * y.atan2(x),
    embedding = [Verlet, Midpoint],
)]
struct Turning {
    c: f64,
}

/// `q - atan(tan q)` is a staircase.
#[hamiltonian(drift = |q, p| 0.5 * p * p + q - q.tan().atan(), embedding = [Verlet, Midpoint])]
struct Staircase;

/// A step in a parabola.
#[hamiltonian(
    drift = |q, p| 0.5 * (p * p + q * q) + if q > 0.25 { left } else { right },
    embedding = [Verlet, Midpoint],
)]
struct Step {
    left: f64,
    right: f64,
}

/// The height of the step varies along its edge.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + 2.0 * y * y) + if x > 0.1 { a * y * y } else { 0.0 },
    embedding = [Verlet, Midpoint],
)]
struct Refracting {
    a: f64,
}

/// A round box.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + if x * x + y * y < 1.0 { 0.0 } else { 5.0 },
    embedding = [Verlet, Midpoint],
)]
struct Disc;

/// The shift with which a potential that is cut off at 2.5 is continuous.
fn continuous() -> f64 {
    -4.0 * (6.25_f64.powi(-6) - 6.25_f64.powi(-3))
}

/// Why a run ends, alone and as each of nine paths: the same.
macro_rules! outcome {
    ($system:expr, $scheme:ty, $h:expr, $start:expr, $steps:expr) => {{
        let (system, start) = ($system, $start);
        let alone = system.simulate::<$scheme>($h).start(start.clone()).steps($steps).run().map(|_| ());
        let many = system.ensemble::<$scheme>($h).start(start).steps($steps).paths(9).allow_losses(1.0).run();
        // A run of which no path is left ends like its first path.
        let failed = match many {
            Ok(many) => many.failed(),
            Err(wzvi::Error::Step(_)) => 9,
            Err(error) => panic!("{error}"),
        };
        assert_eq!(failed, if alone.is_err() { 9 } else { 0 }, "{alone:?}");
        match alone {
            Ok(()) => None,
            Err(wzvi::Error::Step(error)) => Some((error.cause, error.to_string())),
            Err(error) => panic!("{error}"),
        }
    }};
}

/// Refused, with both causes.
#[track_caller]
fn is_undecided(outcome: Option<(StepFailure, String)>) {
    let Some((StepFailure::Unresolved { may_jump: true, .. }, message)) = outcome else {
        panic!("{outcome:?}")
    };
    assert!(
        message.contains("too long for the motion, or H jumps") && message.contains("`.unwatched()`"),
        "{message}"
    );
}

const fn watch<E, H: Discretized<E>>(_: &H) -> EnergyWatch {
    H::PLAN.energy_watch()
}

/// Collisions in few steps: 18 becomes 5.04 for one particle, 36 becomes 4.4e6 for two.
#[test]
fn cut_off_potentials_are_monitored() {
    let system = CutOff { shift: continuous() };
    assert_eq!(watch::<Verlet, _>(&system), EnergyWatch::Undecided);
    let start = State::new([3.0, 0.1], [-6.0, 0.0]);
    is_undecided(outcome!(&system, Verlet, 0.05, start, 1200));
    // The same collision in steps that resolve it.
    assert_eq!(outcome!(&system, Verlet, 5e-4, start, 4000), None);
    let atoms = Atoms { shift: continuous() };
    assert_eq!(watch::<Verlet, _>(&atoms), EnergyWatch::Undecided);
    let start = State::new(vec![0.0, 0.0, 3.0, 0.1], vec![6.0, 0.0, -6.0, 0.0]);
    is_undecided(outcome!(&atoms, Verlet, 0.05, start.clone(), 1200));
    assert_eq!(outcome!(&atoms, Verlet, 5e-4, start, 2000), None);
    // Not shifted, the energy changes by a sixtieth at the edge, where the run begins anew.
    assert_eq!(
        outcome!(&CutOff { shift: 0.0 }, Verlet, 5e-4, State::new([3.0, 0.5], [-0.3, 0.0]), 40_000),
        None
    );
}

/// The step sends 0.125 to 1.1e13.
#[test]
fn an_infinite_force_at_a_curved_edge_is_monitored() {
    is_undecided(outcome!(&Rooted, Verlet, 0.1, State::new([0.0], [0.5]), 20_000));
}

/// The end has `j = -8e-5`, where 2.2e-4 is right.
#[test]
fn an_energy_that_is_no_number_is_refused() {
    let start = State::new([PI], [0.501_000_5]);
    let Some((StepFailure::UndefinedEnergy, message)) = outcome!(&Action, Midpoint, 0.1, start, 31) else {
        panic!("it leaves the domain")
    };
    assert!(message.contains("is not a number"), "{message}");
    let retried =
        Action.simulate::<Midpoint>(0.1).start(start).steps(31).retry(Retry::halving(6)).run().unwrap();
    // Halved until the end is in the domain, and no further.
    assert!((retried.last().p[0] - 2.2e-4).abs() < 2e-4, "{:?}", retried.last());
    let unwatched = Action.simulate::<Midpoint>(0.1).start(start).steps(31).unwatched().run().unwrap();
    assert!(unwatched.last().p[0] < 0.0);
}

/// At every step size that resolves the motion between two jumps.
#[test]
fn staircases_and_turns_are_not_refused() {
    let start = State::new([1.0, 0.0], [0.0, 1.0]);
    // Below, at and above the change that unseen jumps may make: 1/640 of `p · dq/dt`.
    for c in [1e-5, 1e-4, 1e-3, 0.05, 0.3] {
        let system = Turning { c };
        assert_eq!(watch::<Midpoint, _>(&system), EnergyWatch::Discontinuous);
        assert_eq!(outcome!(&system, Verlet, 0.1, start, 5000), None, "{c}");
        assert_eq!(outcome!(&system, Midpoint, 0.05, start, 5000), None, "{c}");
    }
    assert_eq!(watch::<Verlet, _>(&Staircase), EnergyWatch::Discontinuous);
    assert_eq!(outcome!(&Staircase, Verlet, 0.1, State::new([0.0], [1.0]), 5000), None);
    assert_eq!(outcome!(&Staircase, Midpoint, 0.7, State::new([0.0], [1.0]), 5000), None);
}

#[test]
fn steps_and_boxes_are_not_refused() {
    for (left, right) in [(0.0, 0.3), (0.2, 0.2), (5.0, 0.0), (0.0, -40.0)] {
        let system = Step { left, right };
        assert_eq!(watch::<Verlet, _>(&system), EnergyWatch::Undecided);
        assert_eq!(outcome!(&system, Verlet, 0.1, State::new([1.0], [0.0]), 2000), None, "{left} {right}");
        assert_eq!(outcome!(&system, Midpoint, 0.7, State::new([1.0], [0.0]), 2000), None, "{left} {right}");
        let composed = outcome!(&system, Composed<Verlet, Yoshida4>, 0.3, State::new([1.0], [0.0]), 2000);
        assert_eq!(composed, None, "{left} {right}");
    }
    let start = State::new([1.0, 0.5], [0.0, 0.3]);
    assert_eq!(watch::<Verlet, _>(&Refracting { a: 0.5 }), EnergyWatch::Discontinuous);
    assert_eq!(outcome!(&Refracting { a: 0.5 }, Verlet, 0.02, start, 10_000), None);
    assert_eq!(watch::<Verlet, _>(&Disc), EnergyWatch::Discontinuous);
    assert_eq!(outcome!(&Disc, Verlet, 0.02, State::new([0.0, 0.1], [1.0, 0.3]), 10_000), None);
}
