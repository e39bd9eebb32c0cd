//! Paths that run beside each other in the lanes of vector registers: their steps, and which of them failed.

mod coupled;
mod inside;
mod scalar_path;
mod watched;

use std::marker::PhantomData;

use coupled::CoarsePaths;
use watched::Motions;

use super::increments::LaneIncrements;
use super::job::EnsembleJob;
use super::starts::Systems;
use crate::algebra::lanes::Lanes;
use crate::algebra::memory::{MemoryRequest, StepMemory};
use crate::algebra::scalar::Scalar;
use crate::algebra::solve::Effort;
use crate::algebra::state::{State, Vector};
use crate::algebra::state_sum::PlainSum;
use crate::error::{ConfigError, InternalError, StepError, StepFailure};
use crate::increments::Interval;
use crate::scheme::continuation::HardStep;
use crate::scheme::system::{
    Discretized, Exchange, MemoryOf, PreparedOf, Scheme, SchemeOf, StepArguments, explained,
};
use crate::statistics::PathFailure;
use crate::trajectory::Error;
use crate::trajectory::retry::Subdivision;
use crate::trajectory::step::{Exchanged, Stepper, checks_starts};
use crate::trajectory::watch::{EnergyMonitor, MonitorScratch, keeps_energy};

/// A step to check, with room for what that leaves.
type Checked<'j, H, E> = (HardStep<'j, H, E, PlainSum>, MemoryOf<H, E, f64>);

/// No step was halved.
const NEVER: (u64, u32) = (u64::MAX, 0);

/// `L` paths that run beside each other.
pub(super) struct Group<'j, 'a, H: Discretized<E>, E, P, const L: usize> {
    job: &'j EnsembleJob<'a, H, E>,
    /// The size of the present step, and what is prepared of the system for such steps: the last one may be
    /// shorter.
    size: f64,
    prepared: &'j PreparedOf<H, E>,
    path: u64,
    /// None where each path has a stepper.
    q: Vec<Lanes<L>>,
    p: Vec<Lanes<L>>,
    /// Data of previous steps, and the memory that steps in lanes allocate once.
    memory: MemoryOf<H, E, Lanes<L>>,
    /// The memories by lane; none where nothing is remembered.
    lane_memories: Vec<MemoryOf<H, E, Lanes<1>>>,
    /// Whether the memories by lane are in use: from a step that some lanes could not take by the fast method
    /// to the first step after which all lanes remember as much.
    has_lane_memories: bool,
    pub(super) increments: LaneIncrements<'j, L>,
    /// Lanes that are paths of this run; others only keep the vector full.
    counts: [bool; L],
    /// Lanes whose path has failed: they follow a neighbour.
    failed: [bool; L],
    any_failed: bool,
    failures: Vec<PathFailure>,
    /// The states of paths with a stepper each, else that of one lane, for observers.
    states: Vec<State<H::Vector>>,
    /// Increments of one lane.
    scalar_increments: Vec<f64>,
    /// Coordinates, momenta and increments of a lane that steps alone.
    single: [Vec<Lanes<1>>; 3],
    /// The prepared numbers of each path, if it has a system of its own.
    own: Vec<PreparedOf<H, E>>,
    /// The prepared numbers in lanes, where systems are in lanes.
    gathered: Option<PreparedOf<H, E, Lanes<L>>>,
    /// One stepper per path: if the scheme
    /// ([`Properties::in_lanes`](crate::scheme::system::Properties::in_lanes)) or the systems cannot run in
    /// lanes, or if dense output is needed that lanes do not have.
    steppers: Vec<Stepper<'j, H, E, PlainSum>>,
    /// Halves steps, once one has to be.
    subdivision: Option<Subdivision<'j, H, E, PlainSum>>,
    /// The last step of each lane that was halved, and how often.
    halved: [(u64, u32); L],
    /// The step that each lane begins without a guide, the first or one after a halved or hard one, and the
    /// last of these.
    unguided: [u64; L],
    anew: u64,
    /// Where that one began, by lane.
    starts: Vec<State<H::Vector>>,
    /// What checks it, and its memory.
    checked: Option<Checked<'j, H, E>>,
    /// The monitored energy of each lane, and the next step at which one is tested; empty where nothing is
    /// monitored.
    watches: Vec<EnergyMonitor<H::Vector>>,
    next_look: u64,
    /// The scratch of the lanes whose energy is tested in this step.
    looked: Vec<(usize, Box<MonitorScratch<H::Vector>>)>,
    /// What the parts of a divided step are compared with.
    motions: Motions<H::Vector>,
    /// Whether anything is looked for between nodes.
    looks_between: bool,
    /// The coarser paths beside these.
    coarse: Option<Box<CoarsePaths<'j, 'a, H, E, P, L>>>,
    systems: PhantomData<P>,
}

impl<'j, 'a, H: Discretized<E>, E, P: Systems, const L: usize> Group<'j, 'a, H, E, P, L> {
    /// The paths of a job, and those of a coarser one beside them.
    pub(super) fn new(job: &'j EnsembleJob<'a, H, E>, coarse: Option<&'j EnsembleJob<'a, H, E>>) -> Self {
        // The number of processes of the system, which may not know it.
        let processes = job.processes();
        let mut increments = LaneIncrements::new(&job.source, processes, job.h);
        if Self::takes_scalar_paths(job) {
            increments = increments.for_scalar_paths();
        } else if coarse.is_some() {
            increments = increments.keeping_normals();
        }
        Self {
            job,
            size: job.h,
            prepared: &job.prepared,
            path: 0,
            q: Vec::new(),
            p: Vec::new(),
            memory: Default::default(),
            lane_memories: Vec::new(),
            has_lane_memories: false,
            single: Default::default(),
            increments,
            counts: [false; L],
            failed: [false; L],
            any_failed: false,
            failures: Vec::new(),
            states: Vec::new(),
            scalar_increments: vec![0.0; processes],
            own: Vec::new(),
            gathered: None,
            steppers: Vec::new(),
            subdivision: None,
            halved: [NEVER; L],
            unguided: [0; L],
            anew: 0,
            starts: Vec::new(),
            checked: None,
            watches: Vec::new(),
            next_look: u64::MAX,
            looked: Vec::new(),
            motions: Motions::default(),
            looks_between: job.looks_between(),
            coarse: coarse.map(|job| Box::new(CoarsePaths::new(job))),
            systems: PhantomData,
        }
    }

    /// Starts paths `path ..`, as many as there are before `end`.
    ///
    /// # Errors
    /// The errors of a system that cannot be prepared.
    pub(super) fn begin(&mut self, path: u64, end: u64) -> Result<(), Error> {
        self.path = path;
        for (lane, counts) in self.counts.iter_mut().enumerate() {
            *counts = path + (lane as u64) < end;
        }
        (self.failed, self.any_failed) = ([false; L], false);
        self.halved = [NEVER; L];
        let was_shorter = self.size != self.job.h;
        self.begin_anew(0, self.job.h, &self.job.prepared)?;
        self.increments.begin(path);
        self.put_starts()?;
        // A stepper that is there starts anew by itself: paths begin at another time than they end.
        if self.is_stepped() && (self.steppers.len() < L || was_shorter || P::ARE_OWN) {
            self.make_steppers()?;
        }
        for stepper in &mut self.steppers {
            stepper.set_exchanged(Exchanged::default());
        }
        self.watch_from_start();
        self.coarse.as_mut().map_or(Ok(()), |coarse| coarse.group.begin(path, end))
    }

    /// From this step on, steps have this size, and know nothing of those before.
    ///
    /// # Errors
    /// The errors of a system that cannot be prepared.
    fn begin_anew(
        &mut self,
        step: u64,
        size: f64,
        prepared: &'j PreparedOf<H, E>,
    ) -> Result<(), ConfigError> {
        if size != self.size {
            (self.size, self.prepared) = (size, prepared);
            (self.subdivision, self.checked) = (None, None);
        }
        (self.unguided, self.anew) = ([step; L], step);
        self.memory.tell(&MemoryRequest::Forget);
        self.has_lane_memories = false;
        if const { P::ARE_OWN } {
            self.own.clear();
            for lane in 0..L {
                self.own.push(self.prepared(lane)?);
            }
            self.gather();
        }
        Ok(())
    }

    /// Makes a stepper for each lane.
    fn make_steppers(&mut self) -> Result<(), ConfigError> {
        let accounts = self.job.own_work.is_some();
        self.steppers.clear();
        for lane in 0..L {
            let system = self.job.system_of(self.source_of(lane));
            self.steppers.push(Stepper::of_many_paths(system, self.size, accounts)?);
        }
        Ok(())
    }

    /// The last step is next, and is shorter than the others: all lanes take it together. It is none of the
    /// steps that watches compare.
    ///
    /// # Errors
    /// The errors of a system that cannot be prepared, and of a noise that has no increments.
    #[cold]
    #[inline(never)]
    fn begin_last(&mut self, step: u64, size: f64) -> Result<(), Error> {
        let job = self.job;
        let missing = || InternalError::new("a shorter step is prepared", size);
        self.begin_anew(step, size, job.shorter.as_ref().ok_or_else(missing)?)?;
        if self.is_stepped() {
            let exchanged: Vec<Exchanged> =
                self.steppers.iter().map(|stepper| stepper.account().clone()).collect();
            self.make_steppers()?;
            let steppers = self.steppers.iter_mut().zip(exchanged);
            steppers.for_each(|(stepper, exchanged)| stepper.set_exchanged(exchanged));
        }
        (self.next_look, self.motions.next) = (u64::MAX, u64::MAX);
        let interval = Interval { step, ..job.grid.first() };
        let (counts, failed) = (&self.counts, &self.failed);
        Ok(self.increments.draw_last(&job.source, &interval, size, |lane| counts[lane] && !failed[lane])?)
    }

    /// Writes what [`Ensemble::observe_work`](super::Ensemble::observe_work) observes of a lane, up to a node
    /// that all have reached, in the order of [`OwnWork::names`].
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
        let path = self.source_of(lane);
        let (system, start) = (self.job.system_of(path), self.job.start_of(path)?);
        let gained = system.energy(self.state_at(lane, node)) - system.energy(&start);
        let missing = || InternalError::new("paths whose work is observed have steppers", lane);
        let stepper = self.steppers.get(lane).ok_or_else(missing)?;
        let Exchanged { all: Exchange { work: accounted, heat }, by_degree } = stepper.account();
        let work = gained - heat;
        let weight = match has_weight {
            true => {
                let missing = || InternalError::new("the weight of work has a temperature", lane);
                Some((-work / SchemeOf::<H, E>::temperature(system).ok_or_else(missing)?).exp())
            }
            false => None,
        };
        // Before the first step there is no heat.
        into.fill(0.0);
        let all = [work, work - accounted, *heat];
        let values = all.into_iter().chain(by_degree.iter().copied()).chain(weight);
        into.iter_mut().zip(values).for_each(|(into, value)| *into = value);
        Ok(())
    }

    /// # Errors
    /// The error of a start that is none.
    fn put_starts(&mut self) -> Result<(), ConfigError> {
        let job = self.job;
        let (lists, states) = if self.is_stepped() { (0, L) } else { (job.start.q.components().len(), 1) };
        if (self.q.len(), self.states.len()) != (lists, states) {
            self.q.resize(lists, Lanes::from_f64(0.0));
            self.p.resize(lists, Lanes::from_f64(0.0));
            self.states.resize(states, job.start.clone());
        }
        for lane in 0..L {
            let start = job.start_of(self.source_of(lane))?;
            self.put(lane, &start.q, &start.p);
        }
        Ok(())
    }

    /// What is prepared of the system of a lane.
    fn prepared(&self, lane: usize) -> Result<PreparedOf<H, E>, ConfigError> {
        let path = self.source_of(lane);
        let prepared = crate::trajectory::step::prepared(self.job.system_of(path), self.size);
        prepared.map_err(|cause| ConfigError::PathSystem { path, cause: Box::new(cause) })
    }

    /// Gathers the systems of all lanes; a lane whose path has failed has that of the first that has not.
    #[inline(never)]
    fn gather(&mut self) {
        let Some(lanes) = self.living() else { return };
        let gather = || SchemeOf::<H, E>::gather(lanes.map(|lane| &self.own[lane]));
        self.gathered = if self.job.all_gather { gather() } else { None };
    }

    /// Maps each lane to itself, and each failed lane to the first lane still alive.
    fn living(&self) -> Option<[usize; L]> {
        let living = (0..L).find(|&lane| !self.failed[lane])?;
        Some(std::array::from_fn(|lane| if self.failed[lane] { living } else { lane }))
    }

    /// The path whose start and system a lane has: one without a path has those of the first.
    fn source_of(&self, lane: usize) -> u64 {
        self.path + if self.counts[lane] { lane as u64 } else { 0 }
    }

    /// Whether paths go one after the other, each in vector instructions.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn takes_scalar_paths(job: &EnsembleJob<'_, H, E>) -> bool {
        L == 1 && const { EnsembleJob::<H, E>::MAY_TAKE_SCALAR_PATHS } && job.takes_scalar_paths()
    }

    /// Whether each path has a stepper of its own.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_stepped(&self) -> bool {
        // Lanes do not keep what a scheme knows between its nodes.
        !H::PROPERTIES.in_lanes
            || Self::takes_scalar_paths(self.job)
            || (P::ARE_OWN && self.gathered.is_none())
            || (H::PROPERTIES.has_polynomial && self.looks_between)
            || self.job.own_work.is_some()
    }

    fn time(&self, step: u64) -> f64 {
        self.job.grid.time(step)
    }

    /// Draws the increments of a step.
    ///
    /// # Errors
    /// The error of a noise that has none.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn draw(&mut self, step: u64) -> Result<(), Error> {
        let interval = Interval { step, ..self.job.grid.first() };
        let (counts, failed) = (&self.counts, &self.failed);
        Ok(self.increments.draw(&interval, |lane| counts[lane] && !failed[lane])?)
    }

    /// Takes a step with the increments that were drawn.
    ///
    /// # Errors
    /// If the run cannot go on; a path that fails ends alone.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn step(&mut self, step: u64) -> Result<(), Error> {
        if const { keeps_energy::<H, E>() } && step == self.next_look {
            self.begin_look(step);
        }
        let is_anew = const { checks_starts::<H, E>() } && step == self.anew && !self.is_stepped();
        if const { checks_starts::<H, E>() } && is_anew {
            self.keep_starts(step);
        }
        let is_measured = const { keeps_energy::<H, E>() } && step == self.motions.next;
        if is_measured {
            self.begin_motion();
        }
        self.take_step(step)?;
        if const { checks_starts::<H, E>() } && is_anew {
            self.check_starts(step)?;
        }
        if is_measured {
            self.end_motion(step);
        }
        if const { keeps_energy::<H, E>() } && !self.looked.is_empty() {
            self.end_look(step);
        }
        if const { keeps_energy::<H, E>() } && step + 1 == self.job.steps {
            self.arrive(step);
        }
        Ok(())
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take_step(&mut self, step: u64) -> Result<(), Error> {
        let job = self.job;
        if self.is_stepped() {
            return self.by_steppers(step);
        }
        if self.any_failed && !self.mirror(step) {
            return Ok(());
        }
        let t = self.time(step);
        if self.has_lane_memories {
            return self.step_scalar_paths(None, step, t);
        }
        let gathered = self.gathered.as_ref();
        let at = StepArguments {
            t,
            h: self.size,
            q: &mut self.q[..],
            p: &mut self.p[..],
            dw: self.increments.of(step),
        };
        let outcome = advance::<H, E, P, L>(job.system, self.prepared, gathered, at, &mut self.memory);
        match outcome {
            Ok(_) => Ok(()),
            Err(StepFailure::Lanes(failed)) => self.step_scalar_paths(Some(failed), step, t),
            Err(_) => self.step_scalar_paths(None, step, t),
        }
    }

    #[inline(never)]
    fn by_steppers(&mut self, step: u64) -> Result<(), Error> {
        let t = self.time(step);
        let mut steppers = std::mem::take(&mut self.steppers);
        for (lane, stepper) in steppers.iter_mut().enumerate() {
            if !self.failed[lane] {
                let dw = match self.increments.of_path(step) {
                    Some(dw) => dw,
                    None => {
                        self.increments_of(lane, step);
                        &self.scalar_increments
                    }
                };
                let state = &mut self.states[lane];
                state.t = t;
                if let Err(error) = stepper.step(state, dw) {
                    self.halve_or_fail(lane, step, StepError { step, ..error }, &mut Default::default())?;
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
        let Some(lanes) = self.living() else { return false };
        let dw = self.increments.of_mut(step);
        for x in self.q.iter_mut().chain(&mut self.p).chain(dw) {
            let old = x.to_array();
            *x = Lanes::new(lanes.map(|lane| old[lane]));
        }
        true
    }

    fn fail(&mut self, lane: usize, error: StepError) {
        (self.failed[lane], self.any_failed) = (true, true);
        if const { P::ARE_OWN } && self.gathered.is_some() {
            self.gather();
        }
        if self.counts[lane] {
            let error = StepError { cause: explained(self.job.system, error.cause), ..error };
            self.failures.push(PathFailure { path: self.path + lane as u64, error });
        }
    }

    fn state_of(&mut self, lane: usize, t: f64) -> State<H::Vector> {
        State { t, ..self.observed_state(lane).clone() }
    }

    fn put(&mut self, lane: usize, q: &H::Vector, p: &H::Vector) {
        if self.is_stepped() {
            let state = &mut self.states[lane];
            (state.q, state.p) = (q.clone(), p.clone());
            return;
        }
        let components = q.components().iter().chain(p.components());
        for (to, from) in self.q.iter_mut().chain(&mut self.p).zip(components) {
            to.set(lane, *from);
        }
    }

    /// The state of a lane at a node that all have reached.
    pub(super) fn state_at(&mut self, lane: usize, node: u64) -> &State<H::Vector> {
        let t = self.time(node);
        let state = self.observed_state(lane);
        state.t = t;
        state
    }

    /// The state of a lane for observables.
    fn observed_state(&mut self, lane: usize) -> &mut State<H::Vector> {
        if self.is_stepped() {
            return &mut self.states[lane];
        }
        let state = &mut self.states[0];
        for (vector, lanes) in [(&mut state.q, &self.q), (&mut state.p, &self.p)] {
            for (to, from) in vector.components_mut().iter_mut().zip(lanes) {
                *to = from[lane];
            }
        }
        state
    }

    /// The increments of a lane in a step that has been drawn.
    pub(super) fn increments_of(&mut self, lane: usize, step: u64) -> &[f64] {
        match self.increments.of_path(step) {
            Some(dw) => self.scalar_increments.copy_from_slice(dw),
            None => {
                for (to, from) in self.scalar_increments.iter_mut().zip(self.increments.of(step)) {
                    *to = from[lane];
                }
            }
        }
        &self.scalar_increments
    }

    /// How often the last step of a lane was halved, if it is this one.
    pub(super) fn halvings_of(&self, lane: usize, step: u64) -> u32 {
        let (halved, halvings) = self.halved[lane];
        if halved == step { halvings } else { 0 }
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

    /// Failures since the last call, sorted by path number.
    pub(super) fn take_failures(&mut self) -> Vec<PathFailure> {
        in_order_of_paths(std::mem::take(&mut self.failures))
    }
}

/// One step of all lanes by the fast method. If each path has its own system, its constants are lanes, too,
/// even for `L = 1`: the bits of a path do not depend on `L`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn advance<H: Discretized<E>, E, P: Systems, const L: usize>(
    system: &H,
    prepared: &PreparedOf<H, E>,
    gathered: Option<&PreparedOf<H, E, Lanes<L>>>,
    StepArguments { t, h, q, p, dw }: StepArguments<'_, Lanes<L>>,
    memory: &mut MemoryOf<H, E, Lanes<L>>,
) -> Result<Effort, StepFailure> {
    if const { P::ARE_OWN }
        && let Some(gathered) = gathered
    {
        let [t, h] = [t, h].map(Lanes::from_f64);
        let at = StepArguments { t, h, q, p, dw };
        return SchemeOf::<H, E>::advance::<Lanes<L>, _, PlainSum, false>(
            system,
            gathered,
            at,
            memory,
            &mut PlainSum,
        );
    }
    let at = StepArguments { t, h, q, p, dw };
    SchemeOf::<H, E>::advance::<f64, _, PlainSum, false>(system, prepared, at, memory, &mut PlainSum)
}

fn in_order_of_paths(mut failures: Vec<PathFailure>) -> Vec<PathFailure> {
    failures.sort_unstable_by_key(|failure| failure.path);
    failures
}

impl<H: Discretized<E>, E, P: Systems, const L: usize> Group<'_, '_, H, E, P, L> {
    /// Draws the increments of the step with this number, and takes it.
    ///
    /// # Errors
    /// If no path can go on.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn advance(&mut self, step: u64) -> Result<(), Error> {
        match self.job.grid.shorter {
            Some(size) if step + 1 == self.job.steps => self.begin_last(step, size)?,
            _ => self.draw(step)?,
        }
        if const { P::ARE_PAIRED } {
            self.advance_coarse(step)?;
        }
        self.step(step)
    }
}
