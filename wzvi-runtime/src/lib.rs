//! Runtime of `wzvi`. Users depend on the facade crate `wzvi`; see there for the tour.

#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod bath;
mod between;
pub mod calculus;
pub mod carry;
mod checksum;
mod clock;
pub mod compose;
mod continuation;
pub mod dense;
mod digits;
mod due;
pub mod elements;
pub mod embedding;
#[cfg(feature = "ensemble")]
pub mod ensemble;
pub mod error;
#[cfg(feature = "ensemble")]
mod execution;
mod few;
pub mod gauss;
pub mod increments;
pub mod integrate;
#[cfg(all(feature = "interrupt", not(target_family = "wasm")))]
mod interrupt;
#[cfg(any(not(feature = "interrupt"), target_family = "wasm"))]
#[path = "interrupt/absent.rs"]
mod interrupt;
pub mod lanes;
pub mod memory;
pub mod modified;
#[cfg(any(feature = "ensemble", feature = "serde"))]
mod names;
#[cfg(feature = "noise")]
pub mod noise;
pub mod numbers;
mod options;
mod persist;
pub mod plan;
#[cfg(feature = "plot")]
pub mod plot;
mod progress;
mod recording;
#[cfg(feature = "report")]
pub mod report;
pub mod retry;
pub mod scalar;
#[cfg(feature = "ensemble")]
mod schedule;
pub mod section;
pub mod series;
pub mod simulate;
pub mod solve;
mod span;
pub mod state;
pub mod step;
mod steps;
mod sum;
pub mod system;
mod threads;
pub mod trajectory;
pub mod variables;
mod watch;

#[doc(hidden)]
pub use core;

#[cfg(feature = "mpi")]
pub use mpi;
pub use nalgebra;
#[cfg(feature = "serde")]
pub use persist::checkpoint;
#[cfg(not(feature = "serde"))]
use persist::checkpoint;
pub use persist::table;
