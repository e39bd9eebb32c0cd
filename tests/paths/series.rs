//! Averages, correlations and temperatures along paths, against exact laws.

use std::thread::sleep;
use std::time::Duration;

use fixtures::Uniform;
use wzvi::checkpoint::Checkpoint;
use wzvi::error::{Error, PathError};
use wzvi::prelude::*;
use wzvi::series::{Autocorrelation, SeriesError};

/// A particle with friction in a bath, free or in a harmonic well.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p / m + 0.5 * k * q * q,
    friction = gamma, temperature = kt, embedding = Baoab,
)]
#[derive(Clone, Debug)]
pub(crate) struct Particle {
    pub m: f64,
    pub k: f64,
    pub gamma: f64,
    pub kt: f64,
}

const FREE: Particle = Particle { m: 0.8, k: 0.0, gamma: 0.5, kt: 1.3 };
const WELL: Particle = Particle { m: 1.0, k: 1.0, gamma: 1.0, kt: 0.7 };
const H: f64 = 0.1;

#[test]
fn the_momentum_of_a_free_particle_has_its_correlation_time() {
    let run = FREE.simulate::<Baoab>(H).start(State::new([0.0], [1.0])).noise(StepNormals::seed(3));
    let path = run.steps(1 << 18).run().expect("a path");
    // p' = a p + ...: ρ(n) = aⁿ, summed up.
    let a = (-FREE.gamma * H).exp();
    let time = H * (0.5 + a / (1.0 - a));
    let found = path.autocorrelation(|state| state.p[0]).expect("an autocorrelation");
    assert!((found.time - time).abs() < 4.0 * found.time_error, "{} {time} {}", found.time, found.time_error);
    assert!(found.time_error < 0.05 * time);
    assert!(found.mean.abs() < 4.0 * found.standard_error);
    let error = (2.0 * time * FREE.m * FREE.kt / (f64::from(1 << 18) * H)).sqrt();
    assert!((found.standard_error / error - 1.0).abs() < 0.15, "{} {error}", found.standard_error);
    for (t, rho) in found.function.points().take(40) {
        assert!((rho - (-FREE.gamma * t).exp()).abs() < 0.05, "{t} {rho}");
    }
    // The velocities, with their sizes.
    let velocities = path.velocity_autocorrelation(&FREE).expect("velocities");
    for (t, value) in velocities.points().take(40) {
        let exact = FREE.kt / FREE.m * (-FREE.gamma * t).exp();
        assert!((value - exact).abs() < 0.05 * FREE.kt / FREE.m, "{t} {value} {exact}");
    }
    // ⟨Δq²⟩ = 2 kT/(m γ²) (γt - 1 + e^{-γt}); drifts by halves follow it to (γh)²/12.
    let moved = path.mean_square_displacement().expect("displacements");
    for (t, value) in moved.points().take(60).skip(1) {
        let x = FREE.gamma * t;
        let exact = 2.0 * FREE.kt / (FREE.m * FREE.gamma.powi(2)) * (x - 1.0 + (-x).exp());
        assert!((value / exact - 1.0).abs() < 0.08, "{t} {value} {exact}");
    }
}

#[test]
fn uniform_motion_moves_by_its_square() {
    let still = Particle { gamma: 0.0, ..FREE };
    let run = still.simulate::<Baoab>(H).start(State::new([5.0], [0.4])).noise(StepNormals::seed(3));
    let run = run.steps(500).run().expect("a path");
    let moved = run.mean_square_displacement().expect("displacements");
    for (t, value) in moved.points() {
        // Squares of up to 25² lose as much to rounding.
        assert!((value - (0.5 * t).powi(2)).abs() < 500.0 * 25.0_f64.powi(2) * f64::EPSILON, "{t} {value}");
    }
    assert_eq!(moved.values[0], 0.0);
}

#[test]
fn every_degree_of_freedom_has_the_temperature() {
    let run = || WELL.simulate::<Baoab>(H).start(State::new([0.5], [0.0])).noise(StepNormals::seed(4));
    let path = run().steps(1 << 17).run().expect("a path");
    let shares = path.equipartition(&WELL);
    let x = H * H / 4.0;
    let kinetic = shares.kinetic[0];
    assert!((kinetic.temperature - WELL.kt * (1.0 - x)).abs() < 4.0 * kinetic.standard_error, "{kinetic:?}");
    let place = shares.configurational[0];
    assert!((place.temperature - WELL.kt).abs() < 4.0 * place.standard_error, "{place:?}");
    assert!(place.standard_error < 0.02 && shares.kinetic_temperature == kinetic);
    // In an ensemble the same observables.
    let run = WELL.ensemble::<Baoab>(H).start(State::new([0.5], [0.0])).paths(4000).seed(3).until(20.0);
    let statistics = run.observe_temperatures().observe_equipartition().run().expect("an ensemble");
    for name in ["kinetic temperature", "configurational temperature", "kinetic temperature 0"] {
        let (mean, error) =
            (statistics.mean(name).expect("a mean"), statistics.standard_error(name).expect("an error"));
        assert!((mean - WELL.kt).abs() < 4.0 * error + WELL.kt * x, "{name} {mean} {error}");
    }
    // The size of a slice is that of the start.
    let chain = fixtures::bath::Chain { gamma: 1.0, kt: 0.7 };
    let run = || chain.ensemble::<Baoab>(H).paths(8).seed(3).steps(2);
    let start = || State::new(vec![0.5; 3], vec![0.0; 3]);
    assert!(
        run().start(start()).observe_equipartition().run().unwrap().mean("kinetic temperature 2").is_ok()
    );
    let early = run().observe_equipartition().start(start()).run().unwrap_err().to_string();
    assert!(early.contains("call it after `.start(...)`"), "{early}");
}

#[test]
fn a_long_path_ends_when_its_average_is_exact_enough() {
    let run = |seed, target| {
        let run = WELL.simulate::<Baoab>(H).start(State::new([3.0], [0.0])).noise(StepNormals::seed(seed));
        let run = run.observe("q2", |state| state.q[0].powi(2)).steps(1 << 22).time_averages();
        run.discard(20.0).until_error("q2", target).run().expect("averages")
    };
    // Within 1.96 targets in 95 % of the runs: of 8, 4 or more outside have a chance of 0.04 %.
    let mut outside = 0;
    for seed in 0..8 {
        let averages = run(seed, 0.03);
        let average = averages.of("q2").expect("an average");
        assert!(averages.met_targets == Some(true) && average.error_bound <= 0.03);
        outside += u32::from((average.mean - WELL.kt).abs() > 1.96 * 0.03);
        // ⟨q² q²(t)⟩ has τ = ∫ ρ² = (γ² + ω²)/(2 γ ω²) = 1. The estimate is a variance of 3.2 degrees of
        // freedom or more, whose law has 1e-4 outside.
        assert!((0.005..6.7).contains(&average.time), "{}", average.time);
    }
    assert!(outside < 4, "{outside}");
    // A third of the error takes about nine times as long, where the errors of few degrees of freedom scatter
    // by half.
    let steps = [0.03, 0.01].map(|target| (0..2).map(|seed| run(seed, target).steps).sum::<u64>() as f64);
    assert!((3.0..27.0).contains(&(steps[1] / steps[0])), "{steps:?}");
    // Its limit ends it, too.
    let run = WELL.simulate::<Baoab>(H).start(State::new([3.0], [0.0])).noise(StepNormals::seed(1));
    let run = run.observe("q2", |state| state.q[0].powi(2)).steps(100).time_averages();
    let averages = run.until_error("q2", 1e-9).run().expect("averages");
    assert_eq!((averages.met_targets, averages.steps), (Some(false), 100));
}

/// Another thread stops averages: they are those of the steps that were taken, and go on from their checkpoint.
#[test]
fn a_handle_stops_averages() {
    let file = fixtures::folder!("averages").join("file");
    let run = |steps| {
        let run = WELL.simulate::<Baoab>(H).start(State::new([3.0], [0.0])).noise(StepNormals::seed(1));
        run.observe("q2", |state| state.q[0].powi(2)).steps(steps)
    };
    let kept = |steps| run(steps).checkpoint(Checkpoint::to(&file));
    let handle = Handle::new();
    let stopped = std::thread::scope(|scope| {
        scope.spawn(|| {
            while handle.progress().done < 10_000 {
                sleep(Duration::from_millis(1));
            }
            handle.stop();
        });
        kept(1 << 40).handle(&handle).time_averages().run().expect("averages")
    });
    let done = stopped.steps;
    assert!(stopped.is_partial && done >= 10_000 && handle.progress().all == 1 << 40, "{stopped:?}");
    let whole = run(done).time_averages().run().expect("averages");
    assert_eq!((whole.averages, whole.last, whole.is_partial), (stopped.averages, stopped.last, false));
    let resumed = kept(done + 5000).time_averages().run().expect("averages");
    let whole = run(done + 5000).time_averages().run().expect("averages");
    assert_eq!((whole.averages, whole.last), (resumed.averages, resumed.last));
    let none = run(1 << 40).time_averages().stop_when(|| true).run().expect("averages");
    assert!(none.is_partial && none.steps < 1 << 40);
}

/// A path is stopped by a function, too, and is kept up to there.
#[test]
fn a_function_stops_a_path() {
    let run = WELL.simulate::<Baoab>(H).start(State::new([3.0], [0.0])).noise(StepNormals::seed(1));
    let run = run.steps(1 << 40).record_every(0).stop_when(|| true);
    let (path, error) = run.run_partial().expect("a path");
    let Some(Error::Stopped(stopped)) = error else { panic!("{error:?}") };
    assert!(stopped.done > 0 && path.last().t == stopped.done as f64 * H, "{stopped:?}");
}

/// `∫_0^t ρ` of `ρ = e^{-γt/2} (cos ωt ± γ/2ω sin ωt)`, plus for the coordinate and minus for the momentum:
/// what it is to a lag, and to infinity, `γ` and 0.
#[test]
fn integrals_of_correlations_that_oscillate_have_errors() {
    let system = Particle { gamma: 0.2, ..WELL };
    let run = system.simulate::<Baoab>(H).start(State::new([0.5], [0.0])).noise(StepNormals::seed(6));
    let path = run.steps(1 << 17).run().expect("a path");
    let rate = 0.5 * system.gamma;
    let omega = (1.0 - rate * rate).sqrt();
    // The real part of the integral of `(1 ∓ i γ/2ω) e^{(-γ/2 + iω) t}`.
    let exact = |sign: f64, t: f64| {
        let (decay, (sin, cos)) = ((-rate * t).exp(), (omega * t).sin_cos());
        let [real, imaginary] = [decay * cos - 1.0, decay * sin];
        let [re, im] = [real + sign * rate / omega * imaginary, imaginary - sign * rate / omega * real];
        omega * im - rate * re
    };
    for (sign, found) in [
        (1.0, path.autocorrelation(|state| state.q[0]).expect("an autocorrelation")),
        (-1.0, path.autocorrelation(|state| state.p[0]).expect("an autocorrelation")),
    ] {
        let limit = if sign > 0.0 { system.gamma } else { 0.0 };
        assert!((found.time - limit).abs() < 4.0 * found.time_error, "{} {}", found.time, found.time_error);
        assert!(found.time_error < 0.1 && found.window as f64 * H > 3.0 / system.gamma, "{}", found.window);
        for lag in [0.0, 0.5, 1.6, 3.1, 7.0, 20.0, 45.0] {
            let integral = found.integral(lag).expect("an integral");
            // A step changes the frequency by h²/24 of itself.
            let allowed = 4.0 * integral.error + H * H / 24.0 * lag;
            assert!((integral.value - exact(sign, lag)).abs() <= allowed, "{sign} {lag} {integral:?}");
            assert!(integral.error < 0.15, "{integral:?}");
        }
        let window = found.integral(found.window as f64 * H).expect("an integral");
        assert!(
            (window.value - found.time).abs() < 1e-3 && (window.error / found.time_error - 1.0).abs() < 1e-3
        );
        for lag in [-0.1, f64::NAN, 1e9] {
            assert!(matches!(found.integral(lag), Err(SeriesError::Lag { .. })), "{lag}");
        }
    }
    // What does not decay has no time.
    let still = Particle { gamma: 0.0, ..WELL }.simulate::<Baoab>(H).start(State::new([0.5], [0.0]));
    let path = still.noise(StepNormals::seed(6)).steps(5000).run().expect("a path");
    let error = path.autocorrelation(|state| state.q[0]).expect_err("a wave that goes on");
    assert_eq!(error, PathError::Series(SeriesError::Short { length: 5001 }));
}

#[test]
fn what_cannot_be_estimated_is_an_error() {
    let short = Autocorrelation::of(&[1.0, 2.0, 3.0, 2.0], 0.1);
    assert_eq!(short, Err(SeriesError::Short { length: 4 }));
    // A change of units by a power of two changes no time, and neither does the direction of the run.
    let logistic = std::iter::successors(Some(0.3), |x| Some(3.9 * x * (1.0 - x)));
    let values: Vec<f64> = logistic.take(1000).collect();
    let known = Autocorrelation::of(&values, 0.1).unwrap();
    for exponent in [-600, 500] {
        let unit = 2f64.powi(exponent);
        let scaled: Vec<f64> = values.iter().map(|value| value * unit).collect();
        let scaled = Autocorrelation::of(&scaled, -0.1).unwrap();
        assert_eq!((scaled.time, scaled.time_error), (known.time, known.time_error));
        assert_eq!(scaled.standard_error, known.standard_error * unit);
    }
    for constant in [1.0, 0.1] {
        assert_eq!(Autocorrelation::of(&[constant; 100], 0.1), Err(SeriesError::Constant));
    }
    assert_eq!(Autocorrelation::of(&[1.0, f64::NAN], 0.1), Err(SeriesError::NonFinite { index: 1 }));
    let uneven: [&[f64]; 2] = [&[1.0, 2.0], &[1.0]];
    assert_eq!(Autocorrelation::of_many(&uneven, 0.1), Err(SeriesError::Lengths { expected: 2, got: 1 }));
    let run =
        || WELL.simulate::<Baoab>(H).start(State::new([0.5], [0.0])).noise(StepNormals::seed(4)).steps(50);
    let path = run().run().expect("a path");
    let error = path.autocorrelation(|state| state.q[0]).expect_err("a path of a few times");
    assert_eq!(error, PathError::Series(SeriesError::Short { length: 51 }));
    let unknown = run().time_averages().until_error("q2", 0.1).run().expect_err("no such observable");
    assert!(matches!(unknown, Error::Name(_)), "{unknown}");
    let wrong = run().observe("q", |state| state.q[0]).time_averages().until_error("q", -0.1).run();
    assert!(wrong.is_err());
    let section = run().section(|state| state.q[0]).time_averages().run().expect_err("nobody keeps sections");
    assert!(section.to_string().contains("section"), "{section}");
}

/// Units of a power of two change no digit, up to the largest numbers.
#[test]
fn correlations_have_no_largest_unit() {
    let mut random = Uniform(3);
    let values: Vec<f64> = (0..512).map(|_| 0.75 + 0.2 * random.draw()).collect();
    let found = Autocorrelation::of(&values, H).expect("an autocorrelation");
    for exponent in [-1000, -300, 300, 1000, 1023] {
        let unit = 2.0_f64.powi(exponent);
        let scaled: Vec<f64> = values.iter().map(|x| x * unit).collect();
        let scaled = Autocorrelation::of(&scaled, H).expect("an autocorrelation");
        assert_eq!(
            (scaled.mean, scaled.standard_error),
            (found.mean * unit, found.standard_error * unit),
            "{exponent}"
        );
        assert_eq!((&scaled.function, scaled.time), (&found.function, found.time), "{exponent}");
    }
    // The difference of both ends is more than the largest number.
    let turns: Vec<f64> =
        values.iter().map(|x| if random.draw() < -0.3 { f64::MAX } else { -x * f64::MAX }).collect();
    let small: Vec<f64> = turns.iter().map(|x| x * 0.125).collect();
    let [turns, small] =
        [turns, small].map(|values| Autocorrelation::of(&values, H).expect("an autocorrelation"));
    assert_eq!((turns.mean, turns.function), (small.mean * 8.0, small.function));
}

#[test]
fn independent_paths_are_averaged() {
    let run = FREE.ensemble::<Baoab>(H).start(State::new([0.0], [0.0])).paths(512).seed(2).until(200.0);
    let run = run.observe("p", |state| state.p[0]).record_every(1).keep_paths(1 << 26).run().expect("paths");
    let paths = run.paths().expect("kept");
    // After the start is forgotten.
    let series: Vec<Vec<f64>> = (0..512)
        .map(|path| (200..2001).map(|node| paths.at(path, node).expect("a node")[0]).collect())
        .collect();
    let found = Autocorrelation::of_many(&series, H).expect("an autocorrelation");
    let a = (-FREE.gamma * H).exp();
    let time = H * (0.5 + a / (1.0 - a));
    assert!((found.time - time).abs() < 4.0 * found.time_error, "{} {time} {}", found.time, found.time_error);
}
