//! Steps of a scheme in loops: data for each system, one implementation for all.

use std::marker::PhantomData;

use super::explicit::{advance_explicit, advance_explicit_vectors};
use super::{
    CompensationVec, Elements, Memory, Quadrature, Unknowns, discrete_lagrangian,
    discrete_lagrangian_gradient, iterate, prepare, step_momentum,
};
use crate::algebra::carry::{Carry, Plain};
use crate::algebra::scalar::{Constant, Over, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state::{State, Vector};
use crate::error::{ConfigError, StepFailure};
use crate::scheme::plan::Plan;
use crate::scheme::system::{At, LagrangianGradient, Lift, Properties, Scheme, Segment, without_derivatives};

/// A system whose steps by `E` are solved in loops; generated.
pub trait InLoops<E>: Elements + Sync {
    /// The order in `h` without noise.
    const ORDER: u32;
    /// Whether the scheme converges to the Stratonovich system.
    const IS_CONSISTENT: bool;
    /// The quadrature.
    const QUADRATURE: Quadrature;
}

/// Steps in loops.
#[derive(Clone, Copy, Debug)]
pub struct Loops<E>(PhantomData<E>);

const fn is_explicit(quadrature: &Quadrature) -> bool {
    matches!(quadrature.unknowns, Unknowns::None)
}

/// A poor start costs iterations, but no digits, so that past steps need not be forgotten.
impl<H: InLoops<E>, E> Scheme<H> for Loops<E> {
    const PLAN: Plan = H::QUADRATURE.plan(H::FACTS, H::ORDER, H::IS_CONSISTENT);
    const PROPERTIES: Properties = Properties {
        kept_energy: H::QUADRATURE.kept_energy(H::ORDER),
        remembers: false,
        in_lanes: is_explicit(&H::QUADRATURE),
        ..Properties::of(&<Self as Scheme<H>>::PLAN, 0)
    };
    type Prepared<K: Constant> = ();
    type Memory<S: Scalar> = Memory<S>;
    type Compensated<S: Scalar> = CompensationVec<S>;
    type Carry<S: Scalar> = Plain;

    fn memory(system: &H) -> Memory<f64> {
        Memory::new(system, &H::QUADRATURE)
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
        if const { is_explicit(&H::QUADRATURE) } {
            advance_explicit(system, &H::QUADRATURE, at, memory, carry)
        } else {
            iterate::advance::<H, S, C, CAREFUL>(system, &H::QUADRATURE, at, memory, carry)
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance_vectors<C: Carry<f64>, const CAREFUL: bool>(
        system: &H,
        (): &(),
        [t, h]: [f64; 2],
        [q, p]: [&mut H::Vector; 2],
        dw: &[f64],
        memory: &mut Memory<f64>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        if const { is_explicit(&H::QUADRATURE) } {
            return advance_explicit_vectors(system, &H::QUADRATURE, [t, h], [q, p], dw, memory, carry);
        }
        let at = At { t, h, q: q.components_mut(), p: p.components_mut(), dw };
        iterate::advance::<H, f64, C, CAREFUL>(system, &H::QUADRATURE, at, memory, carry)
    }

    fn discrete_lagrangian(system: &H, segment: &Segment<H::Vector>, dw: &[f64]) -> f64 {
        discrete_lagrangian(system, &H::QUADRATURE, segment, dw)
    }

    fn discrete_lagrangian_gradient(
        system: &H,
        segment: &Segment<H::Vector>,
        dw: &[f64],
    ) -> LagrangianGradient<H::Vector> {
        discrete_lagrangian_gradient(system, &H::QUADRATURE, segment, dw)
    }

    fn step_momentum(
        system: &H,
        before: &State<H::Vector>,
        after: &State<H::Vector>,
        h: f64,
        dw: &[f64],
    ) -> H::Vector {
        step_momentum(system, &H::QUADRATURE, [before, after], h, dw)
    }
}
