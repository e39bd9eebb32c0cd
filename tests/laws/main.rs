//! Laws of many paths, orders of convergence and large stiff systems: minutes without optimisation, moments with it.
//!
//! `cargo test --release --test laws` runs them; other builds compile them and say that they are skipped.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test stops at the first error")]
#![allow(missing_docs, unreachable_pub, reason = "test systems")]

mod bath;
mod branches;
mod brouwer;
mod convergence;
mod multilevel;
mod series_errors;
mod stiff;
