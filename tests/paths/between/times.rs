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
        let run = Oscillator.simulate::<Verlet>(0.25).start(start()).until(1.1);
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
    let exactly = Oscillator.simulate::<Verlet>(0.25).start(start()).until(1.1).exactly();
    are_refused(exactly.record_at([1.2]).run(), "between 0 and 1.1");
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
fn ends_are_exact_where_that_is_asked_for() {
    let run = |end: f64| Oscillator.simulate::<Gauss<8>>(0.3).start(start()).until(end);
    let path = run(2.0).exactly().run().unwrap();
    assert_eq!((path.last().t, path.steps(), path.len()), (2.0, 7, 8));
    assert!((path.last().q[0] - 2.0_f64.cos()).abs() < 1e-14);
    // Without it, as ever.
    assert_eq!(run(2.0).run().unwrap().last().t, 0.3 * 7.0);
    // Nodes before it are those of any run.
    assert_eq!(path.states()[..7], run(2.0).run().unwrap().states()[..7]);
    // An end that is a node up to rounding has the time that was asked for.
    let path = Oscillator.simulate::<Gauss<8>>(0.1).start(start()).until(0.3).exactly().run().unwrap();
    assert_eq!((path.last().t, path.steps()), (0.3, 3));
    assert_eq!(0.1 * 3.0, 0.30000000000000004);
    // Shorter than a step, nothing, and backwards.
    assert_eq!(run(0.1).exactly().run().unwrap().last().t, 0.1);
    assert_eq!(run(0.0).exactly().run().unwrap().last().t, 0.0);
    let back = Oscillator.simulate::<Gauss<8>>(-0.3).start(start()).until(-1.0).exactly().run().unwrap();
    assert!(back.last().t == -1.0 && (back.last().q[0] - 1.0_f64.cos()).abs() < 1e-14);
    // Recorded times in the last step.
    let path = run(2.0).exactly().record_at([1.85, 1.95, 2.0]).run().unwrap();
    assert_eq!(path.times().collect::<Vec<_>>(), [0.0, 1.85, 1.95, 2.0]);
    assert!(path.iter().all(|state| (state.q[0] - state.t.cos()).abs() < 1e-12));
    are_refused(
        Oscillator.simulate::<Verlet>(0.3).start(start()).steps(3).exactly().run(),
        "`.until(time).exactly()`",
    );
    are_refused(run(f64::NAN).exactly().run(), "NaN");
    are_refused(run(-1.0).exactly().run(), "-1");
}

/// The increments of the shorter step are those of its interval.
#[test]
fn noise_ends_with_the_path() {
    let run = || Shaken.simulate::<Midpoint>(0.3).start(start()).until(1.0).exactly();
    let path = run().noise(Wiener::seed(5)).run().unwrap();
    for k in 0..2 {
        let mut wiener = Wiener::seed(5);
        assert!((path.wiener(k).last().unwrap() - wiener.value(k, 1.0).unwrap()).abs() < 1e-14);
    }
    // The path is that of its increments.
    let rows: Vec<Vec<f64>> = path.increments().map(<[f64]>::to_vec).collect();
    assert_eq!(run().noise(Increments::from(rows.clone())).run().unwrap(), path);
    let error = run().noise(Increments::from(rows[..3].to_vec())).run().unwrap_err();
    assert_eq!(error, wzvi::Error::Noise(NoiseError::Exhausted { step: 3, available: 3 }));
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
        matches!(&error, wzvi::Error::Noise(NoiseError::Setting(text)) if text.contains("exactly")),
        "{error}"
    );
    assert!(Shaken.simulate::<Midpoint>(0.25).start(start()).until(1.0).exactly().noise(Steps).run().is_ok());
}

/// A step of its own size is a step of the scheme: the order stays.
#[test]
fn the_last_step_is_one_of_the_scheme() {
    let error = |h: f64| {
        let path = Pendulum.simulate::<Composed<Verlet, KahanLi8>>(h).start(State::new([2.0], [0.0]));
        let path = path.until(4.0 * Pendulum::quarter(2.0)).exactly().run().unwrap();
        (path.last().q[0] - 2.0).abs().max(path.last().p[0].abs())
    };
    assert!(error(0.25) < 1e-6 && error(0.0625) < 1e-11, "{:e} {:e}", error(0.25), error(0.0625));
    assert!(matches!(
        Pendulum.simulate::<Verlet>(0.1).start(start()).exactly().run(),
        Err(wzvi::Error::Config(ConfigError::Missing(_)))
    ));
}
