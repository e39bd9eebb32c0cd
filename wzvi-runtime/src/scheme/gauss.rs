//! The Gauss methods: the discrete embedding with `S` quadrature points, of order `2S`.
//!
//! With `F = h H_0 + Σ_k ΔW_k H_k`, frozen over the step, the discrete Lagrangian with internal stages
//!
//! ```text
//! L_d = ext Σ_i b_i [P_i · V_i - F(P_i, Q_i, t + c_i h)],  Q_i = q + Σ_j a_ij V_j,  q' = q + Σ_j b_j V_j
//! ```
//!
//! has the stages `V_i = ∂F/∂p (i)`, `P_i = p - Σ_j a_ij ∂F/∂q (j)` (E. Hairer, C. Lubich, G. Wanner,
//! *Geometric Numerical Integration*, theorem VI.6.4). They are found by sweeps `Y ← φ(Y)` over all of them
//! at once, and by Newton's method where that costs less. For one path, the lanes of a vector register are
//! its stages; in an ensemble they are paths, which evaluate stage after stage with the same arithmetic.
//! If `F = h T(p) + V(q, t)` with a quadratic `T` the momenta are eliminated (Nyström form), which doubles
//! the digits gained per sweep.
//!
//! Coefficients, their symmetries, and the prediction of the stages from those of the step before: M.
//! Antoñana, J. Makazaga, A. Murua, "Reducing and monitoring round-off error propagation for symplectic
//! implicit Runge-Kutta schemes", Numer. Algorithms 76, 2017.

mod action;
mod advance;
mod choice;
mod dense;
mod double_double;
mod equations;
mod memory;
mod newton;
mod solve;
mod stages;
mod stiff;
mod sweep;
mod tableau;
mod tangent;

use crate::algebra::lanes::Lanes;
use crate::algebra::scalar::{ComputesWith, Constant, Constants, ConstantsIn, Dual, Parameters, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state::State;
use crate::algebra::state_sum::{self, StateSum};
use crate::error::{ConfigError, StepFailure};
use crate::scheme::dense::RateCoefficients;
use crate::scheme::elements::{self, Elements, FieldAt, NewState, PairColumns, TileParts, TilePlan};
use crate::scheme::plan::{Facts, Plan, Solver};
use crate::scheme::poles::Poles;
use crate::scheme::system::{
    DEVIATIONS, LiftParameter, Movable, Properties, Scheme, Segment, StepArguments, TakenStep, as_they_are,
};

pub use crate::algebra::shape::{Dynamic, Fixed, Shape};
pub use advance::GaussConstants;
pub use memory::GaussMemory;
pub use stages::{OneStage, Stages};

/// The discrete embedding with `S` quadrature points, from 1 to 16: symplectic, symmetric, of order `2S`, and
/// consistent with every Stratonovich system. `Gauss<1>` is [`Midpoint`](crate::scheme::embedding::Midpoint).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Gauss<const S: usize>;

pub(crate) use tableau::quadrature;

/// The derivatives of the step Hamiltonian `F = h H_0 + Σ_k ΔW_k H_k`; generated.
pub trait Field: Elements + Sized {
    /// Whether `F` is a constant quadratic form of `p` plus a function of `q` and `t`.
    const IS_NYSTROM: bool;
    /// Whether all stages can be evaluated at once although their times differ.
    const IN_LANES: bool;
    /// Whether `V` reads the time, where `F = T(p) + V(q, t)`.
    const FORCE_READS_TIME: bool = false;
    /// Whether the potential energy has a constant quadratic part.
    const IS_STIFF: bool = false;
    /// Lists of one entry per noise.
    type Noises: Shape;

    /// The parameters that the derivatives read, for systems whose lists are arrays: nothing else of the
    /// system is read. Empty for others.
    type Parameters: Parameters;

    /// The values of these parameters.
    fn parameters<K: Constant>(&self, lift: LiftParameter<'_, K>) -> ConstantsIn<Self::Parameters, K>;

    /// Takes all parts of a step of drifts and kicks, tile by tile, if the system [has
    /// tiles](Facts::has_tiles) and `F = T(p) + V(q, t)`.
    ///
    /// # Errors
    /// [`StepFailure::NonFinite`] if the new state is not finite.
    fn take_tiles<'p, W: TileParts>(
        &self,
        word: &mut W,
        q: &[f64],
        p: &[f64],
        plan: &'p mut TilePlan,
    ) -> Option<Result<NewState<'p>, StepFailure>> {
        let _ = (word, q, p, plan);
        None
    }

    /// The matrix `K` of the quadratic part `q · K q / 2` of the potential energy, by rows.
    fn stiffness<K: Constant>(&self, _parameters: &[K], _k: &mut [K]) {}

    /// `∂F/∂q` and `∂F/∂p`, as requested. Slices have one entry per degree of freedom or noise; `columns` is
    /// scratch.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step_gradient<K: Constant, S: ComputesWith<K>, const BY_Q: bool, const BY_P: bool>(
        &self,
        parameters: &ConstantsIn<Self::Parameters, K>,
        at: FieldAt<'_, S>,
        into: [&mut [S]; 2],
        columns: &mut PairColumns,
    ) {
        let parameters = S::varied(Self::Parameters::varied(parameters));
        elements::field::<_, S, BY_Q, BY_P>((self, parameters), at, into, columns);
    }
}

/// The parameters of systems in lanes; `None` if derivatives read more of a system.
pub(crate) fn gather<F: Field, const L: usize>(
    of_lanes: [&ConstantsIn<F::Parameters, f64>; L],
) -> Option<ConstantsIn<F::Parameters, Lanes<L>>> {
    F::Shape::IS_FIXED.then(|| F::Parameters::gather(of_lanes))
}

/// Fills the derivatives with NaN, for lists that do not fit the system.
#[cold]
pub fn unfit<S: Scalar>(by_q: &mut [S], by_p: &mut [S]) {
    by_q.fill(S::from_f64(f64::NAN));
    by_p.fill(S::from_f64(f64::NAN));
}

/// The plan of a step with `stages` stages.
const fn plan(facts: Facts, stages: usize, is_nystrom: bool) -> Plan {
    let unknowns = facts.degrees.saturating_mul(stages * if is_nystrom { 1 } else { 2 });
    facts.plan(Solver::Newton, unknowns, 2 * stages as u32, true)
}

impl<F: Field, const N: usize> Scheme<F> for Gauss<N> {
    const PLAN: Plan = plan(F::FACTS, N, F::IS_NYSTROM);
    const PROPERTIES: Properties = Properties {
        stages: N as u32,
        poles: Poles::of_stages(N),
        in_lanes: F::Shape::IS_FIXED,
        // With friction, the polynomial would be one of the momentum `e^{γ τ} p`.
        has_polynomial: N > 1 && !F::FACTS.kind.is_conformal,
        dense_order: dense::dense_order(
            if F::FACTS.kind.is_conformal { 1 } else { N as u32 },
            &<Self as Scheme<F>>::PLAN,
        ),
        ..Properties::of(&<Self as Scheme<F>>::PLAN, size_of::<<Self as Scheme<F>>::Memory<f64>>())
    };
    type Prepared<K: Constant> = GaussConstants<ConstantsIn<F::Parameters, K>, N, K>;
    type Memory<S: Scalar> = GaussMemory<S, F::Shape, F::Noises, N>;
    type Unclocked = Self;
    type CompensatedSum<S: Scalar> = state_sum::CompensatedSum<S, F::Shape>;
    type Sum<S: Scalar> = state_sum::CompensatedSum<S, F::Shape>;

    fn memory(system: &F) -> Self::Memory<f64> {
        advance::memory(system)
    }

    fn prepare<K: Constant>(
        system: &F,
        lift: LiftParameter<'_, K>,
        h: K,
    ) -> Result<Self::Prepared<K>, ConfigError> {
        advance::prepare(system, lift, h)
    }

    fn resize<K: Constant>(
        system: &F,
        lift: LiftParameter<'_, K>,
        prepared: &mut Self::Prepared<K>,
        h: K,
    ) -> Result<(), ConfigError> {
        prepared.resize::<F>(system, lift, h)
    }

    fn gather<const L: usize>(prepared: [&Self::Prepared<f64>; L]) -> Option<Self::Prepared<Lanes<L>>> {
        advance::gather::<F, L, N>(prepared)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        system: &F,
        prepared: &Self::Prepared<K>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let prepared = (&prepared.parameters, &prepared.friction, &prepared.common);
        advance::advance::<F, K, S, C, N, CAREFUL>(system, prepared, at.lists(), memory, carry)
    }

    fn hand_values<S: Scalar>(from: &Self::Memory<f64>, to: &mut Self::Memory<S>) {
        memory::hand_values(from, to);
    }

    fn multiply(
        system: &F,
        prepared: &Self::Prepared<f64>,
        taken: TakenStep<'_, Self::Memory<f64>>,
        room: &mut Self::Memory<f64>,
        deviations: [&mut [Dual<DEVIATIONS>]; 2],
    ) -> bool {
        tangent::multiply(system, prepared, taken, room, deviations)
    }

    fn slopes_between(
        system: &F,
        (prepared, memory): (&Self::Prepared<f64>, &Self::Memory<f64>),
        before: &State<F::Vector>,
        h: f64,
        dw: &[f64],
        slopes: &mut RateCoefficients,
    ) {
        dense::slopes_between(system, prepared, memory, before, h, dw, slopes);
    }

    fn discrete_lagrangian(system: &F, segment: &Segment<F::Vector>, dw: &[f64]) -> f64 {
        let prepared = advance::prepare::<F, f64, N>(system, &as_they_are, segment.h);
        prepared.map_or(f64::NAN, |prepared| action::value(system, &prepared, segment, dw))
    }
}
