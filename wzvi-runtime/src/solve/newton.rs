//! Newton's method, run until another iteration could change nothing but rounding.
//!
//! The unknowns are increments of the state, so that their digits are not lost in it. With `e_k` the largest
//! correction relative to its unknown, the iteration ends when `e_k` is at rounding level, when quadratic convergence
//! predicts that the next correction, `e_k (e_k / e_{k-1})²`, is below it, or when the corrections stop shrinking at
//! the level of the rounding of the residual (E. Hairer, R. I. McLachlan, A. Razakarivony, "Achieving Brouwer's law
//! with implicit Runge-Kutta methods", BIT 48, 2008).

use super::dense::{Factor, SymmetricFactor};
use crate::error::StepFailure;
use crate::scalar::Scalar;

/// Corrections below this fraction of an unknown change nothing.
const ROUNDING: f64 = f64::EPSILON;
/// Stagnation counts as convergence below this fraction of the unknown or of the state component that it changes.
const STAGNATION: f64 = 1e-9;
/// More iterations than any step needs that converges at all.
const MOST_ITERATIONS: u32 = 50;

/// Unknowns of past steps, extrapolated to start the next one: `3x_n - 3x_{n-1} + x_{n-2}`.
#[derive(Clone, Copy, Debug)]
pub struct Extrapolation<S, const N: usize> {
    past: [[S; N]; 3],
    known: u8,
}

impl<S: Scalar, const N: usize> Default for Extrapolation<S, N> {
    fn default() -> Self {
        Self { past: [[S::from_f64(0.0); N]; 3], known: 0 }
    }
}

impl<S: Scalar, const N: usize> Extrapolation<S, N> {
    /// The starting value: zero, constant, linear or quadratic, by what is known.
    #[inline(always)]
    pub fn guess(&self) -> [S; N] {
        let [a, b, c] = self.past;
        match self.known {
            0 | 1 => a,
            2 => std::array::from_fn(|i| a[i] * 2.0 - b[i]),
            _ => std::array::from_fn(|i| (a[i] - b[i]) * 3.0 + c[i]),
        }
    }

    /// Takes the solution of a step that succeeded.
    #[inline(always)]
    pub fn record(&mut self, solution: [S; N]) {
        self.past = [solution, self.past[0], self.past[1]];
        self.known = (self.known + 1).min(3);
    }
}

/// Decides when to stop.
struct Progress {
    last: f64,
    iterations: u32,
}

enum Verdict {
    Converged,
    Continue,
}

impl Progress {
    #[inline(always)]
    fn new() -> Self {
        // NaN: the first correction has nothing to be compared with.
        Self { last: f64::NAN, iterations: 0 }
    }

    /// `relative`: largest correction relative to its unknown. `at_rounding`: whether every correction is small
    /// against the state.
    #[inline(always)]
    fn judge(&mut self, relative: f64, at_rounding: impl FnOnce() -> bool) -> Result<Verdict, StepFailure> {
        self.iterations += 1;
        let ratio = relative / self.last;
        if relative <= ROUNDING || relative * ratio * ratio <= 0.25 * ROUNDING {
            return Ok(Verdict::Converged);
        }
        if ratio >= 0.5 && at_rounding() {
            return Ok(Verdict::Converged);
        }
        if relative.is_nan() {
            return Err(StepFailure::NonFinite);
        }
        if self.iterations >= MOST_ITERATIONS {
            return Err(StepFailure::NotConverged { iterations: self.iterations, correction: relative });
        }
        self.last = relative;
        Ok(Verdict::Continue)
    }
}

/// `|correction| / |unknown|`, 0 for no correction.
#[inline(always)]
fn relative<S: Scalar>(correction: S, unknown: S) -> f64 {
    correction.relative_to(unknown, S::from_f64(0.0))
}

#[inline(always)]
fn is_rounding<S: Scalar>(correction: S, unknown: S, state: S) -> bool {
    correction.relative_to(unknown, state) <= STAGNATION
}

/// Solves `r(x) = 0` for one unknown from `start`; `equation` gives the residual and its slope, `state` the component
/// of the state that `x` is an increment of. Returns the solution and the iterations.
///
/// # Errors
/// [`StepFailure::NotConverged`], [`StepFailure::Singular`] or [`StepFailure::NonFinite`]; a start other than zero is
/// given up for zero first.
#[inline(always)]
pub fn newton_scalar<S: Scalar>(
    mut start: S,
    state: S,
    mut equation: impl FnMut(S) -> (S, S),
) -> Result<(S, u32), StepFailure> {
    // A loop, so that the equation is inlined once.
    loop {
        match newton_scalar_from(start, state, &mut equation) {
            Err(_) if start.magnitude() != 0.0 => start = S::from_f64(0.0),
            outcome => return outcome,
        }
    }
}

#[inline(always)]
fn newton_scalar_from<S: Scalar>(
    start: S,
    state: S,
    equation: &mut impl FnMut(S) -> (S, S),
) -> Result<(S, u32), StepFailure> {
    let mut x = start;
    let mut progress = Progress::new();
    loop {
        let (residual, slope) = equation(x);
        let correction = residual / slope;
        x = x - correction;
        match progress.judge(relative(correction, x), || is_rounding(correction, x, state)) {
            Ok(Verdict::Converged) => return Ok((x, progress.iterations)),
            Ok(Verdict::Continue) => {}
            Err(failure) => return Err(explain(failure, slope)),
        }
    }
}

/// A slope of zero is the cause of the infinity that follows from it.
#[cold]
fn explain<S: Scalar>(failure: StepFailure, slope: S) -> StepFailure {
    let pivot = slope.magnitude();
    if pivot < f64::EPSILON { StepFailure::Singular { pivot, scale: 1.0 } } else { failure }
}

/// [`newton_scalar`] for `N` coupled unknowns; `equations` gives the residuals and the Jacobian by rows.
///
/// # Errors
/// As [`newton_scalar`].
#[inline(always)]
pub fn newton<S: Scalar, const N: usize>(
    start: [S; N],
    state: [S; N],
    mut equations: impl FnMut(&[S; N]) -> ([S; N], [[S; N]; N]),
) -> Result<([S; N], u32), StepFailure> {
    iterate(start, state, |x| {
        let (residual, jacobian) = equations(x);
        Ok(Factor::new(jacobian)?.solve(residual))
    })
}

/// [`newton`] for a Jacobian that is symmetric; only its lower triangle is read.
///
/// # Errors
/// As [`newton_scalar`].
#[inline(always)]
pub fn newton_symmetric<S: Scalar, const N: usize>(
    start: [S; N],
    state: [S; N],
    mut equations: impl FnMut(&[S; N]) -> ([S; N], [[S; N]; N]),
) -> Result<([S; N], u32), StepFailure> {
    iterate(start, state, |x| {
        let (residual, jacobian) = equations(x);
        Ok(SymmetricFactor::new(jacobian)?.solve(residual))
    })
}

#[inline(always)]
fn iterate<S: Scalar, const N: usize>(
    mut start: [S; N],
    state: [S; N],
    mut correction_at: impl FnMut(&[S; N]) -> Result<[S; N], StepFailure>,
) -> Result<([S; N], u32), StepFailure> {
    // A loop, so that the equations are inlined once.
    loop {
        match iterate_from(start, state, &mut correction_at) {
            Err(_) if start.iter().any(|x| x.magnitude() != 0.0) => start = [S::from_f64(0.0); N],
            outcome => return outcome,
        }
    }
}

#[inline(always)]
fn iterate_from<S: Scalar, const N: usize>(
    start: [S; N],
    state: [S; N],
    correction_at: &mut impl FnMut(&[S; N]) -> Result<[S; N], StepFailure>,
) -> Result<([S; N], u32), StepFailure> {
    let mut x = start;
    let mut progress = Progress::new();
    loop {
        let correction = correction_at(&x)?;
        let mut largest = 0.0_f64;
        for i in 0..N {
            x[i] = x[i] - correction[i];
            let size = relative(correction[i], x[i]);
            // Not `max`, which would drop a NaN.
            largest = if size <= largest { largest } else { size };
        }
        let verdict = progress.judge(largest, || (0..N).all(|i| is_rounding(correction[i], x[i], state[i])));
        if let Verdict::Converged = verdict? {
            return Ok((x, progress.iterations));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_digit_is_reached() {
        // x = cos x, to the nearest number.
        let (x, iterations) = newton_scalar(0.5, 1.0, |x: f64| (x - x.cos(), 1.0 + x.sin())).unwrap();
        assert!((x - 0.739_085_133_215_160_6).abs() <= f64::EPSILON);
        assert!(iterations <= 5, "{iterations}");
    }

    #[test]
    fn no_solution_is_an_error() {
        let outcome = newton_scalar(0.5, 1.0, |x: f64| (1.0 + x * x, 2.0 * x));
        assert!(
            matches!(outcome, Err(StepFailure::NotConverged { .. } | StepFailure::Singular { .. })),
            "{outcome:?}"
        );
        let outcome = newton([0.0], [1.0], |_: &[f64; 1]| ([1.0], [[0.0]]));
        assert!(matches!(outcome, Err(StepFailure::Singular { .. })), "{outcome:?}");
        let outcome = newton_scalar(0.0, 1.0, |_| (f64::NAN, 1.0));
        assert_eq!(outcome, Err(StepFailure::NonFinite));
    }

    #[test]
    fn components_of_very_different_size_are_all_resolved() {
        // x = 1e12 (1 + y²), y = 1e-12 cos(y): both to full relative precision.
        let equations = |z: &[f64; 2]| {
            let [x, y] = *z;
            let residual = [x - 1e12 * (1.0 + y * y), y - 1e-12 * y.cos()];
            (residual, [[1.0, -2e12 * y], [0.0, 1.0 + 1e-12 * y.sin()]])
        };
        let ([x, y], _) = newton([0.0; 2], [1.0; 2], equations).unwrap();
        assert_eq!((x, y), (1e12, 1e-12));
    }

    #[test]
    fn extrapolation_is_exact_for_a_parabola() {
        let mut memory = Extrapolation::<f64, 1>::default();
        for n in 0..3 {
            memory.record([f64::from(n * n)]);
        }
        assert_eq!(memory.guess(), [9.0]);
    }
}
