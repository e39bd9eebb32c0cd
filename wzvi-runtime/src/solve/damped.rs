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
use super::newton::{
    Effort, Equations, Progress, Verdict, astray, beyond_in_any_lane, larger, relative, roundings,
};
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

/// Solves `r(x) = 0`; of a `SYMMETRIC` Jacobian only the lower triangle is read.
///
/// # Errors
/// [`StepFailure::NotConverged`], [`StepFailure::Singular`] or [`StepFailure::NonFinite`].
pub(super) fn damped<S: Scalar, const N: usize, const SYMMETRIC: bool>(
    start: [S; N],
    equations: impl Equations<S, N>,
) -> Result<([S; N], Effort), StepFailure> {
    match search::<S, N, SYMMETRIC>(start, equations, false) {
        Ok(found) => Ok(found),
        Err(_) => search::<S, N, SYMMETRIC>(start, equations, true),
    }
}

/// With whole corrections, or shortened ones.
fn search<S: Scalar, const N: usize, const SYMMETRIC: bool>(
    start: [S; N],
    equations: impl Equations<S, N>,
    shortens: bool,
) -> Result<([S; N], Effort), StepFailure> {
    let evaluate = |x: &[S; N]| {
        let (residual, jacobian) = equations.evaluate(x);
        let entry = |i: usize, j: usize| match SYMMETRIC {
            true => jacobian[i.max(j)][i.min(j)],
            false => jacobian[i][j],
        };
        let full: [[S; N]; N] = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
        (residual, full)
    };
    let most = if shortens { MOST_ITERATIONS } else { PATIENCE };
    let is_guess = start.iter().any(|x| x.magnitude() != 0.0);
    let mut progress = Progress::new(is_guess);
    let mut doubtful = shortens;
    let mut shortened = 0;
    let mut x = start;
    let (mut residual, jacobian) = evaluate(&x);
    let mut factor = Factor::new(jacobian)?;
    loop {
        let correction = factor.solve(residual);
        let end = shifted(&x, &correction, 1.0);
        let size = largest(&correction, &end);
        let beyond = |roundings| beyond_in_any_lane(equations, &x, &correction, &end, roundings);
        match progress.judge(size, beyond) {
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
        let scale: [f64; N] =
            std::array::from_fn(|i| x[i].magnitude() + correction[i].magnitude() + f64::MIN_POSITIVE);
        let mut length = 1.0;
        loop {
            let trial = shifted(&x, &correction, length);
            let (trial_residual, trial_jacobian) = evaluate(&trial);
            let next = factor.solve(trial_residual);
            let shrinks = |to: f64| shrinks(equations, &trial, &scale, &next, &correction, to);
            let contracts = length < 1.0 || shrinks(SAFE_CONTRACTION);
            doubtful |= !contracts;
            let is_lower = !shortens || shrinks(1.0 - 0.5 * length);
            if is_lower && let Ok(next) = Factor::new(trial_jacobian) {
                (x, residual, factor) = (trial, trial_residual, next);
                break;
            }
            length *= 0.5;
            if !shortens || length < SHORTEST {
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

/// Whether the next correction, in units of `scale`, is at most the fraction `to` of this one. Unknowns whose residual at
/// `trial` is nothing but rounding, which no step makes smaller, do not count. False for NaN.
fn shrinks<S: Scalar, const N: usize>(
    equations: impl Equations<S, N>,
    trial: &[S; N],
    scale: &[f64; N],
    next: &[S; N],
    correction: &[S; N],
    to: f64,
) -> bool {
    let level = |c: &[S; N], counts: &dyn Fn(usize) -> bool| {
        (0..N).filter(|&i| counts(i)).map(|i| c[i].magnitude() / scale[i]).fold(0.0, larger)
    };
    if level(next, &|_| true) <= to * level(correction, &|_| true) {
        return true;
    }
    let mut is_settled = [true; N];
    for lane in 0..S::LANES {
        let residual = equations.rounded(trial, lane);
        for (is_settled, residual) in is_settled.iter_mut().zip(residual) {
            *is_settled &= residual.is_below(roundings(false));
        }
    }
    level(next, &|i| !is_settled[i]) <= to * level(correction, &|i| !is_settled[i])
}

fn shifted<S: Scalar, const N: usize>(x: &[S; N], correction: &[S; N], length: f64) -> [S; N] {
    std::array::from_fn(|i| x[i] - correction[i] * length)
}

/// The largest correction relative to its unknown; NaN if any is.
fn largest<S: Scalar, const N: usize>(correction: &[S; N], unknown: &[S; N]) -> f64 {
    correction.iter().zip(unknown).map(|(&c, &x)| relative(c, x)).fold(0.0, larger)
}

#[cfg(test)]
mod tests {
    use super::super::Block;
    use super::*;
    use crate::scalar::Rounded;

    /// An equation and its slope, with the rounding of a value of the size of 1.
    fn scalar(start: f64, equation: impl Fn(f64) -> (f64, f64) + Copy) -> Result<(f64, Effort), StepFailure> {
        let evaluate = |&[x]: &[f64; 1]| {
            let (residual, slope) = equation(x);
            ([residual], [[slope]])
        };
        let rounded = |&[x]: &[f64; 1], _| [Rounded { value: equation(x).0, error: f64::EPSILON }];
        damped::<_, 1, false>([start], Block { evaluate, rounded }).map(|([x], effort)| (x, effort))
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
        let rounded = |z: &[f64; 2], _: usize| {
            let (residual, errors) = (equations(z).0, [1e100, 1e-100]);
            std::array::from_fn(|i| Rounded { value: residual[i], error: f64::EPSILON * errors[i] })
        };
        let ([x, y], _) = damped::<_, 2, false>([0.0; 2], Block { evaluate: equations, rounded }).unwrap();
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
