//! The splitting of `K = f(T + p_t) - f(-V)` with `f'(x) = x^{-a}`, `a = N/D`:
//! [`Logarithmic<N, D>`](super::super::Logarithmic).
//!
//! On the exact motion `T + p_t = -V`, so that `K` has the motion of `H = T(p) + V(q)` in a time with
//! `dt/dτ = (-V)^{-a}`. Both parts have exact flows:
//!
//! ```text
//! A(e)   q ← q + e (T + p_t)^{-a} T',   t ← t + e (T + p_t)^{-a}
//! B(e)   p ← p - e (-V)^{-a} V'
//! ```
//!
//! A step is `A(ε/2) B(ε) A(ε/2)`. For `a = 1` the orbits of Kepler's problem are exact but for their time
//! (S. Mikkola, K. Tanikawa, "Explicit symplectic algorithms for time-transformed Hamiltonians", Celest.
//! Mech. Dyn. Astron. 74, 1999; M. Preto, S. Tremaine, "A class of symplectic integrators with adaptive time
//! step for separable Hamiltonian systems", Astron. J. 118, 1999).

use std::marker::PhantomData;

use super::super::evaluation::{SystemIn, is_positive};
use super::super::{Attractive, ClockReading, Logarithmic, text};
use super::{ExtendedMemory, ExtendedState, ExtendedStep, add, advance, prepare, properties};
use crate::algebra::memory::step_memory;
use crate::algebra::scalar::{ComputesWith, Constant, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state_sum::{PlainSum, StateSum};
use crate::error::{ConfigError, StepFailure, wrong};
use crate::scheme::compose::{ComposedWord, Composes, SingleStep, Symmetric, Verlet, WholeOf, plan};
use crate::scheme::elements::{PairColumns, Role};
use crate::scheme::plan::{KeptEnergy, Plan};
use crate::scheme::system::{Discretized, LiftParameter, Movable, Properties, Scheme, StepArguments};
use crate::scheme::word::{Part, Substep, Weighted, Word};

/// Drifts and kicks `W` of the splitting with the exponent `N/D`.
#[derive(Clone, Copy, Debug)]
pub struct LogarithmicSplitting<W, const N: u32, const D: u32>(PhantomData<W>);

impl<H, const N: u32, const D: u32> Discretized<Logarithmic<N, D>> for H
where
    H: Attractive + Discretized<Verlet>,
    SingleStep: Composes<Logarithmic<N, D>, H::Structure, Steps: Scheme<H>>,
{
    type Scheme = WholeOf<H, Logarithmic<N, D>>;
    type Prepared = <Self::Scheme as Scheme<H>>::Prepared<f64>;
    const EQUATIONS: &'static str = text::LogarithmicText::<H>::ALL;
}

impl<K, const N: u32, const D: u32> Symmetric<K> for Logarithmic<N, D> {
    type Basic = Self;
    type Adjoint = Self;
    type Part = Part;
    type Steps<W> = LogarithmicSplitting<W, N, D>;
    const STEP: &'static [Weighted] = &[
        Weighted { part: Part::A, weight: 0.5 },
        Weighted { part: Part::B, weight: 1.0 },
        Weighted { part: Part::A, weight: 0.5 },
    ];
}

impl<H, T, W, const N: u32, const D: u32> Scheme<H>
    for LogarithmicSplitting<ComposedWord<Logarithmic<N, D>, T, W>, N, D>
where
    H: Attractive,
    W: Composes<Logarithmic<N, D>, T, Part = Part> + Composes<Verlet, T>,
    <W as Composes<Verlet, T>>::Steps: Scheme<H>,
{
    const PLAN: Plan = plan(H::FACTS.explicit(), <W as Composes<Logarithmic<N, D>, T>>::ORDER);
    const PROPERTIES: Properties =
        properties(Properties::of(&<Self as Scheme<H>>::PLAN, 1), KeptEnergy::Nearly);
    /// The word of a step, and the parameters.
    type Prepared<K: Constant> = (Word, Vec<K>);
    type Memory<S: Scalar> = ExtendedMemory<S::Constant, SplittingNode<S::Constant>>;
    type Unclocked = <W as Composes<Verlet, T>>::Steps;
    type CompensatedSum<S: Scalar> = PlainSum;
    type Sum<S: Scalar> = PlainSum;

    fn prepare<K: Constant>(
        system: &H,
        lift: LiftParameter<'_, K>,
        _: K,
    ) -> Result<Self::Prepared<K>, ConfigError> {
        const { assert!(N > 0 && D > 0, "`Logarithmic<N, D>` has the exponent `N/D`, which is positive") }
        if H::FACTS.kind.reads_time {
            return wrong(
                "the steps of `Logarithmic<N, D>` take no Hamiltonian that reads the time; write \
                 `Clocked<E>` or `Extended<Gauss<S>>`",
            );
        }
        Ok((<W as Composes<Logarithmic<N, D>, T>>::word(), prepare(system, lift)?))
    }

    fn resize<K: Constant>(
        _: &H,
        _: LiftParameter<'_, K>,
        _: &mut Self::Prepared<K>,
        _: K,
    ) -> Result<(), ConfigError> {
        Ok(())
    }

    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        system: &H,
        (word, parameters): &Self::Prepared<K>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut Self::Memory<S>,
        _: &mut C,
    ) -> Result<Effort, StepFailure> {
        let system = SystemIn { system, parameters: S::varied(parameters) };
        advance(&SplittingWord::<N, D>(word), &system, at.lists().shared(), memory)
    }

    fn reading(memory: &Self::Memory<f64>) -> ClockReading {
        memory.reading
    }
}

/// `x^{-N/D}`
fn power<S: Scalar, const N: u32, const D: u32>(x: S) -> S {
    match (i32::try_from(N), D) {
        (Ok(n), 1) => x.powi(n).recip(),
        (Ok(n), 2) => x.sqrt().powi(n).recip(),
        _ => x.powf(S::from_f64(-f64::from(N) / f64::from(D))),
    }
}

/// Drifts and kicks with the exponent `N/D`.
pub(super) struct SplittingWord<'a, const N: u32, const D: u32>(pub(super) &'a Word);

/// Lists of a step.
#[derive(Debug, Default)]
pub struct SplittingNode<N: Scalar> {
    /// `T'` or `V'`
    slopes: Vec<N>,
    /// The rounding errors of coordinates and momenta.
    lost: [Vec<N>; 2],
    columns: PairColumns,
}

step_memory! {
    impl[N: Scalar] StepMemory for SplittingNode<N> { kept: ; scratch: slopes, lost, columns }
}

impl<H: Attractive, S: Constant<Constant = S>, const N: u32, const D: u32> ExtendedStep<H, S>
    for SplittingWord<'_, N, D>
{
    type Memory = SplittingNode<S>;

    fn take(
        &self,
        system: &SystemIn<'_, H, S>,
        eps: S,
        ExtendedState { time, q, p, carry }: &mut ExtendedState<S>,
        SplittingNode { slopes, lost, columns }: &mut SplittingNode<S>,
    ) -> Result<Effort, StepFailure> {
        let zero = S::from_f64(0.0);
        slopes.resize(q.len(), zero);
        for (own, lost) in lost.iter_mut().zip(carry.lists(q.len())) {
            own.clear();
            own.extend_from_slice(lost);
        }
        let [lost_q, lost_p] = lost;
        for Substep { part, weight, .. } in &self.0.substeps {
            let is_drift = part.drifts();
            let base = match is_drift {
                true => system.value(Role::Summand(0), zero, [q, p]) + time.momentum,
                false => -system.value(Role::Summand(1), zero, [q, p]),
            };
            let value = base.lane(0);
            if !is_positive(value) {
                return Err(match is_drift {
                    true => StepFailure::ClockTooCoarse { density: value },
                    false => StepFailure::ClockNotPositive { value },
                });
            }
            let duration = eps * *weight * power::<S, N, D>(base);
            if is_drift {
                system.by_p(Role::Summand(0), zero, [q, p], slopes, columns);
                add(q, lost_q, |i| duration * slopes[i]);
                time.move_time(duration);
            } else {
                system.by_q(Role::Summand(1), zero, [q, p], slopes, columns);
                add(p, lost_p, |i| -duration * slopes[i]);
            }
        }
        carry.keep(lost_q, lost_p);
        Ok(Effort::fast(0))
    }
}
