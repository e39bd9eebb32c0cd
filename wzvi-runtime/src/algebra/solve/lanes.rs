//! Newton's method and linear systems for several trajectories at once.
//!
//! Each lane performs the operations that it would perform alone: it has its own verdict after each
//! iteration, keeps its bits once it has converged, and has its own pivots. A lane whose step has no
//! solution, or none that the fast method finds, gets NaN, which marks it at the end of the step; the caller
//! then takes its step alone.
#![expect(clippy::needless_range_loop, reason = "indices as in the formulas of the factorisations")]

use super::convergence::{
    CURVATURE, Convergence, FIRST, GUIDED, ROUNDING, UNSEEN, Verdict, WHOLE, nearly_relative, relative_to,
};
use super::dense::{
    LARGEST_PIVOT, PIVOT_ULPS, STABLE_PIVOT, eliminate, eliminate_symmetric, substitute, substitute_symmetric,
};
use super::effort::Effort;
use super::newton::{Equations, SAFE_DETERMINANT, UPRIGHT, beyond};
use crate::algebra::scalar::{Mask, Scalar};

/// Whether each lane is solved for by itself.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) const fn decides_by_lane<S: Scalar>() -> bool {
    S::LANES_ARE_PATHS && S::LANES > 1
}

fn poison<S: Scalar>() -> S {
    S::from_f64(f64::NAN)
}

/// `a > b`
#[cfg_attr(not(debug_assertions), inline(always))]
fn exceeds<S: Scalar>(a: S, b: S) -> S::Mask {
    b.less(a)
}

/// `Convergence::glance`, by lane.
#[derive(Clone, Copy)]
struct LaneConvergence<S: Scalar> {
    curved: S,
    /// Infinite where a lane is done: numbers stay in vector registers from iteration to iteration where
    /// truths do not.
    enough: S,
    iterations: u32,
    is_guess: bool,
}

impl<S: Scalar> LaneConvergence<S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn new(is_guess: bool) -> Self {
        Self {
            curved: S::from_f64(if is_guess { GUIDED } else { f64::INFINITY }),
            enough: S::from_f64(ROUNDING * ROUNDING * ROUNDING),
            iterations: 0,
            is_guess,
        }
    }

    /// Notes the verdicts where they take no more than the corrections; `false`, and nothing is noted, where
    /// a lane's depends on its residuals.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn note_verdicts(&mut self, relative: S) -> bool {
        let square = relative * relative;
        // A lane that is done stays so, unless the next correction is not a number.
        let done = (square * relative).less_equal(self.enough);
        let is_enough = (done | relative.less(self.curved)).all();
        if is_enough {
            self.iterations += 1;
            self.expect(done, square);
            if !self.is_guess && self.iterations == 1 {
                self.curved = S::from_f64(FIRST);
            }
        }
        is_enough
    }

    /// Quadratic convergence from corrections of this size, with their squares, of lanes that are not done.
    /// The squares are finite: no difference is smaller than a rounding of what it is taken from.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn expect(&mut self, done: S::Mask, square: S) {
        let whole = S::from_f64(WHOLE);
        let square = S::select(exceeds(square, whole), whole, square);
        self.curved = square * CURVATURE;
        let predicted = square * (UNSEEN * ROUNDING);
        let floor = S::from_f64(ROUNDING * ROUNDING * ROUNDING);
        let enough = S::select(exceeds(predicted, floor), predicted, floor);
        self.enough = S::select(done, S::from_f64(f64::INFINITY), enough);
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn done(&self) -> S::Mask {
        self.enough.equal(S::from_f64(f64::INFINITY))
    }

    /// The iteration of a lane, to be judged by itself from `x` on.
    fn of_lane<const N: usize>(&self, lane: usize, x: &[S; N]) -> Convergence {
        let Self { curved, enough, iterations, is_guess } = *self;
        let mut own = Convergence::resumed(iterations, curved.lane(lane), enough.lane(lane), is_guess);
        if iterations == 0 && x.iter().all(|x| x.lane(lane) == 0.0) {
            own.claim_nothing();
        }
        own
    }
}

/// `newton::newton`, by lane.
///
/// The iteration ends: relative to the unknown, the second correction of a lane is at most an eighth, and
/// each later one at most half of the one before, or the lane goes astray; 2^-52 is the last.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn iterate<S: Scalar, const N: usize>(
    start: [S; N],
    is_guess: bool,
    is_symmetric: bool,
    equations: impl Equations<S, N>,
) -> ([S; N], Effort) {
    let (mut x, mut convergence) = (start, LaneConvergence::new(is_guess));
    let mut level = S::from_f64(0.0);
    loop {
        let (residual, jacobian) = equations.evaluate(&x);
        let Some(correction) = safe_correction(&jacobian, &residual, is_symmetric) else { break };
        let (done, (moved, largest)) = (convergence.done(), corrected_end(&x, &correction));
        if !convergence.note_verdicts(largest) {
            break;
        }
        for i in 0..N {
            x[i] = S::select(done, x[i], moved[i]);
        }
        level = S::select(done, level, uprightness(&jacobian, is_symmetric));
        if convergence.done().all() {
            return accepted(x, level, convergence.iterations);
        }
    }
    let (x, iterations) = resumed(x, level, convergence, is_symmetric, equations);
    (x, Effort::fast(iterations))
}

/// The iteration of one lane.
struct LaneSearch {
    convergence: Convergence,
    is_done: bool,
    /// Whether it went astray.
    is_lost: bool,
}

/// The iteration from `x` on, where a lane needs a pivot or a look at its residuals. A call by value, and the
/// last thing that the caller does: its loop stays in vector registers.
#[cold]
#[inline(never)]
fn resumed<S: Scalar, const N: usize>(
    mut x: [S; N],
    mut level: S,
    convergence: LaneConvergence<S>,
    is_symmetric: bool,
    equations: impl Equations<S, N>,
) -> ([S; N], u32) {
    let done = convergence.done();
    let mut paths = S::Mask::by_lane(|lane| LaneSearch {
        convergence: convergence.of_lane(lane, &x),
        is_done: done.lane(lane),
        is_lost: false,
    });
    let paths = paths.as_mut();
    loop {
        let (residual, jacobian) = equations.evaluate(&x);
        let correction = correction(&jacobian, &residual, is_symmetric);
        let (moved, largest) = corrected_end(&x, &correction);
        let before = S::Mask::of_lanes(|lane| paths[lane].is_done);
        for lane in (0..S::LANES).filter(|&lane| !before.lane(lane)) {
            let verdict = paths[lane].convergence.judge(largest.lane(lane), || {
                let sizes =
                    std::array::from_fn(|i| relative_to(correction[i].lane(lane), moved[i].lane(lane)));
                beyond(equations.rounded(&x, lane), sizes)
            });
            paths[lane].is_done = !matches!(verdict, Verdict::Contracting);
            paths[lane].is_lost = matches!(verdict, Verdict::Straying);
        }
        let lost = S::Mask::of_lanes(|lane| paths[lane].is_lost);
        for i in 0..N {
            x[i] = S::select(before | lost, x[i], moved[i]);
        }
        level = S::select(before | lost, level, uprightness(&jacobian, is_symmetric));
        if paths.iter().all(|path| path.is_done) {
            let iterations = paths.iter().map(|path| path.convergence.iterations).max().unwrap_or(0);
            let (x, effort) = accepted(x, level, iterations);
            return (x.map(|x| S::select(lost, poison(), x)), effort.iterations);
        }
    }
}

/// `newton::corrected_end`, by lane.
#[cfg_attr(not(debug_assertions), inline(always))]
fn corrected_end<S: Scalar, const N: usize>(x: &[S; N], correction: &[S; N]) -> ([S; N], S) {
    let (mut moved, mut largest) = (*x, S::from_f64(0.0));
    for i in 0..N {
        moved[i] = x[i] - correction[i];
        let size = nearly_relative(correction[i], moved[i]);
        largest = if i == 0 { size } else { S::select(exceeds(largest, size), largest, size) };
    }
    (moved, largest)
}

/// The number that `newton::is_upright` compares with its bound.
#[cfg_attr(not(debug_assertions), inline(always))]
fn uprightness<S: Scalar, const N: usize>(jacobian: &[[S; N]; N], is_symmetric: bool) -> S {
    if N == 1 || (N == 2 && is_symmetric) { jacobian[0][0] } else { S::from_f64(1.0) }
}

/// With an infinite slope the correction is zero, and a determinant far from that of an empty step belongs to
/// another solution.
#[cfg_attr(not(debug_assertions), inline(always))]
fn accepted<S: Scalar, const N: usize>(mut x: [S; N], level: S, iterations: u32) -> ([S; N], Effort) {
    if N == 1 {
        let is_upright = S::from_f64(UPRIGHT).less_equal(level) & level.is_finite();
        x[0] = S::select(is_upright, x[0], poison());
    } else if N == 2 {
        let is_upright = S::from_f64(0.0).less(level);
        x = x.map(|x| S::select(is_upright, x, poison()));
    }
    (x, Effort::fast(iterations))
}

/// [`correction`], where no lane needs a pivot that others do not.
#[cfg_attr(not(debug_assertions), inline(always))]
fn safe_correction<S: Scalar, const N: usize>(
    matrix: &[[S; N]; N],
    b: &[S; N],
    is_symmetric: bool,
) -> Option<[S; N]> {
    if N != 2 {
        return Some(correction(matrix, b, is_symmetric));
    }
    let (solution, is_safe) = of_pair(matrix, b, is_symmetric);
    if is_safe.all() { Some(solution) } else { None }
}

/// Two unknowns by Cramer's rule, and where that is safe.
#[cfg_attr(not(debug_assertions), inline(always))]
fn of_pair<S: Scalar, const N: usize>(
    matrix: &[[S; N]; N],
    b: &[S; N],
    is_symmetric: bool,
) -> ([S; N], S::Mask) {
    let m01 = if is_symmetric { matrix[1][0] } else { matrix[0][1] };
    let (m00, m10, m11) = (matrix[0][0], matrix[1][0], matrix[1][1]);
    let (main, cross) = (m00 * m11, m01 * m10);
    let determinant = main - cross;
    let is_safe = exceeds(determinant, (main.abs() + cross.abs()) * SAFE_DETERMINANT);
    let inverse = determinant.recip();
    let mut solution = *b;
    solution[0] = (b[0] * m11 - b[1] * m01) * inverse;
    solution[1] = (b[1] * m00 - b[0] * m10) * inverse;
    (solution, is_safe)
}

/// `A⁻¹ b` as the generic solvers have it: Cramer's rule for two unknowns where it is safe, else by
/// elimination.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn correction<S: Scalar, const N: usize>(
    matrix: &[[S; N]; N],
    b: &[S; N],
    is_symmetric: bool,
) -> [S; N] {
    if N == 1 {
        return b.map(|b| b / matrix[0][0]);
    }
    if N != 2 {
        return if is_symmetric { symmetric(matrix, b) } else { general::<S, N, true>(matrix, b) };
    }
    let (mut solution, is_safe) = of_pair(matrix, b, is_symmetric);
    if !is_safe.all() {
        let mut full = *matrix;
        if is_symmetric {
            full[0][1] = full[1][0];
        }
        let other = rarely(&full, b, is_symmetric);
        for i in 0..N {
            solution[i] = S::select(is_safe, solution[i], other[i]);
        }
    }
    solution
}

/// Out of the way of the common one.
#[cold]
#[inline(never)]
fn rarely<S: Scalar, const N: usize>(matrix: &[[S; N]; N], b: &[S; N], is_symmetric: bool) -> [S; N] {
    if is_symmetric { symmetric(matrix, b) } else { general::<S, N, true>(matrix, b) }
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
fn symmetric<S: Scalar, const N: usize>(matrix: &[[S; N]; N], b: &[S; N]) -> [S; N] {
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
        let other = rarely(&full, b, false);
        for i in 0..N {
            x[i] = S::select(stable, x[i], S::select(definite, other[i], poison()));
        }
    }
    x
}

/// The pivot where it is usable, else NaN.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn usable<S: Scalar>(pivot: S) -> S {
    let size = pivot.abs();
    let is_usable = exceeds(size, S::from_f64(PIVOT_ULPS)) & size.less(S::from_f64(LARGEST_PIVOT));
    S::select(is_usable, pivot, poison())
}
