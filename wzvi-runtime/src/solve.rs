//! The solvers of a step: dense factorisation and Newton's method, on arrays, without allocation.

mod damped;
mod dense;
mod newton;

pub use dense::{Factor, SymmetricFactor, prepared, quotient, reciprocal, reciprocal_above_one};
pub use newton::{Effort, Extrapolation, newton, newton_scalar, newton_symmetric};
