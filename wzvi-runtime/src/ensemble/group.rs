//! A group of paths of an ensemble: as many as there are lanes in a vector register.
//!
//! ```text
//! Coupled                    beside each path a coarser one, of a multilevel run
//!   Group                    the paths, their increments and failures
//!     Watched                ends paths whose energy has changed
//!       Halving              halves steps that a path could not take, or ends it
//!         InLanes            all paths in one step, in lanes: or, where they cannot (`NotInLanes`),
//!         BySteppers         each by a stepper
//! ```
//!
//! [`StepPaths`] is what the last two have in common.
//!
//! Tested by `tests/ensembles/alone.rs`, `tests/ensembles/runs.rs` and `tests/bits.rs`.

mod by_steppers;
mod coupled;
mod halving;
mod in_lanes;
mod memories;
mod paths;
mod steps;
mod watched;

pub(super) use by_steppers::BySteppers;
pub(super) use coupled::Coupled;
use halving::PathStep;
pub(super) use halving::SeeInside;
pub(super) use in_lanes::InLanes;
pub(super) use paths::LanePaths;
use steps::DrivenPaths;
pub(super) use steps::StepPaths;
use watched::Watched;

use super::increments::LaneIncrements;
use super::job::EnsembleJob;
use crate::algebra::scalar::Scalar;
use crate::algebra::state::{State, copy_state};
use crate::error::InternalError;
use crate::increments::Interval;
use crate::scheme::dense::DenseOutput;
use crate::scheme::system::{Discretized, Exchange, Scheme, SchemeOf};
use crate::trajectory::Error;
use crate::trajectory::step::Exchanged;

/// `L` paths of a job, and how their steps are taken.
pub(super) struct Group<'j, 'a, H: Discretized<E>, E, T, const L: usize> {
    job: &'j EnsembleJob<'a, H, E>,
    pub(super) paths: DrivenPaths<'j, L>,
    steps: Watched<'j, 'a, H, E, T, L>,
    /// Increments of one lane.
    dw: Vec<f64>,
    /// The end of a step of one lane.
    after: State<H::Vector>,
}

impl<'j, 'a, H, E, T, const L: usize> Group<'j, 'a, H, E, T, L>
where
    H: Discretized<E>,
    T: StepPaths<'j, H, E, L>,
{
    /// The paths of a job, whose steps are taken by `steps`.
    pub(super) fn new(job: &'j EnsembleJob<'a, H, E>, steps: T) -> Self {
        // The number of processes of the system, which may not know it.
        let processes = job.processes();
        let increments = LaneIncrements::new(&job.source, processes, job.grid.h);
        let (dw, after) = (vec![0.0; processes], job.starts.first.clone());
        let paths = DrivenPaths { lanes: LanePaths::none(), increments };
        Self { job, paths, steps: Watched::new(job, steps), dw, after }
    }

    /// Starts paths `path ..`, as many as there are before `end`.
    ///
    /// # Errors
    /// The errors of a system that cannot be prepared, and of a start that is none.
    pub(super) fn begin(&mut self, path: u64, end: u64) -> Result<(), Error> {
        let Self { job, paths: DrivenPaths { lanes, increments }, steps, .. } = self;
        lanes.begin(path, end);
        steps.restart(0, job.grid.h, lanes)?;
        increments.begin(path);
        for lane in 0..L {
            let start = job.start_of(lanes.source(lane))?;
            steps.halving.inner.put(lane, &start.q, &start.p);
        }
        steps.begin(lanes);
        Ok(())
    }

    /// Draws the increments of the step with this number, and takes it.
    ///
    /// # Errors
    /// If the run cannot go on.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn advance(&mut self, step: u64) -> Result<(), Error> {
        self.draw(step)?;
        self.step(step)
    }

    /// Draws the increments of a step; from a last step on that is shorter, steps have its size.
    ///
    /// # Errors
    /// The error of a noise that has none, and of a system that cannot be prepared.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn draw(&mut self, step: u64) -> Result<(), Error> {
        match self.job.grid.shorter {
            Some(size) if step + 1 == self.job.grid.steps => self.draw_last(step, size),
            _ => {
                let Self { job, paths: DrivenPaths { lanes, increments }, .. } = self;
                let interval = Interval { step, ..job.grid.first() };
                Ok(increments.draw(&interval, lanes)?)
            }
        }
    }

    #[cold]
    #[inline(never)]
    fn draw_last(&mut self, step: u64, size: f64) -> Result<(), Error> {
        let Self { job, paths: DrivenPaths { lanes, increments }, steps, .. } = self;
        steps.restart(step, size, lanes)?;
        let interval = Interval { step, ..job.grid.first() };
        Ok(increments.draw_last(&job.source, &interval, size, lanes)?)
    }

    /// Takes a step with the increments that were drawn.
    ///
    /// # Errors
    /// If the run cannot go on; a path that fails ends alone.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step(&mut self, number: u64) -> Result<(), Error> {
        self.steps.step(number, &mut self.paths)
    }

    /// The state of a lane at a node that all have reached.
    pub(super) fn state_at(&mut self, lane: usize, node: u64) -> &State<H::Vector> {
        self.steps.halving.inner.state_at(lane, self.job.grid.time(node))
    }

    /// The increments of a lane in a step that has been drawn.
    pub(super) fn increments_of(&mut self, lane: usize, step: u64) -> &[f64] {
        self.paths.increments.of_lane(lane, step, &mut self.dw)
    }

    /// How often the last step of a lane was halved, if it is this one.
    pub(super) fn halvings_of(&self, lane: usize, step: u64) -> u32 {
        self.steps.halving.halvings_of(lane, step)
    }

    /// Shows the inside of the step of a lane that led from `before` to this node, part by part if it was
    /// halved.
    ///
    /// # Errors
    /// The errors of steps that have been taken before, and of a noise that had increments for them: never.
    pub(super) fn look_inside(
        &mut self,
        lane: usize,
        node: u64,
        before: &State<H::Vector>,
        dense: &mut DenseOutput<H::Vector>,
        see: SeeInside<'_, H::Vector>,
    ) -> Result<(), Error> {
        let Self { job, paths: DrivenPaths { lanes, increments }, steps, after, .. } = self;
        copy_state(after, steps.halving.inner.state_at(lane, job.grid.time(node)));
        let taken = PathStep { lane, path: lanes.number(lane), number: node - 1, nodes: [before, after] };
        steps.halving.look_inside(taken, increments, dense, see)
    }

    /// Writes what [`Ensemble::observe_work`](super::Ensemble::observe_work) observes of a lane, up to a node
    /// that all have reached, in the order of [`OwnWork::names`](super::job::OwnWork::names).
    ///
    /// # Errors
    /// The error of a start that is none; [`InternalError`] if the lane has no stepper, which accounts for
    /// the heat, or no temperature.
    pub(super) fn work_of(
        &mut self,
        lane: usize,
        node: u64,
        has_weight: bool,
        into: &mut [f64],
    ) -> Result<(), Error> {
        let path = self.paths.lanes.source(lane);
        let (system, start) = (self.job.systems.of(path), self.job.start_of(path)?);
        let gained = system.energy(self.state_at(lane, node)) - system.energy(&start);
        let missing = || InternalError::new("paths whose work is observed have steppers", lane);
        let stepper = self.steps.halving.inner.stepper(lane).ok_or_else(missing)?;
        let Exchanged { all: Exchange { work: accounted, heat }, by_degree } = stepper.account();
        let work = gained - heat;
        let weight = match has_weight {
            true => {
                let missing = || InternalError::new("the weight of work has a temperature", lane);
                Some(Scalar::exp(-work / SchemeOf::<H, E>::temperature(system).ok_or_else(missing)?))
            }
            false => None,
        };
        write_work([work, work - accounted, *heat], by_degree, weight, into);
        Ok(())
    }
}

/// Writes the work of a path as it is observed: work, shadow work and heat, the heats by degree of freedom,
/// the weight.
fn write_work(all: [f64; 3], by_degree: &[f64], weight: Option<f64>, into: &mut [f64]) {
    // Before the first step there is no heat.
    into.fill(0.0);
    let values = all.iter().chain(by_degree).copied().chain(weight);
    into.iter_mut().zip(values).for_each(|(into, value)| *into = value);
}
