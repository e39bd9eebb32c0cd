//! A measurement as CSV and JSON.

use super::{Cell, Report, ReportError};
use crate::saving::table::Cell::{Count, Number, Text};
use crate::saving::table::{COUNT, Column, NUMBER, TEXT, Table};

/// Columns of every measurement.
const COLUMNS: [(&str, Column); 17] = [
    ("scheme", TEXT),
    ("h", NUMBER),
    ("steps", COUNT),
    ("paths", COUNT),
    ("failures", COUNT),
    ("strong_error", NUMBER),
    ("strong_standard_error", NUMBER),
    ("energy_trend", NUMBER),
    ("energy_oscillation", NUMBER),
    ("newton_per_step", NUMBER),
    ("newton_largest", COUNT),
    ("step_seconds_median", NUMBER),
    ("step_seconds_q1", NUMBER),
    ("step_seconds_q3", NUMBER),
    ("noise_seconds_median", NUMBER),
    ("noise_seconds_q1", NUMBER),
    ("noise_seconds_q3", NUMBER),
];

impl Report {
    /// One line for each scheme and step size, every number in full; `NaN` where nothing was measured.
    pub fn csv(&self) -> Vec<u8> {
        let weak = self.cells.first().map_or(&[][..], |cell| &cell.weak);
        let observables = weak.iter().flat_map(|weak| {
            ["weak_error", "weak_standard_error"].map(|name| format!("{name}_{}", weak.observable))
        });
        let observables: Vec<String> = observables.collect();
        let mut table = Table::new("measurements", COLUMNS, observables.iter().map(String::as_str));
        for cell in &self.cells {
            let Cell { strong, energy_trend, energy_oscillation, .. } = cell;
            let spreads = [cell.time, cell.noise_time].map(|spread| {
                spread.map_or([f64::NAN; 3], |spread| [spread.median, spread.low, spread.high])
            });
            let known = [
                Text(&cell.scheme),
                Number(cell.h),
                Count(cell.steps as u64),
                Count(cell.paths as u64),
                Count(cell.failures as u64),
                Number(strong.value),
                Number(strong.standard_error),
                Number(energy_trend.value),
                Number(energy_oscillation.value),
                Number(cell.iterations),
                Count(u64::from(cell.largest_iterations)),
            ];
            let weak = cell.weak.iter().flat_map(|weak| [weak.bias.value, weak.bias.standard_error]);
            table.row(known.into_iter().chain(spreads.into_iter().flatten().chain(weak).map(Number)));
        }
        table.csv()
    }

    /// Everything, every path's error and every timing included.
    ///
    /// # Errors
    /// [`ReportError::Format`].
    pub fn json(&self) -> Result<String, ReportError> {
        serde_json::to_string_pretty(self).map_err(|error| ReportError::Format(error.to_string()))
    }
}
