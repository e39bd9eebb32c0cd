//! What can go wrong with a report.

use std::fmt;
use std::path::PathBuf;

use super::{FileError, PlotError};

/// A measurement that could not be made, read or written.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ReportError {
    /// A file or folder could not be read or written.
    File(FileError),
    /// A file of points measured elsewhere has a line that is not `name,seconds,error`.
    Overlay {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// What is wrong with it.
        cause: String,
    },
    /// A plot could not be drawn.
    Plot(PlotError),
    /// The numbers could not be put into a format.
    Format(String),
}

impl fmt::Display for ReportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(error) => error.fmt(f),
            Self::Overlay { path, line, cause } => {
                write!(f, "{}, line {line}: {cause}; a line is name,seconds,error", path.display())
            }
            Self::Plot(error) => error.fmt(f),
            Self::Format(cause) => write!(f, "cannot write the numbers down: {cause}"),
        }
    }
}

impl std::error::Error for ReportError {}

impl From<FileError> for ReportError {
    fn from(error: FileError) -> Self {
        Self::File(error)
    }
}

impl From<PlotError> for ReportError {
    fn from(error: PlotError) -> Self {
        Self::Plot(error)
    }
}
