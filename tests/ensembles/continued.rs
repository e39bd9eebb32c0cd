//! Runs that continue others: noise belongs to the time at which it acts, so that several runs have the noise
//! of one.

use std::collections::HashSet;
use std::slice::from_ref;

use fixtures::Uniform;
use fixtures::bath::{Chain, Oscillator};
use fixtures::folder;
use fixtures::small::{DoubleWell, KUBO, Kubo};
use fixtures::stepped::{paths_are_steppers, stepped};
use wzvi::checkpoint::Checkpoint;
use wzvi::increments::Interval;
use wzvi::noise::{Noise, Paths, Truncation};
use wzvi::prelude::*;
use wzvi::system::Gradient;

/// `dp = dW`
#[hamiltonian(drift = |q, p| 0.5 * p * p, noise = [|q, p| -q], embedding = Midpoint)]
pub struct Free;

const OSCILLATOR: Oscillator = Oscillator { m: 0.8, k: 1.3, b: 0.4, gamma: 0.6, kt: 0.7 };

type Rows = Vec<Vec<f64>>;

fn rows<V: wzvi::state::Vector, E>(path: &Trajectory<V, E>) -> Rows {
    path.increments().map(<[f64]>::to_vec).collect()
}

/// Asserts that runs from one of these times to the next have the increments of one run, bit by bit: single
/// paths, and paths of ensembles.
fn continue_one_run<E, H: Discretized<E> + Sync>(
    system: &H,
    path: u64,
    h: f64,
    start: &State<H::Vector>,
    times: &[f64],
) {
    let what = std::any::type_name::<(E, H)>();
    let (first, last) = (times[0], times[times.len() - 1]);
    let alone = |from: State<H::Vector>, to: f64| {
        let run = system.simulate::<E>(h).start(from).noise(StepNormals::seed(7).path(path).untruncated());
        run.retry(Retry::halving(12)).until(to).run().unwrap()
    };
    let of_ensemble = |from: State<H::Vector>, to: f64, is_antithetic: bool| {
        let run = system
            .ensemble::<E>(h)
            .start(from)
            .paths(2 * (path + 1))
            .seed(7)
            .until(to)
            .retry(Retry::halving(12));
        let run = run.truncation(Truncation::Off);
        let run = if is_antithetic { run.antithetic() } else { run };
        let (path, error) = run.record_every(1).replay(path).unwrap();
        assert_eq!(error, None, "{what}");
        path
    };
    type Run<'r, H, E> =
        &'r dyn Fn(State<<H as Hamiltonian>::Vector>, f64) -> Trajectory<<H as Hamiltonian>::Vector, E>;
    let runs: [Run<'_, H, E>; 3] =
        [&alone, &|from, to| of_ensemble(from, to, false), &|from, to| of_ensemble(from, to, true)];
    for (kind, run) in runs.iter().enumerate() {
        let whole = run(start.clone().at(first), last);
        let (mut state, mut parts) = (start.clone().at(first), Rows::new());
        for &time in &times[1..] {
            let part = run(state, time);
            parts.extend(rows(&part));
            state = part.last().clone();
        }
        assert_eq!(parts, rows(&whole), "{what}, {kind}: from {times:?}");
        let distinct: HashSet<u64> = parts.iter().map(|row| row[0].to_bits()).collect();
        assert_eq!(distinct.len(), parts.len(), "{what}, {kind}: from {times:?}");
    }
}

#[test]
fn runs_that_go_on_have_the_noise_of_one_run() {
    let start = State::new([0.5], [2.0]);
    for times in [&[0.0, 10.0, 20.0][..], &[-12.0, -3.5, 0.0, 4.5], &[10.1, 13.3, 17.0]] {
        continue_one_run::<Midpoint, _>(&Free, 3, 0.1, &start, times);
        continue_one_run::<Baoab, _>(&OSCILLATOR, 3, 0.1, &start, times);
        continue_one_run::<Thermostat<Midpoint>, _>(&OSCILLATOR, 3, 0.1, &start, times);
    }
    // Backwards, the numbers of steps grow from -100 to 100.
    continue_one_run::<Midpoint, _>(&Free, 3, -0.1, &start, &[10.0, 3.0, 0.0, -10.0]);
    // Some of these steps are halved.
    let (well, path) = halved_path(7, -5.0, 50);
    continue_one_run::<Midpoint, _>(&well, path, 0.5, &start, &[-5.0, 0.0, 12.5, 20.0]);
}

/// From any time, in any lanes and on any threads, with the normals of paths and of pairs: each path is the
/// one of a stepper with [`StepNormals`].
#[test]
fn paths_that_start_at_any_time_are_those_of_the_noise() {
    for t in [-7.3, -1.0, 0.35, 10.0, 1e6] {
        let start = || State::new([0.3], [-0.4]).at(t);
        paths_are_steppers::<Midpoint, _, _>(
            || KUBO.ensemble::<Midpoint>(0.1).start(start()),
            from_ref(&KUBO),
            (0.1, 33),
            (19, 7),
        );
        let run =
            || KUBO.ensemble::<Midpoint>(0.1).start(start()).paths(38).seed(7).steps(33).keep_paths(1 << 20);
        let pairs = every_split_of_pairs(|| run().antithetic());
        let mut noise = StepNormals::seed(7).antithetic();
        for path in [0, 1, 18, 37] {
            noise.set_path(path);
            let steps = stepped::<Midpoint, _>(&KUBO, 0.1, start(), noise.clone(), 33);
            let end = steps.nodes.last().unwrap();
            assert_eq!(
                pairs.paths().unwrap().at(path as usize, 1).unwrap()[..2],
                [end.q[0], end.p[0]],
                "{t} {path}"
            );
        }
        // Many degrees of freedom, of which each path goes by itself.
        let chain = Chain { gamma: 0.5, kt: 1.0 };
        let list = |x: f64| (0..40).map(|i| x * f64::from(i).sin()).collect::<Vec<f64>>();
        let start = || State::new(list(0.3), list(0.5)).at(t);
        paths_are_steppers::<Baoab, _, _>(
            || chain.ensemble::<Baoab>(0.1).start(start()),
            from_ref(&chain),
            (0.1, 23),
            (5, 7),
        );
    }
}

fn every_split_of_pairs<'a, H: Discretized<E> + Sync + 'a, E>(
    run: impl Fn() -> wzvi::ensemble::Ensemble<'a, H, E>,
) -> wzvi::ensemble::Statistics {
    let reference = run().threads(1).run_in::<2>().unwrap();
    for threads in [1, 3] {
        assert!(run().threads(threads).run().unwrap() == reference, "{threads}");
    }
    assert!(run().run_in::<8>().unwrap() == reference);
    reference
}

/// Runs of any length, also with ends that are no nodes, never have an increment twice, wherever they start,
/// forwards and backwards through 0.
#[test]
fn no_chain_of_runs_has_an_increment_twice() {
    let mut random = Uniform(11);
    for h in [0.1, 1.0 / 3.0, 0.02, 0.7, 1.0, -0.1, -1.0 / 3.0] {
        for first in [-20.0, -10.000_000_000_000_004, -3.3, -0.5, 0.0, 0.05, 7.0] {
            let (mut t, mut seen) = (first * h, HashSet::new());
            let mut noise = StepNormals::seed(3);
            for _ in 0..60 {
                let (steps, kind) = ((8.0 * (random.draw() + 1.0)) as u64 % 8, random.draw());
                noise.prepare(&<Free as Discretized<Midpoint>>::PLAN, h, 1, t).unwrap();
                let mut dw = [0.0];
                let mut draw = |interval: &Interval, part: Option<f64>| {
                    match part {
                        None => noise.increments(interval, &mut dw).unwrap(),
                        Some(part) => noise.increments_of_part(interval, part, &mut dw).unwrap(),
                    }
                    assert!(seen.insert(dw[0].to_bits()), "h = {h}, from {first}: {dw:?} again at {t}");
                };
                for step in 0..steps {
                    draw(&Interval { start: t, h, step }, None);
                }
                let last = Interval { start: t, h, step: steps };
                // A third of the runs end at a node, a third at some time, a third in the middle of a step.
                let rest = h * if kind < -0.3 {
                    0.0
                } else if kind < 0.3 {
                    0.5
                } else {
                    kind
                };
                if rest != 0.0 {
                    draw(&last, Some(rest));
                }
                t = last.begin() + rest;
            }
        }
    }
    // The ends of two runs that are shorter than a step are two steps.
    let run = |from: f64, to: f64| {
        let start = State::new([0.0], [0.0]).at(from);
        Free.simulate::<Midpoint>(0.1).start(start).noise(StepNormals::seed(1)).until(to).run().unwrap()
    };
    assert_ne!(rows(&run(0.0, 0.05)), rows(&run(0.05, 0.1)));
    let of_ensemble = |from: f64, to: f64| {
        let run = Free.ensemble::<Midpoint>(0.1).start(State::new([0.0], [0.0]).at(from)).paths(2).seed(1);
        rows(&run.until(to).record_every(1).replay(0).unwrap().0)
    };
    assert_eq!(of_ensemble(0.05, 0.1), rows(&run(0.05, 0.1)));
}

/// Times too far from 0 to tell steps from each other are refused, not repeated.
#[test]
fn times_that_have_no_steps_are_refused() {
    let mut noise = StepNormals::seed(1);
    for (start, h) in [(1e17, 1.0), (-1e17, 1.0), (1.0, 1e-17), (f64::NAN, 1.0), (f64::INFINITY, 1.0)] {
        let outcome = noise.increments(&Interval { start, h, step: 0 }, &mut [0.0]);
        assert!(matches!(outcome, Err(wzvi::noise::NoiseError::Time { .. })), "{start} {h}: {outcome:?}");
    }
}

/// `Var p(20) = 20`, of 4000 paths to `20 √(2/4000)`; five such deviations. The same noise twice would make
/// it 40.
#[test]
fn a_run_in_two_parts_has_the_variance_of_one() {
    let paths = 4000;
    let ends = std::sync::Mutex::new(vec![State::new([0.0], [0.0]); paths]);
    let part = |to: f64| {
        let starts = ends.lock().unwrap().clone();
        let run = Free
            .ensemble::<Midpoint>(0.5)
            .starts_from(starts)
            .seed(7)
            .until(to)
            .observe("p", |state| state.p[0]);
        let run = run.inspect(|path, state| ends.lock().unwrap()[path as usize] = *state);
        run.run().unwrap().nodes()[1].variance(0)
    };
    assert!((part(10.0) - 10.0).abs() < 50.0 * (2.0 / paths as f64).sqrt());
    let variance = part(20.0);
    assert!((variance - 20.0).abs() < 100.0 * (2.0 / paths as f64).sqrt(), "{variance}");
}

/// A run that is stopped and resumed has the noise of its times, wherever it starts; its adjoint has that of
/// the run.
#[test]
fn resumed_runs_and_adjoints_have_the_noise_of_their_times() {
    let folder = folder!("continued");
    let start = || State::new([0.2], [1.0]).at(-0.7);
    let to = |name: &str| Checkpoint::to(folder.join(name));
    let path = |steps| KUBO.simulate::<Midpoint>(0.1).start(start()).noise(StepNormals::seed(7)).steps(steps);
    path(5).checkpoint(to("path")).run().unwrap();
    assert_eq!(path(20).checkpoint(to("path")).run().unwrap().last(), path(20).run().unwrap().last());
    let paths = |paths| KUBO.ensemble::<Midpoint>(0.1).start(start()).paths(paths).seed(7).steps(20);
    paths(64).checkpoint(to("paths")).run().unwrap();
    assert!(paths(150).checkpoint(to("paths")).run().unwrap() == paths(150).run().unwrap());
    let gradient = |end: &State<_>| Gradient { q: end.q, p: 0.0 * end.p };
    assert_eq!(path(20).adjoint::<Midpoint>(gradient).unwrap().end, *path(20).run().unwrap().last());
    // Rows are given by the number of the step in the run.
    let given = KUBO.simulate::<Midpoint>(0.1).start(start()).noise(Increments::from([0.1, -0.2])).steps(2);
    assert_eq!(rows(&given.run().unwrap()), [[0.1], [-0.2]]);
}

/// Levels of a multilevel run have other noise at other times.
#[test]
fn multilevel_runs_have_the_noise_of_their_times() {
    let mean = |t: f64| {
        let run = KUBO.multilevel::<Midpoint>(0.1).start(State::new([0.2], [1.0]).at(t)).steps(10).seed(7);
        run.observe("q", |state| state.q[0]).target(0.1).run().unwrap().mean()
    };
    assert_eq!(mean(0.0), mean(0.0));
    assert!(mean(1.0) != mean(0.0) && mean(-1.0) != mean(1.0));
}

/// What drives a run may be any noise; those that are functions of time need no numbers.
#[test]
fn wiener_paths_go_on_as_before() {
    fn rows_of(noise: impl Noise, from: f64, to: f64) -> Rows {
        let start = State::new([0.0], [1.0]).at(from);
        rows(&KUBO.simulate::<Midpoint>(0.25).start(start).noise(noise).until(to).run().unwrap())
    }
    let whole = rows_of(Wiener::seed(7), -2.0, 2.0);
    assert_eq!([rows_of(Wiener::seed(7), -2.0, 0.5), rows_of(Wiener::seed(7), 0.5, 2.0)].concat(), whole);
}

/// Paths of a sweep have noises of their own; ensembles of one seed have the same ones, path by path,
/// whatever their systems.
#[test]
fn ensembles_of_one_seed_have_common_noise_and_paths_of_a_sweep_have_not() {
    let start = State::new([0.0], [1.0]);
    let replayed = |system: &Kubo, path: u64| {
        rows(&system.ensemble::<Midpoint>(0.1).start(start).paths(4).seed(7).steps(9).replay(path).unwrap().0)
    };
    let systems = [0.5, 1.0].map(|a| Kubo { a, ..KUBO });
    assert_eq!(replayed(&systems[0], 2), replayed(&systems[1], 2));
    let sweep = |path| {
        KUBO.ensemble::<Midpoint>(0.1)
            .systems_from(systems.clone())
            .start(start)
            .seed(7)
            .steps(9)
            .replay(path)
    };
    assert_ne!(rows(&sweep(0).unwrap().0), rows(&sweep(1).unwrap().0));
}

/// The double well in steps so long that some fail, and the first path from this time with this seed of which
/// some are halved.
fn halved_path(seed: u64, t: f64, steps: u64) -> (DoubleWell, u64) {
    let well = DoubleWell { sigma: 1.5 };
    let is_halved = |path: &u64| {
        let run = well.simulate::<Midpoint>(0.5).start(State::new([0.5], [2.0]).at(t)).steps(steps);
        let run =
            run.noise(StepNormals::seed(seed).path(*path).untruncated()).retry(Retry::halving(12)).run();
        run.is_ok_and(|run| run.iterations().halved > 0)
    };
    let path = (0..1000).find(is_halved).unwrap();
    (well, path)
}

/// What is looked for between the nodes is on the path with the noise of its times, also where steps are
/// halved.
#[test]
fn sections_have_the_noise_of_their_times() {
    let (t, steps) = (-7.5, 20);
    let (well, halved) = halved_path(4, t, steps);
    let start = || State::new([0.5], [2.0]).at(t);
    let all = well.ensemble::<Midpoint>(0.5).start(start()).paths(halved + 1).seed(4).steps(steps);
    let all = all.truncation(Truncation::Off);
    let all = all.retry(Retry::halving(12)).section(|state| state.p[0]).keep_crossings(1000).run().unwrap();
    for path in [0, halved] {
        let alone = well
            .simulate::<Midpoint>(0.5)
            .start(start())
            .noise(StepNormals::seed(4).path(path).untruncated());
        let alone = alone.steps(steps).retry(Retry::halving(12)).section(|state| state.p[0]).run().unwrap();
        let expected: Vec<f64> = alone.crossings().iter().map(|crossing| crossing.state.t).collect();
        let found =
            all.crossings()[0].iter().filter(|crossing| crossing.path == path).map(|crossing| crossing.t);
        let found: Vec<f64> = found.collect();
        assert_eq!(found.len(), expected.len(), "path {path}");
        // Single paths sum with care, and the motion multiplies the difference.
        assert!(
            found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-4),
            "{path}: {found:?} {expected:?}"
        );
    }
}
