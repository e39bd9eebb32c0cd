//! The solvers of a step: dense factorisation and Newton's method, on arrays, without allocation.

mod banded;
mod damped;
mod dense;
mod krylov;
mod newton;

pub use banded::{Banded, reverse_cuthill_mckee};
pub use dense::{Factor, SymmetricFactor, prepared, quotient, reciprocal, reciprocal_above_one};
pub use krylov::Krylov;
pub use newton::{Effort, Extrapolation, newton, newton_scalar, newton_symmetric};
pub(crate) use newton::{Progress, STAGNATION, Verdict, astray};
