//! The settings of a run that were made: methods with a use for few of them refuse the others by name.
//!
//! Whoever adds a setting lists it once, in [`RunSetup::made`] or in that of the ensembles, and every such
//! method refuses it until it says that it has a use for it.
//!
//! Tested by `tests/paths/refused.rs`, `tests/paths/chaos.rs` and `tests/ensembles/chaos.rs`.

use crate::error::{ConfigError, wrong};
use crate::scheme::system::Hamiltonian;
use crate::trajectory::options::{Execution, RunSetup};
use crate::trajectory::recording::RecordingRequest;

/// A setting that some methods have no use for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MadeSetting {
    AllowLosses,
    Antithetic,
    Checkpoint,
    Covariances,
    Events,
    FirstPassage,
    Handle,
    Histogram,
    Inspect,
    KeepCrossings,
    KeepPaths,
    Observe,
    ObserveWork,
    /// Observables that read the system of a path, as temperatures do.
    OwnObservables,
    /// A noise that is not `StepNormals`.
    OtherNoise,
    Quantiles,
    RecordAt,
    RecordEvery,
    Retry,
    SecondObservable,
    Section,
    Starts,
    Statistic,
    StopWhen,
    Systems,
    UntilError,
    Unwatched,
}

impl MadeSetting {
    /// The name of the setting in an error: that of its method, where there is one.
    fn name(self) -> &'static str {
        match self {
            Self::AllowLosses => "`allow_losses`",
            Self::Antithetic => "`antithetic`",
            Self::Checkpoint => "`checkpoint`",
            Self::Covariances => "`covariances`",
            Self::Events => "`on` and `on_time`",
            Self::FirstPassage => "`first_passage`",
            Self::Handle => "`handle`",
            Self::Histogram => "`histogram`",
            Self::Inspect => "`inspect`",
            Self::KeepCrossings => "`keep_crossings`",
            Self::KeepPaths => "`keep_paths`",
            Self::Observe => "`observe`",
            Self::ObserveWork => "`observe_work`",
            Self::OwnObservables => "observables of each path's own system",
            Self::OtherNoise => "a noise that is not `StepNormals`",
            Self::Quantiles => "`quantiles`",
            Self::RecordAt => "`record_at`",
            Self::RecordEvery => "`record_every`",
            Self::Retry => "`retry`",
            Self::SecondObservable => "a second observable",
            Self::Section => "`section`",
            Self::Starts => "starts of each path",
            Self::Statistic => "`statistic`",
            Self::StopWhen => "`stop_when`",
            Self::Systems => "systems of each path",
            Self::UntilError => "`until_error`",
            Self::Unwatched => "`unwatched`",
        }
    }

    /// Refuses the first setting that was `made` and that the method with this name does not use.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] with the names of both.
    pub(crate) fn refuse(
        method: &str,
        mut made: impl Iterator<Item = Self>,
        used: &[Self],
    ) -> Result<(), ConfigError> {
        match made.find(|setting| !used.contains(setting)) {
            Some(setting) => wrong(format!("`{method}` has no use for {}: leave it out", setting.name())),
            None => Ok(()),
        }
    }
}

/// The settings among these that were made.
pub(crate) fn made<const N: usize>(settings: [(MadeSetting, bool); N]) -> impl Iterator<Item = MadeSetting> {
    settings.into_iter().filter_map(|(setting, is_made)| is_made.then_some(setting))
}

impl<H: Hamiltonian, M> RunSetup<'_, H, M> {
    /// The settings that were made of those that all runs of paths have.
    pub(crate) fn made(&self) -> impl Iterator<Item = MadeSetting> {
        let Self {
            system: _,
            h: _,
            span: _,
            recorded: RecordingRequest { every, times },
            observables,
            sections,
            events,
            retry,
            is_watched,
            execution: Execution { threads: _, stop, is_quiet: _, handle, instructions: _ },
            keeping,
            more: _,
        } = self;
        made([
            (MadeSetting::Observe, !observables.is_empty()),
            (MadeSetting::SecondObservable, observables.len() > 1),
            (MadeSetting::Section, !sections.is_empty()),
            (MadeSetting::Events, !events.is_empty()),
            (MadeSetting::RecordEvery, every.is_some()),
            (MadeSetting::RecordAt, !times.is_empty()),
            (MadeSetting::Retry, retry.most() > 0),
            (MadeSetting::Unwatched, !is_watched),
            (MadeSetting::Handle, handle.is_some()),
            (MadeSetting::StopWhen, stop.is_some()),
            (MadeSetting::Checkpoint, keeping.is_set()),
        ])
    }
}
