//! There is no seam between steps that are emitted as straight-line code and steps that are emitted in loops, nor between
//! the spellings of a size: what a system is, and what a step of it gives, depends on neither.

#![allow(clippy::unwrap_used, reason = "a test that unwraps says what it expects")]

#[macro_use]
#[path = "seam/closures.rs"]
mod closures;
#[path = "seam/sizes.rs"]
mod sizes;
#[path = "seam/values.rs"]
mod values;
