//! The base of all other modules: numbers as words, digits, clocks, names.

pub(crate) mod checksum;
pub(crate) mod clock;
pub(crate) mod digits;
pub(crate) mod due;
pub mod handle;
#[cfg(all(feature = "interrupt", not(target_family = "wasm")))]
mod interrupt;
#[cfg(feature = "serde")]
pub(crate) mod loose;
pub(crate) mod names;
pub mod numbers;
pub(crate) mod progress;
pub mod variables;
