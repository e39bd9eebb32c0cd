//! Errors of series of values.

use crate::error::messages;

/// Why a series has no estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SeriesError {
    /// It is too short for its own correlations.
    Short {
        /// Number of values.
        length: usize,
    },
    /// All values are the same.
    Constant,
    /// A value is NaN or infinite.
    NonFinite {
        /// Its index, from 0.
        index: usize,
    },
    /// A lag that the series does not have.
    Lag {
        /// As it was requested, in time units.
        lag: f64,
        /// The longest.
        longest: f64,
    },
    /// Series that belong together have different lengths.
    Lengths {
        /// Length of the first series.
        expected: usize,
        /// Length of another one.
        got: usize,
    },
}

messages! { SeriesError:
    Self::Short { length } =>
        "the correlations of {length} values do not end within a tenth of the series; run longer";
    Self::Constant => "all values are the same: there is nothing to correlate";
    Self::NonFinite { index } => "value {index} (from 0) is NaN or infinite";
    Self::Lag { lag, longest } =>
        "no correlation at a lag of {lag}: it goes from 0 to {longest}, the length of the series in time units";
    Self::Lengths { expected, got } =>
        "the series have {expected} and {got} values; they must have the same length";
}
