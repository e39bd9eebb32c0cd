//! User-defined one-step schemes.

use std::cell::Cell;
use std::marker::PhantomData;

use super::{
    Discretized, LiftParameter, Movable, Properties, Scheme, StepArguments, check_lengths,
    varied_without_lists,
};
use crate::algebra::memory::step_memory;
use crate::algebra::scalar::{ComputesWith, Constant, Mask, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state_sum::{PlainSum, StateSum};
use crate::error::{ConfigError, StepFailure, wrong};
use crate::scheme::elements::{self, Elements, PairColumns};
use crate::scheme::plan::{Plan, Solver};

/// A user-defined one-step scheme for all systems: its name in `simulate`, `stepper` and `ensemble` is
/// [`Own<Self>`](Own).
///
/// It integrates the step Hamiltonian `F = h H_0 + Σ_k ΔW_k H_k` with the forces of the system, and reads
/// nothing else. Numbers are any [`Scalar`]: one path, paths in the lanes of vector registers, dual numbers.
///
/// ```ignore
/// use wzvi::embedding::{OneStep, Own};
/// use wzvi::error::StepFailure;
/// use wzvi::prelude::*;
/// use wzvi::scalar::Scalar;
/// use wzvi::system::{Scratch, StepField};
///
/// /// The explicit mid-point rule.
/// struct Runge;
///
/// impl OneStep for Runge {
///     const ORDER: u32 = 2;
///     const IS_CONSISTENT: bool = true;
///
///     fn step<S: Scalar>(
///         field: &impl StepField<S>,
///         [q, p]: [&mut [S]; 2],
///         scratch: &mut Scratch<S>,
///     ) -> Result<(), StepFailure> {
///         let [dq, dp, mid_q, mid_p] = scratch.lists(q.len());
///         field.at(0.0, [q, p], [dq, dp]);
///         for i in 0..q.len() {
///             mid_q[i] = q[i] + dq[i] * 0.5;
///             mid_p[i] = p[i] + dp[i] * 0.5;
///         }
///         field.at(0.5, [mid_q, mid_p], [dq, dp]);
///         for i in 0..q.len() {
///             q[i] = q[i] + dq[i];
///             p[i] = p[i] + dp[i];
///         }
///         Ok(())
///     }
/// }
///
/// #[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), embedding = Midpoint)]
/// struct Pendulum;
///
/// let start = State::new([0.5], [0.0]);
/// let path = Pendulum.simulate::<Own<Runge>>(0.01).start(start).until(10.0).run()?;
/// let many = Pendulum.ensemble::<Own<Runge>>(0.01).start(start).paths(100).until(10.0).observe("q", |s| s.q[0]).run()?;
/// assert!((path.last().q[0] - many.mean("q")?).abs() < 1e-12);
/// # Ok::<(), wzvi::Error>(())
/// ```
pub trait OneStep {
    /// The order in `h` without noise.
    const ORDER: u32;

    /// Whether steps converge to the Stratonovich system as `h` goes to zero, for every noise.
    const IS_CONSISTENT: bool;

    /// Its description in `EQUATIONS`.
    const TEXT: &'static str = "a scheme of the program";

    /// One step of the state in place. If the new state is not finite, the step fails and the old state
    /// remains.
    ///
    /// # Errors
    /// If it finds no solution.
    fn step<S: Scalar>(
        field: &impl StepField<S>,
        state: [&mut [S]; 2],
        scratch: &mut Scratch<S>,
    ) -> Result<(), StepFailure>;
}

/// The vector field of the step Hamiltonian of one step.
pub trait StepField<S> {
    /// `Δq = ∂F/∂p` and `Δp = -∂F/∂q + forces`, with `F` at the time `t + c h`.
    fn at(&self, c: f64, state: [&[S]; 2], increments: [&mut [S]; 2]);
}

/// Scratch lists of a step, allocated once.
#[derive(Debug, Default)]
pub struct Scratch<S> {
    numbers: Vec<S>,
    columns: PairColumns,
    /// The state before the step.
    before: [Vec<S>; 2],
}

impl<S: Scalar> Scratch<S> {
    /// `N` lists of this length, with unspecified content.
    pub fn lists<const N: usize>(&mut self, length: usize) -> [&mut [S]; N] {
        self.numbers.resize(self.numbers.len().max(N * length), S::from_f64(0.0));
        let mut rest = &mut self.numbers[..];
        std::array::from_fn(|_| {
            let (list, others) = std::mem::take(&mut rest).split_at_mut(length);
            rest = others;
            list
        })
    }

    fn save(&mut self, state: [&[S]; 2]) {
        for (before, now) in self.before.iter_mut().zip(state) {
            before.clear();
            before.extend_from_slice(now);
        }
    }

    /// Restores the state before the step for the paths that have not `taken` it.
    fn restore(&self, taken: S::Mask, state: [&mut [S]; 2]) {
        for (now, before) in state.into_iter().zip(&self.before) {
            now.iter_mut().zip(before).for_each(|(now, before)| *now = S::select(taken, *now, *before));
        }
    }
}

step_memory! { impl[S: Scalar] StepMemory for Scratch<S> { kept: ; scratch: numbers, columns, before } }

/// Steps of a [user-defined scheme](OneStep).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Own<T>(PhantomData<T>);

/// The field that a step reads.
struct FieldOfStep<'a, H, S: Scalar> {
    system: &'a H,
    parameters: &'a [S::Constant],
    t: S::Constant,
    h: S::Constant,
    dw: &'a [S],
    columns: Cell<PairColumns>,
}

impl<H: Elements, S: Scalar> StepField<S> for FieldOfStep<'_, H, S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn at(&self, c: f64, [q, p]: [&[S]; 2], [dq, dp]: [&mut [S]; 2]) {
        let &Self { system, parameters, t, h, dw, .. } = self;
        let mut columns = self.columns.take();
        let (t, h) = (S::of_constant(h * c + t), S::of_constant(h));
        elements::field::<_, S, true, true>(
            (system, parameters),
            ([t, h], [q, p], dw),
            [dp, dq],
            &mut columns,
        );
        self.columns.set(columns);
        dp.iter_mut().for_each(|slope| *slope = -*slope);
    }
}

impl<H: Elements, T: OneStep> Discretized<Own<T>> for H {
    type Scheme = Own<T>;
    type Prepared = Vec<f64>;
    const EQUATIONS: &'static str = T::TEXT;
}

impl<H: Elements, T: OneStep> Scheme<H> for Own<T> {
    /// Its weak order with noise is one: nothing is known of where it takes its increments.
    const PLAN: Plan =
        Plan { has_weak_order_two: false, ..H::FACTS.plan(Solver::Explicit, 0, T::ORDER, T::IS_CONSISTENT) };
    const PROPERTIES: Properties =
        Properties { is_variational: false, ..Properties::of(&<Self as Scheme<H>>::PLAN, 0) };
    /// All parameters, where they have derivatives.
    type Prepared<K: Constant> = Vec<K>;
    type Memory<S: Scalar> = Scratch<S>;
    type Unclocked = Self;
    type CompensatedSum<S: Scalar> = PlainSum;
    type Sum<S: Scalar> = PlainSum;

    fn prepare<K: Constant>(system: &H, lift: LiftParameter<'_, K>, _: K) -> Result<Vec<K>, ConfigError> {
        if H::FACTS.is_damped {
            return wrong(
                "a scheme of one's own takes no friction and no bath: write them as a `force` and a noise",
            );
        }
        elements::check_new(system)?;
        varied_without_lists(system, lift)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        system: &H,
        parameters: &Vec<K>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        scratch: &mut Scratch<S>,
        _: &mut C,
    ) -> Result<Effort, StepFailure> {
        let (StepArguments { t, h, q, p, dw }, parameters) = (at.lists().shared(), S::varied(parameters));
        check_lengths(system, scratch.before[0].len() == q.len(), [q.len(), p.len(), dw.len()])?;
        scratch.save([q, p]);
        let columns = Cell::new(std::mem::take(&mut scratch.columns));
        let field = FieldOfStep { system, parameters, t, h, dw, columns };
        let solved = T::step(&field, [&mut *q, &mut *p], scratch);
        scratch.columns = field.columns.into_inner();
        if let Err(failure) = solved {
            scratch.restore(S::Mask::from_bool(false), [q, p]);
            return Err(failure);
        }
        let are_finite = q.iter().chain(&*p).fold(S::Mask::from_bool(true), |all, x| all & x.is_finite());
        if are_finite.all() {
            return Ok(Effort::fast(0));
        }
        scratch.restore(are_finite, [q, p]);
        Err(StepFailure::but_of::<S>(are_finite))
    }
}
