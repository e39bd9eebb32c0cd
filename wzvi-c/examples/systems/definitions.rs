//! Straight-line steps with noise, Newton's method and a clock, and loops over a table of indices.

use wzvi::prelude::*;

/// Kubo's oscillator: a rotation whose angle diffuses.
#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
    invariant = [action = |q, p| 0.5 * (q * q + p * p)],
    observe = [radius = |q, p| (q * q + p * p).sqrt()],
    embedding = Midpoint,
    export = [],
)]
#[derive(Clone, Debug)]
pub(crate) struct Kubo {
    /// Mean angular frequency.
    pub(crate) a: f64,
    /// Intensity of the noise.
    pub(crate) sigma: f64,
}

/// A pendulum of length 1 and mass 1.
#[hamiltonian(
    drift = |angle, momentum| 0.5 * momentum * momentum - g * angle.cos(),
    clock = |angle, momentum| 1.0 / (1.0 + momentum * momentum).sqrt(),
    embedding = [Midpoint, Clocked<Verlet>],
    export = [Composed<Verlet, KahanLi8>],
)]
#[derive(Clone, Debug)]
pub(crate) struct Pendulum {
    /// Acceleration of gravity.
    pub(crate) g: f64,
}

/// Masses 1, and springs between the sites of a table.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let kinetic = p.iter().map(|p| 0.5 * p * p).sum::<f64>();
        kinetic + springs.iter().map(|&[i, j]| 0.5 * k * (q[i] - q[j]).powi(2)).sum::<f64>()
    },
    embedding = Verlet,
    export = [],
)]
#[derive(Clone, Debug)]
pub(crate) struct Network {
    /// Stiffness.
    pub(crate) k: f64,
    /// Ends of each spring.
    pub(crate) springs: Vec<[usize; 2]>,
}
