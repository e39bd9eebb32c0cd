//! Between the nodes: dense output, recorded times, ends and sections.

#![allow(clippy::unwrap_used, reason = "a test may stop")]

#[path = "between/dense.rs"]
mod dense;
