//! The paths in the lanes of a group, and the failed ones among them.

use std::array::from_fn;

use crate::error::StepError;
use crate::statistics::PathFailure;

/// The paths of `L` lanes.
pub(in crate::ensemble) struct LanePaths<const L: usize> {
    /// The number of the path in lane 0; those of the other lanes follow.
    first: u64,
    /// Lanes that are paths of this run; others only keep the vector full.
    counts: [bool; L],
    /// Lanes whose path has failed.
    failed: [bool; L],
    any_failed: bool,
    failures: Vec<PathFailure>,
}

impl<const L: usize> LanePaths<L> {
    /// No paths.
    pub(super) fn none() -> Self {
        Self { first: 0, counts: [false; L], failed: [false; L], any_failed: false, failures: Vec::new() }
    }

    /// Goes on to paths `first ..`, as many as there are before `end`.
    pub(super) fn begin(&mut self, first: u64, end: u64) {
        self.first = first;
        self.counts = from_fn(|lane| first + (lane as u64) < end);
        (self.failed, self.any_failed) = ([false; L], false);
    }

    /// The number of the path of a lane.
    pub(in crate::ensemble) fn number(&self, lane: usize) -> u64 {
        self.first + lane as u64
    }

    /// The path whose start and system a lane has: one without a path has those of the first.
    pub(super) fn source(&self, lane: usize) -> u64 {
        if self.counts[lane] { self.number(lane) } else { self.first }
    }

    /// Whether a lane is a path of this run.
    pub(in crate::ensemble) fn is_path(&self, lane: usize) -> bool {
        self.counts[lane]
    }

    /// Whether the path of a lane has failed.
    pub(in crate::ensemble) fn has_failed(&self, lane: usize) -> bool {
        self.failed[lane]
    }

    /// Whether a lane is a path of this run that has not failed.
    pub(in crate::ensemble) fn goes_on(&self, lane: usize) -> bool {
        self.counts[lane] && !self.failed[lane]
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn any_failed(&self) -> bool {
        self.any_failed
    }

    /// Maps each lane to itself, and each failed lane to the first lane still alive; `None` if none is.
    pub(super) fn living(&self) -> Option<[usize; L]> {
        let living = (0..L).find(|&lane| !self.failed[lane])?;
        Some(from_fn(|lane| if self.failed[lane] { living } else { lane }))
    }

    /// The path of a lane ends with this error.
    pub(super) fn fail(&mut self, lane: usize, error: StepError) {
        (self.failed[lane], self.any_failed) = (true, true);
        if self.counts[lane] {
            self.failures.push(PathFailure { path: self.number(lane), error });
        }
    }

    /// Why this path failed, if it has.
    pub(in crate::ensemble) fn failure_of(&self, path: u64) -> Option<PathFailure> {
        self.failures.iter().find(|failure| failure.path == path).copied()
    }

    /// Failures since the last call, sorted by path number.
    pub(in crate::ensemble) fn take_failures(&mut self) -> Vec<PathFailure> {
        let mut failures = std::mem::take(&mut self.failures);
        failures.sort_unstable_by_key(|failure| failure.path);
        failures
    }
}
