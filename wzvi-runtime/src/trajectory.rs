//! One path: its steps, its recorded nodes, and how it resumes after a stop.

pub(crate) mod between;
pub mod chaos;
pub mod checkpoint;
pub mod error;
pub mod events;
pub(crate) mod exclusive_setting;
pub(crate) mod following;
pub(crate) mod made_settings;
pub(crate) mod options;
pub mod recorded;
pub(crate) mod recording;
pub mod retry;
pub mod section;
pub mod series;
pub mod simulate;
pub(crate) mod span;
pub mod step;
pub(crate) mod steps;
pub(crate) mod watch;

pub use error::Error;
