//! Sweeps: paths that each have a bath of their own, in lanes beside each other.

use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

use fixtures::Uniform;
use fixtures::bath::{Damped, Driven, Oscillator, Wall};
use fixtures::lanes::steps_in_part;
use fixtures::stepped::{hard, sweep_is_steppers};

const PATHS: u64 = 75;
const H: f64 = 0.1;
const STEPS: u64 = 24;

/// A digit of the number of a path.
fn digit(path: u64, place: u32) -> f64 {
    (path / 3_u64.pow(place) % 3) as f64
}

/// Every parameter differs; the friction of a third of them is large.
fn oscillator(path: u64) -> Oscillator {
    let gamma = [0.3, 1.1, 700.0][(path % 3) as usize];
    let (m, k, b) = (0.8 + 0.1 * digit(path, 1), 1.3 - 0.2 * digit(path, 2), 0.2 * digit(path, 1));
    Oscillator { m, k, b, gamma, kt: 0.5 * digit(path, 3) }
}

/// Every path is the one that a stepper takes of its system; how many steps are hard.
fn check<E, H>(system: fn(u64) -> H, [q, p]: [f64; 2], goes_in_lanes: bool) -> u64
where
    H: Discretized<E, Vector = SVector<f64, 1>> + Clone + Send + Sync,
{
    let list: Vec<H> = (0..PATHS).map(system).collect();
    hard(&sweep_is_steppers::<E, H>(&list, &State::new([q], [p]), (self::H, STEPS), goes_in_lanes))
}

/// A pendulum.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p - q.cos(), friction = gamma, temperature = kt,
    embedding = [Baoab, Thermostat<Midpoint>],
)]
#[derive(Clone)]
struct Pendulum {
    gamma: f64,
    kt: f64,
}

/// One path without friction among others: no path depends on what is beside it.
#[test]
fn a_path_without_friction_changes_none_beside_it() {
    fn check<E>()
    where
        Pendulum: Discretized<E, Vector = SVector<f64, 1>>,
    {
        let system = |path| Pendulum { gamma: if path == 9 { 0.0 } else { 0.5 }, kt: 0.3 };
        let base = system(0);
        let run =
            || base.ensemble::<E>(0.2).systems(|draw| system(draw.path())).start(State::new([1.0], [0.4]));
        let run = || run().paths(24).seed(3).steps(300).keep_paths(1 << 20).threads(1);
        let alone = run().run_in::<1>().expect("a run");
        for other in [run().run_in::<4>(), run().run_in::<8>(), run().run_in::<32>()] {
            assert_eq!(other.expect("a run").paths(), alone.paths());
        }
        let list: Vec<Pendulum> = (0..24).map(system).collect();
        sweep_is_steppers::<E, _>(&list, &State::new([1.0], [0.4]), (0.2, 50), true);
    }
    check::<Baoab>();
    check::<Thermostat<Midpoint>>();
}

/// Steps that some of the paths beside each other cannot take the short way: what a part of the step has done for the others is undone with it.
#[test]
fn hard_steps_between_the_bath_are_those_of_steppers() {
    let well = |path| {
        let stiffness = 40.0 * (path % 20) as f64;
        Oscillator { m: 1.0, k: -stiffness, b: stiffness, gamma: 0.2, kt: 0.5 + digit(path, 3) }
    };
    let hard = check::<Thermostat<Midpoint>, _>(well, [0.7, 0.2], true);
    assert!(hard > 50, "{hard} hard steps: too few to test anything");
}

/// Only the lanes that cannot take the step between the bath go alone.
#[test]
fn a_hard_step_between_the_bath_leaves_those_beside_it_in_lanes() {
    let (mut starts, mut normals) = (Uniform(7), Uniform(7));
    let well = Oscillator { m: 1.0, k: -400.0, b: 400.0, gamma: 0.2, kt: 0.5 };
    let start = || [2.0 * starts.draw(), 8.0 * starts.draw()];
    let in_part = steps_in_part::<Thermostat<Midpoint>, _>(&well, H, start, || 0.5 * normals.draw());
    assert!(in_part > 10, "{in_part} steps in part: too few to test anything");
}

#[test]
fn each_path_has_its_own_bath() {
    let start = [0.3, -0.4];
    check::<Baoab, _>(oscillator, start, true);
    check::<Obabo, _>(oscillator, start, true);
    check::<Thermostat<Verlet>, _>(oscillator, start, true);
    check::<Thermostat<Midpoint>, _>(oscillator, start, true);
    check::<Thermostat<Gauss<2>>, _>(oscillator, start, true);
}

/// Besides it a noise that reads the state, and no temperature.
#[test]
fn noises_stand_before_the_bath_of_each_path() {
    let driven = |path| Driven { sigma: 0.2 * digit(path, 0), gamma: 0.5 + digit(path, 1), kt: 0.9 };
    check::<Baoab, _>(driven, [0.3, -0.4], true);
    check::<Obabo, _>(driven, [0.3, -0.4], true);
    check::<Thermostat<Midpoint>, _>(driven, [0.3, -0.4], true);
    let damped = |path| Damped { m: 1.1, k: 1.0 + digit(path, 0), b: 0.3, gamma: 0.1 + digit(path, 1) };
    check::<Baoab, _>(damped, [0.3, -0.4], true);
}

/// Paths without friction go in lanes with their like, and by themselves beside others.
#[test]
fn paths_without_friction_are_those_of_steppers() {
    let still = |path| Oscillator { gamma: 0.0, ..oscillator(path) };
    check::<Baoab, _>(still, [0.3, -0.4], true);
    check::<Obabo, _>(still, [0.3, -0.4], true);
    check::<Thermostat<Midpoint>, _>(still, [0.3, -0.4], true);
    let some = |path| Oscillator { gamma: digit(path, 0), ..oscillator(path) };
    check::<Baoab, _>(some, [0.3, -0.4], false);
    check::<Thermostat<Midpoint>, _>(some, [0.3, -0.4], false);
}

/// Behind a wall energies are undefined: hot paths end there, the others go on.
#[test]
fn paths_of_a_sweep_fail_alone() {
    let wall = |path| Wall { gamma: 0.2 + 0.3 * digit(path, 0), kt: 0.01 + 40.0 * digit(path, 1) };
    check::<Baoab, _>(wall, [1.0, 0.0], true);
    let list: Vec<Wall> = (0..PATHS).map(wall).collect();
    let run = list[0].ensemble::<Baoab>(H).systems_from(list.clone()).start(State::new([1.0], [0.0]));
    let run = run.seed(9).allow_losses(1.0).steps(STEPS).run().expect("a run");
    assert!((1..PATHS).contains(&run.failed()), "{} failures", run.failed());
}
