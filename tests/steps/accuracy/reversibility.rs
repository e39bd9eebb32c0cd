//! There and back, and noise that multiplies: very large and very small.

use fixtures::extremes::Random;
use fixtures::steps::{distance, numbers, refused};
use wzvi::error::StepFailure;
use wzvi::prelude::*;

use super::reference::{Case, compare, state};
use super::systems::{DoubleWell, Growth, Kepler, Kubo, Oscillator, Pendulum};

/// How far a step by `E` and one back by `B` miss the start, in units in the last place of the largest component met.
fn miss<E, B, H: Discretized<E> + Discretized<B>>(system: &H, case: &Case) -> f64 {
    let mut state = state::<<H as Hamiltonian>::Vector>(&case.q, &case.p);
    let mut met = vec![numbers(&state)];
    Stepper::<H, E>::new(system, case.h).unwrap().step(&mut state, &case.dw).unwrap();
    met.push(numbers(&state));
    let back: Vec<f64> = case.dw.iter().map(|dw| -dw).collect();
    Stepper::<H, B>::new(system, -case.h).unwrap().step(&mut state, &back).unwrap();
    let largest = met.iter().flatten().fold(0.0_f64, |size, x| size.max(x.abs()));
    distance(&numbers(&state), &met[0]) / (f64::EPSILON * largest)
}

/// Both steps round every component by one unit at most, and each passes on what it is given by a factor of two at most.
const RETURN: f64 = 8.0;

fn returns<E, B, H: Discretized<E> + Discretized<B>>(name: &str, system: &H, noises: usize) {
    let mut random = Random(5);
    let d = system.degrees();
    let mut worst = 0.0_f64;
    for _ in 0..1000 {
        let mut numbers =
            |n: usize, size: f64| -> Vec<f64> { (0..n).map(|_| size * random.uniform()).collect() };
        let mut case = Case { h: 0.0, q: numbers(d, 1.0), p: numbers(d, 1.0), dw: numbers(noises, 0.3) };
        case.q[0] += 1.5;
        case.h = 0.1 * random.uniform();
        worst = worst.max(miss::<E, B, H>(system, &case));
    }
    println!("{name:28} {worst:.2} units in the last place");
    assert!(worst <= RETURN, "{name}: {worst}");
}

/// `Δ+` and `Δ-` are adjoint, the mid-point scheme is adjoint to itself: `Φ*_{-h, -ΔW} Φ_{h, ΔW} = 1`.
#[test]
fn a_step_and_its_adjoint_backwards_return_to_the_start() {
    let (oscillator, pendulum) = (Oscillator { omega: 1.3 }, Pendulum { m: 0.7, k: 1.9 });
    returns::<Midpoint, Midpoint, _>("oscillator, mid-point", &oscillator, 0);
    returns::<DeltaPlus, DeltaMinus, _>("oscillator, Δ+ then Δ-", &oscillator, 0);
    returns::<DeltaMinus, DeltaPlus, _>("oscillator, Δ- then Δ+", &oscillator, 0);
    returns::<Midpoint, Midpoint, _>("pendulum, mid-point", &pendulum, 0);
    returns::<DeltaPlus, DeltaMinus, _>("pendulum, Δ+ then Δ-", &pendulum, 0);
    returns::<Midpoint, Midpoint, _>("Kepler, mid-point", &Kepler, 0);
    let (kubo, well) = (Kubo { a: 1.5, sigma: 1.0 }, DoubleWell { sigma: 0.3 });
    returns::<Midpoint, Midpoint, _>("Kubo, mid-point", &kubo, 1);
    returns::<Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, _>("Kubo, Δ+ then Δ-", &kubo, 1);
    returns::<Midpoint, Midpoint, _>("double well, mid-point", &well, 1);
    returns::<Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, _>("double well, Δ+ then Δ-", &well, 1);
}

/// The step is a rotation, whatever its angle: the radius is kept to a few roundings, and it can be undone.
///
/// With `θ = (a h + σ ΔW)/2` the step adds the change of the momentum before it multiplies by `2 θ`: what that rounds is
/// enlarged by `2 θ` where that is more than one.
#[test]
fn noise_of_any_size_rotates_and_returns() {
    let mut worst = [0.0_f64; 2];
    for sigma in [1e-3, 1.0, 1e3] {
        for h in [1e-12, 1e-3, 1.0, 1e6] {
            for dw in [-1e3, -1.0, 1e-6, 0.5, 1e3] {
                let kubo = Kubo { a: 1.5, sigma };
                let angle = (1.5 * h + sigma * dw).abs().max(1.0);
                let case = Case { h, q: vec![0.6], p: vec![0.8], dw: vec![dw] };
                let mut there = state::<<Kubo as Hamiltonian>::Vector>(&case.q, &case.p);
                kubo.stepper::<Midpoint>(h).unwrap().step(&mut there, &case.dw).unwrap();
                let radius = (there.q[0].hypot(there.p[0]) - 1.0).abs() / f64::EPSILON / angle;
                let returned = miss::<Midpoint, Midpoint, _>(&kubo, &case) / angle;
                assert!(radius <= 4.0 && returned <= RETURN, "σ = {sigma:e}, {case:?}: {radius} {returned}");
                worst = [worst[0].max(radius), worst[1].max(returned)];
            }
        }
    }
    println!("radius {:.2}, return {:.2} units in the last place, per max(1, 2θ)", worst[0], worst[1]);
}

/// The pole is where `a h + σ ΔW = 2`: on either side of it the step is right to what rounding leaves of the distance,
/// on it the step is singular.
#[test]
fn multiplicative_noise_near_its_pole() {
    let growth = Growth { a: 0.0, sigma: 1.0 };
    for exponent in 1..=14 {
        for side in [-1.0, 1.0] {
            let dw = 2.0 * (1.0 + side * 10.0_f64.powi(-exponent));
            let case = Case { h: 0.01, q: vec![0.6], p: vec![0.8], dw: vec![dw] };
            let errors = compare::<Midpoint, _>(&growth, &case).unwrap();
            assert!(errors.conditioned <= 2.0, "{case:?}: {errors:?}");
        }
    }
    for dw in [-2.0, 2.0] {
        let mut stepper = growth.stepper::<Midpoint>(0.01).unwrap();
        let cause = refused(&State::new([0.6], [0.8]), |state| stepper.step(state, &[dw])).cause;
        assert!(matches!(cause, StepFailure::Singular { .. }), "{cause:?}");
    }
}

/// With σ = 1 and h = 0.01 truncated increments stay below `A_h √h` = 0.61 and never meet the pole at 2. Without
/// truncation, and with σ = 20 with it, they may cross it: every step is then a finite state or an error all the same.
#[test]
fn truncation_keeps_away_from_the_pole() {
    let h = 0.01_f64;
    let bound = h.sqrt() * (8.0 * -h.ln()).sqrt();
    let start = || state::<<Growth as Hamiltonian>::Vector>(&[0.6], &[0.8]);
    let growth = Growth { a: 0.0, sigma: 1.0 };
    for seed in 0..20 {
        let path = growth
            .simulate::<Midpoint>(h)
            .start(start())
            .noise(Wiener::seed(seed))
            .steps(2000)
            .run()
            .unwrap();
        assert!(path.increments().all(|dw| dw[0].abs() <= bound * (1.0 + 4.0 * f64::EPSILON)));
        // The step multiplies q and p by inverse factors: q p is a first integral, kept to a random walk of roundings.
        let product = path.last().q[0] * path.last().p[0] / 0.48;
        assert!((product - 1.0).abs() <= 10.0 * f64::EPSILON * 2000.0_f64.sqrt(), "{product}");
    }
    let wild = Growth { a: 0.0, sigma: 20.0 };
    for seed in 0..20 {
        for noise in [Wiener::seed(seed), Wiener::seed(seed).untruncated()] {
            if let Ok(path) = wild.simulate::<Midpoint>(h).start(start()).noise(noise).steps(200).run() {
                assert!(path.iter().all(|state| state.q[0].is_finite() && state.p[0].is_finite()));
            }
        }
    }
}
