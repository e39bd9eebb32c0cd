//! What is known of the blocks that are done, and its checkpoint.

use std::ops::{ControlFlow, Range};

use super::job::Job;
use super::keeping::BlockKeeper;
use super::statistics::{Node, Statistics};
use crate::checkpoint::Keeping;
use crate::error::Error;
use crate::system::Discretized;

/// Takes the blocks of a run in the order of their numbers.
pub(super) struct Account {
    statistics: Statistics,
    keeper: BlockKeeper,
    /// Those that are still to be done.
    blocks: Range<u64>,
    error: Option<Error>,
}

impl Account {
    /// With the blocks of the checkpoint, if there is one.
    pub(super) fn open<H, E>(job: &Job<'_, H, E>, keeping: Keeping) -> Result<Self, Error>
    where
        H: Discretized<E> + Sync,
        H::Vector: Send + Sync,
        H::Prepared: Send + Sync,
    {
        let mut statistics = Statistics::new(&job.wanted);
        if let Some(paths) = &mut statistics.paths {
            paths.reserve(job.paths)?;
        }
        let keeper = BlockKeeper::open(keeping, job, &mut statistics)?;
        let blocks = keeper.first()..job.blocks().end;
        Ok(Self { statistics, keeper, blocks, error: None })
    }

    /// The numbers of the blocks that are still to be done.
    pub(super) fn blocks(&self) -> Range<u64> {
        self.blocks.clone()
    }

    /// One more block, the next one.
    pub(super) fn take(&mut self, block: &Statistics) -> ControlFlow<()> {
        self.statistics.merge(block);
        self.blocks.start += 1;
        match self.keeper.done(self.blocks.start, &mut self.statistics) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.error = Some(error);
                ControlFlow::Break(())
            }
        }
    }

    /// What is known at the end.
    pub(super) fn close(self) -> Result<Statistics, Error> {
        let Self { statistics, error, .. } = self;
        if let Some(error) = error {
            return Err(error);
        }
        match (statistics.last().map_or(0, Node::count), statistics.failures().first()) {
            (0, Some(failure)) => Err(failure.error.into()),
            _ => Ok(statistics),
        }
    }
}
