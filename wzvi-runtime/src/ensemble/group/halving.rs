//! Steps that a path could not take are halved ([`Subdivision`]), if that is allowed: each path as if it were
//! alone.

use super::paths::LanePaths;
use super::steps::{DrivenPaths, NotTaken, RefusedPath, StepPaths};
use crate::algebra::memory::Threads;
use crate::algebra::state::{State, copy_state};
use crate::algebra::state_sum::PlainSum;
use crate::ensemble::increments::LaneIncrements;
use crate::ensemble::job::EnsembleJob;
use crate::error::{ConfigError, StepError};
use crate::increments::Interval;
use crate::scheme::dense::DenseOutput;
use crate::scheme::system::{Discretized, explained};
use crate::trajectory::Error;
use crate::trajectory::retry::{Subdivision, is_curable};
use crate::trajectory::steps::StepToTake;
use crate::trajectory::watch::{MotionSize, keeps_energy, next_look};

/// Sees the dense output of a part of a step, its increments, and whether it is the last part.
pub(in crate::ensemble) type SeeInside<'s, V> = &'s mut dyn FnMut(&DenseOutput<V>, &[f64], bool);

/// A step of the path of a lane that has been taken, and the states before and after it.
pub(super) struct PathStep<'s, V> {
    pub(super) lane: usize,
    pub(super) path: u64,
    pub(super) number: u64,
    pub(super) nodes: [&'s State<V>; 2],
}

/// `L` paths whose steps may be halved, and end where that does not help.
pub(super) struct Halving<'j, 'a, H: Discretized<E>, E, T, const L: usize> {
    job: &'j EnsembleJob<'a, H, E>,
    pub(super) inner: T,
    /// The size of the present steps.
    size: f64,
    /// Made when a step has to be halved for the first time.
    subdivision: Option<Subdivision<'j, H, E, PlainSum>>,
    /// The last step of each lane that was halved, and how often.
    halved: [Option<(u64, u32)>; L],
    /// The motion of each path, with which the parts of a halved step are compared.
    motions: Motions<H::Vector>,
    /// Increments of one lane.
    dw: Vec<f64>,
}

/// The size of the motion of each path, from the steps that a single path looks at: so both divide a step
/// alike.
struct Motions<V> {
    /// The next of these steps; the largest number if no step is divided.
    next: u64,
    /// By lane, where that step began.
    before: Vec<State<V>>,
    so_far: Vec<MotionSize>,
}

impl<'j, 'a, H, E, T, const L: usize> Halving<'j, 'a, H, E, T, L>
where
    H: Discretized<E>,
    T: StepPaths<'j, H, E, L>,
{
    pub(super) fn new(job: &'j EnsembleJob<'a, H, E>, inner: T) -> Self {
        let motions = Motions { next: u64::MAX, before: Vec::new(), so_far: Vec::new() };
        let dw = vec![0.0; job.processes()];
        Self { job, inner, size: job.grid.h, subdivision: None, halved: [None; L], motions, dw }
    }

    /// The next paths begin.
    pub(super) fn begin(&mut self) {
        self.halved = [None; L];
        if keeps_energy::<H, E>() && self.job.retry.most() > 0 {
            self.motions.next = 0;
            self.motions.so_far = vec![MotionSize::default(); L];
        }
    }

    /// [`StepPaths::restart`]
    pub(super) fn restart(&mut self, step: u64, size: f64, paths: &LanePaths<L>) -> Result<(), Error> {
        if size != self.size {
            (self.size, self.subdivision) = (size, None);
        }
        // A last step that is shorter is none of the steps that are compared.
        self.motions.next = u64::MAX;
        self.inner.restart(step, size, paths)
    }

    /// Takes a step, of some paths in halves; paths end that cannot take it.
    ///
    /// # Errors
    /// If the run cannot go on.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn step(&mut self, number: u64, paths: &mut DrivenPaths<'j, L>) -> Result<(), Error> {
        let is_measured = const { keeps_energy::<H, E>() } && number == self.motions.next;
        if is_measured {
            self.begin_motion();
        }
        match self.inner.step(number, paths) {
            Ok(()) => {}
            Err(error) => self.halve_or_fail(*error, number, paths)?,
        }
        if is_measured {
            self.end_motion(number);
        }
        Ok(())
    }

    /// The step of the refused paths again, in halves, if that is allowed; a path fails if it is not, or does
    /// not help.
    ///
    /// # Errors
    /// If the run cannot go on: the error of a noise that has no increments, among others.
    #[cold]
    #[inline(never)]
    fn halve_or_fail(
        &mut self,
        error: NotTaken,
        number: u64,
        paths: &mut DrivenPaths<'j, L>,
    ) -> Result<(), Error> {
        let refused = match error {
            NotTaken::Paths(refused) => refused,
            NotTaken::Run(error) => return Err(error),
        };
        for RefusedPath { lane, error } in refused {
            let may_halve = self.job.retry.most() > 0 && is_curable(error.cause) && paths.lanes.is_path(lane);
            match if may_halve {
                self.halve(lane, paths.lanes.number(lane), number)
            } else {
                Err(error.into())
            } {
                Ok(State { q, p, .. }) => {
                    self.inner.put(lane, &q, &p);
                    self.inner.forget(lane, number + 1)?;
                }
                Err(Error::Step(error)) => self.fail(lane, error, &mut paths.lanes),
                // A step that is too short to be prepared: the path ends with what made it necessary.
                Err(Error::Config(_)) => self.fail(lane, error, &mut paths.lanes),
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// The end of the step of a path in halves.
    fn halve(&mut self, lane: usize, path: u64, number: u64) -> Result<State<H::Vector>, Error> {
        let Self { job, inner, size, subdivision, halved, motions, dw } = self;
        let mut state = inner.state_at(lane, job.grid.time(number)).clone();
        let motion = motions.so_far.get(lane).and_then(|motion| motion.mean());
        let mut noise = if dw.is_empty() { None } else { Some(job.source.path(path)) };
        let interval = Interval { step: number, ..job.grid.first() };
        let of_lane = StepToTake { state: &mut state, interval, noise: &mut noise.as_deref_mut(), dw };
        let info = subdivision_of(subdivision, job, path, *size)?.subdivide(of_lane, 1, motion)?;
        halved[lane] = Some((number, info.halvings));
        Ok(state)
    }

    /// The path of a lane ends.
    pub(super) fn fail(&self, lane: usize, error: StepError, paths: &mut LanePaths<L>) {
        paths.fail(lane, StepError { cause: explained(self.job.systems.common, error.cause), ..error });
    }

    /// The size of the present steps.
    pub(super) fn size(&self) -> f64 {
        self.size
    }

    /// How often the last step of a lane was halved, if it is this one.
    pub(super) fn halvings_of(&self, lane: usize, step: u64) -> u32 {
        self.halved[lane].map_or(0, |(halved, halvings)| if halved == step { halvings } else { 0 })
    }

    /// Shows the inside of the last step of a path, part by part if it was halved.
    ///
    /// # Errors
    /// The errors of steps that have been taken before, and of a noise that had increments for them: never.
    pub(super) fn look_inside(
        &mut self,
        PathStep { lane, path, number, nodes }: PathStep<'_, H::Vector>,
        increments: &LaneIncrements<'j, L>,
        dense: &mut DenseOutput<H::Vector>,
        see: SeeInside<'_, H::Vector>,
    ) -> Result<(), Error> {
        let halvings = self.halvings_of(lane, number);
        let Self { job, inner, size, subdivision, dw, .. } = self;
        if halvings > 0 {
            let mut noise = if dw.is_empty() { None } else { Some(job.source.path(path)) };
            let interval = Interval { step: number, ..job.grid.first() };
            let mut parts = 1_u64 << halvings;
            let subdivision = subdivision_of(subdivision, job, path, *size)?;
            let noise = &mut noise.as_deref_mut();
            return subdivision.revisit(nodes[0], interval, noise, halvings, &mut |stepper, nodes, dw| {
                parts -= 1;
                stepper.fill(nodes, dw, dense);
                see(dense, dw, parts == 0);
            });
        }
        let dw = increments.of_lane(lane, number, dw);
        match inner.stepper(lane) {
            Some(stepper) => stepper.fill(nodes, dw, dense),
            None => {
                debug_assert!(!H::PROPERTIES.has_polynomial, "a stepper keeps it");
                dense.fill_by_rates::<H, E>(job.systems.of(path), nodes, *size, dw);
            }
        }
        see(dense, dw, true);
        Ok(())
    }

    /// Before a step whose motion counts.
    #[cold]
    #[inline(never)]
    fn begin_motion(&mut self) {
        let Self { job, inner, motions, .. } = self;
        motions.before.resize(L, job.starts.first.clone());
        for (lane, before) in motions.before.iter_mut().enumerate() {
            copy_state(before, inner.state(lane));
        }
    }

    /// After it.
    #[cold]
    #[inline(never)]
    fn end_motion(&mut self, step: u64) {
        let Self { job, inner, motions, .. } = self;
        for (lane, (motion, before)) in motions.so_far.iter_mut().zip(&motions.before).enumerate() {
            motion.add(job.grid.h, [before, inner.state(lane)]);
        }
        motions.next = next_look(step);
    }
}

/// The subdivision of steps of this size: made when it is first needed, and anew for each path that has its
/// own system.
fn subdivision_of<'s, 'j, H: Discretized<E>, E>(
    kept: &'s mut Option<Subdivision<'j, H, E, PlainSum>>,
    job: &'j EnsembleJob<'_, H, E>,
    path: u64,
    size: f64,
) -> Result<&'s mut Subdivision<'j, H, E, PlainSum>, ConfigError> {
    if job.systems.are_own() {
        *kept = None;
    }
    let subdivision = match kept {
        Some(subdivision) => subdivision,
        none => {
            none.insert(Subdivision::new(job.systems.of(path), job.grid.h, job.retry, true, Threads::Caller)?)
        }
    };
    subdivision.resize(size)?;
    Ok(subdivision)
}
