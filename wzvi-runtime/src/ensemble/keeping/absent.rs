//! Without the feature `serde` no ensemble keeps anything.

use super::job::Job;
use crate::error::FileError;
use crate::path::Error;
use crate::path::checkpoint::Keeping;
use crate::scheme::system::Discretized;
use crate::statistics::Statistics;

/// Keeps nothing.
pub(super) struct ChunkKeeper;

impl ChunkKeeper {
    pub(super) fn open<H: Discretized<E>, E>(
        _keeping: Keeping,
        _job: &Job<'_, H, E>,
        _statistics: &mut Statistics,
    ) -> Result<Self, Error> {
        Ok(Self)
    }

    /// Every run starts with its first chunk.
    pub(super) fn first(&self) -> u64 {
        0
    }

    pub(super) fn done(&mut self, _chunks: u64, _statistics: &mut Statistics) -> Result<(), Error> {
        Ok(())
    }

    pub(super) fn unsaved(&self) -> Option<FileError> {
        None
    }

    pub(super) fn close(&mut self, _chunks: u64, _statistics: &mut Statistics) -> Result<(), Error> {
        Ok(())
    }
}
