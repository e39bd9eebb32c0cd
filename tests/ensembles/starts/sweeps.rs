//! Systems by path in lanes: each path is the one that a stepper of its system takes.

use fixtures::stepped::{failed, hard, paths_are_steppers, sweep_is_steppers};
use wzvi::ensemble::Statistics;
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;
use wzvi::system::Discretized;

use super::Well;

/// Four parameters, of which one chooses between two potentials; arithmetic only.
#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u + v * v) + 0.5 * (a * x * x + b * y * y) + c * x * x * y
        - d * y * y * y / 3.0 + if a < b { 0.1 * x * y } else { -0.2 * x * y },
    embedding = [Midpoint, Verlet, Gauss<4>],
)]
#[derive(Clone)]
pub(crate) struct Galaxy {
    pub(crate) a: f64,
    pub(crate) b: f64,
    pub(crate) c: f64,
    pub(crate) d: f64,
}

/// A mid-point step is linear, with a matrix whose pivots depend on the parameters.
#[hamiltonian(
    drift = |[x, y], [u, v], t| 0.5 * (u * u + v * v) + 0.5 * (a * x * x + b * y * y) + c * x * y - f * t * x,
    noise = [|[_, y], _| -s * y],
    embedding = [Midpoint],
)]
#[derive(Clone)]
pub(crate) struct Coupled {
    pub(crate) a: f64,
    pub(crate) b: f64,
    pub(crate) c: f64,
    pub(crate) f: f64,
    pub(crate) s: f64,
}

/// Not separable: a step of two coupled unknowns, which reads the time and what the noise multiplies.
#[hamiltonian(
    drift = |q, p, t| 0.5 * p * p / (1.0 + m * q * q) + 0.25 * k * q * q * q * q + f * t * q,
    noise = [|q, p| s * q * p],
    embedding = [Midpoint, Gauss<2>],
)]
#[derive(Clone)]
pub(crate) struct Bent {
    pub(crate) m: f64,
    pub(crate) k: f64,
    pub(crate) f: f64,
    pub(crate) s: f64,
}

/// A particle between two wells that shake: separable, with two noises.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * q.powi(4) - 0.5 * q * q,
    noise = [|q, _| 0.5 * sigma * q * q / (1.0 + q * q), |q, _| 0.1 * q],
    embedding = [Midpoint, Verlet, Gauss<8>],
)]
#[derive(Clone)]
struct Shaken {
    sigma: f64,
}

/// Every path of a sweep is the one that a stepper takes of its system.
macro_rules! sweep_is_that_of_steppers {
    ($scheme:ty, $system:ty, $of_path:expr, $start:expr) => {{
        let list: Vec<$system> = (0..75).map($of_path).collect();
        assert_eq!(failed(&sweep_is_steppers::<$scheme, _>(&list, &$start, (0.1, 8), true)), 0);
    }};
}

fn galaxy(path: u64) -> Galaxy {
    let digit = |place: u32| (path / 3_u64.pow(place) % 3) as f64;
    Galaxy { a: 1.0 + 0.5 * digit(0), b: 1.25 - 0.25 * digit(1), c: 0.5 * digit(2), d: 1.0 - 0.4 * digit(3) }
}

fn coupled(path: u64) -> Coupled {
    // The step of size 0.1 has the matrix [1 + a/400, c/400; c/400, 1 + b/400].
    let digit = |place: u32| (path / 5_u64.pow(place) % 5) as f64;
    Coupled {
        a: 30.0 * digit(0) - 40.0,
        b: 20.0 * digit(1),
        c: 400.0 * (digit(2) - 1.0) + 30.0,
        f: 0.1 * digit(1),
        s: 0.2,
    }
}

fn bent(path: u64) -> Bent {
    let digit = |place: u32| (path / 4_u64.pow(place) % 4) as f64;
    Bent { m: 0.3 * digit(0), k: 0.5 + digit(1), f: 0.1 * digit(2), s: 0.2 + 0.05 * digit(0) }
}

#[test]
fn sweeps_go_in_lanes() {
    let start = State::new([0.1, -0.2], [0.05, 0.3]);
    sweep_is_that_of_steppers!(Midpoint, Galaxy, galaxy, start);
    sweep_is_that_of_steppers!(Verlet, Galaxy, galaxy, start);
    sweep_is_that_of_steppers!(Gauss<4>, Galaxy, galaxy, start);
    sweep_is_that_of_steppers!(Composed<Midpoint, Yoshida4>, Galaxy, galaxy, start);
}

#[test]
fn sweeps_with_noise_go_in_lanes() {
    let start = State::new([0.1, -0.2], [0.05, 0.3]);
    sweep_is_that_of_steppers!(Midpoint, Coupled, coupled, start);
    sweep_is_that_of_steppers!(Midpoint, Bent, bent, State::new([0.4], [0.3]));
    sweep_is_that_of_steppers!(Gauss<2>, Bent, bent, State::new([0.4], [0.3]));
    let shaken = |path: u64| Shaken { sigma: 0.1 * (path % 5) as f64 };
    sweep_is_that_of_steppers!(Gauss<8>, Shaken, shaken, State::new([0.4], [0.3]));
    sweep_is_that_of_steppers!(Composed<Midpoint, Yoshida4>, Shaken, shaken, State::new([0.4], [0.3]));
    sweep_is_that_of_steppers!(Composed<Verlet, KahanLi8>, Shaken, shaken, State::new([0.4], [0.3]));
}

/// Steps that the short way does not take, and paths that fail, each of its own system: as in
/// `hard_steps_keep_their_lane_to_themselves`.
#[test]
fn hard_steps_of_a_sweep_are_those_of_steppers() {
    let hard = hard_sweep::<Midpoint>(0.8);
    assert!(hard > 20, "{hard} hard steps: too few to test anything");
    hard_sweep::<Gauss<2>>(1.2);
    hard_sweep::<Composed<Midpoint, Yoshida4>>(0.6);
}

fn hard_sweep<E>(h: f64) -> u64
where
    Well: Discretized<E, Vector = SVector<f64, 1>>,
{
    let list: Vec<Well> = (0..12).map(|path| Well { k: 0.35 * path as f64 }).collect();
    // Steppers do not look at the energy.
    let wells = || list[0].ensemble::<E>(h).unwatched().systems(|draw| Well { k: 0.35 * draw.path() as f64 });
    let wells = || wells().start(State::new([-0.7], [0.2]));
    let paths = paths_are_steppers(wells, &list, (h, 30), (12, 9));
    assert!((1..12).contains(&failed(&paths)), "{} failures", failed(&paths));
    let run = || wells().seed(9).paths(12).allow_losses(1.0).keep_paths(1 << 20).steps(30);
    let reference = run().run().unwrap();
    let same = |other: wzvi::ensemble::Statistics| {
        other.paths().unwrap().count() == 12 && other.failures() == reference.failures()
    };
    assert!(same(run().run_in::<1>().unwrap()) && same(run().run_in::<32>().unwrap()));
    hard(&paths)
}

/// A constant force, which leaves a path at rest where there is none.
#[hamiltonian(drift = |q, p| 0.5 * p * p - f * q, embedding = Verlet)]
struct Pushed {
    f: f64,
}

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>() - f * q.iter().sum::<f64>(),
    embedding = Verlet,
)]
struct PushedSites {
    f: f64,
}

/// Where one path ends the next one begins, and no force of the last system is kept: `p = f t`.
#[test]
fn no_force_of_another_system_is_kept() {
    const PATHS: u64 = 256;
    let f = |path: u64| (path / 32 % 2) as f64;
    let check = |statistics: &Statistics| {
        for path in 0..PATHS {
            let [_, p, ..] = statistics.paths().unwrap().at(path as usize, 1).unwrap() else {
                panic!("two numbers")
            };
            // Twelve kicks at most, each with a rounding.
            assert!((p - f(path)).abs() <= 12.0 * f64::EPSILON, "path {path}: {p}");
        }
    };
    macro_rules! run {
        ($scheme:ty, $system:ident, $start:expr) => {{
            let run = $system { f: 0.0 };
            let run =
                || run.ensemble::<$scheme>(0.25).systems(|draw| $system { f: f(draw.path()) }).start($start);
            let run = || run().paths(PATHS).steps(4).threads(1).keep_paths(1 << 20);
            [run().run_in::<1>(), run().run_in::<8>()].into_iter().for_each(|run| check(&run.unwrap()));
        }};
    }
    run!(Verlet, Pushed, State::new([0.0], [0.0]));
    run!(Composed<Verlet, Yoshida4>, Pushed, State::new([0.0], [0.0]));
    run!(Verlet, PushedSites, State::new(vec![0.0], vec![0.0]));
}
