//! Ensembles: the same bits however they are split, and the moments that are known exactly.

mod lanes;

use fixtures::edge::Edge;
use fixtures::small::{DoubleWell, KUBO, Kubo, kubo_run};
use fixtures::stepped::{every_split, stepped};
use std::sync::Mutex;

use wzvi::ensemble::Statistics;
use wzvi::error::{ConfigError, Error, StepFailure};
use wzvi::increments::{Interval, NoiseError};
use wzvi::nalgebra;
use wzvi::noise::Truncation;
use wzvi::prelude::*;

/// Two coupled degrees of freedom, functions, two noises: a Newton block of several unknowns.
#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u + v * v) - x.cos() - (y - x).cos() + (0.1 * x * v).exp(),
    noise = [|[x, y], [u, v]| s * (x * u).sin(), |[x, y], [u, v]| s * y * v],
    embedding = [Midpoint, Corrected<DeltaPlus>],
)]
pub struct Coupled {
    pub s: f64,
}

/// What is observed where nothing is asked for has the names of the closure, as the table of a path has.
#[test]
fn default_observables_have_the_names_of_the_closure() {
    let coupled = Coupled { s: 0.1 };
    let start = State::new([0.1, 0.2], [0.3, 0.4]);
    let run = coupled.ensemble::<Midpoint>(0.1).start(start).paths(1).seed(1).steps(0).run().unwrap();
    assert_eq!(run.observables(), ["x", "y", "u", "v", "energy"]);
    assert_eq!([run.mean("y").unwrap(), run.mean("u").unwrap()], [0.2, 0.3]);
}

#[test]
fn every_split_gives_the_same_bits() {
    let all = every_split(|| kubo_run(0.05).paths(1101).seed(3).steps(37).record_every(10));
    assert_eq!(all.nodes().len(), 5);
    assert!(all.nodes().iter().all(|node| node.count() == 1101));
    let well = DoubleWell { sigma: 0.3 };
    every_split(|| {
        well.ensemble::<Midpoint>(0.01).start(State::new([0.5], [0.5])).paths(155).seed(4).steps(50)
    });
    let coupled = Coupled { s: 0.4 };
    let start = || State::new([0.3, -0.2], [0.5, 0.1]);
    every_split(|| coupled.ensemble::<Midpoint>(0.05).start(start()).paths(140).seed(5).steps(25));
    every_split(|| {
        coupled.ensemble::<Corrected<DeltaPlus>>(0.05).start(start()).paths(140).seed(5).steps(25)
    });
}

/// Steps so long that some need the careful way, or have no solution: still the same bits.
#[test]
fn hard_steps_and_failures_are_the_same_in_every_split() {
    let well = DoubleWell { sigma: 1.5 };
    let hard = every_split(|| {
        well.ensemble::<Midpoint>(0.5)
            .start(State::new([0.5], [2.0]))
            .paths(270)
            .seed(4)
            // Else such steps are refused.
            .truncation(Truncation::Off)
            .allow_losses(1.0)
            .steps(20)
            .record_every(10)
    });
    assert!(hard.last().unwrap().count() + hard.failed() == 270 && hard.failed() > 0);
    let edge = Edge { a: 1.0, sigma: 1.0 };
    let run = every_split(|| {
        edge.ensemble::<DeltaPlus>(0.1)
            .start(State::new([1.0], [0.0]))
            .paths(600)
            .seed(1)
            .allow_losses(1.0)
            .steps(30)
            .record_every(3)
            .observe("observable0", |state| state.q[0])
            .observe("observable1", |state| state.p[0])
    });
    assert!(run.failed() > 0 && run.failed() < 600, "{}", run.failed());
    assert_eq!(run.failures().len() as u64, run.failed());
    assert!(run.failures().windows(2).all(|pair| pair[0].path < pair[1].path));
    for failure in run.failures() {
        assert!(failure.path < 700 && failure.error.step < 30, "{failure:?}");
        assert_eq!(failure.error.cause, StepFailure::NonFinite);
        assert_eq!(failure.error.t, failure.error.step as f64 * 0.1);
    }
    assert_eq!(run.last().unwrap().count(), 600 - run.failed());
    let counts: Vec<u64> = run.nodes().iter().map(|node| node.count()).collect();
    assert!(counts.windows(2).all(|pair| pair[0] >= pair[1]), "{counts:?}");
}

/// `E z(t) = e^{-σ²t/2} R(at) z(0)` and `|z| = 1`: five standard errors, exceeded once in two million. At this step the
/// weak error of the scheme, about `0.4 h`, is one of them.
#[test]
fn kubo_has_its_exact_moments() {
    let run = kubo_run(0.01).paths(20_000).seed(1).until(1.0);
    let run = run.observe("q", |state| state.q[0]).observe("p", |state| state.p[0]);
    let run = run.observe("observable2", |state| state.q[0].powi(2) + state.p[0].powi(2)).run().unwrap();
    let decay = (-0.5f64).exp();
    for (name, exact) in [("q", decay * 1.5f64.sin()), ("p", decay * 1.5f64.cos())] {
        let (mean, error) = (run.mean(name).unwrap(), run.standard_error(name).unwrap());
        assert!((mean - exact).abs() < 5.0 * error, "{name}: {mean} ± {error}, exactly {exact}");
        // Var = (1 - e^{-2})/2 of the fast angle and so on: between 0 and 1.
        assert!(error > 1e-3 && error < 1e-2, "{error}");
    }
    assert_eq!(run.observables(), ["q", "p", "observable2"]);
    assert!((run.mean("observable2").unwrap() - 1.0).abs() < 1e-12);
    let end = run.last().unwrap();
    assert_eq!((end.count(), end.time()), (20_000, 1.0));
    // q² + p² = 1 links the second moments.
    let second = end.variance(0) + end.mean(0).powi(2) + end.variance(1) + end.mean(1).powi(2);
    assert!((second - 1.0).abs() < 1e-3, "{second}");
    assert_eq!(end.covariance(0, 1), end.covariance(1, 0));
    assert!(run.mean("nothing").is_err());
}

#[test]
fn what_makes_no_sense_is_refused() {
    let base = || kubo_run(0.01).paths(4).seed(1).steps(2);
    assert!(base().run().is_ok());
    let config = |outcome: Result<Statistics, Error>| matches!(outcome, Err(Error::Config(_)));
    assert!(
        config(base().paths(0).run()) && config(base().threads(0).run()) && config(base().until(-1.0).run())
    );
    assert!(matches!(base().truncation(wzvi::noise::Truncation::On(0.5)).run(), Err(Error::Noise(_))));
    let short = kubo_run(0.01).paths(4).noise(Increments::from([0.1])).steps(2).run();
    assert!(matches!(short, Err(Error::Noise(_))), "{short:?}");
    let without_seed = kubo_run(0.01).paths(4).steps(2).run();
    assert!(matches!(without_seed, Err(Error::Config(ConfigError::Missing(_)))));
    let zero_step = kubo_run(0.0).paths(4).seed(1).steps(2).run();
    assert_eq!(zero_step, Err(Error::Config(ConfigError::StepSize(0.0))));
    let edge = Edge { a: 1.0, sigma: 0.0 };
    let all_fail =
        edge.ensemble::<DeltaPlus>(0.1).start(State::new([-1.0], [0.0])).paths(20).seed(1).steps(3).run();
    assert!(matches!(all_fail, Err(Error::Step(error)) if error.step == 0), "{all_fail:?}");
}

/// Given numbers are those of all paths, in every split, and a seed is that of the noise with a name.
#[test]
fn given_numbers_and_seeds_drive_an_ensemble() {
    let (run, given) = (|| kubo_run(0.1).paths(37).steps(20), Increments::from([0.3, -0.1].repeat(10)));
    let all = every_split(|| run().noise(given.clone()).keep_paths(1 << 20));
    let alone = stepped::<Midpoint, _>(&KUBO, 0.1, State::new([0.0], [1.0]), given.clone(), 20);
    let end = [alone.nodes[20].q[0], alone.nodes[20].p[0]];
    for path in [0, 1, 36] {
        assert_eq!(all.paths().unwrap().at(path, 1).unwrap()[..2], end);
    }
    assert!(run().seed(7).run().unwrap() == run().noise(StepNormals::seed(7)).run().unwrap());
    let antithetic = run().noise(StepNormals::seed(7).antithetic()).paths(36).run().unwrap();
    assert!(antithetic == run().seed(7).antithetic().paths(36).run().unwrap());
}

/// A path alone is the path of the ensemble, to the last bit, and it ends with the same error.
#[test]
fn a_path_is_replayed() {
    let coupled = Coupled { s: 0.4 };
    let start = || State::new([0.3, -0.2], [0.5, 0.1]);
    let run =
        || coupled.ensemble::<Midpoint>(0.05).start(start()).paths(40).seed(5).steps(25).record_every(1);
    let all = run().keep_paths(1 << 20).run().unwrap();
    for path in [0, 7, 39] {
        let (replayed, error) = run().replay(path).unwrap();
        assert!(error.is_none() && replayed.len() == 26);
        for (node, state) in replayed.iter().enumerate() {
            let kept = all.paths().unwrap().at(path as usize, node).unwrap();
            assert_eq!(kept[..4], [state.q[0], state.q[1], state.p[0], state.p[1]], "{path} {node}");
        }
        // Its increments are those of the noise with a name.
        let mut noise = StepNormals::seed(5).path(path);
        noise.prepare(&<Coupled as Discretized<Midpoint>>::PLAN, 0.05, 2, 0.0).unwrap();
        let mut dw = [0.0; 2];
        for (step, row) in (0..).zip(replayed.increments()) {
            noise.increments(&Interval { start: 0.0, h: 0.05, step }, &mut dw).unwrap();
            assert_eq!(row, dw);
        }
    }
    assert!(matches!(run().replay(40), Err(Error::Config(_))));
    let edge = Edge { a: 1.0, sigma: 1.0 };
    let run = || edge.ensemble::<DeltaPlus>(0.1).start(State::new([1.0], [0.0])).paths(100).seed(1).steps(30);
    let all = run().antithetic().allow_losses(1.0).run().unwrap();
    for failure in &all.failures()[..4] {
        let (replayed, error) = run().antithetic().replay(failure.path).unwrap();
        assert_eq!((error, replayed.steps()), (Some(failure.error.into()), failure.error.step));
    }
}

/// Steps that fail are halved on the same path, in every split; those paths that do not fail keep their bits.
#[test]
fn failing_steps_are_halved() {
    let well = DoubleWell { sigma: 1.5 };
    let run = || {
        let run = well.ensemble::<Midpoint>(0.5).start(State::new([0.5], [2.0])).paths(30).seed(4).steps(60);
        run.truncation(Truncation::Off)
    };
    let whole = run().allow_losses(1.0).keep_paths(1 << 20).run().unwrap();
    assert!(whole.failed() > 1, "{}", whole.failed());
    let halved = every_split(|| run().retry(Retry::halving(12)).keep_paths(1 << 20));
    assert_eq!(halved.failed(), 0);
    for path in 0..30 {
        let kept = whole.paths().unwrap().at(path, 1).unwrap();
        if !kept[0].is_nan() {
            assert_eq!(kept, halved.paths().unwrap().at(path, 1).unwrap());
        }
    }
    // The noise with a name is halved just so, in a single path: the same increments, summed.
    let failure = whole.failures()[0];
    let (replayed, error) = run().retry(Retry::halving(12)).record_every(1).replay(failure.path).unwrap();
    let single = well.simulate::<Midpoint>(0.5).start(State::new([0.5], [2.0])).steps(60);
    let single = single
        .noise(StepNormals::seed(4).path(failure.path).untruncated())
        .retry(Retry::halving(12))
        .run()
        .unwrap();
    assert!(error.is_none() && single.iterations().halved > 0);
    // The halves round where their sum does not.
    for (a, b) in replayed.increments().zip(single.increments()) {
        assert!((a[0] - b[0]).abs() < 1e-12, "{a:?} {b:?}");
    }
}

/// Nodes of a path of one degree of freedom.
type Nodes = Vec<[f64; 2]>;

/// All steps by a stepper, with the increments that it had.
fn by_hand<N: Noise>(mut noise: N, steps: u64, is_plain: bool) -> (Nodes, Vec<f64>) {
    noise.prepare(&<Kubo as Discretized<Midpoint>>::PLAN, 0.1, 1, 0.0).unwrap();
    let (mut state, mut nodes, mut rows) = (State::new([0.0], [1.0]), vec![[0.0, 1.0]], Vec::new());
    let mut plain = KUBO.stepper::<Midpoint>(0.1).unwrap().plain();
    let mut usual = KUBO.stepper::<Midpoint>(0.1).unwrap();
    for step in 0..steps {
        let mut dw = [0.0];
        noise.increments(&Interval { start: 0.0, h: 0.1, step }, &mut dw).unwrap();
        let outcome = if is_plain { plain.step(&mut state, &dw) } else { usual.step(&mut state, &dw) };
        outcome.unwrap();
        nodes.push([state.q[0], state.p[0]]);
        rows.push(dw[0]);
    }
    (nodes, rows)
}

/// The same increments lead every runner to the same nodes, bit for bit: a loop by hand, a simulation with the noise, with the rows
/// of numbers and with halvings that it does not need, an ensemble that keeps, shows or replays its paths, and a measurement.
#[test]
fn every_runner_takes_the_same_steps() {
    const STEPS: u64 = 23;
    fn check<N>(noise: impl Fn(u64) -> N)
    where
        N: wzvi::noise::Paths + Clone + Send + Sync,
    {
        let start = || State::new([0.0], [1.0]);
        let nodes = |states: &[State<nalgebra::SVector<f64, 1>>]| -> Nodes {
            states.iter().map(|state| [state.q[0], state.p[0]]).collect()
        };
        let ensemble = || {
            let run = kubo_run(0.1).paths(37).steps(STEPS).record_every(1);
            run.noise(noise(0))
        };
        let kept = every_split(|| ensemble().keep_paths(1 << 20));
        let halved = ensemble().retry(Retry::halving(4)).keep_paths(1 << 20).run().unwrap();
        assert!(kept.paths() == halved.paths());
        let shown = Mutex::new(vec![Vec::new(); 37]);
        let see = |path: u64, state: &State<nalgebra::SVector<f64, 1>>| {
            shown.lock().unwrap()[path as usize].push([state.q[0], state.p[0]]);
        };
        assert!(ensemble().inspect(see).run().unwrap().nodes() == kept.nodes());
        let shown = shown.into_inner().unwrap();
        for path in [0, 1, 17, 36] {
            let (expected, rows) = by_hand(noise(path), STEPS, false);
            let run = || KUBO.simulate::<Midpoint>(0.1).start(start()).steps(STEPS);
            assert_eq!(nodes(run().noise(noise(path)).run().unwrap().states()), expected);
            assert_eq!(nodes(run().noise(Increments::from(rows)).run().unwrap().states()), expected);
            let halving = run().noise(noise(path)).retry(Retry::halving(4)).run().unwrap();
            assert_eq!(nodes(halving.states()), expected);
            let mut seen = Vec::new();
            let sparse = run().noise(noise(path)).record_every(0).inspect(
                |state: &State<nalgebra::SVector<f64, 1>>, _: &wzvi::simulate::Node<'_>| {
                    seen.push([state.q[0], state.p[0]]);
                },
            );
            assert_eq!(sparse.run().unwrap().len(), 2);
            assert_eq!(seen, expected);
            let (expected, _) = by_hand(noise(path), STEPS, true);
            assert_eq!(shown[path as usize], expected);
            let (replayed, error) = ensemble().replay(path).unwrap();
            assert!(error.is_none() && nodes(replayed.states()) == expected);
            for (node, expected) in expected.iter().enumerate() {
                assert_eq!(kept.paths().unwrap().at(path as usize, node).unwrap()[..2], expected[..]);
            }
        }
    }
    check(|path| Wiener::seed(7).path(path));
    check(|path| StepNormals::seed(7).path(path));
    check(|path| WongZakai::averaged(0.2).seed(7).path(path));
}

/// A noise that has no increments for some paths.
#[derive(Clone)]
struct Fails {
    path: u64,
    from: u64,
}

impl Noise for Fails {
    fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        dw.fill(0.01);
        if self.path >= self.from && interval.step >= 3 {
            return Err(NoiseError::Exhausted { step: interval.step, available: self.path as usize });
        }
        Ok(())
    }
}

impl wzvi::noise::Paths for Fails {
    fn set_path(&mut self, path: u64) {
        self.path = path;
    }
}

/// A noise that fails ends the run with the error of the first such path, whatever the threads: no path goes on with old increments.
#[test]
fn a_noise_that_fails_ends_the_run() {
    for threads in [1, 2, 5] {
        let run = kubo_run(0.1).paths(5000).steps(10);
        let outcome = run.noise(Fails { path: 0, from: 1300 }).threads(threads).run();
        let expected = NoiseError::Exhausted { step: 3, available: 1300 };
        // What is asked for before the first step is the last increment of path 0.
        assert_eq!(outcome.unwrap_err(), Error::Noise(expected));
    }
    let run = kubo_run(0.1).paths(5000).steps(10);
    let (path, error) = run.noise(Fails { path: 0, from: 1300 }).replay(4000).unwrap();
    assert_eq!(path.steps(), 3);
    assert_eq!(error, Some(Error::Noise(NoiseError::Exhausted { step: 3, available: 4000 })));
}

/// A measurement has the errors of the paths of the ensemble with the same Wiener paths.
#[test]
fn a_measurement_is_of_the_same_paths() {
    let report = KUBO
        .work_precision()
        .start(State::new([0.0], [1.0]))
        .until(2.0)
        .step_sizes([0.1])
        .paths(40)
        .seed(7)
        .repetitions(0)
        .value(State::new([0.0], [0.0]))
        .scheme::<Midpoint>()
        .run()
        .unwrap();
    let cell = &report.cells[0];
    assert_eq!(cell.path_numbers, (0..40).collect::<Vec<_>>());
    for (path, error) in (0..).zip(&cell.errors) {
        let (nodes, _) = by_hand(Wiener::seed(7).path(path), 20, true);
        let [q, p] = nodes[20];
        assert_eq!(*error, (q * q + p * p).sqrt(), "path {path}");
    }
}
