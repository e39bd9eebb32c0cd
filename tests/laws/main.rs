//! Laws of many paths, orders of convergence, long runs and large stiff systems: minutes without optimisation, moments with it.
//!
//! `cargo test --workspace --release --test laws` runs them; other builds say that they are skipped, and Clippy reads them.
//!
//! The feature `short` leaves out what takes longest, for `.ci/run`: baths, branches, statistics of series, heat fluxes, rare events, several levels, and long runs.
//!
//! Ensembles ask for eight lanes: code for the lanes of every machine takes a seventh longer to compile, and has the same results.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test stops at the first error")]
#![allow(missing_docs, unreachable_pub, reason = "test systems")]

#[cfg(all(any(clippy, not(debug_assertions)), not(feature = "short")))]
mod bath;
#[cfg(all(any(clippy, not(debug_assertions)), not(feature = "short")))]
mod branches;
#[cfg(all(any(clippy, not(debug_assertions)), not(feature = "short")))]
mod brouwer;
#[cfg(all(any(clippy, not(debug_assertions)), not(feature = "short")))]
mod chaos_errors;
#[cfg(all(any(clippy, not(debug_assertions)), not(feature = "short")))]
mod clock;
#[cfg(all(any(clippy, not(debug_assertions)), not(feature = "short")))]
mod constraints;
#[cfg(any(clippy, not(debug_assertions)))]
mod convergence;
#[cfg(all(any(clippy, not(debug_assertions)), not(feature = "short")))]
mod heat_flux;
#[cfg(all(any(clippy, not(debug_assertions)), not(feature = "short")))]
mod long_runs;
#[cfg(all(any(clippy, not(debug_assertions)), not(feature = "short")))]
mod multilevel;
#[cfg(any(clippy, not(debug_assertions)))]
mod noise;
#[cfg(all(any(clippy, not(debug_assertions)), not(feature = "short")))]
mod orbits;
#[cfg(all(any(clippy, not(debug_assertions)), not(feature = "short")))]
mod rare;
#[cfg(all(any(clippy, not(debug_assertions)), not(feature = "short")))]
mod rigid_bodies;
#[cfg(all(any(clippy, not(debug_assertions)), not(feature = "short")))]
mod series_errors;
#[cfg(all(any(clippy, not(debug_assertions)), not(feature = "short")))]
mod spins;
#[cfg(any(clippy, not(debug_assertions)))]
mod stiff;
#[cfg(all(any(clippy, not(debug_assertions)), not(feature = "short")))]
mod thermostats;

#[cfg(debug_assertions)]
#[test]
#[ignore = "long without optimisation: cargo test --workspace --release --test laws"]
fn laws() {}
