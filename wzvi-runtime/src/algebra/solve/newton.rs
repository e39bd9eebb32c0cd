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
//! The Jacobian of an empty step is the identity, whatever the units are, and it is singular where two
//! branches of solutions meet. On the branch that continues the state its determinant is positive, and it is
//! definite where it is symmetric. For one unknown it must be above one half.

use super::convergence::{Convergence, Verdict, nearly_relative, relative_to};
use super::damped::{Dense, NewtonScratch, damped};
use super::dense::{Factor, SymmetricFactor, is_definite};
use super::effort::Effort;
use super::lanes::{self, decides_by_lane};
use crate::algebra::scalar::{Mask, Rounded, Scalar, larger};
use crate::error::StepFailure;

/// A determinant above this fraction of its two products has lost three digits at most, which Newton's method
/// makes up.
pub(super) const SAFE_DETERMINANT: f64 = 1e-3;

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
pub(super) fn beyond<const N: usize>(residual: [Rounded; N], relative: [f64; N]) -> f64 {
    let left = residual.iter().zip(relative).filter(|(residual, _)| !residual.is_below(1.0));
    left.fold(0.0, |most, (_, size)| larger(most, size))
}

/// [`beyond`] of all lanes.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn beyond_in_any_lane<S: Scalar, const N: usize>(
    equations: impl Equations<S, N>,
    x: &[S; N],
    correction: &[S; N],
    end: &[S; N],
) -> f64 {
    let sizes = relatives(correction, end);
    let mut most = 0.0;
    for lane in 0..S::LANES {
        most = larger(most, beyond(equations.rounded(x, lane), sizes));
    }
    most
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

/// `|correction| / |unknown|` of each unknown, 0 for no correction.
#[cfg_attr(not(debug_assertions), inline(always))]
fn relatives<S: Scalar, const N: usize>(correction: &[S; N], unknowns: &[S; N]) -> [f64; N] {
    std::array::from_fn(|i| relative_to(correction[i], unknowns[i]))
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
    if const { decides_by_lane::<S>() } {
        let (end, effort) = lanes::iterate(*x, GUESS, SYMMETRIC, equations);
        *x = end;
        return Ok(effort);
    }
    let mut convergence = Convergence::new(GUESS);
    if GUESS || N > 2 || begun::<S, N, SYMMETRIC>(x, &mut convergence, equations) {
        loop {
            let (residual, jacobian) = equations.evaluate(x);
            let Some(correction) = corrected::<S, N, SYMMETRIC>(&jacobian, residual) else { break };
            let (end, largest) = corrected_end(x, &correction);
            match convergence.glance(largest) {
                Some(Verdict::Contracting) => *x = end,
                Some(_) => {
                    *x = end;
                    return accepted::<S, N, SYMMETRIC>(&jacobian, convergence);
                }
                None if !GUESS && N > 2 && convergence.iterations == 0 && largest.is_finite() => {
                    *x = end;
                    convergence.begin(largest);
                }
                None => break,
            }
        }
    }
    // Taken apart: the common way writes to no memory that the call knows.
    let (end, iterations) = resumed::<S, N, SYMMETRIC>(*x, convergence, equations)?;
    *x = end;
    Ok(Effort::fast(iterations))
}

/// The first iteration from zero for few unknowns: it has no predecessor, and its correction is the whole
/// solution so far. `false`, with nothing done, where the general iteration is needed.
#[cfg_attr(not(debug_assertions), inline(always))]
fn begun<S: Scalar, const N: usize, const SYMMETRIC: bool>(
    x: &mut [S; N],
    convergence: &mut Convergence,
    equations: impl Equations<S, N>,
) -> bool {
    let (residual, jacobian) = equations.evaluate(x);
    let Some(correction) = corrected::<S, N, SYMMETRIC>(&jacobian, residual) else { return false };
    let (end, largest) = corrected_end(x, &correction);
    let is_first = (largest - 1.0).abs() < 0.5;
    if is_first {
        *x = end;
        convergence.begin(largest);
    }
    is_first
}

/// The iteration from `x` on, where it needs a pivot or the residuals. A call by value at the end of the
/// caller, so that nothing in the caller's loop must leave its register.
#[cold]
#[inline(never)]
fn resumed<S: Scalar, const N: usize, const SYMMETRIC: bool>(
    mut x: [S; N],
    mut convergence: Convergence,
    equations: impl Equations<S, N>,
) -> Result<([S; N], u32), StepFailure> {
    if convergence.iterations == 0 && x.iter().all(|x| x.magnitude() == 0.0) {
        convergence.claim_nothing();
    }
    loop {
        let (residual, jacobian) = equations.evaluate(&x);
        let correction = match corrected::<S, N, SYMMETRIC>(&jacobian, residual) {
            Some(correction) => correction,
            None => pivoted::<S, N, SYMMETRIC>(jacobian, residual)?,
        };
        let (end, largest) = corrected_end(&x, &correction);
        let beyond = || beyond_in_any_lane(equations, &x, &correction, &end);
        match convergence.judge(largest, beyond) {
            Verdict::Converged => {
                return Ok((end, accepted::<S, N, SYMMETRIC>(&jacobian, convergence)?.iterations));
            }
            Verdict::Contracting => x = end,
            Verdict::Straying => {
                let size = relatives(&correction, &end).into_iter().fold(0.0, larger);
                return Err(explain::<N>(convergence.iterations, size, jacobian[0][0].magnitude()));
            }
        }
    }
}

/// `x - c`, and approximately the largest component of `c` relative to it. NaN of an unknown may be missing
/// in the latter; no step returns it.
#[cfg_attr(not(debug_assertions), inline(always))]
fn corrected_end<S: Scalar, const N: usize>(x: &[S; N], correction: &[S; N]) -> ([S; N], f64) {
    let (mut end, mut largest) = (*x, 0.0_f64);
    for i in 0..N {
        end[i] = x[i] - correction[i];
        let size = nearly_relative(correction[i], end[i]).magnitude();
        largest = if i > 0 && largest > size { largest } else { size };
    }
    (end, largest)
}

/// The smallest Jacobian of one unknown: half of that of an empty step.
pub(super) const UPRIGHT: f64 = 0.5;

/// Whether the solution is the one that continues the state, as far as the Jacobian shows. For more than one
/// unknown each correction has tested it, except that a symmetric pair with positive determinant is definite.
#[cfg_attr(not(debug_assertions), inline(always))]
fn is_upright<S: Scalar, const N: usize, const SYMMETRIC: bool>(jacobian: &[[S; N]; N]) -> bool {
    match N {
        // With an infinite slope the correction is zero. With more unknowns the factorisation detects it.
        1 => {
            let slope = jacobian[0][0];
            S::from_f64(UPRIGHT).less_equal(slope).all() && slope.less_equal(S::from_f64(f64::MAX)).all()
        }
        2 if SYMMETRIC => S::from_f64(0.0).less(jacobian[0][0]).all(),
        _ => true,
    }
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn accepted<S: Scalar, const N: usize, const SYMMETRIC: bool>(
    jacobian: &[[S; N]; N],
    convergence: Convergence,
) -> Result<Effort, StepFailure> {
    match is_upright::<S, N, SYMMETRIC>(jacobian) {
        true => Ok(Effort::fast(convergence.iterations)),
        false => Err(turned(N > 1 || jacobian[0][0].magnitude() <= f64::MAX)),
    }
}

#[cold]
fn turned(is_flat: bool) -> StepFailure {
    if is_flat { astray(0, f64::INFINITY) } else { StepFailure::NonFinite }
}

/// A slope of zero is the cause of the infinity that follows from it. Numbers, not the matrix: what has its
/// address in a function is kept in memory in every iteration.
#[cold]
fn explain<const N: usize>(iterations: u32, correction: f64, pivot: f64) -> StepFailure {
    if N == 1 && pivot < f64::EPSILON {
        StepFailure::Singular { pivot, scale: 1.0 }
    } else {
        astray(iterations, correction)
    }
}

/// `J⁻¹ r`; `None` where two unknowns need pivots.
#[cfg_attr(not(debug_assertions), inline(always))]
fn corrected<S: Scalar, const N: usize, const SYMMETRIC: bool>(
    jacobian: &[[S; N]; N],
    residual: [S; N],
) -> Option<[S; N]> {
    match N {
        1 => Some(residual.map(|r| r / jacobian[0][0])),
        2 => solve_pair::<S, N, SYMMETRIC>(jacobian, &residual),
        _ => pivoted::<S, N, SYMMETRIC>(*jacobian, residual).ok(),
    }
}

/// Newton's correction by a factorisation with pivots.
#[cfg_attr(not(debug_assertions), inline(always))]
fn pivoted<S: Scalar, const N: usize, const SYMMETRIC: bool>(
    jacobian: [[S; N]; N],
    residual: [S; N],
) -> Result<[S; N], StepFailure> {
    if SYMMETRIC { factored_symmetric(jacobian, residual) } else { factored(jacobian, residual) }
}

/// Two unknowns by Cramer's rule; `None` for another number of them, and where the determinant is negative or
/// cancels so far that pivoting is worth its price.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn solve_pair<S: Scalar, const N: usize, const SYMMETRIC: bool>(
    matrix: &[[S; N]; N],
    b: &[S; N],
) -> Option<[S; N]> {
    if N != 2 {
        return None;
    }
    let (m00, m10, m11) = (matrix[0][0], matrix[1][0], matrix[1][1]);
    let m01 = if SYMMETRIC { m10 } else { matrix[0][1] };
    let (main, cross) = (m00 * m11, m01 * m10);
    let determinant = main - cross;
    // Also false for NaN, and where a product or the determinant overflows: the sum then does.
    let least = S::from_f64(SAFE_DETERMINANT * (main.magnitude() + cross.magnitude()));
    if !least.less(determinant).all() {
        return None;
    }
    let inverse = determinant.recip();
    let x = [(b[0] * m11 - b[1] * m01) * inverse, (b[1] * m00 - b[0] * m10) * inverse];
    Some(std::array::from_fn(|i| x[i]))
}

#[inline(never)]
fn factored<S: Scalar, const N: usize>(matrix: [[S; N]; N], b: [S; N]) -> Result<[S; N], StepFailure> {
    upright(&Factor::new(matrix)?, b)
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn upright<S: Scalar, const N: usize>(factor: &Factor<S, N>, b: [S; N]) -> Result<[S; N], StepFailure> {
    if factor.is_reversed() { Err(turned(true)) } else { Ok(factor.solve(b)) }
}

#[inline(never)]
fn factored_symmetric<S: Scalar, const N: usize>(
    matrix: [[S; N]; N],
    b: [S; N],
) -> Result<[S; N], StepFailure> {
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
