//! Sparse matrices that a renumbering of their unknowns makes narrow: `P A = L U` in the band with the pivots
//! of [`Factor`](super::Factor). Exact for chains (a band), rings (folded to a band), lattices and networks.
//!
//! G. H. Golub, C. F. Van Loan, *Matrix Computations*, section 4.3. With pivoting, `U` has as many upper
//! diagonals as `A` has in all. Rows reach that far only after exchanges, so that a wide band is eliminated
//! as far as its rows reach.

use std::ops::Mul;

use super::dense::{Candidate, PIVOT_ULPS};
use crate::algebra::scalar::{Mask, Scalar};
use crate::error::StepFailure;

/// Half-bandwidth up to which the loops of the elimination are written out, with all diagonals.
const WRITTEN_OUT: usize = 2;

/// The pivot of a row, in operations that go in vector instructions.
const PER_PIVOT: f64 = 20.0;
/// Operations that wait for each other, in operations that go in vector instructions.
const IN_TURN: f64 = 2.5;

/// A square matrix with room for its factors.
#[derive(Clone, Debug)]
pub struct Banded<S> {
    /// Diagonals on each side.
    half: usize,
    /// Whether unknowns next to each other are in blocks of `half + 1`, which have nothing in common.
    is_parted: bool,
    /// Where each unknown is in the band; empty for the order that it has.
    position: Vec<usize>,
    /// Row `i` from column `i - half`, with `half` further columns that pivoting fills. `half` rows of zeros
    /// follow the last row, so that rows at the end need no special case.
    rows: Vec<S>,
    /// Row exchanged with row `k` before column `k` was eliminated.
    exchanges: Vec<usize>,
    /// For each unknown, and with `half` on either side, or twice as many behind.
    scratch: Vec<S>,
}

impl<S: Scalar> Banded<S> {
    /// Room for a matrix of `n` unknowns with `half` diagonals on each side, in the order that `position`
    /// gives them; empty for the order that they have. `None` if it has more than `most` numbers.
    pub fn new(n: usize, half: usize, position: Vec<usize>, most: usize) -> Option<Self> {
        let numbers = half.checked_mul(3)?.checked_add(1)?.checked_mul(n.checked_add(half)?)?;
        (numbers <= most).then(|| Self::of_size(n, half, position, numbers))
    }

    /// Room for a matrix of `n` unknowns with any entry.
    pub fn dense(n: usize) -> Self {
        let half = n.saturating_sub(1);
        Self::of_size(n, half, Vec::new(), (3 * half + 1) * (n + half)).parted(true)
    }

    fn of_size(n: usize, half: usize, position: Vec<usize>, numbers: usize) -> Self {
        let zero = S::from_f64(0.0);
        Self {
            half,
            is_parted: false,
            position,
            rows: vec![zero; numbers],
            exchanges: vec![0; n],
            scratch: vec![zero; n + 2 * half],
        }
    }

    /// For a matrix of uncoupled blocks of `half + 1` consecutive unknowns, if it `is_parted`.
    #[must_use]
    pub fn parted(self, is_parted: bool) -> Self {
        Self { is_parted, ..self }
    }

    /// Diagonals on each side.
    pub fn half_width(&self) -> usize {
        self.half
    }

    /// Operations of [`Banded::factor`] without exchanges. Each pivot is found and inverted in the time of
    /// `PER_PIVOT` others.
    pub fn elimination_cost(&self) -> f64 {
        let [n, half] = [self.exchanges.len(), self.half].map(|number| number as f64);
        let per_row = if self.is_parted { half * half / 3.0 } else { half * (half + 1.0) };
        n * (per_row + PER_PIVOT)
    }

    /// Operations of [`Banded::solve`], which wait for each other: `IN_TURN` as many in the time of others.
    pub fn solution_cost(&self) -> f64 {
        let [n, half] = [self.exchanges.len(), self.half].map(|number| number as f64);
        let per_row = if self.is_parted { half + 1.0 } else { 3.0 * half + 1.0 };
        IN_TURN * n * per_row
    }

    /// Whether a band of so many unknowns is eliminated faster as a whole matrix: `n h²` operations against
    /// `n³ / 3`.
    pub fn is_dense(n: usize, half: usize) -> bool {
        half.saturating_mul(half).saturating_mul(3) > n.saturating_mul(n)
    }

    /// The identity.
    pub fn reset(&mut self) {
        self.rows.fill(S::from_f64(0.0));
        let (width, half) = (3 * self.half + 1, self.half);
        for row in self.rows.chunks_exact_mut(width).take(self.exchanges.len()) {
            row[half] = S::from_f64(1.0);
        }
    }

    /// Adds to one entry of the pattern.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn add(&mut self, row: usize, column: usize, value: S) {
        let (row, column) = match self.position.is_empty() {
            true => (row, column),
            false => (self.position[row], self.position[column]),
        };
        let at = row * (3 * self.half + 1) + column + self.half - row;
        self.rows[at] = self.rows[at] + value;
    }

    /// Factors the matrix in place.
    ///
    /// # Errors
    /// [`StepFailure::Singular`] if a pivot is at the rounding level of the terms subtracted from it.
    pub fn factor(&mut self) -> Result<(), StepFailure> {
        match (self.half, self.is_parted) {
            (1, false) => self.factor_in::<false>(1),
            (2, false) => self.factor_in::<false>(2),
            (half, false) => self.factor_in::<false>(half),
            (1, true) => self.factor_in::<true>(1),
            (half, true) => self.factor_in::<true>(half),
        }
    }

    /// [`Banded::factor`] with its loops written out where the caller knows how narrow the band is: of a
    /// chain, or of a ring. Blocks do not wait for each other.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn factor_in<const PARTED: bool>(&mut self, half: usize) -> Result<(), StepFailure> {
        let width = 3 * half + 1;
        let Self { rows, exchanges, scratch: taken, .. } = self;
        taken.fill(S::from_f64(0.0));
        // The last column that any row has reached so far; of a block, it ends at the last column of the
        // block.
        let mut last = 0;
        for (k, exchange) in exchanges.iter_mut().enumerate() {
            let (above, below) = rows.split_at_mut((k + 1) * width);
            let reach = reach::<PARTED>(half, k);
            let (own, below) = (&mut above[k * width + half..], &mut below[..reach * width]);
            let mut best = Candidate::on_diagonal(0, own[0].magnitude());
            for (row, entries) in below.chunks_exact(width).enumerate() {
                let [entry, opposite, own] =
                    [entries[half - 1 - row], own[row + 1], entries[half]].map(S::magnitude);
                best = best.or(Candidate { row: row + 1, entry, through: entry * opposite, own });
            }
            let (best, pivot) = (best.row, best.entry);
            if best > 0 {
                // The sizes of the terms subtracted from entries beside the diagonal are not known.
                (taken[k], taken[k + best]) = (S::from_f64(0.0), S::from_f64(0.0));
            }
            let scale = taken[k].magnitude();
            if !pivot.is_finite() || scale.is_nan() {
                return Err(StepFailure::NonFinite);
            }
            if pivot <= PIVOT_ULPS * scale {
                return Err(StepFailure::Singular { pivot, scale });
            }
            *exchange = k + best;
            let upper = if half <= WRITTEN_OUT {
                2 * half + 1
            } else if PARTED {
                reach + 1
            } else {
                last = last.max(k + best + half);
                last - k + 1
            };
            let own = &mut own[..upper];
            if best > 0 {
                own.swap_with_slice(&mut below[(best - 1) * width + half - best..][..upper]);
            }
            let inverse = own[0].recip();
            own[0] = inverse;
            for (row, entries) in below.chunks_exact_mut(width).enumerate() {
                let entries = &mut entries[half - 1 - row..][..upper];
                let factor = entries[0] * inverse;
                entries[0] = factor;
                let own_taken = &mut taken[k + 1 + row];
                *own_taken = S::from_f64(own_taken.magnitude() + (factor * own[row + 1]).magnitude());
                for (entry, &other) in entries[1..].iter_mut().zip(&own[1..]) {
                    *entry = *entry - factor * other;
                }
            }
        }
        Ok(())
    }

    /// Whether the determinant is negative, after [`Banded::factor`], or that of any block where there are
    /// blocks.
    pub fn is_reversed(&self) -> bool {
        let n = self.exchanges.len();
        let block = if self.is_parted || self.half == 0 { self.half + 1 } else { n.max(1) };
        let is_block_reversed = |first: usize| {
            let unknowns = first..n.min(first + block);
            unknowns.fold(false, |is_reversed, unknown| is_reversed ^ self.reverses(unknown))
        };
        (0..n).step_by(block).any(is_block_reversed)
    }

    /// Whether the pivot of an unknown changes the sign of the determinant, after [`Banded::factor`].
    pub fn reverses(&self, unknown: usize) -> bool {
        let at = self.position.get(unknown).copied().unwrap_or(unknown);
        let is_negative = self.rows[at * (3 * self.half + 1) + self.half].less(S::from_f64(0.0)).all();
        is_negative ^ (self.exchanges[at] != at)
    }

    /// The inverse of a diagonal matrix, after [`Banded::factor`].
    pub fn inverses(&self) -> Option<&[S]> {
        (self.half == 0 && self.position.is_empty()).then_some(&self.rows)
    }

    /// `b` becomes `A⁻¹ b`, after [`Banded::factor`].
    pub fn solve(&mut self, b: &mut [S]) {
        let mut x = std::mem::take(&mut self.scratch);
        self.solve_in_room(b, &mut x);
        self.scratch = x;
    }

    /// [`Banded::solve`] for numbers of another type, such as those with derivatives; `x` is scratch,
    /// allocated by its first use.
    pub fn solve_in_room<T: Scalar + Mul<S, Output = T>>(&self, b: &mut [T], x: &mut Vec<T>) {
        if let Some(inverses) = self.inverses() {
            return b.iter_mut().zip(inverses).for_each(|(b, &inverse)| *b = *b * inverse);
        }
        x.resize(self.scratch_length(), T::from_f64(0.0));
        match (self.half, self.is_parted) {
            (1, false) => self.solve_in::<T, false>(1, b, x),
            (2, false) => self.solve_in::<T, false>(2, b, x),
            (half, false) => self.solve_in::<T, false>(half, b, x),
            (1, true) => self.solve_in::<T, true>(1, b, x),
            (half, true) => self.solve_in::<T, true>(half, b, x),
        }
    }

    fn scratch_length(&self) -> usize {
        self.exchanges.len() + 2 * self.half
    }

    /// [`Banded::solve`], as [`Banded::factor_in`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn solve_in<T: Scalar + Mul<S, Output = T>, const PARTED: bool>(
        &self,
        half: usize,
        b: &mut [T],
        x: &mut [T],
    ) {
        let (n, width) = (self.exchanges.len(), 3 * half + 1);
        let Self { rows, exchanges, position, .. } = self;
        match position.is_empty() {
            true => x[..n].copy_from_slice(b),
            false => b.iter().zip(position).for_each(|(value, &to)| x[to] = *value),
        }
        x[n..].fill(T::from_f64(0.0));
        for (k, &exchange) in exchanges.iter().enumerate() {
            if exchange != k {
                x.swap(k, exchange);
            }
            let reach = reach::<PARTED>(half, k);
            let (value, below) = (x[k], &rows[(k + 1) * width..][..reach * width]);
            for (row, (entries, own)) in below.chunks_exact(width).zip(&mut x[k + 1..=k + reach]).enumerate()
            {
                *own = *own - value * entries[half - 1 - row];
            }
        }
        for (i, row) in rows.chunks_exact(width).enumerate().take(n).rev() {
            // Rows that were exchanged reach further, but not out of their block.
            let last = if PARTED { reach::<PARTED>(half, i) } else { 2 * half };
            let (above, behind) = x[i..=i + last].split_at_mut(1);
            let sum = |value: T, (&entry, &other): (&S, &T)| value - other * entry;
            above[0] = row[half + 1..].iter().zip(&*behind).fold(above[0], sum) * row[half];
        }
        match position.is_empty() {
            true => b.copy_from_slice(&x[..n]),
            false => b.iter_mut().zip(position).for_each(|(value, &from)| *value = x[from]),
        }
    }
}

/// How many rows below one have entries in its column.
#[cfg_attr(not(debug_assertions), inline(always))]
fn reach<const PARTED: bool>(half: usize, row: usize) -> usize {
    if PARTED { half - row % (half + 1) } else { half }
}

#[cfg(test)]
mod tests {
    use super::super::graph::reverse_cuthill_mckee;
    use super::*;

    fn random(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    /// Solves with random entries at the pattern; the residual is rounding, relative to |A||x| (growth below
    /// 2^half is never near here: 100 allows for it).
    fn reconstruct(n: usize, pairs: &[(usize, usize)]) -> usize {
        let mut seed = n as u64;
        let apart: Vec<_> = pairs.iter().copied().filter(|(a, b)| a != b).collect();
        let position = reverse_cuthill_mckee(n, &apart);
        let half = apart.iter().map(|&(a, b)| position[a].abs_diff(position[b])).max().unwrap_or(0);
        let mut matrix = Banded::<f64>::new(n, half, position, usize::MAX).unwrap();
        let mut dense = vec![vec![0.0; n]; n];
        matrix.reset();
        for (i, row) in dense.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        for &(a, b) in pairs {
            for (i, j) in [(a, b), (b, a)] {
                let value = 4.0 * random(&mut seed);
                matrix.add(i, j, value);
                dense[i][j] += value;
            }
        }
        let b: Vec<f64> = (0..n).map(|_| random(&mut seed)).collect();
        let mut x = b.clone();
        matrix.factor().unwrap();
        assert_eq!(matrix.is_reversed(), is_reversed(dense.clone()));
        matrix.solve(&mut x);
        let size = x.iter().fold(1.0_f64, |largest, x| largest.max(x.abs()));
        for i in 0..n {
            let sum: f64 = (0..n).map(|j| dense[i][j] * x[j]).sum();
            assert!((sum - b[i]).abs() <= 100.0 * n as f64 * f64::EPSILON * size, "row {i} of {n}");
        }
        matrix.half
    }

    /// By elimination without exchanges.
    fn is_reversed(mut a: Vec<Vec<f64>>) -> bool {
        let n = a.len();
        for k in 0..n {
            for i in k + 1..n {
                let (factor, pivot) = (a[i][k] / a[k][k], a[k].clone());
                a[i].iter_mut().zip(pivot).skip(k).for_each(|(own, other)| *own -= factor * other);
            }
        }
        (0..n).filter(|&k| a[k][k] < 0.0).count() % 2 == 1
    }

    /// Blocks have the bits that the band gives.
    #[test]
    fn parted_blocks_are_a_band() {
        for size in 2..5 {
            let (n, mut seed) = (6 * size, size as u64);
            let mut matrices = [false, true].map(|is_parted| {
                Banded::<f64>::new(n, size - 1, Vec::new(), usize::MAX).unwrap().parted(is_parted)
            });
            matrices.iter_mut().for_each(Banded::reset);
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                if i / size == j / size {
                    let value = 4.0 * random(&mut seed);
                    matrices.iter_mut().for_each(|matrix| matrix.add(i, j, value));
                }
            }
            let b: Vec<f64> = (0..n).map(|_| random(&mut seed)).collect();
            let [band, blocks] = matrices.each_mut().map(|matrix| {
                let mut x = b.clone();
                matrix.factor().unwrap();
                matrix.solve(&mut x);
                (x, (0..n).map(|unknown| matrix.reverses(unknown)).collect::<Vec<_>>())
            });
            assert_eq!(band, blocks);
            let is_odd = |block: &[bool]| block.iter().filter(|&&reverses| reverses).count() % 2 == 1;
            assert_eq!(matrices[0].is_reversed(), is_odd(&blocks.1));
            assert_eq!(matrices[1].is_reversed(), blocks.1.chunks(size).any(is_odd));
        }
    }

    #[test]
    fn chains_rings_lattices_and_networks_reconstruct() {
        let chain: Vec<_> = (0..19).map(|i| (i, i + 1)).collect();
        assert_eq!(reconstruct(20, &chain), 1);
        let ring: Vec<_> = (0..20).map(|i| (i, (i + 1) % 20)).collect();
        assert_eq!(reconstruct(20, &ring), 2);
        let mut lattice = Vec::new();
        for (i, j) in (0..6).flat_map(|i| (0..6).map(move |j| (i, j))) {
            lattice.push((6 * i + j, 6 * ((i + 1) % 6) + j));
            lattice.push((6 * i + j, 6 * i + (j + 1) % 6));
        }
        assert!(reconstruct(36, &lattice) < 36);
        let network = [(0, 13), (13, 4), (4, 9), (9, 0), (2, 11), (7, 7), (3, 12), (12, 2), (1, 10)];
        assert!(reconstruct(14, &network) <= 3);
        assert_eq!(reconstruct(5, &[]), 0);
        reconstruct(1, &[]);
    }

    /// Unknowns of very different units: `A⁻¹ b` has those of `b`.
    #[test]
    fn columns_of_very_different_size_are_no_singularity() {
        let mut matrix = Banded::<f64>::new(3, 1, Vec::new(), 100).unwrap();
        matrix.reset();
        for (row, column, value) in [(0, 1, 1e30), (1, 0, 2.0), (1, 1, 1e30), (1, 2, 1e-30), (2, 1, 1e30)] {
            matrix.add(row, column, value);
        }
        matrix.factor().unwrap();
        // The right-hand side of x = (1, 1e-30, 1): [1 + 1, 2 + 1 + 1e-30, 1 + 1].
        let mut x = [2.0, 3.0, 2.0];
        matrix.solve(&mut x);
        assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 1e-30).abs() < 1e-45 && (x[2] - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_singular_matrix_is_found_and_a_wide_one_refused() {
        let mut matrix = Banded::<f64>::new(2, 1, Vec::new(), 100).unwrap();
        matrix.reset();
        matrix.add(0, 1, 1.0);
        matrix.add(1, 0, 1.0);
        assert!(matches!(matrix.factor(), Err(StepFailure::Singular { .. })));
        assert!(Banded::<f64>::new(1000, 999, Vec::new(), 500).is_none());
    }
}
