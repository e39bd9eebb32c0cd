//! Tables: columns with names, and their text as CSV and JSON.

use std::fmt::Write as _;
use std::io::{self, Write};

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
}

impl Table {
    /// What the rows are about: the name of its file.
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

    /// Comma-separated values as in RFC 4180, with the names in the first line. Numbers come back to the last bit; those that
    /// are none or infinite are `NaN`, `inf` and `-inf`.
    ///
    /// # Errors
    /// Those of `to`.
    pub fn write_csv(&self, to: &mut impl Write) -> io::Result<()> {
        let mut line = String::new();
        for (i, (name, _)) in self.columns.iter().enumerate() {
            separate(&mut line, i);
            quote(&mut line, name);
        }
        writeln!(to, "{line}")?;
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
    #[cfg(feature = "report")]
    pub(crate) fn csv(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        // Writing to memory cannot fail.
        let _ = self.write_csv(&mut bytes);
        bytes
    }

    /// `{"column":[entries], ...}`; numbers come back to the last bit, but JSON has `null` for those that are none or
    /// infinite.
    #[cfg(feature = "ensemble")]
    pub(crate) fn write_json(&self, to: &mut impl Write) -> io::Result<()> {
        for (i, (name, column)) in self.columns.iter().enumerate() {
            write!(to, "{}{}:[", if i == 0 { "{" } else { "," }, escaped(name))?;
            for row in 0..column.len() {
                let comma = if row == 0 { "" } else { "," };
                match column {
                    Column::Number(entries) if entries[row].is_finite() => {
                        write!(to, "{comma}{:?}", entries[row])?;
                    }
                    Column::Number(_) => write!(to, "{comma}null")?,
                    Column::Count(entries) => write!(to, "{comma}{}", entries[row])?,
                    Column::Text(entries) => write!(to, "{comma}{}", escaped(&entries[row]))?,
                }
            }
            write!(to, "]")?;
        }
        write!(to, "}}")
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

#[cfg(feature = "ensemble")]
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

/// An entry of a row.
pub(crate) enum Cell<'a> {
    Number(f64),
    Count(u64),
    Text(&'a str),
}
use Cell::{Count, Number, Text};

pub(crate) const NUMBER: Column = Column::Number(Vec::new());
pub(crate) const COUNT: Column = Column::Count(Vec::new());
pub(crate) const TEXT: Column = Column::Text(Vec::new());

impl Table {
    /// Without rows: columns of given types, and columns of numbers.
    pub(crate) fn new<'n>(
        name: impl Into<String>,
        columns: impl IntoIterator<Item = (&'n str, Column)>,
        numbers: impl IntoIterator<Item = &'n str>,
    ) -> Self {
        let columns = columns.into_iter().chain(numbers.into_iter().map(|name| (name, NUMBER)));
        Self { name: name.into(), columns: columns.map(|(name, column)| (name.to_owned(), column)).collect() }
    }

    /// One more row, whose entries have the types of the columns.
    pub(crate) fn row<'a>(&mut self, cells: impl IntoIterator<Item = Cell<'a>>) {
        for ((_, column), cell) in self.columns.iter_mut().zip(cells) {
            match (column, cell) {
                (Column::Number(entries), Number(entry)) => entries.push(entry),
                (Column::Count(entries), Count(entry)) => entries.push(entry),
                (Column::Text(entries), Text(entry)) => entries.push(entry.to_owned()),
                (Column::Number(_) | Column::Count(_) | Column::Text(_), _) => {
                    debug_assert!(false, "the types of the table `{}`", self.name);
                }
            }
        }
    }
}
