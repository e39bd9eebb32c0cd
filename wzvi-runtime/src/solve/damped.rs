//! Newton's method for the steps where the short way fails: with patience, then with a line search, and with a doubt about
//! its own result.
//!
//! Near a solution the next correction is less than half of the last: with `c = J⁻¹r` at `x`, and the same matrix, `|J⁻¹r(x -
//! c)| < |c| / 2`. Where it is not, the solution found need not be the one nearest to the start, and is reported as
//! doubtful. Whole corrections often arrive all the same, along the curved valley of a stiff force faster than any others:
//! they are tried first. Then each is shortened until the residual at its end is smaller, `|J⁻¹r(x - λc)| <= (1 - λ/2) |c|`:
//! the natural monotonicity test, which no scaling of equations or unknowns changes (P. Deuflhard, *Newton Methods for
//! Nonlinear Problems*, Springer 2011, section 3.3).

use super::dense::Factor;
use super::newton::{Effort, Progress, STAGNATION, Verdict, astray, is_rounding, relative};
use crate::error::StepFailure;
use crate::scalar::Scalar;

/// Whole corrections that are tried, whatever they do.
const PATIENCE: u32 = 12;
/// More shortened corrections than any step needs that converges at all.
const MOST_ITERATIONS: u32 = 20;
/// More whole corrections than it takes to halve the first one to rounding level.
const MOST_HALVINGS: u32 = 64;
/// Corrections are shortened to this fraction at most.
const SHORTEST: f64 = 1.0 / 64.0;
/// Next corrections below this fraction of the one before leave no doubt.
const SAFE_CONTRACTION: f64 = 0.5;

/// Solves `r(x) = 0`; `equations` gives the residuals and the full Jacobian by rows, `state` the components of the state
/// that the unknowns are increments of.
///
/// # Errors
/// [`StepFailure::NotConverged`], [`StepFailure::Singular`] or [`StepFailure::NonFinite`].
pub(super) fn damped<S: Scalar, const N: usize>(
    start: [S; N],
    state: [S; N],
    mut equations: impl FnMut(&[S; N]) -> ([S; N], [[S; N]; N]),
) -> Result<([S; N], Effort), StepFailure> {
    match search(start, state, &mut equations, false) {
        Ok(found) => Ok(found),
        Err(_) => search(start, state, &mut equations, true),
    }
}

/// With whole corrections, or shortened ones.
fn search<S: Scalar, const N: usize>(
    start: [S; N],
    state: [S; N],
    equations: &mut impl FnMut(&[S; N]) -> ([S; N], [[S; N]; N]),
    shortens: bool,
) -> Result<([S; N], Effort), StepFailure> {
    let most = if shortens { MOST_ITERATIONS } else { PATIENCE };
    let is_guess = start.iter().any(|x| x.magnitude() != 0.0);
    let mut progress = Progress::new(is_guess);
    let mut doubtful = shortens;
    let mut shortened = 0;
    let mut x = start;
    let (mut residual, jacobian) = equations(&x);
    let mut factor = Factor::new(jacobian)?;
    loop {
        let correction = factor.solve(residual);
        let end = shifted(&x, &correction, 1.0);
        let size = largest(&correction, |i| end[i]);
        let is_stagnation = || (0..N).all(|i| is_rounding(correction[i], end[i], state[i]));
        match progress.judge(size, is_stagnation) {
            Verdict::Converged => {
                return Ok((end, found(&progress, doubtful, &factor)));
            }
            Verdict::Straying if size.is_nan() || progress.iterations >= most => {
                return Err(astray(progress.iterations, size));
            }
            // A guess that is off by more than the solution itself.
            Verdict::Straying => doubtful |= is_guess && progress.iterations == 1,
            Verdict::Contracting if progress.iterations >= MOST_HALVINGS => {
                return Err(astray(progress.iterations, size));
            }
            Verdict::Contracting => {}
        }
        let scale: [f64; N] = std::array::from_fn(|i| magnitude_of(x[i], correction[i], state[i]));
        let level = |c: &[S; N]| {
            c.iter().zip(&scale).fold(0.0, |most: f64, (c, scale)| {
                let size = c.magnitude() / scale;
                if size <= most || most.is_nan() { most } else { size }
            })
        };
        let here = level(&correction);
        let mut length = 1.0;
        loop {
            let trial = shifted(&x, &correction, length);
            let (trial_residual, trial_jacobian) = equations(&trial);
            let next = factor.solve(trial_residual);
            let there = level(&next);
            // What is left may be nothing but the rounding of the residual, which no step makes smaller.
            let is_floor = length == 1.0 && (0..N).all(|i| is_rounding(next[i], trial[i], state[i]));
            // All false for NaN.
            let contracts = is_floor || there <= SAFE_CONTRACTION * here;
            doubtful |= length == 1.0 && !contracts;
            let is_lower = is_floor || !shortens || there <= (1.0 - 0.5 * length) * here;
            if is_lower && let Ok(next) = Factor::new(trial_jacobian) {
                (x, residual, factor) = (trial, trial_residual, next);
                break;
            }
            length *= 0.5;
            if !shortens || length < SHORTEST {
                // A component that crosses zero may carry the rounding of its neighbours.
                if shortens && is_rounding_of_block(&correction, &end, &state) {
                    return Ok((end, found(&progress, doubtful, &factor)));
                }
                // A singular matrix at the end of every way down is the cause.
                Factor::new(trial_jacobian)?;
                return Err(astray(progress.iterations, size));
            }
        }
        if length < 1.0 {
            shortened += 1;
            if shortened >= MOST_ITERATIONS {
                return Err(astray(progress.iterations, size));
            }
            progress.forget();
        }
    }
}

fn found<S: Scalar, const N: usize>(progress: &Progress, doubtful: bool, factor: &Factor<S, N>) -> Effort {
    Effort { iterations: progress.iterations, doubtful, is_reversed: factor.is_reversed() }
}

/// Whether the largest correction is at rounding level of the largest component.
fn is_rounding_of_block<S: Scalar, const N: usize>(
    correction: &[S; N],
    unknowns: &[S; N],
    state: &[S; N],
) -> bool {
    let sizes = unknowns.iter().zip(state).map(|(x, state)| x.magnitude() + state.magnitude());
    let bound = STAGNATION * sizes.fold(0.0, f64::max);
    // False for NaN.
    correction.iter().all(|c| c.magnitude() <= bound)
}

fn shifted<S: Scalar, const N: usize>(x: &[S; N], correction: &[S; N], length: f64) -> [S; N] {
    std::array::from_fn(|i| x[i] - correction[i] * length)
}

/// The largest correction relative to its unknown; NaN if any is.
fn largest<S: Scalar, const N: usize>(correction: &[S; N], unknown: impl Fn(usize) -> S) -> f64 {
    (0..N)
        .map(|i| relative(correction[i], unknown(i)))
        .fold(0.0, |most, size| if size <= most || most.is_nan() { most } else { size })
}

/// What a change of this unknown is small against: the unknown, its correction, and a millionth of the state.
fn magnitude_of<S: Scalar>(x: S, correction: S, state: S) -> f64 {
    x.magnitude() + correction.magnitude() + 1e-6 * state.magnitude() + f64::MIN_POSITIVE
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scalar(start: f64, equation: impl Fn(f64) -> (f64, f64)) -> Result<(f64, Effort), StepFailure> {
        let equations = |&[x]: &[f64; 1]| {
            let (residual, slope) = equation(x);
            ([residual], [[slope]])
        };
        damped([start], [1.0], equations).map(|([x], effort)| (x, effort))
    }

    #[test]
    fn full_corrections_that_diverge_are_shortened() {
        // atan(x - 3): from 0 Newton's method without damping runs away.
        let (x, effort) = scalar(0.0, |x| ((x - 3.0).atan(), 1.0 / (1.0 + (x - 3.0).powi(2)))).unwrap();
        assert_eq!(x, 3.0);
        assert!(effort.doubtful && effort.iterations < 15, "{effort:?}");
    }

    #[test]
    fn a_step_of_ordinary_size_leaves_no_doubt() {
        let (x, effort) = scalar(0.0, |x| (x - 0.1 * (1.0 + x).sin(), 1.0 - 0.1 * (1.0 + x).cos())).unwrap();
        assert!((x - 0.1 * (1.0 + x).sin()).abs() <= f64::EPSILON * x);
        assert!(!effort.doubtful && effort.iterations <= 5, "{effort:?}");
    }

    #[test]
    fn a_guess_on_the_wrong_side_is_doubtful() {
        let (x, effort) = scalar(-7.0, |x| (x - 1.0, 1.0)).unwrap();
        assert!(x == 1.0 && effort.doubtful);
    }

    #[test]
    fn badly_scaled_unknowns_are_no_obstacle() {
        // The same equation in units of 1e-200 and 1e200.
        let equations = |z: &[f64; 2]| {
            let [x, y] = [z[0] * 1e200, z[1] * 1e-200];
            let residual = [(x - 3.0 + 0.1 * y).atan() * 1e100, (y - 2.0) * 1e-100];
            let slope = 1.0 / (1.0 + (x - 3.0 + 0.1 * y).powi(2));
            (residual, [[slope * 1e200 * 1e100, slope * 0.1 * 1e-100], [0.0, 1e-300]])
        };
        let ([x, y], _) = damped([0.0; 2], [0.0; 2], equations).unwrap();
        assert!((x * 1e200 - 2.8).abs() < 1e-14 && y * 1e-200 == 2.0, "{x} {y}");
    }

    #[test]
    fn no_solution_is_an_error() {
        let outcome = scalar(0.5, |x| (1.0 + x * x, 2.0 * x));
        assert!(
            matches!(outcome, Err(StepFailure::NotConverged { .. } | StepFailure::Singular { .. })),
            "{outcome:?}"
        );
        assert_eq!(scalar(0.0, |_| (f64::NAN, 1.0)).map(|_| ()), Err(StepFailure::NonFinite));
    }
}
