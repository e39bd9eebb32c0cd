//! The checkpoint of an ensemble: what is known of its first blocks of paths.
//!
//! Blocks are merged in the order of their numbers, so that what is known of the first `n` is all that the others need: a
//! run that goes on merges the same blocks in the same order as one that was never stopped.

use serde::{Deserialize, Serialize};

use super::Keeping;
use super::format::{self, Content, Words};
use super::identity::{self, Fields};
use super::own::Own;
use super::unsaved::Unsaved;
use crate::algebra::state::{State, Vector};
use crate::error::FileError;
use crate::error::{CheckpointError, Damage};
use crate::ground::due::Due;
use crate::ground::numbers::Tape;
use crate::path::Error;
use crate::scheme::system::{Discretized, PreparedOf};

/// An ensemble after some of its blocks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SavedBlocks {
    /// What the user set, by name.
    settings: Fields,
    /// Checksums of what follows from that, by name.
    derived: Fields,
    /// The first state of every path: `t`, `q`, `p`.
    start: Words,
    /// Whole blocks that are done.
    blocks: u64,
    /// What is known of them.
    statistics: Words,
}

impl Content for SavedBlocks {
    const MAGIC: &'static str = "wzvi-ensemble ";
}

/// What makes two ensembles the same.
pub(crate) struct Described {
    settings: Fields,
    derived: Fields,
    start: Words,
    degrees: usize,
}

impl Described {
    /// `settings` are those that only ensembles have, `observed` what the observables are at some states.
    pub(crate) fn new<H: Discretized<E>, E>(
        system: &H,
        prepared: &PreparedOf<H, E>,
        h: f64,
        start: &State<H::Vector>,
        settings: Fields,
        observed: &[f64],
    ) -> Self {
        let degrees = start.q.components().len();
        let mut all = identity::scheme::<H, E>(system, degrees, h);
        all.extend(identity::parameters(system));
        all.extend(settings);
        let mut derived = identity::derived(system, prepared, start);
        let observed = identity::checksum(observed.iter().map(|number| number.to_bits()));
        derived.push(("what the observables and events are on path 0 (checksum)".to_owned(), observed));
        let mut start = start.clone();
        let start = format::words(Tape::write(|tape| start.pass(tape)));
        Self { settings: all, derived, start, degrees }
    }
}

#[cfg(feature = "mpi")]
impl Described {
    /// All of it, and the number of paths, a line each.
    pub(crate) fn lines(&self, paths: u64) -> Vec<String> {
        let fields = self.settings.iter().chain(&self.derived);
        let mut lines = vec![format!("the number of paths: {paths}")];
        lines.extend(fields.map(|(name, value)| format!("{name}: {value}").replace('\n', " ")));
        let start: Vec<f64> = format::bits(&self.start).into_iter().map(f64::from_bits).collect();
        lines.push(format!("t, q, p of the start: {start:?}"));
        lines
    }
}

/// Saves an ensemble, or does nothing.
pub(crate) struct BlockKeeper(Option<Keep>);

struct Keep {
    own: Own,
    described: Described,
    first: u64,
    /// Those that the file has.
    saved: u64,
    /// Whole blocks of the run.
    blocks: u64,
    due: Due,
    unsaved: Unsaved,
}

/// The paths of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    pub(crate) paths: u64,
    pub(crate) block: u64,
}

impl Keeping {
    /// Goes on from the checkpoint if there is one, else writes the first one: `pass` shows what is known, of no path
    /// before and of the first blocks afterwards.
    pub(crate) fn open_blocks(
        self,
        described: impl FnOnce() -> Result<Described, Error>,
        extent: Extent,
        mut pass: impl FnMut(&mut Tape),
    ) -> Result<BlockKeeper, Error> {
        let Self(Some(checkpoint)) = self else { return Ok(BlockKeeper(None)) };
        checkpoint.check()?;
        let (every, interval) =
            (checkpoint.count.map(|paths| paths.div_ceil(extent.block)), checkpoint.interval());
        let blocks = extent.paths / extent.block;
        let mut keep = Keep {
            own: Own::new(&checkpoint.path)?,
            described: described()?,
            first: 0,
            saved: 0,
            blocks,
            due: Due::new(every, interval, 0, blocks),
            unsaved: Unsaved::default(),
        };
        match keep.own.read()? {
            Some(saved) => keep.restore(saved, extent, pass)?,
            None => keep.save(0, &mut pass)?,
        }
        keep.own.remove_parts::<SavedBlocks>();
        keep.due = Due::new(every, interval, keep.first, blocks);
        Ok(BlockKeeper(Some(keep)))
    }
}

impl BlockKeeper {
    /// The number of the block to start with.
    pub(crate) fn first(&self) -> u64 {
        self.0.as_ref().map_or(0, |keep| keep.first)
    }

    /// So many blocks are done: saves them if it is time. A last block that is not whole is never saved, so that a run of
    /// more paths can go on.
    pub(crate) fn done(&mut self, blocks: u64, pass: impl FnMut(&mut Tape)) -> Result<(), CheckpointError> {
        let Some(keep) = &mut self.0 else { return Ok(()) };
        if blocks <= keep.blocks && keep.due.is_due(blocks) { keep.try_to_save(blocks, pass) } else { Ok(()) }
    }

    /// So many blocks are done, and no others will be: saves them if they are not.
    pub(crate) fn close(&mut self, blocks: u64, pass: impl FnMut(&mut Tape)) -> Result<(), CheckpointError> {
        match &mut self.0 {
            Some(keep) if blocks <= keep.blocks && blocks > keep.saved => keep.try_to_save(blocks, pass),
            _ => Ok(()),
        }
    }

    /// Why the last checkpoint could not be written.
    pub(crate) fn unsaved(&self) -> Option<FileError> {
        self.0.as_ref().and_then(|keep| keep.unsaved.error())
    }
}

impl Keep {
    fn restore(
        &mut self,
        saved: SavedBlocks,
        extent: Extent,
        pass: impl FnMut(&mut Tape),
    ) -> Result<(), CheckpointError> {
        self.compare(&saved)?;
        let path = || self.own.path().to_owned();
        if saved.blocks > self.blocks {
            let done = saved.blocks.saturating_mul(extent.block);
            return Err(CheckpointError::MorePaths { path: path(), done, paths: extent.paths });
        }
        Tape::read(format::bits(&saved.statistics), pass).ok_or_else(|| {
            let damage = Damage::Content("what is known of the paths has the wrong length".to_owned());
            CheckpointError::Damaged { path: path(), damage }
        })?;
        (self.first, self.saved) = (saved.blocks, saved.blocks);
        Ok(())
    }

    /// Whether the file is of this run: what the user set comes first, because the rest follows from it.
    fn compare(&self, saved: &SavedBlocks) -> Result<(), CheckpointError> {
        let Described { settings, derived, start, degrees } = &self.described;
        let mut differences = identity::differences(&saved.settings, settings);
        differences.extend(identity::start_differences(*degrees, &saved.start, start));
        if differences.is_empty() {
            differences = identity::differences(&saved.derived, derived);
        }
        if differences.is_empty() { Ok(()) } else { Err(self.own.other_run(differences)) }
    }

    fn try_to_save(&mut self, blocks: u64, pass: impl FnMut(&mut Tape)) -> Result<(), CheckpointError> {
        let outcome = self.save(blocks, pass);
        self.due.done();
        self.unsaved.note(outcome)
    }

    fn save(&mut self, blocks: u64, pass: impl FnMut(&mut Tape)) -> Result<(), CheckpointError> {
        self.own.check_ours()?;
        let Described { settings, derived, start, .. } = &self.described;
        self.own.write(&SavedBlocks {
            settings: settings.clone(),
            derived: derived.clone(),
            start: start.clone(),
            blocks,
            statistics: format::words(Tape::write(pass)),
        })?;
        self.saved = blocks;
        Ok(())
    }
}
