//! Paths that failed.
//!
//! Tested by `tests/ensembles/runs.rs`.

use std::fmt;

use super::results::Statistics;
use super::statistic::{Seen, Statistic, Tables};
use crate::error::{StepError, StepFailure, messages};
use crate::ground::numbers::{Numbers, Tape, numbers};
use crate::saving::table::TableRows;

/// Failed paths that are kept with their errors; further ones are only counted.
const MOST_FAILURES: usize = 1000;

/// A path that ended early.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathFailure {
    /// Number of the path, from 0.
    pub path: u64,
    /// Its step, time and cause.
    pub error: StepError,
}

impl PathFailure {
    /// A placeholder that a tape replaces.
    const NONE: Self =
        Self { path: 0, error: StepError { step: 0, t: 0.0, h: 0.0, cause: StepFailure::NonFinite } };
}

numbers! { impl[] Numbers for PathFailure { kept: path, error } }

/// How many paths failed, and the first of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Losses {
    pub(super) failed: u64,
    pub(super) failures: Vec<PathFailure>,
}

impl Statistic for Losses {
    fn see(&mut self, path: u64, seen: &Seen<'_>) {
        if let Seen::Failure(error) = *seen {
            self.merge(&Self { failed: 1, failures: vec![PathFailure { path, error }] });
        }
    }

    fn merge(&mut self, later: &Self) {
        self.failed += later.failed;
        let room = MOST_FAILURES.saturating_sub(self.failures.len());
        self.failures.extend(later.failures.iter().take(room));
    }

    fn rows<'s>(&'s self, _run: &'s Statistics) -> Tables<'s> {
        Tables(vec![
            TableRows::of(self.failures.iter())
                .column("path", |failure| failure.path)
                .column("step", |failure| failure.error.step)
                .column("time", |failure| failure.error.t)
                .column("cause", |failure| failure.error.cause.to_string())
                .parts("failures"),
        ])
    }
}

impl Numbers for Losses {
    fn pass(&mut self, tape: &mut Tape) {
        tape.word(&mut self.failed);
        let length = tape.length(self.failures.len());
        if length > MOST_FAILURES {
            tape.refuse();
            return;
        }
        self.failures.resize(length, PathFailure::NONE);
        self.failures.iter_mut().for_each(|failure| failure.pass(tape));
    }
}

/// More paths failed than the run allows
/// ([`Ensemble::allow_losses`](crate::ensemble::Ensemble::allow_losses)): the means are those of the others,
/// and how far the lost paths would have changed them is not known.
#[derive(Clone, PartialEq)]
pub struct LossError {
    /// Paths that failed.
    pub failed: u64,
    /// Paths in all.
    pub begun: u64,
    /// The fraction that is allowed.
    pub allowed: f64,
    /// The first that failed.
    pub first: PathFailure,
    /// The statistics of the paths that did not fail.
    pub statistics: Box<Statistics>,
}

/// Without the statistics, which are long.
impl fmt::Debug for LossError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { failed, begun, allowed, first, statistics: _ } = self;
        let mut fields = f.debug_struct("LossError");
        fields.field("failed", failed).field("begun", begun).field("allowed", allowed).field("first", first);
        fields.finish_non_exhaustive()
    }
}

messages! { LossError:
    Self { failed, begun, allowed, first, .. } =>
        "{failed} of {begun} paths failed, more than the fraction of {allowed} that is allowed, and are missing in the means; the first, \
         path {}: {}. Halve steps that fail with `.retry(Retry::halving(n))`, take a smaller step, or add `.allow_losses(fraction)`",
        first.path, first.error;
}
