//! Steps in straight-line code, block by block: the generated part for one scheme of a small system, and the common part.

use std::marker::PhantomData;

use super::{At, LagrangianGradient, Lift, Properties, Scheme, Segment, Solution, array_mut, increments};
use crate::algebra::carry::{Carry, Compensation};
use crate::algebra::lanes::Lanes;
use crate::algebra::memory::StepMemory;
use crate::algebra::scalar::{Constant, Constants, Of, Over, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state::State;
use crate::error::{ConfigError, StepFailure};
use crate::scheme::elements::{self, Elements};
use crate::scheme::plan::Plan;

/// The step of a system with `D` degrees of freedom and `N` noises by the scheme `E`; generated.
pub trait StraightLine<E, const D: usize, const N: usize>: Elements + Sized {
    /// The compile-time facts.
    const PLAN: Plan;
    /// The quadrature of the discrete Lagrangian.
    const QUADRATURE: elements::Quadrature;
    /// The constants of all steps: numbers, truths and factors of matrices.
    type Prepared: Constants;
    /// One extrapolation per iterated block.
    type Memory<S: Scalar>: StepMemory;
    /// The default summation of increments.
    type Carry<S: Scalar>: Carry<S>;

    /// Computes the constants.
    ///
    /// # Errors
    /// If a parameter is NaN, or a matrix that is factored here is singular.
    fn prepare<K: Constant>(&self, lift: Lift<'_, K>, h: K) -> Result<Of<Self::Prepared, K>, ConfigError>;

    /// Writes the end of the step into `next`.
    ///
    /// # Errors
    /// If no solution of a block was found, or the end is not finite.
    #[expect(clippy::too_many_arguments, reason = "generated code reads each by its name")]
    fn solve<S: Over<K>, K: Constant, C: Carry<S>, const CAREFUL: bool>(
        prepared: &Of<Self::Prepared, K>,
        t: K,
        h: K,
        q: [S; D],
        p: [S; D],
        dw: [S; N],
        memory: &mut Self::Memory<S>,
        carry: &C,
        next: &mut Solution<S, D>,
    ) -> Result<(), StepFailure>;
}

/// Steps in straight-line code.
#[derive(Clone, Copy, Debug)]
pub struct Straight<E, const D: usize, const N: usize>(PhantomData<E>);

impl<H, E, const D: usize, const N: usize> Scheme<H> for Straight<E, D, N>
where
    H: StraightLine<E, D, N>,
{
    const PLAN: Plan = H::PLAN;
    const PROPERTIES: Properties = Properties {
        kept_energy: H::QUADRATURE.kept_energy(H::PLAN.order),
        ..Properties::of(&H::PLAN, size_of::<H::Memory<f64>>())
    };
    type Prepared<K: Constant> = Of<H::Prepared, K>;
    type Memory<S: Scalar> = H::Memory<S>;
    type Compensated<S: Scalar> = Compensation<S, D>;
    type Carry<S: Scalar> = H::Carry<S>;

    fn prepare<K: Constant>(system: &H, lift: Lift<'_, K>, h: K) -> Result<Self::Prepared<K>, ConfigError> {
        system.prepare(lift, h)
    }

    fn gather<const L: usize>(prepared: [&Self::Prepared<f64>; L]) -> Option<Self::Prepared<Lanes<L>>> {
        Some(H::Prepared::gather(prepared))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: Over<K>, C: Carry<S>, const CAREFUL: bool>(
        _: &H,
        prepared: &Self::Prepared<K>,
        At { t, h, q, p, dw }: At<'_, S, K>,
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let (q, p) = (array_mut(q)?, array_mut(p)?);
        let dw = increments::<_, N>(dw)?;
        let mut next = Solution::nowhere();
        let solved = H::solve::<S, K, C, CAREFUL>(prepared, t, h, *q, *p, dw, memory, carry, &mut next);
        // Without iteration, all lanes fail together.
        if size_of::<H::Memory<f64>>() == 0 {
            solved?;
            Ok(next.store(q, p, carry))
        } else {
            next.arrive(solved, q, p, carry)
        }
    }

    fn discrete_lagrangian(system: &H, segment: &Segment<H::Vector>, dw: &[f64]) -> f64 {
        elements::discrete_lagrangian(system, &H::QUADRATURE, segment, dw)
    }

    fn discrete_lagrangian_gradient(
        system: &H,
        segment: &Segment<H::Vector>,
        dw: &[f64],
    ) -> LagrangianGradient<H::Vector> {
        elements::discrete_lagrangian_gradient(system, &H::QUADRATURE, segment, dw)
    }

    fn step_momentum(
        system: &H,
        before: &State<H::Vector>,
        after: &State<H::Vector>,
        h: f64,
        dw: &[f64],
    ) -> H::Vector {
        elements::step_momentum(system, &H::QUADRATURE, [before, after], h, dw)
    }
}
