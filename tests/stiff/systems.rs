//! Systems at whose steps the fixed point does not contract, for their tests and their bench.

use wzvi::prelude::*;

/// FPUT-alpha-beta, ends fixed.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let v = |d: f64| 0.5 * d * d + alpha / 3.0 * d.powi(3) + 0.25 * beta * d.powi(4);
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (1..n).map(|i| v(q[i] - q[i - 1])).sum::<f64>()
            + v(q[0]) + v(-q[n - 1])
    },
    embedding = Midpoint,
)]
pub(crate) struct Fput {
    pub(crate) alpha: f64,
    pub(crate) beta: f64,
}

/// A field on a torus with springs of any stiffness, in wells that are not linear: φ⁴.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (0..side)
                .map(|i| {
                    (0..side)
                        .map(|j| {
                            let own = q[i * side + j];
                            let right = q[i * side + (j + 1) % side];
                            let down = q[(i + 1) % side * side + j];
                            let bonds = (right - own) * (right - own) + (down - own) * (down - own);
                            0.5 * stiffness * bonds + 0.25 * depth * (own * own - 1.0) * (own * own - 1.0)
                        })
                        .sum::<f64>()
                })
                .sum::<f64>()
    },
    embedding = Midpoint,
)]
pub(crate) struct Torus {
    pub(crate) side: usize,
    pub(crate) stiffness: f64,
    pub(crate) depth: f64,
}

/// Long waves of a chain that is not linear: the second derivatives change little from step to step.
pub(crate) fn waves(n: usize) -> Vec<f64> {
    let mode = |k: f64, i: usize| (std::f64::consts::PI * k * (i + 1) as f64 / (n + 1) as f64).sin();
    (0..n).map(|i| mode(1.0, i) + 0.2 * mode(7.0, i)).collect()
}

/// A thousandth of a long wave about the bottom of the wells.
pub(crate) fn field(side: usize) -> Vec<f64> {
    let turn = std::f64::consts::TAU / side as f64;
    let at = |i: usize, j: usize| (turn * i as f64).sin() * (2.0 * turn * j as f64).cos();
    (0..side * side).map(|k| 1.0 + 0.001 * at(k / side, k % side)).collect()
}
