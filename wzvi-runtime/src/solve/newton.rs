//! Newton's method, run until another iteration could change nothing but rounding.
//!
//! The unknowns are increments of the state, so that their digits are not lost in it. With `e_k` the largest
//! correction relative to its unknown, the iteration ends when `e_k` is at rounding level, when quadratic convergence
//! predicts that the next correction, `e_k (e_k / e_{k-1})²`, is below it, or when the corrections stop shrinking at
//! the level of the rounding of the residual (E. Hairer, R. I. McLachlan, A. Razakarivony, "Achieving Brouwer's law
//! with implicit Runge-Kutta methods", BIT 48, 2008).

use super::dense::{Factor, SymmetricFactor};
use crate::error::StepFailure;
use crate::numbers::Numbers;
use crate::scalar::Scalar;

/// Corrections below this fraction of an unknown change nothing.
const ROUNDING: f64 = f64::EPSILON;
/// Stagnation counts as convergence below this fraction of the unknown or of the state component that it changes.
const STAGNATION: f64 = 1e-9;
/// A determinant above this fraction of its two products has lost three digits at most, which Newton's method makes up.
const SAFE_DETERMINANT: f64 = 1e-3;
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
        std::array::from_fn(|i| (a[i] - b[i]) * 3.0 + c[i])
    }

    /// Takes the solution of a step that succeeded.
    #[inline(always)]
    pub fn record(&mut self, solution: [S; N]) {
        self.past = [solution, self.past[0], self.past[1]];
        if self.known < 2 {
            self.pretend();
        }
    }

    /// Continues the one or two points that are known to the past, as a constant or as a line.
    #[cold]
    fn pretend(&mut self) {
        let [a, b, c] = &mut self.past;
        if self.known == 0 {
            *b = *a;
        }
        *c = std::array::from_fn(|i| b[i] * 2.0 - a[i]);
        self.known += 1;
    }
}

impl<S: Scalar, const N: usize> Numbers<S> for Extrapolation<S, N> {
    fn visit(&mut self, visit: &mut dyn FnMut(&mut S)) {
        let Self { past, known } = self;
        past.iter_mut().flatten().for_each(&mut *visit);
        let mut number = S::from_f64(f64::from(*known));
        visit(&mut number);
        // Exact: 0, 1 or 2.
        *known = number.magnitude() as u8;
    }
}

/// Decides when to stop.
struct Progress {
    last: f64,
    /// The cube of the relative correction that is good enough: `ROUNDING³` or `last² ROUNDING / 4`.
    enough: f64,
    iterations: u32,
}

enum Verdict {
    Converged,
    Continue,
}

impl Progress {
    #[inline(always)]
    fn new() -> Self {
        Self { last: f64::INFINITY, enough: ROUNDING * ROUNDING * ROUNDING, iterations: 0 }
    }

    /// `relative`: largest correction relative to its unknown. `at_rounding`: whether every correction is small
    /// against the state.
    #[inline(always)]
    fn judge(&mut self, relative: f64, at_rounding: impl FnOnce() -> bool) -> Result<Verdict, StepFailure> {
        self.iterations += 1;
        let square = relative * relative;
        // `relative <= ROUNDING || relative (relative / last)² <= ROUNDING / 4` without dividing.
        if square * relative <= self.enough {
            return Ok(Verdict::Converged);
        }
        // False for NaN, too: one comparison on the way that is taken.
        let contracts = relative < 0.5 * self.last;
        if !contracts {
            if relative.is_nan() {
                return Err(StepFailure::NonFinite);
            }
            if self.last < f64::INFINITY && at_rounding() {
                return Ok(Verdict::Converged);
            }
            // Corrections that at least halve are at rounding level soon: only these need to be counted.
            if self.iterations >= MOST_ITERATIONS {
                return Err(StepFailure::NotConverged { iterations: self.iterations, correction: relative });
            }
        }
        self.last = relative;
        // `relative` is above `ROUNDING` here, so that neither product underflows.
        let (predicted, floor) = (0.25 * ROUNDING * square, ROUNDING * ROUNDING * ROUNDING);
        self.enough = if predicted > floor { predicted } else { floor };
        Ok(Verdict::Continue)
    }
}

/// `|correction| / |unknown|`, 0 for no correction.
#[inline(always)]
fn relative<S: Scalar>(correction: S, unknown: S) -> f64 {
    correction.relative_to(unknown, None)
}

/// Rarely asked; inlined it would keep its operands in registers for every iteration.
#[cold]
#[inline(never)]
fn is_rounding<S: Scalar>(correction: S, unknown: S, state: S) -> bool {
    correction.relative_to(unknown, Some(state)) <= STAGNATION
}

/// Solves `r(x) = 0` for one unknown from `start`; `equation` gives the residual and its slope, `state` the component
/// of the state that `x` is an increment of. Returns the solution and the iterations.
///
/// # Errors
/// [`StepFailure::NotConverged`], [`StepFailure::Singular`] or [`StepFailure::NonFinite`]; a start other than zero is
/// given up for zero first.
#[inline(always)]
pub fn newton_scalar<S: Scalar>(
    start: S,
    state: S,
    mut equation: impl FnMut(S) -> (S, S),
) -> Result<(S, u32), StepFailure> {
    let mut x = start;
    let mut may_restart = true;
    let mut progress = Progress::new();
    loop {
        let (residual, slope) = equation(x);
        let correction = residual / slope;
        x = x - correction;
        match progress.judge(relative(correction, x), || is_rounding(correction, x, state)) {
            Ok(Verdict::Converged) => return Ok((x, progress.iterations)),
            Ok(Verdict::Continue) => {}
            // Not a second copy of the loop: it would keep the whole step from being inlined.
            Err(_) if may_restart && start.magnitude() != 0.0 => {
                (x, may_restart, progress) = (S::from_f64(0.0), false, Progress::new());
            }
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
        match solve_pair(&jacobian, &residual) {
            Some(correction) => Ok(correction),
            None => factored(jacobian, residual),
        }
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
        let (residual, mut jacobian) = equations(x);
        if N == 2 {
            jacobian[0][1] = jacobian[1][0];
        }
        match solve_pair(&jacobian, &residual) {
            Some(correction) => Ok(correction),
            None => factored_symmetric(jacobian, residual),
        }
    })
}

/// Two unknowns by Cramer's rule; `None` for another number of them, and where the determinant cancels so far that
/// pivoting is worth its price.
#[inline(always)]
fn solve_pair<S: Scalar, const N: usize>(matrix: &[[S; N]; N], b: &[S; N]) -> Option<[S; N]> {
    if N != 2 {
        return None;
    }
    let ([m00, m01], [m10, m11]) = ([matrix[0][0], matrix[0][1]], [matrix[1][0], matrix[1][1]]);
    let (main, cross) = (m00 * m11, m01 * m10);
    let determinant = main - cross;
    // Also false for NaN and where a product overflows.
    let is_safe = determinant.magnitude() > SAFE_DETERMINANT * (main.magnitude() + cross.magnitude());
    if !(is_safe && determinant.magnitude() < f64::INFINITY) {
        return None;
    }
    let inverse = determinant.recip();
    let x = [(b[0] * m11 - b[1] * m01) * inverse, (b[1] * m00 - b[0] * m10) * inverse];
    Some(std::array::from_fn(|i| x[i]))
}

#[inline(never)]
fn factored<S: Scalar, const N: usize>(matrix: [[S; N]; N], b: [S; N]) -> Result<[S; N], StepFailure> {
    Ok(Factor::new(matrix)?.solve(b))
}

#[inline(never)]
fn factored_symmetric<S: Scalar, const N: usize>(
    matrix: [[S; N]; N],
    b: [S; N],
) -> Result<[S; N], StepFailure> {
    Ok(SymmetricFactor::new(matrix)?.solve(b))
}

#[inline(always)]
fn iterate<S: Scalar, const N: usize>(
    start: [S; N],
    state: [S; N],
    mut correction_at: impl FnMut(&[S; N]) -> Result<[S; N], StepFailure>,
) -> Result<([S; N], u32), StepFailure> {
    let mut x = start;
    let mut may_restart = true;
    let mut progress = Progress::new();
    loop {
        let outcome = correction_at(&x).and_then(|correction| {
            let mut largest = 0.0_f64;
            for i in 0..N {
                x[i] = x[i] - correction[i];
                let size = relative(correction[i], x[i]);
                // Not `max`, which would drop a NaN.
                largest = if size <= largest || largest.is_nan() { largest } else { size };
            }
            progress.judge(largest, || (0..N).all(|i| is_rounding(correction[i], x[i], state[i])))
        });
        match outcome {
            Ok(Verdict::Converged) => return Ok((x, progress.iterations)),
            Ok(Verdict::Continue) => {}
            Err(_) if may_restart && start.iter().any(|x| x.magnitude() != 0.0) => {
                (x, may_restart, progress) = ([S::from_f64(0.0); N], false, Progress::new());
            }
            Err(failure) => return Err(failure),
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
