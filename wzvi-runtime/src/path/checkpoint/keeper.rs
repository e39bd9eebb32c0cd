//! Opens the checkpoint of a run, and saves the run to it.

use super::Keeping;
use super::format::{self, Saved, Word, Words};
use super::identity::{self, Fields};
use super::nodes::Nodes;
use super::own::Own;
use super::unsaved::Unsaved;
use crate::algebra::carry::Carry;
use crate::algebra::state::Vector;
use crate::error::FileError;
use crate::error::{CheckpointError, Damage, Difference};
use crate::ground::due::Due;
use crate::ground::numbers::{Numbers, Tape};
use crate::increments::{Identity, Noise};
use crate::path::Error;
use crate::path::retry::Retry;
use crate::path::section::Sections;
use crate::path::simulate::Run;
use crate::path::span::Grid;
use crate::path::step::Stepper;
use crate::scheme::system::Discretized;

/// Saves a run, or does nothing.
#[derive(Debug)]
pub(crate) struct Keeper {
    first: u64,
    /// Not in this struct, which the loop of the run has at hand.
    file: Option<Box<Keep>>,
}

/// The files of a run.
#[derive(Debug)]
struct Keep {
    own: Own,
    due: Due,
    settings: Fields,
    derived: Fields,
    start: Words,
    nodes: Nodes,
    unsaved: Unsaved,
}

impl Keeping {
    /// Goes on from the checkpoint if there is one, else writes the first one. The arguments are those of a run at its
    /// start, with the nodes to go to, a `retry` and sections to name; they become those of the run at the checkpoint.
    pub(crate) fn open<H: Discretized<E>, E, C: Carry<f64>, N: Noise>(
        self,
        stepper: &mut Stepper<'_, H, E, C>,
        run: &mut Run<'_, '_, '_, H::Vector>,
        noise: Option<&N>,
        (grid, retry, sections): (&Grid, Retry, &Sections<'_, H::Vector>),
    ) -> Result<Keeper, Error> {
        let Self(Some(checkpoint)) = self else { return Ok(Keeper { first: 0, file: None }) };
        checkpoint.check()?;
        let noise = noise.map_or_else(|| Some(Identity::of("none")), N::identity);
        let noise = noise.ok_or(CheckpointError::Noise)?.into_settings();
        // That of the system, which may not know it before its first step.
        let (degrees, steps, state) = (run.state.q.components().len(), grid.steps, &mut *run.state);
        let own = Own::new(&checkpoint.path)?;
        let mut settings = identity::settings(stepper, degrees, run.recorder.recording(), retry, noise);
        settings.extend(identity::between(grid, sections, state));
        settings
            .extend(run.tally.as_ref().map(|tally| identity::averages(tally, state)).into_iter().flatten());
        let mut keep = Keep {
            due: Due::new(checkpoint.count, checkpoint.interval(), 0, steps),
            settings,
            derived: identity::derived(stepper.system(), stepper.prepared(), state),
            start: format::words(Tape::write(|tape| state.pass(tape))),
            nodes: Nodes::new(own.path(), degrees, stepper.system().increments(degrees)),
            own,
            unsaved: Unsaved::default(),
        };
        let first = match keep.own.read()? {
            Some(saved) => keep.restore(saved, steps, stepper, run)?,
            None => {
                keep.check_alone(run.recorder.recording().adds())?;
                keep.save(stepper, run, 0)?;
                0
            }
        };
        keep.own.remove_parts::<Saved>();
        keep.due = Due::new(checkpoint.count, checkpoint.interval(), first, steps);
        Ok(Keeper { first, file: Some(Box::new(keep)) })
    }
}

impl Keeper {
    /// The number of the step to start with.
    pub(crate) fn first(&self) -> u64 {
        self.first
    }

    /// Whether it keeps anything.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn keeps(&self) -> bool {
        self.file.is_some()
    }

    /// The next node at which it may be time to save.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn next(&self) -> u64 {
        self.file.as_ref().map_or(u64::MAX, |file| file.due.next())
    }

    /// Whether to save at `node`, the number of steps taken.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn is_due(&mut self, node: u64) -> bool {
        self.file.as_mut().is_some_and(|file| file.due.is_due(node))
    }

    /// Saves the run at `node`.
    #[cold]
    #[inline(never)]
    pub(crate) fn save<H: Discretized<E>, E, C: Carry<f64>>(
        &mut self,
        stepper: &mut Stepper<'_, H, E, C>,
        run: &mut Run<'_, '_, '_, H::Vector>,
        node: u64,
    ) -> Result<(), Error> {
        if let Some(file) = &mut self.file {
            let outcome = file.save(stepper, run, node);
            file.due.done();
            file.unsaved.note(outcome)?;
        }
        Ok(())
    }

    /// Why the last checkpoint could not be written.
    pub(crate) fn unsaved(&self) -> Option<FileError> {
        self.file.as_ref().and_then(|file| file.unsaved.error())
    }
}

impl Keep {
    /// Nodes without a checkpoint are someone's: this run writes its first checkpoint before its first node.
    fn check_alone(&self, records: bool) -> Result<(), CheckpointError> {
        let nodes = self.nodes.path();
        let is_there = records && nodes.try_exists().map_err(CheckpointError::file(nodes, "read"))?;
        match is_there {
            true => {
                Err(CheckpointError::Orphan { nodes: nodes.to_owned(), path: self.own.path().to_owned() })
            }
            false => Ok(()),
        }
    }

    /// Brings a run from its start to where it was saved; the number of that node.
    fn restore<H: Discretized<E>, E, C: Carry<f64>>(
        &mut self,
        saved: Saved,
        steps: u64,
        stepper: &mut Stepper<'_, H, E, C>,
        run: &mut Run<'_, '_, '_, H::Vector>,
    ) -> Result<u64, CheckpointError> {
        let Run { state, recorder, wiener: path, looks, watch, tally } = run;
        self.compare(&saved, state.q.components().len())?;
        let step = saved.step;
        if step > steps {
            return Err(CheckpointError::Beyond { path: self.own.path().to_owned(), step, steps });
        }
        let expected = recorder.recording().nodes(step);
        let parts = (saved.nodes == expected)
            .then_some(())
            .and_then(|()| Tape::read(format::bits(&saved.state), |tape| state.pass(tape)))
            .and_then(|()| Tape::read(format::bits(&saved.stepper), |tape| stepper.pass(tape)))
            .and_then(|()| {
                Tape::read(format::bits(&saved.recorder), |tape| {
                    recorder.pass(tape);
                    looks.iter_mut().for_each(|looks| looks.pass(recorder, tape));
                    watch.pass(tape);
                    tally.iter_mut().for_each(|tally| tally.pass(tape));
                })
            })
            .and_then(|()| Tape::read(format::bits(&saved.wiener), |tape| path.pass(tape)));
        if parts.is_none() {
            let damage = Damage::Content("a part of it has the wrong length".to_owned());
            return Err(CheckpointError::damaged(self.own.path(), damage));
        }
        let forces = identity::forces(stepper.system(), state);
        if forces != saved.forces {
            let field = identity::forces_at("checkpoint");
            let difference = Difference { field, checkpoint: Some(saved.forces), run: Some(forces) };
            return Err(self.own.other_run(vec![difference]));
        }
        self.nodes.read(saved.nodes, saved.nodes_checksum.0, recorder)?;
        Ok(step)
    }

    /// Whether the file is of this run: what the user set comes first, because the rest follows from it.
    fn compare(&self, saved: &Saved, degrees: usize) -> Result<(), CheckpointError> {
        let mut differences = identity::differences(&saved.settings, &self.settings);
        differences.extend(identity::start_differences(degrees, &saved.start, &self.start));
        if differences.is_empty() {
            differences = identity::differences(&saved.derived, &self.derived);
        }
        if differences.is_empty() { Ok(()) } else { Err(self.own.other_run(differences)) }
    }

    /// Nodes first: a checkpoint is never ahead of them.
    fn save<H: Discretized<E>, E, C: Carry<f64>>(
        &mut self,
        stepper: &mut Stepper<'_, H, E, C>,
        run: &mut Run<'_, '_, '_, H::Vector>,
        step: u64,
    ) -> Result<(), CheckpointError> {
        let Run { state, recorder, wiener: path, looks, watch, tally } = run;
        self.own.check_ours()?;
        self.nodes.append(recorder)?;
        let (nodes, checksum) = self.nodes.written();
        let saved = Saved {
            settings: self.settings.clone(),
            derived: self.derived.clone(),
            start: self.start.clone(),
            step,
            forces: identity::forces(stepper.system(), state),
            state: format::words(Tape::write(|tape| state.pass(tape))),
            stepper: format::words(Tape::write(|tape| stepper.pass(tape))),
            recorder: format::words(Tape::write(|tape| {
                recorder.pass(tape);
                looks.iter_mut().for_each(|looks| looks.pass(recorder, tape));
                watch.pass(tape);
                tally.iter_mut().for_each(|tally| tally.pass(tape));
            })),
            wiener: format::words(Tape::write(|tape| path.pass(tape))),
            nodes,
            nodes_checksum: Word(checksum),
        };
        self.own.write(&saved)
    }
}
