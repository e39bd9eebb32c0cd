//! Tables: columns with names, and their text as CSV and JSON.
//!
//! Tested by `tests/ensembles/statistics.rs` and `tests/paths/results.rs`.

mod rows;

use std::fmt::Write as _;
use std::io::{self, Write};

use crate::ground::names::free;
pub(crate) use rows::{TableChunks, TableRows};

/// Columns of one length.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    name: String,
    columns: Vec<(String, Column)>,
}

/// Entries of one type.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// Real numbers; NaN for none.
    Number(Vec<f64>),
    /// Counts and numbers of things.
    Count(Vec<u64>),
    /// Names and explanations.
    Text(Vec<String>),
}

impl Column {
    fn len(&self) -> usize {
        match self {
            Self::Number(entries) => entries.len(),
            Self::Count(entries) => entries.len(),
            Self::Text(entries) => entries.len(),
        }
    }

    fn write_json(&self, row: usize, to: &mut impl Write) -> io::Result<()> {
        match self {
            Self::Number(entries) if entries[row].is_finite() => write!(to, "{:?}", entries[row]),
            Self::Number(_) => write!(to, "null"),
            Self::Count(entries) => write!(to, "{}", entries[row]),
            Self::Text(entries) => write!(to, "{}", escaped(&entries[row])),
        }
    }
}

impl Table {
    /// The subject of the rows, which is the name of its file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The columns with their names, from left to right.
    pub fn columns(&self) -> &[(String, Column)] {
        &self.columns
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, column)| column.len())
    }

    /// Comma-separated values as in RFC 4180, with the names in the first line. Numbers are exact to the last
    /// bit; undefined and infinite ones are `NaN`, `inf` and `-inf`.
    ///
    /// # Errors
    /// The errors of `to`.
    pub fn write_csv(&self, to: &mut impl Write) -> io::Result<()> {
        self.write_csv_names(to)?;
        self.write_csv_rows(to)
    }

    /// The rows of this table and of others with the same columns.
    pub(crate) fn write_csv_parts(
        &self,
        rest: impl Iterator<Item = Self>,
        to: &mut impl Write,
    ) -> io::Result<()> {
        self.write_csv(to)?;
        for part in rest {
            part.write_csv_rows(to)?;
        }
        Ok(())
    }

    fn write_csv_names(&self, to: &mut impl Write) -> io::Result<()> {
        let mut line = String::new();
        for (i, (name, _)) in self.columns.iter().enumerate() {
            separate(&mut line, i);
            quote(&mut line, name);
        }
        writeln!(to, "{line}")
    }

    fn write_csv_rows(&self, to: &mut impl Write) -> io::Result<()> {
        let mut line = String::new();
        for row in 0..self.rows() {
            line.clear();
            for (i, (_, column)) in self.columns.iter().enumerate() {
                separate(&mut line, i);
                match column {
                    // Writing to a string cannot fail.
                    Column::Number(entries) => drop(write!(line, "{:?}", entries[row])),
                    Column::Count(entries) => drop(write!(line, "{}", entries[row])),
                    Column::Text(entries) => quote(&mut line, &entries[row]),
                }
            }
            writeln!(to, "{line}")?;
        }
        Ok(())
    }

    /// [`Table::write_csv`] into memory.
    pub(crate) fn csv(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        // Writing to memory cannot fail.
        let _ = self.write_csv(&mut bytes);
        bytes
    }

    /// The entries of a column with commas between them, and before the first one unless it is that of the
    /// whole table; numbers come back to the last bit, but JSON has `null` for those that are none or
    /// infinite.
    pub(crate) fn write_json_entries(
        &self,
        column: usize,
        is_first: bool,
        to: &mut impl Write,
    ) -> io::Result<()> {
        let Some((_, column)) = self.columns.get(column) else { return Ok(()) };
        for row in 0..column.len() {
            to.write_all(if is_first && row == 0 { b"" } else { b"," })?;
            column.write_json(row, to)?;
        }
        Ok(())
    }

    /// `[{"column":entry, ...}, ...]`, a line for each row, with numbers as in [`Table::write_csv`]; JSON has
    /// `null` for undefined and infinite ones.
    ///
    /// # Errors
    /// The errors of `to`.
    pub fn write_json_records(&self, to: &mut impl Write) -> io::Result<()> {
        let names: Vec<String> = self.columns.iter().map(|(name, _)| escaped(name)).collect();
        for row in 0..self.rows() {
            write!(to, "{}", if row == 0 { "[" } else { ",\n" })?;
            for (i, (name, (_, column))) in names.iter().zip(&self.columns).enumerate() {
                write!(to, "{}{name}:", if i == 0 { "{" } else { "," })?;
                column.write_json(row, to)?;
            }
            write!(to, "}}")?;
        }
        writeln!(to, "{}]", if self.rows() == 0 { "[" } else { "" })
    }

    /// A table without columns, with the name of its file.
    pub fn named(name: impl Into<String>) -> Self {
        Self { name: name.into(), columns: Vec::new() }
    }

    /// Adds a column, as long as the others, under this name, or under a longer one if another column has it.
    pub fn push(&mut self, name: &str, entries: impl Into<Column>) {
        let name = free(name, self.columns.iter().map(|(known, _)| known.as_str()));
        self.columns.push((name, entries.into()));
    }
}

fn separate(line: &mut String, column: usize) {
    if column > 0 {
        line.push(',');
    }
}

fn quote(line: &mut String, text: &str) {
    if text.contains(['"', ',', '\n', '\r']) {
        line.push('"');
        line.push_str(&text.replace('"', "\"\""));
        line.push('"');
    } else {
        line.push_str(text);
    }
}

pub(crate) fn escaped(text: &str) -> String {
    let mut json = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => json.extend(['\\', c]),
            c if c < ' ' => drop(write!(json, "\\u{:04x}", u32::from(c))),
            c => json.push(c),
        }
    }
    json.push('"');
    json
}

impl From<Vec<f64>> for Column {
    fn from(entries: Vec<f64>) -> Self {
        Self::Number(entries)
    }
}

impl From<Vec<u64>> for Column {
    fn from(entries: Vec<u64>) -> Self {
        Self::Count(entries)
    }
}

impl From<Vec<String>> for Column {
    fn from(entries: Vec<String>) -> Self {
        Self::Text(entries)
    }
}
