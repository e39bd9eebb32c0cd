//! A measurement as CSV and JSON.

use super::{Report, ReportError};

/// Rows as CSV.
pub(crate) fn csv_text<R>(rows: impl IntoIterator<Item = R>) -> Result<Vec<u8>, ReportError>
where
    R: IntoIterator,
    R::Item: AsRef<[u8]>,
{
    let failed = |error: &dyn std::fmt::Display| ReportError::Format(error.to_string());
    let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(vec![]);
    for row in rows {
        writer.write_record(row).map_err(|error| failed(&error))?;
    }
    writer.into_inner().map_err(|error| failed(&error))
}

impl Report {
    /// One line for each scheme and step size, every number in full.
    ///
    /// # Errors
    /// [`ReportError::Format`].
    pub fn csv(&self) -> Result<Vec<u8>, ReportError> {
        let mut headings: Vec<String> = [
            "scheme",
            "h",
            "steps",
            "paths",
            "failures",
            "strong_error",
            "strong_standard_error",
            "energy_trend",
            "energy_oscillation",
            "newton_per_step",
            "newton_largest",
            "step_seconds_median",
            "step_seconds_q1",
            "step_seconds_q3",
            "noise_seconds_median",
            "noise_seconds_q1",
            "noise_seconds_q3",
        ]
        .map(str::to_owned)
        .into();
        if let Some(cell) = self.cells.first() {
            for weak in &cell.weak {
                headings.push(format!("weak_error_{}", weak.observable));
                headings.push(format!("weak_standard_error_{}", weak.observable));
            }
        }
        let mut rows = vec![headings];
        for cell in &self.cells {
            let mut row = vec![cell.scheme.clone(), cell.h.to_string()];
            row.extend([cell.steps, cell.paths, cell.failures].map(|count| count.to_string()));
            let numbers = [
                cell.strong.value,
                cell.strong.standard_error,
                cell.energy_trend.value,
                cell.energy_oscillation.value,
                cell.iterations,
                f64::from(cell.largest_iterations),
            ];
            row.extend(numbers.map(|number| number.to_string()));
            for spread in [cell.time, cell.noise_time] {
                let values = spread.map(|s| [s.median, s.low, s.high].map(|value| value.to_string()));
                row.extend(values.unwrap_or_default());
            }
            for weak in &cell.weak {
                row.extend([weak.bias.value, weak.bias.standard_error].map(|value| value.to_string()));
            }
            rows.push(row);
        }
        csv_text(rows)
    }

    /// Everything, every path's error and every timing included.
    ///
    /// # Errors
    /// [`ReportError::Format`].
    pub fn json(&self) -> Result<String, ReportError> {
        serde_json::to_string_pretty(self).map_err(|error| ReportError::Format(error.to_string()))
    }
}
