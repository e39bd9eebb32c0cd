//! Steps that have no end on the manifold, starts that are not there, and linkages that fold.

use fixtures::are_refused;
use wzvi::error::{Error, StepFailure};
use wzvi::prelude::*;

use super::holds::chain;
use super::systems::{Sphere, WarmSphere};

/// A rod about a point.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) / m + m * g * y,
    constraint = [|[x, y]| (x - centre) * (x - centre) + (y + centre) * (y + centre) - length * length],
    embedding = Rattle,
)]
#[derive(Clone, Debug)]
struct Rod {
    m: f64,
    g: f64,
    length: f64,
    centre: f64,
}

const ROD: Rod = Rod { m: 1.0, g: 1.0, length: 1.0, centre: 0.0 };

/// Two cranks of length 1 and a coupler between them, of length 2 as the base.
#[hamiltonian(
    drift = |[_, _, _, _], [a, b, c, d]| 0.5 * (a * a + b * b + c * c + d * d),
    constraint = [
        |[x1, y1, _, _]| x1 * x1 + y1 * y1 - 1.0,
        |[_, _, x2, y2]| (x2 - 2.0).powi(2) + y2 * y2 - 1.0,
        |[x1, y1, x2, y2]| (x2 - x1).powi(2) + (y2 - y1).powi(2) - 4.0,
    ],
    embedding = Rattle,
)]
#[derive(Clone, Debug)]
struct FourBars;

/// A point on the unit circle, with its second coordinate in another unit.
#[hamiltonian(
    drift = |[_, _], [px, py]| 0.5 * (px * px + unit * unit * py * py),
    constraint = [|[x, y]| x * x + (y / unit) * (y / unit) - 1.0],
    embedding = Rattle,
)]
#[derive(Clone, Debug)]
struct Circle {
    unit: f64,
}

type Start<H> = State<<H as Hamiltonian>::Vector>;

fn failure<T: std::fmt::Debug>(run: Result<T, Error>) -> StepFailure {
    match run {
        Err(Error::Step(error)) => error.cause,
        other => panic!("{other:?}"),
    }
}

/// Parallel cranks at this angle, which turn towards the fold with unit speed.
fn cranks(angle: f64) -> Start<FourBars> {
    let (c, s) = (angle.cos(), angle.sin());
    State::new([c, s, 2.0 + c, s], [s, -c, s, -c])
}

/// On the unit circle without forces a step has an end if `h |v| ≤ 1`.
#[test]
fn there_is_an_end_up_to_the_radius_of_curvature() {
    let free = Rod { g: 0.0, ..ROD };
    let step = |h: f64, v: f64| {
        let mut state = State::new([0.0, -1.0], [v, 0.0]);
        let start = state;
        let outcome = free.stepper::<Rattle>(h).unwrap().step(&mut state, &[]);
        assert!(outcome.is_ok() || state == start);
        outcome.map(|_| state).map_err(|error| error.cause)
    };
    for h in [1.0, -1.0, 0.125] {
        for v in [1.0 - 1e-7, 1.0 - 1e-15] {
            let end = step(h, v / h).unwrap();
            // Where both ends of the fold meet, a rounding is a square root of it.
            assert!((end.q[0] - v).abs() < 1e-15 && end.q[1].abs() < 1e-3, "{end:?}");
        }
        match step(h, 1.0001 / h) {
            Err(StepFailure::BeyondCurvature { constraint: 0, length, radius }) => {
                assert!((length - 1.0001).abs() < 1e-12 && (radius - 1.0).abs() < 1e-3, "{length} {radius}");
            }
            other => panic!("{other:?}"),
        }
    }
}

/// What the message advises works: parts of the step have ends.
#[test]
fn a_step_that_is_too_long_is_divided() {
    let (sphere, start) = (Sphere { g: 1.0 }, State::new([0.0, 0.0, -1.0], [3.0, 0.0, 0.0]));
    let run = || sphere.simulate::<Rattle>(0.5).start(start).steps(40).unwatched();
    let cause = failure(run().run());
    assert!(matches!(cause, StepFailure::BeyondCurvature { constraint: 0, .. }), "{cause:?}");
    let path = run().retry(Retry::halving(8)).run().unwrap();
    for node in path.states() {
        assert!((node.q.norm() - 1.0).abs() < 4e-15 && node.q.dot(&node.p).abs() < 4e-14, "{node:?}");
    }
    // A warm one, too: in two dimensions a share of steps has momenta beyond 1/h.
    let warm = WarmSphere { gamma: 1.0, kt: 1.0 };
    let start = State::new([0.0, 0.0, -1.0], [0.0; 3]);
    let run = || warm.simulate::<GBaoab>(0.8).start(start).noise(Wiener::seed(3)).steps(500).unwatched();
    let cause = failure(run().run());
    assert!(matches!(cause, StepFailure::BeyondCurvature { constraint: 0, .. }), "{cause:?}");
    let path = run().retry(Retry::halving(5)).run().unwrap();
    assert!(path.states().iter().all(|node| (node.q.norm() - 1.0).abs() < 4e-15));
}

/// Cranks pass their fold between two nodes by inertia, and stay parallel. A node at the fold, where a motion
/// may go on in two ways, is a dependent constraint.
#[test]
fn a_fold_is_passed_or_named() {
    let path = FourBars.simulate::<Rattle>(0.1).start(cranks(0.5)).steps(25).run().unwrap();
    for node in path.states() {
        assert!((node.q[0] + 2.0 - node.q[2]).abs() < 1e-12 && (node.q[1] - node.q[3]).abs() < 1e-12);
    }
    // A step turns by asin(h).
    for (turns, h) in [(1.0_f64, 0.1_f64), (5.0, 0.1), (50.0, 0.01)] {
        let run = || FourBars.simulate::<Rattle>(h).start(cranks(turns * h.asin())).steps(70);
        let cause = failure(run().run());
        assert!(matches!(cause, StepFailure::Dependent { .. }), "{cause:?}");
    }
    are_refused(
        FourBars.simulate::<Rattle>(0.1).start(cranks(0.0)).steps(1).run(),
        "as where a linkage is folded",
    );
}

/// A rod is as long far from the origin as it is there.
#[test]
fn a_start_off_the_manifold_is_refused_anywhere() {
    for centre in [0.0, 1e3, 1e6, -1e8] {
        let rod = Rod { centre, ..ROD };
        let run = |stretch: f64| {
            let start = State::new([centre + 0.6 * stretch, -centre - 0.8 * stretch], [0.8, 0.6]);
            rod.simulate::<Rattle>(0.1).start(start).steps(1)
        };
        for stretch in [1.1, 0.999, 1.0001] {
            are_refused(run(stretch).run(), "not on the manifold");
            run(stretch).project_start().run().unwrap();
        }
        run(1.0).run().unwrap();
    }
}

#[test]
fn numbers_without_a_manifold_are_named() {
    let start = State::new([0.6, -0.8], [0.4, 0.3]);
    let run = |rod: Rod| rod.simulate::<Rattle>(0.1).start(start).project_start().steps(1).run();
    are_refused(run(Rod { length: 0.0, ..ROD }), "no point of the manifold of the constraints was found");
    are_refused(run(Rod { length: f64::INFINITY, ..ROD }), "check the numbers in the constraints");
    for m in [0.0, -1.0, f64::INFINITY] {
        are_refused(run(Rod { m, ..ROD }), "check that masses are positive and finite");
    }
    are_refused(run(Rod { m: f64::NAN, ..ROD }), "the parameter `m` of the system is NaN");
    let centre = ROD.simulate::<Rattle>(0.1).start(State::new([0.0, 0.0], [0.0, 0.0]));
    are_refused(centre.project_start().steps(1).run(), "constraint g1 follows from the others");
}

/// The unit of length, of mass and of time may be anything whose square is a number.
#[test]
fn units_do_not_matter() {
    let end = |[length, mass, time]: [f64; 3]| {
        let speed = length / time;
        let rod = Rod { m: mass, g: speed / time, length, ..ROD };
        let start = State::new([0.6, -0.8].map(|x| x * length), [0.8, 0.6].map(|v| v * mass * speed));
        let path = rod.simulate::<Rattle>(0.1 * time).start(start).steps(20).run().unwrap();
        let State { q, p, .. } = path.last();
        [q[0] / length, q[1] / length, p[0] / (mass * speed), p[1] / (mass * speed)]
    };
    let expected = end([1.0; 3]);
    for unit in [1e-100_f64, 1e100, 1e-30, 1e30] {
        for units in [[unit, 1.0, 1.0], [1.0, unit, 1.0], [1.0, 1.0, unit], [unit.sqrt(), unit.sqrt(), 1.0]] {
            for (found, expected) in end(units).iter().zip(expected) {
                // Twenty steps, each with some roundings.
                assert!((found - expected).abs() < 1e-14, "{units:?} {found} {expected}");
            }
        }
    }
}

/// Rest is rest: at the lowest point, and for a chain without momenta in any place without forces.
#[test]
fn rest_is_kept() {
    let path =
        ROD.simulate::<Rattle>(0.1).start(State::new([0.0, -1.0], [0.0, 0.0])).steps(100).run().unwrap();
    let State { q, p, .. } = path.last();
    assert!(q[0] == 0.0 && (q[1] + 1.0).abs() < 1e-15 && p.norm() < 1e-15, "{q} {p}");
    let (mut linkage, start) = chain(4);
    linkage.gravity = [0.0; 3];
    let path = linkage.simulate::<Rattle>(0.1).start(start.clone()).project_start().steps(100).run().unwrap();
    assert_eq!(path.last().q, path.states()[0].q);
    assert!(path.last().p.iter().all(|p| *p == 0.0));
}

/// Whether a step is too long does not depend on the units of single coordinates.
#[test]
fn the_radius_of_curvature_has_no_unit() {
    let share = |unit: f64| {
        let ((s, c), v) = (0.7_f64.sin_cos(), 1.5);
        let mut state = State::new([c, unit * s], [-v * s, v * c / unit]);
        let circle = Circle { unit };
        match circle.stepper::<Rattle>(1.0).unwrap().step(&mut state, &[]).unwrap_err().cause {
            StepFailure::BeyondCurvature { constraint: 0, length, radius } => length / radius,
            other => panic!("{other:?}"),
        }
    };
    // The tangent of length 1.5 ends 2.25 above the circle: its radius is 1.
    for unit in [1.0, 1e-4, 1e5] {
        assert!((share(unit) - 1.5).abs() < 1e-13, "{}", share(unit));
    }
}
