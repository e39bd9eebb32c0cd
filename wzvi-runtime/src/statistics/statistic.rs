//! Statistics of many paths, which see path after path.
//!
//! Tested by `tests/ensembles/statistics.rs`.

use std::any::Any;
use std::fmt;
use std::iter;

use super::passage::Passage;
use super::results::Statistics;
use crate::algebra::crossing::Direction;
use crate::error::{InternalError, StepError};
use crate::ground::names::short_name;
use crate::ground::numbers::{Numbers, Tape};
use crate::saving::table::{Table, TableChunks};

/// An observation of a path, which a [`Statistic`] sees.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Seen<'s> {
    /// The path at a recorded time, each in its order.
    Values {
        /// Number of the recorded time, 0 for the start.
        node: usize,
        /// Its observables.
        values: &'s [f64],
    },
    /// The path is missing at this recorded time: it has failed before.
    Lost {
        /// Number of the recorded time.
        node: usize,
    },
    /// The outcome of the path's first passage of an event.
    Passage {
        /// Number of the event.
        event: usize,
        /// Whether and when it passed.
        passage: Passage,
    },
    /// The path crosses a section.
    Crossing {
        /// Number of the section.
        section: usize,
        /// How often the path has crossed it before.
        before: u64,
        /// Whether the function of the section rises or falls.
        direction: Direction,
        /// Time of the crossing.
        t: f64,
        /// Coordinates there.
        q: &'s [f64],
        /// Momenta there.
        p: &'s [f64],
    },
    /// The path is over, and has crossed a section so often.
    Crossings {
        /// Number of the section.
        section: usize,
        /// How often.
        count: u64,
    },
    /// The path ended early.
    Failure(StepError),
}

/// A statistic of the paths of an ensemble ([`Ensemble::statistic`](crate::ensemble::Ensemble::statistic)).
///
/// Paths run in chunks of a fixed size. Each chunk has a clone of the given statistic, which sees the paths
/// of the chunk, and the chunks are merged in the order of their numbers. The result therefore has the same
/// bits on any number of threads and ranks. Checkpoints and ranks keep what [`Numbers::pass`] passes to the
/// tape: everything that paths change.
///
/// At each recorded time paths come in the order of their numbers. Several run side by side, so a statistic
/// that remembers something of a path keeps it by the number of the path.
pub trait Statistic: Numbers + Clone + fmt::Debug + PartialEq + Send + Sync + 'static {
    /// Sees what happens to a path, by its number from 0.
    fn see(&mut self, path: u64, seen: &Seen<'_>);

    /// Adds the statistic of a later chunk. The order matters to the last bit.
    fn merge(&mut self, later: &Self);

    /// The result as tables, which [`Statistics::tables`] and files then include. `run` has the recorded
    /// times and the names of observables.
    fn rows<'s>(&'s self, run: &'s Statistics) -> Tables<'s>;
}

/// Tables, each whole or in parts with the same columns.
pub struct Tables<'s>(pub(super) Vec<TableChunks<'s>>);

impl fmt::Debug for Tables<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tables").field("count", &self.0.len()).finish_non_exhaustive()
    }
}

impl From<Table> for Tables<'_> {
    fn from(table: Table) -> Self {
        Self(vec![Box::new(iter::once(table))])
    }
}

/// A [`Statistic`] of any type.
pub(crate) trait AnyStatistic: fmt::Debug + Send + Sync {
    fn see(&mut self, path: u64, seen: &Seen<'_>);

    /// # Errors
    /// [`InternalError`] if the other is of another type.
    fn merge(&mut self, later: &dyn AnyStatistic) -> Result<(), InternalError>;

    fn pass(&mut self, tape: &mut Tape);

    fn rows<'s>(&'s self, run: &'s Statistics) -> Tables<'s>;

    fn copy(&self) -> Box<dyn AnyStatistic>;

    fn equals(&self, other: &dyn AnyStatistic) -> bool;

    fn as_any(&self) -> &dyn Any;

    /// The name of its type.
    fn name(&self) -> String;
}

impl<T: Statistic> AnyStatistic for T {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn see(&mut self, path: u64, seen: &Seen<'_>) {
        Statistic::see(self, path, seen);
    }

    fn merge(&mut self, later: &dyn AnyStatistic) -> Result<(), InternalError> {
        let other = || InternalError::new("chunks have the same statistics", format!("{later:?}"));
        Statistic::merge(self, later.as_any().downcast_ref().ok_or_else(other)?);
        Ok(())
    }

    fn pass(&mut self, tape: &mut Tape) {
        Numbers::pass(self, tape);
    }

    fn rows<'s>(&'s self, run: &'s Statistics) -> Tables<'s> {
        Statistic::rows(self, run)
    }

    fn copy(&self) -> Box<dyn AnyStatistic> {
        Box::new(self.clone())
    }

    fn equals(&self, other: &dyn AnyStatistic) -> bool {
        other.as_any().downcast_ref() == Some(self)
    }

    fn as_any(&self) -> &dyn Any {
        self
    }

    fn name(&self) -> String {
        short_name::<T>()
    }
}

impl Clone for Box<dyn AnyStatistic> {
    fn clone(&self) -> Self {
        (**self).copy()
    }
}

impl PartialEq for dyn AnyStatistic {
    fn eq(&self, other: &Self) -> bool {
        self.equals(other)
    }
}
