//! Every kind of struct, and every way to name what it holds.
#![deny(warnings)]

use std::f64::consts::PI;
use wzvi::prelude::*;

const STIFFNESS: f64 = 2.0;
static GRAVITY: f64 = 9.81;
const TABLE: [f64; 3] = [1.0, 2.0, 3.0];
mod units {
    pub const METRE: f64 = 1.0;
}

#[hamiltonian(
    drift = |q, p| self.mass * p * p + 2.0 * mass + (*self).mass * q * q + STIFFNESS * PI + GRAVITY + Self::SCALE
        + units::METRE * std::f64::consts::E + TABLE[1] * q + f64::MAX.recip() + f64::from(steps) + steps as f64
        + (self.steps as f64) * q.powi(steps) + weights[1] * q + self.weights[0] + grid[1][0] + table[3] + boxed[0]
        + weights.iter().zip(&[q, p]).map(|(w, x)| w * x).sum::<f64>() + table.len() as f64,
    embedding = Midpoint,
)]
#[derive(Clone, Debug, Default)]
pub struct Everything {
    mass: f64,
    steps: i32,
    weights: [f64; 2],
    grid: [[f64; 2]; 2],
    table: Vec<f64>,
    boxed: Box<[f64]>,
    /// No Hamiltonian reads it.
    pub name: String,
    pub callback: Option<fn(f64) -> f64>,
}

impl Everything {
    const SCALE: f64 = 0.5;
}

#[hamiltonian(drift = |q, p| 0.5 * self.0 * p * p + self.1[1] * q * q, embedding = [Midpoint, DeltaPlus])]
struct Tuple(f64, [f64; 2]);

#[hamiltonian(drift = |q, p| 0.5 * p * p + q * q, embedding = Midpoint)]
struct Unit;

#[hamiltonian(drift = |q, p| 0.5 * p * p + q * q, embedding = Midpoint)]
struct Empty {}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + values[0] * q * q + N as f64 + weights.iter().sum::<f64>(),
    embedding = [Midpoint, DeltaPlus],
)]
struct Generic<'a, T: Clone + 'a, const N: usize = 3>
where
    T: Default,
{
    values: &'a [f64],
    weights: [f64; 2],
    extra: [T; N],
}

#[test]
fn compiles_and_runs() {
    let state = State::new([0.5], [2.0]);
    let everything = Everything {
        mass: 1.5,
        steps: 2,
        weights: [1.0, 2.0],
        grid: [[1.0, 2.0], [3.0, 4.0]],
        table: vec![1.0; 4],
        boxed: vec![7.0].into(),
        ..Everything::default()
    };
    let _ = (&everything.name, everything.callback);
    let (q, p) = (0.5f64, 2.0f64);
    let expected = 1.5 * p * p
        + 1.5
        + 1.5
        + 1.5 * q * q
        + STIFFNESS * PI
        + GRAVITY
        + 0.5
        + std::f64::consts::E
        + 2.0 * q
        + 2.0
        + 2.0
        + 2.0 * q * q
        + 2.0 * q
        + 1.0
        + 3.0
        + 1.0
        + 7.0
        + (q + 2.0 * p)
        + 4.0;
    let energy = everything.energy(&state);
    assert!((energy - expected).abs() < 1e-13 * expected, "{energy} {expected}");
    assert_eq!(Tuple(2.0, [0.0, 3.0]).energy(&state), 4.0 + 0.75);
    assert_eq!(Unit.energy(&state), Empty {}.energy(&state));
    let values = [4.0];
    let generic = Generic::<String> { values: &values, weights: [0.25, 0.75], extra: Default::default() };
    let _ = &generic.extra;
    assert_eq!(generic.energy(&state), 2.0 + 1.0 + 3.0 + 1.0);
    let mut state = state;
    generic.stepper::<Midpoint>(0.1).unwrap().step(&mut state, &[]).unwrap();
    Tuple(1.0, [1.0; 2]).stepper::<DeltaPlus>(0.1).unwrap().step(&mut state, &[]).unwrap();
}
