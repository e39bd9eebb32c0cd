//! Thermostats with different numbers of O parts, on the Wiener paths that they share.

use wzvi::prelude::*;
use wzvi::report::Report;

use fixtures::bath::Oscillator;

fn oscillator(b: f64) -> Oscillator {
    Oscillator { m: 1.0, k: 1.0, b, gamma: 1.0, kt: 1.0 }
}

fn quartic() -> Report {
    oscillator(1.0)
        .work_precision()
        .start(State::new([0.5], [0.5]))
        .until(4.0)
        .step_sizes((2..=6).map(|k| 2f64.powi(-k)))
        .paths(400)
        .seed(3)
        .repetitions(1)
        .reference::<Thermostat<Gauss<2>>>(2f64.powi(-10))
        .observe("q²", |state| state.q[0] * state.q[0])
        .scheme::<Baoab>()
        .scheme::<Obabo>()
        .scheme::<Thermostat<Midpoint>>()
        .quiet()
        .run()
        .unwrap()
}

/// One part in a step or two: all lead to the path of the reference, which has two, with strong order 1 of additive noise.
#[test]
fn thermostats_converge_to_one_path() {
    let report = quartic();
    for scheme in ["Baoab", "Obabo", "Thermostat<Midpoint>"] {
        let (order, error) = report.slope(scheme).order().unwrap_or_else(|| panic!("{}", report.text()));
        // The next power of h bends the line of steps from 1/4 on.
        assert!((order - 1.0).abs() < 0.15 + 2.0 * error, "{scheme}: {order} ± {error}");
        let finest = report.of(scheme).last().unwrap();
        // Bias and deviation fall with the step, and both are small at 1/64.
        assert!(finest.strong.value < 0.02 && finest.weak[0].bias.standard_error < 2e-3, "{}", report.text());
        assert!(finest.time.is_some() && finest.noise_time.is_some());
    }
}

/// The stationary variance, whatever the step: the processes of both parts stay independent Wiener processes.
#[test]
fn shared_paths_have_the_law_of_the_bath() {
    let report = oscillator(0.0)
        .work_precision()
        .start(State::new([0.0], [0.0]))
        .until(20.0)
        .step_sizes([0.25, 0.5])
        .paths(4000)
        .seed(4)
        .repetitions(0)
        .reference::<Thermostat<Midpoint>>(0.25)
        // What is left of the start is e^-20.
        .expectation("q²", |state| state.q[0] * state.q[0], 1.0)
        .expectation("p²", |state| state.p[0] * state.p[0], 1.0)
        .scheme::<Thermostat<Midpoint>>()
        .scheme::<Thermostat<Gauss<2>>>()
        .scheme::<Baoab>()
        .quiet()
        .run()
        .unwrap();
    for cell in &report.cells {
        let momenta = if cell.scheme == "Baoab" { 1.0 - 0.25 * cell.h * cell.h } else { 1.0 };
        for (weak, exact) in cell.weak.iter().zip([1.0, momenta]) {
            let gap = weak.bias.value + 1.0 - exact;
            assert!(gap.abs() < 4.0 * weak.bias.standard_error, "{} {gap:?}", cell.scheme);
            // A square of a normal has the variance 2.
            assert!((weak.bias.standard_error - (2.0_f64 / 4000.0).sqrt()).abs() < 5e-3);
        }
    }
}
