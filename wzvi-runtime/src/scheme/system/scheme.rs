//! The trait of all schemes: steps of a system.

use std::fmt::Debug;

use super::{Discretized, Exchange, Hamiltonian, LagrangianGradient, Segment, by_dual_numbers};
use crate::algebra::lanes::Lanes;
use crate::algebra::memory::StepMemory;
use crate::algebra::scalar::{ComputesWith, Constant, Dual, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state::{State, Vector};
use crate::algebra::state_sum::StateSum;
use crate::error::{ConfigError, StepFailure, wrong};
use crate::scheme::clock::ClockReading;
use crate::scheme::dense::{RateCoefficients, hermite_order};
use crate::scheme::elements::QuadraturePoint;
use crate::scheme::plan::{KeptEnergy, NoiseClass, Plan, Solver};
use crate::scheme::poles::Poles;

/// The arguments of a step: the state `(q, p)` at `t`, which it moves, the step size and the increments.
#[derive(Debug)]
pub struct StepArguments<'a, S, K = f64, V: ?Sized = [S]> {
    /// Time at the start of the step.
    pub t: K,
    /// Step size.
    pub h: K,
    /// Coordinates, one number per degree of freedom.
    pub q: &'a mut V,
    /// Momenta, likewise.
    pub p: &'a mut V,
    /// Increments, [`Scheme::increments`] of them.
    pub dw: &'a [S],
}

/// The coordinates or the momenta that a step moves: a list, or a vector that a new one may replace.
pub trait Movable<S> {
    /// The numbers.
    fn list(&mut self) -> &mut [S];
    /// Takes the numbers of a list of the same length, which may take the old ones in exchange. Only numbers
    /// that are `f64` come so.
    fn exchange(&mut self, new: &mut Vec<f64>);
}

impl<S: Scalar> Movable<S> for [S] {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn list(&mut self) -> &mut [S] {
        self
    }
    fn exchange(&mut self, new: &mut Vec<f64>) {
        let own = S::as_f64s_mut(self);
        debug_assert!(own.is_some(), "numbers of another type are not taken tile by tile");
        own.into_iter().for_each(|own| own.copy_from_slice(new));
    }
}

impl<V: Vector> Movable<f64> for V {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn list(&mut self) -> &mut [f64] {
        self.components_mut()
    }
    fn exchange(&mut self, new: &mut Vec<f64>) {
        self.exchange(new);
    }
}

impl<'a, S, K, V: Movable<S> + ?Sized> StepArguments<'a, S, K, V> {
    /// With lists.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn lists(self) -> StepArguments<'a, S, K> {
        let Self { t, h, q, p, dw } = self;
        StepArguments { t, h, q: q.list(), p: p.list(), dw }
    }

    /// With time and step size of the first lane.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn shared(self) -> StepArguments<'a, S, S::Constant, V>
    where
        S: ComputesWith<K>,
        K: Constant,
    {
        let Self { t, h, q, p, dw } = self;
        let [t, h] = [t, h].map(|constant| S::constant(constant).to_constant());
        StepArguments { t, h, q, p, dw }
    }
}

/// Deviations from a path that are multiplied at once, as derivatives of dual numbers.
pub const DEVIATIONS: usize = 4;

/// A step that has been taken: where it began, and the memory that it left.
#[derive(Debug)]
pub struct TakenStep<'a, M> {
    /// [`StepArguments::t`] and [`StepArguments::h`]
    pub t: f64,
    /// The step size.
    pub h: f64,
    /// Coordinates at its start.
    pub q: &'a [f64],
    /// Momenta there.
    pub p: &'a [f64],
    /// Its increments.
    pub dw: &'a [f64],
    /// The memory that it left for the next step.
    pub memory: &'a M,
    /// Whether these are the first of its deviations.
    pub is_first: bool,
}

/// A parameter of the system as a constant of a step, from its number among [`Hamiltonian::parameter`] and
/// its value.
pub type LiftParameter<'l, K> = &'l dyn Fn(usize, f64) -> K;

/// The [`LiftParameter`] that leaves parameters as they are.
pub fn as_they_are(_: usize, value: f64) -> f64 {
    value
}

/// All parameters, where they have derivatives; an empty list where they are `f64`.
pub fn varied<H: Hamiltonian, K: Constant>(system: &H, lift: LiftParameter<'_, K>) -> Vec<K> {
    if size_of::<K>() == size_of::<f64>() {
        return Vec::new();
    }
    let mut all = Vec::new();
    while let Some((_, value)) = system.parameter(all.len()) {
        all.push(lift(all.len(), value));
    }
    all
}

/// [`varied`] for steps that read entries of lists as `f64`.
///
/// # Errors
/// [`ConfigError::Setting`] if such an entry has a derivative.
pub(crate) fn varied_without_lists<H: Hamiltonian, K: Constant>(
    system: &H,
    lift: LiftParameter<'_, K>,
) -> Result<Vec<K>, ConfigError> {
    let varied = varied(system, lift);
    for (index, number) in varied.iter().enumerate() {
        if let Some((name, value)) = system.parameter(index)
            && name.contains('[')
            && !number.is_identical(K::from_f64(value))
        {
            return wrong(format!(
                "steps of this scheme have no derivatives by entries of lists, as `{name}`"
            ));
        }
    }
    Ok(varied)
}

/// Properties of the steps of a scheme for runs, besides its [`Plan`].
#[derive(Clone, Copy, Debug)]
pub struct Properties {
    /// The energy monitored in runs of constant step.
    pub kept_energy: KeptEnergy,
    /// The largest number of stages solved at once in any part of a step; 0 for explicit steps.
    pub stages: u32,
    /// Whether the memory of past steps is valid for this state only: then it is cleared if the caller moves
    /// the state.
    pub remembers: bool,
    /// Whether paths run in lanes: not with iterations over loops in large systems, nor with linear equations
    /// there.
    pub in_lanes: bool,
    /// Whether equations of implicit steps are solved by lane in numbers with derivatives, too.
    pub differentiates_lanes: bool,
    /// The number of degrees of freedom from which the step of a single path is vectorised; paths then run
    /// one after the other, and stay in the cache. `usize::MAX` if steps are never vectorised so.
    pub scalar_paths_from: usize,
    /// The order of the error inside a step:
    /// [`DenseOutput::order`](crate::scheme::dense::DenseOutput::order).
    pub dense_order: u32,
    /// Whether the scheme has a polynomial of its own between the nodes of a step.
    pub has_polynomial: bool,
    /// Whether the scheme accounts for the energy from forces and bath: [`Scheme::exchanged`].
    pub exchanges: bool,
    /// Whether degrees of freedom have baths of their own: [`Scheme::heats`].
    pub has_temperatures: bool,
    /// Whether steps follow from a discrete Lagrangian.
    pub is_variational: bool,
    /// Whether steps follow a [clock](crate::scheme::clock): their size is then `eps`, and
    /// [`Scheme::reading`] has the time.
    pub is_clocked: bool,
    /// The poles of implicit steps in linear systems, if they are known and there are any.
    pub poles: Option<Poles>,
}

/// Why a scheme for a system with a bath has no equilibrium, if it has none.
pub(crate) const fn disequilibrium(plan: &Plan, properties: &Properties) -> Option<&'static str> {
    match (plan.is_out_of_equilibrium, properties.has_temperatures) {
        (false, _) => None,
        (true, true) => Some("the temperatures of the degrees of freedom differ"),
        (true, false) => Some("the temperature depends on the time"),
    }
}

impl Properties {
    /// The properties of a variational step with paths in lanes, cubics between its nodes, and a memory of
    /// `memory` bytes.
    pub const fn of(plan: &Plan, memory: usize) -> Self {
        Self {
            kept_energy: KeptEnergy::Hamiltonian,
            stages: if matches!(plan.solver, Solver::Explicit) { 0 } else { 1 },
            remembers: matches!(plan.noise, NoiseClass::None) && memory != 0,
            in_lanes: true,
            differentiates_lanes: false,
            scalar_paths_from: usize::MAX,
            dense_order: hermite_order(plan),
            has_polynomial: false,
            exchanges: false,
            has_temperatures: false,
            is_variational: true,
            is_clocked: false,
            poles: None,
        }
    }
}

/// A scheme for the system `H`. For user-defined schemes, [`OneStep`](super::OneStep) is simpler.
pub trait Scheme<H: Hamiltonian> {
    /// The compile-time facts.
    const PLAN: Plan;

    /// Further properties for runs.
    const PROPERTIES: Properties = Properties::of(&Self::PLAN, size_of::<Self::Memory<f64>>());

    /// The quadrature points of the discrete Lagrangian, where they define the step. Steps without are
    /// symmetric.
    #[doc(hidden)]
    const POINTS: Option<&'static [QuadraturePoint]> = None;

    /// The data that depend on the system and the step size only, in constants `K`: of one system, of one
    /// system per lane, or with derivatives.
    type Prepared<K: Constant>: Clone + Debug + Send + Sync;

    /// The data that a step leaves for the next one, and scratch; of size zero where there are none.
    type Memory<S: Scalar>: StepMemory;

    /// The scheme of steps over a given time: this one, unless its steps follow a
    /// [clock](crate::scheme::clock). A single such step from a node gives states between nodes.
    type Unclocked: Scheme<H>;

    /// Compensated sums of the state's increments:
    /// [`FixedCompensatedSum`](crate::algebra::state_sum::FixedCompensatedSum).
    type CompensatedSum<S: Scalar>: StateSum<S>;

    /// The default summation of increments: compensated if that costs less than about 5 % of the step, else
    /// [`PlainSum`](crate::algebra::state_sum::PlainSum).
    type Sum<S: Scalar>: StateSum<S>;

    /// The number of increments that drive a step of a state with this many degrees of freedom: those of the
    /// noises, and after them `√h` times the standard normals of a bath.
    fn increments(system: &H, degrees: usize) -> usize {
        let _ = degrees;
        system.noises()
    }

    /// The memory of a new stepper, allocated in full if the system knows its size.
    fn memory(system: &H) -> Self::Memory<f64> {
        let _ = system;
        Default::default()
    }

    /// Computes the data common to all steps, from parameters and a step size that may have derivatives.
    ///
    /// # Errors
    /// If a parameter is invalid, or a matrix that is factored here is singular; if there are derivatives and
    /// the scheme does not propagate them.
    fn prepare<K: Constant>(
        system: &H,
        lift: LiftParameter<'_, K>,
        h: K,
    ) -> Result<Self::Prepared<K>, ConfigError>;

    /// Makes the data of a system those for steps of another size.
    ///
    /// # Errors
    /// The errors of [`Scheme::prepare`]; the data are then unchanged.
    fn resize<K: Constant>(
        system: &H,
        lift: LiftParameter<'_, K>,
        prepared: &mut Self::Prepared<K>,
        h: K,
    ) -> Result<(), ConfigError> {
        *prepared = Self::prepare(system, lift, h)?;
        Ok(())
    }

    /// The time at the end of the next step by a [clock](Properties::is_clocked) from a state, where it is
    /// known before the step; else NaN.
    ///
    /// # Errors
    /// The errors of a clock that is not positive there.
    fn upcoming(
        system: &H,
        prepared: &Self::Prepared<f64>,
        state: &State<H::Vector>,
        eps: f64,
        memory: &Self::Memory<f64>,
    ) -> Result<f64, StepFailure> {
        let _ = (system, prepared, state, eps, memory);
        Ok(f64::NAN)
    }

    /// The time after the last step recorded in `memory`, where [steps follow a
    /// clock](Properties::is_clocked).
    fn reading(memory: &Self::Memory<f64>) -> ClockReading {
        let _ = memory;
        ClockReading { t: f64::NAN, h: f64::NAN, density: f64::NAN }
    }

    /// The prepared data of `L` systems for one step size, one system per lane; `None` if they do not run in
    /// lanes. If they do, so does any selection of them, with repetitions.
    fn gather<const L: usize>(prepared: [&Self::Prepared<f64>; L]) -> Option<Self::Prepared<Lanes<L>>> {
        let _ = prepared;
        None
    }

    /// One step in place. For systems in lanes, `system` is any of them: only their common data are read. On
    /// `Err`, the state, `memory` and `carry` are unchanged; if the error is that of some
    /// [lanes](StepFailure::Lanes), this holds for these lanes, and the others have taken the step.
    ///
    /// Unless `CAREFUL`, an iteration that does not converge fast is abandoned; the
    /// [`Stepper`](crate::trajectory::step::Stepper) then continues with care.
    ///
    /// # Errors
    /// If no solution was found, or sizes do not fit.
    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        system: &H,
        prepared: &Self::Prepared<K>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure>;

    /// Hands the solution of the last step to the memory of a step in numbers with derivatives from the same
    /// state, which need not be solved again then.
    fn hand_values<S: Scalar>(from: &Self::Memory<f64>, to: &mut Self::Memory<S>) {
        let _ = (from, to);
    }

    /// Multiplies deviations from the path by the derivative of the step that was taken, where the scheme has
    /// formulas for it. False, with nothing done, where the step is to be repeated in dual numbers. `room`
    /// keeps what further deviations of the same step need.
    #[doc(hidden)]
    fn multiply(
        system: &H,
        prepared: &Self::Prepared<f64>,
        taken: TakenStep<'_, Self::Memory<f64>>,
        room: &mut Self::Memory<f64>,
        deviations: [&mut [Dual<DEVIATIONS>]; 2],
    ) -> bool {
        let _ = (system, prepared, taken, room, deviations);
        false
    }

    /// The derivatives of the scheme's own polynomial, for the last step recorded in `memory`.
    fn slopes_between(
        system: &H,
        (prepared, memory): (&Self::Prepared<f64>, &Self::Memory<f64>),
        before: &State<H::Vector>,
        h: f64,
        dw: &[f64],
        slopes: &mut RateCoefficients,
    ) {
        let _ = (system, prepared, memory, before, h, dw, slopes);
    }

    /// The energy exchanged in the last step recorded in `memory`.
    fn exchanged(system: &H, memory: &Self::Memory<f64>) -> Exchange {
        let _ = (system, memory);
        Exchange::default()
    }

    /// The heat of each degree of freedom in the last step recorded in `memory`, where
    /// [`Properties::has_temperatures`]; else empty.
    fn heats(memory: &Self::Memory<f64>) -> &[f64] {
        let _ = memory;
        &[]
    }

    /// `kT` of a bath at one constant temperature.
    fn temperature(system: &H) -> Option<f64> {
        let _ = system;
        None
    }

    /// `L_d(q_i, q_{i+1}, P; t, h, ΔW)`; NaN if there is none.
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

/// The scheme that takes the steps of `H` by `E`.
pub type SchemeOf<H, E> = <H as Discretized<E>>::Scheme;
/// The prepared data of steps of `H` by `E`.
pub type PreparedOf<H, E, K = f64> = <SchemeOf<H, E> as Scheme<H>>::Prepared<K>;
/// The default summation of increments.
pub type SumOf<H, E> = <SchemeOf<H, E> as Scheme<H>>::Sum<f64>;
/// The memory of steps of `H` by `E`.
pub type MemoryOf<H, E, S> = <SchemeOf<H, E> as Scheme<H>>::Memory<S>;
