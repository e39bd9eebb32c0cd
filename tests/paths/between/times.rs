//! Recorded times between the nodes, and ends at them.

use fixtures::small::Pendulum;
use wzvi::error::{ConfigError, NoiseError};
use wzvi::increments::Interval;
use wzvi::prelude::*;

use super::systems::{Oscillator, Shaken, V1, start};
use fixtures::are_refused;

/// `Gauss<8>` with h = 0.25: the collocation polynomial has the error `h^9 / (4^9 9!)`-like, below 1e-13.
#[test]
fn recorded_times_are_on_the_path() {
    let times = [0.1, 0.25, 0.26, 0.3, 1.0, 2.72, 4.999];
    let run = || Oscillator.simulate::<Gauss<8>>(0.25).start(start()).until(5.0);
    let path = run().record_at(times).observe("q", |state| state.q[0]).run().unwrap();
    let all = run().run().unwrap();
    assert_eq!(path.times().collect::<Vec<_>>(), [0.0, 0.1, 0.25, 0.26, 0.3, 1.0, 2.72, 4.999, 5.0]);
    for (state, q) in path.iter().zip(path.observed("q").unwrap()) {
        assert!((state.q[0] - state.t.cos()).abs() < 1e-12 && (state.p[0] + state.t.sin()).abs() < 1e-12);
        assert_eq!(*q, state.q[0]);
    }
    // Nodes are what they are, to the bit.
    let states = path.states();
    assert_eq!([states[2], states[5]], [all.states()[1], all.states()[4]]);
    assert_eq!(path.last(), all.last());
    assert!(path.time_scale().is_err());
    // Beside regular nodes.
    let path = run().record_at([0.6]).record_every(1).run().unwrap();
    assert_eq!(path.len(), all.len() + 1);
    assert!(path.euler_lagrange_residual(&Oscillator).is_err());
    // Backwards.
    let path =
        Oscillator.simulate::<Gauss<8>>(-0.25).start(start()).until(-1.0).record_at([-0.3, -0.9]).run();
    assert!(path.unwrap().iter().all(|state| (state.q[0] - state.t.cos()).abs() < 1e-12));
}

#[test]
fn times_that_make_no_sense_are_refused() {
    let run = |times: &[f64]| {
        let run = Oscillator.simulate::<Verlet>(0.25).start(start()).until(1.1).whole_steps();
        run.record_at(times.to_vec()).run()
    };
    are_refused(run(&[0.5, 0.3]), "t = 0.3 after t = 0.5");
    are_refused(run(&[0.3, 0.3]), "each once");
    are_refused(run(&[f64::NAN]), "NaN");
    are_refused(run(&[-0.1]), "-0.1");
    are_refused(run(&[f64::INFINITY]), "inf");
    // The last node is the first one beyond the end.
    assert!(run(&[1.2]).is_ok());
    are_refused(run(&[1.26]), "between 0 and 1.25");
    let to_the_end = Oscillator.simulate::<Verlet>(0.25).start(start()).until(1.1);
    are_refused(to_the_end.record_at([1.2]).run(), "between 0 and 1.1");
}

/// Increments are cut where the states are: each `W_k` is a straight line between nodes.
#[test]
fn increments_are_cut_with_the_path() {
    let run = || Shaken.simulate::<Midpoint>(0.1).start(start()).noise(Wiener::seed(3)).steps(10);
    let (path, all) = (run().record_at([0.13, 0.17, 0.2, 0.55]).run().unwrap(), run().run().unwrap());
    for k in 0..2 {
        let (w, nodes) = (path.wiener(k), all.wiener(k));
        let line = |t: f64| {
            let n = (10.0 * t) as usize;
            nodes[n] + (10.0 * t - n as f64) * (nodes[n + 1] - nodes[n])
        };
        for (w, expected) in w.iter().zip([0.0, line(0.13), line(0.17), nodes[2], line(0.55), nodes[10]]) {
            assert!((w - expected).abs() < 1e-14, "{w} {expected}");
        }
    }
}

/// With noise, too, the stages of a step are at hand: the polynomial has the flow of the frozen step Hamiltonian, here that of a rotation by
/// `h + 0.4 ΔW_1` about the point that the second noise has moved.
#[test]
fn dense_output_with_noise_follows_the_frozen_step() {
    fn inside<E>(h: f64, dw: [f64; 2]) -> Vec<State<V1>>
    where
        Shaken: Discretized<E, Vector = V1>,
    {
        let run = Shaken.simulate::<E>(h).start(start()).noise(Increments::from([dw])).steps(1);
        run.record_at([0.025, 0.05, 0.075]).run().unwrap().states().to_vec()
    }
    let (h, dw) = (0.1, [0.21, -0.3]);
    // Step Hamiltonian: a (p² + q²)/2 + b q, with the centre of rotation at q = -b/a.
    let (a, b) = (h + 0.4 * dw[0], 0.3 * dw[1]);
    for (states, tolerance) in [(inside::<Midpoint>(h, dw), 1e-3), (inside::<Gauss<2>>(h, dw), 1e-4)] {
        for state in states {
            let (sin, cos) = (a * state.t / h).sin_cos();
            let [q, p] = [(1.0 + b / a) * cos - b / a, -(1.0 + b / a) * sin];
            let error = (state.q[0] - q).hypot(state.p[0] - p);
            // The mid-point errs by a³/12, the collocation polynomial of two stages by a³/72 or so inside.
            assert!(error < tolerance, "{tolerance} {}: {error:e}", state.t);
        }
    }
}

#[test]
fn runs_end_where_they_are_told() {
    let run = |end: f64| Oscillator.simulate::<Gauss<8>>(0.3).start(start()).until(end);
    let path = run(2.0).run().unwrap();
    assert_eq!((path.last().t, path.steps(), path.len()), (2.0, 7, 8));
    assert!((path.last().q[0] - 2.0_f64.cos()).abs() < 1e-14);
    // In whole steps, at the first node at or beyond it.
    let whole = run(2.0).whole_steps().run().unwrap();
    assert_eq!(whole.last().t, 0.3 * 7.0);
    assert_eq!(run(1.8).whole_steps().run().unwrap().steps(), 6);
    // Nodes before it are those of any run.
    assert_eq!(path.states()[..7], whole.states()[..7]);
    // An end that is a node up to rounding has the time that was asked for.
    let path = Oscillator.simulate::<Gauss<8>>(0.1).start(start()).until(0.3).run().unwrap();
    assert_eq!((path.last().t, path.steps()), (0.3, 3));
    assert_eq!(0.1 * 3.0, 0.30000000000000004);
    // Shorter than a step, nothing, and backwards.
    assert_eq!(run(0.1).run().unwrap().last().t, 0.1);
    assert_eq!(run(0.0).run().unwrap().last().t, 0.0);
    let back = Oscillator.simulate::<Gauss<8>>(-0.3).start(start()).until(-1.0).run().unwrap();
    assert!(back.last().t == -1.0 && (back.last().q[0] - 1.0_f64.cos()).abs() < 1e-14);
    // Recorded times in the last step.
    let path = run(2.0).record_at([1.85, 1.95, 2.0]).run().unwrap();
    assert_eq!(path.times().collect::<Vec<_>>(), [0.0, 1.85, 1.95, 2.0]);
    assert!(path.iter().all(|state| (state.q[0] - state.t.cos()).abs() < 1e-12));
    // The end is the one that was asked for, also beside regular nodes and with an observer.
    let mut seen = 0.0;
    let path = run(0.9).record_every(1).inspect(|state, _| seen = state.t).run().unwrap();
    assert_eq!((path.last().t, path.states()[3].t, seen, path.steps()), (0.9, 0.9, 0.9, 3));
    assert_eq!(0.3 * 3.0, 0.899_999_999_999_999_9);
    let path = Oscillator.simulate::<Verlet>(0.3).start(start()).steps(3).whole_steps().run().unwrap();
    assert_eq!(path.steps(), 3);
    are_refused(run(f64::NAN).run(), "NaN");
    are_refused(run(-1.0).run(), "-1");
}

/// Asserts that the noise of a run refuses to drive it, in these words.
fn noise_refuses<T>(run: Result<T, wzvi::Error>, words: &str) {
    match run {
        Err(wzvi::Error::Noise(error)) => assert!(error.to_string().contains(words), "{words}: {error}"),
        other => panic!("{words}: {:?}", other.err()),
    }
}

/// The increments of the shorter step are those of its interval.
#[test]
fn noise_ends_with_the_path() {
    let run = || Shaken.simulate::<Midpoint>(0.3).start(start()).until(1.0);
    let path = run().noise(Wiener::seed(5)).run().unwrap();
    for k in 0..2 {
        let mut wiener = Wiener::seed(5);
        assert!((path.wiener(k).last().unwrap() - wiener.value(k, 1.0).unwrap()).abs() < 1e-14);
    }
    // The path of whole steps is that of its increments; no row belongs to a shorter step.
    let whole = || run().whole_steps();
    let path = whole().noise(Wiener::seed(5)).run().unwrap();
    let rows: Vec<Vec<f64>> = path.increments().map(<[f64]>::to_vec).collect();
    assert_eq!(whole().noise(Increments::from(rows.clone())).run().unwrap(), path);
    let error = whole().noise(Increments::from(rows[..3].to_vec())).run().unwrap_err();
    assert_eq!(error, wzvi::Error::Noise(NoiseError::Exhausted { step: 3, available: 3 }));
    let given = || Increments::from(rows.clone());
    noise_refuses(run().noise(given()).run(), "add `.whole_steps()` to end at t = 1.2, or end at t = 0.9");
    let many = Shaken.ensemble::<Midpoint>(0.3).start(start()).until(1.0).noise(given()).paths(2);
    noise_refuses(many.run(), "`.whole_steps()`");
    assert!(run().until(0.9).noise(given()).run().is_ok());
    // Normals of their own have the variance of the shorter step.
    let n = 4000;
    let last = |path: u64| {
        let path = run().noise(StepNormals::seed(1).path(path)).run().unwrap();
        path.increments().last().unwrap()[0]
    };
    let variance = (0..n).map(|path| last(path).powi(2)).sum::<f64>() / n as f64;
    // Four standard errors of a chi-squared mean.
    assert!((variance / 0.1 - 1.0).abs() < 4.0 * (2.0 / n as f64).sqrt(), "{variance}");
    let averaged = run().noise(WongZakai::averaged(0.3).exact().seed(5)).run().unwrap();
    assert_eq!(averaged.last().t, 1.0);

    /// It knows its steps only.
    struct Steps;
    impl Noise for Steps {
        fn increments(&mut self, _: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
            dw.fill(0.1);
            Ok(())
        }
    }
    let error = run().noise(Steps).run().unwrap_err();
    assert!(
        matches!(&error, wzvi::Error::Noise(NoiseError::Setting(text)) if text.contains("`.whole_steps()`")),
        "{error}"
    );
    assert!(Shaken.simulate::<Midpoint>(0.25).start(start()).until(1.0).noise(Steps).run().is_ok());
}

/// A step of its own size is a step of the scheme: the order stays.
#[test]
fn the_last_step_is_one_of_the_scheme() {
    let error = |h: f64| {
        let path = Pendulum.simulate::<Composed<Verlet, KahanLi8>>(h).start(State::new([2.0], [0.0]));
        let path = path.until(4.0 * Pendulum::quarter(2.0)).run().unwrap();
        (path.last().q[0] - 2.0).abs().max(path.last().p[0].abs())
    };
    assert!(error(0.25) < 1e-6 && error(0.0625) < 1e-11, "{:e} {:e}", error(0.25), error(0.0625));
    assert!(matches!(
        Pendulum.simulate::<Verlet>(0.1).start(start()).whole_steps().run(),
        Err(wzvi::Error::Config(ConfigError::Missing(_)))
    ));
}

/// Derivatives of an end inside a step are those of the run, by differences of `1e-5`: the third derivative by the step size, whose ten steps have a
/// third power of their number, leaves `1e-10` times some tens.
#[test]
fn ends_inside_steps_have_derivatives() {
    let run = |q: f64, h: f64| Pendulum.simulate::<Verlet>(h).start(State::new([q], [0.3])).until(1.05);
    let tangent = run(2.0, 0.1).tangent_by(&[]).unwrap();
    assert_eq!((tangent.end.t, tangent.end.q), (1.05, run(2.0, 0.1).plain_sums().run().unwrap().last().q));
    let d = 1e-5;
    let slope = |[below, above]: [(f64, f64); 2]| {
        let [below, above] = [below, above].map(|(q, h)| *run(q, h).run().unwrap().last());
        [(above.q - below.q) / (2.0 * d), (above.p - below.p) / (2.0 * d)].map(|slope| slope[0])
    };
    let by_start = slope([(2.0 - d, 0.1), (2.0 + d, 0.1)]);
    let by_step_size = slope([(2.0, 0.1 - d), (2.0, 0.1 + d)]);
    for i in 0..2 {
        assert!((tangent.by_start[(i, 0)] - by_start[i]).abs() < 1e-8, "{i}: {tangent:?} {by_start:?}");
        let own = tangent.by_step_size.as_ref().unwrap()[i];
        assert!((own - by_step_size[i]).abs() < 1e-8, "{i}: {tangent:?} {by_step_size:?}");
    }
    let gradient = |end: &State<V1>| wzvi::system::Gradient { q: V1::new(1.0) + 0.0 * end.q, p: 0.0 * end.p };
    let adjoint = run(2.0, 0.1).adjoint::<Verlet>(gradient).unwrap();
    assert!((adjoint.by_start.q[0] - tangent.by_start[(0, 0)]).abs() < 1e-14);
    assert!((adjoint.by_start.p[0] - tangent.by_start[(0, 1)]).abs() < 1e-14);
}

/// The shorter step is none of the equal intervals that correlations and averages are about, and one of those of the discrete principle.
#[test]
fn what_needs_equal_steps_leaves_the_shorter_one_out() {
    let run = |end: f64| {
        let run = Shaken.simulate::<Midpoint>(0.1).start(start()).noise(Wiener::seed(3)).until(end);
        run.observe("q", |state| state.q[0])
    };
    let [even, uneven] = [2000.0, 2000.06].map(|end| run(end).run().unwrap());
    assert_eq!(uneven.len(), even.len() + 1);
    let correlation = |path: &Trajectory<V1, Midpoint>| path.autocorrelation(|state| state.p[0]).unwrap();
    assert_eq!(correlation(&uneven), correlation(&even));
    assert_eq!(uneven.mean_square_displacement().unwrap(), even.mean_square_displacement().unwrap());
    assert!(matches!(uneven.time_scale(), Err(wzvi::error::PathError::Uneven { .. })));
    // Residuals of numbers of size one, each of some roundings.
    assert!(uneven.euler_lagrange_residual(&Shaken).unwrap() < 1e-13);
    let [even, uneven] = [50.0, 50.06].map(|end| run(end).time_averages().run().unwrap());
    assert_eq!(
        (uneven.averages[0].mean, uneven.averages[0].variance),
        (even.averages[0].mean, even.averages[0].variance)
    );
    assert_eq!((uneven.last.t, uneven.steps), (50.06, even.steps + 1));
    // Also where a stride does not divide the steps.
    let run =
        |steps| Oscillator.simulate::<Verlet>(0.1).start(start()).record_every(7).steps(steps).run().unwrap();
    let displacement = |steps| run(steps).mean_square_displacement().unwrap();
    assert_eq!(displacement(700).values, displacement(703).values);
}

/// An event in a last step that is shorter is a passage, with noise at its nodes and without noise inside it,
/// and its time is that of the event: the first is linear in time, the second exact to the dense output.
#[test]
fn passages_happen_in_the_shorter_step_too() {
    let noisy = Shaken.ensemble::<Midpoint>(0.1).start(start()).paths(9).seed(3).until(2.03);
    let noisy = noisy.first_passage("late", |state| state.t - 2.02).run().unwrap();
    let late = noisy.passage("late").unwrap();
    assert!(late.passed() == 9 && (late.mean() - 2.02).abs() < 1e-14, "{late}");
    let smooth = Oscillator.ensemble::<Gauss<8>>(0.25).start(start()).paths(3).until(1.6);
    let smooth = smooth.first_passage("q", |state| state.q[0]).run().unwrap();
    let quarter = smooth.passage("q").unwrap();
    assert!(
        quarter.passed() == 3 && (quarter.mean() - std::f64::consts::FRAC_PI_2).abs() < 1e-12,
        "{quarter}"
    );
}

/// A well that is driven hard: a step may have no solution.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * (q * q - 1.0) * (q * q - 1.0),
    noise = [|q, p| 0.75 * q * q * p * p],
    embedding = Midpoint,
)]
struct Hard;

/// In a well that is driven hard, in one step of 0.9, some paths need its halves: the increments of these add up to the one of the step. Paths of
/// ensembles, in lanes, are halved like those.
#[test]
fn the_last_step_is_halved_as_any_other() {
    const PATHS: u64 = 3;
    let from = State::new([0.5], [2.0]);
    let all = || {
        let run = Hard.ensemble::<Midpoint>(5.0).start(from).seed(1).truncation(wzvi::noise::Truncation::Off);
        run.paths(PATHS).until(0.9).retry(Retry::halving(12)).allow_losses(1.0)
    };
    let mut halved = 0;
    for path in 0..PATHS {
        let noise = || StepNormals::seed(1).path(path).untruncated();
        let run = || Hard.simulate::<Midpoint>(5.0).start(from).noise(noise()).until(0.9).plain_sums();
        if run().run().is_ok() {
            continue;
        }
        let Ok(path_in_halves) = run().retry(Retry::halving(12)).run() else { continue };
        halved += 1;
        assert_eq!((path_in_halves.iterations().halved, path_in_halves.last().t), (1, 0.9));
        let (mut noise, mut dw) = (noise(), [0.0]);
        noise.prepare(&<Hard as Discretized<Midpoint>>::PLAN, 5.0, 1, 0.0).unwrap();
        let interval = Interval { start: 0.0, h: 5.0, step: 0 };
        noise.increments_of_part(&interval, 0.9, &mut dw).unwrap();
        assert!((path_in_halves.wiener(0)[1] - dw[0]).abs() < 1e-13, "{path}");
        let (alone, error) = all().record_every(1).replay(path).unwrap();
        assert_eq!((error, alone.last()), (None, path_in_halves.last()), "{path}");
    }
    assert!(halved > 0);
    assert!(all().run_in::<8>().unwrap() == all().run_in::<1>().unwrap());
    // A noise that cannot halve its last step says so before the run.
    struct Linear;
    impl Noise for Linear {
        fn is_divisible(&self) -> bool {
            true
        }
        fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
            dw.fill(interval.h);
            Ok(())
        }
        fn increments_of_part(&mut self, _: &Interval, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
            dw.fill(h);
            Ok(())
        }
    }
    let run = || Shaken.simulate::<Midpoint>(0.3).start(start()).until(1.0).noise(Linear);
    assert!(run().run().is_ok());
    noise_refuses(run().retry(Retry::halving(3)).run(), "`Noise::increments_within`");
    assert!(run().whole_steps().retry(Retry::halving(3)).run().is_ok());
}

/// All levels of a multilevel run, and all step sizes of a measurement, are whole.
#[test]
fn runs_of_whole_steps_name_the_ends_nearby() {
    let levels = |end: f64| {
        let run = Shaken.multilevel::<Midpoint>(0.3).start(start()).until(end).seed(1);
        run.observe("q", |state| state.q[0]).target(0.2).run()
    };
    are_refused(levels(1.0), "end at t = 0.9 or t = 1.2");
    are_refused(levels(0.1), "end at t = 0.3");
    assert!(levels(0.9).is_ok());
    let measured = |end: f64| {
        let run = Oscillator.work_precision().start(start()).until(end).step_sizes([0.3]).scheme::<Verlet>();
        run.exact(|t, _| State::new([t.cos()], [-t.sin()])).repetitions(1).quiet().run()
    };
    are_refused(measured(1.0), "end at t = 0.9 or t = 1.2");
    assert!(measured(0.9).is_ok());
}
