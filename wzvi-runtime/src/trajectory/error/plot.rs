//! Errors of plots.

use std::path::PathBuf;

use crate::error::messages;
use crate::saving::FileError;

/// A plot that could not be drawn or written.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum PlotError {
    /// Its file could not be written.
    File(FileError),
    /// It could not be drawn.
    Drawing {
        /// The name of the figure.
        figure: String,
        /// The message of the backend.
        cause: String,
    },
    /// Its file is a PNG file, which the feature `plot` draws, and this build has the feature `svg` alone.
    Pixels {
        /// The file.
        path: PathBuf,
    },
    /// The limits of an axis are no range: the second is not above the first, one is NaN or infinite, or not
    /// positive on a logarithmic axis.
    Range {
        /// The name of the figure.
        figure: String,
        /// `x` or `y`.
        axis: char,
        /// The limits.
        from: f64,
        /// The limits.
        to: f64,
    },
    /// The name of its file ends neither in `.svg` nor in `.png`.
    Ending {
        /// The file.
        path: PathBuf,
    },
}

messages! { PlotError:
    Self::File(error) => "{error}";
    Self::Drawing { figure, cause } => "cannot draw the figure `{figure}`: {cause}";
    Self::Pixels { path } => "cannot draw {}: PNG needs the feature `plot` of wzvi; with `svg` alone the name of a plot ends in .svg",
        path.display();
    Self::Range { figure, axis, from, to } =>
        "cannot draw the figure `{figure}`: `{axis}_range({from}..{to})` is no range; it runs from a smaller number to a larger one, both \
         finite, and both positive on a logarithmic axis";
    Self::Ending { path } => "cannot draw {}: the name of a plot ends in .svg or .png", path.display();
}

impl From<FileError> for PlotError {
    fn from(error: FileError) -> Self {
        Self::File(error)
    }
}
