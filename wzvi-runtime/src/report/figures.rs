//! A measurement as figures and as a page.
//!
//! Tested by `tests/paths/report/page.rs`.

use std::path::Path;

use super::document::Document;
use super::fit::Slope;
use super::{Cell, Report, ReportError, duration, number, write_file};
use crate::plot::{Axis, Figure, Look, Series};
use crate::saving::file;

impl Report {
    /// Error against run time and error against step size, log-log, with the fitted slopes.
    pub fn figures(&self, id: &str) -> Vec<Figure> {
        vec![self.work_precision(id), self.convergence(id)]
    }

    fn work_precision(&self, id: &str) -> Figure {
        let (x, y) = (Axis::logarithmic("seconds per path"), Axis::logarithmic("strong error"));
        let mut figure =
            Figure::new(format!("{id}-time"), format!("{}: error against run time", self.title), x, y);
        figure.shows = "Further left and lower is better. Time is that of the steps and of the increments that drive them.".to_owned();
        for (colour, scheme) in self.schemes().into_iter().enumerate() {
            let timed: Vec<&Cell> = self.of(scheme).filter(|cell| cell.time.is_some()).collect();
            let points = timed.iter().filter_map(|cell| Some((cell.seconds()?, cell.strong.value)));
            let mut series = Series::new(scheme, Look::Joined, colour, points.collect());
            series.notes = timed.iter().map(|cell| note(cell)).collect();
            figure.series.push(series);
        }
        let mut names: Vec<&str> = vec![];
        for point in &self.overlay {
            if !names.contains(&point.name.as_str()) {
                names.push(&point.name);
            }
        }
        for (more, name) in names.into_iter().enumerate() {
            let points = self.overlay.iter().filter(|point| point.name == name);
            let points = points.map(|point| (point.seconds, point.error)).collect();
            let colour = self.schemes().len() + more;
            figure.series.push(Series::new(format!("{name} (elsewhere)"), Look::Marks, colour, points));
        }
        figure
    }

    fn convergence(&self, id: &str) -> Figure {
        let (x, y) = (Axis::logarithmic("step size h"), Axis::logarithmic("strong error"));
        let mut figure =
            Figure::new(format!("{id}-order"), format!("{}: error against step size", self.title), x, y);
        figure.shows =
            "Dashed: slopes by weighted least squares, over the part of a curve that is straight.".to_owned();
        for (colour, scheme) in self.schemes().into_iter().enumerate() {
            let points = self.of(scheme).map(|cell| (cell.h, cell.strong.value)).collect();
            let mut series = Series::new(scheme, Look::Marks, colour, points);
            series.notes = self.of(scheme).map(note).collect();
            figure.series.push(series);
        }
        for (colour, scheme) in self.schemes().into_iter().enumerate() {
            if let Slope::Order { order, factor, used, .. } = self.slope(scheme) {
                let points = used.iter().map(|h| (*h, factor * h.powf(order))).collect();
                let name = format!("slope {order:.2} ({scheme})");
                figure.series.push(Series::new(name, Look::Dashed, colour, points));
            }
        }
        figure
    }

    /// This measurement at the end of a page: figures, conclusions and table.
    #[must_use]
    pub fn append_to(&self, document: Document, id: &str) -> Document {
        let (headings, rows) = self.rows();
        let document = self.figures(id).into_iter().fold(document, Document::figure);
        document
            .list(self.conclusions())
            .table(format!("{}: measurements", self.title), headings, rows)
            .list(self.terms())
            .text(self.conditions())
    }

    /// Writes `measurements.csv`, `measurements.json`, plots as SVG and PNG with their numbers as CSV, and
    /// `index.html` into a folder, which is made if it is not there.
    ///
    /// # Errors
    /// [`ReportError::File`] with the path that could not be written. A file is there complete or not at all.
    pub fn write(&self, folder: impl AsRef<Path>) -> Result<(), ReportError> {
        let folder = folder.as_ref();
        file::create_folder(folder)?;
        write_file(&folder.join("measurements.csv"), &self.csv())?;
        write_file(&folder.join("measurements.json"), self.json()?.as_bytes())?;
        self.append_to(Document::new(self.title.clone()), "error").write(folder)
    }
}

/// A note on a measurement, besides its error and time.
fn note(cell: &Cell) -> String {
    let mut note =
        format!("h = {}, ± {:.0e}, {} paths", number(cell.h), cell.strong.standard_error, cell.paths);
    if let Some(time) = cell.time {
        note += &format!(", steps {}", duration(time.median));
    }
    if let Some(noise) = cell.noise_time {
        note += &format!(", noise {}", duration(noise.median));
    }
    if cell.failures > 0 {
        note += &format!(", {} failed", cell.failures);
    }
    note
}
