//! Thermostats: the steps, what they sample, and what they refuse.

#![allow(clippy::expect_used, clippy::panic, reason = "a test may stop")]

#[path = "starts/beside.rs"]
mod beside;
#[path = "bath/large.rs"]
mod large;
#[path = "bath/refusals.rs"]
mod refusals;
#[path = "bath/runs.rs"]
mod runs;
#[path = "bath/steps.rs"]
mod steps;
#[path = "bath/sweeps.rs"]
mod sweeps;
#[path = "bath/systems.rs"]
mod systems;
