//! Tables that are made row by row.

use super::{Column, Table};
use Cell::{Count, Number, Text};

/// An entry of a row.
pub(crate) enum Cell<'a> {
    Number(f64),
    Count(u64),
    Text(&'a str),
}

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

    /// The rows of another table with the same columns, behind those of this one.
    pub(crate) fn append(&mut self, other: Self) {
        for ((_, ours), (_, theirs)) in self.columns.iter_mut().zip(other.columns) {
            match (ours, theirs) {
                (Column::Number(ours), Column::Number(theirs)) => ours.extend(theirs),
                (Column::Count(ours), Column::Count(theirs)) => ours.extend(theirs),
                (Column::Text(ours), Column::Text(theirs)) => ours.extend(theirs),
                (Column::Number(_) | Column::Count(_) | Column::Text(_), _) => {
                    debug_assert!(false, "the types of the table `{}`", self.name);
                }
            }
        }
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
