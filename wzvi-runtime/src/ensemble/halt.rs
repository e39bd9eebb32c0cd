//! Why a block of paths has no result.

use crate::path::Error;

/// What ends a block of paths early.
#[derive(Debug)]
pub(super) enum Halt {
    /// Whoever asked for it wants no more.
    Stopped,
    /// The run cannot go on.
    Failed(Error),
}

impl From<Error> for Halt {
    fn from(error: Error) -> Self {
        Self::Failed(error)
    }
}
