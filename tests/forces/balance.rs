//! Work and heat: `W = ΔH - Q` to the last digit, and Jarzynski's equality, which holds for it at every step size.
//!
//! The work on a harmonic trap that moves is normally distributed, and `⟨e^{-W/kT}⟩ = 1` then says that its variance is `2 kT` times its mean.
//! Exact values for `h = 0`: moving (k = 2, v = 1, γ = 0.7, kT = 1/2, t = 2) mean 2.36370063415750729; stiffening (k from 1 to 3, v = 0) mean
//! 0.376932473625614843, variance 0.16574672994829, and `⟨e^{-W/kT}⟩ = 1/√3` at every `h`.

use wzvi::ensemble::Statistics;
use wzvi::prelude::*;

const GAMMA: f64 = 0.7;
const KT: f64 = 0.5;

/// A trap that moves and stiffens.
#[hamiltonian(
    drift = |q, p, t| 0.5 * p * p + 0.5 * (k + rate * t) * (q - v * t) * (q - v * t),
    friction = GAMMA,
    temperature = KT,
    embedding = [Baoab, Thermostat<Midpoint>],
)]
#[derive(Clone, Copy)]
struct Trap {
    k: f64,
    rate: f64,
    v: f64,
}

/// Without a bath.
#[hamiltonian(drift = |q, p, t| 0.5 * p * p + 0.5 * q * q - q * (0.3 * t).sin(), embedding = Verlet)]
struct Driven;

const MOVING: Trap = Trap { k: 2.0, rate: 0.0, v: 1.0 };
const STIFFENING: Trap = Trap { k: 1.0, rate: 1.0, v: 0.0 };
const PATHS: u64 = 8_000;

/// Paths to `t = 2` from equilibrium, with their work.
fn paths<E>(trap: &Trap, h: f64) -> Statistics
where
    Trap: Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 1>>,
{
    let deviation = (KT / trap.k).sqrt();
    let run = trap
        .ensemble::<E>(h)
        .starts(move |draw| State::new([deviation * draw.normal()], [KT.sqrt() * draw.normal()]));
    run.paths(PATHS).seed(4).until(2.0).observe_work().keep_paths(1 << 26).run().unwrap()
}

/// Mean, variance and `⟨e^{-W/kT}⟩` with its standard error.
fn work(statistics: &Statistics) -> (f64, f64, [f64; 2]) {
    let kept = statistics.paths().unwrap();
    let column = statistics.observables().iter().position(|name| name == "work").unwrap();
    let last = statistics.nodes().len() - 1;
    let work: Vec<f64> = (0..kept.count()).map(|path| kept.at(path, last).unwrap()[column]).collect();
    let n = work.len() as f64;
    let moments = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / n;
        (mean, values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n - 1.0))
    };
    let (mean, variance) = moments(&work);
    let weights: Vec<f64> = work.iter().map(|w| (-w / KT).exp()).collect();
    let (weight, spread) = moments(&weights);
    (mean, variance, [weight, (spread / n).sqrt()])
}

fn moving<E>(h: f64) -> f64
where
    Trap: Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 1>>,
{
    let (mean, variance, _) = work(&paths::<E>(&MOVING, h));
    let n = PATHS as f64;
    // Of normal samples: independent errors √(v/n) of the mean and v √(2/n) of the variance; four of both together.
    let error = (variance / n + (2.0 * variance * variance / n) / (4.0 * KT * KT)).sqrt();
    println!("h = {h}: mean {mean:.4}, variance / 2 kT {:.4}, error {error:.4}", variance / (2.0 * KT));
    assert!((mean - variance / (2.0 * KT)).abs() < 4.0 * error, "{h}: {mean} {variance}");
    mean
}

#[test]
fn jarzynski_holds_for_the_moving_trap_at_every_step_size() {
    moving::<Baoab>(0.5);
    moving::<Thermostat<Midpoint>>(0.5);
    // Of order two: h² leaves less than the statistical error, of a variance of `2 kT` times the mean.
    let (mean, exact) = (moving::<Baoab>(1.0 / 32.0), 2.363_700_634_157_507);
    assert!((mean - exact).abs() < 4.0 * (2.0 * KT * exact / PATHS as f64).sqrt(), "{mean}");
}

#[test]
fn jarzynski_holds_for_the_stiffening_trap_at_every_step_size() {
    for h in [0.5, 1.0 / 32.0] {
        let (mean, variance, [weight, error]) = work(&paths::<Baoab>(&STIFFENING, h));
        println!("h = {h}: mean {mean:.4}, variance {variance:.4}, weight {weight:.4} ± {error:.4}");
        assert!((weight - 3.0_f64.sqrt().recip()).abs() < 4.0 * error, "{h}: {weight} ± {error}");
        if h < 0.1 {
            let error = (0.165_746_729_949_28 / PATHS as f64).sqrt();
            assert!((mean - 0.376_932_473_625_614_8).abs() < 4.0 * error, "{mean}");
        }
    }
}

/// Along one path: `ΔH = W + Q`, the shadow part falls with the step size, and an ensemble observes the same.
#[test]
fn work_is_what_heat_leaves() {
    let mut shadows = Vec::new();
    for h in [0.1, 0.05, 0.025] {
        let start = State::new([0.3], [-0.2]);
        // Without noise in the bath the path is the same for all step sizes.
        let run = MOVING.simulate::<Baoab>(h).start(start).until(2.0);
        let path = run.noise(Increments::from(vec![0.0; 80])).run().unwrap();
        let gained = MOVING.energy(path.last()) - MOVING.energy(&start);
        assert!((gained - path.work() - path.heat()).abs() < 1e-14 && path.work() > 0.1);
        shadows.push(path.shadow_work().unwrap().abs());
    }
    println!("{shadows:?}");
    assert!(shadows[0] > 3.0 * shadows[1] && shadows[1] > 3.0 * shadows[2], "{shadows:?}");

    let start = State::new([0.1], [0.4]);
    // The last step is shorter.
    let ensemble = || MOVING.ensemble::<Baoab>(0.125).start(start).paths(3).seed(9).until(1.93);
    let statistics = ensemble().observe_work().keep_paths(1 << 20).run().unwrap();
    let kept = statistics.paths().unwrap();
    let unobserved = ensemble().keep_paths(1 << 20).run().unwrap();
    for path in 0..3 {
        // With arithmetic only, observing changes no bit of the path.
        for node in 0..statistics.nodes().len() {
            let alone = unobserved.paths().unwrap().at(path as usize, node).unwrap();
            assert!(kept.at(path as usize, node).unwrap().starts_with(alone), "{path} {node}");
        }
        let noise = wzvi::noise::StepNormals::seed(9).path(path);
        let single = MOVING.simulate::<Baoab>(0.125).start(start).noise(noise).until(1.93).run().unwrap();
        let values = kept.at(path as usize, statistics.nodes().len() - 1).unwrap();
        let own = [single.work(), single.shadow_work().unwrap(), single.heat()];
        let observed = &values[values.len() - 3..];
        for (own, observed) in own.iter().zip(observed) {
            assert!((own - observed).abs() < 1e-13, "{own} {observed}");
        }
    }
    assert!(ensemble().observe_work().retry(Retry::halving(2)).run().is_err());
}

/// Explicit time alone: all of what the energy gains is work.
#[test]
fn a_driven_oscillator_takes_work() {
    let start = State::new([0.0], [1.0]);
    let path = Driven.simulate::<Verlet>(0.05).start(start).until(10.0).run().unwrap();
    assert_eq!(path.work(), Driven.energy(path.last()) - Driven.energy(&start));
    assert!(path.work() != 0.0 && path.heat() == 0.0 && path.shadow_work().is_none());
}
