//! The compiler from outside: what it accepts, what it says, what it emits, what a build holds, and the documents.
//!
//! Tests that call Cargo are ignored: `.ci/run` calls `ui`, `.ci/release` the others. `cargo test --workspace --test compiler -- --include-ignored` runs all.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test stops at the first error")]
#![allow(missing_docs, unreachable_pub, reason = "test systems")]

mod documents;
mod golden;
mod hygiene;
mod lean;
mod names;
mod rooms;
mod ui;

/// The folder of the workspace.
fn root() -> &'static std::path::Path {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap()
}
