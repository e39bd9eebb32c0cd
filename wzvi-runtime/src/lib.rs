//! Runtime of `wzvi`. Users depend on the facade crate `wzvi`; see there for the tour.
//!
//! Each room imports only those above it:
//!
//! | room | what is in it |
//! |---|---|
//! | `ground` | numbers as words, digits, clocks, names |
//! | `error` | why a step, a run, a file or a question failed |
//! | `algebra` | the kinds of numbers, states, sums, and the solvers of equations in them |
//! | `scheme` | what takes a step |
//! | `increments`, `noise` | what drives it |
//! | `saving` | files and tables |
//! | `statistics` | what is known of many paths |
//! | `path` | one path: steps, records, sections, checkpoints |
//! | `ensemble` | many paths |
//! | `plot`, `report` | what is shown of them |
//! | `integrate` | where a run begins |

#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod algebra;
#[cfg(feature = "ensemble")]
pub mod ensemble;
pub mod error;
pub mod ground;
pub mod increments;
pub mod integrate;
#[cfg(feature = "noise")]
pub mod noise;
pub mod path;
#[cfg(feature = "plot")]
pub mod plot;
#[cfg(feature = "report")]
pub mod report;
pub mod saving;
pub mod scheme;
#[cfg(feature = "ensemble")]
pub mod statistics;

#[doc(hidden)]
pub use core;

#[cfg(feature = "mpi")]
pub use mpi;
pub use nalgebra;
