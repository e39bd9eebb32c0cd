//! The statistics of finished chunks, their checkpoint, and the test of targets.

use std::ops::{ControlFlow, Range};

use super::control::{Control, ErrorTargets, unless_lost};
use super::job::EnsembleJob;
use super::run_identity;
use crate::ground::numbers::Numbers as _;
use crate::ground::progress::ProgressLine;
use crate::scheme::system::Discretized;
use crate::statistics::Provenance;
use crate::statistics::{Statistics, StatisticsNode};
use crate::trajectory::Error;
use crate::trajectory::checkpoint::{CheckpointKeeper, CheckpointSetting};

/// Errors are tested each time so many paths are done, for any size of chunks.
const LOOK: u64 = 512;

/// Takes the chunks of a run in the order of their numbers.
pub(super) struct ChunkLedger {
    statistics: Statistics,
    keeper: CheckpointKeeper,
    targets: ErrorTargets,
    progress: ProgressLine,
    /// Paths of the run, at most, and of a chunk.
    limit: u64,
    size: u64,
    /// The fraction of paths that may fail.
    allowed_losses: f64,
    /// Chunks that are still to be done.
    chunks: Range<u64>,
    error: Option<Error>,
}

impl ChunkLedger {
    /// With the chunks of the checkpoint, if there is one.
    pub(super) fn open<H, E>(
        job: &EnsembleJob<'_, H, E>,
        control: &Control,
        keeping: CheckpointSetting,
        progress: ProgressLine,
    ) -> Result<Self, Error>
    where
        H: Discretized<E> + Sync,
    {
        let targets = control.targets(job.observed.empty.observables())?;
        let allowed_losses = control.allowed_losses()?;
        let mut statistics = job.observed.empty.clone();
        statistics.origin = Some(Provenance::of(job));
        if let Some(paths) = &mut statistics.paths {
            paths.reserve(job.paths)?;
        }
        let keeper = run_identity::open(keeping, job, &mut statistics)?;
        let chunks = keeper.first()..job.chunks().end;
        let (limit, size) = (job.paths, job.chunk);
        let mut account =
            Self { statistics, keeper, targets, progress, limit, size, allowed_losses, chunks, error: None };
        if account.targets_reached().0 {
            account.chunks.end = account.chunks.start;
        }
        Ok(account)
    }

    /// The numbers of the chunks that are still to be done.
    pub(super) fn chunks(&self) -> Range<u64> {
        self.chunks.clone()
    }

    /// Whether the paths so far are enough, and about how many that takes.
    fn targets_reached(&self) -> (bool, u64) {
        let (is_done, expected) = self.targets.errors_reached(&self.statistics, self.limit);
        (is_done && (self.chunks.start * self.size).is_multiple_of(LOOK), expected)
    }

    /// The next chunk, or why it has no result; breaks if that was the last one.
    pub(super) fn add_chunk(&mut self, chunk: Result<Statistics, Error>) -> ControlFlow<()> {
        match chunk.and_then(|chunk| Ok(self.statistics.merge(&chunk)?)) {
            Ok(()) => {}
            Err(Error::Stopped(_)) => {
                self.statistics.is_partial = true;
                return ControlFlow::Break(());
            }
            Err(error) => {
                self.error = Some(error);
                return ControlFlow::Break(());
            }
        }
        self.chunks.start += 1;
        let (is_done, expected) = self.targets_reached();
        self.progress.show(self.statistics.begun(), expected);
        let Self { keeper, statistics, chunks, .. } = self;
        if keeper.is_due(chunks.start) {
            self.error = keeper.save(chunks.start, &mut |tape| statistics.pass(tape)).err();
        }
        if is_done || self.error.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// The statistics at the end.
    pub(super) fn close(mut self) -> Result<Statistics, Error> {
        if let Some(error) = self.error {
            return Err(error);
        }
        let mut statistics = self.statistics;
        self.keeper.close(self.chunks.start, &mut |tape| statistics.pass(tape))?;
        statistics.unsaved = self.keeper.unsaved();
        statistics.targets = self.targets.statuses(&statistics);
        match (statistics.last().map_or(0, StatisticsNode::count), statistics.failures().first()) {
            (0, Some(failure)) => Err(failure.error.into()),
            _ => Ok(unless_lost(statistics, self.allowed_losses)?),
        }
    }
}
