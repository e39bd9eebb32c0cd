//! Ensembles whose paths start at states of their own, with noise and without: each path is the one that it is alone.

use fixtures::small::HenonHeiles;
use std::slice::from_ref;
use std::sync::Mutex;

use allocation_counter::measure;
use wzvi::ensemble::Draw;
use wzvi::error::{ConfigError, Error, StepFailure};
use wzvi::memory::Iteration;
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;
use wzvi::system::Discretized;

use fixtures::Uniform;
use fixtures::lanes::{steps_in_part, steps_together};
use fixtures::stepped::{Stepped, every_split, failed, hard, paths_are_steppers};

/// Stiff enough that some steps in the middle of a path are hard.
#[hamiltonian(drift = |q, p| 0.5 * p * p + k * (q * q - 1.0).powi(2), embedding = [Midpoint, Gauss<2>])]
pub struct Well {
    pub k: f64,
}

#[hamiltonian(
    drift = |q, p| 0.5 * (q * q + p * p),
    noise = [|q, p| sigma * q],
    embedding = [DeltaPlus],
)]
pub struct Driven {
    pub sigma: f64,
}

/// A drift that has no value for negative `q`.
#[hamiltonian(drift = |q, p| 0.5 * p * p + q * q.sqrt(), embedding = [DeltaPlus])]
pub struct Edge;

type Plane = SVector<f64, 2>;

/// In a composition, too, and what its parts remember is that of the steps that were taken.
#[test]
fn a_hard_step_leaves_those_beside_it_in_lanes() {
    let mut random = Uniform(7);
    let mut start = || [1.2 * random.draw(), 2.0 * random.draw()];
    let simple = steps_in_part::<Midpoint, _>(&Well { k: 2.0 }, 0.6, &mut start, || 0.0);
    let composed = steps_in_part::<Composed<Midpoint, Yoshida4>, _>(&Well { k: 2.0 }, 0.4, start, || 0.0);
    assert!(simple > 10 && composed > 5, "{simple} and {composed} steps in part: too few to test anything");
}

/// Unless the lanes are asked to go in part.
#[test]
fn lanes_that_advance_all_move_or_none() {
    let mut random = Uniform(7);
    let hard =
        steps_together::<Midpoint, _>(&Well { k: 2.0 }, 1.0, || [1.2 * random.draw(), 2.0 * random.draw()]);
    assert!(hard.iter().all(|&steps| steps > 10), "{hard:?}: too few to test anything");
}

fn cloud(draw: &mut Draw) -> State<Plane> {
    let mut number = || 0.12 * draw.normal();
    State::new([number(), number()], [number(), number()])
}

/// The last states of an ensemble, by path.
macro_rules! ends {
    ($run:expr, $paths:expr, $steps:expr) => {{
        let ends = Mutex::new(vec![None; $paths]);
        let statistics = $run
            .inspect(|path, state| ends.lock().unwrap()[path as usize] = Some(state.clone()))
            .paths($paths as u64)
            .steps($steps)
            .run()
            .unwrap();
        let ends: Vec<_> = ends.into_inner().unwrap().into_iter().map(Option::unwrap).collect();
        (ends, statistics)
    }};
}

mod stages;
mod sweeps;

/// Every path of a cloud is the one that a stepper takes from its start, however wide the lanes are.
fn paths_are_those_of_steppers<E>()
where
    HenonHeiles: Discretized<E, Vector = Plane>,
{
    let cloud = || HenonHeiles.ensemble::<E>(0.2).starts(cloud);
    let paths = paths_are_steppers(cloud, &[HenonHeiles], (0.2, 20), (45, 11));
    assert_eq!(failed(&paths), 0);
    let run = || cloud().seed(11).paths(45).steps(20);
    every_split(run);
}

#[test]
fn paths_of_a_cloud_are_those_of_steppers() {
    paths_are_those_of_steppers::<Verlet>();
    paths_are_those_of_steppers::<Gauss<2>>();
    paths_are_those_of_steppers::<Gauss<8>>();
    paths_are_those_of_steppers::<Composed<Midpoint, Yoshida4>>();
    paths_are_those_of_steppers::<Composed<Verlet, KahanLi8>>();
    paths_are_those_of_steppers::<Composed<Verlet, Aba864>>();
    paths_are_those_of_steppers::<Composed<Verlet, Chin4>>();
}

/// Nothing leads to the first step of a path, and nothing is hard about it: it is taken in lanes, which allocate what they need for any
/// number of steps; a path that goes alone would allocate lists of its own.
#[test]
fn first_steps_are_taken_in_lanes() {
    fn check<E>()
    where
        HenonHeiles: Discretized<E, Vector = Plane>,
    {
        const PATHS: usize = 300;
        // Short enough that no start leaves a doubt: such a one is followed along the step, which allocates.
        const H: f64 = 0.05;
        let run = |steps| {
            HenonHeiles.ensemble::<E>(H).starts(cloud).seed(11).paths(PATHS as u64).threads(1).steps(steps)
        };
        let starts = ends!(run(0), PATHS, 0).0;
        let (ends, _) = ends!(run(1), PATHS, 1);
        for (start, end) in starts.iter().zip(ends) {
            let (mut state, mut stepper) = (*start, HenonHeiles.stepper::<E>(H).unwrap().plain());
            assert!(!stepper.step(&mut state, &[]).unwrap().is_hard, "{start:?}");
            assert_eq!((state.q, state.p), (end.q, end.p), "{start:?}");
        }
        let [none, one] =
            [0, 1].map(|steps| measure(|| assert_eq!(run(steps).run().unwrap().failed(), 0)).count_total);
        assert!(one - none < PATHS as u64 / 8, "{none} allocations without steps, {one} with one");
    }
    check::<Midpoint>();
    check::<Composed<Midpoint, Yoshida4>>();
}

/// Steps that the short way does not take come at different times on different paths, and leave different numbers of steps to
/// remember: every width still takes the same ones, and they are a stepper's. Some paths come to a step without a solution, and end
/// where the stepper does.
#[test]
fn hard_steps_keep_their_lane_to_themselves() {
    let [hard, _, failed] = paths_of_a_stiff_well::<Midpoint>(Well { k: 2.0 }, 0.9);
    assert!(hard > 40, "{hard} hard steps: too few to test anything");
    assert!((1..20).contains(&failed), "{failed} failures");
    // Sweeps of some paths contract, those of others do not.
    let [_, slow, _] = paths_of_a_stiff_well::<Gauss<2>>(Well { k: 1.0 }, 0.7);
    assert!((5..15).contains(&slow), "{slow} of 20 paths take Newton's method");
    let [hard, _, _] = paths_of_a_stiff_well::<Gauss<2>>(Well { k: 2.5 }, 0.6);
    assert!(hard > 40, "{hard} hard steps: too few to test anything");
}

/// All paths are those of steppers. How many steps after the first were hard, how many paths have one that sweeps do not solve, and how many
/// fail.
fn paths_of_a_stiff_well<E>(well: Well, h: f64) -> [u64; 3]
where
    Well: Discretized<E, Vector = SVector<f64, 1>>,
{
    let start = |draw: &mut Draw| State::new([0.1 * draw.path() as f64 - 1.0], [0.3 * draw.normal()]);
    // Steppers do not look at the energy.
    let wells = || well.ensemble::<E>(h).unwatched().starts(start);
    let paths = paths_are_steppers(wells, from_ref(&well), (h, 30), (20, 3));
    let is_slow = |path: &&Stepped<_>| {
        let (mut swept, mut state) =
            (well.stepper::<E>(h).unwrap().plain().iteration(Iteration::FixedPoint), path.nodes[0]);
        (0..30).any(|_| swept.step(&mut state, &[]).is_err())
    };
    let slow = paths.iter().filter(is_slow).count() as u64;
    let run = || wells().seed(3).paths(20).steps(30).allow_losses(1.0);
    let reference = run().run().unwrap();
    assert!(run().run_in::<1>().unwrap() == reference && run().run_in::<32>().unwrap() == reference);
    [hard(&paths), slow, failed(&paths)]
}

/// A path that ends does not disturb its neighbours, with and without memory.
#[test]
fn a_path_that_fails_ends_alone() {
    let start = |draw: &mut Draw| State::new([if draw.path() == 3 { 0.01 } else { 50.0 }], [-0.5]);
    let run = || Edge.ensemble::<DeltaPlus>(0.1).starts(start).paths(9).allow_losses(1.0).steps(20);
    let statistics = every_split(run);
    assert_eq!(statistics.failures().iter().map(|failure| failure.path).collect::<Vec<_>>(), [3]);
    let alone = Edge.simulate::<DeltaPlus>(0.1).start(State::new([50.0], [-0.5])).steps(20).run().unwrap();
    let end = statistics.last().unwrap();
    assert_eq!(end.count(), 8);
    assert!((end.mean(0) - alone.last().q[0]).abs() < 1e-14);
}

/// Variance of the end of a harmonic oscillator after a quarter of a turn: that of the momentum at the start, and what the noise adds.
/// 15 000 paths: 4 standard errors of the variance, `√(2/n)` of it.
#[test]
fn starts_and_noise_are_independent() {
    let driven = Driven { sigma: 0.5 };
    let (h, steps) = (std::f64::consts::FRAC_PI_2 / 200.0, 200);
    let start = |draw: &mut Draw| State::new([0.0], [0.7 * draw.normal()]);
    let run = || driven.ensemble::<DeltaPlus>(h).starts(start).paths(15_000).seed(5).steps(steps);
    let end = run().run().unwrap();
    // q(T) = p_0 sin T - σ ∫ sin(T - s) dW, of variance 0.49 + σ² π/4; the scheme adds O(h).
    let exact = 0.49 + 0.25 * std::f64::consts::FRAC_PI_4;
    let variance = end.last().unwrap().variance(0);
    let allowed = 4.0 * exact * (2.0 / 15_000_f64).sqrt() + h * exact;
    assert!((variance - exact).abs() < allowed, "{variance} against {exact} within {allowed}");
}

/// A list is taken in its order; seeds, step sizes and schemes do not change where a sampler starts.
#[test]
fn starts_are_those_that_were_asked_for() {
    let list: Vec<_> = (0..37).map(|k| State::new([0.01 * f64::from(k), 0.0], [0.0, 0.1])).collect();
    let run = || HenonHeiles.ensemble::<Verlet>(0.1).starts_from(list.clone());
    let ends = Mutex::new(vec![None; 37]);
    let see = |path: u64, state: &State<Plane>| ends.lock().unwrap()[path as usize] = Some(*state);
    run().inspect(see).steps(0).run().unwrap();
    assert_eq!(ends.into_inner().unwrap().into_iter().map(Option::unwrap).collect::<Vec<_>>(), list);
    assert_eq!(run().paths(5).steps(1).run().unwrap().last().unwrap().count(), 5);

    let at = |h: f64, seed: u64| ends!(HenonHeiles.ensemble::<Midpoint>(h).starts(cloud).seed(seed), 8, 0).0;
    assert_eq!(at(0.1, 4), at(0.025, 4));
    assert_ne!(at(0.1, 4), at(0.1, 5));
}

#[test]
fn starts_that_are_none_are_refused() {
    let run = |start: fn(&mut Draw) -> State<Plane>| {
        HenonHeiles.ensemble::<Verlet>(0.1).starts(start).paths(100).steps(1).run().unwrap_err()
    };
    let nan = run(|draw| State::new([0.0, if draw.path() == 77 { f64::NAN } else { 0.0 }], [0.0, 0.0]));
    let expected = ConfigError::PathStart { path: 77, cause: StepFailure::NonFiniteInput };
    assert_eq!(nan, Error::Config(expected));
    let late = run(|draw| State { t: draw.path() as f64, ..State::new([0.0, 0.0], [0.0, 0.0]) });
    assert!(late.to_string().contains("path 1 starts at t = 1"), "{late}");
    let list = vec![State::new([0.0, 0.0], [0.0, 0.1]); 4];
    let short = HenonHeiles.ensemble::<Verlet>(0.1).starts_from(list).paths(5).steps(1).run().unwrap_err();
    assert!(short.to_string().contains("a start for each path"), "{short}");
    let none = HenonHeiles.ensemble::<Verlet>(0.1).starts_from([]).steps(1).run().unwrap_err();
    assert!(none.to_string().contains("a start for each path"), "{none}");
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * a * q * q * q * q + 0.5 * b * q * q,
    noise = [|q, p| sigma * q],
    embedding = [Midpoint],
)]
#[derive(Clone, Debug)]
pub struct Duffing {
    pub a: f64,
    pub b: f64,
    pub sigma: f64,
}

/// Parameters by path: each path is the one of its own system, with its own energy, however the run is split, and with retries.
#[test]
fn paths_have_the_systems_that_were_asked_for() {
    let grid =
        |path: u64| Duffing { a: 0.2 * (path % 6) as f64, b: 0.5 * (path / 6) as f64 - 0.5, sigma: 0.3 };
    let start = |draw: &mut Draw| State::new([1.0 + 0.01 * draw.path() as f64], [0.0]);
    let first = grid(0);
    let run = || first.ensemble::<Midpoint>(0.1).starts(start).seed(9).steps(50);
    let listed = || run().systems_from((0..30).map(grid));
    let reference = every_split(|| listed().keep_paths(1 << 20));
    let drawn = run().systems(|draw| grid(draw.path())).paths(30).keep_paths(1 << 20);
    assert!(drawn.run().unwrap() == reference);
    let paths = reference.paths().unwrap();
    for path in 0..30 {
        let system = grid(path);
        let alone = system
            .simulate::<Midpoint>(0.1)
            .start(State::new([1.0 + 0.01 * path as f64], [0.0]))
            .noise(StepNormals::seed(9).path(path))
            .steps(50)
            .run()
            .unwrap();
        let end = alone.last();
        let kept = paths.at(path as usize, 1).unwrap();
        assert_eq!(kept, [end.q[0], end.p[0], system.energy(end)], "path {path}");
        assert_eq!(listed().replay(path).unwrap().0.last(), end);
    }
}

#[test]
fn systems_that_are_none_are_refused() {
    let base = Duffing { a: 1.0, b: 1.0, sigma: 0.1 };
    let run = |bad: f64| {
        let system = move |draw: &mut Draw| Duffing {
            a: if draw.path() == 5 { bad } else { 1.0 },
            b: 1.0,
            sigma: 0.1,
        };
        let run = base.ensemble::<Midpoint>(0.1).systems(system).start(State::new([1.0], [0.0]));
        run.paths(9).seed(1).steps(2).run()
    };
    assert!(run(2.0).is_ok());
    let cause = Box::new(ConfigError::NotANumber { parameter: "a" });
    assert_eq!(run(f64::NAN).unwrap_err(), Error::Config(ConfigError::PathSystem { path: 5, cause }));
    let few = base.ensemble::<Midpoint>(0.1).systems_from(vec![base.clone(); 3]);
    let few = few.start(State::new([1.0], [0.0])).paths(4).seed(1).steps(1).run().unwrap_err();
    assert!(few.to_string().contains("a system for each path"), "{few}");
    // Which of two lists of different length is meant has to be said.
    let start = State::new([1.0], [0.0]);
    let both = |starts, systems| {
        let run = base.ensemble::<Midpoint>(0.1).starts_from(vec![start; starts]);
        run.systems_from(vec![base.clone(); systems]).seed(1).steps(1)
    };
    for (starts, systems) in [(2, 3), (3, 2)] {
        let error = both(starts, systems).run().unwrap_err().to_string();
        assert!(error.contains(&format!("{starts} starts and {systems} systems")), "{error}");
        assert_eq!(both(starts, systems).paths(2).run().unwrap().last().unwrap().count(), 2);
    }
    assert_eq!(both(3, 3).run().unwrap().last().unwrap().count(), 3);
}

/// More systems than memory holds are refused, not begun.
#[test]
fn there_is_room_for_all_systems_before_the_run() {
    let base = Duffing { a: 1.0, b: 1.0, sigma: 0.0 };
    let run = base.ensemble::<Midpoint>(0.1).systems(|_| Duffing { a: 1.0, b: 1.0, sigma: 0.0 });
    let run = run.start(State::new([0.1], [0.0])).paths(1 << 60).seed(3).steps(1);
    let error = run.run().unwrap_err().to_string();
    assert!(error.contains("no memory for the systems"), "{error}");
}

/// What is drawn for starts and for systems is independent.
#[test]
fn systems_and_starts_draw_different_numbers() {
    let pairs = Mutex::new(Vec::new());
    let base = Duffing { a: 1.0, b: 1.0, sigma: 0.0 };
    let run = base
        .ensemble::<Midpoint>(0.1)
        .systems(|draw| {
            let b = draw.normal();
            pairs.lock().unwrap().push(b);
            Duffing { a: 0.0, b, sigma: 0.0 }
        })
        .starts(|draw| State::new([draw.normal()], [0.0]))
        .paths(4)
        .seed(3)
        .keep_paths(1 << 16)
        .steps(0)
        .run()
        .unwrap();
    let kept = run.paths().unwrap();
    for (path, b) in pairs.into_inner().unwrap().into_iter().enumerate() {
        let [q, _, energy] = kept.at(path, 0).unwrap() else { panic!("two coordinates and the energy") };
        assert_ne!(*q, b);
        let own = Duffing { a: 0.0, b, sigma: 0.0 };
        assert_eq!(*energy, own.energy(&State::new([*q], [0.0])), "the energy of the path's own system");
    }
}
