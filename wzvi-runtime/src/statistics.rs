//! Statistics of many paths: moments, histograms, quantiles, crossings, first passages, and their tables.
//! Each is a [`Statistic`].

mod crossings;
mod error;
mod histogram;
mod loss;
mod moments;
mod origin;
mod passage;
mod paths;
mod quantiles;
mod run;
mod statistic;
mod table;

pub use crossings::{Crossings, PathCrossing};
pub use error::StatisticsError;
pub use histogram::Histogram;
pub use loss::{LossError, PathFailure};
pub(crate) use origin::Origin;
pub use passage::{Passage, Passages};
pub use paths::Paths;
pub use quantiles::Quantiles;
pub(crate) use run::Nodes;
pub use run::{Statistics, StatisticsNode, TargetStatus};
pub(crate) use statistic::AnyStatistic;
pub use statistic::{Seen, Statistic, Tables};
