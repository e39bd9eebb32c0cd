//! The solvers of a step: dense factorisation and Newton's method, on arrays, without allocation.
//!
//! Generated code calls the functions here. What they do with one number, and with several that share a verdict (dual
//! numbers), is in `newton` and `dense`; lanes of trajectories are decided one by one, in `lanes`.

mod banded;
mod damped;
mod dense;
mod krylov;
#[cfg(feature = "ensemble")]
mod lanes;
mod newton;

pub use banded::{Banded, reverse_cuthill_mckee};
pub use dense::{Factor, SymmetricFactor, prepared, reciprocal_above_one};
pub use krylov::Krylov;
#[cfg(feature = "ensemble")]
pub use lanes::LaneByLane;
pub use newton::{Effort, Extrapolation};
pub(crate) use newton::{Progress, STAGNATION, Verdict, astray};

use crate::error::StepFailure;
use crate::scalar::Scalar;

/// How systems of equations in numbers of a type are solved.
pub trait Solve<S: Scalar> {
    /// See [`newton_scalar`].
    ///
    /// # Errors
    /// As there.
    #[inline(always)]
    fn newton_scalar<const GUESS: bool, const CAREFUL: bool>(
        start: S,
        state: S,
        equation: impl FnMut(S) -> (S, S),
    ) -> Result<(S, Effort), StepFailure> {
        newton::newton_scalar::<S, GUESS, CAREFUL>(start, state, equation)
    }

    /// See [`newton`] and [`newton_symmetric`].
    ///
    /// # Errors
    /// As there.
    #[inline(always)]
    fn newton<const N: usize, const SYMMETRIC: bool, const GUESS: bool, const CAREFUL: bool>(
        start: [S; N],
        state: [S; N],
        equations: impl FnMut(&[S; N]) -> ([S; N], [[S; N]; N]),
    ) -> Result<([S; N], Effort), StepFailure> {
        if SYMMETRIC {
            newton::newton_symmetric::<S, N, GUESS, CAREFUL>(start, state, equations)
        } else {
            newton::newton::<S, N, GUESS, CAREFUL>(start, state, equations)
        }
    }

    /// See [`linear`].
    ///
    /// # Errors
    /// As there.
    #[inline(always)]
    fn linear<const N: usize>(matrix: [[S; N]; N], b: [S; N]) -> Result<[S; N], StepFailure> {
        Ok(Factor::new(matrix)?.solve(b))
    }

    /// See [`reciprocal`].
    ///
    /// # Errors
    /// As there.
    #[inline(always)]
    fn reciprocal(pivot: S) -> Result<S, StepFailure> {
        dense::reciprocal(pivot)
    }

    /// See [`quotient`].
    ///
    /// # Errors
    /// As there.
    #[inline(always)]
    fn quotient(rhs: S, pivot: S) -> Result<S, StepFailure> {
        dense::quotient(rhs, pivot)
    }
}

/// One verdict for the whole number.
#[derive(Clone, Copy, Debug)]
pub struct Together;

impl<S: Scalar> Solve<S> for Together {}

/// Solves `r(x) = 0` for one unknown from `start`; `equation` gives the residual and its slope, `state` the component
/// of the state that `x` is an increment of. `GUESS`: whether a start other than zero may come from past steps.
///
/// # Errors
/// [`StepFailure::NotConverged`], [`StepFailure::Singular`] or [`StepFailure::NonFinite`]; unless `CAREFUL`, of any
/// iteration whose corrections do not shrink fast. Lanes have NaN instead.
#[inline(always)]
pub fn newton_scalar<S: Scalar, const GUESS: bool, const CAREFUL: bool>(
    start: S,
    state: S,
    equation: impl FnMut(S) -> (S, S),
) -> Result<(S, Effort), StepFailure> {
    S::Solver::newton_scalar::<GUESS, CAREFUL>(start, state, equation)
}

/// [`newton_scalar`] for `N` coupled unknowns; `equations` gives the residuals and the Jacobian by rows.
///
/// # Errors
/// As [`newton_scalar`].
#[inline(always)]
pub fn newton<S: Scalar, const N: usize, const GUESS: bool, const CAREFUL: bool>(
    start: [S; N],
    state: [S; N],
    equations: impl FnMut(&[S; N]) -> ([S; N], [[S; N]; N]),
) -> Result<([S; N], Effort), StepFailure> {
    S::Solver::newton::<N, false, GUESS, CAREFUL>(start, state, equations)
}

/// [`newton`] for a Jacobian that is symmetric; only its lower triangle is read.
///
/// # Errors
/// As [`newton_scalar`].
#[inline(always)]
pub fn newton_symmetric<S: Scalar, const N: usize, const GUESS: bool, const CAREFUL: bool>(
    start: [S; N],
    state: [S; N],
    equations: impl FnMut(&[S; N]) -> ([S; N], [[S; N]; N]),
) -> Result<([S; N], Effort), StepFailure> {
    S::Solver::newton::<N, true, GUESS, CAREFUL>(start, state, equations)
}

/// `A⁻¹ b` for a matrix given by rows.
///
/// # Errors
/// [`StepFailure::Singular`] if a pivot is at the rounding level of its row. Lanes have NaN instead.
#[inline(always)]
pub fn linear<S: Scalar, const N: usize>(matrix: [[S; N]; N], b: [S; N]) -> Result<[S; N], StepFailure> {
    S::Solver::linear(matrix, b)
}

/// `1 / pivot`, for the matrix `1 - c` of one unknown.
///
/// # Errors
/// [`StepFailure::Singular`] where `1 - c` cancels to rounding, or `c` is so large that the 1 does. Lanes have NaN
/// instead.
#[inline(always)]
pub fn reciprocal<S: Scalar>(pivot: S) -> Result<S, StepFailure> {
    S::Solver::reciprocal(pivot)
}

/// `rhs / pivot`, for the equation `(1 - c) x = rhs` of one unknown.
///
/// # Errors
/// [`StepFailure::Singular`] as [`reciprocal`].
#[inline(always)]
pub fn quotient<S: Scalar>(rhs: S, pivot: S) -> Result<S, StepFailure> {
    S::Solver::quotient(rhs, pivot)
}
