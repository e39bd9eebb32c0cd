//! What takes the steps of a system: one trait for every scheme.

use std::fmt::Debug;

use super::{Exchange, Hamiltonian, LagrangianGradient, Segment, by_dual_numbers};
use crate::algebra::carry::Carry;
use crate::algebra::lanes::Lanes;
use crate::algebra::memory::StepMemory;
use crate::algebra::scalar::{Constant, Over, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state::{State, Vector};
use crate::error::{ConfigError, StepFailure, StepPromise};
use crate::scheme::dense::{Slopes, hermite_order};
use crate::scheme::plan::{KeptEnergy, NoiseClass, Plan, Solver};

/// What a step reads and moves: the state `(q, p)` at `t`, the step size and the increments.
#[derive(Debug)]
pub struct At<'a, S, K = f64> {
    /// Time at the start of the step.
    pub t: K,
    /// Step size.
    pub h: K,
    /// Coordinates, one number per degree of freedom.
    pub q: &'a mut [S],
    /// Momenta, likewise.
    pub p: &'a mut [S],
    /// Increments, [`Scheme::increments`] of them.
    pub dw: &'a [S],
}

impl<'a, S, K: Constant> At<'a, S, K> {
    /// With time and step size as `f64`, which is what a scheme prepared that takes no derivatives along.
    ///
    /// # Errors
    /// [`StepPromise::PlainConstants`] where they are none.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn plain(self) -> Result<At<'a, S>, StepFailure> {
        let Self { t, h, q, p, dw } = self;
        match K::plain(&[t, h]) {
            Some(&[t, h]) => Ok(At { t, h, q, p, dw }),
            _ => Err(StepFailure::Internal(StepPromise::PlainConstants)),
        }
    }
}

/// A parameter of the system as a constant of a step, from its number among [`Hamiltonian::parameter`] and its value.
pub type Lift<'l, K> = &'l dyn Fn(usize, f64) -> K;

/// [`Lift`] to what they are.
pub fn as_they_are(_: usize, value: f64) -> f64 {
    value
}

/// The step size, where it is an `f64` and so are the parameters.
///
/// # Errors
/// [`ConfigError::Setting`] where they have derivatives, which the scheme does not take along.
pub(crate) fn without_derivatives<K: Constant>(h: K) -> Result<f64, ConfigError> {
    match K::plain(&[h]) {
        Some(&[h]) => Ok(h),
        _ => Err(ConfigError::Setting(
            "steps of this scheme have no derivatives by parameters or by the step size".into(),
        )),
    }
}

/// What runs need to know of the steps of a scheme besides its [`Plan`].
#[derive(Clone, Copy, Debug)]
pub struct Properties {
    /// The energy that is watched in runs of constant step.
    pub kept_energy: KeptEnergy,
    /// Stages whose equations are solved at once, the most of all parts of a step; 0 where none are solved.
    pub stages: u32,
    /// Whether steps use what the ones before left in memory for this state alone: then a state that the caller moved makes them forget it.
    pub remembers: bool,
    /// Whether paths run in lanes beside each other: not where loops are iterated on, which go for each path as far as it needs.
    pub in_lanes: bool,
    /// From how many degrees of freedom on the step of one path is in vector instructions by itself, and stays in the cache: then paths go one
    /// after the other. `usize::MAX` where there are no such steps.
    pub fills_registers_from: usize,
    /// The order of the error inside a step: [`DenseOutput::order`](crate::scheme::dense::DenseOutput::order).
    pub dense_order: u32,
    /// Whether the scheme has a polynomial of its own between the nodes of a step.
    pub has_polynomial: bool,
    /// Whether the scheme accounts for what forces and bath do: [`Scheme::exchanged`].
    pub exchanges: bool,
    /// Whether steps follow from a discrete Lagrangian.
    pub is_variational: bool,
}

impl Properties {
    /// Those of a variational step of one path, in lanes, with cubics between its nodes, and with a memory of so many bytes.
    pub const fn of(plan: &Plan, memory: usize) -> Self {
        Self {
            kept_energy: KeptEnergy::Hamiltonian,
            stages: if matches!(plan.solver, Solver::Explicit) { 0 } else { 1 },
            remembers: matches!(plan.noise, NoiseClass::None) && memory != 0,
            in_lanes: true,
            fills_registers_from: usize::MAX,
            dense_order: hermite_order(plan),
            has_polynomial: false,
            exchanges: false,
            is_variational: true,
        }
    }
}

/// A way to take steps of the system `H`. A scheme of one's own is a [`OneStep`](super::OneStep), which is shorter.
pub trait Scheme<H: Hamiltonian> {
    /// What the compiler derived.
    const PLAN: Plan;

    /// What runs need to know besides.
    const PROPERTIES: Properties = Properties::of(&Self::PLAN, size_of::<Self::Memory<f64>>());

    /// Everything that a step reads and that depends on the system and the step size only, in constants `K`: of one system, of one in each lane, or with
    /// derivatives.
    type Prepared<K: Constant>: Clone + Debug + Send + Sync;

    /// What one step leaves for the starting value of the next; of no size where nothing is iterated.
    type Memory<S: Scalar>: StepMemory;

    /// Compensated sums of the state's increments: [`Compensation`](crate::algebra::carry::Compensation).
    type Compensated<S: Scalar>: Carry<S>;

    /// How increments are added unless the user chooses: compensated where that is less than about 5 % of the step,
    /// else [`Plain`](crate::algebra::carry::Plain).
    type Carry<S: Scalar>: Carry<S>;

    /// The number of increments that drive a step of a state with this many degrees of freedom: those of the noises, and after them `√h` times the
    /// standard normals of a bath.
    fn increments(system: &H, degrees: usize) -> usize {
        let _ = degrees;
        system.noises()
    }

    /// The memory of a new stepper: all that its steps will need, where the system knows its size.
    fn memory(system: &H) -> Self::Memory<f64> {
        let _ = system;
        Default::default()
    }

    /// Computes what does not change from step to step, from parameters and a step size that may have derivatives.
    ///
    /// # Errors
    /// If a parameter is invalid, or a matrix that is factored here is singular; if there are derivatives and the scheme does not take them along.
    fn prepare<K: Constant>(system: &H, lift: Lift<'_, K>, h: K) -> Result<Self::Prepared<K>, ConfigError>;

    /// What is prepared of `L` systems for one step size, each in its lane; `None` where they do not go in lanes. Those that do still do where
    /// some of them are replaced by others of them.
    fn gather<const L: usize>(prepared: [&Self::Prepared<f64>; L]) -> Option<Self::Prepared<Lanes<L>>> {
        let _ = prepared;
        None
    }

    /// One step in place. Of systems in lanes, `system` is any of them: it says what is the same for all. On `Err`, the state, `memory` and `carry` are as they were; where it is that of some
    /// [lanes](StepFailure::Lanes), those of these lanes, and the others have taken the step.
    ///
    /// Unless `CAREFUL`, an iteration that does not converge fast is given up; what then follows is the
    /// business of the [`Stepper`](crate::path::step::Stepper).
    ///
    /// # Errors
    /// Where the step has no solution that could be found, or sizes do not fit.
    fn advance<K: Constant, S: Over<K>, C: Carry<S>, const CAREFUL: bool>(
        system: &H,
        prepared: &Self::Prepared<K>,
        at: At<'_, S, K>,
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure>;

    /// [`Scheme::advance`] at the time and by the step `[t, h]` of vectors that may be exchanged for others with the new numbers.
    ///
    /// # Errors
    /// Those of [`Scheme::advance`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance_vectors<C: Carry<f64>, const CAREFUL: bool>(
        system: &H,
        prepared: &Self::Prepared<f64>,
        [t, h]: [f64; 2],
        [q, p]: [&mut H::Vector; 2],
        dw: &[f64],
        memory: &mut Self::Memory<f64>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let at = At { t, h, q: q.components_mut(), p: p.components_mut(), dw };
        Self::advance::<f64, f64, C, CAREFUL>(system, prepared, at, memory, carry)
    }

    /// The slopes of the scheme's own polynomial, of the step that was the last to leave something in `memory`.
    fn slopes_between(
        system: &H,
        (prepared, memory): (&Self::Prepared<f64>, &Self::Memory<f64>),
        before: &State<H::Vector>,
        h: f64,
        dw: &[f64],
        slopes: &mut Slopes,
    ) {
        let _ = (system, prepared, memory, before, h, dw, slopes);
    }

    /// What the step exchanged that was the last to leave something in `memory`.
    fn exchanged(system: &H, memory: &Self::Memory<f64>) -> Exchange {
        let _ = (system, memory);
        Exchange::default()
    }

    /// `L_d(q_i, q_{i+1}, P; t, h, ΔW)`; NaN where there is none.
    fn discrete_lagrangian(system: &H, segment: &Segment<H::Vector>, dw: &[f64]) -> f64 {
        let _ = (system, segment, dw);
        f64::NAN
    }

    /// The gradient of [`Scheme::discrete_lagrangian`]; NaN where there is none.
    fn discrete_lagrangian_gradient(
        system: &H,
        segment: &Segment<H::Vector>,
        dw: &[f64],
    ) -> LagrangianGradient<H::Vector> {
        by_dual_numbers::gradient::<H, Self>(system, segment, dw)
    }

    /// The momentum `P` of the step from `before` to `after`.
    fn step_momentum(
        system: &H,
        before: &State<H::Vector>,
        after: &State<H::Vector>,
        h: f64,
        dw: &[f64],
    ) -> H::Vector {
        let _ = (system, after, h, dw);
        before.p.clone()
    }
}

/// That `E` is listed in the `embedding` of a system; generated.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no discretisation by `{E}`",
    label = "this scheme was not generated for `{Self}`",
    note = "add `{E}`, or the scheme that it composes, to `embedding = [...]` in the `#[hamiltonian(...)]` of `{Self}`; only listed schemes are compiled"
)]
pub trait Listed<E>: Hamiltonian + Sized {
    /// What takes the steps.
    type Scheme: Scheme<Self>;

    /// The discrete Lagrangian, the discrete Euler-Lagrange equations and the step, as readable text.
    const TEXT: &'static str;

    /// As [`Scheme::PROPERTIES`].
    const PROPERTIES: Properties = <Self::Scheme as Scheme<Self>>::PROPERTIES;
}

/// The scheme that takes the steps of `H` by `E`.
pub type SchemeOf<H, E> = <H as Listed<E>>::Scheme;
/// The prepared data of steps of `H` by `E`.
pub type PreparedOf<H, E, K = f64> = <SchemeOf<H, E> as Scheme<H>>::Prepared<K>;
/// How increments are added unless the user chooses.
pub type CarryOf<H, E> = <SchemeOf<H, E> as Scheme<H>>::Carry<f64>;
/// The memory of steps of `H` by `E`: what one step leaves for the next.
pub type MemoryOf<H, E, S> = <SchemeOf<H, E> as Scheme<H>>::Memory<S>;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::scalar::Dual;

    /// Derivatives by the step size are refused where they would be lost, not taken for none.
    #[test]
    fn derivatives_are_not_dropped() {
        let (mut q, mut p) = ([Dual::<1>::constant(0.5)], [Dual::<1>::constant(1.0)]);
        let h = Dual { value: 0.1, derivative: [1.0] };
        let at = At { t: Dual::<1>::constant(0.0), h, q: &mut q, p: &mut p, dw: &[] };
        let plain = at.plain();
        assert_eq!(plain.map(|at| at.h), Err(StepFailure::Internal(StepPromise::PlainConstants)));
        let at = At { t: 0.25, h: 0.1, q: &mut q, p: &mut p, dw: &[] };
        assert_eq!(at.plain().map(|at| [at.t, at.h]), Ok([0.25, 0.1]));
    }
}
