//! Long runs: checkpoints, and how a run resumes from one.
//!
//! [`Simulation::checkpoint`] saves the state of a run from time to time. A run may be stopped at any moment,
//! by a signal, a crash or a loss of power. Started again with the same settings, it resumes from its last
//! checkpoint. Its trajectory is bit for bit that of a run that was never stopped:
//!
//! ```ignore
//! let path = kepler
//!     .simulate::<Midpoint>(0.01)
//!     .start(State::new([0.5, 0.0], [0.0, 3.0_f64.sqrt()]))
//!     .steps(100_000_000)
//!     .record_every(0)
//!     .checkpoint(Checkpoint::to("kepler.wzvi").every_steps(1_000_000))
//!     .run()?;
//! ```
//!
//! # What happens to the file
//!
//! | The file | The run |
//! |---|---|
//! | does not exist | starts, and writes it before the first step, so that a folder that cannot be written to is an error at once |
//! | is of this run | continues from there |
//! | is of this run, which has finished | returns the same trajectory at once; with a later end, continues to it from the last whole step |
//! | is of another run, damaged, of another format, or no checkpoint | fails with a [`CheckpointError`]; the file is unchanged |
//!
//! Two runs are the same if they have the same system, parameters, scheme, step size, start, noise,
//! `record_every` and version of this crate. Sections are compared by their number, their directions and
//! their values at the start. Parameters are compared by the numbers that the step computes from them, and by
//! energies and forces at the start and at the checkpoint. Only the end may differ. To repeat a run from its
//! start, remove its file.
//!
//! A file has whole steps only. A run to an end inside a step takes the shorter last step again; a run to a
//! later end takes the whole step there, and the node at the earlier end is not one of its nodes: its path is
//! that of a run that never ended there.
//!
//! Bits are the same on every machine, as long as what the program itself computes is: `sin`, `exp` and the
//! like of `std`, in a closure for example, come from the platform.
//!
//! # Files
//!
//! A checkpoint is written to a temporary file in the same folder (`.wzvi-....part`), which is flushed to the
//! disk and then renamed; the folder is flushed after that. A process that is killed there leaves its
//! temporary file, which the next one removes. A symbolic link is followed and stays a link; a device, a pipe
//! or a folder is refused. The file has one line, `wzvi-checkpoint <version> <steps> <length>
//! <checksum>`, and `length` bytes: words of 64 bits, the least byte first. Recorded nodes ([`record_every`](Simulation::record_every) above 0)
//! are among them. Only one process at a time should use the file; one that finds it changed by another
//! leaves it alone.
//!
//! # Cost
//!
//! A checkpoint of a small system has about a kilobyte. It takes the time in which the disk confirms it,
//! about a millisecond on a solid-state disk. Between two checkpoints a step costs one comparison more. With
//! `d` degrees of freedom and `K` noises, a recorded node takes `8 (1 + 2 d + K)` bytes, as in memory, and
//! every checkpoint writes all of them, and the crossings of sections: record only what you need, or save
//! less often. `cargo run --release --example long_run -- cost` measures it.
//!
//! A checkpoint that cannot be written, for example on a full disk, in a folder that was removed, or because
//! another run changed the file, does not end the run. The run warns once on the standard error stream,
//! continues, and tries again at the next one. If the last one failed,
//! [`Trajectory::unsaved`](crate::trajectory::recorded::Trajectory::unsaved) or
//! [`Statistics::unsaved`](crate::ensemble::Statistics::unsaved) says why. The first one is written before
//! the first step, and must succeed.
//!
//! # Observers
//!
//! A checkpoint does not contain the data of an observer. The observer of a resumed run sees the nodes after
//! the checkpoint, with the sums of the increments from the start. Nodes between the last checkpoint and the
//! stop are seen twice.
//!
//! # Ensembles
//!
//! The checkpoint of an [`Ensemble`](crate::ensemble::Ensemble) holds the statistics of its first chunks of
//! paths, and a resumed run merges the others in the same order. The table and the guarantee above hold as
//! well. The file has its own kind (`wzvi-ensemble`). The number of paths may grow, unless starts are listed
//! or each path has its own system; an incomplete last chunk is run again.
//!
//! Observables and events are compared by their names and by their values at the start and at the next three
//! nodes of path 0. The file grows with the number of recorded times, observables and bins, and with that of
//! the paths only if they are kept.
//!
//! A [`Multilevel`](crate::ensemble::Multilevel) run saves the statistics of all its levels
//! (`wzvi-multilevel`), which are a few kilobytes. Its target and limits cannot change, since the numbers of
//! paths depend on them.
//!
//! # Sources of noise
//!
//! [`Wiener`](crate::noise::Wiener), [`WongZakai`](crate::noise::WongZakai) and given increments need no
//! state: the file identifies them, and they give the increments of step `n` as in a run that was never
//! stopped. A source of your own needs [`Noise::identity`](crate::increments::Noise::identity); without it,
//! runs take no checkpoints.

mod error;
mod format;
mod identity;
mod keeper;
mod run_identity;

use std::path::PathBuf;
use std::time::Duration;

use crate::error::{ConfigError, wrong};
use crate::scheme::system::Discretized;
use crate::trajectory::simulate::Simulation;
pub use error::{CheckpointError, Damage, Difference};
pub(crate) use format::CheckpointKind;
pub(crate) use keeper::CheckpointKeeper;
pub(crate) use keeper::{RunDescription, RunExtent};

/// The file of a checkpoint, and how often it is written: after some time, or after a number of what the run
/// counts. A [`Simulation`] counts steps, an [`Ensemble`](crate::ensemble::Ensemble) or
/// [`Multilevel`](crate::ensemble::Multilevel) run counts paths.
#[derive(Clone, Debug, PartialEq, Eq)]
#[must_use = "give it to the `checkpoint` of a `Simulation` or an `Ensemble`"]
pub struct Checkpoint {
    path: PathBuf,
    steps: Option<u64>,
    paths: Option<u64>,
    interval: Option<Duration>,
}

/// The default interval.
const MINUTE: Duration = Duration::from_secs(60);

impl Checkpoint {
    /// A checkpoint in this file, written once a minute by default.
    pub fn to(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), steps: None, paths: None, interval: None }
    }

    /// Saves at each node whose number is a multiple of `steps`, at least 1. For a [`Simulation`]; an
    /// ensemble refuses it.
    pub fn every_steps(self, steps: u64) -> Self {
        Self { steps: Some(steps), ..self }
    }

    /// Saves after every `paths` further paths, at least 1, in whole chunks of paths. For an ensemble; a
    /// single path refuses it.
    pub fn every_paths(self, paths: u64) -> Self {
        Self { paths: Some(paths), ..self }
    }

    /// When this time, more than zero, has passed since the last checkpoint. Together with
    /// [`Checkpoint::every_steps`] or [`Checkpoint::every_paths`], whichever comes first.
    pub fn every(self, interval: Duration) -> Self {
        Self { interval: Some(interval), ..self }
    }

    /// How many steps or paths are between two checkpoints of such a run, and how much time, as far as each
    /// matters.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] for a number of what the run does not count, and for nothing between two
    /// checkpoints.
    fn strides(&self, kind: CheckpointKind) -> Result<(Option<u64>, Option<Duration>), ConfigError> {
        let (count, other) = match kind {
            CheckpointKind::Path => (self.steps, self.paths),
            CheckpointKind::Ensemble | CheckpointKind::Multilevel => (self.paths, self.steps),
        };
        match (count, other, self.interval) {
            (_, Some(number), _) if kind == CheckpointKind::Path => wrong(format!(
                "`every_paths({number})` in the checkpoint of a single path, which counts steps: \
                 write `.every_steps(number)`, or `.every(interval)`"
            )),
            (_, Some(number), _) => wrong(format!(
                "`every_steps({number})` in the checkpoint of an ensemble, which counts paths: \
                 write `.every_paths(number)`, or `.every(interval)`"
            )),
            (Some(0), ..) => wrong("a checkpoint every 0 steps or paths; give at least 1"),
            (.., Some(Duration::ZERO)) => wrong("a checkpoint after no time at all; give more than zero"),
            (None, _, interval) => Ok((None, Some(interval.unwrap_or(MINUTE)))),
            (count, _, interval) => Ok((count, interval)),
        }
    }
}

/// The checkpoint of a run, if it has one.
#[derive(Clone, Debug, Default)]
pub(crate) struct CheckpointSetting(Option<Checkpoint>);

impl CheckpointSetting {
    pub(crate) fn to(checkpoint: Checkpoint) -> Self {
        Self(Some(checkpoint))
    }

    pub(crate) fn is_set(&self) -> bool {
        self.0.is_some()
    }
}

pub(crate) use identity::checksum;
pub(crate) use identity::sections;

impl<H: Discretized<E>, E, N, O, S> Simulation<'_, H, E, N, O, S> {
    /// Resumes from the checkpoint if its file exists and belongs to this run. Writes checkpoints during the
    /// run and at its end: see [`crate::trajectory::checkpoint`].
    pub fn checkpoint(self, checkpoint: Checkpoint) -> Self {
        self.keeping(CheckpointSetting::to(checkpoint))
    }
}
