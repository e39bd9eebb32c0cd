//! Runtime of `wzvi`. Users depend on the facade crate `wzvi`; see there for the tour.
//!
//! Each module imports only modules above it:
//!
//! | module | contents |
//! |---|---|
//! | `ground` | numbers as words, digits, clocks, names |
//! | `error` | errors of steps, settings and increments |
//! | `algebra` | the kinds of numbers, states, sums, and the solvers of equations in them |
//! | `scheme` | schemes and their steps |
//! | `increments`, `noise` | Wiener paths and other sources of increments |
//! | `saving` | files and tables |
//! | `statistics` | statistics of many paths |
//! | `calculus` | derivatives and integrals on time scales |
//! | `trajectory` | one path: steps, records, sections, checkpoints |
//! | `ensemble` | many paths |
//! | `plot`, `report` | figures and pages |
//! | `integrate` | the entry points of runs |
//! | `exported` | systems for programs in other languages |

#![cfg_attr(docsrs, feature(doc_cfg))]
#![cfg_attr(
    test,
    allow(clippy::disallowed_methods, reason = "tests compare with the functions of the platform")
)]
#![cfg_attr(
    not(all(feature = "ensemble", feature = "report")),
    allow(
        dead_code,
        unused_imports,
        reason = "what features that are off have in common is compiled with all of them"
    )
)]

pub mod algebra;
pub mod calculus;
#[cfg(feature = "ensemble")]
pub mod ensemble;
pub mod error;
pub mod exported;
pub mod ground;
pub mod increments;
pub mod integrate;
#[cfg(feature = "noise")]
pub mod noise;
#[cfg(feature = "svg")]
#[allow(clippy::disallowed_methods, reason = "figures are of no bits")]
pub mod plot;
#[cfg(feature = "report")]
#[allow(clippy::disallowed_methods, reason = "reports are of no bits")]
pub mod report;
pub mod saving;
pub mod scheme;
#[cfg(feature = "ensemble")]
pub mod statistics;
pub mod trajectory;

#[doc(hidden)]
pub use core;

#[cfg(feature = "mpi")]
pub use mpi;
pub use nalgebra;
