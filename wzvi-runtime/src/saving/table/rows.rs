//! Tables that are made of rows.
//!
//! Tested by `tests/ensembles/large_tables.rs`.

use std::borrow::Cow;
use std::iter::{self, Peekable};
use std::mem::take;

use super::{Column, Table};

/// Rows of a part: some megabytes of numbers.
const PART: usize = 1 << 15;

/// The rows of a table in parts; there is always a first part.
pub(crate) type TableChunks<'r> = Box<dyn Iterator<Item = Table> + 'r>;

/// The entries of some rows.
type ToColumn<'r, R> = Box<dyn Fn(&[R]) -> Column + 'r>;

/// The rows `R` of a table, and its columns: the name of each, and its entries.
pub(crate) struct TableRows<'r, R> {
    rows: Peekable<Box<dyn Iterator<Item = R> + 'r>>,
    columns: Vec<(Cow<'r, str>, ToColumn<'r, R>)>,
}

impl<'r, R: 'r> TableRows<'r, R> {
    /// Without columns.
    pub(crate) fn of(rows: impl IntoIterator<Item = R, IntoIter: 'r>) -> Self {
        let rows: Box<dyn Iterator<Item = R> + 'r> = Box::new(rows.into_iter());
        Self { rows: rows.peekable(), columns: Vec::new() }
    }

    /// One more column: numbers, counts or texts.
    pub(crate) fn column<T>(mut self, name: impl Into<Cow<'r, str>>, entry: impl Fn(&R) -> T + 'r) -> Self
    where
        Column: From<Vec<T>>,
    {
        let entries = move |rows: &[R]| {
            // Collected once for each type, not for each column.
            let entry: &dyn Fn(&R) -> T = &entry;
            rows.iter().map(entry).collect::<Vec<T>>().into()
        };
        self.columns.push((name.into(), Box::new(entries)));
        self
    }

    /// The names of the columns.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> + Clone {
        self.columns.iter().map(|(name, _)| &**name)
    }

    /// The next rows, this many at most.
    fn some(&mut self, name: &str, most: usize) -> Table {
        let rows: Vec<R> = self.rows.by_ref().take(most).collect();
        let columns = self.columns.iter().map(|(name, entries)| (name.clone().into_owned(), entries(&rows)));
        Table { name: name.to_owned(), columns: columns.collect() }
    }

    /// The table of this name, in parts that are made on request.
    pub(crate) fn parts(mut self, name: &'r str) -> TableChunks<'r> {
        let mut is_first = true;
        Box::new(iter::from_fn(move || {
            let is_wanted = take(&mut is_first) || self.rows.peek().is_some();
            is_wanted.then(|| self.some(name, PART))
        }))
    }

    /// The whole table.
    pub(crate) fn table(mut self, name: &str) -> Table {
        self.some(name, usize::MAX)
    }
}

impl Table {
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
}
