//! Symbolic discrete-embedding compiler for (stochastic) Hamiltonian systems.

pub use wzvi_runtime::{embedding, error, plan, scalar, state, step, system};
