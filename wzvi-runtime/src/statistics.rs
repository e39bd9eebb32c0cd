//! Statistics of many paths: moments, histograms, quantiles, crossings, first passages, and their tables.
//! Each is a [`Statistic`].

mod crossings;
mod error;
mod histogram;
mod loss;
mod moments;
mod passage;
mod paths;
mod provenance;
mod quantiles;
mod results;
mod statistic;
mod table;

pub use crossings::{Crossings, PathCrossing};
pub use error::StatisticsError;
pub use histogram::Histogram;
pub use loss::{LossError, PathFailure};
pub use passage::{Passage, Passages};
pub use paths::PathValues;
pub(crate) use provenance::Provenance;
pub use quantiles::Quantiles;
pub(crate) use results::RecordedNodes;
pub use results::{Statistics, StatisticsNode, TargetStatus};
pub(crate) use statistic::AnyStatistic;
pub use statistic::{Seen, Statistic, Tables};
