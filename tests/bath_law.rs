//! Thermostats: what they sample.

#![allow(clippy::expect_used, reason = "a test may stop")]

#[path = "bath/law.rs"]
mod law;
#[allow(dead_code, reason = "some are for steps alone")]
#[path = "bath/systems.rs"]
mod systems;
