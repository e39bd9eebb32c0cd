//! Runs of one path: output between the nodes, hard steps, averages, results, checkpoints, reports.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test stops at the first error")]
#![allow(missing_docs, unreachable_pub, reason = "test systems")]

mod between;
mod chaos;
mod checkpoint;
mod clock;
mod events;
mod export;
mod high_order;
mod jumps;
mod observables;
mod orbits;
mod refused;
mod report;
mod results;
mod runs;
mod series;
mod stability;
