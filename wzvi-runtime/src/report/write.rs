//! A measurement as CSV and JSON.
//!
//! Tested by `tests/paths/report/files.rs`.

use super::statistics::Spread;
use super::{Cell, Report, ReportError};
use crate::saving::table::TableRows;

impl Report {
    /// One line for each scheme and step size, every number in full; `NaN` where nothing was measured.
    pub fn csv(&self) -> Vec<u8> {
        let mut rows = TableRows::of(&self.cells)
            .column("scheme", |cell| cell.scheme.clone())
            .column("h", |cell| cell.h)
            .column("steps", |cell| cell.steps as u64)
            .column("paths", |cell| cell.paths as u64)
            .column("failures", |cell| cell.failures as u64)
            .column("strong_error", |cell| cell.strong.value)
            .column("strong_standard_error", |cell| cell.strong.standard_error)
            .column("energy_trend", |cell| cell.energy_trend.value)
            .column("energy_oscillation", |cell| cell.energy_oscillation.value)
            .column("newton_per_step", |cell| cell.iterations)
            .column("newton_largest", |cell| u64::from(cell.largest_iterations));
        rows = timed(rows, "step", |cell| cell.time);
        rows = timed(rows, "noise", |cell| cell.noise_time);
        for (index, weak) in self.cells.first().map_or(&[][..], |cell| &cell.weak).iter().enumerate() {
            let (name, bias) = (&weak.observable, move |cell: &Cell| cell.weak[index].bias);
            rows = rows
                .column(format!("weak_error_{name}"), move |cell| bias(cell).value)
                .column(format!("weak_standard_error_{name}"), move |cell| bias(cell).standard_error);
        }
        rows.table("measurements").csv()
    }

    /// Everything, every path's error and every timing included.
    ///
    /// # Errors
    /// [`ReportError::Format`].
    pub fn json(&self) -> Result<String, ReportError> {
        serde_json::to_string_pretty(self).map_err(|error| ReportError::Format(error.to_string()))
    }
}

/// The median and the quartiles of a time.
fn timed<'r>(
    rows: TableRows<'r, &'r Cell>,
    name: &str,
    spread: fn(&Cell) -> Option<Spread>,
) -> TableRows<'r, &'r Cell> {
    let entry = |part: fn(Spread) -> f64| move |cell: &&Cell| spread(cell).map_or(f64::NAN, part);
    rows.column(format!("{name}_seconds_median"), entry(|spread| spread.median))
        .column(format!("{name}_seconds_q1"), entry(|spread| spread.low))
        .column(format!("{name}_seconds_q3"), entry(|spread| spread.high))
}
