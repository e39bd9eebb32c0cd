//! What schemes of high order promise, for one of each kind of step: what is kept, what is at rest, steps in halves, paths of ensembles, runs
//! that go on from a checkpoint.

use std::path::Path;

use wzvi::checkpoint::Checkpoint;
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

/// A star in a galaxy: separable, so that all compositions take it, and symmetric.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + 0.5 * (x * x + y * y + core).ln(),
    invariant = [|[x, y], [px, py]| x * py - y * px],
    embedding = [Midpoint, Verlet, Gauss<8>],
)]
struct Galaxy {
    core: f64,
}

/// A particle in a well before a wall: beyond it there is no force.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q + 0.1 / (1.0 - q).sqrt(),
    embedding = [Midpoint, Verlet, Gauss<8>],
)]
struct Walled;

/// A particle between two wells that shake, without functions: in those of lanes and of one number last bits differ.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * q.powi(4) - 0.5 * q * q,
    noise = [|q, _| 0.5 * sigma * q * q / (1.0 + q * q), |q, _| 0.1 * q],
    embedding = [Midpoint, Verlet, Gauss<8>],
)]
struct Shaken {
    sigma: f64,
}

/// Calls a generic function for one scheme of each kind of step.
macro_rules! every_kind {
    ($check:ident) => {
        $check::<Gauss<8>>("Gauss<8>");
        $check::<Composed<Midpoint, Yoshida4>>("Composed<Midpoint, Yoshida4>");
        $check::<Composed<Verlet, KahanLi8>>("Composed<Verlet, KahanLi8>");
        $check::<Composed<Verlet, Aba864>>("Composed<Verlet, Aba864>");
        $check::<Composed<Verlet, Chin4>>("Composed<Verlet, Chin4>");
    };
}

const GALAXY: Galaxy = Galaxy { core: 0.1 };

/// Angular momentum is quadratic, and the potential symmetric: only rounding moves it. A step rounds at most 40 times terms below 2, a walk.
#[test]
fn angular_momentum_is_kept_to_rounding() {
    fn check<E>(scheme: &str)
    where
        Galaxy: Discretized<E, Vector = SVector<f64, 2>>,
    {
        let momentum = |state: &State<SVector<f64, 2>>| state.q[0] * state.p[1] - state.q[1] * state.p[0];
        let mut state = State::new([1.0, 0.0], [0.1, 0.6]);
        let start = momentum(&state);
        let mut stepper = GALAXY.stepper::<E>(0.1).unwrap();
        let (mut worst, steps) = (0.0_f64, 2000);
        for _ in 0..steps {
            stepper.step(&mut state, &[]).unwrap();
            worst = worst.max((momentum(&state) - start).abs());
        }
        let walk = 2.0 * f64::EPSILON * (40.0 * f64::from(steps)).sqrt();
        assert!(worst < walk, "{scheme}: {worst:.1e}, {walk:.1e}");
    }
    every_kind!(check);
}

/// Where force and momentum are zero, no scheme moves a bit.
#[test]
fn what_is_at_rest_stays_there() {
    fn check<E>(scheme: &str)
    where
        Galaxy: Discretized<E, Vector = SVector<f64, 2>>,
    {
        let rest = State::new([0.0, 0.0], [0.0, 0.0]);
        let mut state = rest;
        let mut stepper = GALAXY.stepper::<E>(0.1).unwrap();
        for _ in 0..1000 {
            stepper.step(&mut state, &[]).unwrap();
        }
        assert_eq!((state.q, state.p), (rest.q, rest.p), "{scheme}");
    }
    every_kind!(check);
}

/// A step that ends behind the wall is halved until none does and the halves agree, and those parts are steps of that size.
#[test]
fn steps_are_halved_where_they_fail() {
    fn check<E>(scheme: &str)
    where
        Walled: Discretized<E, Vector = SVector<f64, 1>>,
    {
        let start = State::new([0.5], [1.0]);
        // Steps of any size that have a solution are good.
        let fails = |h: &f64| Walled.simulate::<E>(*h).start(start).steps(1).run().is_err();
        let Some(h) = [1.0, 1.5, 2.0, 3.0, 5.0].into_iter().find(fails) else {
            // Implicit steps of any of these sizes have one before the wall.
            assert!(scheme.starts_with("Composed<Midpoint") || scheme.contains("Gauss"), "{scheme}");
            return;
        };
        let halved =
            || Walled.simulate::<E>(h).start(start).steps(1).retry(Retry::halving(12)).run().unwrap();
        let solvable = (1..=12)
            .find(|&halvings| {
                let h = h / f64::from(1 << halvings);
                Walled.simulate::<E>(h).start(start).steps(1 << halvings).run().is_ok()
            })
            .unwrap();
        let whole = halved();
        let halvings = whole.iterations().halvings;
        assert!(halvings > solvable, "{scheme}: {halvings} {solvable}");
        let parts = Walled.simulate::<E>(h / f64::from(1 << halvings)).start(start).steps(1 << halvings);
        let parts = parts.run().unwrap();
        assert_eq!(
            (whole.last().q, whole.last().p),
            (parts.last().q, parts.last().p),
            "{scheme}, {halvings}"
        );
        assert_eq!(whole.iterations().halved, 1, "{scheme}");
    }
    every_kind!(check);
}

/// Paths of an ensemble, from many starts, are those of a stepper, one by one.
#[test]
fn paths_of_an_ensemble_are_those_of_a_stepper() {
    fn check<E>(scheme: &str)
    where
        Galaxy: Discretized<E, Vector = SVector<f64, 2>>,
    {
        let starts: Vec<_> = (0..7).map(|i| State::new([1.0, 0.1 * f64::from(i)], [0.0, 0.5])).collect();
        let run = GALAXY.ensemble::<E>(0.1).starts_from(starts.clone()).steps(50).keep_paths(1 << 16);
        let paths = run.run().unwrap();
        for (path, start) in starts.into_iter().enumerate() {
            let (mut state, mut stepper) = (start, GALAXY.stepper::<E>(0.1).unwrap().plain());
            (0..50).for_each(|_| {
                stepper.step(&mut state, &[]).unwrap();
            });
            let kept = paths.paths().unwrap().at(path, 1).unwrap();
            assert_eq!(kept[..4], [state.q[0], state.q[1], state.p[0], state.p[1]], "{scheme}, path {path}");
        }
    }
    every_kind!(check);
}

/// A run that stops anywhere and goes on from its checkpoint ends as it would have without.
#[test]
fn runs_go_on_from_checkpoints() {
    fn check<E>(scheme: &str)
    where
        Galaxy: Discretized<E, Vector = SVector<f64, 2>>,
    {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
            .join("high_order")
            .join(scheme.replace(['<', '>', ','], "_"));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        let run = |steps| {
            GALAXY.simulate::<E>(0.1).start(State::new([1.0, 0.3], [0.1, 0.6])).steps(steps).record_every(0)
        };
        let whole = run(9).run().unwrap();
        for stop in [0, 1, 4] {
            let to = || Checkpoint::to(folder.join(stop.to_string()));
            run(stop).checkpoint(to()).run().unwrap();
            assert_eq!(
                run(9).checkpoint(to()).run().unwrap().last(),
                whole.last(),
                "{scheme}, stopped after {stop}"
            );
        }
    }
    every_kind!(check);
}

/// The noise of a path of an ensemble drives one path to the same end, and so do its increments in a list.
#[test]
fn one_seed_has_one_meaning() {
    fn check<E>(scheme: &str)
    where
        Shaken: Discretized<E, Vector = SVector<f64, 1>>,
    {
        let (system, start) = (Shaken { sigma: 0.3 }, State::new([0.4], [0.3]));
        let ensemble =
            system.ensemble::<E>(0.05).start(start).paths(19).seed(7).steps(20).keep_paths(1 << 16);
        let ensemble = ensemble.run().unwrap();
        for path in 0..19 {
            let alone = || system.simulate::<E>(0.05).start(start).steps(20);
            let drawn = alone().noise(StepNormals::seed(7).path(path)).run().unwrap();
            let rows: Vec<[f64; 2]> = drawn.increments().map(|dw| [dw[0], dw[1]]).collect();
            let given = alone().noise(Increments::from(rows)).run().unwrap();
            assert_eq!(given.last(), drawn.last(), "{scheme}, path {path}");
            let mut stepper = system.stepper::<E>(0.05).unwrap().plain();
            let mut state = start;
            drawn.increments().for_each(|dw| {
                stepper.step(&mut state, dw).unwrap();
            });
            let kept = ensemble.paths().unwrap().at(path as usize, 1).unwrap();
            assert_eq!(kept[..2], [state.q[0], state.p[0]], "{scheme}, path {path}");
        }
    }
    check::<Gauss<8>>("Gauss<8>");
    check::<Composed<Midpoint, Yoshida4>>("Composed<Midpoint, Yoshida4>");
    check::<Composed<Verlet, KahanLi8>>("Composed<Verlet, KahanLi8>");
}
