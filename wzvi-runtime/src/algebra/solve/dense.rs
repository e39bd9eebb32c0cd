//! Dense factorisations of the small matrices of one step.
#![expect(clippy::needless_range_loop, reason = "indices as in the formulas of the factorisations")]

use std::ops::Mul;

use super::lanes::{self, decides_by_lane};
use crate::algebra::scalar::{Mask, Scalar};
use crate::error::{ConfigError, StepFailure};

/// A pivot below this many roundings of the terms subtracted from it makes the matrix singular to working
/// precision. No other entry has the same unit, because the user may choose the unit of each row and column.
pub(super) const PIVOT_ULPS: f64 = 4.0 * f64::EPSILON;

/// Above this size `c` drowns the 1 of `1 - c`: the increments that follow have lost all digits of the state.
pub(super) const LARGEST_PIVOT: f64 = 1.0 / f64::EPSILON;

/// The pivot, which is the matrix `1 - c` of one unknown, to divide by.
///
/// # Errors
/// [`StepFailure::Singular`] where `1 - c` cancels to rounding, or `c` is so large that the 1 does;
/// [`StepFailure::NonFinite`] where it is not finite. In lanes, such paths have NaN
/// instead.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn usable<S: Scalar>(pivot: S) -> Result<S, StepFailure> {
    if const { S::DERIVATIVES > 0 } {
        let mut same = S::of_value(usable(pivot.value())?);
        for number in 0..S::DERIVATIVES {
            same.set_derivative(number, pivot.derivative(number));
        }
        return Ok(same);
    }
    if const { decides_by_lane::<S>() } {
        return Ok(lanes::usable(pivot));
    }
    let size = pivot.magnitude();
    if size > PIVOT_ULPS && size < LARGEST_PIVOT { Ok(pivot) } else { Err(unusable(size)) }
}

/// The reciprocal of a pivot that is at least one by its form; NaN, which no step returns, where `c` is so
/// large that the 1 drowns in it.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn reciprocal_above_one<S: Scalar>(pivot: S) -> S {
    let is_usable = pivot.less(S::from_f64(LARGEST_PIVOT));
    S::select(is_usable, pivot.recip(), S::from_f64(f64::NAN))
}

#[cold]
fn unusable(pivot: f64) -> StepFailure {
    if pivot > 1.0 { singular(1.0, pivot) } else { singular(pivot, 1.0) }
}

/// `A⁻¹ b` for a matrix given by rows.
///
/// # Errors
/// The errors of [`Factor::new`]. In lanes, paths without a solution have NaN instead.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn linear<S: Scalar, const N: usize>(matrix: [[S; N]; N], b: [S; N]) -> Result<[S; N], StepFailure> {
    if const { S::DERIVATIVES > 0 } {
        return linear_with_derivatives(matrix, b);
    }
    Ok(FactoredMatrix::new(matrix)?.solve(b))
}

/// `x' = A⁻¹ (b' - A' x)`
#[cfg_attr(not(debug_assertions), inline(always))]
fn linear_with_derivatives<S: Scalar, const N: usize>(
    matrix: [[S; N]; N],
    b: [S; N],
) -> Result<[S; N], StepFailure> {
    let solver = FactoredMatrix::new(matrix.map(|row| row.map(S::value)))?;
    let solution = solver.solve(b.map(S::value));
    let mut x = solution.map(S::of_value);
    for number in 0..S::DERIVATIVES {
        let mut side = b.map(|b| b.derivative(number));
        for i in 0..N {
            for j in 0..N {
                side[i] = side[i] - matrix[i][j].derivative(number) * solution[j];
            }
        }
        set_derivatives(&mut x, number, solver.solve(side));
    }
    Ok(x)
}

/// Sets one derivative of each number.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn set_derivatives<S: Scalar, const N: usize>(
    x: &mut [S; N],
    number: usize,
    derivatives: [S::Value; N],
) {
    for i in 0..N {
        x[i].set_derivative(number, derivatives[i]);
    }
}

/// `A⁻¹` for several right-hand sides.
pub(super) enum FactoredMatrix<S, const N: usize> {
    /// The matrix is factored once.
    Factored(Factor<S, N>),
    /// Lanes have pivots of their own, which are found again for each side.
    ByLane([[S; N]; N]),
}

impl<S: Scalar, const N: usize> FactoredMatrix<S, N> {
    /// # Errors
    /// The errors of [`Factor::new`]. In lanes, solutions of paths without one are NaN instead.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn new(matrix: [[S; N]; N]) -> Result<Self, StepFailure> {
        if const { decides_by_lane::<S>() } {
            Ok(Self::ByLane(matrix))
        } else {
            Factor::new(matrix).map(Self::Factored)
        }
    }

    /// `A⁻¹ b`
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn solve(&self, b: [S; N]) -> [S; N] {
        match self {
            Self::Factored(factor) => factor.solve(b),
            Self::ByLane(matrix) => lanes::general::<S, N, false>(matrix, &b),
        }
    }
}

/// A matrix that cannot be factored once for all steps is an error of the configuration, not of a step.
///
/// # Errors
/// The cause, with the step size.
pub fn prepared<T>(h: impl Scalar, outcome: Result<T, StepFailure>) -> Result<T, ConfigError> {
    outcome.map_err(|cause| match cause {
        StepFailure::Singular { pivot, scale } => ConfigError::Singular { h: h.lane(0), pivot, scale },
        _ => ConfigError::Parameter,
    })
}

#[cold]
fn singular(pivot: f64, scale: f64) -> StepFailure {
    if !(pivot.is_finite() && scale.is_finite()) {
        StepFailure::NonFinite
    } else {
        StepFailure::Singular { pivot, scale }
    }
}

/// `P A = L U` with pivots that do not depend on the units of rows and columns. Only products of the same
/// unit are compared: row `i` takes the place of row `k` where `|a_ik a_ki| > |a_kk a_ii|`; of several such
/// rows the one with the largest product does. Elimination then subtracts no more than the entries that it
/// changes, for any two rows. Scaling rows and columns by powers of two changes no bit of a solution but its
/// scale.
#[derive(Clone, Copy, Debug)]
pub struct Factor<S, const N: usize> {
    /// `L` below the diagonal (its unit diagonal is not stored), `U` above, reciprocals of the pivots on it.
    lu: [[S; N]; N],
    order: [usize; N],
}

/// A row that may give the next pivot, in column `k`.
#[derive(Clone, Copy)]
pub(super) struct Candidate {
    pub(super) row: usize,
    /// `|a_ik|`
    pub(super) entry: f64,
    /// `|a_ik a_ki|`, or `|a_kk|` on the diagonal.
    pub(super) through: f64,
    /// `|a_ii|`, or 1 there.
    pub(super) own: f64,
}

impl Candidate {
    /// The row that the column stands for.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn on_diagonal(k: usize, entry: f64) -> Self {
        Self { row: k, entry, through: entry, own: 1.0 }
    }

    /// The better of two; this one where nothing tells.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn or(self, other: Self) -> Self {
        let is_better = other.through * self.own > self.through * other.own;
        if is_better || (self.entry == 0.0 && other.entry > 0.0) { other } else { self }
    }
}

impl<S: Scalar, const N: usize> Factor<S, N> {
    /// Factors `matrix`, given by rows.
    ///
    /// # Errors
    /// [`StepFailure::Singular`] if a pivot is at the rounding level of the terms subtracted from it;
    /// [`StepFailure::NonFinite`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(matrix: [[S; N]; N]) -> Result<Self, StepFailure> {
        let mut lu = matrix;
        let mut order: [usize; N] = std::array::from_fn(|i| i);
        for k in 0..N {
            let mut best = Candidate::on_diagonal(k, lu[k][k].magnitude());
            for i in k + 1..N {
                let [entry, opposite, own] = [lu[i][k], lu[k][i], lu[i][i]].map(S::magnitude);
                best = best.or(Candidate { row: i, entry, through: entry * opposite, own });
            }
            lu.swap(k, best.row);
            order.swap(k, best.row);
            let pivot = lu[k][k].magnitude();
            let taken = (0..k).fold(0.0, |sum, i| sum + lu[k][i].magnitude() * lu[i][k].magnitude());
            // False for NaN, too.
            if !(pivot > PIVOT_ULPS * taken && pivot.is_finite()) {
                return Err(singular(pivot, taken));
            }
            eliminate(&mut lu, k);
        }
        Ok(Self { lu, order })
    }

    /// `A⁻¹ b`
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn solve(&self, b: [S; N]) -> [S; N] {
        substitute(&self.lu, self.order.map(|row| b[row]))
    }

    /// Whether the determinant is negative.
    pub(super) fn is_reversed(&self) -> bool {
        let negative = (0..N).filter(|&k| self.lu[k][k].less(S::from_f64(0.0)).all()).count();
        let inversions = (0..N).flat_map(|i| (0..i).map(move |j| (i, j)));
        let swapped = inversions.filter(|&(i, j)| self.order[i] < self.order[j]).count();
        (negative + swapped) % 2 == 1
    }
}

impl<const N: usize> Factor<f64, N> {
    /// `L` and `U` as they are kept, and the rows of the matrix in the order of the pivots.
    pub(super) fn parts(&self) -> (&[[f64; N]; N], &[usize; N]) {
        (&self.lu, &self.order)
    }

    /// `A⁻¹ b` for a right-hand side of any number type.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn apply<S: Scalar>(&self, b: [S; N]) -> [S; N] {
        substitute(&self.lu, self.order.map(|row| b[row]))
    }
}

/// A symmetric matrix: `A = L D Lᵀ` without pivoting, or [`Factor`] where that would lose digits.
#[derive(Clone, Copy, Debug)]
pub enum SymmetricFactor<S, const N: usize> {
    /// `L` below the diagonal, reciprocals of `D` on it.
    Symmetric([[S; N]; N]),
    /// The matrix is indefinite or nearly singular.
    General(Factor<S, N>),
}

/// `L D Lᵀ` is backward stable while its pivots stay above this fraction of the diagonal that they came from.
pub(super) const STABLE_PIVOT: f64 = 1e-2;

impl<S: Scalar, const N: usize> SymmetricFactor<S, N> {
    /// Factors the symmetric matrix whose lower triangle `matrix` holds.
    ///
    /// # Errors
    /// [`StepFailure::Singular`] as [`Factor::new`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(matrix: [[S; N]; N]) -> Result<Self, StepFailure> {
        match Self::without_pivoting(matrix) {
            Some(factor) => Ok(factor),
            None => {
                let full = std::array::from_fn(|i| std::array::from_fn(|j| matrix[i.max(j)][i.min(j)]));
                Factor::new(full).map(Self::General)
            }
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn without_pivoting(matrix: [[S; N]; N]) -> Option<Self> {
        let mut l = matrix;
        for k in 0..N {
            let pivot = l[k][k];
            // False for NaN; a negative pivot makes the matrix indefinite.
            if !S::from_f64(STABLE_PIVOT * matrix[k][k].magnitude()).less(pivot).all() {
                return None;
            }
            eliminate_symmetric(&mut l, k);
        }
        Some(Self::Symmetric(l))
    }

    /// `A⁻¹ b`
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn solve(&self, b: [S; N]) -> [S; N] {
        match self {
            Self::Symmetric(l) => substitute_symmetric(l, b),
            Self::General(factor) => factor.solve(b),
        }
    }
}

/// Whether a symmetric matrix, of which this is the lower triangle, is positive definite: of all lanes.
pub(super) fn is_definite<S: Scalar, const N: usize>(matrix: &[[S; N]; N]) -> bool {
    let mut l = *matrix;
    (0..N).all(|k| {
        let is_positive = S::from_f64(0.0).less(l[k][k]).all();
        eliminate_symmetric(&mut l, k);
        is_positive
    })
}

/// Column `k` of `A = L U` in place, with the reciprocal of the pivot that stands on the diagonal.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn eliminate<S: Scalar, const N: usize>(lu: &mut [[S; N]; N], k: usize) {
    let inverse = lu[k][k].recip();
    lu[k][k] = inverse;
    for i in k + 1..N {
        let factor = lu[i][k] * inverse;
        lu[i][k] = factor;
        for j in k + 1..N {
            lu[i][j] = lu[i][j] - factor * lu[k][j];
        }
    }
}

/// `U⁻¹ L⁻¹ x`
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn substitute<S: Scalar + Mul<T, Output = S>, T: Copy, const N: usize>(
    lu: &[[T; N]; N],
    mut x: [S; N],
) -> [S; N] {
    for i in 1..N {
        for j in 0..i {
            x[i] = x[i] - x[j] * lu[i][j];
        }
    }
    for i in (0..N).rev() {
        for j in i + 1..N {
            x[i] = x[i] - x[j] * lu[i][j];
        }
        x[i] = x[i] * lu[i][i];
    }
    x
}

/// Column `k` of `A = L D Lᵀ` in place, from the lower triangle.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn eliminate_symmetric<S: Scalar, const N: usize>(l: &mut [[S; N]; N], k: usize) {
    let inverse = l[k][k].recip();
    for i in k + 1..N {
        let factor = l[i][k] * inverse;
        for j in k + 1..=i {
            l[i][j] = l[i][j] - factor * l[j][k];
        }
    }
    for i in k + 1..N {
        l[i][k] = l[i][k] * inverse;
    }
    l[k][k] = inverse;
}

/// `L⁻ᵀ D⁻¹ L⁻¹ x`
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn substitute_symmetric<S: Scalar, const N: usize>(l: &[[S; N]; N], mut x: [S; N]) -> [S; N] {
    for i in 1..N {
        for j in 0..i {
            x[i] = x[i] - l[i][j] * x[j];
        }
    }
    for i in (0..N).rev() {
        x[i] = x[i] * l[i][i];
        for j in i + 1..N {
            x[i] = x[i] - l[j][i] * x[j];
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::lanes::Lanes;
    use crate::algebra::scalar::Dual;

    fn pseudo_random(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    fn residual<const N: usize>(matrix: &[[f64; N]; N], x: &[f64; N], b: &[f64; N]) -> f64 {
        let row = |i: usize| (0..N).map(|j| matrix[i][j] * x[j]).sum::<f64>() - b[i];
        (0..N).map(|i| row(i).abs()).fold(0.0, f64::max)
    }

    /// Backward stability: the residual is rounding relative to |A||x| (growth of small matrices is below 8).
    fn reconstruct<const N: usize>(symmetric: bool) {
        let mut seed = N as u64;
        for _ in 0..200 {
            let mut matrix = [[0.0; N]; N];
            for i in 0..N {
                for j in 0..N {
                    matrix[i][j] = if symmetric && j < i { matrix[j][i] } else { pseudo_random(&mut seed) };
                }
            }
            let b = std::array::from_fn(|_| pseudo_random(&mut seed));
            let x = if symmetric {
                SymmetricFactor::new(matrix).map(|factor| factor.solve(b))
            } else {
                Factor::new(matrix).map(|factor| factor.solve(b))
            };
            let x = x.unwrap();
            let size = x.iter().fold(1.0_f64, |largest, x| largest.max(x.abs()));
            let bound = if symmetric { 100.0 } else { 1.0 } * 8.0 * (N * N) as f64 * f64::EPSILON * size;
            assert!(residual(&matrix, &x, &b) <= bound, "N = {N}: {} > {bound}", residual(&matrix, &x, &b));
        }
    }

    #[test]
    fn factors_reconstruct() {
        reconstruct::<1>(false);
        reconstruct::<2>(false);
        reconstruct::<5>(false);
        reconstruct::<2>(true);
        reconstruct::<5>(true);
    }

    #[test]
    fn the_sign_of_a_determinant() {
        let sign = |matrix| Factor::<f64, 3>::new(matrix).unwrap().is_reversed();
        assert!(!sign([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]));
        assert!(sign([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]));
        assert!(!sign([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]));
        // 1·(5·10 - 6·8) - 2·(4·10 - 6·7) + 3·(4·8 - 5·7) = -3
        assert!(sign([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 10.0]]));
    }

    /// Any solution has derivatives, also one where the determinant is negative: in lanes as alone.
    #[test]
    fn matrices_of_any_sign_are_solved_in_lanes() {
        let upright = [[2.0, 1.0, 0.0], [1.0, 3.0, 1.0], [0.0, 1.0, 4.0]];
        let reversed = [upright[1], upright[0], upright[2]];
        let matrices = [upright, reversed];
        let lanes = std::array::from_fn(|i| {
            std::array::from_fn(|j| Lanes::new(matrices.map(|matrix: [[f64; 3]; 3]| matrix[i][j])))
        });
        let b = [1.0, -2.0, 0.5];
        let x = FactoredMatrix::<Lanes<2>, 3>::new(lanes).unwrap().solve(b.map(Lanes::<2>::from_f64));
        for (lane, matrix) in matrices.into_iter().enumerate() {
            let alone = Factor::new(matrix).unwrap();
            assert_eq!(alone.is_reversed(), lane == 1);
            assert_eq!(x.map(|x| x[lane]), alone.solve(b));
        }
    }

    #[test]
    fn rows_of_very_different_size_are_no_singularity() {
        let matrix = [[1e-120, 2e-120], [3e120, 4e120]];
        let x = Factor::new(matrix).unwrap().solve([5e-120, 11e120]);
        assert!((x[0] - 1.0).abs() < 1e-14 && (x[1] - 2.0).abs() < 1e-14, "{x:?}");
    }

    #[test]
    fn a_singular_matrix_is_found() {
        assert!(matches!(Factor::new([[1.0, 2.0], [2.0, 4.0]]), Err(StepFailure::Singular { .. })));
        assert!(matches!(SymmetricFactor::new([[0.0, 0.0], [0.0, 1.0]]), Err(StepFailure::Singular { .. })));
        assert!(matches!(Factor::new([[f64::NAN, 2.0], [2.0, 4.0]]), Err(StepFailure::NonFinite)));
        assert!(matches!(usable(1e-17), Err(StepFailure::Singular { .. })));
        assert!(matches!(usable(1e17), Err(StepFailure::Singular { .. })));
        assert_eq!(usable(f64::INFINITY), Err(StepFailure::NonFinite));
        // A slope that overflows is no pole of the scheme.
        let infinite = [[f64::INFINITY, 1.0], [1.0, 1.0]];
        assert!(matches!(Factor::new(infinite), Err(StepFailure::NonFinite)));
        assert!(matches!(SymmetricFactor::new(infinite), Err(StepFailure::NonFinite)));
        assert!(reciprocal_above_one(f64::INFINITY).is_nan() && reciprocal_above_one(1e17).is_nan());
        assert!(reciprocal_above_one(f64::NAN).is_nan());
    }

    /// `A x = b` and `A x' = b' - A' x` for two paths, of which the first has no solution.
    #[test]
    fn a_path_without_a_solution_leaves_the_other_and_its_derivative() {
        type Number = Dual<1, Lanes<2>>;
        let number =
            |value, derivative| Number { value: Lanes::new(value), derivative: [Lanes::new(derivative)] };
        let zero = number([0.0, 0.0], [0.0, 0.0]);
        let matrix = [[number([0.0, 4.0], [1.0, 2.0]), zero], [zero, number([1.0, 1.0], [0.0, 0.0])]];
        let [x, y] = linear(matrix, [number([1.0, 8.0], [1.0, 12.0]), zero]).unwrap();
        // 4 x = 8 and 4 x' = 12 - 2 * 2, without rounding.
        assert_eq!((x.value[1], x.derivative[0][1], y.value[1]), (2.0, 2.0, 0.0));
        assert!(x.value[0].is_nan());
        // The pivot 1 - c of one unknown.
        let pivot = usable(matrix[0][0]).unwrap();
        assert_eq!((pivot.value[1], pivot.derivative[0][1]), (4.0, 2.0));
        assert!(pivot.value[0].is_nan());
    }
}
