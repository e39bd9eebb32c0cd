//! Steps of a scheme in loops: data for each system, one implementation for all.

use std::marker::PhantomData;

use super::explicit::{advance_explicit, advance_explicit_vectors};
use super::side_by_side::go_side_by_side;
use super::{
    CompensationVec, Elements, Memory, MomentumUpdate, Quadrature, Unknowns, discrete_lagrangian,
    discrete_lagrangian_gradient, iterate, prepare, step_momentum,
};
use crate::algebra::carry::{Carry, Plain};
use crate::algebra::scalar::{Constant, Over, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state::{State, Vector};
use crate::error::{ConfigError, StepFailure};
use crate::scheme::plan::Plan;
use crate::scheme::system::{
    At, Discretized, LagrangianGradient, Lift, Properties, Scheme, Segment, without_derivatives,
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

impl InLoops {
    /// Of all other schemes.
    pub const NONE: Self =
        Self { order: 0, is_consistent: false, quadrature: Quadrature::new(&[], MomentumUpdate::Slopes) };
}

/// Steps in loops.
#[derive(Clone, Copy, Debug)]
pub struct Loops<E>(PhantomData<E>);

const fn is_explicit(quadrature: &Quadrature) -> bool {
    matches!(quadrature.unknowns, Unknowns::None)
}

/// A poor start costs iterations, but no digits, so that past steps need not be forgotten.
impl<H, E> Scheme<H> for Loops<E>
where
    H: Elements + Sync + Discretized<E, Vector = <H as Elements>::Vector>,
{
    const PLAN: Plan = {
        let InLoops { order, is_consistent, quadrature } = H::IN_LOOPS;
        assert!(!quadrature.stages.is_empty(), "steps of this scheme are not solved in loops");
        quadrature.plan(H::FACTS, order, is_consistent)
    };
    const PROPERTIES: Properties = Properties {
        kept_energy: H::IN_LOOPS.quadrature.kept_energy(H::IN_LOOPS.order),
        remembers: false,
        in_lanes: is_explicit(&H::IN_LOOPS.quadrature) || go_side_by_side(&H::FACTS, &H::IN_LOOPS.quadrature),
        ..Properties::of(&<Self as Scheme<H>>::PLAN, 0)
    };
    type Prepared<K: Constant> = ();
    type Memory<S: Scalar> = Memory<S>;
    type Compensated<S: Scalar> = CompensationVec<S>;
    type Carry<S: Scalar> = Plain;

    fn memory(system: &H) -> Memory<f64> {
        Memory::new(system, &H::IN_LOOPS.quadrature)
    }

    fn prepare<K: Constant>(system: &H, _: Lift<'_, K>, h: K) -> Result<(), ConfigError> {
        without_derivatives(h)?;
        prepare(system)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: Over<K>, C: Carry<S>, const CAREFUL: bool>(
        system: &H,
        (): &(),
        at: At<'_, S, K>,
        memory: &mut Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let at = at.plain()?;
        if const { is_explicit(&H::IN_LOOPS.quadrature) } {
            advance_explicit(system, &H::IN_LOOPS.quadrature, at, memory, carry)
        } else {
            iterate::advance::<H, S, C, CAREFUL>(system, &H::IN_LOOPS.quadrature, at, memory, carry)
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance_vectors<C: Carry<f64>, const CAREFUL: bool>(
        system: &H,
        (): &(),
        [t, h]: [f64; 2],
        [q, p]: [&mut <H as Elements>::Vector; 2],
        dw: &[f64],
        memory: &mut Memory<f64>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        if const { is_explicit(&H::IN_LOOPS.quadrature) } {
            return advance_explicit_vectors(
                system,
                &H::IN_LOOPS.quadrature,
                [t, h],
                [q, p],
                dw,
                memory,
                carry,
            );
        }
        let at = At { t, h, q: q.components_mut(), p: p.components_mut(), dw };
        iterate::advance::<H, f64, C, CAREFUL>(system, &H::IN_LOOPS.quadrature, at, memory, carry)
    }

    fn discrete_lagrangian(system: &H, segment: &Segment<<H as Elements>::Vector>, dw: &[f64]) -> f64 {
        discrete_lagrangian(system, &H::IN_LOOPS.quadrature, segment, dw)
    }

    fn discrete_lagrangian_gradient(
        system: &H,
        segment: &Segment<<H as Elements>::Vector>,
        dw: &[f64],
    ) -> LagrangianGradient<<H as Elements>::Vector> {
        discrete_lagrangian_gradient(system, &H::IN_LOOPS.quadrature, segment, dw)
    }

    fn step_momentum(
        system: &H,
        before: &State<<H as Elements>::Vector>,
        after: &State<<H as Elements>::Vector>,
        h: f64,
        dw: &[f64],
    ) -> <H as Elements>::Vector {
        step_momentum(system, &H::IN_LOOPS.quadrature, [before, after], h, dw)
    }
}
