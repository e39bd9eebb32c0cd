//! Opens the checkpoint of a run, and saves the run to it.

use std::io::Read;
use std::path::PathBuf;

use super::CheckpointSetting;
use super::format::{self, CheckpointKind, Encoded, Saved};
use super::identity::{self, Fields};
use crate::algebra::state::{State, Vector};
use crate::ground::due::Due;
use crate::ground::numbers::{Tape, numbers};
use crate::saving::FileError;
use crate::saving::file::{self, Staged};
use crate::scheme::system::{Discretized, PreparedOf};
use crate::trajectory::Error;
use crate::trajectory::checkpoint::{CheckpointError, Difference};

/// The identity of a run: two runs with equal descriptions are the same.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RunDescription {
    /// The settings of the user, by name.
    settings: Fields,
    /// Checksums of what follows from that, by name.
    derived: Fields,
    /// The first state: `t`, `q`, `p`.
    start: Vec<u64>,
    /// Checksums of the states where paths 0, 1, ... start, of a function that gives each path its own: of as
    /// many as are compared.
    starts: Vec<u64>,
}

numbers! { impl[] Numbers for RunDescription { kept: settings, derived, start, starts } }

impl RunDescription {
    /// A run from `start` in steps of size `h`, with the settings of its kind.
    pub(crate) fn of<H: Discretized<E>, E>(
        system: &H,
        prepared: &PreparedOf<H, E>,
        h: f64,
        start: &State<H::Vector>,
        settings: Fields,
    ) -> Self {
        let mut all = identity::scheme::<H, E>(system, start.q.components().len(), h);
        all.extend(identity::parameters(system));
        all.extend(settings);
        let (derived, mut start) = (identity::derived(system, prepared, start), start.clone());
        Self { settings: all, derived, start: Tape::write(|tape| start.pass(tape)), starts: Vec::new() }
    }

    /// Adds a setting to the description of the run.
    pub(crate) fn add(&mut self, name: &str, value: &str) {
        self.settings.push((name.to_owned(), value.to_owned()));
    }

    /// And with these checksums of the states where paths start.
    pub(crate) fn starting(mut self, starts: Vec<u64>) -> Self {
        self.starts = starts;
        self
    }

    /// And with observables of these values at some states: functions cannot be compared.
    pub(crate) fn observing(mut self, values: &[f64]) -> Self {
        let observed = identity::checksum(values.iter().map(|number| number.to_bits()));
        self.derived.push(("what the observables and events are on path 0 (checksum)".to_owned(), observed));
        self
    }

    /// The differences, the user's settings first, because others follow from them.
    fn differences(&self, saved: &Self) -> Vec<Difference> {
        let mut differences = identity::differences(&saved.settings, &self.settings);
        differences.extend(identity::start_differences(self.start.len() / 2, &saved.start, &self.start));
        // The run may have more paths than the file, or fewer: those of both are compared.
        let both = saved.starts.iter().zip(&self.starts).enumerate();
        differences.extend(both.filter(|(_, (there, here))| there != here).take(1).map(
            |(path, (there, here))| {
                let [checkpoint, run] = [there, here].map(|checksum| Some(format!("{checksum:016x}")));
                Difference { field: format!("the start of path {path} (checksum)"), checkpoint, run }
            },
        ));
        if differences.is_empty() {
            differences = identity::differences(&saved.derived, &self.derived);
        }
        differences
    }

    /// All of it, and the number of paths, a line each.
    #[cfg(feature = "mpi")]
    pub(crate) fn lines(&self, paths: u64) -> Vec<String> {
        let fields = self.settings.iter().chain(&self.derived);
        let mut lines = vec![format!("the number of paths: {paths}")];
        lines.extend(fields.map(|(name, value)| format!("{name}: {value}").replace('\n', " ")));
        lines.push(format!(
            "the starts of paths (checksum): {}",
            identity::checksum(self.starts.iter().copied())
        ));
        let start: Vec<f64> = self.start.iter().copied().map(f64::from_bits).collect();
        lines.push(format!("t, q, p of the start: {start:?}"));
        lines
    }
}

/// How far a run goes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RunExtent {
    pub(crate) kind: CheckpointKind,
    /// Steps, or paths.
    pub(crate) all: u64,
    /// How many of them are done at once.
    pub(crate) unit: u64,
}

impl RunExtent {
    /// Units that can be saved. A last chunk of paths that is not whole never is, so that a run of more paths
    /// can go on.
    fn end(self) -> u64 {
        self.all / self.unit
    }
}

/// Saves a run, or does nothing.
#[derive(Debug, Default)]
pub(crate) struct CheckpointKeeper {
    first: u64,
    /// Not in this struct, which the loop of the run has at hand.
    file: Option<Box<RunFile>>,
}

/// The file of one run: read once, then replaced again and again, unless someone else changes it.
#[derive(Debug)]
struct RunFile {
    extent: RunExtent,
    /// The path behind symbolic links: a run that names the file in another way finds the same one.
    path: PathBuf,
    /// The first line of the file as this run left it; `None` before there is one.
    line: Option<Vec<u8>>,
    described: RunDescription,
    saved: u64,
    due: Due,
    /// Why the last checkpoint could not be written, if it could not.
    unsaved: Option<FileError>,
}

impl CheckpointSetting {
    /// Continues from the checkpoint if there is one, else writes the first one. `pass` passes the data of
    /// the run: those of the start before the call, those of the checkpoint afterwards.
    pub(crate) fn open(
        self,
        extent: RunExtent,
        described: RunDescription,
        pass: &mut dyn FnMut(&mut Tape),
    ) -> Result<CheckpointKeeper, Error> {
        let Self(Some(checkpoint)) = self else { return Ok(CheckpointKeeper::default()) };
        let (count, interval) = checkpoint.strides(extent.kind)?;
        let every = count.map(|count| count.div_ceil(extent.unit));
        let due = |first| Due::new(every, interval, first, extent.end());
        let path = file::Target::of(&checkpoint.path, "write").map_err(CheckpointError::from)?.into_path();
        let mut kept = RunFile { extent, path, line: None, described, saved: 0, due: due(0), unsaved: None };
        match kept.read()? {
            Some(saved) => kept.restore(saved, pass)?,
            None => kept.save(0, pass)?,
        }
        file::remove_parts(&kept.path, extent.kind.magic().as_bytes());
        kept.due = due(kept.saved);
        Ok(CheckpointKeeper { first: kept.saved, file: Some(Box::new(kept)) })
    }
}

impl CheckpointKeeper {
    /// The step or chunk to start with.
    pub(crate) fn first(&self) -> u64 {
        self.first
    }

    /// Whether it keeps anything.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn keeps(&self) -> bool {
        self.file.is_some()
    }

    /// When it may be time to save next.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn next_node(&self) -> u64 {
        self.file.as_ref().map_or(u64::MAX, |file| file.due.next_node())
    }

    /// Whether to save when so much is done.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn is_due(&mut self, done: u64) -> bool {
        self.file.as_mut().is_some_and(|file| done <= file.extent.end() && file.due.is_due(done))
    }

    /// Saves the run. If the checkpoint cannot be written, the run continues, because ending it would lose
    /// more.
    ///
    /// # Errors
    /// A bug of the library.
    #[cold]
    #[inline(never)]
    pub(crate) fn save(&mut self, done: u64, pass: &mut dyn FnMut(&mut Tape)) -> Result<(), Error> {
        let Some(file) = &mut self.file else { return Ok(()) };
        let outcome = file.save(done, pass);
        file.due.done();
        let error = match outcome {
            Ok(()) => None,
            Err(CheckpointError::File(error)) => Some(error),
            Err(CheckpointError::Taken { path }) => Some(FileError::Taken { path }),
            Err(error) => return Err(error.into()),
        };
        let before = std::mem::replace(&mut file.unsaved, error);
        if let (None, Some(error)) = (before, &file.unsaved) {
            eprintln!(
                "wzvi: {error}; the run goes on without this checkpoint, and tries again at the next one"
            );
        }
        Ok(())
    }

    /// So much is done, and no more will be: saves it if it is not.
    pub(crate) fn close(&mut self, done: u64, pass: &mut dyn FnMut(&mut Tape)) -> Result<(), Error> {
        match &self.file {
            Some(file) if done <= file.extent.end() && done > file.saved => self.save(done, pass),
            _ => Ok(()),
        }
    }

    /// The error for a difference that is found after the file was opened.
    pub(super) fn other_run(&self, difference: Difference) -> CheckpointError {
        let path = self.file.as_ref().map_or_else(PathBuf::new, |file| file.path.clone());
        CheckpointError::OtherRun { path, differences: vec![difference] }
    }

    /// Why the last checkpoint could not be written.
    pub(crate) fn unsaved(&self) -> Option<FileError> {
        self.file.as_ref().and_then(|file| file.unsaved.clone())
    }
}

impl RunFile {
    /// The contents of the file; `None` if there is no file.
    fn read(&mut self) -> Result<Option<Saved>, CheckpointError> {
        let Some(mut file) = file::open(&self.path)? else { return Ok(None) };
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(CheckpointError::file(&self.path, "read"))?;
        let (line, saved) = format::decode(self.extent.kind, &self.path, &bytes);
        self.line = Some(line);
        saved.map(Some)
    }

    /// Brings a run from its start to where it was saved.
    fn restore(&mut self, saved: Saved, pass: &mut dyn FnMut(&mut Tape)) -> Result<(), CheckpointError> {
        let (path, differences) = (self.path.clone(), self.described.differences(&saved.run));
        if !differences.is_empty() {
            return Err(CheckpointError::OtherRun { path, differences });
        }
        if saved.done > self.extent.end() {
            let RunExtent { kind, all, .. } = self.extent;
            return Err(match kind {
                CheckpointKind::Path => CheckpointError::Beyond { path, step: saved.done, steps: all },
                CheckpointKind::Ensemble | CheckpointKind::Multilevel => {
                    let done = saved.done.saturating_mul(self.extent.unit);
                    CheckpointError::MorePaths { path, done, paths: all }
                }
            });
        }
        let damaged = || CheckpointError::Damaged { path, damage: format::nonsense() };
        Tape::read(saved.content, pass).ok_or_else(damaged)?;
        self.saved = saved.done;
        Ok(())
    }

    fn save(&mut self, done: u64, pass: &mut dyn FnMut(&mut Tape)) -> Result<(), CheckpointError> {
        self.check_ours()?;
        let mut saved = Saved { run: self.described.clone(), done, content: Tape::write(pass) };
        let encoded = Encoded::new(self.extent.kind, &mut saved);
        let staged = Staged::write(&self.path, |file| encoded.write(file))?;
        // Once more: the disk may have taken its time.
        self.check_ours()?;
        staged.publish()?;
        (self.line, self.saved) = (Some(encoded.line), done);
        Ok(())
    }

    /// Whether the file is as this run left it, or gone: nothing of another run is replaced.
    fn check_ours(&self) -> Result<(), CheckpointError> {
        let is_ours = match (&self.line, file::open(&self.path)?) {
            (_, None) => true,
            (Some(line), Some(file)) => {
                let mut start = Vec::with_capacity(line.len());
                let read = file.take(line.len() as u64).read_to_end(&mut start);
                read.map_err(CheckpointError::file(&self.path, "read"))?;
                start == *line
            }
            (None, Some(_)) => false,
        };
        if is_ours { Ok(()) } else { Err(CheckpointError::Taken { path: self.path.clone() }) }
    }
}
