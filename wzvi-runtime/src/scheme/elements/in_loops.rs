//! Steps of a scheme in loops: data for each system, one implementation for all.

use std::marker::PhantomData;

use super::explicit::advance_explicit;
use super::lanes::allow_lanes;
use super::{
    Elements, LoopMemory, Quadrature, QuadraturePoint, Unknowns, check_new, discrete_lagrangian,
    discrete_lagrangian_gradient, iterate, step_momentum,
};
use crate::algebra::scalar::{ComputesWith, Constant, Scalar};
use crate::algebra::shape::Dynamic;
use crate::algebra::solve::Effort;
use crate::algebra::state::State;
use crate::algebra::state_sum::{CompensatedSum, PlainSum, StateSum};
use crate::error::{ConfigError, StepFailure};
use crate::scheme::plan::Plan;
use crate::scheme::system::{
    Discretized, LagrangianGradient, LiftParameter, Movable, Properties, Scheme, Segment, StepArguments,
    varied_without_lists,
};

/// A scheme whose steps are solved in loops.
#[derive(Clone, Copy, Debug)]
pub struct InLoops {
    /// The order in `h` without noise.
    pub order: u32,
    /// Whether the scheme converges to the Stratonovich system.
    pub is_consistent: bool,
    /// The quadrature.
    pub quadrature: Quadrature,
}

/// Steps in loops.
#[derive(Clone, Copy, Debug)]
pub struct Loops<E>(PhantomData<E>);

/// The scheme of a system whose steps are solved in loops.
struct LoopScheme<H, E>(PhantomData<(H, E)>);

impl<H: Discretized<E>, E> LoopScheme<H, E> {
    const SCHEME: InLoops = H::IN_LOOPS.expect("steps of this scheme are not solved in loops");
    const QUADRATURE: &'static Quadrature = &Self::SCHEME.quadrature;
    const IS_EXPLICIT: bool = matches!(Self::QUADRATURE.unknowns, Unknowns::None);
}

/// A poor start costs iterations, but no digits, so that past steps need not be forgotten.
impl<H, E> Scheme<H> for Loops<E>
where
    H: Elements + Sync + Discretized<E, Vector = <H as Elements>::Vector>,
{
    const PLAN: Plan = {
        let InLoops { order, is_consistent, quadrature } = LoopScheme::<H, E>::SCHEME;
        quadrature.plan(H::FACTS, order, is_consistent)
    };
    const PROPERTIES: Properties = Properties {
        kept_energy: LoopScheme::<H, E>::QUADRATURE.kept_energy(LoopScheme::<H, E>::SCHEME.order),
        poles: LoopScheme::<H, E>::QUADRATURE.poles(),
        remembers: false,
        in_lanes: LoopScheme::<H, E>::IS_EXPLICIT || allow_lanes(&H::FACTS, LoopScheme::<H, E>::QUADRATURE),
        ..Properties::of(&<Self as Scheme<H>>::PLAN, 0)
    };
    const POINTS: Option<&'static [QuadraturePoint]> = Some(LoopScheme::<H, E>::QUADRATURE.stages);
    /// All parameters, where they have derivatives.
    type Prepared<K: Constant> = Vec<K>;
    type Memory<S: Scalar> = LoopMemory<S>;
    type Unclocked = Self;
    type CompensatedSum<S: Scalar> = CompensatedSum<S, Dynamic>;
    type Sum<S: Scalar> = PlainSum;

    fn memory(system: &H) -> LoopMemory<f64> {
        LoopMemory::new(system, LoopScheme::<H, E>::QUADRATURE)
    }

    fn prepare<K: Constant>(system: &H, lift: LiftParameter<'_, K>, _: K) -> Result<Vec<K>, ConfigError> {
        check_new(system)?;
        varied_without_lists(system, lift)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        system: &H,
        parameters: &Vec<K>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut LoopMemory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let (at, system) = (at.shared(), (system, S::varied(parameters)));
        if const { LoopScheme::<H, E>::IS_EXPLICIT } {
            advance_explicit(system, LoopScheme::<H, E>::QUADRATURE, at, memory, carry)
        } else {
            iterate::advance::<H, S, C, CAREFUL>(
                system,
                LoopScheme::<H, E>::QUADRATURE,
                at.lists(),
                memory,
                carry,
            )
        }
    }

    fn discrete_lagrangian(system: &H, segment: &Segment<<H as Elements>::Vector>, dw: &[f64]) -> f64 {
        discrete_lagrangian(system, LoopScheme::<H, E>::QUADRATURE, segment, dw)
    }

    fn discrete_lagrangian_gradient(
        system: &H,
        segment: &Segment<<H as Elements>::Vector>,
        dw: &[f64],
    ) -> LagrangianGradient<<H as Elements>::Vector> {
        discrete_lagrangian_gradient(system, LoopScheme::<H, E>::QUADRATURE, segment, dw)
    }

    fn step_momentum(
        system: &H,
        before: &State<<H as Elements>::Vector>,
        after: &State<<H as Elements>::Vector>,
        h: f64,
        dw: &[f64],
    ) -> <H as Elements>::Vector {
        step_momentum(system, LoopScheme::<H, E>::QUADRATURE, [before, after], h, dw)
    }
}
