//! From Hamiltonians to discrete Euler-Lagrange equations: mathematics only, no tokens.

pub(crate) mod embedding;
