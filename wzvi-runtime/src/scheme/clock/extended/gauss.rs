//! Gauss steps of `K = Q (H + p_t)`: [`Extended<Gauss<S>>`](super::super::Extended).
//!
//! The stages of a step of `ε` from `y = (q, p, t, p_t)` are, with `D = H + p_t`,
//!
//! ```text
//! Y_i = y + Σ_j μ_ij L_j,   L_i = ε b_i (Q H_p + D Q_p, -(Q H_q + D Q_q), Q, -(Q H_t + D Q_t))_i
//! ```
//!
//! Where neither `H` nor `Q` reads the time, `p_t` is a constant, `t` the quadrature `t + ε Σ_i b_i Q_i`, and
//! the unknowns are those of the system. Else `t` and `p_t` are one more coordinate and one more momentum.
//! Either way [`ExtendedSystem`] is an autonomous system with the Hamiltonian `K` for [`Gauss`], which solves
//! for the stages as for any other. Steps are equal in `τ`, so that the stages start from those of the step
//! before.

use super::super::evaluation::SystemIn;
use super::super::{Extended, Extends, text};
use super::{ExtendedMemory, ExtendedState, ExtendedStep, advance, prepare, properties};
use crate::algebra::lanes::Lanes;
use crate::algebra::memory::{MemoryRequest, SolverReport, StepMemory};
use crate::algebra::scalar::{
    ComputesWith, Constant, Constants, ConstantsIn, Dual, Number, Parameters, Scalar,
};
use crate::algebra::shape::Dynamic;
use crate::algebra::solve::Effort;
use crate::algebra::state_sum::{CompensatedSum, PlainSum, StateSum};
use crate::error::{ConfigError, StepFailure};
use crate::ground::numbers::numbers;
use crate::scheme::compose::General;
use crate::scheme::dense::hermite_order;
use crate::scheme::elements::{
    ElementInput, Elements, EvaluationPoint, FieldAt, PairColumns, Partials, Role, Sums, slopes,
};
use crate::scheme::gauss::{Field, Gauss, GaussConstants, GaussMemory};
use crate::scheme::plan::{Facts, KeptEnergy, Plan, Solver};
use crate::scheme::system::{Discretized, LiftParameter, Movable, Properties, Scheme, StepArguments, anew};

/// Gauss steps with `S` stages of `K = Q (H + p_t)`.
#[derive(Clone, Copy, Debug)]
pub struct ExtendedGauss<const S: usize>;

impl<H, const S: usize> Discretized<Extended<Gauss<S>>> for H
where
    H: Field + Extends + Discretized<Gauss<S>>,
{
    type Scheme = ExtendedGauss<S>;
    type Prepared = Vec<f64>;
    const EQUATIONS: &'static str = text::ExtendedText::<H, Gauss<S>>::GAUSS;
}

impl<H: Field + Extends, const M: usize> Scheme<H> for ExtendedGauss<M> {
    const PLAN: Plan = {
        let plan = <Gauss<M> as Scheme<H>>::PLAN;
        let degrees = H::FACTS.degrees.saturating_add(H::READS_TIME as usize);
        Plan { solver: Solver::Newton, unknowns: degrees.saturating_mul(2 * M), ..plan }
    };
    const PROPERTIES: Properties = Properties {
        dense_order: hermite_order(&<Self as Scheme<H>>::PLAN),
        ..properties(<Gauss<M> as Scheme<H>>::PROPERTIES, KeptEnergy::Hamiltonian)
    };
    type Prepared<K: Constant> = Vec<K>;
    type Memory<S: Scalar> = ExtendedMemory<S::Constant, StageMemory<S::Constant, M>>;
    type Unclocked = Gauss<M>;
    type CompensatedSum<S: Scalar> = PlainSum;
    type Sum<S: Scalar> = PlainSum;

    fn prepare<K: Constant>(
        system: &H,
        lift: LiftParameter<'_, K>,
        _: K,
    ) -> Result<Self::Prepared<K>, ConfigError> {
        prepare(system, lift)
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
        parameters: &Self::Prepared<K>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut Self::Memory<S>,
        _: &mut C,
    ) -> Result<Effort, StepFailure> {
        let system = SystemIn { system, parameters: S::varied(parameters) };
        advance::<H, S, Self>(&Self, &system, at.lists().shared(), memory)
    }

    fn reading(memory: &Self::Memory<f64>) -> super::ClockReading {
        memory.reading
    }
}

/// The derivatives at the stages of the last step.
#[derive(Debug)]
pub struct StageMemory<N: Constant, const S: usize> {
    step: GaussMemory<N, Dynamic, Dynamic, S>,
    /// Scratch: the data of steps, and the `ε` for which they are.
    prepared: Option<(N, ExtendedConstants<N, S>)>,
    /// Scratch: one stage.
    stage: [Vec<N>; 2],
}

/// The data of steps.
type ExtendedConstants<N, const S: usize> = GaussConstants<ConstantsIn<ExtendedParameters, N>, S, N>;

impl<N: Constant, const S: usize> Default for StageMemory<N, S> {
    fn default() -> Self {
        Self { step: GaussMemory::default(), prepared: None, stage: Default::default() }
    }
}

/// A copy makes its own scratch.
impl<N: Constant, const S: usize> Clone for StageMemory<N, S> {
    fn clone(&self) -> Self {
        Self { step: self.step.clone(), ..Self::default() }
    }

    fn clone_from(&mut self, other: &Self) {
        self.step.clone_from(&other.step);
    }
}

numbers! { impl[N: Constant, const S: usize] Numbers for StageMemory<N, S> { kept: step; scratch: prepared, stage } }

impl<N: Constant, const S: usize> StepMemory for StageMemory<N, S> {
    fn tell(&mut self, request: &MemoryRequest) {
        self.step.tell(request);
    }

    fn report(&self) -> SolverReport {
        self.step.report()
    }
}

impl<H: Field + Extends, N: Constant<Constant = N>, const S: usize> ExtendedStep<H, N> for ExtendedGauss<S> {
    type Memory = StageMemory<N, S>;

    fn take(
        &self,
        given: &SystemIn<'_, H, N>,
        eps: N,
        ExtendedState { time, q, p, carry }: &mut ExtendedState<N>,
        StageMemory { step, prepared, stage: [stage_q, stage_p] }: &mut Self::Memory,
    ) -> Result<Effort, StepFailure> {
        let (system, degrees) = (ExtendedSystem(given.system), q.len());
        given.period(time.t, q, p)?;
        let constants = match prepared {
            Some((size, constants)) if size.is_identical(eps) => constants,
            _ => {
                let lift = |number: usize, value: f64| N::parameter(given.parameters, number, value);
                let made = Gauss::<S>::prepare(&system, &lift, eps).map_err(|_| StepFailure::NonFinite)?;
                // Stages of another size are no guide; those of a run that resumes are.
                if prepared.is_some() {
                    step.tell(&MemoryRequest::Forget);
                }
                &mut prepared.insert((eps, made)).1
            }
        };
        constants.parameters_mut().momentum = time.momentum;
        if H::READS_TIME {
            q.push(time.t);
            p.push(time.momentum);
        }
        let at = StepArguments { t: N::from_f64(0.0), h: eps, q: &mut q[..], p: &mut p[..], dw: &[] };
        let effort = anew::advance_carrying::<_, Gauss<S>, N, N, CompensatedSum<N, Dynamic>>(
            &system, constants, at, step, carry,
        )?;
        if let (true, Some(t), Some(momentum)) = (H::READS_TIME, q.get(degrees), p.get(degrees)) {
            (time.t, time.lost, time.momentum) = (*t, carry.of_coordinate(degrees), *momentum);
            q.truncate(degrees);
            p.truncate(degrees);
            return Ok(effort);
        }
        let mut duration = N::from_f64(0.0);
        for (i, weight) in constants.weights().iter().enumerate() {
            step.read_stage(i, [&mut *stage_q, stage_p]);
            duration = duration + given.period(time.t, stage_q, stage_p)? * *weight;
        }
        time.move_time(eps * duration);
        Ok(effort)
    }
}

/// The system with the Hamiltonian `K = Q (H + p_t)`. Its last coordinate and momentum are `t` and `p_t`, if
/// it [reads the time](Extends::READS_TIME).
#[derive(Debug)]
struct ExtendedSystem<'a, H>(&'a H);

/// The parameters of the system, and the constant `p_t`.
#[derive(Clone, Copy, Debug)]
struct ExtendedParameters;

/// The parameters of the system and `p_t`, in numbers of one type.
#[derive(Clone, Debug)]
struct ParametersWithMomentum<K> {
    /// All, where they have derivatives; else none.
    varied: Vec<K>,
    /// `p_t`, where it is a constant.
    momentum: K,
}

impl Constants for ExtendedParameters {
    type In<K: Constant> = ParametersWithMomentum<K>;

    /// Steps with a clock do not run in lanes.
    fn gather<const L: usize>(of_lanes: [&Self::In<f64>; L]) -> Self::In<Lanes<L>> {
        let momentum = Lanes::new(of_lanes.map(|parameters| parameters.momentum));
        ParametersWithMomentum { varied: Vec::new(), momentum }
    }
}

impl Parameters for ExtendedParameters {
    fn lane<K: Constant>(of: &Self::In<K>, lane: usize) -> Self::In<f64> {
        ParametersWithMomentum { varied: Vec::new(), momentum: of.momentum.lane(lane) }
    }
    fn varied<K: Constant>(of: &Self::In<K>) -> &[K] {
        &of.varied
    }
}

impl<H: Field + Extends> Elements for ExtendedSystem<'_, H> {
    type Vector = H::Vector;
    const FACTS: Facts = Facts::autonomous(usize::MAX);
    type Shape = Dynamic;
    type Structure = General;
    type CommonRange = H::CommonRange;

    fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
        self.0.parameter(index)
    }

    /// Not asked for: a step of Gauss needs derivatives.
    fn value<S: Scalar>(&self, _: Role, _: f64, _: &EvaluationPoint<'_, S>) -> S {
        S::from_f64(f64::NAN)
    }

    /// Not asked for: they come with `p_t` from [`Field::step_gradient`].
    fn gradient<S: Scalar, T: Number<S>>(
        &self,
        _: Role,
        _: f64,
        _: &EvaluationPoint<'_, S, impl ElementInput<S> + ?Sized>,
        _: Partials,
        _: &mut (impl Sums<S> + ?Sized),
        _: &mut (impl Sums<S> + ?Sized),
    ) {
    }
}

impl<H: Field + Extends> Field for ExtendedSystem<'_, H> {
    const IS_NYSTROM: bool = false;
    // Times differ from stage to stage.
    const IN_LANES: bool = H::IN_LANES && !H::READS_TIME;
    type Noises = Dynamic;
    type Parameters = ExtendedParameters;

    fn parameters<K: Constant>(&self, lift: LiftParameter<'_, K>) -> ParametersWithMomentum<K> {
        let varied = crate::scheme::system::varied(self.0, lift);
        ParametersWithMomentum { varied, momentum: K::from_f64(0.0) }
    }

    /// `h ∇K = h Q (∇H + (D/Q) ∇Q)`
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step_gradient<K: Constant, S: ComputesWith<K>, const BY_Q: bool, const BY_P: bool>(
        &self,
        ParametersWithMomentum { varied, momentum }: &ParametersWithMomentum<K>,
        ([_, h], [q, p], _): FieldAt<'_, S>,
        [by_q, by_p]: [&mut [S]; 2],
        columns: &mut PairColumns,
    ) {
        let Self(system) = *self;
        let degrees = q.len() - usize::from(H::READS_TIME);
        let zero = S::from_f64(0.0);
        let (t, momentum) = match H::READS_TIME {
            true => (q[degrees], p[degrees]),
            false => (zero, S::constant(*momentum)),
        };
        let varied = S::varied(varied);
        let at = EvaluationPoint::new([&q[..degrees], &p[..degrees]], t.to_constant(), varied, &[]);
        let (energy, period) = (system.value(Role::Drift, 1.0, &at), system.value(Role::Clock, 1.0, &at));
        let excess = energy + momentum;
        by_q.fill(zero);
        by_p.fill(zero);
        let (own_q, own_p) = (&mut by_q[..degrees], &mut by_p[..degrees]);
        system.gradient::<S, S>(Role::Clock, 1.0, &at, Partials::ALL, own_q, own_p);
        let ratio = excess / period;
        own_q.iter_mut().chain(&mut *own_p).for_each(|slope| *slope = *slope * ratio);
        slopes(system, Role::Drift.times(1.0), &at, Partials::ALL, own_q, own_p, columns);
        let factor = period * h;
        own_q.iter_mut().chain(own_p).for_each(|slope| *slope = *slope * factor);
        if H::READS_TIME {
            let [of_energy, of_period] = [Role::Drift, Role::Clock].map(|role| by_time(system, role, &at));
            by_q[degrees] = (period * of_energy + excess * of_period) * h;
            by_p[degrees] = factor;
        }
    }
}

/// The most degrees of freedom for which lists are arrays, so that nothing is allocated.
const MOST_IN_ARRAYS: usize = 32;

/// The derivative of a role by the time.
fn by_time<H: Elements, S: Scalar>(system: &H, role: Role, at: &EvaluationPoint<'_, S>) -> S {
    let (mut short, mut long) =
        ([[Dual::<1, S>::from_f64(0.0); MOST_IN_ARRAYS]; 2], [Vec::new(), Vec::new()]);
    let degrees = at.q.len();
    let lists = match degrees <= MOST_IN_ARRAYS {
        true => short.each_mut().map(|list| &mut list[..degrees]),
        false => long.each_mut().map(|list| {
            list.resize(degrees, Dual::from_f64(0.0));
            &mut list[..]
        }),
    };
    let [q, p] = lists;
    for (own, given) in q.iter_mut().zip(at.q).chain(p.iter_mut().zip(at.p)) {
        *own = Dual::constant(*given);
    }
    let parameters: Vec<_> = at.parameters.iter().map(|parameter| Dual::constant(*parameter)).collect();
    let t = Dual { value: at.t, derivative: [Scalar::from_f64(1.0)] };
    let [derivative] =
        system.value(role, 1.0, &EvaluationPoint::new([&*q, &*p], t, &parameters, &[])).derivative;
    derivative
}
