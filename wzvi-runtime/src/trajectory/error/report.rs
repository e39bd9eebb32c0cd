//! Errors of reports.

use std::path::PathBuf;

use super::PlotError;
use crate::error::messages;
use crate::saving::FileError;

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
        /// The mistake in this line.
        cause: String,
    },
    /// A plot could not be drawn.
    Plot(PlotError),
    /// The numbers could not be put into a format.
    Format(String),
}

messages! { ReportError:
    Self::File(error) => "{error}";
    Self::Overlay { path, line, cause } =>
        "{}, line {line}: {cause}; a line is name,seconds,error", path.display();
    Self::Plot(error) => "{error}";
    Self::Format(cause) => "cannot format the numbers: {cause}";
}

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
