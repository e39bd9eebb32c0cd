//! A lane of a group that steps alone, where the fast method fails, and lanes with memories of their own.

use super::{Group, Systems, advance};
use crate::algebra::lanes::Lanes;
use crate::algebra::memory::{MemoryRequest, StepMemory, Threads};
use crate::algebra::short_list::ShortOrLong;
use crate::algebra::state::State;
use crate::algebra::state_sum::PlainSum;
use crate::ensemble::job::EnsembleJob;
use crate::error::{ConfigError, FailedLanes, InternalError, StepError, StepFailure};
use crate::ground::numbers::{Numbers, Tape};
use crate::increments::Interval;
use crate::scheme::continuation::{ContinuedStep, HardStep, solve_by_continuation};
use crate::scheme::plan::Solver;
use crate::scheme::system::{Discretized, MemoryOf, PreparedOf, Scheme, SchemeOf, StepArguments};
use crate::trajectory::Error;
use crate::trajectory::retry::{Subdivision, is_curable};
use crate::trajectory::step::may_mislead;
use crate::trajectory::steps::StepToTake;

impl<'j, H: Discretized<E>, E, P: Systems, const L: usize> Group<'j, '_, H, E, P, L> {
    /// The step of these lanes, or of all, one after the other: each as it goes alone.
    #[cold]
    #[inline(never)]
    pub(super) fn step_scalar_paths(
        &mut self,
        lanes: Option<FailedLanes>,
        step: u64,
        t: f64,
    ) -> Result<(), Error> {
        self.split()?;
        let (mut apart, mut none) = (std::mem::take(&mut self.lane_memories), Default::default());
        for lane in 0..L {
            if !self.failed[lane] && lanes.is_none_or(|lanes| lanes.has(lane)) {
                let memory = apart.get_mut(lane).unwrap_or(&mut none);
                match self.single(lane, step, t, memory) {
                    Err(Error::Step(error)) => self.halve_or_fail(lane, step, error, memory)?,
                    outcome => outcome?,
                }
            }
        }
        self.lane_memories = apart;
        self.join();
        Ok(())
    }

    /// The step of one path again, in halves, if that is allowed; the path fails if it is not, or does not
    /// help.
    ///
    /// # Errors
    /// The error of a noise that has no increments.
    pub(super) fn halve_or_fail(
        &mut self,
        lane: usize,
        step: u64,
        error: StepError,
        memory: &mut MemoryOf<H, E, Lanes<1>>,
    ) -> Result<(), Error> {
        let is_tried = self.job.retry.most() > 0 && is_curable(error.cause) && self.counts[lane];
        match if is_tried { self.halve(lane, step, error) } else { Err(error.into()) } {
            Ok(state) => {
                self.put(lane, &state.q, &state.p);
                memory.tell(&MemoryRequest::Forget);
            }
            Err(Error::Step(error)) => self.fail(lane, error),
            // A step that is too short to be prepared: the path ends with what made it necessary.
            Err(Error::Config(_)) => self.fail(lane, error),
            Err(error) => return Err(error),
        }
        Ok(())
    }

    fn halve(&mut self, lane: usize, step: u64, error: StepError) -> Result<State<H::Vector>, Error> {
        let job = self.job;
        let mut state = self.state_of(lane, error.t);
        let motion = self.motions.of(lane);
        let subdivision = subdivision_of(&mut self.subdivision, job, self.path + lane as u64, self.size)?;
        let mut noise =
            (!self.scalar_increments.is_empty()).then(|| job.source.path(self.path + lane as u64));
        let interval = Interval { step, ..job.grid.first() };
        let noise = &mut noise.as_deref_mut();
        let step_of_lane = StepToTake { state: &mut state, interval, noise, dw: &mut self.scalar_increments };
        let info = subdivision.subdivide(step_of_lane, 1, motion)?;
        self.halved[lane] = (step, info.halvings);
        self.lose_guide(lane, step);
        Ok(state)
    }

    /// Marks a step of a lane as no guide for the next one.
    fn lose_guide(&mut self, lane: usize, step: u64) {
        self.unguided[lane] = step + 1;
        self.anew = step + 1;
    }

    /// One lane alone: the fast method, then the careful one of a `Stepper`.
    fn single(
        &mut self,
        lane: usize,
        step: u64,
        t: f64,
        memory: &mut MemoryOf<H, E, Lanes<1>>,
    ) -> Result<(), Error> {
        let [mut q, mut p, mut dw] = std::mem::take(&mut self.single);
        let lists = [(&mut q, &*self.q), (&mut p, &*self.p), (&mut dw, self.increments.of(step))];
        for (single, all) in lists {
            single.clear();
            single.extend(all.iter().map(|x| Lanes::new([x[lane]])));
        }
        let (system, prepared) = self.system_of(lane);
        let gathered = if const { P::ARE_OWN } { SchemeOf::<H, E>::gather([&prepared]) } else { None };
        let at = StepArguments { t, h: self.size, q: &mut q[..], p: &mut p[..], dw: &dw };
        let outcome = advance::<H, E, P, 1>(system, &prepared, gathered.as_ref(), at, memory);
        if outcome.is_ok() {
            for (to, from) in self.q.iter_mut().chain(&mut self.p).zip(q.iter().chain(&p)) {
                to.set(lane, from[0]);
            }
        }
        self.single = [q, p, dw];
        match outcome {
            Ok(_) => Ok(()),
            Err(cause) if matches!(H::PLAN.solver, Solver::Newton) => self.careful(lane, step, cause, memory),
            Err(cause) => Err(StepError { step, t, h: self.size, cause }.into()),
        }
    }

    /// The system of a lane, and its prepared numbers.
    fn system_of(&self, lane: usize) -> (&'j H, PreparedOf<H, E>) {
        let job = self.job;
        match self.own.get(lane) {
            Some(prepared) if P::ARE_OWN => (job.system_of(self.source_of(lane)), prepared.clone()),
            _ => (job.system, self.prepared.clone()),
        }
    }

    /// The careful method for one lane.
    fn careful(
        &mut self,
        lane: usize,
        step: u64,
        cause: StepFailure,
        memory: &mut MemoryOf<H, E, Lanes<1>>,
    ) -> Result<(), Error> {
        let t = self.time(step);
        let State { q, p, t } = self.state_of(lane, t);
        let (system, prepared) = self.system_of(lane);
        let (h, dw) = (self.size, ShortOrLong::of(self.increments_of(lane, step)));
        let hard = HardStep { system, prepared, t, h, q, p, dw, carry: PlainSum };
        let solved = solve_by_continuation(hard, cause);
        let mut solved = solved.map_err(|cause| StepError { step, t, h, cause })?;
        self.put_hard(lane, step, &mut solved, memory)
    }

    /// Stores the end of a hard step of a lane, and the memory that it leaves.
    fn put_hard(
        &mut self,
        lane: usize,
        step: u64,
        solved: &mut ContinuedStep<H, E, PlainSum>,
        memory: &mut MemoryOf<H, E, Lanes<1>>,
    ) -> Result<(), Error> {
        self.put(lane, &solved.q, &solved.p);
        if const { may_mislead::<H, E>() } {
            self.lose_guide(lane, step);
        }
        let words = Tape::write(|tape| solved.memory.pass(tape));
        Ok(Tape::read(words, |tape| memory.pass(tape)).ok_or_else(other_memory)?)
    }

    /// Keeps where a step begins that some lanes begin anew.
    #[cold]
    #[inline(never)]
    pub(super) fn keep_starts(&mut self, step: u64) {
        let t = self.time(step);
        let mut starts = std::mem::take(&mut self.starts);
        starts.clear();
        starts.extend((0..L).map(|lane| self.state_of(lane, t)));
        self.starts = starts;
    }

    /// After that step: whether each of these lanes has the solution that continues its state. As for a
    /// stepper, that the short way has found one is not enough where it had nothing to go by.
    ///
    /// # Errors
    /// The error of a noise that has no increments.
    #[cold]
    #[inline(never)]
    pub(super) fn check_starts(&mut self, step: u64) -> Result<(), Error> {
        let (h, starts) = (self.size, std::mem::take(&mut self.starts));
        for (lane, State { q, p, t }) in starts.iter().enumerate() {
            // Halves that were taken, and a careful solution, have been checked.
            if self.unguided[lane] != step || self.failed[lane] {
                continue;
            }
            let end = self.state_of(lane, *t);
            let other = self.check_start(lane, [q, p], *t, [&end.q, &end.p]);
            let Some(other) = other.transpose() else { continue };
            self.split()?;
            let mut apart = std::mem::take(&mut self.lane_memories);
            let mut none = Default::default();
            let memory = apart.get_mut(lane).unwrap_or(&mut none);
            match other {
                Ok(mut solved) => self.put_hard(lane, step, &mut solved, memory)?,
                Err(cause) => {
                    self.put(lane, q, p);
                    let error = StepError { step, t: *t, h, cause };
                    self.halve_or_fail(lane, step, error, memory)?;
                }
            }
            self.lane_memories = apart;
        }
        self.join();
        self.starts = starts;
        Ok(())
    }

    /// [`HardStep::check`] of a lane.
    fn check_start(
        &mut self,
        lane: usize,
        [q, p]: [&H::Vector; 2],
        t: f64,
        ends: [&H::Vector; 2],
    ) -> Result<Option<ContinuedStep<H, E, PlainSum>>, StepFailure> {
        let (mut hard, mut room) = match self.checked.take() {
            Some((hard, room)) if !P::ARE_OWN => (hard, room),
            _ => {
                let (system, prepared) = self.system_of(lane);
                let (h, q, p, dw) = (self.size, q.clone(), p.clone(), ShortOrLong::of(&[]));
                (HardStep { system, prepared, t, h, q, p, dw, carry: PlainSum }, Default::default())
            }
        };
        hard.q.clone_from(q);
        hard.p.clone_from(p);
        hard.t = t;
        let other = hard.check(ends, &mut room);
        self.checked = Some((hard, room));
        other
    }

    /// From now on, each lane remembers by itself.
    fn split(&mut self) -> Result<(), InternalError> {
        // With noise as well: what a step leaves may say how the next one is solved.
        if size_of::<MemoryOf<H, E, f64>>() == 0 || self.has_lane_memories {
            return Ok(());
        }
        self.lane_memories.resize_with(L, Default::default);
        for (lane, memory) in self.lane_memories.iter_mut().enumerate() {
            let words = Tape::split(lane, |tape| self.memory.pass(tape));
            Tape::read(words, |tape| memory.pass(tape)).ok_or_else(other_memory)?;
        }
        self.has_lane_memories = true;
        Ok(())
    }

    /// Joins the lanes if they go side by side and their memories have the same shape. A lane that has failed
    /// takes the memory of the path that it follows.
    fn join(&mut self) {
        let Some(lanes) = self.living() else { return };
        if !self.has_lane_memories || !lanes.iter().all(|&lane| self.lane_memories[lane].allows_lanes()) {
            return;
        }
        let mut words = Vec::with_capacity(L);
        for lane in lanes {
            words.push(Tape::write(|tape| self.lane_memories[lane].pass(tape)));
        }
        if Tape::join(words, |tape| self.memory.pass(tape)).is_some() {
            self.has_lane_memories = false;
        }
    }
}

/// What halves the steps of this size of a path: made when it is first needed, and anew for each path that
/// has its own system.
pub(super) fn subdivision_of<'s, 'j, H: Discretized<E>, E>(
    kept: &'s mut Option<Subdivision<'j, H, E, PlainSum>>,
    job: &'j EnsembleJob<'_, H, E>,
    path: u64,
    size: f64,
) -> Result<&'s mut Subdivision<'j, H, E, PlainSum>, ConfigError> {
    if !job.systems.is_empty() {
        *kept = None;
    }
    let subdivision = match kept {
        Some(subdivision) => subdivision,
        none => none.insert(Subdivision::new(job.system_of(path), job.h, job.retry, true, Threads::Caller)?),
    };
    subdivision.resize(size)?;
    Ok(subdivision)
}

/// What one scheme leaves has the same shape for every number.
fn other_memory() -> InternalError {
    InternalError::new("what a step leaves is the same for lanes and alone", "a group of paths")
}
