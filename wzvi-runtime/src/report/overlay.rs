//! Points measured elsewhere.
//!
//! Tested by `tests/paths/report/files.rs`.

use std::path::Path;

use serde::Serialize;

use super::ReportError;
use crate::saving::FileError;

/// A point that another program measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Overlay {
    /// The program.
    pub name: String,
    /// Seconds for one path.
    pub seconds: f64,
    /// Its error.
    pub error: f64,
}

impl Overlay {
    /// Reads lines `name,seconds,error`; a first line whose numbers are words is a heading, `#` begins a
    /// comment.
    ///
    /// # Errors
    /// [`ReportError::File`], [`ReportError::Overlay`].
    pub fn read(path: &Path) -> Result<Vec<Self>, ReportError> {
        let failed = |error: csv::Error| ReportError::File(FileError::system(path, "read")(error.into()));
        let mut builder = csv::ReaderBuilder::new();
        builder.has_headers(false).flexible(true).trim(csv::Trim::All).comment(Some(b'#'));
        let mut reader = builder.from_path(path).map_err(failed)?;
        let mut points = vec![];
        for (index, record) in reader.records().enumerate() {
            let record = record.map_err(failed)?;
            let line = record.position().map_or(index as u64 + 1, csv::Position::line);
            let bad = |cause: String| ReportError::Overlay { path: path.to_owned(), line, cause };
            let [name, seconds, error] = [0, 1, 2].map(|field| record.get(field).unwrap_or(""));
            if record.len() != 3 {
                return Err(bad(format!("{} fields", record.len())));
            }
            if index == 0 && seconds.parse::<f64>().is_err() && error.parse::<f64>().is_err() {
                continue;
            }
            let positive = |text: &str| match text.parse::<f64>() {
                Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
                _ => Err(bad(format!("`{text}` is not a positive number"))),
            };
            points.push(Self { name: name.to_owned(), seconds: positive(seconds)?, error: positive(error)? });
        }
        Ok(points)
    }
}
