//! Exponents and indicators of chaos: references, invariants, and what a short run does not know.

use std::f64::consts::SQRT_2;

use fixtures::bath::Oscillator;
use fixtures::reference::{data, list, number, numbers};
use fixtures::small::{HenonHeiles, Kubo};
use fixtures::{are_refused, column};
use wzvi::chaos::{Indicators, Spectrum};
use wzvi::nalgebra::{DVector, SVector};
use wzvi::prelude::*;

/// An oscillator whose stiffness is noisy: with friction `b`.
#[hamiltonian(
    drift = |x, v| 0.5 * v * v + 0.5 * a * x * x,
    noise = [|x, _| -0.5 * sigma * x * x],
    friction = b,
    embedding = [Verlet, Midpoint],
)]
#[derive(Clone, Debug)]
struct Parametric {
    a: f64,
    b: f64,
    sigma: f64,
}

/// Two coupled pendulums with friction of one rate.
#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u + v * v) - x.cos() - y.cos() + 0.5 * (x - y).powi(2),
    friction = rate,
    embedding = [Verlet, Midpoint, Gauss<2>],
)]
struct Slowed {
    rate: f64,
}

/// The chain of Fermi, Pasta, Ulam and Tsingou with cubic forces, of any size.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + q.windows(2).map(|w| 0.5 * (w[1] - w[0]).powi(2) + 0.25 * (w[1] - w[0]).powi(4)).sum::<f64>()
    },
    embedding = [Verlet, Midpoint],
)]
struct Chain;

fn unit(place: usize) -> Vec<f64> {
    (0..4).map(|k| f64::from(k == place)).collect()
}

/// Of the energy and `x = p_y = 0`.
fn on_axis(energy: f64, y: f64) -> State<SVector<f64, 2>> {
    State::new([0.0, y], [(2.0 * energy - y * y + 2.0 / 3.0 * y.powi(3)).sqrt(), 0.0])
}

fn largest_difference(ours: &[f64], exact: &[f64]) -> f64 {
    ours.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Against steps with 34 digits.
#[test]
fn the_first_steps_have_the_values_of_the_definitions() {
    let reference = data("chaos_map");
    for row in list(&reference["rows"]) {
        let steps = row["step"].as_u64().unwrap();
        let start = State::new([0.0, -0.1], [number(&reference["p1"]), 0.0]);
        let run = || HenonHeiles.simulate::<Verlet>(0.25).start(start).steps(steps);
        let spectrum = run().copies(0).deviations((0..4).map(unit)).lyapunov().unwrap();
        let mut logs = numbers(&row["log_diag_R"]);
        logs.sort_by(|a, b| b.total_cmp(a));
        let ours: Vec<f64> = spectrum.values.iter().map(|value| value * spectrum.time).collect();
        // Roundings of so many steps, and of as many sums in MEGNO.
        let bound = 2e-15 * steps as f64 + 1e-15;
        assert!(largest_difference(&ours, &logs) < bound, "{steps}: {ours:?} instead of {logs:?}");
        let Indicators { megno, megno_mean, sali, gali, fli, time, series } =
            run().deviations([unit(0), unit(1)]).indicators().unwrap();
        let ours = [megno, megno_mean, sali, gali[0]];
        let exact = ["megno_Y", "megno_mean", "SALI", "GALI2"].map(|name| number(&row[name]));
        assert!(largest_difference(&ours, &exact) < bound, "{steps}: {ours:?} instead of {exact:?}");
        assert!((time, series, gali.len()) == (0.25 * steps as f64, None, 1) && fli.is_finite());
    }
}

/// Three starts on tori and two in the chaotic sea. Where a symmetry fixes the start, a unit vector sees no shear, and MEGNO does not go to 2.
#[test]
fn generic_deviations_tell_regular_from_chaotic_starts_on_symmetric_ones() {
    let indicators = |energy, y| {
        let run = HenonHeiles.simulate::<Verlet>(0.25).start(on_axis(energy, y)).until(2000.0);
        [run.clone().indicators().unwrap(), run.deviations([unit(0), unit(3)]).indicators().unwrap()]
    };
    for (energy, y) in [(1.0 / 12.0, 0.1), (1.0 / 12.0, -0.1)] {
        let [generic, symmetric] = indicators(energy, y);
        // 2 ± O(1/T) with a factor of the shear.
        assert!((generic.megno_mean - 2.0).abs() < 0.35, "{generic:?}");
        assert!(generic.sali > 0.1 && generic.fli < 10.0 && generic.gali[2] < 1e-6, "{generic:?}");
        assert!(symmetric.megno_mean.abs() < 0.1, "{symmetric:?}");
    }
    let [generic, _] = indicators(0.125, -0.25);
    assert!(generic.megno_mean > 15.0 && generic.sali < 1e-10 && generic.fli > 30.0, "{generic:?}");
}

#[test]
fn symplectic_steps_have_exponents_in_pairs() {
    fn check<E>(h: f64)
    where
        HenonHeiles: Discretized<E, Vector = SVector<f64, 2>>,
    {
        let run = HenonHeiles.simulate::<E>(h).start(on_axis(0.125, -0.25)).until(400.0);
        let Spectrum { values, pair_defect, sum_defect, .. } = run.copies(0).lyapunov().unwrap();
        // QR of some hundred pieces; pairs like ln T / T.
        assert!(sum_defect.unwrap().abs() < 1e-14, "{sum_defect:?}");
        assert!(pair_defect.unwrap() < 0.02 && values.is_sorted_by(|a, b| a >= b), "{values:?}");
        assert!(values[0] > 0.01 && values[1] < 0.02, "{values:?}");
    }
    check::<Verlet>(0.1);
    check::<Gauss<8>>(1.0);
    check::<Composed<Verlet, KahanLi8>>(0.5);
}

/// `det T = e^{-d γ h}` exactly, whatever the step.
#[test]
fn friction_contracts_at_its_rate() {
    fn check<E>(h: f64)
    where
        Slowed: Discretized<E, Vector = SVector<f64, 2>>,
    {
        for h in [h, -0.2 * h] {
            let system = Slowed { rate: 0.3 };
            let run = system.simulate::<E>(h).start(State::new([1.0, -0.4], [1.5, 0.2]));
            // The last step is shorter.
            let spectrum = run.until(300.3 * h).copies(0).lyapunov().unwrap();
            let expected = -2.0 * 0.3 * h.signum();
            assert!((spectrum.sum() - expected).abs() < 1e-13, "{spectrum:?}");
            assert!(spectrum.sum_defect.unwrap().abs() < 1e-13, "{spectrum:?}");
            // Pairs of a conformal step have the sum -γ.
            assert!(spectrum.pair_defect.unwrap() < 0.1, "{spectrum:?}");
        }
    }
    check::<Verlet>(0.1);
    check::<Midpoint>(0.3);
    check::<Gauss<2>>(0.3);
    let bath = Oscillator { m: 1.3, k: 1.0, b: 0.5, gamma: 0.7, kt: 1.0 };
    let run = bath.simulate::<Baoab>(0.1).start(State::new([1.0], [0.0])).noise(StepNormals::seed(4));
    let spectrum = run.steps(2000).copies(2).lyapunov().unwrap();
    assert!((spectrum.sum() + 0.7).abs() < 1e-13 && spectrum.sum_defect.is_none(), "{spectrum:?}");
}

/// Growth of a linear system is that of its matrix, with the increments of the path.
#[test]
fn deviations_have_the_increments_of_the_path() {
    let system = Parametric { a: 1.0, b: 0.2, sigma: 0.8 };
    let run = || {
        system.simulate::<Midpoint>(0.05).start(State::new([0.6], [-0.8])).noise(Wiener::seed(5)).until(50.0)
    };
    let spectrum = run().copies(0).deviations([[0.6, -0.8]]).lyapunov().unwrap();
    let end = *run().run().unwrap().last();
    let growth = (end.q.norm_squared() + end.p.norm_squared()).sqrt().ln();
    // Roundings of a thousand steps.
    assert!((spectrum.values[0] * spectrum.time - growth).abs() < 1e-12, "{spectrum:?} {growth}");
    assert!((spectrum.copies.len(), spectrum.errors, spectrum.pair_defect) == (0, None, None));
}

/// With noise, the error is that of other paths of it; a noise of one path knows none.
#[test]
fn noise_has_errors_by_other_paths() {
    let exact = data("chaos_noise");
    for case in list(&exact["cases"]).iter().step_by(2) {
        let [a, b, sigma, top] = ["a", "b", "sigma", "lambda_top"].map(|name| number(&case[name]));
        let system = Parametric { a, b, sigma };
        let run = system.simulate::<Midpoint>(0.05).start(State::new([1.0], [0.0]));
        let spectrum = run.noise(StepNormals::seed(1)).until(100.0).lyapunov().unwrap();
        let errors = spectrum.errors.clone().unwrap();
        // Of the first order in the step, with a factor of some tenths.
        assert!((spectrum.values[0] - top).abs() < 4.0 * errors[0] + 0.2 * 0.05, "{top} {spectrum:?}");
        // The spread of a random walk over T = 100 is below `σ/√T`.
        assert!(errors[0] < sigma / 100f64.sqrt(), "{spectrum:?}");
    }
    let system = Parametric { a: 1.0, b: 0.0, sigma: 1.0 };
    let run = system.simulate::<Verlet>(0.05).start(State::new([1.0], [0.0])).steps(200);
    let given = run.clone().noise(Increments::from(vec![0.1; 200])).lyapunov().unwrap();
    assert!(given.errors.is_none() && given.copies.is_empty());
    let mut borrowed = Wiener::seed(3);
    assert!(run.clone().noise(&mut borrowed).lyapunov().unwrap().errors.is_none());
    assert_eq!(run.noise(Wiener::seed(3)).copies(3).lyapunov().unwrap().copies.len(), 3);
}

#[test]
fn errors_are_none_where_a_run_does_not_know_them() {
    let chaotic = |until| HenonHeiles.simulate::<Verlet>(0.1).start(on_axis(0.125, -0.25)).until(until);
    // A part of a period, where growth is smooth; and some multiples of 1/λ, where copies are not apart yet.
    for until in [0.5, 3.0, 300.0] {
        let spectrum = chaotic(until).lyapunov().unwrap();
        assert!(spectrum.errors.is_none(), "{until}: {spectrum:?}");
        assert!(spectrum.to_string().ends_with("(errors not known)"));
    }
    assert!(chaotic(2000.0).copies(0).lyapunov().unwrap().errors.is_none());
    let known = chaotic(2000.0).copies(3).lyapunov().unwrap();
    assert_eq!(known.copies.len(), 3);
    let errors = known.errors.clone().unwrap();
    // 0.0093 at T = 10⁴, by 200 copies, which does not fall like T^{-1/2}; of four, within a factor of 3.
    assert!(errors[0] > 0.003 && errors[0] < 0.03, "{known:?}");
    assert!((known.values[0] - 0.0485).abs() < 3.0 * 0.0093, "{known:?}");
    assert!(known.to_string().contains(" ± "));
    // On a torus the error covers the bias `ln T / T`.
    let regular = HenonHeiles.simulate::<Verlet>(0.1).start(on_axis(1.0 / 12.0, 0.1)).until(500.0);
    let spectrum = regular.copies(2).lyapunov().unwrap();
    let errors = spectrum.errors.clone().unwrap();
    assert!(spectrum.values[0] < 3.0 * errors[0] && errors[0] < 0.02, "{spectrum:?}");
}

/// As other runs: a stop is an error that says how far the path and its copies were.
#[test]
fn runs_with_deviations_are_watched_and_stopped() {
    let run = |steps| HenonHeiles.simulate::<Verlet>(0.1).start(on_axis(0.125, -0.25)).steps(steps);
    let handle = Handle::new();
    handle.stop();
    assert!(matches!(run(1 << 40).handle(&handle).lyapunov(), Err(wzvi::Error::Stopped(_))));
    assert!(matches!(run(1 << 40).handle(&handle).indicators(), Err(wzvi::Error::Stopped(_))));
    assert!(matches!(run(1 << 40).handle(&handle).tangent(), Err(wzvi::Error::Stopped(_))));
    assert!(matches!(run(1 << 40).stop_when(|| true).copies(2).lyapunov(), Err(wzvi::Error::Stopped(_))));
    // Nobody stops it.
    let handle = Handle::new();
    let watched = run(300).handle(&handle).stop_when(|| false).copies(2).lyapunov().unwrap();
    assert_eq!(watched, run(300).copies(2).lyapunov().unwrap());
}

#[test]
fn series_are_recorded_on_request() {
    let run =
        || HenonHeiles.simulate::<Verlet>(0.25).start(on_axis(0.125, -0.25)).until(100.0).record_every(150);
    let spectrum = run().copies(0).lyapunov().unwrap();
    let series = spectrum.series.as_ref().unwrap();
    assert_eq!(series.times, [37.5, 75.0, 100.0]);
    assert_eq!(series.values[2], spectrum.values);
    let halfway = HenonHeiles.simulate::<Verlet>(0.25).start(on_axis(0.125, -0.25)).until(37.5);
    let halfway = halfway.copies(0).lyapunov().unwrap();
    // QR at other nodes: rounding alone.
    assert!(largest_difference(&series.values[0], &halfway.values) < 1e-13);
    let table = series.table();
    assert_eq!((table.rows(), column(&table, "t"), table.columns().len()), (3, &series.times[..], 5));
    assert_eq!(column(&table, "lambda_1")[2], spectrum.values[0]);

    let all = run().indicators().unwrap();
    let series = all.series.as_ref().unwrap();
    assert_eq!((series.times.len(), series.gali[2].clone()), (3, all.gali.clone()));
    assert_eq!(column(&series.table(), "megno_mean")[2], all.megno_mean);
    assert_eq!(column(&series.table(), "gali_4")[2], all.gali[2]);
    assert!(all.sali <= SQRT_2 && run().record_every(0).indicators().unwrap().megno == all.megno);
}

/// Deviations cost columns: nothing is of the size of a matrix.
#[test]
fn few_deviations_of_a_long_chain_take_few_columns() {
    let sites = 1000;
    let start: Vec<f64> = (0..sites).map(|i| (0.7 * i as f64).sin()).collect();
    let run = || Chain.simulate::<Verlet>(0.1).start(State::new(vec![0.0; sites], start.clone())).steps(100);
    let mut spectrum = None;
    let counted = allocation_counter::measure(|| spectrum = Some(run().copies(1).lyapunov_of(2).unwrap()));
    // The path at the ends of 64 batches is most of it; a matrix would have 2000² numbers.
    assert!(counted.bytes_max < 8 * (2 * sites as u64) * 200, "{}", counted.bytes_max);
    let spectrum = spectrum.unwrap();
    assert_eq!((spectrum.values.len(), spectrum.pair_defect, spectrum.sum_defect), (2, None, None));
    let indicators = run().indicators().unwrap();
    assert_eq!(indicators.gali.len(), 3);
    // All of a short chain, whose momentum is conserved: four exponents are zero.
    let start = State::new(DVector::zeros(6), DVector::from_vec(vec![1.5, 0.3, -0.8, 0.1, -1.0, 0.7]));
    let all = Chain.simulate::<Midpoint>(0.2).start(start).until(400.0).copies(0).lyapunov().unwrap();
    assert!(
        all.values.len() == 12 && all.sum_defect.unwrap().abs() < 1e-13 && all.pair_defect.unwrap() < 0.01
    );
}

#[test]
fn what_is_no_deviation_is_refused() {
    let run = || HenonHeiles.simulate::<Verlet>(0.25).start(on_axis(0.125, -0.25)).steps(10);
    are_refused(run().lyapunov_of(5), "5 deviations of a system with 2 degrees of freedom: at most 4");
    are_refused(run().lyapunov_of(0), "of no deviations");
    are_refused(run().deviations((0..5).map(|k| unit(k % 4))).lyapunov(), "5 deviations of a system with 2");
    are_refused(run().deviations([unit(0), unit(0)]).lyapunov(), "deviation 1 is a sum of multiples");
    are_refused(run().deviations([unit(0)]).lyapunov_of(2), "2 deviations are needed, and 1 are given");
    are_refused(run().deviations([unit(0)]).indicators(), "SALI compares two");
    are_refused(run().deviations([unit(0), vec![0.0; 4]]).indicators(), "deviation 1 is zero");
    are_refused(run().deviations([[1.0, f64::NAN, 0.0, 0.0], [0.0; 4]]).indicators(), "has the entry NaN");
    are_refused(run().deviations([[1.0, 0.0]]).lyapunov(), "has 2 entries: it needs 4");
    are_refused(run().steps(0).lyapunov(), "of a run without steps");
    are_refused(run().steps(0).indicators(), "of a run without steps");
    are_refused(run().observe("x", |state| state.q[0]).lyapunov(), "`lyapunov` has no use for `observe`");
    are_refused(run().record_at([0.1]).indicators(), "`indicators` has no use for");
    let spectrum = run().deviations([unit(0), unit(1), unit(2)]).lyapunov_of(2).unwrap();
    assert_eq!(spectrum.values.len(), 2);
    let kubo = Kubo { a: 1.0, sigma: 0.5 };
    let run = kubo.simulate::<Midpoint>(0.1).start(State::new([1.0], [0.0])).noise(Wiener::seed(2));
    let indicators = run.steps(50).indicators().unwrap();
    // A rotation, to rounding.
    assert!(indicators.megno.abs() < 1e-12 && (indicators.sali - SQRT_2).abs() < 1e-12, "{indicators:?}");
}
