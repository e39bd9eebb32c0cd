//! The solvers of a step: dense factorisation and Newton's method, on arrays, without allocation.
//!
//! Numbers do not know solvers: these are functions of any [`Scalar`](crate::algebra::scalar::Scalar).
//! Generated code calls [`linear`], [`usable`] and [`Block::newton`]. They solve by `newton` and `dense`, and
//! for each lane of several trajectories separately by `newton` and `lanes`. Numbers with derivatives are
//! solved for their values, and then for each derivative. `convergence` has the constants that decide when an
//! iteration ends, here and in the schemes that iterate by themselves.

mod banded;
mod block;
#[cfg(test)]
mod closures;
mod convergence;
mod damped;
mod dense;
mod effort;
mod extrapolation;
mod factors_by_lane;
mod graph;
mod krylov;
mod lanes;
mod newton;
mod sparse;

pub use banded::Banded;
pub use block::{Block, Inputs};
pub(crate) use convergence::{
    CAREFUL_CONTRACTION, CONTRACTION, Contraction, DOUBTFUL, ROUNDING, SETTLED_STAGES, UNSEEN,
    UNSEEN_IN_STAGES, WILD,
};
pub use convergence::{nearly_over, relative_to};
pub(crate) use damped::{NewtonScratch, Problem, damped};
pub use dense::{Factor, SymmetricFactor, linear, prepared, reciprocal_above_one, usable};
pub(crate) use dense::{eliminate, substitute};
pub use effort::{Doubt, Effort};
pub use extrapolation::Extrapolation;
pub use factors_by_lane::FactorsByLane;
pub use graph::reverse_cuthill_mckee;
pub(crate) use krylov::power_of_two;
pub use krylov::{Krylov, Operator};
pub use newton::Equations;
pub(crate) use newton::astray;
pub use sparse::Sparse;
