//! The solvers of a step: dense factorisation and Newton's method, on arrays, without allocation.
//!
//! Generated code calls the functions of [`Scalar`](crate::algebra::scalar::Scalar) with these names. `newton` and `dense` implement them for
//! one number and for several that share a verdict (dual numbers). `lanes` decides for each lane of trajectories separately.

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
pub use graph::reverse_cuthill_mckee;
pub(crate) use krylov::power_of_two;
pub use krylov::{Krylov, Operator};
pub use newton::Equations;
pub(crate) use newton::astray;
pub use sparse::Sparse;

/// How numbers of any type are solved for that have one verdict.
pub(crate) mod together {
    pub(crate) use super::dense::{linear, usable};
    pub(crate) use super::newton::newton;
}
