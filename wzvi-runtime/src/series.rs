//! Averages along one long path, whose neighbouring values are no independent ones.
//!
//! With the autocorrelation `ρ(t)` of a stationary series, `τ = 1/2 + Σ_{t ≥ 1} ρ(t)` is its integrated autocorrelation time, in samples, and the mean of `N`
//! values has the variance `2 τ σ² / N`: as of `N / 2τ` independent ones.
//!
//! Two estimates: by [batch means](BatchMeans) of every size, which take a few numbers of memory and end runs that are exact enough
//! ([`TimeAveraging::until_error`]), and, with the feature `correlation`, by the autocorrelation function itself
//! (`Autocorrelation`), which also says how long things take. Several paths from different starts show what one path cannot know:
//! [`Chains`] compares their means.

mod averages;
mod batches;
mod chains;
#[cfg(feature = "correlation")]
mod correlation;
mod student;
mod tally;
mod temperature;
#[cfg(feature = "correlation")]
mod transform;

use std::fmt;

pub use averages::{TimeAverage, TimeAverages, TimeAveraging};
pub use batches::BatchMeans;
pub use chains::Chains;
#[cfg(feature = "correlation")]
pub use correlation::{Autocorrelation, ByLag};
pub(crate) use tally::{Observed, Tally};
pub use temperature::{Equipartition, Share};
pub(crate) use temperature::{configurational, configurational_of, kinetic, kinetic_of};

/// Why a series has no estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SeriesError {
    /// It is too short for its own correlations.
    Short {
        /// Values that there are.
        length: usize,
    },
    /// All values are the same.
    Constant,
    /// A value is NaN or infinite.
    NonFinite {
        /// Which one, from 0.
        index: usize,
    },
    /// Series that belong together have different lengths.
    Lengths {
        /// Of the first.
        expected: usize,
        /// Of another.
        got: usize,
    },
}

impl fmt::Display for SeriesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Short { length } => write!(
                f,
                "{length} values are too few for how long they are correlated; run longer, or record less often"
            ),
            Self::Constant => write!(f, "all values are the same: there is nothing to correlate"),
            Self::NonFinite { index } => write!(f, "value {index} (from 0) is NaN or infinite"),
            Self::Lengths { expected, got } => {
                write!(f, "series of {expected} and of {got} values: they must have the same length")
            }
        }
    }
}

impl std::error::Error for SeriesError {}
