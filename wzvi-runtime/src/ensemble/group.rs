//! Paths that run beside each other in the lanes of vector registers: their steps, and which of them failed.

mod inside;

use super::increments::LaneIncrements;
use super::job::Job;
use super::statistics::PathFailure;
use crate::carry::Plain;
use crate::continuation::Hard;
use crate::error::{Error, InternalError, StepError, StepFailure};
use crate::increments::Interval;
use crate::lanes::Lanes;
use crate::memory::StepMemory;
use crate::numbers::{Numbers, Tape};
use crate::plan::Solver;
use crate::retry::{Subdivision, is_curable};
use crate::scalar::Scalar;
use crate::state::{State, Vector};
use crate::step::{ResolutionMonitor, Stepper};
use crate::steps::Advance;
use crate::system::Discretized;

/// No step was halved.
const NEVER: (u64, u32) = (u64::MAX, 0);

/// `L` paths that run beside each other.
pub(super) struct Group<'j, 'a, H: Discretized<E>, E, const L: usize> {
    job: &'j Job<'a, H, E>,
    path: u64,
    q: Vec<Lanes<L>>,
    p: Vec<Lanes<L>>,
    /// What the steps before left, and what steps in lanes allocate once.
    memory: H::Memory<Lanes<L>>,
    /// The same by lane, between a step that not all lanes could take the short way and the first after which all remember as much;
    /// then, and where nothing is remembered, there are none.
    apart: Vec<H::Memory<Lanes<1>>>,
    resolution: [ResolutionMonitor; L],
    pub(super) increments: LaneIncrements<'j, L>,
    /// Lanes that are paths of this run; others only keep the vector full.
    counts: [bool; L],
    /// Lanes whose path has failed: they follow a neighbour.
    failed: [bool; L],
    any_failed: bool,
    failures: Vec<PathFailure>,
    /// The state of one lane, for whoever looks at it.
    state: State<H::Vector>,
    /// Increments of one lane.
    alone: Vec<f64>,
    /// Where steps are no matter of lanes ([`Discretized::IN_LANES`]): one stepper for each.
    steppers: Vec<Stepper<'a, H, E, Plain>>,
    /// Halves steps, once one has to be.
    subdivision: Option<Subdivision<'a, H, E, Plain>>,
    /// The last step of each lane that was halved, and how often.
    halved: [(u64, u32); L],
    /// Whether the last step, which is shorter, has been taken: by steppers.
    is_over: bool,
}

impl<'j, 'a, H: Discretized<E>, E, const L: usize> Group<'j, 'a, H, E, L> {
    pub(super) fn new(job: &'j Job<'a, H, E>) -> Self {
        // That of the system, which may not know it.
        let (d, processes) = (job.start.q.components().len(), job.system.noises());
        let zero = Lanes::from_f64(0.0);
        Self {
            job,
            path: 0,
            q: vec![zero; d],
            p: vec![zero; d],
            memory: Default::default(),
            apart: Vec::new(),
            resolution: [ResolutionMonitor::default(); L],
            increments: LaneIncrements::new(&job.source, processes, job.h),
            counts: [false; L],
            failed: [false; L],
            any_failed: false,
            failures: Vec::new(),
            state: job.start.clone(),
            alone: vec![0.0; processes],
            steppers: Vec::new(),
            subdivision: None,
            halved: [NEVER; L],
            is_over: false,
        }
    }

    /// For a run that makes more of the normals than increments.
    pub(super) fn keeping_normals(mut self) -> Self {
        self.increments = self.increments.keeping_normals();
        self
    }

    /// Starts paths `path ..`, as many as there are before `end`.
    ///
    /// # Errors
    /// Those of a stepper that cannot be made.
    pub(super) fn begin(&mut self, path: u64, end: u64) -> Result<(), Error> {
        self.path = path;
        self.counts = std::array::from_fn(|lane| path + (lane as u64) < end);
        for lane in 0..L {
            // A lane without a path follows the first.
            let start = self.job.start_of(path + if self.counts[lane] { lane as u64 } else { 0 })?;
            self.put(lane, &start.q, &start.p);
        }
        (self.failed, self.any_failed) = ([false; L], false);
        (self.halved, self.is_over) = ([NEVER; L], false);
        self.memory.forget();
        self.apart.clear();
        self.resolution = [ResolutionMonitor::default(); L];
        self.increments.begin(path);
        if Self::IS_STEPPED {
            let stepper = |_| Stepper::new(self.job.system, self.job.h).map(Stepper::plain);
            self.steppers = (0..L).map(stepper).collect::<Result<_, _>>()?;
        }
        Ok(())
    }

    /// Whether each path has a stepper of its own.
    const IS_STEPPED: bool = !H::IN_LANES;

    fn time(&self, step: u64) -> f64 {
        self.job.grid.time(step)
    }

    /// Draws the increments of a step.
    ///
    /// # Errors
    /// That of a noise that has none.
    #[inline(always)]
    pub(super) fn draw(&mut self, step: u64) -> Result<(), Error> {
        let interval = Interval { start: self.job.start.t, h: self.job.h, step };
        let (counts, failed) = (&self.counts, &self.failed);
        Ok(self.increments.draw(&interval, |lane| counts[lane] && !failed[lane])?)
    }

    /// Takes a step with the increments that were drawn.
    ///
    /// # Errors
    /// If the run cannot go on; a path that fails ends alone.
    #[inline(always)]
    pub(super) fn step(&mut self, step: u64) -> Result<(), Error> {
        let job = self.job;
        if Self::IS_STEPPED {
            return self.by_steppers(step);
        }
        if self.any_failed && !self.mirror(step) {
            return Ok(());
        }
        let t = self.time(step);
        if !self.apart.is_empty() {
            return self.one_by_one(step, t);
        }
        let (q, p, memory) = (&mut self.q, &mut self.p, &mut self.memory);
        let dw = self.increments.of(step);
        let outcome = job.system.advance_carrying::<Lanes<L>, Plain, false>(
            &job.prepared,
            t,
            job.h,
            q,
            p,
            dw,
            memory,
            &mut Plain,
        );
        if outcome.is_err() { self.one_by_one(step, t) } else { Ok(()) }
    }

    #[inline(never)]
    fn by_steppers(&mut self, step: u64) -> Result<(), Error> {
        let t = self.time(step);
        let mut steppers = std::mem::take(&mut self.steppers);
        for (lane, stepper) in steppers.iter_mut().enumerate() {
            if !self.failed[lane] {
                self.look(lane);
                self.state.t = t;
                self.increments_of(lane, step);
                match stepper.step(&mut self.state, &self.alone) {
                    Ok(_) => self.keep(lane),
                    Err(error) => self.halve_or_fail(lane, step, StepError { step, ..error })?,
                }
            }
        }
        self.steppers = steppers;
        Ok(())
    }

    /// Lanes without a path follow the first that has one; `false` if none has.
    #[cold]
    #[inline(never)]
    fn mirror(&mut self, step: u64) -> bool {
        let Some(living) = (0..L).find(|&lane| !self.failed[lane]) else { return false };
        let dw = self.increments.of_mut(step);
        for x in self.q.iter_mut().chain(&mut self.p).chain(dw) {
            let old = x.to_array();
            *x = Lanes::new(std::array::from_fn(|lane| old[if self.failed[lane] { living } else { lane }]));
        }
        true
    }

    /// The step that not all lanes can take the short way.
    #[cold]
    #[inline(never)]
    fn one_by_one(&mut self, step: u64, t: f64) -> Result<(), Error> {
        self.split()?;
        for lane in 0..L {
            if self.failed[lane] {
                continue;
            }
            match self.single(lane, step, t) {
                Ok(()) => {}
                Err(Error::Step(error)) => self.halve_or_fail(lane, step, error)?,
                Err(error) => return Err(error),
            }
        }
        self.join();
        Ok(())
    }

    /// The step of one path again, in halves, if that is allowed; the path fails if it is not, or does not help.
    ///
    /// # Errors
    /// That of a noise that has no increments.
    fn halve_or_fail(&mut self, lane: usize, step: u64, error: StepError) -> Result<(), Error> {
        let is_tried = self.job.retry.most() > 0 && is_curable(error.cause) && self.counts[lane];
        match if is_tried { self.halve(lane, step, error) } else { Err(error.into()) } {
            Ok(state) => {
                self.put(lane, &state.q, &state.p);
                self.resolution[lane] = ResolutionMonitor::default();
                if let Some(memory) = self.apart.get_mut(lane) {
                    memory.forget();
                }
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
        let subdivision = match &mut self.subdivision {
            Some(subdivision) => subdivision,
            none => none.insert(Subdivision::new(job.system, job.h, job.retry, true)?),
        };
        let mut noise = (!self.alone.is_empty()).then(|| job.source.path(self.path + lane as u64));
        let interval = Interval { start: job.start.t, h: job.h, step };
        let noise = &mut noise.as_deref_mut();
        let info = subdivision.subdivide(&mut state, &interval, noise, &mut self.alone, 1)?;
        self.halved[lane] = (step, info.halvings);
        Ok(state)
    }

    fn fail(&mut self, lane: usize, error: StepError) {
        (self.failed[lane], self.any_failed) = (true, true);
        if self.counts[lane] {
            self.failures.push(PathFailure { path: self.path + lane as u64, error });
        }
    }

    fn state_of(&self, lane: usize, t: f64) -> State<H::Vector> {
        let vector = |lanes: &[Lanes<L>]| {
            let mut vector = H::Vector::zeros(lanes.len());
            for (to, from) in vector.components_mut().iter_mut().zip(lanes) {
                *to = from[lane];
            }
            vector
        };
        State { q: vector(&self.q), p: vector(&self.p), t }
    }

    fn put(&mut self, lane: usize, q: &H::Vector, p: &H::Vector) {
        let components = q.components().iter().chain(p.components());
        for (to, from) in self.q.iter_mut().chain(&mut self.p).zip(components) {
            to.set(lane, *from);
        }
    }

    /// Moves what observables see to a lane.
    fn keep(&mut self, lane: usize) {
        let components = self.state.q.components().iter().chain(self.state.p.components());
        for (to, from) in self.q.iter_mut().chain(&mut self.p).zip(components) {
            to.set(lane, *from);
        }
    }

    /// One lane, as it goes alone: the short way, then the careful one of a [`Stepper`].
    fn single(&mut self, lane: usize, step: u64, t: f64) -> Result<(), Error> {
        let job = self.job;
        let alone = |lanes: &[Lanes<L>]| -> Vec<_> { lanes.iter().map(|x| Lanes::new([x[lane]])).collect() };
        let (mut q, mut p, dw) = (alone(&self.q), alone(&self.p), alone(self.increments.of(step)));
        let mut forgetful = H::Memory::default();
        let outcome = job.system.advance_carrying::<Lanes<1>, Plain, false>(
            &job.prepared,
            t,
            job.h,
            &mut q,
            &mut p,
            &dw,
            self.apart.get_mut(lane).unwrap_or(&mut forgetful),
            &mut Plain,
        );
        match outcome {
            Ok(_) => {
                for (to, from) in self.q.iter_mut().chain(&mut self.p).zip(q.iter().chain(&p)) {
                    to.set(lane, from[0]);
                }
                Ok(())
            }
            Err(cause) if matches!(H::PLAN.solver, Solver::Newton) => self.careful(lane, step, &dw, cause),
            Err(cause) => Err(StepError { step, t, h: job.h, cause }.into()),
        }
    }

    /// The careful way, of one lane.
    fn careful(&mut self, lane: usize, step: u64, dw: &[Lanes<1>], cause: StepFailure) -> Result<(), Error> {
        let (job, t) = (self.job, self.time(step));
        let State { q, p, t } = self.state_of(lane, t);
        let dw: Vec<f64> = dw.iter().map(|dw| dw[0]).collect();
        let (system, h, prepared) = (job.system, job.h, job.prepared.clone());
        let hard = Hard { system, prepared, t, h, q, p, dw: &dw, carry: Plain };
        let solved = self.resolution[lane].careful_step(hard, step, cause);
        let mut solved = solved.map_err(|cause| StepError { step, t, h, cause })?;
        self.put(lane, &solved.q, &solved.p);
        if let Some(memory) = self.apart.get_mut(lane) {
            let words = Tape::write(|tape| solved.memory.pass(tape));
            Tape::read(words, |tape| memory.pass(tape)).ok_or_else(other_memory)?;
        }
        Ok(())
    }

    /// From now on, each lane remembers by itself.
    fn split(&mut self) -> Result<(), InternalError> {
        if !H::REMEMBERS || !self.apart.is_empty() {
            return Ok(());
        }
        for lane in 0..L {
            let words = Tape::split(lane, |tape| self.memory.pass(tape));
            let mut memory = H::Memory::default();
            Tape::read(words, |tape| memory.pass(tape)).ok_or_else(other_memory)?;
            self.apart.push(memory);
        }
        Ok(())
    }

    /// Lanes go on together if what they remember is of the same shape. One that has failed remembers what the path does that it follows.
    fn join(&mut self) {
        let Some(living) = (0..L).find(|&lane| !self.failed[lane]) else { return };
        if self.apart.is_empty() {
            return;
        }
        let words = |lane: usize| {
            let lane = if self.failed[lane] { living } else { lane };
            Tape::write(|tape| self.apart[lane].pass(tape))
        };
        let words = (0..L).map(words).collect();
        if Tape::join(words, |tape| self.memory.pass(tape)).is_some() {
            self.apart.clear();
        }
    }

    /// The state of a lane at a node that all have reached.
    pub(super) fn state_at(&mut self, lane: usize, node: u64) -> &State<H::Vector> {
        self.look(lane);
        self.state.t = self.time(node);
        &self.state
    }

    /// Moves a lane to what observables see.
    fn look(&mut self, lane: usize) {
        for (to, from) in self.state.q.components_mut().iter_mut().zip(&self.q) {
            *to = from[lane];
        }
        for (to, from) in self.state.p.components_mut().iter_mut().zip(&self.p) {
            *to = from[lane];
        }
    }

    /// The increments of a lane in a step that has been drawn.
    pub(super) fn increments_of(&mut self, lane: usize, step: u64) -> &[f64] {
        for (to, from) in self.alone.iter_mut().zip(self.increments.of(step)) {
            *to = from[lane];
        }
        &self.alone
    }

    /// The number of the path of a lane.
    pub(super) fn path(&self, lane: usize) -> u64 {
        self.path + lane as u64
    }

    /// Whether a lane is a path of this run.
    pub(super) fn is_path(&self, lane: usize) -> bool {
        self.counts[lane]
    }

    /// Whether the path of a lane has failed.
    pub(super) fn has_failed(&self, lane: usize) -> bool {
        self.failed[lane]
    }

    /// Why this path failed, if it has.
    pub(super) fn failure_of(&self, path: u64) -> Option<PathFailure> {
        self.failures.iter().find(|failure| failure.path == path).copied()
    }

    /// The paths that failed since this was asked last, in the order of their numbers: they came in that of time, which depends on who ran
    /// beside whom.
    pub(super) fn take_failures(&mut self) -> Vec<PathFailure> {
        let mut failures = std::mem::take(&mut self.failures);
        failures.sort_unstable_by_key(|failure| failure.path);
        failures
    }
}

/// What one scheme leaves has the same shape for every number.
fn other_memory() -> InternalError {
    InternalError::new("what a step leaves is the same for lanes and alone", "a group of paths")
}

impl<H: Discretized<E>, E, const L: usize> Advance for Group<'_, '_, H, E, L> {
    type Error = Error;

    #[inline(always)]
    fn advance(&mut self, step: u64) -> Result<(), Error> {
        if let (Some(h), true) = (self.job.grid.shorter, step + 1 == self.job.steps) {
            return self.finish(step, h);
        }
        self.draw(step)?;
        self.step(step)
    }
}
