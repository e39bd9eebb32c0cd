//! Paths in the lanes of vector registers: the fast method takes a step of all of them at once.
//!
//! A lane that the fast method fails for takes the step alone: by the same method with numbers of one lane,
//! then by the careful one of a [`Stepper`](crate::trajectory::step::Stepper). A path therefore has the same
//! bits whatever is beside it.

use std::marker::PhantomData;

use super::memories::{LaneMemories, other_memory};
use super::paths::LanePaths;
use super::steps::{DrivenPaths, NotTaken, RefusedPath, StepPaths};
use crate::algebra::lanes::Lanes;
use crate::algebra::memory::{MemoryRequest, StepMemory};
use crate::algebra::scalar::Scalar;
use crate::algebra::short_list::ShortOrLong;
use crate::algebra::solve::Effort;
use crate::algebra::state::{State, Vector};
use crate::algebra::state_sum::PlainSum;
use crate::ensemble::job::EnsembleJob;
use crate::ensemble::starts::Systems;
use crate::error::{FailedLanes, InternalError, StepError, StepFailure};
use crate::ground::numbers::{Numbers, Tape};
use crate::scheme::continuation::{ContinuedStep, HardStep, solve_by_continuation};
use crate::scheme::plan::Solver;
use crate::scheme::system::{Discretized, MemoryOf, PreparedOf, Scheme, SchemeOf, StepArguments};
use crate::trajectory::Error;
use crate::trajectory::step::{checks_starts, may_mislead};

/// `L` paths in lanes.
pub(in crate::ensemble) struct InLanes<'j, 'a, H: Discretized<E>, E, P, const L: usize> {
    job: &'j EnsembleJob<'a, H, E>,
    /// The size of the present steps, and what is prepared of the system for them: the last one may be
    /// shorter.
    size: f64,
    prepared: &'j PreparedOf<H, E>,
    own: OwnSystems<H, E, L>,
    q: Vec<Lanes<L>>,
    p: Vec<Lanes<L>>,
    memories: LaneMemories<MemoryOf<H, E, Lanes<L>>, MemoryOf<H, E, Lanes<1>>>,
    guides: Guides<'j, H, E, L>,
    /// Coordinates, momenta and increments of a lane that steps alone.
    scalar: [Vec<Lanes<1>>; 3],
    /// The state of one lane, for whoever looks at it.
    seen: State<H::Vector>,
    systems: PhantomData<P>,
}

/// The systems of paths that have their own.
struct OwnSystems<H: Discretized<E>, E, const L: usize> {
    /// The constants of each system.
    prepared: Vec<PreparedOf<H, E>>,
    /// The constants in lanes; a lane whose path has failed has those of another.
    gathered: Option<PreparedOf<H, E, Lanes<L>>>,
    /// The path of each lane of `gathered`.
    lanes: Option<[usize; L]>,
}

/// A step to check, and its memory.
type CheckedStart<'j, H, E> = (HardStep<'j, H, E, PlainSum>, MemoryOf<H, E, f64>);

/// The steps without a guide in the ones before, and their check: a solution that the fast method has found
/// need not be the one that continues the state ([`HardStep::check`]).
struct Guides<'j, H: Discretized<E>, E, const L: usize> {
    /// The step that each lane begins without a guide: the first, or one after a halved or hard one.
    unguided: [u64; L],
    /// The last of these.
    next: u64,
    /// The state at the start of that step, by lane.
    starts: Vec<State<H::Vector>>,
    /// The check of that step, with room for the next one.
    checked: Option<CheckedStart<'j, H, E>>,
}

impl<H: Discretized<E>, E, const L: usize> Guides<'_, H, E, L> {
    /// The step after this one has no guide in this lane.
    fn lose(&mut self, lane: usize, step: u64) {
        self.unguided[lane] = step + 1;
        self.next = step + 1;
    }
}

impl<'j, 'a, H: Discretized<E>, E, P: Systems, const L: usize> InLanes<'j, 'a, H, E, P, L> {
    pub(in crate::ensemble) fn new(job: &'j EnsembleJob<'a, H, E>) -> Self {
        let list = || vec![Lanes::from_f64(0.0); job.starts.first.q.components().len()];
        Self {
            job,
            size: job.grid.h,
            prepared: &job.prepared.whole,
            own: OwnSystems { prepared: Vec::new(), gathered: None, lanes: None },
            q: list(),
            p: list(),
            memories: LaneMemories::default(),
            guides: Guides { unguided: [0; L], next: 0, starts: Vec::new(), checked: None },
            scalar: Default::default(),
            seen: job.starts.first.clone(),
            systems: PhantomData,
        }
    }

    /// Gathers the systems of these lanes.
    ///
    /// # Errors
    /// [`InternalError`] if they do not go in lanes together: then their job does not, either.
    #[inline(never)]
    fn gather(&mut self, lanes: [usize; L]) -> Result<(), InternalError> {
        let OwnSystems { prepared, gathered, lanes: of_lanes } = &mut self.own;
        let together = SchemeOf::<H, E>::gather(lanes.map(|lane| &prepared[lane]));
        let apart = || InternalError::new("the systems of lanes go in lanes", "a group of paths");
        *gathered = Some(together.ok_or_else(apart)?);
        *of_lanes = Some(lanes);
        Ok(())
    }

    /// The system of a path, and what is prepared of that of its lane.
    fn system_of(&self, lane: usize, path: u64) -> (&'j H, PreparedOf<H, E>) {
        match self.own.prepared.get(lane) {
            Some(prepared) if P::ARE_OWN => (self.job.systems.of(path), prepared.clone()),
            _ => (self.job.systems.common, self.prepared.clone()),
        }
    }

    /// Takes a step by the fast method, lane by lane where it has to be.
    ///
    /// # Errors
    /// [`NotTaken`]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance(&mut self, number: u64, paths: &mut DrivenPaths<'j, L>) -> Result<(), Box<NotTaken>> {
        if paths.lanes.any_failed() && !self.mirror(number, paths)? {
            return Ok(());
        }
        if self.memories.are_split() && !paths.lanes.living().is_some_and(|lanes| self.memories.join(lanes)) {
            return self.step_by_lane(None, number, paths);
        }
        let Self { job, size, prepared, own, q, p, memories, .. } = self;
        let (t, dw) = (job.grid.time(number), paths.increments.of(number));
        let at = StepArguments { t, h: *size, q: &mut q[..], p: &mut p[..], dw };
        let (gathered, memory) = (own.gathered.as_ref(), &mut memories.joint);
        match advance::<H, E, P, L>(job.systems.common, prepared, gathered, at, memory) {
            Ok(_) => Ok(()),
            Err(StepFailure::Lanes(failed)) => self.step_by_lane(Some(failed), number, paths),
            Err(_) => self.step_by_lane(None, number, paths),
        }
    }

    /// Lanes whose path has failed follow the first that has one; `false` if none has.
    #[cold]
    #[inline(never)]
    fn mirror(&mut self, number: u64, paths: &mut DrivenPaths<'_, L>) -> Result<bool, InternalError> {
        let Some(lanes) = paths.lanes.living() else { return Ok(false) };
        if const { P::ARE_OWN } && self.own.lanes != Some(lanes) {
            self.gather(lanes)?;
        }
        let dw = paths.increments.of_mut(number);
        for x in self.q.iter_mut().chain(&mut self.p).chain(dw) {
            *x = moved(*x, lanes);
        }
        Ok(true)
    }

    /// The step of these lanes, or of all, one after the other: each as it goes alone.
    #[cold]
    #[inline(never)]
    fn step_by_lane(
        &mut self,
        lanes: Option<FailedLanes>,
        number: u64,
        paths: &mut DrivenPaths<'_, L>,
    ) -> Result<(), Box<NotTaken>> {
        self.memories.split::<L>()?;
        let mut refused = Vec::new();
        for lane in 0..L {
            if !paths.lanes.has_failed(lane) && lanes.is_none_or(|lanes| lanes.has(lane)) {
                let mut memory = std::mem::take(self.memories.of(lane));
                let taken = self.step_lane(lane, number, paths, &mut memory);
                *self.memories.of(lane) = memory;
                if let Err(error) = taken {
                    self.guides.lose(lane, number);
                    refused.push(RefusedPath { lane, error: step_error(error)? });
                }
            }
        }
        NotTaken::by(refused)
    }

    /// One lane alone: the fast method, then the careful one of a `Stepper`.
    fn step_lane(
        &mut self,
        lane: usize,
        number: u64,
        paths: &DrivenPaths<'_, L>,
        memory: &mut MemoryOf<H, E, Lanes<1>>,
    ) -> Result<(), Error> {
        let [mut q, mut p, mut dw] = std::mem::take(&mut self.scalar);
        let lists = [(&mut q, &*self.q), (&mut p, &*self.p), (&mut dw, paths.increments.of(number))];
        for (single, all) in lists {
            single.clear();
            for x in all {
                single.push(Lanes::new([x[lane]]));
            }
        }
        let (system, prepared) = self.system_of(lane, paths.lanes.source(lane));
        let gathered = if const { P::ARE_OWN } { SchemeOf::<H, E>::gather([&prepared]) } else { None };
        let at = StepArguments {
            t: self.job.grid.time(number),
            h: self.size,
            q: &mut q[..],
            p: &mut p[..],
            dw: &dw,
        };
        let outcome = advance::<H, E, P, 1>(system, &prepared, gathered.as_ref(), at, memory);
        if outcome.is_ok() {
            for (to, from) in self.q.iter_mut().chain(&mut self.p).zip(q.iter().chain(&p)) {
                to.set(lane, from[0]);
            }
        }
        self.scalar = [q, p, dw];
        match outcome {
            Ok(_) => Ok(()),
            Err(cause) if matches!(H::PLAN.solver, Solver::Newton) => {
                self.step_with_care(lane, number, paths, cause, memory)
            }
            Err(cause) => Err(self.failed(number, cause).into()),
        }
    }

    /// The careful method for one lane.
    fn step_with_care(
        &mut self,
        lane: usize,
        number: u64,
        paths: &DrivenPaths<'_, L>,
        cause: StepFailure,
        memory: &mut MemoryOf<H, E, Lanes<1>>,
    ) -> Result<(), Error> {
        let (system, prepared) = self.system_of(lane, paths.lanes.source(lane));
        let State { q, p, t } = self.state_at(lane, self.job.grid.time(number)).clone();
        let mut dw = Vec::new();
        let dw = ShortOrLong::of(paths.increments.of_lane(lane, number, &mut dw));
        let hard = HardStep { system, prepared, t, h: self.size, q, p, dw, carry: PlainSum };
        let mut solved = solve_by_continuation(hard, cause).map_err(|cause| self.failed(number, cause))?;
        Ok(self.put_hard(lane, number, &mut solved, memory)?)
    }

    fn failed(&self, number: u64, cause: StepFailure) -> StepError {
        StepError { step: number, t: self.job.grid.time(number), h: self.size, cause }
    }

    /// Stores the end of a hard step of a lane, and the memory that it leaves.
    fn put_hard(
        &mut self,
        lane: usize,
        step: u64,
        solved: &mut ContinuedStep<H, E, PlainSum>,
        memory: &mut MemoryOf<H, E, Lanes<1>>,
    ) -> Result<(), InternalError> {
        self.put(lane, &solved.q, &solved.p);
        if const { may_mislead::<H, E>() } {
            self.guides.lose(lane, step);
        }
        let words = Tape::write(|tape| solved.memory.pass(tape));
        Tape::read(words, |tape| memory.pass(tape)).ok_or_else(other_memory)
    }

    /// Keeps where a step begins that some lanes begin without a guide.
    #[cold]
    #[inline(never)]
    fn keep_starts(&mut self, t: f64) {
        let mut starts = std::mem::take(&mut self.guides.starts);
        starts.clear();
        for lane in 0..L {
            starts.push(self.state_at(lane, t).clone());
        }
        self.guides.starts = starts;
    }

    /// After that step: whether each of these lanes has the solution that continues its state. As for a
    /// stepper, that the fast method has found one is not enough where it had nothing to go by.
    ///
    /// # Errors
    /// [`NotTaken`], with the paths that have not `taken` the step.
    #[cold]
    #[inline(never)]
    fn check_starts(
        &mut self,
        number: u64,
        paths: &DrivenPaths<'_, L>,
        taken: Result<(), Box<NotTaken>>,
    ) -> Result<(), Box<NotTaken>> {
        let mut refused = match taken {
            Ok(()) => Vec::new(),
            Err(error) => match *error {
                NotTaken::Paths(refused) => refused,
                error => return Err(error.into()),
            },
        };
        let starts = std::mem::take(&mut self.guides.starts);
        for (lane, start) in starts.iter().enumerate() {
            // A careful solution has been checked, and a path that was refused is where it was.
            if self.guides.unguided[lane] != number || paths.lanes.has_failed(lane) {
                continue;
            }
            let end = self.state(lane).clone();
            let Some(other) = self.check_start(lane, paths, start, &end).transpose() else { continue };
            self.memories.split::<L>()?;
            match other {
                Ok(mut solved) => {
                    let mut memory = std::mem::take(self.memories.of(lane));
                    let put = self.put_hard(lane, number, &mut solved, &mut memory);
                    *self.memories.of(lane) = memory;
                    put?;
                }
                Err(cause) => {
                    self.put(lane, &start.q, &start.p);
                    refused.push(RefusedPath { lane, error: self.failed(number, cause) });
                }
            }
        }
        self.guides.starts = starts;
        NotTaken::by(refused)
    }

    /// [`HardStep::check`] of a lane.
    fn check_start(
        &mut self,
        lane: usize,
        paths: &DrivenPaths<'_, L>,
        start: &State<H::Vector>,
        end: &State<H::Vector>,
    ) -> Result<Option<ContinuedStep<H, E, PlainSum>>, StepFailure> {
        let (mut hard, mut room) = match self.guides.checked.take() {
            Some((hard, room)) if !P::ARE_OWN => (hard, room),
            _ => {
                let (system, prepared) = self.system_of(lane, paths.lanes.source(lane));
                let State { q, p, t } = start.clone();
                let dw = ShortOrLong::of(&[]);
                let hard = HardStep { system, prepared, t, h: self.size, q, p, dw, carry: PlainSum };
                (hard, Default::default())
            }
        };
        hard.q.clone_from(&start.q);
        hard.p.clone_from(&start.p);
        hard.t = start.t;
        let other = hard.check([&end.q, &end.p], &mut room);
        self.guides.checked = Some((hard, room));
        other
    }
}

impl<'j, H: Discretized<E>, E, P: Systems, const L: usize> StepPaths<'j, H, E, L>
    for InLanes<'j, '_, H, E, P, L>
{
    fn restart(&mut self, step: u64, size: f64, paths: &LanePaths<L>) -> Result<(), Error> {
        if size != self.size {
            (self.size, self.prepared) = (size, self.job.prepared_for(size)?);
            self.guides.checked = None;
        }
        (self.guides.unguided, self.guides.next) = ([step; L], step);
        self.memories.forget();
        if const { P::ARE_OWN } {
            self.own.prepared.clear();
            for lane in 0..L {
                let path = paths.source(lane);
                let prepared = crate::trajectory::step::prepared(self.job.systems.of(path), size);
                self.own.prepared.push(prepared.map_err(|cause| self.job.systems.error_of(path, cause))?);
            }
            if let Some(lanes) = paths.living() {
                self.gather(lanes)?;
            }
        }
        Ok(())
    }

    fn put(&mut self, lane: usize, q: &H::Vector, p: &H::Vector) {
        let components = q.components().iter().chain(p.components());
        for (to, from) in self.q.iter_mut().chain(&mut self.p).zip(components) {
            to.set(lane, *from);
        }
    }

    fn forget(&mut self, lane: usize, step: u64) -> Result<(), InternalError> {
        (self.guides.unguided[lane], self.guides.next) = (step, step);
        self.memories.split::<L>()?;
        self.memories.of(lane).tell(&MemoryRequest::Forget);
        Ok(())
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step(&mut self, number: u64, paths: &mut DrivenPaths<'j, L>) -> Result<(), Box<NotTaken>> {
        let is_unguided = const { checks_starts::<H, E>() } && number == self.guides.next;
        if is_unguided {
            self.keep_starts(self.job.grid.time(number));
        }
        match self.advance(number, paths) {
            taken if is_unguided => self.check_starts(number, paths, taken),
            taken => taken,
        }
    }

    fn state(&mut self, lane: usize) -> &mut State<H::Vector> {
        for (vector, lanes) in [(&mut self.seen.q, &self.q), (&mut self.seen.p, &self.p)] {
            for (to, from) in vector.components_mut().iter_mut().zip(lanes) {
                *to = from[lane];
            }
        }
        &mut self.seen
    }
}

/// In each lane the number of the lane that is given for it.
fn moved<const L: usize>(x: Lanes<L>, lanes: [usize; L]) -> Lanes<L> {
    Lanes::new(lanes.map(|lane| x[lane]))
}

/// The error of a step, if it is one.
///
/// # Errors
/// Another error, which ends the run.
fn step_error(error: Error) -> Result<StepError, Error> {
    if let Error::Step(error) = error { Ok(error) } else { Err(error) }
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
