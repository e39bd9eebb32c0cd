//! The kinds of numbers a step is computed in, states of them, and the solvers of equations in them.

pub(crate) mod compensated;
pub mod crossing;
pub mod lanes;
pub mod memory;
pub mod scalar;
pub mod shape;
pub(crate) mod short_list;
pub mod solve;
pub mod stages;
pub mod state;
pub mod state_sum;
pub(crate) mod student;
pub(crate) mod threads;
pub(crate) mod welford;
