//! A path of an ensemble without noise is that of a single run: its first step, its energy and its errors.

use fixtures::Uniform;
use fixtures::small::{Kepler, Pendulum, Sites};
use fixtures::stepped::{every_split, failed, paths_are_steppers};
use std::slice::from_ref;
use wzvi::error::StepFailure;
use wzvi::memory::StepMemory;
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

/// A double well, or a hard spring: arithmetic only, so that lanes have the bits of a single path.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p * (1.0 + e * q * q) + a * q * q + b * q * q * q + c * q * q * q * q,
    embedding = [Midpoint, Gauss<2>, Gauss<4>],
)]
struct Well {
    a: f64,
    b: f64,
    c: f64,
    e: f64,
}

/// Steps from random states that are long for the force, in ensembles of one and of eight paths; how many paths there were, and how many had an error.
fn compare<H, E, const D: usize>(system: &H) -> [u64; 2]
where
    H: Discretized<E> + Hamiltonian<Vector = SVector<f64, D>> + Sync,
{
    const STEPS: u64 = 5;
    let (mut random, mut counts) = (Uniform(D as u64), [0; 2]);
    for paths in [1, 8] {
        let h = 1.025 + 0.975 * random.draw();
        let starts: Vec<State<SVector<f64, D>>> = (0..paths)
            .map(|_| {
                let q: [f64; D] = std::array::from_fn(|_| 2.0 * random.draw());
                State::new(q, std::array::from_fn::<f64, D, _>(|_| 3.0 * random.draw()))
            })
            .collect();
        let run = || wzvi::ensemble::Ensemble::<H, E>::new(system, h).starts_from(starts.clone());
        let all = paths_are_steppers(run, from_ref(system), (h, STEPS), (paths, 0));
        counts = [counts[0] + paths, counts[1] + failed(&all)];
    }
    counts
}

/// The solution that continues the state is looked for where there is nothing to extrapolate from, beside others as alone.
#[test]
fn first_steps_are_those_of_single_paths() {
    let wells = [(-3.0, 0.0, 2.0, 0.0), (0.5, 0.3, 1.0, 0.0), (0.5, 0.0, 0.25, 1.0)];
    let mut counts =
        vec![compare::<_, Midpoint, 2>(&Sites { g: 0.1 }), compare::<_, Gauss<2>, 2>(&Sites { g: 0.1 })];
    for (a, b, c, e) in wells {
        let well = Well { a, b, c, e };
        counts.extend([compare::<_, Midpoint, 1>(&well), compare::<_, Gauss<2>, 1>(&well)]);
        counts.push(compare::<_, Gauss<4>, 1>(&well));
    }
    let [paths, errors] = [0, 1].map(|i| counts.iter().map(|counts| counts[i]).sum::<u64>());
    println!("{errors} of {paths}: {counts:?}");
    // There are some of both.
    assert!(errors > 6 && 2 * errors < paths);
}

/// Springs in a row, so many that steps are solved in loops.
#[derive(Clone)]
#[hamiltonian(
    drift = |q: [f64; 12], p: [f64; 12]| {
        let v = |d: f64| 0.5 * d * d + 0.25 * d.powi(4);
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() + (1..q.len()).map(|i| v(q[i] - q[i - 1])).sum::<f64>() + v(q[0]) + v(q[11])
    },
    embedding = [Midpoint, Lambda<1, 4>],
)]
struct Springs;

/// The same with a noise at each site, and coordinates in the kinetic energy: both halves of the phase space are unknown.
#[derive(Clone)]
#[hamiltonian(
    drift = |q: [f64; 12], p: [f64; 12]| {
        let v = |d: f64| 0.5 * d * d + 0.25 * d.powi(4);
        (0..q.len()).map(|i| 0.5 * p[i] * p[i] * (1.0 + 0.1 * q[i] * q[i]) + v(q[i])).sum::<f64>()
            + (1..q.len()).map(|i| v(q[i] - q[i - 1])).sum::<f64>()
    },
    noise = [|q, _p, k| s * (q[k] + 0.1 * q[k] * q[k]); 12],
    embedding = Midpoint,
)]
struct PushedSprings {
    s: f64,
}

/// The same in a bath.
#[derive(Clone)]
#[hamiltonian(
    drift = |q: [f64; 12], p: [f64; 12]| {
        let v = |d: f64| 0.5 * d * d + 0.25 * d.powi(4);
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() + (1..q.len()).map(|i| v(q[i] - q[i - 1])).sum::<f64>() + v(q[0]) + v(q[11])
    },
    friction = 0.3,
    temperature = 0.2,
    embedding = Thermostat<Midpoint>,
)]
struct HeatedSprings;

type Twelve = SVector<f64, 12>;

/// Steps of each path.
const OF_SPRINGS: u64 = 10;

/// Steps whose Jacobian is factored, and all, of a path without noise.
fn steps_by_newton<E, H>(system: &H, h: f64, start: &State<Twelve>) -> [u64; 2]
where
    H: Discretized<E> + Hamiltonian<Vector = Twelve>,
{
    let (prepared, mut memory, mut state) = (system.prepare(h).unwrap(), system.memory(), *start);
    let mut counts = [0; 2];
    for _ in 0..OF_SPRINGS {
        let before = memory.linear_work().factorisations;
        let (q, p) = (state.q.as_mut_slice(), state.p.as_mut_slice());
        if system.advance(&prepared, 0.0, h, q, p, &[], &mut memory).is_ok() {
            counts = [counts[0] + u64::from(memory.linear_work().factorisations > before), counts[1] + 1];
        }
    }
    counts
}

/// Nine paths of twelve sites with amplitudes up to `amplitude`, in lanes, one by one, and by steppers, which systems of their own take.
fn check_widths<E, H>(system: &H, h: f64, amplitude: f64) -> (Vec<State<Twelve>>, u64)
where
    H: Discretized<E> + Hamiltonian<Vector = Twelve> + Sync + Clone,
{
    let mut random = Uniform(5);
    let mut list = |size: f64| std::array::from_fn::<f64, 12, _>(|_| size * random.draw());
    // Later paths move less.
    let sizes = (0..9).map(|path| amplitude * 0.6_f64.powi(path));
    let starts: Vec<State<Twelve>> = sizes.map(|size| State::new(list(size), list(size))).collect();
    let run = || {
        let all = wzvi::ensemble::Ensemble::<H, E>::new(system, h).starts_from(starts.clone()).seed(3);
        all.steps(OF_SPRINGS).record_every(1).allow_losses(1.0).observe("q", |state| state.q[5])
    };
    let (one, what) = (every_split(run), format!("h = {h}, amplitude {amplitude}"));
    let own = run().systems_from(vec![system.clone(); starts.len()]).run().unwrap();
    assert!(own == one, "{what}");
    (starts, one.failed())
}

/// Where the fixed point contracts in all lanes, in some of them, and in none; where steps need care, and where paths fail.
#[test]
fn paths_of_loops_have_the_same_bits_in_lanes() {
    let mut failed = 0;
    let mut by_newton = [0; 3];
    for (h, amplitude) in [(0.02, 1.0), (0.15, 2.5), (0.6, 1.0), (2.0, 4.0)] {
        let (starts, failures) = check_widths::<Midpoint, _>(&Springs, h, amplitude);
        for start in &starts {
            let [newton, steps] = steps_by_newton::<Midpoint, _>(&Springs, h, start);
            by_newton[if newton == 0 { 0 } else { 1 + usize::from(newton == steps) }] += 1;
        }
        failed += failures;
    }
    // Where it contracts in some lanes, and where paths fail.
    for (h, amplitude) in [(0.15, 2.5), (2.0, 4.0)] {
        failed += check_widths::<Lambda<1, 4>, _>(&Springs, h, amplitude).1;
        failed += check_widths::<Midpoint, _>(&PushedSprings { s: 0.1 }, h, amplitude).1;
    }
    println!("{by_newton:?} {failed}");
    assert!(by_newton.iter().all(|&paths| paths > 2) && failed > 0, "{by_newton:?} {failed}");
    let [paths, errors] = compare::<_, Midpoint, 12>(&Springs);
    assert!(errors < paths);
}

/// Where some paths need Newton's method, and where all do.
#[test]
fn compositions_and_baths_of_loops_have_the_same_bits_in_lanes() {
    for (h, amplitude) in [(0.15, 2.5), (0.6, 1.0)] {
        check_widths::<Composed<Midpoint, Yoshida4>, _>(&Springs, h, amplitude);
        check_widths::<Thermostat<Midpoint>, _>(&HeatedSprings, h, amplitude);
    }
}

/// Starts of orbits of semi-axis one, at their apocentres.
fn apocentres(eccentricities: &[f64]) -> Vec<State<SVector<f64, 2>>> {
    let start = |e: &f64| State::new([1.0 + e, 0.0], [0.0, ((1.0 - e) / (1.0 + e)).sqrt()]);
    eccentricities.iter().map(start).collect()
}

/// Stages that leap over the pericentre end the paths that do, and no other.
#[test]
fn paths_whose_energy_has_changed_are_refused() {
    let starts = apocentres(&[0.99, 0.1, 0.985, 0.3]);
    let run = || Kepler.ensemble::<Gauss<8>>(1e-2).starts_from(starts.clone()).until(5.0).allow_losses(0.5);
    let ended = run().run().unwrap();
    let paths: Vec<u64> = ended.failures().iter().map(|failure| failure.path).collect();
    assert_eq!(paths, [0, 2]);
    for failure in ended.failures() {
        println!("{}", failure.error);
        assert!(matches!(failure.error.cause, StepFailure::Unresolved { .. }));
        // As a single one, but for when it is looked at.
        let alone = Kepler.simulate::<Gauss<8>>(1e-2).start(starts[failure.path as usize]).until(5.0).run();
        let Err(wzvi::Error::Step(alone)) = alone else { panic!("it is refused") };
        assert!(failure.error.step >= alone.step, "{alone}");
        let (_, replayed) = run().replay(failure.path).unwrap();
        assert_eq!(replayed, Some(failure.error.into()));
    }
    assert!(matches!(run().allow_losses(0.1).run(), Err(wzvi::Error::Losses(_))));
    assert_eq!(run().unwatched().run().unwrap().failed(), 0);
    // One by one, in lanes of any width, and each with its own system.
    assert_eq!(run().run_in::<1>().unwrap().failures(), ended.failures());
    assert_eq!(run().run_in::<8>().unwrap().failures(), ended.failures());
    let own = run().systems_from((0..4).map(|_| Kepler)).run().unwrap();
    assert_eq!(own.failures(), ended.failures());
}

/// What goes wrong at any time up to 64 steps before the end is found.
#[test]
fn late_alarms_are_not_missed() {
    // The pericentre is after 314 steps.
    for steps in [400, 450, 700, 3000] {
        let run = Kepler.ensemble::<Gauss<8>>(1e-2).starts_from(apocentres(&[0.99])).steps(steps);
        let Err(wzvi::Error::Step(error)) = run.run() else { panic!("{steps} steps") };
        assert!(matches!(error.cause, StepFailure::Unresolved { .. }), "{error}");
    }
    let run = Kepler.ensemble::<Gauss<8>>(1e-2).starts_from(apocentres(&[0.99])).steps(64);
    assert_eq!(run.run().unwrap().failed(), 0);
}

/// Stable motions of any frequency, at the limit of their schemes.
#[test]
fn stable_motions_are_not_refused() {
    let starts: Vec<State<SVector<f64, 1>>> =
        (0..16).map(|k| State::new([0.2 * f64::from(k)], [0.0])).collect();
    for steps in [65, 1000] {
        for h in [0.01, 0.3, 0.7] {
            let run = |h| Pendulum.ensemble::<Verlet>(h).starts_from(starts.clone()).steps(steps);
            assert_eq!(run(h).run().unwrap().failed(), 0);
            let run = Pendulum.ensemble::<Midpoint>(h).starts_from(starts.clone()).steps(steps).run();
            assert_eq!(run.unwrap().failed(), 0);
        }
    }
}

/// Steps of orbits that have to be divided are divided as those of a single run are, and have the same bits.
#[test]
fn steps_are_divided_as_those_of_a_single_path() {
    // From the apocentre past the pericentre.
    let starts = apocentres(&[0.984, 0.986, 0.988, 0.99, 0.992, 0.994]);
    let retry = Retry::halving(12);
    let (mut divided, mut finest) = (0, 0);
    for (h, steps) in [(5e-3, 680), (1e-2, 340)] {
        let ensemble = || {
            let all = Kepler.ensemble::<Midpoint>(h).starts_from(starts.clone()).steps(steps).record_every(1);
            all.retry(retry).allow_losses(1.0)
        };
        assert!(ensemble().run_in::<1>().unwrap() == ensemble().run_in::<4>().unwrap());
        for (path, start) in starts.iter().enumerate() {
            let (single, theirs) =
                Kepler.simulate::<Midpoint>(h).start(*start).steps(steps).retry(retry).run_partial().unwrap();
            let (replayed, ours) = ensemble().replay(path as u64).unwrap();
            assert_eq!(ours, theirs, "path {path}");
            let pairs = replayed.states().iter().zip(single.states());
            let other =
                pairs.enumerate().find(|(_, (ours, theirs))| (ours.q, ours.p) != (theirs.q, theirs.p));
            assert!(other.is_none() && replayed.len() == single.len(), "path {path}: {other:?}");
            let [ours, theirs] = [&replayed, &single].map(|path| path.iterations());
            assert_eq!((ours.halved, ours.halvings), (theirs.halved, theirs.halvings), "path {path}");
            (divided, finest) = (divided + ours.halved, finest.max(ours.halvings));
        }
    }
    println!("{divided} steps divided, {finest} times");
    assert!(divided > 20 && finest == 12, "{divided} {finest}");
}

/// Sites in a periodic potential on springs, each with a noise of its own. From 256 sites on, each path of an
/// ensemble has a stepper; the cosine shows whether it has one everywhere.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().zip(q).map(|(p, q)| 0.5 * p * p + 1.0 - q.cos()).sum::<f64>()
            + (1..q.len()).map(|i| 0.5 * (q[i] - q[i - 1]).powi(2)).sum::<f64>()
    },
    noise = [|q, p, k| 0.3 * q[k]; self.sites],
    embedding = [Verlet],
)]
struct Kicked {
    sites: usize,
}

/// A large system has the same bits in an ensemble, in lanes of any width and in a replay; and its levels are
/// those of its paths.
#[test]
fn paths_of_large_systems_are_those_of_their_replays() {
    let system = Kicked { sites: 256 };
    let start = State::new((0..256).map(|i| (0.37 * f64::from(i)).sin()).collect::<Vec<_>>(), vec![0.0; 256]);
    let run = || system.ensemble::<Verlet>(0.1).start(start.clone()).paths(3).seed(3).steps(5);
    let ends = std::sync::Mutex::new(vec![start.clone(); 3]);
    let observed = || run().inspect(|path, state| ends.lock().unwrap()[path as usize] = state.clone());
    observed().run().unwrap();
    let alone = ends.lock().unwrap().clone();
    observed().run_in::<2>().unwrap();
    assert!(*ends.lock().unwrap() == alone, "in two lanes");
    for (path, end) in (0..).zip(&alone) {
        let (replayed, error) = run().replay(path).unwrap();
        assert!(error.is_none() && replayed.last() == end, "path {path}");
    }
    let levels = system.multilevel::<Verlet>(0.5).start(start.clone()).until(1.0).seed(3).paths(64);
    let levels = levels.observe("q", |state| state.q[0]).target(1e-3).finest(2).run().unwrap();
    // The coarsest level has as many paths as asked for, each once.
    let coarsest = levels.levels().first().unwrap();
    let same = system.ensemble::<Verlet>(0.5).start(start.clone()).until(1.0).seed(3).paths(coarsest.paths());
    let same = same.observe("q", |state| state.q[0]).run().unwrap();
    let (error, expected) = (coarsest.variance().sqrt(), same.last().unwrap().variance(0).sqrt());
    assert!((error - expected).abs() < 1e-12 * expected, "{error}, expected {expected}");
}
