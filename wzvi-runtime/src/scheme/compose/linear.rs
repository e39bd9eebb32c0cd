//! The flow of a quadratic Hamiltonian, by a matrix exponential.
//!
//! `H = x·Kx/2 + b·x` with `x = (q, p)` and constant `K`, `b` has the equations of motion `x' = J(Kx + b)`,
//! and the flow over `s` is `x ← x + D(s) x + d(s)`, `D = e^(sJK) - 1`, `d = ∫_0^s e^(rJK) J b dr`: both
//! follow from the exponential of the matrix `M = [[JK, Jb], [0, 0]]`, which has one more row. `D` is summed
//! for a small `s` and doubled by `D(2s) = 2 D(s) + D(s)²`, so that the difference to 1 keeps its digits (N.
//! J. Higham, *Functions of Matrices*, SIAM 2008, section 10.3).
//!
//! The action `∫ p · q' - H` over the flow is that of a homogeneous form, `[p · q] / 2`, less `∫ b · x / 2`,
//! which takes one more row of `M`.
//!
//! Degrees of freedom that `K` does not couple have separate exponentials.

use crate::algebra::scalar::{ComputesWith, Constant, Mask as _, Scalar};
use crate::error::ConfigError;

/// The flow over a fixed time.
#[derive(Clone, Debug)]
pub(super) struct LinearFlow<K = f64> {
    blocks: Vec<CoupledGroup<K>>,
}

/// The flow of a group of coupled degrees of freedom.
#[derive(Clone, Debug)]
struct CoupledGroup<K> {
    /// The degrees of freedom; `x` are their coordinates, then their momenta.
    degrees: Vec<usize>,
    /// Row by row, `2n + 1` rows of `2n + 1` numbers: `D` and `d`, then the row for `-∫ b · x / 2`.
    rows: Vec<K>,
}

/// Number of terms of the sum for `D`: with a norm of at most 1/2, the first omitted term is below rounding.
const TERMS: u32 = 18;

impl<K: Constant> LinearFlow<K> {
    /// The flow over the time `s`. `slopes(x, y)` writes `∂H/∂q`, `∂H/∂p` at `x` into `y`; both have the
    /// coordinates first.
    ///
    /// # Errors
    /// [`ConfigError::Parameter`] if an entry of the matrix is not finite.
    pub(super) fn new(
        degrees: usize,
        s: K,
        slopes: &mut dyn FnMut(&[K], &mut [K]),
    ) -> Result<Self, ConfigError> {
        let size = 2 * degrees;
        let (zero, one) = (K::from_f64(0.0), K::from_f64(1.0));
        let (mut x, mut origin) = (vec![zero; size], vec![zero; size]);
        slopes(&x, &mut origin);
        // Column by column, `K`.
        let columns: Vec<Vec<K>> = (0..size)
            .map(|j| {
                let mut column = vec![zero; size];
                x[j] = one;
                slopes(&x, &mut column);
                x[j] = zero;
                column.iter_mut().zip(&origin).for_each(|(slope, origin)| *slope = *slope - *origin);
                column
            })
            .collect();
        if columns.iter().flatten().chain(&origin).any(|entry| !entry.is_finite().all()) {
            return Err(ConfigError::Parameter);
        }
        let is_coupled = |i: usize, j: usize| {
            [i, i + degrees]
                .iter()
                .any(|&row| !(columns[j][row].vanishes() & columns[j + degrees][row].vanishes()).all())
        };
        let blocks = groups(degrees, is_coupled).into_iter().map(|group| {
            let of_state: Vec<usize> =
                group.iter().copied().chain(group.iter().map(|i| i + degrees)).collect();
            let n = of_state.len();
            // `x`, a row for `-∫ b · x / 2`, and 1.
            let size = n + 2;
            let mut matrix = vec![zero; size * size];
            for row in 0..n {
                // `J`: `q' = ∂H/∂p`, `p' = -∂H/∂q`.
                let (slope, sign) =
                    if row < n / 2 { (of_state[row + n / 2], s) } else { (of_state[row - n / 2], -s) };
                for (column, &j) in of_state.iter().enumerate() {
                    matrix[row * size + column] = sign * columns[j][slope];
                }
                matrix[row * size + n + 1] = sign * origin[slope];
                matrix[n * size + row] = s * -0.5 * origin[of_state[row]];
            }
            let exponential = exponential_less_one(matrix, size);
            let kept = exponential.chunks(size).take(n + 1);
            let rows = kept.flat_map(|row| row[..n].iter().chain(&row[n + 1..])).copied().collect();
            CoupledGroup { degrees: group, rows }
        });
        let blocks: Vec<CoupledGroup<K>> = blocks.collect();
        let is_finite = blocks.iter().flat_map(|block| &block.rows).all(|entry| entry.is_finite().all());
        if is_finite { Ok(Self { blocks }) } else { Err(ConfigError::Parameter) }
    }

    /// The increments of the state into `dq`, `dp`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn increments<S: ComputesWith<K>>(&self, [q, p]: [&[S]; 2], [dq, dp]: [&mut [S]; 2]) {
        for block in &self.blocks {
            let n = block.degrees.len();
            for (row, coefficients) in block.rows.chunks(2 * n + 1).take(2 * n).enumerate() {
                let increment = block.row(coefficients, q, p);
                let into =
                    if row < n { &mut dq[block.degrees[row]] } else { &mut dp[block.degrees[row - n]] };
                *into = increment;
            }
        }
    }
}

impl LinearFlow {
    /// `∫ p · q' - H` over the flow from one state to another.
    pub(super) fn action(&self, [q, p]: [&[f64]; 2], [next_q, next_p]: [&[f64]; 2]) -> f64 {
        let product = |p: &[f64], q: &[f64]| p.iter().zip(q).map(|(p, q)| p * q).sum::<f64>();
        let of_blocks = self.blocks.iter().map(|block| {
            let n = 2 * block.degrees.len();
            block.rows.chunks(n + 1).nth(n).map_or(0.0, |coefficients| block.row(coefficients, q, p))
        });
        0.5 * (product(next_p, next_q) - product(p, q)) + of_blocks.sum::<f64>()
    }
}

impl<K: Constant> CoupledGroup<K> {
    /// A row of the map, applied to a state of the whole system.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn row<S: ComputesWith<K>>(&self, coefficients: &[K], q: &[S], p: &[S]) -> S {
        let n = self.degrees.len();
        let mut sum = S::constant(coefficients[2 * n]);
        for (k, &i) in self.degrees.iter().enumerate() {
            sum = sum + q[i] * coefficients[k] + p[i] * coefficients[n + k];
        }
        sum
    }
}

/// The indices `0..length` in groups of coupled ones.
fn groups(length: usize, is_coupled: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut is_placed = vec![false; length];
    let mut groups = Vec::new();
    for first in 0..length {
        if is_placed[first] {
            continue;
        }
        is_placed[first] = true;
        let (mut group, mut next) = (vec![first], 0);
        while let Some(&known) = group.get(next) {
            for (other, is_placed) in is_placed.iter_mut().enumerate() {
                if !*is_placed && (is_coupled(known, other) || is_coupled(other, known)) {
                    *is_placed = true;
                    group.push(other);
                }
            }
            next += 1;
        }
        group.sort_unstable();
        groups.push(group);
    }
    groups
}

/// `e^M - 1` of a square matrix, row by row.
fn exponential_less_one<K: Constant>(mut matrix: Vec<K>, n: usize) -> Vec<K> {
    let norm = matrix.chunks(n).map(|row| row.iter().map(|x| x.magnitude()).sum::<f64>()).fold(0.0, f64::max);
    // Finite entries have sums below 2^1100.
    let halvings = (0..1100).find(|&k| norm * Scalar::powi(0.5, k) <= 0.5).unwrap_or(1100);
    let scale = Scalar::powi(0.5, halvings);
    matrix.iter_mut().for_each(|x| *x = *x * scale);
    // Horner: `M (1 + M/2 (1 + M/3 (...)))`.
    let mut sum = vec![K::from_f64(0.0); n * n];
    for term in (1..=TERMS).rev() {
        for i in 0..n {
            sum[i * n + i] = sum[i * n + i] + 1.0;
        }
        sum = product(&matrix, &sum, n);
        sum.iter_mut().for_each(|x| *x = *x / f64::from(term));
    }
    for _ in 0..halvings {
        let square = product(&sum, &sum, n);
        sum.iter_mut().zip(square).for_each(|(x, square)| *x = *x * 2.0 + square);
    }
    sum
}

fn product<K: Constant>(a: &[K], b: &[K], n: usize) -> Vec<K> {
    let mut product = vec![K::from_f64(0.0); n * n];
    for (row, into) in a.chunks(n).zip(product.chunks_mut(n)) {
        for (&factor, other) in row.iter().zip(b.chunks(n)) {
            if !factor.vanishes().all() {
                into.iter_mut().zip(other).for_each(|(into, other)| *into = *into + factor * *other);
            }
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rotation, a shift, and a hyperbolic flow, which are not coupled.
    #[test]
    fn flows_are_those_of_the_closed_form() {
        // H = (q0² + p0²) ω/2 + p1²/2 + g q1 + q2 p2
        let (omega, g, s) = (40.0, 0.3, 0.7);
        let mut slopes = |x: &[f64], y: &mut [f64]| {
            y.copy_from_slice(&[omega * x[0], g, x[5], omega * x[3], x[4], x[2]]);
        };
        let linear = LinearFlow::new(3, s, &mut slopes).unwrap_or(LinearFlow { blocks: Vec::new() });
        let rows: Vec<&[f64]> = linear.blocks.iter().map(|block| block.rows.as_slice()).collect();
        let (sin, cos) = (omega * s).sin_cos();
        let exact: [[f64; 6]; 3] = [
            [cos - 1.0, sin, 0.0, -sin, cos - 1.0, 0.0],
            [0.0, s, -g * s * s / 2.0, 0.0, 0.0, -g * s],
            [s.exp_m1(), 0.0, 0.0, 0.0, (-s).exp_m1(), 0.0],
        ];
        assert_eq!(rows.len(), 3);
        for (row, exact) in rows.iter().zip(exact) {
            // The last row gives the action.
            for (ours, exact) in row[..6].iter().zip(exact) {
                // Six doublings of rotations, each with the roundings of a product.
                assert!((ours - exact).abs() < 4e-14, "{ours} {exact}");
            }
        }
    }
}
