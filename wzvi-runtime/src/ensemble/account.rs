//! What is known of the blocks that are done, its checkpoint, and when it is enough.

use std::ops::{ControlFlow, Range};

use super::block::PATHS;
use super::control::{Control, Targets, unless_lost};
use super::halt::Halt;
use super::job::Job;
use super::keeping::BlockKeeper;
use super::piece::{self, Piece};
use crate::ground::progress::Progress;
use crate::path::Error;
use crate::path::checkpoint::Keeping;
use crate::scheme::system::Discretized;
use crate::statistics::Origin;
use crate::statistics::{Statistics, StatisticsNode, Wanted};

/// Takes the blocks of a run in the order of their numbers.
pub(super) struct Account<'j> {
    wanted: &'j Wanted,
    /// Paths in a piece of work.
    size: u64,
    statistics: Statistics,
    /// The block that is being put together, and how many of its pieces are there.
    block: Option<Statistics>,
    pieces: u64,
    keeper: BlockKeeper,
    targets: Targets,
    progress: Progress,
    /// Paths of the run, at most.
    limit: u64,
    /// The fraction of them that may fail.
    allowed_losses: f64,
    /// Blocks that are still to be done.
    blocks: Range<u64>,
    error: Option<Error>,
}

impl<'j> Account<'j> {
    /// With the blocks of the checkpoint, if there is one.
    pub(super) fn open<H, E>(
        job: &'j Job<'_, H, E>,
        control: &Control,
        keeping: Keeping,
        progress: Progress,
        threads: usize,
    ) -> Result<Self, Error>
    where
        H: Discretized<E> + Sync,
    {
        let targets = control.targets(&job.wanted.names)?;
        let allowed_losses = control.allowed_losses()?;
        let mut statistics = Statistics::new(&job.wanted);
        statistics.origin = Some(Origin::of(job));
        if let Some(paths) = &mut statistics.paths {
            paths.reserve(job.paths)?;
        }
        let keeper = BlockKeeper::open(keeping, job, &mut statistics)?;
        let mut blocks = keeper.first()..job.blocks().end;
        if targets.look(&statistics, job.paths).0 {
            blocks.end = blocks.start;
        }
        let rest = (blocks.end - blocks.start, job.paths.saturating_sub(blocks.start * PATHS));
        let size = piece::size(&job.wanted, PATHS, rest, job.goes_path_by_path(), threads);
        Ok(Self {
            wanted: &job.wanted,
            size,
            statistics,
            block: None,
            pieces: 0,
            keeper,
            targets,
            progress,
            limit: job.paths,
            allowed_losses,
            blocks,
            error: None,
        })
    }

    /// Paths in a piece of work: a block, or a part of one.
    pub(super) fn size(&self) -> u64 {
        self.size
    }

    /// The numbers of the pieces that are still to be done.
    pub(super) fn pieces(&self) -> Range<u64> {
        let last = self.limit.div_ceil(self.size);
        let of_blocks = |block: u64| (block * (PATHS / self.size)).min(last);
        of_blocks(self.blocks.start)..of_blocks(self.blocks.end)
    }

    /// The next piece, or why it has no result; breaks if that was the last one.
    pub(super) fn take(&mut self, piece: Result<Piece, Halt>) -> ControlFlow<()> {
        let block = match piece {
            Ok(piece) => piece.add_to(self.block.take(), self.wanted),
            Err(Halt::Stopped) => {
                self.statistics.is_partial = true;
                return ControlFlow::Break(());
            }
            Err(Halt::Failed(error)) => {
                self.error = Some(error);
                return ControlFlow::Break(());
            }
        };
        self.pieces += 1;
        let paths = self.blocks.start * PATHS + self.pieces * self.size;
        if paths < self.limit && !paths.is_multiple_of(PATHS) {
            self.block = Some(block);
            return ControlFlow::Continue(());
        }
        self.take_block(&block)
    }

    /// The next block; breaks if that was the last one.
    pub(super) fn take_block(&mut self, block: &Statistics) -> ControlFlow<()> {
        self.statistics.merge(block);
        (self.blocks.start, self.pieces) = (self.blocks.start + 1, 0);
        let (is_done, expected) = self.targets.look(&self.statistics, self.limit);
        self.progress.show(self.statistics.begun(), expected);
        self.error = self.keeper.done(self.blocks.start, &mut self.statistics).err();
        if is_done || self.error.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// What is known at the end.
    pub(super) fn close(mut self) -> Result<Statistics, Error> {
        if let Some(error) = self.error {
            return Err(error);
        }
        self.keeper.close(self.blocks.start, &mut self.statistics)?;
        let mut statistics = self.statistics;
        statistics.unsaved = self.keeper.unsaved();
        statistics.targets = self.targets.statuses(&statistics);
        match (statistics.last().map_or(0, StatisticsNode::count), statistics.failures().first()) {
            (0, Some(failure)) => Err(failure.error.into()),
            _ => Ok(unless_lost(statistics, self.allowed_losses)?),
        }
    }
}
