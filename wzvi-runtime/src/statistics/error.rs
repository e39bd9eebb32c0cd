//! Errors of questions to an ensemble.

use crate::error::{UnknownName, messages};

/// A question that the statistics of an ensemble cannot answer.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum StatisticsError {
    /// Nothing has this name.
    Unknown(UnknownName),
    /// The run did not compute it.
    NotComputed {
        /// The request.
        what: &'static str,
        /// The method that the run needs for it.
        remedy: &'static str,
    },
    /// There is no quantile of this fraction.
    Fraction(f64),
}

messages! { StatisticsError:
    Self::Unknown(error) => "{error}";
    Self::NotComputed { what, remedy } => "the run has no {what}: add `{remedy}` to it";
    Self::Fraction(fraction) => "no quantile of the fraction {fraction}: take a fraction from 0 to 1, such as 0.5 for the median";
}
