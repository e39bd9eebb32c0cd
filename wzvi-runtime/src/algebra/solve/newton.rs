//! Newton's method, run until another iteration could change nothing but rounding.
//!
//! The unknowns are increments of the state, so that their digits are not lost in it. With `e_k` the largest
//! correction relative to its unknown, the iteration ends when `e_k` is at rounding level, when quadratic
//! convergence predicts that the next correction, `e_k (e_k / e_{k-1})²`, is below it, or when the
//! corrections stop shrinking because they are rounding of the residual (E. Hairer, R. I. McLachlan, A.
//! Razakarivony, "Achieving Brouwer's law with implicit Runge-Kutta methods", BIT 48, 2008).
//!
//! One criterion decides the last case: a residual is zero if it is below the rounding of its own terms,
//! which is computed by evaluating the same equations on numbers with error bounds ([`Rounded`]). That
//! depends on no unit, compares no unknown with another, and is done only where corrections do not shrink any
//! more. Unknowns whose equations are at rounding level do not count in the contraction of the others.
//!
//! This is the fast method of nearly every step. It has no damping, and gives up as soon as the corrections
//! do not shrink as they do near a solution, or where the Jacobian shows that the solution is not the one
//! that continues the state. Then the step is solved again with `CAREFUL`, which is
//! [`damped`](super::damped). From zero the first correction is the whole step and proves nothing; the second
//! must be at most an eighth of it. An extrapolated start may be anywhere: its second correction must be at
//! most a thousandth of the step.
//!
//! One text serves a single number and the lanes of several trajectories: truths are masks. Each lane
//! performs the operations that it would perform alone: it has its own verdict after each iteration, and
//! keeps its bits once it has converged. Where a single number has an error, a lane has NaN, which marks it
//! at the end of the step; the caller then takes its step alone. Compared with a text for each, steps of
//! `Midpoint` and `Lambda<1, 4>` of one to three degrees of freedom take 1.002 to 1.008 of the instructions
//! for a single number, and 0.92 to 1.008 in lanes.
//!
//! The Jacobian of an empty step is the identity, whatever the units are, and it is singular where two
//! branches of solutions meet. On the branch that continues the state its determinant is positive, and it is
//! definite where it is symmetric. For one unknown it must be above one half.

use super::convergence::{Convergence, Verdict, nearly_relative, relative_to};
use super::damped::{Dense, NewtonScratch, damped};
use super::dense::{Factor, SymmetricFactor, is_definite};
use super::effort::Effort;
use super::lanes::{self, decides_by_lane, poison};
use crate::algebra::scalar::{Mask, Rounded, Scalar, larger};
use crate::error::StepFailure;

/// A determinant above this fraction of its two products has lost three digits at most, which Newton's method
/// makes up.
const SAFE_DETERMINANT: f64 = 1e-3;

/// The equations `r(x) = 0` of one step.
pub trait Equations<S, const N: usize>: Copy {
    /// The residuals, and their Jacobian by rows.
    fn evaluate(&self, x: &[S; N]) -> ([S; N], [[S; N]; N]);

    /// The residuals of one lane, at all numbers that round to `x`.
    fn rounded(&self, x: &[S; N], lane: usize) -> [Rounded; N];
}

/// The largest of the relative corrections of those unknowns whose residual is more than its rounding.
#[cold]
#[inline(never)]
fn beyond<const N: usize>(residual: [Rounded; N], relative: [f64; N]) -> f64 {
    let left = residual.iter().zip(relative).filter(|(residual, _)| !residual.is_below(1.0));
    left.fold(0.0, |most, (_, size)| larger(most, size))
}

/// Why an iteration is given up.
#[cold]
pub(crate) fn astray(iterations: u32, correction: f64) -> StepFailure {
    if correction.is_nan() {
        StepFailure::NonFinite
    } else {
        StepFailure::NotConverged { iterations, correction }
    }
}

/// Solves `r(x) = 0` from `x`, which becomes the solution; of a `SYMMETRIC` Jacobian only the lower triangle
/// is read. `GUESS`: whether a start other than zero may come from past steps.
///
/// # Errors
/// [`StepFailure::NotConverged`], [`StepFailure::Singular`] or [`StepFailure::NonFinite`]; unless `CAREFUL`,
/// of any iteration whose corrections do not shrink fast. In lanes, paths without a solution have NaN
/// instead, unless `CAREFUL`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn newton<
    S: Scalar,
    const N: usize,
    const SYMMETRIC: bool,
    const GUESS: bool,
    const CAREFUL: bool,
>(
    x: &mut [S; N],
    equations: impl Equations<S, N>,
) -> Result<Effort, StepFailure> {
    if CAREFUL {
        let mut room = NewtonScratch::of(x);
        let effort = damped(&mut Dense::<_, S, N, SYMMETRIC>::new(equations), &mut room, x)?;
        *x = *room.solution();
        return Ok(effort);
    }
    let (mut end, mut level) = (*x, S::from_f64(0.0));
    let mut convergence = Convergence::new(GUESS);
    loop {
        let (residual, jacobian) = equations.evaluate(&end);
        let (correction, is_safe) = corrected::<S, N, SYMMETRIC>(&jacobian, &residual);
        if !is_safe.all() {
            break;
        }
        let (ended, (moved, largest)) = (convergence.ended(), corrected_end(&end, &correction));
        let Some(done) = convergence.glance(largest) else { break };
        for i in 0..N {
            end[i] = S::select(ended, end[i], moved[i]);
        }
        level = S::select(ended, level, uprightness::<S, N, SYMMETRIC>(&jacobian));
        if done.all() {
            *x = end;
            return accepted::<S, N, SYMMETRIC>(x, level, convergence.iterations);
        }
    }
    let (end, effort) = resumed::<S, N, SYMMETRIC>(end, level, convergence, equations)?;
    *x = end;
    Ok(effort)
}

/// The iteration of one lane where it is judged by itself.
struct LaneSearch {
    convergence: Convergence<f64>,
    is_done: bool,
    /// Whether it went astray.
    is_lost: bool,
}

/// The most iterations of a lane, if all are done.
fn iterations_of(lanes: &[LaneSearch]) -> Option<u32> {
    let are_done = lanes.iter().all(|search| search.is_done);
    are_done.then(|| lanes.iter().map(|search| search.convergence.iterations).max().unwrap_or(0))
}

/// The iteration from `x` on, where a lane needs a pivot or the residuals. A call by value, and the last
/// thing that the caller does: nothing in its loop must leave its register.
#[cold]
#[inline(never)]
fn resumed<S: Scalar, const N: usize, const SYMMETRIC: bool>(
    mut x: [S; N],
    mut level: S,
    convergence: Convergence<S>,
    equations: impl Equations<S, N>,
) -> Result<([S; N], Effort), StepFailure> {
    let ended = convergence.ended();
    let mut lanes = S::Mask::by_lane(|lane| {
        let mut convergence = convergence.lane(lane);
        if convergence.iterations == 0 && x.iter().all(|x| x.lane(lane) == 0.0) {
            convergence.claim_nothing();
        }
        LaneSearch { convergence, is_done: ended.lane(lane), is_lost: false }
    });
    let lanes = lanes.as_mut();
    loop {
        let (residual, jacobian) = equations.evaluate(&x);
        let (mut correction, is_safe) = corrected::<S, N, SYMMETRIC>(&jacobian, &residual);
        if !is_safe.all() {
            let by_pivots = factored::<S, N, SYMMETRIC>(&jacobian, &residual);
            for i in 0..N {
                correction[i] = S::select(is_safe, correction[i], by_pivots[i]);
            }
        }
        let (moved, largest) = corrected_end(&x, &correction);
        let before = S::Mask::of_lanes(|lane| lanes[lane].is_done);
        for (lane, search) in lanes.iter_mut().enumerate() {
            if before.lane(lane) {
                continue;
            }
            let relatives =
                || std::array::from_fn(|i| relative_to(correction[i].lane(lane), moved[i].lane(lane)));
            let beyond_rounding = || beyond::<N>(equations.rounded(&x, lane), relatives());
            let verdict = search.convergence.judge(largest.lane(lane), beyond_rounding);
            search.is_done = !matches!(verdict, Verdict::Contracting);
            search.is_lost = matches!(verdict, Verdict::Straying);
            if search.is_lost && !const { decides_by_lane::<S>() } {
                let size = relatives().into_iter().fold(0.0, larger);
                return Err(explain::<S, N, SYMMETRIC>(search.convergence.iterations, size, jacobian));
            }
        }
        let lost = S::Mask::of_lanes(|lane| lanes[lane].is_lost);
        for i in 0..N {
            x[i] = S::select(before | lost, x[i], moved[i]);
        }
        level = S::select(before | lost, level, uprightness::<S, N, SYMMETRIC>(&jacobian));
        if let Some(iterations) = iterations_of(lanes) {
            let effort = accepted::<S, N, SYMMETRIC>(&mut x, level, iterations)?;
            for x in &mut x {
                *x = S::select(lost, poison(), *x);
            }
            return Ok((x, effort));
        }
    }
}

/// `x - c`, and approximately the largest component of `c` relative to it. NaN of an unknown may be missing
/// in the latter; no step returns it.
#[cfg_attr(not(debug_assertions), inline(always))]
fn corrected_end<S: Scalar, const N: usize>(x: &[S; N], correction: &[S; N]) -> ([S; N], S) {
    let (mut end, mut largest) = (*x, S::from_f64(0.0));
    for i in 0..N {
        end[i] = x[i] - correction[i];
        let size = nearly_relative(correction[i], end[i]);
        largest = if i == 0 { size } else { S::select(size.less(largest), largest, size) };
    }
    (end, largest)
}

/// The smallest Jacobian of one unknown: half of that of an empty step.
const UPRIGHT: f64 = 0.5;

/// The entry of the Jacobian that shows, if any does, whether a solution continues the state. For more than
/// one unknown each correction has tested the determinant, and a symmetric pair with a positive one is
/// definite if its first entry is positive.
#[cfg_attr(not(debug_assertions), inline(always))]
fn uprightness<S: Scalar, const N: usize, const SYMMETRIC: bool>(jacobian: &[[S; N]; N]) -> S {
    if N == 1 || (N == 2 && SYMMETRIC) { jacobian[0][0] } else { S::from_f64(1.0) }
}

/// Accepts solutions with this [`uprightness`]: with an infinite slope of one unknown the correction is zero
/// (of more unknowns the factorisation detects it), and a determinant far from that of an empty step belongs
/// to another solution.
///
/// # Errors
/// [`StepFailure`] of a single number; lanes have NaN.
#[cfg_attr(not(debug_assertions), inline(always))]
fn accepted<S: Scalar, const N: usize, const SYMMETRIC: bool>(
    x: &mut [S; N],
    level: S,
    iterations: u32,
) -> Result<Effort, StepFailure> {
    let is_upright = match N {
        1 => S::from_f64(UPRIGHT).less_equal(level) & level.less_equal(S::from_f64(f64::MAX)),
        2 if SYMMETRIC => S::from_f64(0.0).less(level),
        _ => S::Mask::from_bool(true),
    };
    if const { decides_by_lane::<S>() } {
        for x in x.iter_mut() {
            *x = S::select(is_upright, *x, poison());
        }
    } else if !is_upright.all() {
        return Err(turned(N > 1 || level.magnitude() <= f64::MAX));
    }
    Ok(Effort::fast(iterations))
}

#[cold]
fn turned(is_flat: bool) -> StepFailure {
    if is_flat { astray(0, f64::INFINITY) } else { StepFailure::NonFinite }
}

/// Why a single number went astray. A slope of zero is the cause of the infinity that follows from it.
#[cold]
fn explain<S: Scalar, const N: usize, const SYMMETRIC: bool>(
    iterations: u32,
    correction: f64,
    jacobian: [[S; N]; N],
) -> StepFailure {
    let pivot = jacobian[0][0].magnitude();
    let of_matrix = match N {
        1 => (pivot < f64::EPSILON).then_some(StepFailure::Singular { pivot, scale: 1.0 }),
        _ => pivoted::<S, N, SYMMETRIC>(jacobian, [S::from_f64(0.0); N]).err(),
    };
    of_matrix.unwrap_or_else(|| astray(iterations, correction))
}

/// `J⁻¹ r`, and where two unknowns need no pivots for it.
#[cfg_attr(not(debug_assertions), inline(always))]
fn corrected<S: Scalar, const N: usize, const SYMMETRIC: bool>(
    jacobian: &[[S; N]; N],
    residual: &[S; N],
) -> ([S; N], S::Mask) {
    match N {
        1 => {
            // The function that `map` takes would be compiled for the baseline.
            let mut correction = *residual;
            for r in &mut correction {
                *r = *r / jacobian[0][0];
            }
            (correction, S::Mask::from_bool(true))
        }
        2 => solve_pair::<S, N, SYMMETRIC>(jacobian, residual),
        _ => (factored::<S, N, SYMMETRIC>(jacobian, residual), S::Mask::from_bool(true)),
    }
}

/// Two unknowns by Cramer's rule, and where that is safe: not where the determinant is negative or cancels so
/// far that pivoting is worth its price.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn solve_pair<S: Scalar, const N: usize, const SYMMETRIC: bool>(
    matrix: &[[S; N]; N],
    b: &[S; N],
) -> ([S; N], S::Mask) {
    let (m00, m10, m11) = (matrix[0][0], matrix[1][0], matrix[1][1]);
    let m01 = if SYMMETRIC { m10 } else { matrix[0][1] };
    let (main, cross) = (m00 * m11, m01 * m10);
    let determinant = main - cross;
    // Also false for NaN, and where a product or the determinant overflows: the sum then does.
    let is_safe = ((main.abs() + cross.abs()) * SAFE_DETERMINANT).less(determinant);
    let inverse = determinant.recip();
    let mut x = *b;
    x[0] = (b[0] * m11 - b[1] * m01) * inverse;
    x[1] = (b[1] * m00 - b[0] * m10) * inverse;
    (x, is_safe)
}

/// Newton's correction by a factorisation with pivots; NaN where there is none, or where the determinant or a
/// symmetric matrix is not positive.
#[cfg_attr(not(debug_assertions), inline(always))]
fn factored<S: Scalar, const N: usize, const SYMMETRIC: bool>(
    jacobian: &[[S; N]; N],
    residual: &[S; N],
) -> [S; N] {
    if const { decides_by_lane::<S>() } {
        return if SYMMETRIC {
            lanes::symmetric(jacobian, residual)
        } else {
            lanes::general::<S, N, true>(jacobian, residual)
        };
    }
    pivoted::<S, N, SYMMETRIC>(*jacobian, *residual).unwrap_or([poison(); N])
}

/// [`factored`] of a single number.
///
/// # Errors
/// Why there is no correction.
#[inline(never)]
fn pivoted<S: Scalar, const N: usize, const SYMMETRIC: bool>(
    matrix: [[S; N]; N],
    b: [S; N],
) -> Result<[S; N], StepFailure> {
    if !SYMMETRIC {
        let factor = Factor::new(matrix)?;
        return if factor.is_reversed() { Err(turned(true)) } else { Ok(factor.solve(b)) };
    }
    match SymmetricFactor::new(matrix)? {
        SymmetricFactor::General(factor) if is_definite(&matrix) => Ok(factor.solve(b)),
        SymmetricFactor::General(_) => Err(turned(true)),
        definite => Ok(definite.solve(b)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::lanes::Lanes;
    use crate::algebra::solve::closures::Closures;

    /// An equation and its slope, with the rounding of a value of the size of 1.
    fn one(equation: impl Fn(f64) -> (f64, f64) + Copy) -> impl Equations<f64, 1> {
        Closures {
            evaluate: move |&[x]: &[f64; 1]| {
                let (residual, slope) = equation(x);
                ([residual], [[slope]])
            },
            rounded: move |&[x]: &[f64; 1], _| [Rounded { value: equation(x).0, error: f64::EPSILON }],
        }
    }

    fn solved<const N: usize, const GUESS: bool, const CAREFUL: bool>(
        start: [f64; N],
        equations: impl Equations<f64, N>,
    ) -> Result<([f64; N], Effort), StepFailure> {
        let mut x = start;
        let effort = newton::<f64, N, false, GUESS, CAREFUL>(&mut x, equations)?;
        Ok((x, effort))
    }

    /// Both ways to solve one equation.
    fn scalar(
        start: f64,
        equation: impl Fn(f64) -> (f64, f64) + Copy,
    ) -> [Result<(f64, Effort), StepFailure>; 2] {
        [solved::<1, false, false>([start], one(equation)), solved::<1, false, true>([start], one(equation))]
            .map(|outcome| outcome.map(|([x], effort)| (x, effort)))
    }

    #[test]
    fn the_last_digit_is_reached() {
        // x = cos x, to the nearest number, from where its curvature, 0.18, is no obstacle to the short way.
        for outcome in scalar(0.72, |x| (x - x.cos(), 1.0 + x.sin())) {
            let (x, effort) = outcome.unwrap();
            assert!((x - 0.739_085_133_215_160_6).abs() <= f64::EPSILON);
            assert!(effort.iterations <= 5, "{effort:?}");
        }
    }

    #[test]
    fn no_solution_is_an_error() {
        for outcome in scalar(0.5, |x| (1.0 + x * x, 2.0 * x)) {
            assert!(
                matches!(outcome, Err(StepFailure::NotConverged { .. } | StepFailure::Singular { .. })),
                "{outcome:?}"
            );
        }
        let outcome = solved::<1, false, false>([0.0], one(|_| (1.0, 0.0)));
        assert!(matches!(outcome, Err(StepFailure::Singular { .. })), "{outcome:?}");
        for outcome in scalar(0.0, |_| (f64::NAN, 1.0)) {
            assert_eq!(outcome, Err(StepFailure::NonFinite));
        }
    }

    /// Corrections by it are zero everywhere. A fixed point needs no slope: with care it is found.
    #[test]
    fn an_infinite_slope_is_no_solution() {
        let [fast, careful] = scalar(0.0, |x| (1.0 + x, f64::INFINITY));
        assert!(matches!(fast, Err(StepFailure::NonFinite | StepFailure::Singular { .. })), "{fast:?}");
        assert!(careful.is_ok_and(|(x, effort)| x == -1.0 && effort.is_doubtful()), "{careful:?}");
    }

    #[test]
    fn components_of_very_different_size_are_all_resolved() {
        // x = 1e12 (1 + y²), y = 1e-12 cos(y): both to full relative precision.
        let equations = |z: &[f64; 2]| {
            let [x, y] = *z;
            let residual = [x - 1e12 * (1.0 + y * y), y - 1e-12 * y.cos()];
            (residual, [[1.0, -2e12 * y], [0.0, 1.0 + 1e-12 * y.sin()]])
        };
        let rounded = |z: &[f64; 2], _: usize| {
            let (residual, errors) = (equations(z).0, [1e12, 1e-12]);
            std::array::from_fn(|i| Rounded { value: residual[i], error: f64::EPSILON * errors[i] })
        };
        let block = Closures { evaluate: equations, rounded };
        let ([x, y], _) = solved::<2, false, false>([0.0; 2], block).unwrap();
        assert_eq!((x, y), (1e12, 1e-12));
        let ([x, y], _) = solved::<2, false, true>([0.0; 2], block).unwrap();
        assert_eq!((x, y), (1e12, 1e-12));
    }

    /// `x - 1 + k (x - 1)²`: how far away a start is does not matter, how much the slope changes on the way
    /// from there does.
    #[test]
    fn a_start_is_judged_by_the_curvature_on_its_way() {
        let equation =
            |k: f64| one(move |x: f64| (x - 1.0 + k * (x - 1.0).powi(2), 1.0 + 2.0 * k * (x - 1.0)));
        assert!(solved::<1, true, false>([0.9], equation(0.1)).is_ok());
        assert!(solved::<1, true, false>([-1.0], equation(1e-4)).is_ok());
        let outcome = solved::<1, true, false>([-1.0], equation(0.01));
        assert!(matches!(outcome, Err(StepFailure::NotConverged { iterations: 2, .. })), "{outcome:?}");
    }

    /// `x = c + x²` from zero: there is no solution where `4c > 1`. The one with the minus sign is connected
    /// with `c = 0`; it is taken the short way where the second correction is at most an eighth and each
    /// later one a quarter of the square of the last, and with care nearer to the fold.
    #[test]
    fn nothing_extrapolated_is_no_guess() {
        let parabola = |c: f64| one(move |x: f64| (x - c - x * x, 1.0 - 2.0 * x));
        for c in [1e-300, 1e-3, 0.1, 0.24] {
            let slope = (1.0 - 4.0 * c).sqrt();
            let short = solved::<1, true, false>([0.0], parabola(c));
            assert_eq!(short.is_ok(), c < 0.2, "{c}: {short:?}");
            let ([x], _) = short.or_else(|_| solved::<1, true, true>([0.0], parabola(c))).unwrap();
            let exact = 2.0 * c / (1.0 + slope);
            // A rounding of the terms, magnified by the slope.
            assert!((x - exact).abs() <= 2.0 * f64::EPSILON * exact / (1.0 - 2.0 * exact), "{c}: {x}");
        }
        for c in [0.26, 0.4, 10.0] {
            let outcome = solved::<1, true, false>([0.0], parabola(c));
            assert!(matches!(outcome, Err(StepFailure::NotConverged { iterations: 2, .. })), "{outcome:?}");
        }
    }

    /// `x = c + k c (x/c)²/4` of any size: one number and two lanes go the same way, though only the one
    /// begins with an iteration of its own.
    #[test]
    fn the_first_correction_from_zero_is_all_of_it() {
        fn parabola<S: Scalar>(c: S, k: S) -> impl Equations<S, 1> {
            let residual = move |x: S| x - c - k * x * (x / c) * 0.25;
            Closures {
                evaluate: move |&[x]: &[S; 1]| ([residual(x)], [[S::from_f64(1.0) - k * (x / c) * 0.5]]),
                rounded: move |&[x]: &[S; 1], lane| {
                    [Rounded { value: residual(x).lane(lane), error: f64::EPSILON * c.lane(lane).abs() }]
                },
            }
        }
        let sizes = [
            0.0,
            5e-324,
            1e-310,
            f64::MIN_POSITIVE,
            1e-292,
            1e-277,
            4e-277,
            5e-277,
            1e-100,
            1.0,
            -3.0,
            1e300,
        ];
        for (c, k) in sizes.iter().flat_map(|&c| [(c, 0.0), (c, 1e-9), (c, 0.5), (c, 0.999)]) {
            let mut x = [Lanes::<2>::from_f64(0.0)];
            let lanes = newton::<Lanes<2>, 1, false, false, false>(
                &mut x,
                parabola(Lanes::new([c, 1.0]), Lanes::new([k, 0.999])),
            );
            let alone = solved::<1, false, false>([0.0], parabola(c, k));
            match alone {
                Ok(([x_alone], effort)) => {
                    assert_eq!(x[0].lane(0).to_bits(), x_alone.to_bits(), "{c} {k}");
                    assert!(effort.iterations <= lanes.unwrap().iterations, "{c} {k}");
                }
                Err(_) => assert!(x[0].lane(0).is_nan(), "{c} {k}"),
            }
        }
    }
}
