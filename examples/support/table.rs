//! Tables for people: columns as wide as they must be, numbers to the right.

#![allow(dead_code, reason = "each example takes what it needs")]

/// Prints rows under their headings. The first column is text and stands to the left.
pub(crate) fn print<const N: usize>(headings: [&str; N], rows: &[[String; N]]) {
    let width = |column: usize| {
        let cells = rows.iter().map(|row| row[column].as_str()).chain([headings[column]]);
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: [usize; N] = std::array::from_fn(width);
    let line = |cells: [&str; N]| {
        let mut line = String::from(" ");
        for (column, (cell, width)) in cells.iter().zip(widths).enumerate() {
            line += &if column == 0 { format!(" {cell:<width$}") } else { format!("  {cell:>width$}") };
        }
        println!("{}", line.trim_end());
    };
    line(headings);
    println!("  {}", "-".repeat(widths.iter().sum::<usize>() + 2 * (N - 1)));
    rows.iter().for_each(|row| line(row.each_ref().map(String::as_str)));
}

/// Mean and its standard error.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Mean {
    count: f64,
    mean: f64,
    /// Sum of squared deviations (Welford).
    squares: f64,
}

impl Mean {
    pub(crate) fn add(&mut self, value: f64) {
        self.count += 1.0;
        let off = value - self.mean;
        self.mean += off / self.count;
        self.squares += off * (value - self.mean);
    }

    pub(crate) fn value(&self) -> f64 {
        self.mean
    }

    pub(crate) fn standard_error(&self) -> f64 {
        (self.squares / (self.count * (self.count - 1.0))).sqrt()
    }
}
