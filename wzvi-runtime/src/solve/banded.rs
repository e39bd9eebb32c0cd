//! Sparse matrices that a renumbering of their unknowns makes narrow: reverse Cuthill-McKee, then `P A = L U` in the
//! band with partial pivoting. Exact for chains (a band), rings (folded to a band), lattices and networks.
//!
//! E. Cuthill, J. McKee, "Reducing the bandwidth of sparse symmetric matrices", ACM 1969; G. H. Golub, C. F. Van Loan,
//! *Matrix Computations*, section 4.3. With pivoting, `U` has as many upper diagonals as `A` has in all.

use crate::error::StepFailure;
use crate::scalar::Scalar;

/// A pivot below this many units of rounding of its row makes the matrix singular to working precision.
const PIVOT_ULPS: f64 = 4.0 * f64::EPSILON;

/// Half a bandwidth up to which the order of the unknowns is kept.
const NARROW: usize = 4;

/// A square matrix with room for its factors.
#[derive(Clone, Debug)]
pub struct Banded<S> {
    n: usize,
    /// Diagonals on each side.
    half: usize,
    /// Where each unknown is in the band; empty for the order that it has.
    position: Vec<usize>,
    /// Row `i` from column `i - half`, with `half` columns of room for what pivoting fills.
    rows: Vec<S>,
    /// Row exchanged with row `k` before column `k` was eliminated.
    exchanges: Vec<usize>,
    scratch: Vec<S>,
}

impl<S: Scalar> Banded<S> {
    /// Room for a matrix of `n` unknowns whose entries off the diagonal are at `pairs` and their mirror images; `None`
    /// if the band does not fit `most` numbers.
    pub fn new(n: usize, pairs: &[(usize, usize)], most: usize) -> Option<Self> {
        let natural = pairs.iter().map(|&(a, b)| a.abs_diff(b)).max().unwrap_or(0);
        let (position, half) = if natural <= NARROW {
            (Vec::new(), natural)
        } else {
            let position = reverse_cuthill_mckee(n, pairs);
            let half = pairs.iter().map(|&(a, b)| position[a].abs_diff(position[b])).max().unwrap_or(0);
            if half < natural { (position, half) } else { (Vec::new(), natural) }
        };
        let numbers = n.checked_mul(3 * half + 1)?;
        if numbers > most {
            return None;
        }
        let zero = S::from_f64(0.0);
        Some(Self {
            n,
            half,
            position,
            rows: vec![zero; numbers],
            exchanges: vec![0; n],
            scratch: vec![zero; n],
        })
    }

    /// The identity.
    pub fn reset(&mut self) {
        self.rows.fill(S::from_f64(0.0));
        let (width, half) = (3 * self.half + 1, self.half);
        for row in self.rows.chunks_exact_mut(width) {
            row[half] = S::from_f64(1.0);
        }
    }

    /// Adds to one entry of the pattern.
    #[inline(always)]
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
    /// [`StepFailure::Singular`] if a pivot is at the rounding level of the largest entry of the matrix around it.
    pub fn factor(&mut self) -> Result<(), StepFailure> {
        let (n, half, width) = (self.n, self.half, 3 * self.half + 1);
        let rows = &mut self.rows;
        for k in 0..n {
            let last = (k + half).min(n - 1);
            let entry = |i: usize, j: usize| i * width + j + half - i;
            let mut best = k;
            let mut scale = 0.0_f64;
            for i in k..=last {
                if rows[entry(i, k)].magnitude() > rows[entry(best, k)].magnitude() {
                    best = i;
                }
                for j in k..(k + 2 * half + 1).min(n).min(i + 2 * half + 1) {
                    scale = scale.max(rows[entry(i, j)].magnitude());
                }
            }
            let pivot = rows[entry(best, k)].magnitude();
            if pivot.is_nan() || scale.is_infinite() {
                return Err(StepFailure::NonFinite);
            }
            if pivot <= PIVOT_ULPS * scale {
                return Err(StepFailure::Singular { pivot, scale });
            }
            self.exchanges[k] = best;
            let end = (k + 2 * half + 1).min(n);
            if best != k {
                for j in k..end.min(k + 2 * half + 1) {
                    rows.swap(entry(k, j), entry(best, j));
                }
            }
            let inverse = rows[entry(k, k)].recip();
            rows[entry(k, k)] = inverse;
            for i in k + 1..=last {
                let factor = rows[entry(i, k)] * inverse;
                rows[entry(i, k)] = factor;
                for j in k + 1..end {
                    rows[entry(i, j)] = rows[entry(i, j)] - factor * rows[entry(k, j)];
                }
            }
        }
        Ok(())
    }

    /// `b` becomes `A⁻¹ b`, after [`Banded::factor`].
    pub fn solve(&mut self, b: &mut [S]) {
        let (n, half, width) = (self.n, self.half, 3 * self.half + 1);
        let (rows, x) = (&self.rows, &mut self.scratch);
        let entry = |i: usize, j: usize| i * width + j + half - i;
        match self.position.is_empty() {
            true => x.copy_from_slice(b),
            false => {
                for (value, &to) in b.iter().zip(&self.position) {
                    x[to] = *value;
                }
            }
        }
        for k in 0..n {
            x.swap(k, self.exchanges[k]);
            let value = x[k];
            for i in k + 1..(k + half + 1).min(n) {
                x[i] = x[i] - rows[entry(i, k)] * value;
            }
        }
        for i in (0..n).rev() {
            let mut value = x[i];
            for j in i + 1..(i + 2 * half + 1).min(n) {
                value = value - rows[entry(i, j)] * x[j];
            }
            x[i] = value * rows[entry(i, i)];
        }
        match self.position.is_empty() {
            true => b.copy_from_slice(x),
            false => {
                for (value, &from) in b.iter_mut().zip(&self.position) {
                    *value = x[from];
                }
            }
        }
    }
}

/// The position of each unknown in an order where neighbours are near each other.
fn reverse_cuthill_mckee(n: usize, pairs: &[(usize, usize)]) -> Vec<usize> {
    let mut neighbours: Vec<Vec<usize>> = vec![Vec::new(); n];
    for &(a, b) in pairs {
        if a != b {
            neighbours[a].push(b);
            neighbours[b].push(a);
        }
    }
    for list in &mut neighbours {
        list.sort_unstable();
        list.dedup();
    }
    let mut order = Vec::with_capacity(n);
    let mut met = vec![false; n];
    for seed in 0..n {
        if met[seed] {
            continue;
        }
        // Two sweeps lead to an end of the component.
        let mut start = seed;
        for _ in 0..2 {
            start = farthest(&neighbours, start);
        }
        met[start] = true;
        let mut next = order.len();
        order.push(start);
        while next < order.len() {
            let mut ring: Vec<usize> =
                neighbours[order[next]].iter().copied().filter(|&other| !met[other]).collect();
            ring.sort_by_key(|&other| neighbours[other].len());
            for &other in &ring {
                met[other] = true;
            }
            order.extend(ring);
            next += 1;
        }
    }
    let mut position = vec![0; n];
    for (at, &unknown) in order.iter().rev().enumerate() {
        position[unknown] = at;
    }
    position
}

/// The last unknown that a breadth-first search from `start` meets.
fn farthest(neighbours: &[Vec<usize>], start: usize) -> usize {
    let mut met = std::collections::HashSet::from([start]);
    let (mut ring, mut last) = (vec![start], start);
    while !ring.is_empty() {
        let mut next = Vec::new();
        for &unknown in &ring {
            last = unknown;
            next.extend(neighbours[unknown].iter().copied().filter(|&other| met.insert(other)));
        }
        ring = next;
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    /// Solves with random entries at the pattern; the residual is rounding, relative to |A||x| (growth below 2^half is
    /// never near here: 100 allows for it).
    fn reconstruct(n: usize, pairs: &[(usize, usize)]) -> usize {
        let mut seed = n as u64;
        let mut matrix = Banded::<f64>::new(n, pairs, usize::MAX).unwrap();
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
        matrix.solve(&mut x);
        let size = x.iter().fold(1.0_f64, |largest, x| largest.max(x.abs()));
        for i in 0..n {
            let sum: f64 = (0..n).map(|j| dense[i][j] * x[j]).sum();
            assert!((sum - b[i]).abs() <= 100.0 * n as f64 * f64::EPSILON * size, "row {i} of {n}");
        }
        matrix.half
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

    #[test]
    fn a_singular_matrix_is_found_and_a_wide_one_refused() {
        let mut matrix = Banded::<f64>::new(2, &[(0, 1)], 100).unwrap();
        matrix.reset();
        matrix.add(0, 1, 1.0);
        matrix.add(1, 0, 1.0);
        assert!(matches!(matrix.factor(), Err(StepFailure::Singular { .. })));
        assert!(Banded::<f64>::new(1000, &[(0, 999), (0, 1), (0, 500)], 500).is_none());
    }
}
