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
mod effort;
mod extrapolation;
mod factors;
mod graph;
mod krylov;
pub(crate) mod lanes;
mod newton;
mod sparse;

pub use banded::Banded;
pub use block::{Block, Inputs};
pub(crate) use damped::{Problem, Room, damped};
pub use dense::{Factor, SymmetricFactor, prepared, reciprocal_above_one};
pub use effort::{Doubt, Effort};
pub use extrapolation::Extrapolation;
pub use factors::FactorsByLane;
pub(crate) use graph::Apart;
pub use graph::reverse_cuthill_mckee;
pub(crate) use krylov::power_of_two;
pub use krylov::{Krylov, Operator};
pub use newton::Equations;
pub(crate) use newton::{astray, larger};
pub use sparse::Sparse;

use crate::algebra::scalar::Scalar;
use crate::error::StepFailure;

/// How numbers of any type are solved for that have one verdict.
pub(crate) mod together {
    pub(crate) use super::dense::{linear, quotient, reciprocal};
    pub(crate) use super::newton::newton;
}

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
    S::newton::<N, SYMMETRIC, GUESS, CAREFUL>(x, equations)
}

/// `A⁻¹ b` for a matrix given by rows.
///
/// # Errors
/// [`StepFailure::Singular`] if a pivot is at the rounding level of the terms subtracted from it. Lanes have NaN instead.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn linear<S: Scalar, const N: usize>(matrix: [[S; N]; N], b: [S; N]) -> Result<[S; N], StepFailure> {
    S::linear(matrix, b)
}

/// `1 / pivot`, for the matrix `1 - c` of one unknown.
///
/// # Errors
/// [`StepFailure::Singular`] where `1 - c` cancels to rounding, or `c` is so large that the 1 does. Lanes have NaN
/// instead.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn reciprocal<S: Scalar>(pivot: S) -> Result<S, StepFailure> {
    S::reciprocal(pivot)
}

/// `rhs / pivot`, for the equation `(1 - c) x = rhs` of one unknown.
///
/// # Errors
/// [`StepFailure::Singular`] as [`reciprocal`].
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn quotient<S: Scalar>(rhs: S, pivot: S) -> Result<S, StepFailure> {
    S::quotient(rhs, pivot)
}
