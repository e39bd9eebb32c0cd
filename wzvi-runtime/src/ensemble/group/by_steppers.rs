//! Paths with a stepper each, where they cannot go in lanes: see
//! [`NotInLanes`](crate::ensemble::job::NotInLanes).

use super::paths::LanePaths;
use super::steps::{DrivenPaths, NotTaken, RefusedPath, StepPaths};
use crate::algebra::state::State;
use crate::algebra::state_sum::PlainSum;
use crate::ensemble::job::EnsembleJob;
use crate::error::{ConfigError, StepError};
use crate::scheme::system::Discretized;
use crate::trajectory::Error;
use crate::trajectory::step::{Exchanged, Stepper};

/// `L` paths with a stepper each.
pub(in crate::ensemble) struct BySteppers<'j, 'a, H: Discretized<E>, E, const L: usize> {
    job: &'j EnsembleJob<'a, H, E>,
    /// The size of the present steps: the last one may be shorter.
    size: f64,
    /// None before the first paths begin.
    steppers: Vec<Stepper<'j, H, E, PlainSum>>,
    states: Vec<State<H::Vector>>,
    /// Increments of one path.
    dw: Vec<f64>,
}

impl<'j, 'a, H: Discretized<E>, E, const L: usize> BySteppers<'j, 'a, H, E, L> {
    pub(in crate::ensemble) fn new(job: &'j EnsembleJob<'a, H, E>) -> Self {
        let (states, dw) = (vec![job.starts.first.clone(); L], vec![0.0; job.processes()]);
        Self { job, size: job.grid.h, steppers: Vec::new(), states, dw }
    }

    fn make_steppers(&mut self, paths: &LanePaths<L>) -> Result<(), ConfigError> {
        let (job, accounts) = (self.job, self.job.observed.work.is_some());
        self.steppers.clear();
        for lane in 0..L {
            let path = paths.source(lane);
            let stepper = Stepper::of_many_paths(job.systems.of(path), self.size, accounts);
            self.steppers.push(stepper.map_err(|cause| job.systems.error_of(path, cause))?);
        }
        Ok(())
    }
}

impl<'j, H: Discretized<E>, E, const L: usize> StepPaths<'j, H, E, L> for BySteppers<'j, '_, H, E, L> {
    fn restart(&mut self, step: u64, size: f64, paths: &LanePaths<L>) -> Result<(), Error> {
        let account = |stepper: &Stepper<'j, H, E, PlainSum>| stepper.account().clone();
        let before: Vec<Exchanged> = self.steppers.iter().map(account).collect();
        // A stepper that is there starts anew by itself: paths begin at another time than they end.
        if before.is_empty() || size != self.size || self.job.systems.are_own() {
            self.size = size;
            self.make_steppers(paths)?;
        }
        // Nothing has been exchanged before the first step.
        let before = if step == 0 { vec![Exchanged::default(); L] } else { before };
        self.steppers.iter_mut().zip(before).for_each(|(stepper, before)| stepper.set_exchanged(before));
        Ok(())
    }

    fn put(&mut self, lane: usize, q: &H::Vector, p: &H::Vector) {
        let state = &mut self.states[lane];
        state.q.clone_from(q);
        state.p.clone_from(p);
    }

    #[inline(never)]
    fn step(&mut self, number: u64, paths: &mut DrivenPaths<'j, L>) -> Result<(), Box<NotTaken>> {
        let (t, mut refused) = (self.job.grid.time(number), Vec::new());
        for (lane, (stepper, state)) in self.steppers.iter_mut().zip(&mut self.states).enumerate() {
            if !paths.lanes.has_failed(lane) {
                state.t = t;
                if let Err(error) = stepper.step(state, paths.increments.of_lane(lane, number, &mut self.dw))
                {
                    refused.push(RefusedPath { lane, error: StepError { step: number, ..error } });
                }
            }
        }
        NotTaken::by(refused)
    }

    fn state(&mut self, lane: usize) -> &mut State<H::Vector> {
        &mut self.states[lane]
    }

    fn stepper(&self, lane: usize) -> Option<&Stepper<'j, H, E, PlainSum>> {
        self.steppers.get(lane)
    }
}
