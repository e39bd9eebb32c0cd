//! The run time alone: numbers in lanes, and noise.

#![allow(clippy::unwrap_used, reason = "a test stops at the first error")]
#![allow(
    clippy::disallowed_methods,
    reason = "laws and errors are measured with the functions of the platform"
)]

#[cfg(feature = "ensemble")]
mod ensemble_law;
#[cfg(feature = "ensemble")]
mod lanes;
#[cfg(feature = "ensemble")]
mod lanes_accuracy;
#[cfg(feature = "ensemble")]
mod law;
#[cfg(feature = "noise")]
mod noise_path;
#[cfg(feature = "noise")]
mod noise_wong_zakai;
#[path = "../../../wzvi-macros/src/symbolic/tests/real.rs"]
#[allow(unreachable_pub, reason = "another crate shares it")]
mod real;
mod special;
