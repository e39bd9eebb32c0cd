//! Between the nodes: dense output, recorded times, ends and sections.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop")]

#[path = "between/dense.rs"]
mod dense;
#[path = "between/ensembles.rs"]
mod ensembles;
#[path = "between/kept.rs"]
mod kept;
#[path = "between/sections.rs"]
mod sections;
#[path = "between/systems.rs"]
mod systems;
#[path = "between/times.rs"]
mod times;
