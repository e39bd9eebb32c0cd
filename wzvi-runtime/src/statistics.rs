//! What is known of many paths: moments, histograms, quantiles, crossings, first passages, and their tables.

mod crossings;
mod histogram;
mod loss;
mod moments;
mod origin;
mod passage;
mod paths;
mod quantiles;
mod run;
mod table;

pub use crossings::{Crossings, PathCrossing};
pub use histogram::Histogram;
pub use loss::LossError;
pub(crate) use moments::Welford;
pub(crate) use origin::Origin;
pub use passage::{Passage, Passages};
pub(crate) use passage::{Watch, crossing};
pub use paths::Paths;
pub use quantiles::Quantiles;
pub use run::{PathFailure, Statistics, StatisticsNode, TargetStatus};
pub(crate) use run::{PathTally, Wanted};
