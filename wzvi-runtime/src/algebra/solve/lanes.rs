//! Linear systems of several trajectories at once.
//!
//! Each lane performs the operations that it would perform alone, and has its own pivots. A lane whose system
//! has no solution gets NaN, which marks it at the end of the step; the caller then takes its step alone.
#![expect(clippy::needless_range_loop, reason = "indices as in the formulas of the factorisations")]

use super::dense::{
    LARGEST_PIVOT, PIVOT_ULPS, STABLE_PIVOT, eliminate, eliminate_symmetric, substitute, substitute_symmetric,
};
use crate::algebra::scalar::{Mask, Scalar};

/// Whether each lane is solved for by itself.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) const fn decides_by_lane<S: Scalar>() -> bool {
    S::LANES_ARE_PATHS && S::LANES > 1
}

/// The mark of a lane without a solution.
pub(super) fn poison<S: Scalar>() -> S {
    S::from_f64(f64::NAN)
}

/// `a > b`
#[cfg_attr(not(debug_assertions), inline(always))]
fn exceeds<S: Scalar>(a: S, b: S) -> S::Mask {
    b.less(a)
}

/// [`super::Factor`], by lane: the row that a lane takes for its pivot changes place with the first one by
/// selection. `UPRIGHT`: of a positive determinant, else NaN.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn general<S: Scalar, const N: usize, const UPRIGHT: bool>(
    matrix: &[[S; N]; N],
    b: &[S; N],
) -> [S; N] {
    let (mut a, mut x) = (*matrix, *b);
    let mut usable = S::Mask::from_bool(true);
    let mut sign = S::from_f64(1.0);
    for k in 0..N {
        let zero = S::from_f64(0.0);
        let (mut entry, mut through, mut own) = (a[k][k].abs(), a[k][k].abs(), S::from_f64(1.0));
        let mut chosen = [S::Mask::from_bool(false); N];
        for i in k + 1..N {
            let (next, next_own) = (a[i][k].abs(), a[i][i].abs());
            let next_through = next * a[k][i].abs();
            let better =
                exceeds(next_through * own, through * next_own) | (entry.equal(zero) & zero.less(next));
            entry = S::select(better, next, entry);
            through = S::select(better, next_through, through);
            own = S::select(better, next_own, own);
            for earlier in &mut chosen[..i] {
                *earlier = *earlier & !better;
            }
            chosen[i] = better;
        }
        for i in k + 1..N {
            for j in 0..N {
                (a[k][j], a[i][j]) = swapped(chosen[i], a[k][j], a[i][j]);
            }
            (x[k], x[i]) = swapped(chosen[i], x[k], x[i]);
            if UPRIGHT {
                sign = S::select(chosen[i], -sign, sign);
            }
        }
        let taken = (0..k).fold(zero, |sum, i| sum + a[k][i].abs() * a[i][k].abs());
        usable = usable & exceeds(a[k][k].abs(), taken * PIVOT_ULPS) & a[k][k].is_finite();
        if UPRIGHT {
            sign = S::select(a[k][k].less(S::from_f64(0.0)), -sign, sign);
        }
        eliminate(&mut a, k);
    }
    if UPRIGHT {
        usable = usable & S::from_f64(0.0).less(sign);
    }
    substitute(&a, x).map(|x| S::select(usable, x, poison()))
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn swapped<S: Scalar>(mask: S::Mask, a: S, b: S) -> (S, S) {
    (S::select(mask, b, a), S::select(mask, a, b))
}

/// [`super::SymmetricFactor`], by lane; NaN where it is not definite.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn symmetric<S: Scalar, const N: usize>(matrix: &[[S; N]; N], b: &[S; N]) -> [S; N] {
    let mut l = *matrix;
    let (mut stable, mut definite) = (S::Mask::from_bool(true), S::Mask::from_bool(true));
    for k in 0..N {
        let pivot = l[k][k];
        definite = definite & S::from_f64(0.0).less(pivot);
        stable = stable & exceeds(pivot, matrix[k][k].abs() * STABLE_PIVOT);
        eliminate_symmetric(&mut l, k);
    }
    let mut x = substitute_symmetric(&l, *b);
    if !stable.all() {
        let full = std::array::from_fn(|i: usize| std::array::from_fn(|j: usize| matrix[i.max(j)][i.min(j)]));
        let other = rarely(&full, b);
        for i in 0..N {
            x[i] = S::select(stable, x[i], S::select(definite, other[i], poison()));
        }
    }
    x
}

/// [`general`], out of the way of [`symmetric`].
#[cold]
#[inline(never)]
fn rarely<S: Scalar, const N: usize>(matrix: &[[S; N]; N], b: &[S; N]) -> [S; N] {
    general::<S, N, true>(matrix, b)
}

/// The pivot where it is usable, else NaN.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn usable<S: Scalar>(pivot: S) -> S {
    let size = pivot.abs();
    let is_usable = exceeds(size, S::from_f64(PIVOT_ULPS)) & size.less(S::from_f64(LARGEST_PIVOT));
    S::select(is_usable, pivot, poison())
}
