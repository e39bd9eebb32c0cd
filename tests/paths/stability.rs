//! Steps that are hard, have no solution, or do not resolve the motion: what the run says, and what helps.

use fixtures::small::Cubic;
use fixtures::stiff::{SpringPendulum, hanging, length_error, spring_errors, subdivision_cures};
use wzvi::__private::PlainSum;
use wzvi::error::{StepError, StepFailure};
use wzvi::prelude::*;
use wzvi::system::{Scheme, SchemeOf, StepArguments};

/// [`Cubic`], kicked.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p - q * q * q / 3.0,
    noise = [|q, p| 0.1 * q],
    embedding = Midpoint,
)]
struct KickedCubic;

/// A free mass and a hard elastic wall at zero: a kink in the force.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + if q < 0.0 { 0.5 * stiffness * q * q } else { 0.0 },
    embedding = Midpoint,
)]
struct Wall {
    stiffness: f64,
}

/// Masses that fly freely, the first one to a wall so hard that `Verlet` does not resolve it.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..1).map(|i| if q[i] > 0.0 { 0.5 * stiffness * q[i] * q[i] } else { 0.0 }).sum::<f64>()
    },
    embedding = Verlet,
)]
struct Flight {
    stiffness: f64,
}

/// The step of the wall changes the energy for good. A system of any size is refused from 80 steps behind it on: 64 of them, and where the tests of these
/// begin.
#[test]
fn an_energy_that_changes_shortly_before_the_end_is_found() {
    let flight = Flight { stiffness: 100.0 };
    for n in [3, 200] {
        for behind in [80, 100, 120, 150, 190] {
            let mut p = vec![0.0; n];
            p[0] = 1.0;
            let mut q = vec![0.0; n];
            // The wall after 500 steps of 0.19.
            q[0] = -0.19 * 500.0 + 0.04;
            let run = flight.simulate::<Verlet>(0.19).start(State::new(q, p)).steps(500 + behind);
            let Err(wzvi::Error::Step(error)) = run.run() else {
                panic!("{n} masses, {behind} steps after the wall: nothing found");
            };
            assert!(matches!(error.cause, StepFailure::Unresolved { .. }), "{error}");
        }
    }
}

/// The envelope of the alternating mode, `4 / (ω h²)`, is at least 1.26 up to k = 1e9, above the angular velocity 0.96:
/// the run is bounded, with `(h v)² / 8 = 1.2e-5` in the length. At k = 1e9 the energy of the nodes is off by a ninth of the mean of `p · dq/dt`,
/// which a watched run refuses.
#[test]
fn a_stiff_spring_is_bounded_while_its_envelope_is_fast() {
    for exponent in [2, 6, 9] {
        let k = 10.0_f64.powi(exponent);
        for radial in [0.0, 0.1] {
            let (length, energy, _) = spring_errors(k, radial, Retry::never(), false).unwrap();
            // The stretch by gravity and rotation, 3 cos 0 - 2 cos 1 = 1.92 at most, the oscillation, and the scheme's own.
            let bound = 2.0 * 1.92 / k + 1.5 * radial / k.sqrt() + 1.2e-4;
            assert!(length <= bound, "k = 1e{exponent}, {radial}: {length:.1e} > {bound:.1e}");
            assert!(energy <= 0.2, "k = 1e{exponent}, {radial}: {energy:.1e}");
        }
    }
}

/// Beyond, a hand-written mid-point converges in three iterations to a length of 11.
#[test]
fn a_stiff_spring_that_is_not_resolved_is_refused() {
    for exponent in [10, 12, 14, 16] {
        for radial in [0.0, 0.1] {
            let outcome = spring_errors(10.0_f64.powi(exponent), radial, Retry::never(), true);
            let Err(wzvi::Error::Step(StepError { cause, t, .. })) = outcome else {
                panic!("k = 1e{exponent}, {radial}: {outcome:?}");
            };
            match cause {
                StepFailure::Unresolved { energy_error, scale, .. } => assert!(energy_error > 0.1 * scale),
                // The alternating part may also take a step to where its branch ends.
                StepFailure::NoSolution { .. } => {}
                _ => panic!("k = 1e{exponent}, {radial}: {cause}"),
            }
            assert!(t < 60.0);
        }
    }
}

#[test]
fn subdivision_cures_it_in_the_same_call() {
    // Springs that take eight halvings are in `tests/laws`.
    subdivision_cures(1e10, 4);
}

/// A divided step is hard, or doubtful, where one of its parts is. Parts of a quarter of this step are long for the spring: `ω h = 2.5e5`.
#[test]
fn parts_count_as_their_step() {
    let spring = SpringPendulum { stiffness: 1e16 };
    let run = spring.simulate::<Midpoint>(0.01).start(hanging(0.0)).until(2.0).record_every(0);
    let path = run.retry(Retry::halving(4)).run().unwrap();
    let counts = path.iterations();
    assert_eq!((counts.halved, counts.halvings), (path.steps(), 2));
    assert!(counts.hard > path.steps() / 2 && counts.doubtful > path.steps() / 2, "{counts:?}");
}

#[test]
fn whoever_does_not_want_the_watch_switches_it_off() {
    let spring = SpringPendulum { stiffness: 1e10 };
    let run = || spring.simulate::<Midpoint>(0.01).start(hanging(0.1)).until(20.0).record_every(0);
    assert!(run().run().is_err());
    // Up to where a step has no solution any more, if that comes first.
    let (path, _) = run().unwatched().run_partial().unwrap();
    // This is what it protects from.
    assert!(length_error(path.last()) > 1e-3);
    assert!(path.iterations().hard > 100);
}

/// `M = q + h p / 2 + h² M² / 4` for the mid-point of a step: its two solutions meet where `h² (q + h p / 2) = 1`.
/// The one with the minus sign is connected with the state.
#[test]
fn the_solution_of_a_step_is_the_connected_one_or_none() {
    let (mut solved, mut refused) = (0, 0);
    for i in 0..30 {
        for j in 0..30 {
            let (q, p, h) = (0.2 * f64::from(i) - 3.0, 0.4 * f64::from(j) - 6.0, 0.9);
            let mut state = State::new([q], [p]);
            let outcome = Cubic.stepper::<Midpoint>(h).unwrap().step(&mut state, &[]);
            let discriminant = |part: f64| 1.0 - (part * h).powi(2) * (q + 0.5 * part * h * p);
            // The first zero along the step, if there is one.
            let fold = (1..=10_000).map(|n| f64::from(n) * 1e-4).find(|&part| discriminant(part) < 0.0);
            match (outcome, fold) {
                (Ok(_), None) => {
                    let root = discriminant(1.0).sqrt();
                    let middle = 2.0 * (q + 0.5 * h * p) / (1.0 + root);
                    let error = (0.5 * (q + state.q[0]) - middle).abs();
                    // Rounding, magnified where the two solutions nearly meet.
                    assert!(error <= 1e-13 * (1.0 + middle.abs()) / root, "q = {q}, p = {p}: {error:.1e}");
                    solved += 1;
                }
                (Err(StepError { cause: StepFailure::NoSolution { reached }, .. }), Some(fold)) => {
                    assert!((-1e-4..=1.0 / 16.0).contains(&(fold - reached)), "{reached} of {fold}");
                    refused += 1;
                }
                (outcome, fold) => {
                    // Within rounding of the fold either may be.
                    assert!(
                        (1..=100).any(|n| discriminant(0.01 * f64::from(n)).abs() < 1e-3),
                        "q = {q}, p = {p}: {outcome:?}, fold {fold:?}"
                    );
                }
            }
        }
    }
    println!("{solved} solved, {refused} refused");
    assert!(solved > 375 && refused > 125, "{solved} {refused}");
}

/// A step into the wall: half of it free, the mid-point inside. Piecewise linear, so that the solution is known.
#[test]
fn a_kink_is_no_obstacle() {
    let (h, q, p) = (0.1, 0.05, -2.0);
    for exponent in [0, 3, 6, 9] {
        let wall = Wall { stiffness: 10.0_f64.powi(exponent) };
        let mut state = State::new([q], [p]);
        wall.stepper::<Midpoint>(h).unwrap().step(&mut state, &[]).unwrap();
        // M = (q + h p / 2) / (1 + h² k / 4) < 0
        let middle = (q + 0.5 * h * p) / (1.0 + 0.25 * h * h * wall.stiffness);
        assert!((0.5 * (q + state.q[0]) - middle).abs() <= 1e-15, "1e{exponent}");
    }
}

/// A step without solution is taken in parts with the increments that the same path has there.
#[test]
fn a_subdivided_step_is_the_finer_run() {
    // h² (q + h p / 2) > 1 for h = 1, not for h = 1/4.
    let start = State::new([1.2], [0.5]);
    let run = |h: f64| KickedCubic.simulate::<Midpoint>(h).start(start).noise(Wiener::seed(11));
    let outcome = run(1.0).steps(1).run();
    let Err(wzvi::Error::Step(StepError { cause: StepFailure::NoSolution { .. }, .. })) = outcome else {
        panic!("{outcome:?}");
    };
    let path = run(1.0).steps(1).retry(Retry::halving(6)).run().unwrap();
    let halvings = path.iterations().halvings;
    assert!(halvings > 0 && path.iterations().halved == 1);
    let parts = 2.0_f64.powi(halvings as i32);
    let finer = run(1.0 / parts).steps(parts as u64).run().unwrap();
    assert_eq!((path.last().q, path.last().p), (finer.last().q, finer.last().p));
    assert_eq!(path.last().t, 1.0);
}

#[test]
fn a_retry_that_does_not_help_leaves_the_state() {
    let run = Cubic.simulate::<Midpoint>(1.0).start(State::new([100.0], [100.0])).steps(3);
    let (path, error) = run.retry(Retry::halving(1)).run_partial().unwrap();
    assert_eq!((path.steps(), path.last().q[0], path.last().p[0]), (0, 100.0, 100.0));
    let Some(wzvi::Error::Step(error)) = error else { panic!("{error:?}") };
    assert_eq!((error.step, error.h), (0, 0.5));
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * (q * q - 1.0) * (q * q - 1.0),
    noise = [|q, p| q * p],
    embedding = Midpoint,
)]
struct DilatedWell;

/// With `w = ΔW/2` the step's Jacobian in both unknowns has the determinant `1 - w² + h²/4 V''(Q)`, and its sign tells
/// branches of solutions apart, although the momentum, with the pivot `1 + w`, is isolated in front of the iteration.
#[test]
fn isolated_unknowns_count_in_the_orientation() {
    let h = 0.01;
    let prepared = Discretized::<Midpoint>::prepare(&DilatedWell, h).unwrap();
    for w in [-1.5, -0.5, 0.5, 1.5] {
        let (mut q, mut p) = ([0.5], [0.5]);
        let at = StepArguments { t: 0.0, h, q: &mut q[..], p: &mut p[..], dw: &[2.0 * w] };
        let memory = &mut Default::default();
        let effort = SchemeOf::<DilatedWell, Midpoint>::advance::<f64, f64, PlainSum, true>(
            &DilatedWell,
            &prepared,
            at,
            memory,
            &mut PlainSum,
        )
        .unwrap();
        let mid = 0.5 * (0.5 + q[0]);
        let determinant = 1.0 - w * w + 0.25 * h * h * (3.0 * mid * mid - 1.0);
        assert_eq!(effort.is_reversed, determinant < 0.0, "w = {w}");
    }
}
