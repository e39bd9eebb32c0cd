//! `Gjf` and `GjI`: steps of the reference, at every size and in lanes; the law of positions and the diffusion of linear systems, exactly.

use fixtures::bath::{Oscillator, stationary};
use fixtures::reference::{data, number, numbers};
use serde_json::Value;
use wzvi::error::{BathError, ConfigError, StepFailure};
use wzvi::prelude::*;

/// Quartic oscillators beside each other.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| (0..q.len())
        .map(|i| 0.5 * p[i] * p[i] / m + 0.5 * q[i] * q[i] + 0.25 * q[i].powi(4))
        .sum::<f64>(),
    friction = gamma,
    temperature = kt,
    embedding = [Gjf, GjI],
)]
#[derive(Clone, Debug)]
pub struct Many {
    pub m: f64,
    pub gamma: f64,
    pub kt: f64,
}

/// Two free masses with a friction matrix.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px / m + py * py / n),
    damping = damping,
    temperature = kt,
    embedding = [Gjf, GjI],
)]
#[derive(Clone, Debug)]
pub struct Plane {
    pub m: f64,
    pub n: f64,
    pub damping: [[f64; 2]; 2],
    pub kt: f64,
}

/// A noise beside the bath.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p,
    noise = [|q, _| -s * q],
    friction = gamma,
    temperature = kt,
    embedding = [Gjf, GjI],
)]
#[derive(Clone, Debug)]
pub struct Shaken {
    pub s: f64,
    pub gamma: f64,
    pub kt: f64,
}

/// Friction of the first site, and of the others unless it has it alone.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i]).sum::<f64>(),
    friction = |q: &[f64]| (0..q.len()).map(|i| if i == 0 { gamma } else { gamma * (1.0 - only) }),
    embedding = GjI,
)]
struct Rates {
    gamma: f64,
    only: f64,
}

/// Steps of the reference, of one oscillator and of three beside each other.
fn check_reference<E>(case: &Value)
where
    Oscillator: Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 1>>,
    Many: Discretized<E, Vector = wzvi::nalgebra::DVector<f64>>,
{
    let of = |name: &str| number(&case[name]);
    let (m, kt, gamma, h, q0, p0) = (of("m"), of("kT"), of("friction_rate"), of("h"), of("q0"), of("p0"));
    let single = Oscillator { m, k: 1.0, b: 1.0, gamma, kt };
    let many = Many { m, gamma, kt };
    let mut state = State::new([q0], [p0]);
    let mut states = State::new(vec![q0; 3], vec![p0; 3]);
    let (mut stepper, mut steppers) = (single.stepper::<E>(h).unwrap(), many.stepper::<E>(h).unwrap());
    let (normals, q, p) = (numbers(&case["normals"]), numbers(&case["q"]), numbers(&case["p"]));
    assert_eq!(normals.len(), 6);
    for ((normal, q), p) in normals.iter().zip(q).zip(p) {
        let dw = h.sqrt() * normal;
        stepper.step(&mut state, &[dw]).unwrap();
        steppers.step(&mut states, &[dw; 3]).unwrap();
        for (found, expected) in [(state.q[0], q), (state.p[0], p), (states.q[2], q), (states.p[1], p)] {
            // Some ten roundings of numbers of the size of 1, six times.
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
    }
}

#[test]
fn steps_are_those_of_the_reference() {
    let data = data("gjf_steps");
    check_reference::<Gjf>(&data["GJF"]);
    check_reference::<GjI>(&data["GJ-I"]);
}

/// Every normal moves a free particle by `b + a d/(1 - c)` in the end, where a step is `q + a p + b ξ`, `c p + d ξ`.
fn diffusion<E>(system: &Oscillator, h: f64) -> f64
where
    Oscillator: Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 1>>,
{
    let of = |p: f64, dw: f64| {
        let mut state = State::new([0.0], [p]);
        system.stepper::<E>(h).unwrap().step(&mut state, &[dw]).unwrap();
        [state.q[0], state.p[0]]
    };
    let ([a, c], [b, d]) = (of(1.0, 0.0), of(0.0, h.sqrt()));
    (b + a * d / (1.0 - c)).powi(2) / (2.0 * h)
}

#[test]
fn positions_and_diffusion_are_those_of_the_equation() {
    for x in [0.2, 1.0, 3.0] {
        let (h, m, kt) = (0.4, 0.8, 1.3);
        let gamma = x / h;
        let free = Oscillator { m, k: 0.0, b: 0.0, gamma, kt };
        let well = Oscillator { k: 2.5, ..free };
        // A sum of ten roundings, divided by 1 - c, which is 0.2 or more.
        let close =
            |found: f64, exact: f64| assert!((found / exact - 1.0).abs() < 1e-13, "{x}: {found} {exact}");
        let exact = kt / (m * gamma);
        close(diffusion::<Gjf>(&free, h), exact);
        close(diffusion::<GjI>(&free, h), exact);
        close(diffusion::<Baoab>(&free, h), exact * (0.5 * x) / (0.5 * x).tanh());
        for law in
            [stationary::<Gjf, _>(&well, h), stationary::<GjI, _>(&well, h), stationary::<Baoab, _>(&well, h)]
        {
            // Sums of some hundred terms.
            assert!((law.m11 * 2.5 / kt - 1.0).abs() < 1e-12, "{x}: {law}");
        }
    }
}

#[test]
fn friction_matrices_are_taken_by_cayley_s_map() {
    let (h, m, n, damping, kt) = (0.5, 0.8, 2.0, [[1.5, 0.4], [0.4, 3.0]], 1.3);
    let plane = Plane { m, n, damping, kt };
    let column = |p: [f64; 2], dw: [f64; 2]| {
        let mut state = State::new([0.0, 0.0], p);
        plane.stepper::<Gjf>(h).unwrap().step(&mut state, &dw).unwrap();
        [state.p[0], state.p[1]]
    };
    let kept = [column([1.0, 0.0], [0.0; 2]), column([0.0, 1.0], [0.0; 2])];
    let noise = [column([0.0; 2], [h.sqrt(), 0.0]), column([0.0; 2], [0.0, h.sqrt()])];
    let rate = |i: usize, j: usize| 0.5 * h * damping[i][j] / [m, n][j];
    for i in 0..2 {
        for j in 0..2 {
            let unit = f64::from(u8::from(i == j));
            let left: f64 = (0..2).map(|k| (f64::from(u8::from(i == k)) + rate(i, k)) * kept[j][k]).sum();
            assert!((left - (unit - rate(i, j))).abs() < 1e-14, "{i} {j} {left}");
            // R Rᵀ = kT (M - E M Eᵀ)
            let square: f64 = (0..2).map(|k| noise[k][i] * noise[k][j]).sum();
            let rest = unit * [m, n][i] - (0..2).map(|k| kept[k][i] * [m, n][k] * kept[k][j]).sum::<f64>();
            assert!((square - kt * rest).abs() < 1e-14, "{i} {j} {square}");
        }
    }
    let error = plane.stepper::<GjI>(h).expect_err("two rates");
    assert_eq!(error, ConfigError::Bath(BathError::Rates));
    // The first site is not all that is asked where only the state says how many there are.
    let mut state = State::new(vec![0.1; 3], vec![0.0; 3]);
    let falls = |only: bool| Rates { gamma: 1.0, only: f64::from(u8::from(only)) };
    let mut step = |only| {
        let (system, before) = (falls(only), state.clone());
        let outcome = system.stepper::<GjI>(h).expect("one rate so far").step(&mut state, &[]);
        assert_eq!(outcome.is_err(), state == before);
        outcome.map_err(|error| error.cause)
    };
    assert_eq!(step(true).unwrap_err(), StepFailure::Bath(BathError::Rates));
    assert!(step(false).is_ok());
    let shaken = Shaken { s: 0.1, gamma: 1.0, kt: 1.0 };
    assert!(shaken.stepper::<GjI>(h).is_err() && shaken.stepper::<Gjf>(h).is_ok());
}

/// Runs in lanes of several widths and path by path.
macro_rules! check_lanes {
    ($run:expr) => {{
        let run = || $run.paths(21).seed(5).observe("q", |state| state.q[0]);
        assert!(fixtures::stepped::every_split(run).variance("q").expect("a variance") > 0.0);
    }};
}

#[test]
fn paths_in_lanes_are_those_by_themselves() {
    let single = Oscillator { m: 0.8, k: 1.0, b: 1.0, gamma: 0.9, kt: 1.3 };
    let start = || State::new([0.3], [-0.4]);
    check_lanes!(single.ensemble::<Gjf>(0.2).start(start()).steps(20));
    check_lanes!(single.ensemble::<GjI>(0.2).start(start()).steps(20));
    let systems = || (0..21).map(|i| Oscillator { gamma: 0.5 + 0.1 * f64::from(i), ..single.clone() });
    check_lanes!(single.ensemble::<Gjf>(0.2).systems_from(systems()).start(start()).steps(20));
    check_lanes!(single.ensemble::<GjI>(0.2).systems_from(systems()).start(start()).steps(20));
    // Large enough to go tile by tile.
    let many = Many { m: 0.8, gamma: 0.9, kt: 1.3 };
    let wave = |phase: f64| (0..523).map(|i| (0.7 * f64::from(i) + phase).sin()).collect::<Vec<_>>();
    check_lanes!(many.ensemble::<Gjf>(0.1).start(State::new(wave(0.0), wave(1.0))).steps(11));
    check_lanes!(many.ensemble::<GjI>(0.1).start(State::new(wave(0.0), wave(1.0))).steps(11));
}

#[test]
fn equations_say_how_fast_a_free_particle_diffuses() {
    let of = |text: &str| text.lines().find(|line| line.contains("diffuses")).expect("a fact").to_owned();
    assert!(of(<Oscillator as Discretized<Baoab>>::EQUATIONS).contains("(γh/2) coth(γh/2)"));
    assert!(of(<Oscillator as Discretized<Gjf>>::EQUATIONS).contains("that of the equation"));
    assert!(of(<Oscillator as Discretized<GjI>>::EQUATIONS).contains("that of the equation"));
}
