//! Checkpoints that could not be written.

use super::CheckpointError;
use crate::error::FileError;

/// Why the last checkpoint of a run could not be written, if it could not.
#[derive(Debug, Default)]
pub(super) struct Unsaved(Option<FileError>);

impl Unsaved {
    /// Notes what became of one. A run has more to lose than its checkpoint: it goes on.
    ///
    /// # Errors
    /// What no later attempt mends: the file is another run's, or a mistake of the library.
    pub(super) fn note(&mut self, outcome: Result<(), CheckpointError>) -> Result<(), CheckpointError> {
        match outcome {
            Ok(()) => self.0 = None,
            Err(CheckpointError::File(error)) => {
                if self.0.is_none() {
                    eprintln!(
                        "wzvi: {error}; the run goes on without this checkpoint, and tries again at the next one"
                    );
                }
                self.0 = Some(error);
            }
            Err(error) => return Err(error),
        }
        Ok(())
    }

    pub(super) fn error(&self) -> Option<FileError> {
        self.0.clone()
    }
}
