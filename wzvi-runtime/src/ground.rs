//! What everything stands on: numbers as words, digits, clocks, names.

pub mod calculus;
pub(crate) mod checksum;
pub(crate) mod clock;
pub(crate) mod digits;
pub(crate) mod due;
#[cfg(all(feature = "interrupt", not(target_family = "wasm")))]
pub(crate) mod interrupt;
#[cfg(any(not(feature = "interrupt"), target_family = "wasm"))]
#[path = "ground/interrupt/absent.rs"]
pub(crate) mod interrupt;
pub(crate) mod names;
pub mod numbers;
pub(crate) mod progress;
pub mod variables;
