//! The identity of a single path, for its checkpoint.

use super::format::CheckpointKind;
use super::identity;
use super::keeper::{CheckpointKeeper, RunDescription, RunExtent};
use super::{CheckpointError, CheckpointSetting, Difference};
use crate::algebra::state::State;
use crate::algebra::state_sum::StateSum;
use crate::ground::numbers::{Numbers, Tape};
use crate::increments::{Identity, Noise};
use crate::scheme::system::Discretized;
use crate::trajectory::Error;
use crate::trajectory::retry::{Retry, Subdivision};
use crate::trajectory::section::Sections;
use crate::trajectory::simulate::{Observer, OnePath, RunRecords, RunState};
use crate::trajectory::span::NodeGrid;

impl CheckpointSetting {
    /// Goes on from the checkpoint if there is one, else writes the first one. The arguments are those of a
    /// run at its start, with the nodes to go to, a `retry` and sections to name; they become those of the
    /// run at the checkpoint.
    pub(crate) fn open_path<H: Discretized<E>, E, N: Noise, C: StateSum<f64>>(
        self,
        path: &mut OnePath<'_, '_, H, E, N, C>,
        run: &mut RunState<'_, '_, impl Observer<H::Vector>, H::Vector>,
        grid: &NodeGrid,
        retry: Retry,
        sections: &Sections<'_, H::Vector>,
        events: &str,
    ) -> Result<CheckpointKeeper, Error> {
        if !self.is_set() {
            return Ok(CheckpointKeeper::default());
        }
        let mut described = described(path, run, retry, sections)?;
        if !events.is_empty() {
            described.add("the events", events);
        }
        let (extent, mut forces) =
            (RunExtent { kind: CheckpointKind::Path, all: grid.whole(), unit: 1 }, String::new());
        let keeper =
            self.open(extent, described, &mut |tape| forces = pass(path.stepper, path.state, run, tape))?;
        // The forces at the state that was read, or at the start, which was written.
        let found = identity::forces(path.stepper.stepper.system(), path.state);
        if forces != found {
            let field = identity::forces_at("checkpoint");
            let difference = Difference { field, checkpoint: Some(forces), run: Some(found) };
            return Err(keeper.other_run(difference).into());
        }
        Ok(keeper)
    }
}

impl CheckpointKeeper {
    /// Saves a path at `node`.
    pub(crate) fn save_path<H: Discretized<E>, E, N: Noise, C: StateSum<f64>>(
        &mut self,
        path: &mut OnePath<'_, '_, H, E, N, C>,
        run: &mut RunState<'_, '_, impl Observer<H::Vector>, H::Vector>,
        node: u64,
    ) -> Result<(), Error> {
        self.save(node, &mut |tape| drop(pass(path.stepper, path.state, run, tape)))
    }
}

/// The description that distinguishes a path from others.
fn described<H: Discretized<E>, E, N: Noise, C: StateSum<f64>>(
    path: &OnePath<'_, '_, H, E, N, C>,
    run: &RunState<'_, '_, impl Observer<H::Vector>, H::Vector>,
    retry: Retry,
    sections: &Sections<'_, H::Vector>,
) -> Result<RunDescription, CheckpointError> {
    let noise = path.noise.as_ref().map_or_else(|| Some(Identity::of("none")), N::identity);
    let noise = noise.ok_or(CheckpointError::Noise)?.into_settings();
    let (stepper, state) = (&path.stepper.stepper, &*path.state);
    let mut settings = identity::settings(run.account.recorder.recording(), retry, stepper.is_compensated());
    settings.extend(noise);
    settings.extend(identity::sections(sections, state));
    settings.extend(run.observer.described(state));
    Ok(RunDescription::of(stepper.system(), stepper.prepared(), stepper.step_size(), state, settings))
}

/// All that steps change; the checksum of energies and forces that goes with it.
fn pass<H: Discretized<E>, E, C: StateSum<f64>>(
    Subdivision { stepper, watch, following, .. }: &mut Subdivision<'_, H, E, C>,
    state: &mut State<H::Vector>,
    run: &mut RunState<'_, '_, impl Observer<H::Vector>, H::Vector>,
    tape: &mut Tape,
) -> String {
    let RunState { observer, account: RunRecords { recorder, wiener, .. }, looks } = run;
    let mut forces = identity::forces(stepper.system(), state);
    forces.pass(tape);
    state.pass(tape);
    stepper.pass(tape);
    recorder.pass(tape);
    looks.iter_mut().for_each(|looks| looks.pass(recorder, tape));
    watch.pass(state, tape);
    following.iter_mut().for_each(|following| following.pass(state, tape));
    observer.pass(tape);
    wiener.pass(tape);
    forces
}
