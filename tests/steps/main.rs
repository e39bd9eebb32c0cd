//! Steps of small systems: what they are, how exact they are, what they keep, and how they fail.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test stops at the first error")]
#![allow(missing_docs, unreachable_pub, reason = "test systems")]

mod accuracy;
mod adjoint;
mod clock;
mod compensation;
mod composition;
mod conditions;
mod divisors;
mod errors;
mod gauss;
mod gradient;
mod invariants;
mod limits;
mod modified;
mod momentum;
mod names;
mod own;
mod plan;
mod quadrature;
#[allow(unused, clippy::all, clippy::pedantic, reason = "written by a program")]
mod random {
    include!(concat!(env!("OUT_DIR"), "/steps.rs"));
}
mod constants;
mod reference;
mod rest;
mod spins;
mod symplectic;
mod tangent;
mod units;
mod values;
