//! Thermostats with different numbers of O parts, on the Wiener paths that they share. `tests/laws` has their orders and variances.

use wzvi::prelude::*;

/// A system whose size only the state knows.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        (0..n).map(|i| 0.5 * p[i] * p[i] + 0.5 * (q[(i + 1) % n] - q[i]).powi(2) - q[i].cos()).sum::<f64>()
    },
    friction = 1.0,
    temperature = 0.5,
    embedding = [Baoab, Thermostat<Midpoint>],
)]
struct Ring;

/// One part in a step or two: both lead to the path of the reference, which has two, with strong order 1 of additive noise.
#[test]
fn thermostats_of_any_size_converge_to_one_path() {
    let report = Ring
        .work_precision()
        .start(State::new(vec![0.5, 0.1, -0.3], vec![0.5, 0.0, 0.2]))
        .until(1.0)
        .step_sizes((3..=5).map(|k| 2f64.powi(-k)))
        .paths(16)
        .seed(5)
        .repetitions(1)
        .reference::<Thermostat<Midpoint>>(2f64.powi(-9))
        .scheme::<Baoab>()
        .scheme::<Thermostat<Midpoint>>()
        .quiet()
        .run()
        .unwrap();
    for scheme in ["Baoab", "Thermostat<Midpoint>"] {
        let (order, error) = report.slope(scheme).order().unwrap_or_else(|| panic!("{}", report.text()));
        assert!((order - 1.0).abs() < 0.15 + 2.0 * error, "{scheme}: {order} ± {error}");
    }
}

/// Without temperature nothing is drawn, with friction.
#[test]
fn friction_alone_is_measured_on_one_path() {
    #[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), friction = 0.3, embedding = [Baoab, Thermostat<Gauss<2>>])]
    struct Damped;
    let run = Damped
        .work_precision()
        .start(State::new([1.0], [0.0]))
        .until(2.0)
        .step_sizes((3..=7).map(|k| 2f64.powi(-k)));
    let run = run.reference::<Thermostat<Gauss<2>>>(2f64.powi(-10)).scheme::<Baoab>().repetitions(1).quiet();
    let report = run.run().unwrap();
    assert!((report.slope("Baoab").order().unwrap().0 - 2.0).abs() < 0.1);
    assert!(report.cells.iter().all(|cell| cell.paths == 1 && cell.noise_time.is_none()));
}
