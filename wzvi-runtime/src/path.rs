//! One path: its steps, what is recorded of it, and how it goes on after it was stopped.

pub(crate) mod between;
pub mod checkpoint;
mod error;
pub(crate) mod options;
pub(crate) mod recording;
pub mod retry;
pub mod section;
pub mod series;
pub mod simulate;
pub(crate) mod span;
pub mod step;
pub(crate) mod steps;
pub mod trajectory;
pub(crate) mod watch;

pub use error::Error;
