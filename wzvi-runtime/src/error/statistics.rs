//! What can be wrong with a question to an ensemble.

use std::fmt;

use super::UnknownName;

/// A question that the statistics of an ensemble cannot answer.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StatisticsError {
    /// Nothing has this name.
    Unknown(UnknownName),
    /// The run was not asked to find it out.
    NotComputed {
        /// What was asked for.
        what: &'static str,
        /// What the run needs for it.
        remedy: &'static str,
    },
}

impl fmt::Display for StatisticsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(error) => error.fmt(f),
            Self::NotComputed { what, remedy } => write!(f, "the run has no {what}: add `{remedy}` to it"),
        }
    }
}

impl std::error::Error for StatisticsError {}
