//! Steps in the extended phase space, with the time `τ` of a clock: [`Extended`](super::Extended) and
//! [`Logarithmic`](super::Logarithmic).
//!
//! Time `t` is a coordinate here, and its momentum `p_t` is minus the energy. With `D = H + p_t`, which is 0
//! at the start, the Hamiltonian `K = Q D` has the motion of `H` in the time `τ` with `dt/dτ = Q`:
//!
//! ```text
//! dq/dτ = Q H_p + D Q_p,   dp/dτ = -(Q H_q + D Q_q),   dt/dτ = Q,   dp_t/dτ = -(Q H_t + D Q_t)
//! p_t(0) = -H(z_0)
//! ```
//!
//! A symplectic step of constant `ε` nearly keeps `K`. So an error `D` of the energy that arises where `Q` is
//! small is divided by the ratio of `Q` where it is large. `p_t` is not set anew at nodes, which would
//! switch this off.
//!
//! A step is over when `q`, `p` and `t` have moved; all three are compensated sums.

mod gauss;
mod logarithmic;
mod pair;
#[cfg(test)]
mod tests;

pub use gauss::{ExtendedGauss, StageMemory};
pub use logarithmic::{LogarithmicSplitting, SplittingNode};
pub use pair::{ExplicitPair, PairNode};

use super::ClockReading;
use super::evaluation::SystemIn;
use crate::algebra::memory::{MemoryRequest, SolverReport, StepMemory};
use crate::algebra::scalar::{Constant, Scalar};
use crate::algebra::shape::Dynamic;
use crate::algebra::solve::Effort;
use crate::algebra::state_sum::{CompensatedSum, FixedCompensatedSum, StateSum as _};
use crate::error::{ConfigError, StepFailure, wrong};
use crate::ground::numbers::{Numbers, Tape, numbers};
use crate::scheme::elements::{Elements, Role};
use crate::scheme::plan::{KeptEnergy, NoiseClass};
use crate::scheme::system::{LiftParameter, Properties, StepArguments, check_lengths, varied_without_lists};

/// Time and its momentum at a node.
#[derive(Clone, Copy, Debug, Default)]
struct TimeNode<N> {
    t: N,
    /// The rounding error of `t`.
    lost: N,
    /// `p_t`
    momentum: N,
}

numbers! { impl[N: Scalar] Numbers for TimeNode<N> { kept: t, lost, momentum } }

impl<N: Scalar> TimeNode<N> {
    fn move_time(&mut self, change: N) {
        (self.t, self.lost) = FixedCompensatedSum::<N, 1>::add(self.t, change, self.lost);
    }
}

/// Adds increments to coordinates or momenta, with the rounding errors of the sums.
fn add<N: Scalar>(state: &mut [N], lost: &mut [N], increment: impl Fn(usize) -> N) {
    for (i, (number, lost)) in state.iter_mut().zip(lost).enumerate() {
        (*number, *lost) = FixedCompensatedSum::<N, 1>::add(*number, increment(i), *lost);
    }
}

/// A point of the extended phase space, with the rounding errors of its coordinates and momenta.
#[derive(Debug, Default)]
struct ExtendedState<N: Scalar> {
    time: TimeNode<N>,
    q: Vec<N>,
    p: Vec<N>,
    carry: CompensatedSum<N, Dynamic>,
}

/// How a step of `ε` moves a point of the extended phase space.
trait ExtendedStep<H, N: Scalar> {
    /// The data that a step leaves for the next one.
    type Memory: StepMemory;

    /// Moves the state. On `Err` it may be anywhere.
    fn take(
        &self,
        system: &SystemIn<'_, H, N>,
        eps: N,
        state: &mut ExtendedState<N>,
        memory: &mut Self::Memory,
    ) -> Result<Effort, StepFailure>;
}

/// The memory of steps in the extended phase space.
#[derive(Debug)]
pub struct ExtendedMemory<N: Scalar, M> {
    /// Whether there was a step.
    is_started: bool,
    state: ExtendedState<N>,
    of_step: M,
    reading: ClockReading,
    /// Scratch: what a step changes, before it.
    saved: (M, CompensatedSum<N, Dynamic>),
}

impl<N: Scalar, M: Default> Default for ExtendedMemory<N, M> {
    fn default() -> Self {
        Self {
            is_started: false,
            state: ExtendedState::default(),
            of_step: M::default(),
            reading: ClockReading { t: f64::NAN, h: f64::NAN, density: f64::NAN },
            saved: (M::default(), CompensatedSum::default()),
        }
    }
}

/// A copy makes its own scratch.
impl<N: Scalar, M: StepMemory> Clone for ExtendedMemory<N, M> {
    fn clone(&self) -> Self {
        let Self { is_started, reading, .. } = *self;
        let ExtendedState { time, carry, .. } = &self.state;
        let state = ExtendedState { time: *time, carry: carry.clone(), ..ExtendedState::default() };
        Self { is_started, state, of_step: self.of_step.clone(), reading, ..Self::default() }
    }
}

impl<N: Scalar, M: StepMemory> Numbers for ExtendedMemory<N, M> {
    fn pass(&mut self, tape: &mut Tape) {
        tape.flag(&mut self.is_started);
        self.state.time.pass(tape);
        self.state.carry.pass(tape);
        self.of_step.pass(tape);
    }
}

impl<N: Scalar, M: StepMemory> StepMemory for ExtendedMemory<N, M> {
    fn tell(&mut self, request: &MemoryRequest) {
        if let MemoryRequest::Forget = request {
            self.is_started = false;
        }
        self.of_step.tell(request);
    }

    fn report(&self) -> SolverReport {
        self.of_step.report()
    }
}

/// One step of `ε` from `(q, p)` at `t` in place. On `Err` nothing has changed.
///
/// # Errors
/// The errors of the step, and [`StepFailure::Dimension`] where sizes do not fit.
fn advance<H: Elements, S: Scalar, T: ExtendedStep<H, S::Constant>>(
    step: &T,
    system: &SystemIn<'_, H, S::Constant>,
    StepArguments { t, h: eps, q, p, dw }: StepArguments<'_, S, S::Constant>,
    memory: &mut ExtendedMemory<S::Constant, T::Memory>,
) -> Result<Effort, StepFailure> {
    let degrees = q.len();
    check_lengths(system.system, memory.state.q.len() == degrees, [degrees, p.len(), dw.len()])?;
    let ExtendedMemory { is_started, state, of_step, reading, saved } = memory;
    let before = state.time;
    for (own, given) in [(&mut state.q, &*q), (&mut state.p, &*p)] {
        own.clear();
        own.extend(given.iter().map(|number| number.to_constant()));
    }
    saved.0.copy(of_step);
    saved.1.clone_from(&state.carry);
    if !*is_started || before.t.lane(0) != t.lane(0) {
        let energy = system.value(Role::Drift, t, [&state.q, &state.p]);
        state.time = TimeNode { t, lost: Scalar::from_f64(0.0), momentum: -energy };
        state.carry = CompensatedSum::default();
        of_step.tell(&MemoryRequest::Forget);
    }
    let start = state.time;
    let taken = step.take(system, eps, state, of_step).and_then(|effort| {
        let numbers = state.q.iter().chain(&state.p).chain([&state.time.t, &state.time.momentum]);
        let are_finite = numbers.fold(true, |all, number| all & number.is_finite());
        if are_finite { Ok(effort) } else { Err(StepFailure::NonFinite) }
    });
    if taken.is_err() {
        state.time = before;
        std::mem::swap(of_step, &mut saved.0);
        std::mem::swap(&mut state.carry, &mut saved.1);
        return taken;
    }
    let h = (state.time.t - start.t) + (state.time.lost - start.lost);
    *reading = ClockReading { t: state.time.t.lane(0), h: h.lane(0), density: f64::NAN };
    *is_started = true;
    for (own, end) in q.iter_mut().zip(&state.q).chain(p.iter_mut().zip(&state.p)) {
        *own = S::of_constant(*end);
    }
    taken
}

/// The parameters, for a system that these steps take.
///
/// # Errors
/// [`ConfigError::Setting`] with noise, friction or forces, and if an entry of a list has a derivative.
fn prepare<H: Elements, K: Constant>(system: &H, lift: LiftParameter<'_, K>) -> Result<Vec<K>, ConfigError> {
    if !matches!(H::FACTS.noise, NoiseClass::None) {
        return wrong(
            "a clock that extends the phase space takes no noise: the time of a step, and so the law of its \
             increments, would depend on these; write `Clocked<E>`, whose step has its length beforehand",
        );
    }
    if H::FACTS.is_damped || H::FACTS.kind.is_forced || H::FACTS.kind.is_conformal {
        return wrong(
            "a clock that extends the phase space takes neither friction nor forces, which have no \
             Hamiltonian; write `Clocked<E>`",
        );
    }
    varied_without_lists(system, lift)
}

/// The properties of steps in the extended phase space, from those without a clock.
const fn properties(of_step: Properties, kept_energy: KeptEnergy) -> Properties {
    Properties {
        kept_energy,
        remembers: true,
        in_lanes: false,
        differentiates_lanes: false,
        has_polynomial: false,
        is_variational: false,
        is_clocked: true,
        poles: None,
        ..of_step
    }
}
