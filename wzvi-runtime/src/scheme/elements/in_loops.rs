//! Steps of a scheme in loops: data for each system, one implementation for all.

use std::marker::PhantomData;

use super::explicit::advance_explicit;
use super::side_by_side::go_side_by_side;
use super::{
    Elements, Memory, Quadrature, Stage, Unknowns, check_new, discrete_lagrangian,
    discrete_lagrangian_gradient, iterate, step_momentum,
};
use crate::algebra::carry::{Carry, Compensated, Plain};
use crate::algebra::scalar::{Constant, Over, Scalar};
use crate::algebra::shape::Dynamic;
use crate::algebra::solve::Effort;
use crate::algebra::state::State;
use crate::error::{ConfigError, StepFailure};
use crate::scheme::plan::Plan;
use crate::scheme::system::{
    At, Discretized, LagrangianGradient, Lift, Movable, Properties, Scheme, Segment, varied_without_lists,
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
struct Of<H, E>(PhantomData<(H, E)>);

impl<H: Discretized<E>, E> Of<H, E> {
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
        let InLoops { order, is_consistent, quadrature } = Of::<H, E>::SCHEME;
        quadrature.plan(H::FACTS, order, is_consistent)
    };
    const PROPERTIES: Properties = Properties {
        kept_energy: Of::<H, E>::QUADRATURE.kept_energy(Of::<H, E>::SCHEME.order),
        poles: Of::<H, E>::QUADRATURE.poles(),
        remembers: false,
        in_lanes: Of::<H, E>::IS_EXPLICIT || go_side_by_side(&H::FACTS, Of::<H, E>::QUADRATURE),
        ..Properties::of(&<Self as Scheme<H>>::PLAN, 0)
    };
    const POINTS: Option<&'static [Stage]> = Some(Of::<H, E>::QUADRATURE.stages);
    /// All parameters, where they have derivatives.
    type Prepared<K: Constant> = Vec<K>;
    type Memory<S: Scalar> = Memory<S>;
    type Compensated<S: Scalar> = Compensated<S, Dynamic>;
    type Carry<S: Scalar> = Plain;

    fn memory(system: &H) -> Memory<f64> {
        Memory::new(system, Of::<H, E>::QUADRATURE)
    }

    fn prepare<K: Constant>(system: &H, lift: Lift<'_, K>, _: K) -> Result<Vec<K>, ConfigError> {
        check_new(system)?;
        varied_without_lists(system, lift)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: Over<K>, C: Carry<S>, const CAREFUL: bool>(
        system: &H,
        parameters: &Vec<K>,
        at: At<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let (at, system) = (at.shared(), (system, S::varied(parameters)));
        if const { Of::<H, E>::IS_EXPLICIT } {
            advance_explicit(system, Of::<H, E>::QUADRATURE, at, memory, carry)
        } else {
            iterate::advance::<H, S, C, CAREFUL>(system, Of::<H, E>::QUADRATURE, at.lists(), memory, carry)
        }
    }

    fn discrete_lagrangian(system: &H, segment: &Segment<<H as Elements>::Vector>, dw: &[f64]) -> f64 {
        discrete_lagrangian(system, Of::<H, E>::QUADRATURE, segment, dw)
    }

    fn discrete_lagrangian_gradient(
        system: &H,
        segment: &Segment<<H as Elements>::Vector>,
        dw: &[f64],
    ) -> LagrangianGradient<<H as Elements>::Vector> {
        discrete_lagrangian_gradient(system, Of::<H, E>::QUADRATURE, segment, dw)
    }

    fn step_momentum(
        system: &H,
        before: &State<<H as Elements>::Vector>,
        after: &State<<H as Elements>::Vector>,
        h: f64,
        dw: &[f64],
    ) -> <H as Elements>::Vector {
        step_momentum(system, Of::<H, E>::QUADRATURE, [before, after], h, dw)
    }
}
