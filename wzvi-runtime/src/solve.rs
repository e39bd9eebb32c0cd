//! The solvers of a step: dense factorisation and Newton's method, on arrays, without allocation.

mod banded;
mod dense;
mod newton;

pub use banded::Banded;
pub use dense::{Factor, SymmetricFactor, prepared, quotient, reciprocal, reciprocal_above_one};
pub use newton::{Extrapolation, newton, newton_scalar, newton_symmetric};
