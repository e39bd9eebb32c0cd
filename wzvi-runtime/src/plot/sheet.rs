//! Several figures in one file.
//!
//! Tested by `tests/paths/results.rs`.

use std::io::Write;
use std::path::Path;

#[cfg(feature = "plot")]
use super::drawing::drawn_png;
use super::drawing::{Plot, drawn_svg};
use super::figure::Figure;
use super::layout::Layout;
use crate::saving::file;
use crate::trajectory::error::PlotError;

/// Pixels of the file for one unit of the layout.
const SCALE: i32 = 2;

/// Figures side by side and below each other, each with its title and legend above its axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    columns: usize,
    /// Width and height of each figure, in pixels of the file.
    size: (u32, u32),
    figures: Vec<Figure>,
}

impl Sheet {
    /// An empty sheet with this many figures in a row, each of this width and height in pixels.
    pub fn new(columns: usize, size: (u32, u32)) -> Self {
        Self { columns: columns.max(1), size, figures: Vec::new() }
    }

    /// Adds a figure.
    #[must_use]
    pub fn with(mut self, figure: Figure) -> Self {
        self.figures.push(figure);
        self
    }

    /// The sheet as the text of an SVG file.
    ///
    /// # Errors
    /// [`PlotError::Drawing`].
    pub fn svg(&self) -> Result<String, PlotError> {
        drawn_svg(self.whole(), &self.plots())
    }

    /// The sheet as the content of a PNG file (feature `plot`).
    ///
    /// # Errors
    /// [`PlotError::Drawing`].
    #[cfg(feature = "plot")]
    pub fn png(&self) -> Result<Vec<u8>, PlotError> {
        drawn_png(self.whole(), &self.plots())
    }

    /// Writes the sheet as SVG or PNG, by the end of the name; PNG needs the feature `plot`. The folder of
    /// the file is made if it is not there, and the file appears complete or not at all.
    ///
    /// # Errors
    /// [`PlotError`]: another ending, PNG without its feature, or the file cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), PlotError> {
        let path = path.as_ref();
        let content = match path.extension().and_then(|ending| ending.to_str()) {
            Some("svg") => self.svg()?.into_bytes(),
            #[cfg(feature = "plot")]
            Some("png") => self.png()?,
            #[cfg(not(feature = "plot"))]
            Some("png") => return Err(PlotError::Pixels { path: path.to_owned() }),
            _ => return Err(PlotError::Ending { path: path.to_owned() }),
        };
        Ok(file::replace_in_folder(path, |file| file.write_all(&content))?)
    }

    fn whole(&self) -> (u32, u32) {
        let rows = self.figures.len().div_ceil(self.columns).max(1);
        (self.size.0 * self.columns as u32, self.size.1 * rows as u32)
    }

    /// The figures with the places of their corners.
    fn plots(&self) -> Vec<((i32, i32), Plot<'_>)> {
        let (width, height) = (self.size.0 as i32, self.size.1 as i32);
        let place =
            |number: usize| ((number % self.columns) as i32 * width, (number / self.columns) as i32 * height);
        let plot = |figure| Plot::new(figure, Layout::titled(figure, (width / SCALE, height / SCALE)), SCALE);
        self.figures.iter().enumerate().map(|(number, figure)| (place(number), plot(figure))).collect()
    }
}

impl Figure {
    /// Writes the figure, with its title and legend, as SVG or PNG: [`Sheet::write`] of one figure of 1280 by
    /// 880 pixels, or 1280 by 1280 where the axes are equal.
    ///
    /// # Errors
    /// The errors of [`Sheet::write`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), PlotError> {
        let height = if self.has_equal_axes { 1280 } else { 880 };
        Sheet::new(1, (1280, height)).with(self.clone()).write(path)
    }
}
