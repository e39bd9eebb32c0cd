//! How a run of many paths is carried out: none of it changes the result.

use crate::ensemble::InstructionSet;
use crate::error::ConfigError;
use crate::ground::handle::Handle;
use crate::ground::progress::ProgressLine;

/// What the user wants of a run besides its result.
pub(crate) struct Execution<'a> {
    pub(crate) threads: Option<usize>,
    pub(crate) stop: Option<Box<dyn Fn() -> bool + Send + Sync + 'a>>,
    pub(crate) is_quiet: bool,
    pub(crate) handle: Option<Handle>,
    pub(crate) instructions: InstructionSet,
}

impl Default for Execution<'_> {
    fn default() -> Self {
        Self {
            threads: None,
            stop: None,
            is_quiet: false,
            handle: None,
            instructions: InstructionSet::best(),
        }
    }
}

impl Execution<'_> {
    /// Those asked for, or all cores.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] for none.
    pub(crate) fn threads(&self) -> Result<usize, ConfigError> {
        crate::ensemble::schedule::threads(self.threads)
    }

    /// Whether the run is to end, because its handle or a function says so.
    pub(crate) fn is_stopped(&self) -> bool {
        self.handle.as_ref().is_some_and(Handle::is_stopped) || self.stop.as_ref().is_some_and(|stop| stop())
    }

    /// The line that shows how many of these are done.
    pub(crate) fn progress(&self, unit: &'static str) -> ProgressLine {
        ProgressLine::new(unit, self.is_quiet, self.handle.clone())
    }
}
