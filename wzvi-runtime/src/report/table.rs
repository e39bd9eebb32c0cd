//! The terminal table.

use comfy_table::{CellAlignment, ContentArrangement, LineStyle, Table, presets};

use super::{Cell, Report, duration, number};
use crate::ground::digits::estimate;

impl Report {
    /// Prints [`Report::text`].
    pub fn print(&self) {
        println!("{}", self.text());
    }

    /// Headings and rows of the table, as people read them.
    pub fn rows(&self) -> (Vec<String>, Vec<Vec<String>>) {
        let energy = if self.conserves_energy == "Proven" { "energy" } else { "energy (not conserved)" };
        let mut headings: Vec<String> = ["scheme", "h", "strong error"].map(str::to_owned).into();
        if let Some(cell) = self.cells.first() {
            headings.extend(cell.weak.iter().map(|weak| format!("weak error of {} (95 %)", weak.observable)));
        }
        headings.extend([format!("{energy} trend"), format!("{energy} oscillation")]);
        headings.extend(["failed", "Newton", "time of steps", "time of noise"].map(str::to_owned));
        (headings, self.cells.iter().map(row).collect())
    }

    /// The measurements as text: the table, the slopes, the choices in words, the machine.
    pub fn text(&self) -> String {
        let (headings, rows) = self.rows();
        let mut table = Table::new();
        let style = presets::UTF8_HORIZONTAL_ONLY.row_separator(LineStyle::none());
        table.load_style(style).set_content_arrangement(ContentArrangement::Disabled);
        table.set_header(headings);
        for row in rows {
            table.add_row(row);
        }
        for column in table.column_iter_mut().skip(1) {
            column.set_cell_alignment(CellAlignment::Right);
        }
        let mut lines = vec![self.title.clone(), table.to_string()];
        lines.extend(self.conclusions());
        lines.push(self.conditions());
        lines.join("\n")
    }

    /// The slopes, the choices, failures, in sentences.
    pub fn conclusions(&self) -> Vec<String> {
        let mut lines: Vec<String> = vec![];
        for scheme in self.schemes() {
            lines.push(format!("{scheme}: {}", self.slope(scheme).words()));
        }
        lines.extend(self.choices().iter().map(|choice| choice.words()));
        for cell in &self.cells {
            if let Some(failure) = &cell.failure {
                lines.push(format!(
                    "{} with h = {} failed on {} of {} paths: {failure}",
                    cell.scheme,
                    number(cell.h),
                    cell.failures,
                    cell.failures + cell.paths
                ));
            }
        }
        if self.interrupted {
            lines.push("interrupted: only the measurements until then".to_owned());
        }
        lines
    }

    /// The meaning of the columns of the table, a sentence each.
    pub fn terms(&self) -> Vec<String> {
        let strong = "strong error: the root mean square over paths of the distance between the end of the run and the solution, with its \
                      standard error";
        let weak = "weak error: the mean of the observable minus that of the solution, with its 95 % confidence interval";
        let energy = "trend: the change of the energy over the run, by a linear fit; oscillation: the root mean square distance from that line";
        let rest = "failed: paths whose step had no solution; Newton: mean iterations in a step; time of steps, of noise: the median for one \
                    path, with half the distance of the quartiles";
        let has_weak = self.cells.first().is_some_and(|cell| !cell.weak.is_empty());
        let weak = has_weak.then_some(weak);
        [strong].into_iter().chain(weak).chain([energy, rest]).map(str::to_owned).collect()
    }

    /// The measurement, its reference, the machine and the date.
    pub fn conditions(&self) -> String {
        let paths = self.cells.iter().map(|cell| cell.paths + cell.failures).max().unwrap_or(0);
        format!(
            "T = {}, {paths} paths of seed {}, compared with: {}. {}.",
            number(self.span),
            self.seed,
            self.reference,
            self.machine.line()
        )
    }
}

fn row(cell: &Cell) -> Vec<String> {
    let mut row =
        vec![cell.scheme.clone(), number(cell.h), estimate(cell.strong.value, cell.strong.standard_error)];
    row.extend(cell.weak.iter().map(|weak| estimate(weak.bias.value, weak.bias.half_width())));
    row.extend([number(cell.energy_trend.value), number(cell.energy_oscillation.value)]);
    row.push(cell.failures.to_string());
    row.push(number(cell.iterations));
    let half = |spread: super::statistics::Spread| {
        format!("{} ± {:.0} %", duration(spread.median), 50.0 * (spread.high - spread.low) / spread.median)
    };
    row.push(cell.time.map_or_else(|| "-".to_owned(), half));
    row.push(cell.noise_time.map_or_else(|| "-".to_owned(), half));
    row
}
