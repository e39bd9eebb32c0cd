//! Factors `L U` of a sparse matrix whose pattern is symmetric, without exchanges: all of their entries where
//! these are few, else those at the places of the matrix itself, else its diagonal. They precondition an
//! iteration ([`Krylov`](super::Krylov)), which corrects missing entries and inaccurate pivots.
//!
//! A. George, J. W. H. Liu, *Computer Solution of Large Sparse Positive Definite Systems*, 1981 (the pattern
//! of the factors); J. A. Meijerink, H. A. van der Vorst, "An iterative solution method for linear systems of
//! which the coefficient matrix is a symmetric M-matrix", Math. Comp. 31, 1977 (those at the places of the
//! matrix).

use super::graph::{Neighbours, nested_dissection, starts};
use crate::algebra::scalar::{Mask, Scalar};

/// A pivot below this many roundings of its terms is replaced.
const PIVOT_ULPS: f64 = 4.0 * f64::EPSILON;

/// A square matrix, or its factors.
#[derive(Clone, Debug)]
pub struct Sparse<S> {
    /// Where each unknown is.
    position: Vec<usize>,
    /// Below the diagonal, by rows; then `L`.
    lower: Triangle<S>,
    /// Above the diagonal, by rows; then the part of `U` there.
    upper: Triangle<S>,
    /// The diagonal; then the reciprocals of the pivots.
    diagonal: Vec<S>,
    is_complete: bool,
    /// Whether no pivot was replaced.
    is_exact: bool,
    /// Multiplications of the factorisation.
    operations: u64,
    work: Vec<S>,
    /// The row that a place was filled for last, where entries are left out.
    filled: Vec<u32>,
}

/// One triangle without the diagonal, by rows with ascending columns.
#[derive(Clone, Debug)]
struct Triangle<S> {
    starts: Vec<usize>,
    columns: Vec<u32>,
    entries: Vec<S>,
}

impl<S: Scalar> Triangle<S> {
    fn new(starts: Vec<usize>, columns: Vec<u32>) -> Self {
        let entries = vec![S::from_f64(0.0); columns.len()];
        Self { starts, columns, entries }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn row(&self, row: usize) -> (&[u32], &[S]) {
        let range = self.starts[row]..self.starts[row + 1];
        (&self.columns[range.clone()], &self.entries[range])
    }

    fn clear(&mut self, row: usize) {
        self.entries[self.starts[row]..self.starts[row + 1]].fill(S::from_f64(0.0));
    }

    /// Adds to an entry, if there is one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add(&mut self, row: usize, column: usize, value: S) {
        let first = self.starts[row];
        let columns = &self.columns[first..self.starts[row + 1]];
        if let Ok(at) = columns.binary_search_by(|&own| (own as usize).cmp(&column)) {
            self.entries[first + at] = self.entries[first + at] + value;
        }
    }

    /// `Σ a_ij x_j` of a row.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn product(&self, row: usize, x: &[S]) -> S {
        let (columns, entries) = self.row(row);
        let (mut sums, zero) = ([S::from_f64(0.0); 4], S::from_f64(0.0));
        let (chunks, rest) = columns.as_chunks::<4>();
        let (of_chunks, of_rest) = entries.as_chunks::<4>();
        for (columns, entries) in chunks.iter().zip(of_chunks) {
            for k in 0..4 {
                sums[k] = sums[k] + entries[k] * x[columns[k] as usize];
            }
        }
        let rest = rest.iter().zip(of_rest).fold(zero, |sum, (&j, &entry)| sum + entry * x[j as usize]);
        (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
    }
}

impl<S: Scalar> Sparse<S> {
    /// Room for all entries of the factors, in an order in which these are few; `None` if they take more than
    /// `most` multiplications. `pairs`: the places of the matrix above the diagonal, no one twice.
    pub fn complete(n: usize, pairs: &[(usize, usize)], most: u64) -> Option<Self> {
        let neighbours = Neighbours::new(n, pairs);
        let position = nested_dissection(n, &neighbours);
        let upper = filled(n, &neighbours, &position, most)?;
        Some(Self::new(position, upper, true))
    }

    /// Room for entries at the places of the matrix, in the order of its unknowns; `pairs` ascend. `None` if
    /// there are too many unknowns.
    pub fn incomplete(n: usize, pairs: &[(usize, usize)]) -> Option<Self> {
        u32::try_from(n).ok()?;
        let starts = starts(n, pairs.iter().map(|&(row, _)| row));
        let upper = RowPattern { starts, columns: pairs.iter().map(|&(_, column)| column as u32).collect() };
        Some(Self::new((0..n).collect(), upper, false))
    }

    /// Room for the diagonal.
    pub fn diagonal(n: usize) -> Self {
        Self::new((0..n).collect(), RowPattern { starts: vec![0; n + 1], columns: Vec::new() }, false)
    }

    fn new(position: Vec<usize>, upper: RowPattern, is_complete: bool) -> Self {
        let n = position.len();
        let lower = upper.transposed();
        let operations = (0..n).map(|k| upper.count(k)).map(|own| own * own + own).sum();
        let (lower, upper) =
            (Triangle::new(lower.starts, lower.columns), Triangle::new(upper.starts, upper.columns));
        let zeros = || vec![S::from_f64(0.0); n];
        let filled = if is_complete { Vec::new() } else { vec![u32::MAX; n] };
        let (diagonal, work) = (zeros(), zeros());
        Self { position, lower, upper, diagonal, is_complete, is_exact: true, operations, work, filled }
    }

    /// Multiplications of a factorisation against those of a solution.
    pub fn cost(&self) -> u64 {
        let solution = self.lower.columns.len() + self.upper.columns.len() + self.position.len();
        self.operations / (solution as u64).max(1)
    }

    /// The identity.
    pub fn reset(&mut self) {
        self.lower.entries.fill(S::from_f64(0.0));
        self.upper.entries.fill(S::from_f64(0.0));
        self.diagonal.fill(S::from_f64(1.0));
    }

    /// Adds to one entry, if there is a place for it.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn add(&mut self, row: usize, column: usize, value: S) {
        let (row, column) = (self.position[row], self.position[column]);
        match row.cmp(&column) {
            std::cmp::Ordering::Equal => self.diagonal[row] = self.diagonal[row] + value,
            std::cmp::Ordering::Less => self.upper.add(row, column, value),
            std::cmp::Ordering::Greater => self.lower.add(row, column, value),
        }
    }

    /// Factors the matrix in place. A pivot at rounding level is replaced by the size of its terms, and a row
    /// without a finite pivot by that of the identity.
    pub fn factor(&mut self) {
        self.is_exact = self.is_complete;
        self.filled.fill(u32::MAX);
        for row in 0..self.position.len() {
            let (pivot, scale) = match self.is_complete {
                true => self.eliminate::<true>(row),
                false => self.eliminate::<false>(row),
            };
            let (inverse, of_scale) = (pivot.recip(), scale.recip());
            let is_usable = pivot.magnitude() > PIVOT_ULPS * scale && inverse.is_finite().all();
            self.is_exact &= is_usable;
            self.diagonal[row] = if is_usable {
                inverse
            } else if pivot.is_finite().all() && of_scale.is_finite() {
                S::from_f64(of_scale)
            } else {
                self.lower.clear(row);
                self.upper.clear(row);
                S::from_f64(1.0)
            };
        }
    }

    /// Eliminates the entries before the diagonal of a row; returns its pivot, and the largest term of it.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn eliminate<const COMPLETE: bool>(&mut self, row: usize) -> (S, f64) {
        let Self { lower, upper, diagonal, work, filled, .. } = self;
        let mark = row as u32;
        for (columns, entries) in [lower.row(row), upper.row(row)] {
            for (&column, &entry) in columns.iter().zip(entries) {
                work[column as usize] = entry;
                if !COMPLETE {
                    filled[column as usize] = mark;
                }
            }
        }
        work[row] = diagonal[row];
        if !COMPLETE {
            filled[row] = mark;
        }
        let mut scale = work[row].magnitude();
        for at in lower.starts[row]..lower.starts[row + 1] {
            let earlier = lower.columns[at] as usize;
            let factor = work[earlier] * diagonal[earlier];
            lower.entries[at] = factor;
            let (columns, entries) = upper.row(earlier);
            for (&column, &entry) in columns.iter().zip(entries) {
                let column = column as usize;
                if COMPLETE || filled[column] == mark {
                    work[column] = work[column] - factor * entry;
                }
            }
            scale = scale.max(work[row].magnitude());
        }
        for at in upper.starts[row]..upper.starts[row + 1] {
            upper.entries[at] = work[upper.columns[at] as usize];
        }
        (work[row], scale)
    }

    /// Whether the determinant is negative, after [`Sparse::factor`]; unknown for incomplete factors.
    pub fn is_reversed(&self) -> Option<bool> {
        let zero = S::from_f64(0.0);
        let negative = || self.diagonal.iter().filter(|pivot| pivot.less(zero).all()).count();
        self.is_exact.then(|| negative() % 2 == 1)
    }

    /// `b` becomes `(L U)⁻¹ b`, after [`Sparse::factor`].
    pub fn solve(&mut self, b: &mut [S]) {
        let Self { position, lower, upper, diagonal, work: x, .. } = self;
        for (&value, &to) in b.iter().zip(&*position) {
            x[to] = value;
        }
        for row in 0..position.len() {
            x[row] = x[row] - lower.product(row, x);
        }
        for row in (0..position.len()).rev() {
            x[row] = (x[row] - upper.product(row, x)) * diagonal[row];
        }
        for (value, &from) in b.iter_mut().zip(&*position) {
            *value = x[from];
        }
    }
}

/// The pattern of one triangle, by rows.
struct RowPattern {
    starts: Vec<usize>,
    columns: Vec<u32>,
}

impl RowPattern {
    fn count(&self, row: usize) -> u64 {
        (self.starts[row + 1] - self.starts[row]) as u64
    }

    /// The pattern of the other triangle. Its rows have ascending columns even if the rows of this triangle
    /// have not.
    fn transposed(&self) -> Self {
        let n = self.starts.len() - 1;
        let starts = starts(n, self.columns.iter().map(|&column| column as usize));
        let (mut ends, mut columns) = (starts.clone(), vec![0; self.columns.len()]);
        for row in 0..n {
            for &column in &self.columns[self.starts[row]..self.starts[row + 1]] {
                columns[ends[column as usize]] = row as u32;
                ends[column as usize] += 1;
            }
        }
        Self { starts, columns }
    }
}

/// The places above the diagonal that elimination in the order of the positions fills; `None` if that takes
/// more than `most` multiplications.
///
/// A row has the places of its matrix, and those of the rows whose first place is in its column.
fn filled(n: usize, neighbours: &Neighbours, position: &[usize], most: u64) -> Option<RowPattern> {
    const NONE: usize = usize::MAX;
    u32::try_from(n).ok()?;
    let mut order = vec![0; n];
    position.iter().enumerate().for_each(|(unknown, &at)| order[at] = unknown);
    let mut rows = RowPattern { starts: vec![0], columns: Vec::new() };
    let (mut first_child, mut next_child) = (vec![NONE; n], vec![NONE; n]);
    let (mut met, mut operations) = (vec![NONE; n], 0_u64);
    for row in 0..n {
        let (start, mut least) = (rows.columns.len(), NONE);
        let mut take = |column: usize, columns: &mut Vec<u32>| {
            if column > row && met[column] != row {
                met[column] = row;
                columns.push(column as u32);
                least = least.min(column);
            }
        };
        for &other in neighbours.of(order[row]) {
            take(position[other], &mut rows.columns);
        }
        let mut child = first_child[row];
        while child != NONE {
            for at in rows.starts[child]..rows.starts[child + 1] {
                take(rows.columns[at] as usize, &mut rows.columns);
            }
            child = next_child[child];
        }
        if least != NONE {
            (next_child[row], first_child[least]) = (first_child[least], row);
        }
        let count = (rows.columns.len() - start) as u64;
        operations += count * count + count;
        if operations > most {
            return None;
        }
        rows.starts.push(rows.columns.len());
    }
    // Twice transposed, columns ascend.
    Some(rows.transposed().transposed())
}

#[cfg(test)]
mod tests {
    use super::super::krylov::{Krylov, Operator};
    use super::*;
    use crate::error::StepFailure;

    type Places = Vec<(usize, usize)>;

    fn random(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    /// Entries by place, and factors of what they add up to.
    struct Matrix {
        entries: Vec<(usize, usize, f64)>,
        factors: Sparse<f64>,
    }

    impl Matrix {
        fn new(mut factors: Sparse<f64>, entries: Vec<(usize, usize, f64)>) -> Self {
            factors.reset();
            entries.iter().for_each(|&(row, column, value)| factors.add(row, column, value));
            factors.factor();
            Self { entries, factors }
        }

        /// The largest number that `A x - b` leaves.
        fn residual(&mut self, x: &[f64], b: &[f64]) -> f64 {
            let mut image = vec![0.0; x.len()];
            multiply(&self.entries, x, &mut image);
            image.iter().zip(b).fold(0.0, |most, (image, b)| most.max((image - b).abs()))
        }

        /// GMRES, preconditioned by the factors.
        fn solve(&mut self, x: &mut [f64], tolerance: f64) -> Result<u32, StepFailure> {
            let Self { entries, factors } = self;
            let product = &mut |x: &[f64], y: &mut [f64]| multiply(entries, x, y);
            let precondition = &mut |x: &mut [f64]| factors.solve(x);
            let most_cycles = Krylov::<f64>::MOST_CYCLES;
            Krylov::new(x.len()).solve(x, tolerance, &mut Operator { product, precondition, most_cycles })
        }
    }

    /// `y = x + A x`: with the identity, as in the factors.
    fn multiply(entries: &[(usize, usize, f64)], x: &[f64], y: &mut [f64]) {
        y.copy_from_slice(x);
        entries.iter().for_each(|&(row, column, value)| y[row] += value * x[column]);
    }

    fn torus(side: usize) -> Places {
        let mut pairs = Vec::new();
        for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
            for other in [(i + 1) % side * side + j, i * side + (j + 1) % side] {
                pairs.push((other.min(side * i + j), other.max(side * i + j)));
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// Springs of this stiffness at all places.
    fn springs(pairs: &Places, stiffness: f64) -> Vec<(usize, usize, f64)> {
        let entries = |&(a, b): &(usize, usize)| {
            [(a, a, stiffness), (b, b, stiffness), (a, b, -stiffness), (b, a, -stiffness)]
        };
        pairs.iter().flat_map(entries).collect()
    }

    fn wave(n: usize) -> Vec<f64> {
        (0..n).map(|k| (1.7 * k as f64).sin()).collect()
    }

    #[test]
    fn chains_rings_lattices_and_networks_reconstruct() {
        let chain: Places = (0..99).map(|i| (i, i + 1)).collect();
        let ring: Places = chain.iter().copied().chain([(0, 99)]).collect();
        let star: Places = (1..200).map(|i| (0, i)).collect();
        let pairs: Places = (0..500).map(|i| (2 * i, 2 * i + 1)).collect();
        let all: Places = (0..40).flat_map(|i| (i + 1..40).map(move |j| (i, j))).collect();
        for (n, places) in [
            (100, chain),
            (100, ring),
            (200, star),
            (1000, pairs),
            (40, all),
            (400, torus(20)),
            (7, Vec::new()),
        ] {
            let mut seed = n as u64;
            let mut entries: Vec<_> = (0..n).map(|i| (i, i, 8.0)).collect();
            for &(a, b) in &places {
                entries.push((a, b, 2.0 * random(&mut seed)));
                entries.push((b, a, 2.0 * random(&mut seed)));
            }
            let mut matrix = Matrix::new(Sparse::complete(n, &places, u64::MAX).unwrap(), entries);
            let mut position = matrix.factors.position.clone();
            position.sort_unstable();
            assert!(position.into_iter().eq(0..n));
            let b = wave(n);
            let mut x = b.clone();
            matrix.factors.solve(&mut x);
            // Sums of at most n products of numbers of order one.
            assert!(matrix.residual(&x, &b) <= 10.0 * n as f64 * f64::EPSILON, "{n}");
            assert!(matrix.factors.is_reversed().is_some());
        }
    }

    /// Nested dissection of a lattice of `n` sites fills `O(n log n)` entries, a band `O(n^1.5)`.
    #[test]
    fn lattices_fill_little() {
        let numbers = |side: usize| {
            let factors = Sparse::<f64>::complete(side * side, &torus(side), u64::MAX).unwrap();
            factors.upper.columns.len() as f64 / (side * side) as f64
        };
        let (small, large) = (numbers(32), numbers(128));
        // The logarithm grows by 7/5; the square root would by 4.
        assert!(large < 2.0 * small && large < 100.0, "{small} {large}");
        assert!(Sparse::<f64>::complete(1024, &torus(32), 1024).is_none());
    }

    /// Springs from soft to stiff, by what is known of their inverse.
    #[test]
    fn iterations_do_not_grow_with_the_stiffness() {
        let (side, n) = (48, 48 * 48);
        let places = torus(side);
        let taken = |factors: Sparse<f64>, stiffness: f64| {
            let mut matrix = Matrix::new(factors, springs(&places, stiffness));
            let b = wave(n);
            let mut x = b.clone();
            matrix.solve(&mut x, 1e-3)
        };
        for stiffness in [1.0, 1e2, 1e4, 1e6] {
            let complete = taken(Sparse::complete(n, &places, u64::MAX).unwrap(), stiffness);
            let incomplete = taken(Sparse::incomplete(n, &places).unwrap(), stiffness);
            let diagonal = taken(Sparse::diagonal(n), stiffness);
            assert_eq!(complete, Ok(1), "{stiffness:e}");
            assert!(incomplete.unwrap() < diagonal.unwrap(), "{stiffness:e}");
        }
    }

    /// The pivot of the first unknown is zero: what is solved instead differs by a matrix of rank one, which
    /// takes an iteration more.
    #[test]
    fn a_pivot_of_zero_takes_iterations() {
        let entries = vec![(0, 0, -1.0), (0, 1, 2.0), (1, 0, 2.0), (1, 2, 0.5), (2, 1, 0.5)];
        let mut factors = Sparse::incomplete(3, &[(0, 1), (1, 2)]).unwrap();
        (factors.is_complete, factors.position) = (true, vec![0, 1, 2]);
        let mut matrix = Matrix::new(factors, entries);
        assert_eq!(matrix.factors.is_reversed(), None);
        let b = [1.0, 2.0, 3.0];
        let mut x = b;
        assert!(matrix.solve(&mut x, 1e-14).unwrap() <= 3);
        assert!(matrix.residual(&x, &b) < 1e-13);
    }
}
