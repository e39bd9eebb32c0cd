//! Runtime of `wzvi`. Users depend on the facade crate `wzvi`; see there for the tour.

pub mod embedding;
pub mod error;
#[cfg(feature = "noise")]
pub mod noise;
pub mod plan;
pub mod scalar;
pub mod solve;
pub mod state;
pub mod step;
pub mod system;
