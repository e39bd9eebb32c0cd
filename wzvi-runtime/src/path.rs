//! One path: its steps, its recorded nodes, and how it resumes after a stop.

pub(crate) mod between;
pub mod chaos;
pub mod checkpoint;
pub(crate) mod choice;
pub mod error;
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
