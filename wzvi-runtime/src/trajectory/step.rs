//! One step at a time.

mod account;
mod rare;
mod saved;

use std::marker::PhantomData;

use crate::algebra::memory::{Iteration, MemoryRequest, Method, StepMemory, Threads};
use crate::algebra::short_list::ShortOrLong;
use crate::algebra::state::{State, Vector, are_equal, copy, copy_state};
use crate::algebra::state_sum::{PlainSum, StateSum};
use crate::error::{ConfigError, StepError, StepFailure};
use crate::scheme::clock::ClockReading;
use crate::scheme::continuation::HardStep;
use crate::scheme::dense::DenseOutput;
use crate::scheme::plan::{NoiseClass, Solver};
use crate::scheme::system::{
    Discretized, Exchange, MemoryOf, PreparedOf, Scheme, SchemeOf, StepArguments, SumOf, as_they_are,
    explained, mistaken_parameter,
};
use account::EnergyLedger;
use rare::{RareCause, RareStep, RefusedStep, TakenRareStep};

/// The iterations and halvings of one step, and the way in which it was solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StepInfo {
    /// Newton iterations of the solution, over all blocks; 0 for explicit and linear steps.
    pub iterations: u32,
    /// How often the step was halved: it is `2^halvings` steps of size `h / 2^halvings`. 0 unless a
    /// [`Retry`](crate::trajectory::retry::Retry) allows more.
    pub halvings: u32,
    /// Whether the fast iteration failed or led to another solution, so that the step was solved from zero
    /// with a line search. Many such steps in a row mean that the step is long for the fastest motion. If the
    /// step was halved: whether one of its parts was hard.
    pub is_hard: bool,
    /// Whether the solution could not be followed from the state along the step. Only the orientation of its
    /// Jacobian then says that it is the connected one. The step is far too long for a stiff force, or a push
    /// went along contacts that just touch. If the step was halved: whether this holds for one of its parts.
    pub is_doubtful: bool,
}

/// A prepared integrator: everything that depends only on the system and the step size is computed once.
///
/// Its steps allocate nothing. After `n` consecutive steps of one state the time is `t_0 + n h`; it is not
/// accumulated.
///
/// The energy of these steps is not monitored, unlike that of runs ([`StepFailure::Unresolved`]): compare
/// [`Hamiltonian::energy`](crate::scheme::system::Hamiltonian::energy) with its value at the start.
#[derive(Debug)]
pub struct Stepper<'a, H: Discretized<E>, E, C = SumOf<H, E>> {
    system: &'a H,
    h: f64,
    prepared: PreparedOf<H, E>,
    memory: MemoryOf<H, E, f64>,
    /// The rounding errors of the state, if they are kept.
    carry: C,
    /// Steps before the count was last restarted.
    before: u64,
    time: StepTime,
    /// `q` and `p` after the last step.
    reached: [H::Vector; 2],
    /// The energy that all steps exchanged.
    exchanged: Exchanged,
    /// Whether the exchanged energy is not asked for.
    is_unaccounted: bool,
    /// The account of energy that steps exchange beyond what their scheme accounts for; the first such step
    /// makes it.
    ledger: Option<Box<EnergyLedger<H::Vector>>>,
    scheme: PhantomData<E>,
}

/// The energy that steps exchanged.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Exchanged {
    /// By all degrees of freedom.
    pub(crate) all: Exchange,
    /// The heat of each degree of freedom, where they have temperatures of their own; else empty.
    pub(crate) by_degree: Vec<f64>,
}

impl Exchanged {
    /// Nothing so far, of so many degrees of freedom with temperatures of their own.
    fn of(degrees: usize) -> Self {
        Self { all: Exchange::default(), by_degree: vec![0.0; degrees] }
    }

    /// Adds the heats of a step, where there are any.
    pub(crate) fn add_heats_of(&mut self, of_step: &[f64]) {
        if !of_step.is_empty() {
            self.add_heats(of_step);
        }
    }

    /// Adds the heats of a step. The first one makes the list where the system does not know its size.
    fn add_heats(&mut self, of_step: &[f64]) {
        if self.by_degree.len() != of_step.len() {
            self.by_degree.resize(of_step.len(), 0.0);
        }
        self.by_degree.iter_mut().zip(of_step).for_each(|(sum, heat)| *sum += heat);
    }
}

/// Time as `t_0 + n h`, restarted whenever the caller's state is at another time.
#[derive(Clone, Copy, Debug)]
struct StepTime {
    start: f64,
    ticks: u64,
    now: f64,
}

/// More steps than anyone takes.
const MOST_TICKS: f64 = (1_u64 << 63) as f64;

impl StepTime {
    fn started(at: f64) -> Self {
        Self { start: at, ticks: 0, now: at }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn next(self, h: f64) -> Self {
        let ticks = self.ticks + 1;
        Self { ticks, now: self.time(ticks, h), ..self }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn time(self, ticks: u64, h: f64) -> f64 {
        // The conversion of a signed integer is one instruction.
        self.start + ticks.cast_signed() as f64 * h
    }

    /// This count without the time of the last step, so that the next step checks the state that it gets.
    fn unguided(self) -> Self {
        Self { now: f64::NAN, ..self }
    }

    /// Whether its last step ended at `t`, of steps that have been taken.
    fn has_reached(self, t: f64, h: f64) -> bool {
        self.ticks > 0 && t == self.time(self.ticks, h)
    }
}

impl<'a, H: Discretized<E>, E> Stepper<'a, H, E> {
    /// Prepares steps of size `h` (time units of the Hamiltonian; negative runs backwards).
    ///
    /// # Errors
    /// * [`ConfigError::StepSize`] unless `h` is finite and not zero.
    /// * [`ConfigError::Parameter`] or [`ConfigError::Singular`] if what is computed once for all steps is
    ///   not finite or not invertible.
    /// * [`ConfigError::Bath`] if friction, temperature or masses are invalid.
    pub fn new(system: &'a H, h: f64) -> Result<Self, ConfigError> {
        if !h.is_finite() || h == 0.0 {
            return Err(if H::PROPERTIES.is_clocked {
                ConfigError::Eps(h)
            } else {
                ConfigError::StepSize(h)
            });
        }
        let (d, prepared) = (system.degrees(), prepared(system, h)?);
        let mut memory: MemoryOf<H, E, f64> = SchemeOf::<H, E>::memory(system);
        memory.tell(&MemoryRequest::Share(Threads::Cores));
        Ok(Self {
            system,
            h,
            prepared,
            memory,
            carry: Default::default(),
            before: 0,
            time: StepTime::started(f64::NAN),
            reached: [H::Vector::zeros(d), H::Vector::zeros(d)],
            exchanged: Exchanged::of(if H::PROPERTIES.has_temperatures { d } else { 0 }),
            is_unaccounted: false,
            ledger: None,
            scheme: PhantomData,
        })
    }

    /// Carries the rounding error of the state from step to step ([`crate::algebra::state_sum`]). The drift
    /// of first integrals by rounding shrinks by about the ratio of a step's increment to the state. It costs
    /// six additions per component, and is the default where that is less than about 5 % of the step.
    pub fn compensated(self) -> Stepper<'a, H, E, <SchemeOf<H, E> as Scheme<H>>::CompensatedSum<f64>> {
        self.carrying()
    }

    /// This stepper, with plain sums.
    pub fn plain(self) -> Stepper<'a, H, E, PlainSum> {
        self.carrying()
    }

    pub(crate) fn carrying<C: StateSum<f64>>(self) -> Stepper<'a, H, E, C> {
        Stepper {
            carry: C::default(),
            time: StepTime::started(f64::NAN),
            before: self.before + self.time.ticks,
            system: self.system,
            h: self.h,
            prepared: self.prepared,
            memory: self.memory,
            reached: self.reached,
            exchanged: self.exchanged,
            is_unaccounted: self.is_unaccounted,
            ledger: self.ledger,
            scheme: PhantomData,
        }
    }
}

impl<'a, H: Discretized<E>, E> Stepper<'a, H, E, PlainSum> {
    /// For one of many paths, which have the threads already, with plain sums; whether it accounts for what
    /// forces and bath do.
    ///
    /// # Errors
    /// The errors of [`Stepper::new`].
    pub(crate) fn of_many_paths(system: &'a H, h: f64, accounts: bool) -> Result<Self, ConfigError> {
        let stepper = Stepper::<H, E>::new(system, h)?.plain().sharing(Threads::Caller);
        Ok(Self { is_unaccounted: !accounts, ..stepper })
    }
}

impl<'a, H: Discretized<E>, E, C: StateSum<f64>> Stepper<'a, H, E, C> {
    /// Whether rounding errors are carried from step to step.
    pub fn is_compensated(&self) -> bool {
        C::CARRIES
    }

    /// The memory of the scheme after the last step.
    pub(crate) fn memory(&self) -> &MemoryOf<H, E, f64> {
        &self.memory
    }

    /// The step size.
    pub fn step_size(&self) -> f64 {
        self.h
    }

    /// Fixes how implicit steps of systems of elements are iterated. This affects the time, and no
    /// significant digit. A step whose fixed point does not contract is then an error
    /// ([`StepFailure::NotConverged`]), since nothing else is tried.
    #[must_use]
    pub fn iteration(mut self, iteration: Iteration) -> Self {
        self.memory.tell(&MemoryRequest::Pin(iteration));
        self
    }

    /// Sets the number of threads for the steps of large systems, as far as these have enough tiles. The
    /// default is all cores, from a size on where that pays ([systems of any size](crate::scheme::elements));
    /// 1 switches threads off. The result is the same, bit for bit. Every step then starts its own threads,
    /// an implicit step in each iteration, which allocates.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] for zero.
    pub fn threads(self, threads: usize) -> Result<Self, ConfigError> {
        Threads::asked(Some(threads)).map(|threads| self.sharing(threads))
    }

    /// [`Stepper::threads`]
    pub(crate) fn sharing(mut self, threads: Threads) -> Self {
        self.memory.tell(&MemoryRequest::Share(threads));
        self
    }

    /// How the linear equations of a step are solved in systems of elements, where the best way depends on
    /// the size.
    pub fn method(&self) -> Option<Method> {
        self.memory.report().method
    }

    /// The system that it steps.
    pub fn system(&self) -> &'a H {
        self.system
    }

    /// Number of successful steps so far.
    pub fn steps(&self) -> u64 {
        self.before + self.time.ticks
    }

    /// The [work](crate::trajectory::recorded::Trajectory::work) and the
    /// [heat](crate::trajectory::recorded::Trajectory::heat) of its successful steps so far, in units of
    /// energy. The energy changes by both and by the error of the scheme.
    pub fn exchanged(&self) -> Exchange {
        self.exchanged.all
    }

    /// The heat that each degree of freedom took from its bath in the successful steps so far: as
    /// [`Trajectory::heat_by_degree`](crate::trajectory::recorded::Trajectory::heat_by_degree).
    pub fn heat_by_degree(&self) -> &[f64] {
        &self.exchanged.by_degree
    }

    /// The energy that successful steps exchanged so far.
    pub(crate) fn account(&self) -> &Exchanged {
        &self.exchanged
    }

    /// Accounts for what other steps exchanged, too.
    pub(crate) fn set_exchanged(&mut self, exchanged: Exchanged) {
        self.exchanged = exchanged;
    }

    /// One step of `state` with the given increments: one per noise (`&[]` without noise), and after them
    /// `√h` times the standard normals of a [bath](crate::scheme::bath), which [`Discretized::increments`]
    /// counts.
    ///
    /// # Errors
    /// [`StepError`] with time, step number and cause. State and stepper are then unchanged, bit for bit.
    #[inline]
    pub fn step(&mut self, state: &mut State<H::Vector>, dw: &[f64]) -> Result<StepInfo, StepError> {
        // A constant noise, or one whose force is zero, would not show them.
        if !matches!(H::PLAN.noise, NoiseClass::None) && zero_if_finite(dw) != 0.0 {
            return Err(self.no_number(state, dw));
        }
        if Self::MAY_EXCHANGE {
            self.begin(state);
        }
        if state.t != self.time.now || self.jumped(state) {
            return self.step_anew(state, dw);
        }
        let at = StepArguments { t: state.t, h: self.h, q: &mut state.q, p: &mut state.p, dw };
        let Self { system, prepared, memory, carry, .. } = self;
        match SchemeOf::<H, E>::advance::<f64, f64, C, false>(system, prepared, at, memory, carry) {
            Ok(effort) => {
                self.arrive(state, self.after(self.time), dw);
                Ok(StepInfo { iterations: effort.iterations, ..StepInfo::default() })
            }
            Err(cause) if !Self::IS_ITERATED => Err(self.error(state, dw, cause)),
            Err(cause) => self.step_rarely(state, dw, self.time, RareCause::Failed(cause)),
        }
    }

    /// The error of increments that are no numbers, or of a number of increments that does not fit the
    /// system.
    #[cold]
    fn no_number(&self, state: &State<H::Vector>, dw: &[f64]) -> StepError {
        let (degrees, got) = (state.q.components().len(), dw.len());
        let expected = self.system.increments(degrees);
        let cause = match self.system.check(degrees) {
            Err(cause) => cause,
            Ok(()) if got != expected => StepFailure::Increments { expected, got },
            Ok(()) => StepFailure::NonFiniteInput,
        };
        self.error(state, dw, cause)
    }

    /// Whether the damped iteration can solve a step that the fast one does not. Steps by a clock see to it
    /// themselves.
    const IS_ITERATED: bool = matches!(H::PLAN.solver, Solver::Newton) && !H::PROPERTIES.is_clocked;

    /// The time after the step that was just taken.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn after(&self, time: StepTime) -> StepTime {
        if H::PROPERTIES.is_clocked {
            StepTime { ticks: time.ticks + 1, now: SchemeOf::<H, E>::reading(&self.memory).t, ..time }
        } else {
            time.next(self.h)
        }
    }

    /// The time at the end of the next step of a state, in the units of the Hamiltonian: for a scheme with a
    /// [clock](crate::scheme::clock), whose noise has the increments from the time of the state to this one.
    /// NaN where the clock does not know it before the step: for `Extended`, `Logarithmic` and compositions
    /// of `Clocked`.
    ///
    /// # Errors
    /// [`StepFailure::ClockNotPositive`] and [`StepFailure::ClockTooCoarse`].
    pub fn upcoming(&self, state: &State<H::Vector>) -> Result<f64, StepError> {
        if !H::PROPERTIES.is_clocked {
            return Ok(state.t + self.h);
        }
        let at_start;
        // The memory of another state is no guide.
        let memory = if state.t != self.time.now || self.jumped(state) {
            at_start = MemoryOf::<H, E, f64>::default();
            &at_start
        } else {
            &self.memory
        };
        let end = SchemeOf::<H, E>::upcoming(self.system, &self.prepared, state, self.h, memory);
        end.map_err(|cause| self.error(state, &[], cause))
    }

    /// The reading of the clock after the last step.
    pub(crate) fn reading(&self) -> ClockReading {
        SchemeOf::<H, E>::reading(&self.memory)
    }

    /// The length in time of the step that was just taken.
    pub(crate) fn length(&self) -> f64 {
        if H::PROPERTIES.is_clocked { SchemeOf::<H, E>::reading(&self.memory).h } else { self.h }
    }

    /// As [`Stepper::step`]; `dense` receives the path between the two nodes ([`crate::scheme::dense`]).
    /// Allocates nothing after the first step.
    ///
    /// # Errors
    /// The errors of [`Stepper::step`]; `dense` is then unchanged, too.
    pub fn step_densely(
        &mut self,
        state: &mut State<H::Vector>,
        dw: &[f64],
        dense: &mut DenseOutput<H::Vector>,
    ) -> Result<StepInfo, StepError> {
        let before = dense.lend(state);
        let taken = self.step(state, dw);
        if taken.is_ok() {
            dense.forget();
            self.fill([&before, state], dw, dense);
        }
        dense.give_back(before);
        taken
    }

    /// Goes on from a state to which something else moved the path at the end of the last step, whose time it
    /// keeps: what the step left is no guide.
    pub(crate) fn go_on_from(&mut self, state: &State<H::Vector>) {
        self.memory.tell(&MemoryRequest::Forget);
        self.carry = C::default();
        if Self::REMEMBERS {
            copy(&mut self.reached[0], &state.q);
            copy(&mut self.reached[1], &state.p);
        }
        if Self::IS_ITERATED {
            self.time = self.time.unguided();
        }
    }

    /// Fills the dense output of the last step, which led from one node to the other with these increments.
    pub(crate) fn fill(&self, nodes: [&State<H::Vector>; 2], dw: &[f64], dense: &mut DenseOutput<H::Vector>) {
        dense.fill::<H, E>((self.system, &self.prepared, &self.memory), nodes, self.length(), dw);
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn arrive(&mut self, state: &mut State<H::Vector>, at: StepTime, dw: &[f64]) {
        self.time = at;
        state.t = at.now;
        if H::PROPERTIES.exchanges && !self.is_unaccounted {
            self.exchanged.all += SchemeOf::<H, E>::exchanged(self.system, &self.memory);
            if H::PROPERTIES.has_temperatures {
                self.exchanged.add_heats(SchemeOf::<H, E>::heats(&self.memory));
            }
        }
        if Self::MAY_EXCHANGE {
            self.settle(state, dw);
        }
        if Self::REMEMBERS {
            copy(&mut self.reached[0], &state.q);
            copy(&mut self.reached[1], &state.p);
        }
    }

    /// Whether forces or friction may be at work in steps.
    pub(crate) const MAY_EXCHANGE: bool =
        H::KIND.is_forced || H::KIND.is_conformal || H::PROPERTIES.exchanges;

    /// Keeps where a step begins.
    fn begin(&mut self, state: &State<H::Vector>) {
        if self.is_unaccounted || !account::is_wanted::<H, E>(self.system) {
            return;
        }
        let length = |state: &State<H::Vector>| state.q.components().len();
        self.ledger.take_if(|ledger| length(&ledger.before) != length(state));
        let ledger = self.ledger.get_or_insert_with(|| Box::new(EnergyLedger::of(state, H::PLAN.order)));
        copy_state(&mut ledger.before, state);
    }

    /// Accounts for what a step exchanged.
    fn settle(&mut self, state: &State<H::Vector>, dw: &[f64]) {
        let Some(mut ledger) = self.ledger.take() else { return };
        if !H::PROPERTIES.exchanges {
            let EnergyLedger { before, dense, .. } = &mut *ledger;
            self.fill([before, state], dw, dense);
        }
        self.exchanged.all += ledger.exchanged::<H, E>(self.system, state, self.length(), dw);
        self.ledger = Some(ledger);
    }

    /// A step from another state than the last one led to: time is counted from there.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step_anew(&mut self, state: &mut State<H::Vector>, dw: &[f64]) -> Result<StepInfo, StepError> {
        cold();
        // A clock has no other time than that of its last step, which the state would have.
        let is_moved =
            H::PROPERTIES.is_clocked || !self.time.has_reached(state.t, self.h) || self.jumped(state);
        // If time cannot overflow from here, no step needs to check its own.
        if is_moved && !H::PROPERTIES.is_clocked && !(state.t.abs() + MOST_TICKS * self.h.abs()).is_finite() {
            return Err(self.error(state, dw, StepFailure::NonFinite));
        }
        // With the room that it has; a copy of what it remembers comes back if the step fails.
        let (left, mut memory) = (self.memory.clone(), std::mem::take(&mut self.memory));
        let time = if is_moved { StepTime::started(state.t) } else { self.time };
        if is_moved {
            memory.tell(&MemoryRequest::Forget);
        }
        if Self::IS_ITERATED {
            let taken = self.step_rarely(state, dw, time, RareCause::Unguided(memory));
            if taken.is_err() {
                self.memory.adopt(left);
            }
            return taken;
        }
        let at = StepArguments { t: state.t, h: self.h, q: &mut state.q, p: &mut state.p, dw };
        let (Self { system, prepared, .. }, mut carry) = (&mut *self, C::default());
        let (room, lost) = (&mut memory, &mut carry);
        match SchemeOf::<H, E>::advance::<f64, f64, C, false>(system, prepared, at, room, lost) {
            Ok(effort) => {
                self.before += self.time.ticks;
                (self.memory, self.carry) = (memory, carry);
                self.arrive(state, self.after(time), dw);
                Ok(StepInfo { iterations: effort.iterations, ..StepInfo::default() })
            }
            Err(cause) => {
                memory.adopt(left);
                self.memory = memory;
                Err(self.error(state, dw, cause))
            }
        }
    }

    /// A step that is none of the usual ones, from this time on.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step_rarely(
        &mut self,
        state: &mut State<H::Vector>,
        dw: &[f64],
        time: StepTime,
        cause: RareCause<MemoryOf<H, E, f64>>,
    ) -> Result<StepInfo, StepError> {
        cold();
        // Time that is counted from here.
        let is_moved = time.ticks == 0;
        let (is_unguided, pinned) = match &cause {
            RareCause::Unguided(memory) => (true, memory.report().pinned),
            RareCause::Failed(_) => (false, self.memory.report().pinned),
        };
        let hard = HardStep {
            system: self.system,
            prepared: self.prepared.clone(),
            t: state.t,
            h: self.h,
            q: state.q.clone(),
            p: state.p.clone(),
            dw: ShortOrLong::of(dw),
            carry: if is_moved { C::default() } else { self.carry.clone() },
        };
        // Care takes Newton's method, which a pinned fixed point excludes.
        let is_iterated = pinned != Iteration::FixedPoint;
        let TakenRareStep { taken, is_hard } = match (RareStep { hard, is_iterated }).take(cause) {
            Ok(arrived) => arrived,
            Err(RefusedStep { cause, memory }) => {
                if let Some(memory) = memory {
                    self.memory = memory;
                }
                return Err(self.error(state, dw, cause));
            }
        };
        if is_moved {
            self.before += self.time.ticks;
        }
        if is_unguided {
            self.memory = taken.memory;
        } else {
            self.memory.adopt(taken.memory);
        }
        (state.q, state.p) = (taken.q, taken.p);
        self.carry = taken.carry;
        self.arrive(state, time.next(self.h), dw);
        if is_hard && const { may_mislead::<H, E>() } {
            self.time = self.time.unguided();
        }
        let is_doubtful = is_hard && taken.effort.is_doubtful();
        Ok(StepInfo { iterations: taken.effort.iterations, halvings: 0, is_hard, is_doubtful })
    }

    /// Whether steps use what the ones before left; otherwise nothing of them is kept.
    const REMEMBERS: bool = H::PROPERTIES.remembers || C::CARRIES;

    /// Whether the caller moved the state since the last step: then what that step left is no guide.
    #[inline]
    fn jumped(&self, state: &State<H::Vector>) -> bool {
        Self::REMEMBERS && !(are_equal(&state.q, &self.reached[0]) && are_equal(&state.p, &self.reached[1]))
    }

    /// Bad input shows in the result of a step, so that a good step does not pay for the check.
    ///
    /// Inlined, and each list read by itself: state and increments stay in registers only where nothing walks
    /// over their addresses.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn error(&self, state: &State<H::Vector>, dw: &[f64], cause: StepFailure) -> StepError {
        let of_state = zero_if_finite(state.q.components()) + zero_if_finite(state.p.components());
        let zero = of_state + zero_if_finite(dw) + 0.0 * state.t;
        cold();
        let is_good = zero == 0.0 || cause.is_of_arguments();
        let cause = if is_good { explained(self.system, cause) } else { StepFailure::NonFiniteInput };
        let h = if H::PROPERTIES.is_clocked { f64::NAN } else { self.h };
        StepError { step: self.steps(), t: state.t, h, cause }
    }
}

/// The energy that a step of a path exchanged beside what its scheme accounts for, by the dense output of
/// this step.
pub(crate) fn beside_scheme<H: Discretized<E>, E>(
    system: &H,
    [from, to]: [&State<H::Vector>; 2],
    dense: &DenseOutput<H::Vector>,
    dw: &[f64],
) -> Exchange {
    if !account::is_wanted::<H, E>(system) {
        return Exchange::default();
    }
    let mut ledger = EnergyLedger::of(from, H::PLAN.order);
    ledger.dense.clone_from(dense);
    ledger.exchanged::<H, E>(system, to, to.t - from.t, dw)
}

/// Whether what a hard step leaves may mislead the next: it knows one point of the curve that steps follow,
/// which may be nearer to another solution than to the one that continues the state. A step after a hard one
/// is therefore checked as a first one is.
pub(crate) const fn may_mislead<H: Discretized<E>, E>() -> bool {
    H::PROPERTIES.remembers && checks_starts::<H, E>()
}

/// Whether steps without a guide are checked ([`HardStep::check`]). With noise no step has one, and none is
/// checked.
pub(crate) const fn checks_starts<H: Discretized<E>, E>() -> bool {
    matches!(H::PLAN.solver, Solver::Newton)
        && matches!(H::PLAN.noise, NoiseClass::None)
        && !H::PROPERTIES.is_clocked
}

/// The data that do not change from step to step, if the system is valid.
///
/// # Errors
/// The errors of the system, with the name of a parameter that is no number.
pub(crate) fn prepared<H: Discretized<E>, E>(system: &H, h: f64) -> Result<PreparedOf<H, E>, ConfigError> {
    match system.validate().and_then(|()| SchemeOf::<H, E>::prepare(system, &as_they_are, h)) {
        Err(ConfigError::Parameter) => Err(mistaken_parameter(system)
            .map_or(ConfigError::Parameter, |parameter| ConfigError::NotANumber { parameter })),
        prepared => prepared,
    }
}

/// Zero times a finite number is zero, and NaN otherwise.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn zero_if_finite(list: &[f64]) -> f64 {
    list.iter().fold(0.0, |zeros, x| zeros + x * 0.0)
}

/// Marks the branch that calls it as the unlikely one. The compiler sees the mark, and no call is left.
#[cold]
#[cfg_attr(not(debug_assertions), inline(always))]
fn cold() {}
