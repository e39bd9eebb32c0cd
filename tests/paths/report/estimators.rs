//! What is measured, against closed forms.

use fixtures::are_refused;
use fixtures::small::{KUBO, Kubo, Pendulum};
use std::sync::atomic::{AtomicU32, Ordering};

use wzvi::error::{ConfigError, Error};
use wzvi::prelude::*;
use wzvi::report::Report;
use wzvi::report::statistics::{Estimate, Spread, Trend};

/// Falls to infinity in finite time.
#[hamiltonian(drift = |q, p| 0.5 * p * p - q.powi(6), embedding = DeltaPlus)]
struct Falling;

/// Compared with the exact solution.
pub(crate) fn kubo() -> WorkPrecision<'static, Kubo> {
    kubo_alone().exact(|t, wiener| {
        let (sin, cos) = (KUBO.a * t + KUBO.sigma * wiener[0]).sin_cos();
        State::new([sin], [cos])
    })
}

/// The same, compared with nothing yet.
fn kubo_alone() -> WorkPrecision<'static, Kubo> {
    KUBO.work_precision()
        .start(State::new([0.0], [1.0]))
        .until(1.0)
        .step_sizes((3..=7).map(|k| 2f64.powi(-k)))
        .paths(400)
        .seed(1)
        .repetitions(2)
        .scheme::<Midpoint>()
        .scheme::<Corrected<DeltaPlus>>()
        .scheme::<Uncorrected<DeltaPlus>>()
}

#[test]
fn estimators_are_the_textbook_ones() {
    let mean = Estimate::mean(&[1.0, 2.0, 3.0, 6.0]);
    assert_eq!(mean.value, 3.0);
    assert!((mean.standard_error - (14.0 / 3.0 / 4.0f64).sqrt()).abs() < 1e-15);
    let rms = Estimate::root_mean_square(&[3.0, 4.0, 5.0]);
    assert!((rms.value - (50.0 / 3.0f64).sqrt()).abs() < 1e-14);
    // Var(x^2) of 9, 16, 25 is 193 / 3.
    assert!((rms.standard_error - (193.0 / 9.0f64).sqrt() / (2.0 * rms.value)).abs() < 1e-14);
    assert!(
        (Estimate::root_mean_square(&[3e-200, 4e-200, 5e-200]).value / rms.value - 1e-200).abs() < 1e-213
    );
    assert!(Estimate::mean(&[]).value.is_nan() && Estimate::root_mean_square(&[]).value.is_nan());
    let spread = Spread::of(&[5.0, 1.0, 2.0, 4.0, 3.0]);
    assert_eq!((spread.low, spread.median, spread.high), (2.0, 3.0, 4.0));
    let wave: Vec<_> =
        (0..1000).map(|i| f64::from(i) * 0.01).map(|t| (t, 2.0 * t + (200.0 * t).sin())).collect();
    let trend = Trend::of(&wave);
    assert!(
        (trend.slope - 2.0).abs() < 1e-2 && (trend.oscillation - 0.5f64.sqrt()).abs() < 1e-2,
        "{trend:?}"
    );
}

/// A free particle that noise kicks: `q = q_0 + p_0 t - σ ∫ W`.
#[hamiltonian(drift = |_q, p| 0.5 * p * p, noise = [|q, _p| sigma * q], embedding = Midpoint)]
struct Kicked {
    sigma: f64,
}

/// The mid-point takes `h ΔW / 2` for the area under the path in a step, which misses it by a variance of `h³ / 12`: at `t` the coordinate is wrong by
/// `σ h √(t / 12)`, the momentum by nothing.
#[test]
fn an_exact_solution_may_depend_on_the_whole_path() {
    let (system, t, paths) = (Kicked { sigma: 0.7 }, 2.0_f64, 400);
    let report = system
        .work_precision()
        .start(State::new([0.0], [1.0]))
        .until(t)
        .step_sizes([0.25, 0.0625])
        .paths(paths)
        .seed(4)
        .repetitions(0)
        .exact_on_path(|t, wiener| {
            let kick = system.sigma * wiener.value(0, t)?;
            Ok(State::new([t - system.sigma * wiener.integral(0, 0.0, t)?], [1.0 - kick]))
        })
        .scheme::<Midpoint>()
        .run()
        .unwrap();
    assert_eq!(report.of("Midpoint").count(), 2);
    for cell in report.of("Midpoint") {
        let exact = system.sigma * cell.h * (t / 12.0).sqrt();
        let found = cell.strong;
        // A root of n Gaussian squares is known to 1/√(2n).
        assert!((found.value / exact - 1.0).abs() < 5.0 / (2.0 * paths as f64).sqrt(), "{found:?} {exact}");
    }
}

/// `E z(t) = e^{-sigma^2 t / 2} R(a t) z(0)`; the strong error of the mid-point embedding to leading order in h.
#[test]
fn kubo_has_its_moments_and_its_strong_error() {
    let (a, s) = (KUBO.a, KUBO.sigma);
    let damping = (-0.5 * s * s).exp();
    let report = kubo()
        .paths(150)
        .repetitions(0)
        .expectation("q", |state| state.q[0], damping * a.sin())
        .expectation("p", |state| state.p[0], damping * a.cos())
        .observe("q on the path", |state| state.q[0])
        .run()
        .unwrap();
    let leading = (15.0 * s.powi(6) / 144.0 + (a * s * s / 4.0).powi(2)).sqrt();
    for cell in report.of("Midpoint").filter(|cell| cell.h < 0.05) {
        for weak in &cell.weak {
            // The bias of the scheme is below h / 4; the rest is chance: four standard errors.
            assert!(weak.bias.value.abs() < 0.25 * cell.h + 4.0 * weak.bias.standard_error, "{weak:?}");
        }
        // On the same path the spread is that of the error, not that of q.
        assert!(cell.weak[2].bias.standard_error < 0.1 * cell.weak[0].bias.standard_error);
        let expected = leading * cell.h;
        let off = (cell.strong.value - expected).abs();
        assert!(off < 0.05 * expected + 4.0 * cell.strong.standard_error, "{:?} {expected}", cell.strong);
        assert!(cell.energy_trend.value < 1e-13 && cell.energy_oscillation.value < 1e-13);
        assert_eq!((cell.paths, cell.failures, cell.time), (150, 0, None));
    }
    for scheme in ["Midpoint", "Corrected<DeltaPlus>"] {
        let (order, _) = report.slope(scheme).order().unwrap();
        assert!((order - 1.0).abs() < 0.15, "{scheme}: {}", report.slope(scheme).words());
    }
    let words = report.slope("Uncorrected<DeltaPlus>").words();
    assert!(words.contains("no convergence"), "{words}");
}

#[test]
fn a_finer_run_serves_as_reference() {
    let finer = kubo_alone().paths(6).reference::<Midpoint>(2f64.powi(-12)).run().unwrap();
    let exact = kubo().paths(6).run().unwrap();
    assert_eq!(
        finer.reference,
        "Midpoint with h = 2.44e-4 on the same Wiener path".replace("2.44e-4", "0.000244")
    );
    for (a, b) in finer.cells.iter().zip(&exact.cells) {
        // The reference itself is off by its own strong error, 1.5e-4.
        assert!((a.strong.value - b.strong.value).abs() < 3e-4, "{a:?}");
        let (steps, noise) = (a.time.unwrap(), a.noise_time.unwrap());
        assert!(0.0 < steps.low && steps.low <= steps.median && steps.median <= steps.high);
        assert!(noise.median > 0.0 && a.times.len() == 2 && a.noise_times.len() == 2);
    }
}

#[test]
fn a_deterministic_system_takes_one_path_and_keeps_its_orders() {
    let start = State::new([1.0], [0.0]);
    let fine = Pendulum.simulate::<Midpoint>(1e-4).start(start).until(4.0).record_every(0).run().unwrap();
    let report = Pendulum
        .work_precision()
        .start(start)
        .until(4.0)
        .step_sizes([0.2, 0.1, 0.05, 0.025, 0.0125])
        .value(*fine.last())
        .scheme::<DeltaPlus>()
        .scheme::<Midpoint>()
        .repetitions(1)
        .run()
        .unwrap();
    for (scheme, expected) in [("DeltaPlus", 1.0), ("Midpoint", 2.0)] {
        let (order, _) = report.slope(scheme).order().unwrap();
        assert!((order - expected).abs() < 0.15, "{}", report.slope(scheme).words());
    }
    for cell in &report.cells {
        assert_eq!((cell.paths, cell.noise_time), (1, None));
        assert_eq!(cell.scheme == "Midpoint", cell.iterations > 0.0);
    }
    let choice = report.cheapest(1e-2).unwrap();
    assert!(choice.cell.strong.value <= 1e-2);
    assert!(choice.words().starts_with("for an error of 1e-2, use "), "{}", choice.words());
    let front = report.pareto();
    assert!(front.windows(2).all(|pair| {
        pair[0].seconds() < pair[1].seconds() && pair[0].strong.value > pair[1].strong.value
    }));
    assert!(!report.interrupted);
}

#[test]
fn failures_are_counted_and_told() {
    let report = Falling
        .work_precision()
        .start(State::new([3.0], [0.0]))
        .until(4.0)
        .step_sizes([0.25, 0.125])
        .value(State::new([0.0], [0.0]))
        .scheme::<DeltaPlus>()
        .run()
        .unwrap();
    for cell in &report.cells {
        assert_eq!((cell.paths, cell.failures, cell.time), (0, 1, None));
        assert!(cell.failure.as_ref().is_some_and(|text| text.contains("not finite")), "{cell:?}");
    }
    assert!(report.text().contains("failed on 1 of 1 paths"));
}

#[test]
fn an_interruption_keeps_what_was_measured() {
    // Once for the references, then for each block of paths: some of the fifteen cells are not reached.
    let asked = AtomicU32::new(0);
    let stop = move || asked.fetch_add(1, Ordering::Relaxed) > 12;
    let report: Report = kubo().stop_when(stop).run().unwrap();
    assert!(report.interrupted);
    assert!(!report.cells.is_empty() && report.cells.iter().all(|cell| cell.paths > 0));
    assert!(report.cells.iter().map(|cell| cell.paths).sum::<usize>() < 15 * 400);
    assert!(report.text().contains("interrupted"));
    assert!(!kubo().paths(20).stop_when(|| false).run().unwrap().interrupted);
    let handle = Handle::new();
    handle.stop();
    assert!(kubo().handle(&handle).run().unwrap().interrupted);
}

/// Errors are those of the paths, whatever threads there are; a time that was not measured has its place in the CSV.
#[test]
fn threads_do_not_show_in_the_numbers() {
    let cells = |threads: usize| {
        let report = kubo().paths(1100).step_sizes([0.25]).observe("q", |state| state.q[0]);
        let report = report.repetitions(0).threads(threads).run().unwrap();
        let csv = String::from_utf8(report.csv()).unwrap();
        let commas = |line: &str| line.matches(',').count();
        assert!(csv.lines().all(|line| commas(line) == 18), "{csv}");
        assert!(csv.contains(",NaN,NaN,"), "{csv}");
        report.cells
    };
    let one = cells(1);
    assert!(one.iter().all(|cell| cell.path_numbers == (0..1100).collect::<Vec<_>>()));
    for threads in [2, 5] {
        assert_eq!(format!("{:?}", cells(threads)), format!("{one:?}"));
    }
}

#[test]
fn what_is_missing_is_named() {
    let bare = || KUBO.work_precision().start(State::new([0.0], [1.0])).until(1.0).step_sizes([0.25]);
    are_refused(bare().scheme::<Midpoint>().run(), "something to compare with");
    are_refused(bare().value(State::new([0.0], [1.0])).run(), "a scheme");
    are_refused(kubo().step_sizes([0.3]).run(), "0.3");
    assert!(matches!(kubo().step_sizes([f64::NAN]).run(), Err(Error::Config(ConfigError::End { .. }))));
    are_refused(kubo().paths(0).run(), "paths");
}
