//! What the macro accepts: these compile, run, and mean what Rust means.
//!
//! Not among the tests of `cargo test --workspace`: `.ci/run` calls `cargo test --workspace --test accepted`.

#![allow(clippy::all, clippy::unwrap_used, clippy::panic, reason = "programs as users may write them")]
#![allow(missing_docs, unreachable_pub, reason = "test systems")]

mod attributes;
mod clock;
mod constants_only;
mod embeddings;
mod fields;
mod functions;
mod macros;
mod parameters;
mod phase_spaces;
mod remedies;
