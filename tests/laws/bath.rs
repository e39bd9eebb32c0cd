//! What is sampled: against exact distributions.

use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

use fixtures::bath::{Chain, Oscillator, stationary};

/// Step sizes with `x = h² k / 4m` below 1, and frictions on both sides of the critical one.
const CASES: [(f64, f64); 4] = [(0.1, 0.3), (0.8, 0.3), (0.8, 5.0), (1.1, 60.0)];

fn oscillator(gamma: f64) -> Oscillator {
    Oscillator { m: 0.8, k: 1.7, b: 0.0, gamma, kt: 1.3 }
}

/// The variances of `q` and `p` in units of `kT/k` and `m kT`, by `x = h² k / 4m`, as the theory has them.
fn check_table<E>(expected: impl Fn(f64) -> [f64; 2])
where
    Oscillator: Discretized<E, Vector = SVector<f64, 1>>,
{
    for (h, gamma) in CASES {
        let system = oscillator(gamma);
        let Oscillator { m, k, kt, .. } = system;
        let covariance = stationary::<E, _>(&system, h);
        let expected = expected(h * h * k / (4.0 * m));
        let got = [covariance.m11 * k / kt, covariance.m22 / (m * kt)];
        for (got, expected) in got.iter().zip(expected) {
            // Some roundings of a step, times the steps that the slowest motion lasts: up to a hundred.
            assert!((got - expected).abs() < 1e-13 * expected, "{h} {gamma} {got} {expected}");
        }
        assert!(covariance.m12.abs() < 1e-13, "{h} {gamma} {covariance:?}");
    }
}

#[test]
fn the_harmonic_variances_are_those_of_the_theory() {
    check_table::<Baoab>(|x| [1.0, 1.0 - x]);
    check_table::<Obabo>(|x| [1.0 / (1.0 - x), 1.0]);
    check_table::<Thermostat<Verlet>>(|x| [1.0 / (1.0 - x), 1.0]);
    check_table::<Thermostat<Midpoint>>(|_| [1.0, 1.0]);
    check_table::<Thermostat<Gauss<2>>>(|_| [1.0, 1.0]);
    check_table::<Thermostat<Gauss<3>>>(|_| [1.0, 1.0]);
}

/// `<q²>` of the quartic well, `kT = m = γ = 1`, and its standard error: over nodes of many paths, a few times of correlation apart.
fn quartic<E>(h: f64) -> (f64, f64)
where
    Oscillator: Discretized<E, Vector = SVector<f64, 1>>,
{
    let system = Oscillator { m: 1.0, k: 1.0, b: 1.0, gamma: 1.0, kt: 1.0 };
    let every = (3.0 / h).round();
    let run = system.ensemble::<E>(h).start(State::new([0.5], [0.5])).paths(4096).seed(11);
    let run = run.observe("q2", |state| state.q[0].powi(2)).covariances(false);
    let run = run.record_every(every as u64).steps(60 * every as u64).run_in::<8>().expect("an ensemble");
    let nodes = &run.nodes()[5..];
    let mean = nodes.iter().map(|node| node.mean(0)).sum::<f64>() / nodes.len() as f64;
    let error = nodes.iter().map(|node| node.standard_error(0)).sum::<f64>() / nodes.len() as f64;
    // Neighbours are still correlated by some tenths.
    (mean, 1.3 * error / (nodes.len() as f64).sqrt())
}

/// The exact `<q²>` of the quartic well.
const QUARTIC: f64 = 0.467_919_916_97;

#[test]
fn the_bias_of_the_quartic_is_that_of_the_theory() {
    // Biases by long runs with other programs.
    let check = |(mean, error): (f64, f64), bias: f64| {
        assert!((mean - QUARTIC - bias).abs() < 4.0 * error, "{mean} {error} {bias}");
    };
    check(quartic::<Baoab>(0.36), -0.0017);
    check(quartic::<Obabo>(0.3), 0.0150);
    check(quartic::<Thermostat<Midpoint>>(0.36), 0.0126);
    check(quartic::<Thermostat<Gauss<2>>>(0.36), 0.0002);
    // Of order two: a quarter at half the step.
    let (coarse, fine) = (quartic::<Obabo>(0.3), quartic::<Obabo>(0.15));
    let (ratio, error) = ((coarse.0 - QUARTIC) / (fine.0 - QUARTIC), 4.0 * fine.1 / (fine.0 - QUARTIC));
    assert!((ratio / 4.0 - 1.0).abs() < error + 0.1, "{ratio} {error}");
}

#[test]
fn one_site_in_the_bath_heats_all() {
    let chain = Chain { gamma: 1.0, kt: 0.7 };
    let start = State::new(vec![0.0; 4], vec![0.0; 4]);
    let run = chain.ensemble::<Baoab>(0.1).start(start).paths(4000).seed(3).until(150.0);
    let run = (0..4).fold(run, |run, i| run.observe(format!("p{i}"), move |state| state.p[i].powi(2)));
    let statistics = run.run_in::<8>().expect("an ensemble");
    for i in 0..4 {
        let name = format!("p{i}");
        let (mean, error) =
            (statistics.mean(&name).expect("a mean"), statistics.standard_error(&name).expect("an error"));
        // The bias of order h² of the momenta is half a per cent at most, for a stiffness below 8.
        assert!((mean - 0.7).abs() < 4.0 * error + 0.7 * 0.1 * 0.1 * 8.0 / 4.0, "{name} {mean} {error}");
    }
}

#[test]
fn levels_share_their_noise() {
    // The mean of q² at t = 1 from rest in the origin: of a linear system, exactly.
    let system = Oscillator { m: 1.0, k: 1.0, b: 0.0, gamma: 1.0, kt: 1.0 };
    check_levels::<Thermostat<Midpoint>>(&system);
}

fn check_levels<E>(system: &Oscillator)
where
    Oscillator: Discretized<E, Vector = SVector<f64, 1>>,
{
    let run = system.multilevel::<E>(0.25).start(State::new([0.0], [0.0])).seed(5).until(1.0);
    let estimate = run.observe("q2", |state| state.q[0].powi(2)).target(0.002).run().expect("an estimate");
    // <q²> = 1 - e^{-t} (1 + (1 - cos 2wt)/(8w²) + sin(2wt)/(4w)·...), summed here by small steps of the moment equations.
    let (mut qq, mut qp, mut pp, steps) = (0.0, 0.0, 0.0, 100_000);
    let h = 1.0 / f64::from(steps);
    let rate = |[qq, qp, pp]: [f64; 3]| [2.0 * qp, pp - qq - qp, 2.0 - 2.0 * pp - 2.0 * qp];
    for _ in 0..steps {
        let [a, b, c] = rate([qq, qp, pp]);
        let [d, e, f] = rate([qq + 0.5 * h * a, qp + 0.5 * h * b, pp + 0.5 * h * c]);
        (qq, qp, pp) = (qq + h * d, qp + h * e, pp + h * f);
    }
    assert!((estimate.mean() - qq).abs() < 4.0 * estimate.error(), "{} {qq}", estimate.mean());
    // The variance of the levels falls by h²: strong order one.
    let slope = estimate.variance_slope().expect("a slope");
    assert!((1.6..2.5).contains(&slope), "{slope}");
}
