//! Steps whose size follows a density: [`Clocked`](super::Clocked).
//!
//! With the weights `γ_i` of a composition, or `γ_1 = 1`, a step of the clock is
//!
//! ```text
//! for each i:   ρ ← ρ + γ_i (eps/2) G(z),   h = γ_i eps/ρ,   z ← Φ_h(z),   ρ ← ρ + γ_i (eps/2) G(z)
//! ```
//!
//! from `ρ_0 = 1/Q(z_0)`. Each substep is a symmetric splitting of `z' = f/ρ`, `ρ' = G` in the time `τ` of
//! the clock, and `G` at the end of one is that at the start of the next.

use std::fmt::Debug;
use std::marker::PhantomData;

use super::evaluation::{SystemIn, is_positive};
use super::{Clock, ClockReading, Clocked, SelfAdjoint, text};
use crate::algebra::memory::{MemoryRequest, SolverReport, StepMemory};
use crate::algebra::scalar::{ComputesWith, Constant, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state::{State, Vector};
use crate::algebra::state_sum::{FixedCompensatedSum, PlainSum, StateSum};
use crate::error::{ConfigError, StepFailure, wrong};
use crate::ground::numbers::{Numbers, Tape};
use crate::scheme::compose::{BasicMethod, ComposedWord, Composes, Symmetric, WHOLE, plan};
use crate::scheme::dense::{RateCoefficients, hermite_order};
use crate::scheme::elements::Elements;
use crate::scheme::plan::{KeptEnergy, NoiseClass, Plan};
use crate::scheme::system::{
    Discretized, Hamiltonian, LiftParameter, MemoryOf, Movable, PreparedOf, Properties, Scheme, SchemeOf,
    StepArguments, anew, check_state, varied_without_lists,
};
use crate::scheme::word::Weighted;

/// Steps of `E` by a clock.
#[derive(Clone, Copy, Debug)]
pub struct ClockedSteps<E>(PhantomData<E>);

/// Steps of `E` by a clock with the weights of the word `W`, each over its own time.
#[derive(Clone, Copy, Debug)]
pub struct ClockedComposition<E, W>(PhantomData<(E, W)>);

impl<H, E> Discretized<Clocked<E>> for H
where
    H: Elements + Clock + Discretized<E>,
    E: SelfAdjoint,
{
    type Scheme = ClockedSteps<E>;
    type Prepared = Vec<f64>;
    const EQUATIONS: &'static str = text::ClockedText::<H, E>::ALL;
}

impl<E: Symmetric<K> + SelfAdjoint, K> Symmetric<K> for Clocked<E> {
    type Basic = Self;
    type Adjoint = Self;
    type Part = BasicMethod;
    type Steps<W> = ClockedComposition<E, W>;
    const STEP: &'static [Weighted<BasicMethod>] = WHOLE;
}

/// The properties of clocked steps, from those of the steps.
const fn properties(of_step: Properties) -> Properties {
    Properties {
        kept_energy: match of_step.kept_energy {
            KeptEnergy::Hamiltonian => KeptEnergy::Hamiltonian,
            // The others depend on the size, which changes.
            _ => KeptEnergy::Nearly,
        },
        remembers: true,
        in_lanes: false,
        is_variational: false,
        is_clocked: true,
        poles: None,
        ..of_step
    }
}

impl<H, E> Scheme<H> for ClockedSteps<E>
where
    H: Elements + Clock + Discretized<E>,
{
    const PLAN: Plan = <H as Discretized<E>>::PLAN;
    const PROPERTIES: Properties = properties(<H as Discretized<E>>::PROPERTIES);
    type Prepared<K: Constant> = Vec<K>;
    type Memory<S: Scalar> = ClockMemoryOf<H, E, S::Constant>;
    type Unclocked = SchemeOf<H, E>;
    type CompensatedSum<S: Scalar> = PlainSum;
    type Sum<S: Scalar> = PlainSum;

    fn increments(system: &H, degrees: usize) -> usize {
        SchemeOf::<H, E>::increments(system, degrees)
    }

    fn prepare<K: Constant>(
        system: &H,
        lift: LiftParameter<'_, K>,
        _: K,
    ) -> Result<Self::Prepared<K>, ConfigError> {
        prepare(system, lift)
    }

    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        system: &H,
        parameters: &Self::Prepared<K>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut Self::Memory<S>,
        _: &mut C,
    ) -> Result<Effort, StepFailure> {
        let clock = SystemIn { system, parameters: S::varied(parameters) };
        advance::<H, E, S>(&clock, [1.0], at.lists().shared(), memory)
    }

    fn slopes_between(
        system: &H,
        (_, memory): (&Self::Prepared<f64>, &Self::Memory<f64>),
        before: &State<<H as Hamiltonian>::Vector>,
        _: f64,
        dw: &[f64],
        slopes: &mut RateCoefficients,
    ) {
        if let (Some(prepared), Some(step)) = (memory.prepared.first(), memory.steps.first()) {
            let h = memory.reading.h;
            SchemeOf::<H, E>::slopes_between(system, (prepared, step), before, h, dw, slopes);
        }
    }

    fn upcoming(
        system: &H,
        parameters: &Self::Prepared<f64>,
        state: &State<<H as Hamiltonian>::Vector>,
        eps: f64,
        memory: &Self::Memory<f64>,
    ) -> Result<f64, StepFailure> {
        let clock = SystemIn { system, parameters };
        let (q, p) = (state.q.components(), state.p.components());
        let ClockState { density, rate, t, lost } = memory.state(&clock, state.t, q, p)?;
        let h = eps / positive(density + eps * 0.5 * rate)?;
        Ok(FixedCompensatedSum::<f64, 1>::add(t, h, lost).0)
    }

    fn reading(memory: &Self::Memory<f64>) -> ClockReading {
        memory.reading
    }
}

impl<H, E, T, W> Scheme<H> for ClockedComposition<E, ComposedWord<Clocked<E>, T, W>>
where
    H: Elements + Clock + Discretized<E>,
    W: Composes<Clocked<E>, T, Part = BasicMethod> + Composes<E, T>,
    <W as Composes<E, T>>::Steps: Scheme<H>,
{
    const PLAN: Plan = plan(<H as Discretized<E>>::PLAN, <W as Composes<E, T>>::ORDER);
    const PROPERTIES: Properties = {
        let of_step = properties(<H as Discretized<E>>::PROPERTIES);
        Properties {
            has_polynomial: false,
            dense_order: hermite_order(&<Self as Scheme<H>>::PLAN),
            ..of_step
        }
    };
    /// The weights of the steps, and the parameters.
    type Prepared<K: Constant> = (Vec<f64>, Vec<K>);
    type Memory<S: Scalar> = ClockMemoryOf<H, E, S::Constant>;
    type Unclocked = <W as Composes<E, T>>::Steps;
    type CompensatedSum<S: Scalar> = PlainSum;
    type Sum<S: Scalar> = PlainSum;

    fn prepare<K: Constant>(
        system: &H,
        lift: LiftParameter<'_, K>,
        _: K,
    ) -> Result<Self::Prepared<K>, ConfigError> {
        if !matches!(<H as Discretized<E>>::PLAN.noise, NoiseClass::None) {
            return wrong(
                "a composition of clocked steps takes no noise: its length is not known before its increments; \
                 write `Clocked<Composed<E, W>>`",
            );
        }
        let word = <W as Composes<Clocked<E>, T>>::word();
        let weights = word.substeps.iter().map(|substep| substep.weight);
        Ok((weights.collect(), prepare(system, lift)?))
    }

    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        system: &H,
        (weights, parameters): &Self::Prepared<K>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut Self::Memory<S>,
        _: &mut C,
    ) -> Result<Effort, StepFailure> {
        let clock = SystemIn { system, parameters: S::varied(parameters) };
        advance::<H, E, S>(&clock, weights.iter().copied(), at.lists().shared(), memory)
    }

    fn reading(memory: &Self::Memory<f64>) -> ClockReading {
        memory.reading
    }
}

/// The parameters, where they have derivatives.
fn prepare<H: Elements + Clock, K: Constant>(
    system: &H,
    lift: LiftParameter<'_, K>,
) -> Result<Vec<K>, ConfigError> {
    varied_without_lists(system, lift)
}

/// The memory of clocked steps of a system by `E`, in numbers `N`.
pub type ClockMemoryOf<H, E, N> =
    ClockMemory<N, MemoryOf<H, E, N>, PreparedOf<H, E, N>, <SchemeOf<H, E> as Scheme<H>>::Sum<N>>;

/// The density, the time, and the memories of the steps.
#[derive(Debug)]
pub struct ClockMemory<N, M, P, C> {
    /// Whether there was a step.
    is_started: bool,
    now: ClockState<N>,
    /// The length of the last step that each weight has taken.
    sizes: Vec<N>,
    steps: Vec<M>,
    /// The rounding errors of the state.
    carry: C,
    reading: ClockReading,
    /// Scratch: the data of the steps, made anew where there are none.
    prepared: Vec<P>,
    /// Scratch: the memories before a step, and its rounding errors.
    saved: (Vec<M>, C),
    /// Scratch: coordinates, momenta, increments.
    lists: [Vec<N>; 3],
}

/// The density and the time at a node.
#[derive(Clone, Copy, Debug, Default)]
struct ClockState<N> {
    /// `ρ`
    density: N,
    /// `G`
    rate: N,
    t: N,
    /// The rounding error of `t`.
    lost: N,
}

/// No step was taken.
const NO_READING: ClockReading = ClockReading { t: f64::NAN, h: f64::NAN, density: f64::NAN };

impl<N: Scalar, M, P, C: Default> Default for ClockMemory<N, M, P, C> {
    fn default() -> Self {
        Self {
            is_started: false,
            now: ClockState::default(),
            sizes: Vec::new(),
            steps: Vec::new(),
            carry: C::default(),
            reading: NO_READING,
            prepared: Vec::new(),
            saved: (Vec::new(), C::default()),
            lists: Default::default(),
        }
    }
}

/// A copy makes its own scratch.
impl<N: Scalar, M: StepMemory, P, C: Clone + Default> Clone for ClockMemory<N, M, P, C> {
    fn clone(&self) -> Self {
        let Self { is_started, now, reading, .. } = *self;
        let (sizes, steps, carry) = (self.sizes.clone(), self.steps.clone(), self.carry.clone());
        Self { is_started, now, sizes, steps, carry, reading, ..Self::default() }
    }
}

impl<N: Scalar, M: StepMemory, P, C: Numbers> Numbers for ClockMemory<N, M, P, C> {
    fn pass(&mut self, tape: &mut Tape) {
        tape.flag(&mut self.is_started);
        let ClockState { density, rate, t, lost } = &mut self.now;
        [density, rate, t, lost].into_iter().for_each(|number| number.pass(tape));
        let steps = tape.length(self.steps.len());
        self.sizes.resize(steps, N::default());
        self.steps.resize_with(steps, M::default);
        self.sizes.iter_mut().for_each(|size| size.pass(tape));
        self.steps.iter_mut().for_each(|step| step.pass(tape));
        self.carry.pass(tape);
        self.prepared.clear();
    }
}

impl<N: Scalar, M: StepMemory, P: Debug, C> StepMemory for ClockMemory<N, M, P, C>
where
    C: Clone + Debug + Default + Numbers,
{
    fn tell(&mut self, request: &MemoryRequest) {
        if let MemoryRequest::Forget = request {
            self.is_started = false;
            self.carry = C::default();
        }
        self.steps.iter_mut().for_each(|step| step.tell(request));
    }

    fn report(&self) -> SolverReport {
        self.steps.iter().map(M::report).fold(SolverReport::default(), SolverReport::and)
    }
}

impl<N: Constant<Constant = N>, M: StepMemory, P, C: StateSum<N>> ClockMemory<N, M, P, C> {
    /// The density and the time at a node: from the step before, or at a start.
    ///
    /// # Errors
    /// [`StepFailure::ClockNotPositive`]
    fn state<H: Clock>(
        &self,
        clock: &SystemIn<'_, H, N>,
        t: N,
        q: &[N],
        p: &[N],
    ) -> Result<ClockState<N>, StepFailure> {
        if self.is_started && self.now.t.lane(0) == t.lane(0) {
            return Ok(self.now);
        }
        let density = clock.period(t, q, p)?.recip();
        Ok(ClockState { density, rate: clock.rate(t, q, p), t, lost: Scalar::from_f64(0.0) })
    }

    /// Room for so many steps.
    fn fit(&mut self, steps: usize) {
        if self.steps.len() != steps {
            self.steps.resize_with(steps, M::default);
            self.sizes.resize(steps, N::default());
            self.prepared.clear();
            self.is_started = false;
        }
    }

    /// Keeps what a step changes.
    fn save(&mut self) {
        let (steps, carry) = &mut self.saved;
        steps.resize_with(self.steps.len(), M::default);
        steps.iter_mut().zip(&self.steps).for_each(|(saved, step)| saved.copy(step));
        carry.clone_from(&self.carry);
    }

    /// Takes that back.
    fn restore(&mut self) {
        std::mem::swap(&mut self.steps, &mut self.saved.0);
        std::mem::swap(&mut self.carry, &mut self.saved.1);
    }
}

/// Steps of a clock, one for each weight, from `(q, p)` at `t` in place. On `Err` nothing has changed.
///
/// # Errors
/// [`StepFailure::ClockNotPositive`], [`StepFailure::ClockTooCoarse`], and the errors of the steps.
fn advance<H, E, S: Scalar>(
    clock: &SystemIn<'_, H, S::Constant>,
    weights: impl IntoIterator<Item = f64, IntoIter: ExactSizeIterator>,
    StepArguments { t, h: eps, q, p, dw }: StepArguments<'_, S, S::Constant>,
    memory: &mut ClockMemoryOf<H, E, S::Constant>,
) -> Result<Effort, StepFailure>
where
    H: Elements + Clock + Discretized<E>,
{
    let (system, degrees, weights) = (clock.system, q.len(), weights.into_iter());
    check_state(system, memory.lists[0].len() == degrees, [degrees, p.len()])?;
    memory.fit(weights.len());
    for (own, given) in memory.lists.iter_mut().zip([&*q, &*p, dw]) {
        own.clear();
        own.extend(given.iter().map(|number| number.to_constant()));
    }
    let mut now = memory.state(clock, t, &memory.lists[0], &memory.lists[1])?;
    let (density, mut length, mut effort) = (now.density, 0.0, Effort::fast(0));
    memory.save();
    for (number, weight) in weights.enumerate() {
        match substep::<H, E, _>(clock, eps * weight, number, now, memory) {
            Ok((after, taken)) => {
                (now, effort) = (after, effort.and_block(taken));
                length += memory.sizes[number].lane(0);
            }
            Err(failure) => {
                memory.restore();
                return Err(failure);
            }
        }
    }
    (memory.is_started, memory.now) = (true, now);
    memory.reading = ClockReading { t: now.t.lane(0), h: length, density: density.lane(0) };
    let [end_q, end_p, _] = &memory.lists;
    for (own, end) in q.iter_mut().zip(end_q).chain(p.iter_mut().zip(end_p)) {
        *own = S::of_constant(*end);
    }
    Ok(effort)
}

/// One step of the symmetric scheme, over the time that the clock has for `eps`.
fn substep<H, E, N: Constant<Constant = N>>(
    clock: &SystemIn<'_, H, N>,
    eps: N,
    number: usize,
    ClockState { density, rate, t, lost }: ClockState<N>,
    memory: &mut ClockMemoryOf<H, E, N>,
) -> Result<(ClockState<N>, Effort), StepFailure>
where
    H: Elements + Clock + Discretized<E>,
{
    let ClockMemory { sizes, steps, carry, prepared, lists: [q, p, dw], .. } = memory;
    let density = positive(density + eps * 0.5 * rate)?;
    let h = eps / density;
    prepare_step::<H, E, N>(clock, sizes[number], h, number, prepared)?;
    let (system, prepared, step) = (clock.system, &prepared[number], &mut steps[number]);
    let at = StepArguments { t, h, q: &mut q[..], p: &mut p[..], dw: &dw[..] };
    let effort = anew::advance_carrying::<H, SchemeOf<H, E>, N, N, _>(system, prepared, at, step, carry)?;
    sizes[number] = h;
    let (t, lost) = FixedCompensatedSum::<N, 1>::add(t, h, lost);
    let rate = clock.rate(t, q, p);
    let density = positive(density + eps * 0.5 * rate)?;
    Ok((ClockState { density, rate, t, lost }, effort))
}

/// Makes the data of a step those for its length; `before` was that of the last one.
fn prepare_step<H, E, N: Constant<Constant = N>>(
    clock: &SystemIn<'_, H, N>,
    before: N,
    h: N,
    number: usize,
    prepared: &mut Vec<PreparedOf<H, E, N>>,
) -> Result<(), StepFailure>
where
    H: Elements + Clock + Discretized<E>,
{
    let SystemIn { system, parameters } = *clock;
    let lift = |number: usize, value: f64| N::parameter(parameters, number, value);
    let refused = |_| StepFailure::NonFinite;
    if prepared.len() <= number {
        let first = if before.lane(0) == 0.0 { h } else { before };
        prepared.push(SchemeOf::<H, E>::prepare(system, &lift, first).map_err(refused)?);
    }
    SchemeOf::<H, E>::resize(system, &lift, &mut prepared[number], h).map_err(refused)
}

/// # Errors
/// [`StepFailure::ClockTooCoarse`]
fn positive<N: Scalar>(density: N) -> Result<N, StepFailure> {
    let value = density.lane(0);
    if is_positive(value) { Ok(density) } else { Err(StepFailure::ClockTooCoarse { density: value }) }
}
