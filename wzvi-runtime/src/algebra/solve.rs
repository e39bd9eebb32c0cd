//! The solvers of a step: dense factorisation and Newton's method, on arrays, without allocation.
//!
//! Generated code calls the functions here. `newton` and `dense` implement them for one number and for several that share
//! a verdict (dual numbers). `lanes` decides for each lane of trajectories separately.

mod banded;
mod block;
#[cfg(test)]
mod closures;
mod convergence;
mod damped;
mod dense;
mod extrapolation;
mod factors;
mod graph;
mod krylov;
mod lanes;
mod newton;
mod sparse;

pub use banded::Banded;
pub use block::{Block, Inputs};
pub(crate) use damped::{Problem, Room, damped};
pub use dense::{Factor, SymmetricFactor, prepared, reciprocal_above_one};
pub use extrapolation::Extrapolation;
pub use factors::FactorsByLane;
pub(crate) use graph::Apart;
pub use graph::reverse_cuthill_mckee;
pub(crate) use krylov::power_of_two;
pub use krylov::{Krylov, Operator};
pub use lanes::LaneByLane;
pub use newton::{Effort, Equations};
pub(crate) use newton::{astray, larger};
pub use sparse::Sparse;

use crate::algebra::scalar::Scalar;
use crate::error::StepFailure;

/// How systems of equations in numbers of a type are solved.
pub trait Solve<S: Scalar> {
    /// See [`newton`].
    ///
    /// # Errors
    /// Those of [`newton`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn newton<const N: usize, const SYMMETRIC: bool, const GUESS: bool, const CAREFUL: bool>(
        x: &mut [S; N],
        equations: impl Equations<S, N>,
    ) -> Result<Effort, StepFailure> {
        newton::newton::<S, N, SYMMETRIC, GUESS, CAREFUL>(x, equations)
    }

    /// See [`linear`].
    ///
    /// # Errors
    /// Those of [`linear`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn linear<const N: usize>(matrix: [[S; N]; N], b: [S; N]) -> Result<[S; N], StepFailure> {
        Ok(Factor::new(matrix)?.solve(b))
    }

    /// See [`reciprocal`].
    ///
    /// # Errors
    /// Those of [`reciprocal`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn reciprocal(pivot: S) -> Result<S, StepFailure> {
        dense::reciprocal(pivot)
    }

    /// See [`quotient`].
    ///
    /// # Errors
    /// Those of [`quotient`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn quotient(rhs: S, pivot: S) -> Result<S, StepFailure> {
        dense::quotient(rhs, pivot)
    }
}

/// One verdict for the whole number.
#[derive(Clone, Copy, Debug)]
pub struct Together;

impl<S: Scalar> Solve<S> for Together {}

/// Solves `r(x) = 0` from `x`, which becomes the solution; of a `SYMMETRIC` Jacobian only the lower triangle is read. `GUESS`: whether a start other
/// than zero may come from past steps.
///
/// # Errors
/// [`StepFailure::NotConverged`], [`StepFailure::Singular`] or [`StepFailure::NonFinite`]; unless `CAREFUL`, of any
/// iteration whose corrections do not shrink fast. Lanes have NaN instead.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn newton<S: Scalar, const N: usize, const SYMMETRIC: bool, const GUESS: bool, const CAREFUL: bool>(
    x: &mut [S; N],
    equations: impl Equations<S, N>,
) -> Result<Effort, StepFailure> {
    S::Solver::newton::<N, SYMMETRIC, GUESS, CAREFUL>(x, equations)
}

/// `A⁻¹ b` for a matrix given by rows.
///
/// # Errors
/// [`StepFailure::Singular`] if a pivot is at the rounding level of the terms subtracted from it. Lanes have NaN instead.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn linear<S: Scalar, const N: usize>(matrix: [[S; N]; N], b: [S; N]) -> Result<[S; N], StepFailure> {
    S::Solver::linear(matrix, b)
}

/// `1 / pivot`, for the matrix `1 - c` of one unknown.
///
/// # Errors
/// [`StepFailure::Singular`] where `1 - c` cancels to rounding, or `c` is so large that the 1 does. Lanes have NaN
/// instead.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn reciprocal<S: Scalar>(pivot: S) -> Result<S, StepFailure> {
    S::Solver::reciprocal(pivot)
}

/// `rhs / pivot`, for the equation `(1 - c) x = rhs` of one unknown.
///
/// # Errors
/// [`StepFailure::Singular`] as [`reciprocal`].
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn quotient<S: Scalar>(rhs: S, pivot: S) -> Result<S, StepFailure> {
    S::Solver::quotient(rhs, pivot)
}
