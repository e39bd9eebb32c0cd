//! Ensembles: the same bits however they are split, what they find out, how they end, and checkpoints.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test stops at the first error")]
#![allow(missing_docs, unreachable_pub, reason = "test systems")]

mod alone;
mod chaos;
mod checkpoint;
mod continued;
mod control;
mod failing;
mod large_tables;
mod poles;
mod rare;
mod runs;
mod settings;
mod starts;
mod statistics;
