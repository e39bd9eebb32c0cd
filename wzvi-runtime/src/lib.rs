//! Runtime of `wzvi`. Users depend on the facade crate `wzvi`; see there for the tour.

pub mod calculus;
pub mod carry;
#[cfg(feature = "serde")]
pub mod checkpoint;
#[cfg(not(feature = "serde"))]
#[path = "checkpoint/absent.rs"]
mod checkpoint;
mod checksum;
#[cfg(feature = "ensemble")]
mod clock;
pub mod elements;
pub mod embedding;
#[cfg(feature = "ensemble")]
pub mod ensemble;
pub mod error;
pub mod increments;
pub mod integrate;
#[cfg(all(feature = "interrupt", any(feature = "ensemble", feature = "report")))]
mod interrupt;
#[cfg(all(feature = "ensemble", not(feature = "interrupt")))]
#[path = "interrupt/absent.rs"]
mod interrupt;
#[cfg(feature = "ensemble")]
pub mod lanes;
#[cfg(any(feature = "ensemble", feature = "serde", feature = "report"))]
mod names;
#[cfg(feature = "noise")]
pub mod noise;
pub mod numbers;
#[cfg(any(feature = "ensemble", feature = "serde", feature = "report"))]
mod persist;
pub mod plan;
#[cfg(feature = "report")]
pub mod report;
mod rescue;
pub mod retry;
pub mod scalar;
pub mod simulate;
pub mod solve;
pub mod state;
pub mod step;
mod sum;
pub mod system;
pub mod trajectory;

#[cfg(feature = "mpi")]
pub use mpi;
pub use nalgebra;
