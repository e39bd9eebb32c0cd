//! The kinds of numbers a step is computed in, states of them, and the solvers of equations in them.

pub mod carry;
pub mod crossing;
pub(crate) mod few;
pub mod lanes;
pub mod memory;
pub mod scalar;
pub mod shape;
pub mod solve;
pub mod stages;
pub mod state;
pub(crate) mod student;
pub(crate) mod sum;
pub(crate) mod threads;
pub(crate) mod welford;
