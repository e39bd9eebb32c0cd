//! What can be wrong with a series of values.

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
        "{length} values are too few for their correlation time; run longer, or record less often";
    Self::Constant => "all values are the same: there is nothing to correlate";
    Self::NonFinite { index } => "value {index} (from 0) is NaN or infinite";
    Self::Lengths { expected, got } =>
        "the series have {expected} and {got} values; they must have the same length";
}
