//! The remedies of messages compile, and mean what the messages say.

use wzvi::prelude::*;
use wzvi::state::Vector as _;

/// Integers among real numbers, powers and functions of integers.
#[hamiltonian(
    drift = |q, p| {
        let scaled = (n as f64) * (n as f64) * q + ((n as f64) + 1.0) / 2.0 * q + ((n % 3) as f64) * q;
        let roots = 2.0_f64.sqrt() + (n as f64).sqrt() + ((n as f64) + 1.0).sqrt();
        let step = if (n as f64) < -1.0 { 1.0 } else { 0.0 };
        let powers = q.powi(n.pow(2)) + q * (-2_i32).pow(3) as f64 + q * n.max(3) as f64;
        1.0 / 2.0 * p * p + scaled + powers + roots + step
    },
    embedding = DeltaPlus,
)]
struct Integers {
    n: i32,
}

/// The operators of conditions.
#[hamiltonian(
    drift = |q, p| {
        let a = q > 0.0;
        let slope = if !a ^ (q < 2.0) { 1.0 } else { 2.0 };
        let other = if a & (q > 0.5) | (q < -7.0) { 10.0 } else { 20.0 };
        0.5 * p * p + (slope + other) * q
    },
    embedding = DeltaPlus,
)]
struct Conditions;

/// The square of a long sum as a double sum.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        let square = (0..n).map(|i| (0..n).map(|j| q[i] * q[j]).sum::<f64>()).sum::<f64>();
        0.5 * (p.iter().map(|p| p * p).sum::<f64>() + square)
    },
    embedding = Midpoint,
)]
struct Square;

/// A function of a sum whose length is a literal.
#[hamiltonian(
    drift = |q: [f64; 8], p: [f64; 8]| 0.5 * p.iter().map(|p| p * p).sum::<f64>() + q.iter().sum::<f64>().sin(),
    embedding = DeltaPlus,
)]
struct Sine;

/// Sums and products of real numbers need no type.
#[hamiltonian(
    drift = |q: [f64; 3], p: [f64; 3]| {
        let sum = q.iter().sum();
        let count: usize = (0..3_usize).sum();
        0.5 * p.iter().map(|p| p * p).sum() + sum * count as f64 + q.iter().product() + weights.iter().sum().sqrt()
    },
    force = |q, p| p.map(|x| -g.iter().sum() * x),
    embedding = Midpoint,
)]
struct Untyped {
    weights: [f64; 3],
    g: Vec<f64>,
}

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| 0.5 * p.iter().map(|p| p * p).sum() + q.iter().map(|q| q * q).sum(),
    embedding = Midpoint,
)]
struct Long;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    force = |q, p, t| -gamma * (1.0 + t) * p,
    embedding = [Verlet, Midpoint],
)]
struct Damped {
    gamma: f64,
}

#[hamiltonian(drift = |q, p, tau| 0.5 * p * p + q * tau, noise = [|q, p, t0| q * t0, |q, _, _| q], embedding = Midpoint)]
struct Times;

/// The change of p in one explicit step of size 1 from q, at rest: the force.
fn force<H: Discretized<DeltaPlus>>(system: &H, start: State<H::Vector>) -> Result<f64, wzvi::Error> {
    let (mut state, before) = (start.clone(), start);
    system.stepper::<DeltaPlus>(1.0)?.step(&mut state, &[])?;
    Ok(state.p.components()[0] - before.p.components()[0])
}

#[test]
fn remedies_compile_and_mean_what_rust_means() -> Result<(), wzvi::Error> {
    // n = 2: 4 + 3/2 + 2, 4 q^3 = 4 at q = 1, -8, 3.
    assert_eq!(force(&Integers { n: 2 }, State::new([1.0], [0.0]))?, -(7.5 + 4.0 - 8.0 + 3.0));
    // q = 1: not a is false, q < 2 is true, so they differ; q > 1/2.
    assert_eq!(force(&Conditions, State::new([1.0], [0.0]))?, -(1.0 + 10.0));
    assert_eq!(force(&Conditions, State::new([0.25], [0.0]))?, -(1.0 + 20.0));
    assert_eq!(force(&Conditions, State::new([3.0], [0.0]))?, -(2.0 + 10.0));
    assert_eq!(force(&Sine, State::new([0.0; 8], [0.0; 8]))?, -1.0);

    let start = State::new(vec![1.0, 2.0, 4.0], vec![0.0; 3]);
    assert_eq!(Square.energy(&start), 0.5 * 49.0);
    assert_eq!(Long.energy(&start), 21.0);
    let untyped = Untyped { weights: [1.0, 1.0, 2.0], g: vec![1.0, 2.0] };
    assert_eq!(untyped.energy(&State::new([1.0, 2.0, 4.0], [2.0, 0.0, 0.0])), 2.0 + 21.0 + 8.0 + 2.0);

    let damped = Damped { gamma: 0.1 };
    let start = State::new([1.0], [0.0]);
    let run = damped.simulate::<Composed<Verlet, Yoshida4>>(0.1).start(start).steps(10).run();
    assert!(run?.last().q[0] < 1.0);
    let run = damped.simulate::<Composed<Verlet, KahanLi8>>(0.1).start(start).steps(10).run();
    assert!(run?.last().q[0] < 1.0);
    assert_eq!(Times.noises(), 2);
    Ok(())
}
