//! Steps that are solved in straight lines, block by block: what is generated for one scheme of a small system, and what is the same for all.

use std::fmt::Debug;
use std::marker::PhantomData;

use super::{At, LagrangianGradient, Properties, Scheme, Segment, Solution, array_mut, increments};
use crate::algebra::carry::{Carry, Compensation, Plain};
use crate::algebra::lanes::Lanes;
use crate::algebra::memory::StepMemory;
use crate::algebra::scalar::{Constant, Over, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state::State;
use crate::error::{ConfigError, StepFailure};
use crate::scheme::elements::{self, Elements};
use crate::scheme::plan::Plan;

/// The step of a system with `D` degrees of freedom and `N` noises by the scheme `E`; generated.
pub trait StraightLine<E, const D: usize, const N: usize>: Elements + Sized {
    /// What the compiler found out.
    const PLAN: Plan;
    /// The quadrature that the discrete Lagrangian is.
    const QUADRATURE: elements::Quadrature;
    /// What does not change from step to step: numbers, truths and factors of matrices.
    type Prepared<K: Constant>: Clone + Debug + Send + Sync;
    /// One extrapolation for each block that is iterated on.
    type Memory<S: Scalar>: StepMemory;
    /// How increments are added unless the user chooses.
    type Carry<S: Scalar>: Carry<S>;

    /// Computes it.
    ///
    /// # Errors
    /// Where a parameter is no number, or a matrix that is factored here is singular.
    fn prepare(&self, h: f64) -> Result<Self::Prepared<f64>, ConfigError>;

    /// That of `L` systems, each in its lane.
    fn gather<const L: usize>(prepared: [&Self::Prepared<f64>; L]) -> Self::Prepared<Lanes<L>>;

    /// The end of the step into `next`.
    ///
    /// # Errors
    /// Where a block has no solution that could be found, or the end is not finite.
    #[expect(clippy::too_many_arguments, reason = "generated code reads each by its name")]
    fn solve<S: Over<K>, K: Constant, C: Carry<S>, const CAREFUL: bool>(
        prepared: &Self::Prepared<K>,
        t: f64,
        h: f64,
        q: [S; D],
        p: [S; D],
        dw: [S; N],
        memory: &mut Self::Memory<S>,
        carry: &C,
        next: &mut Solution<S, D>,
    ) -> Result<(), StepFailure>;
}

/// Steps that are solved in straight lines.
#[derive(Clone, Copy, Debug)]
pub struct Straight<E, const D: usize, const N: usize>(PhantomData<E>);

/// A step by what is prepared of one system, or of one in each lane.
#[cfg_attr(not(debug_assertions), inline(always))]
fn advance<H, E, K, S, C, const D: usize, const N: usize, const CAREFUL: bool>(
    prepared: &H::Prepared<K>,
    At { t, h, q, p, dw }: At<'_, S>,
    memory: &mut H::Memory<S>,
    carry: &mut C,
) -> Result<Effort, StepFailure>
where
    H: StraightLine<E, D, N>,
    K: Constant,
    S: Over<K>,
    C: Carry<S>,
{
    let (q, p) = (array_mut(q)?, array_mut(p)?);
    let dw = increments::<_, N>(dw)?;
    let mut next = Solution::nowhere();
    let solved = H::solve::<S, K, C, CAREFUL>(prepared, t, h, *q, *p, dw, memory, carry, &mut next);
    // What is not iterated on fails in all lanes.
    if size_of::<H::Memory<f64>>() == 0 {
        solved?;
        Ok(next.store(q, p, carry))
    } else {
        next.arrive(solved, q, p, carry)
    }
}

impl<H, E, const D: usize, const N: usize> Scheme<H> for Straight<E, D, N>
where
    H: StraightLine<E, D, N>,
{
    const PLAN: Plan = H::PLAN;
    const PROPERTIES: Properties = Properties {
        kept_energy: H::QUADRATURE.kept_energy(H::PLAN.order),
        ..Properties::of(&H::PLAN, size_of::<H::Memory<f64>>())
    };
    type Prepared = H::Prepared<f64>;
    type Memory<S: Scalar> = H::Memory<S>;
    type Compensated<S: Scalar> = Compensation<S, D>;
    type Carry<S: Scalar> = H::Carry<S>;
    type Beside<const L: usize> = H::Prepared<Lanes<L>>;

    fn prepare(system: &H, h: f64) -> Result<Self::Prepared, ConfigError> {
        system.prepare(h)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<S: Scalar, C: Carry<S>, const CAREFUL: bool>(
        _: &H,
        prepared: &Self::Prepared,
        at: At<'_, S>,
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        advance::<H, E, f64, S, C, D, N, CAREFUL>(prepared, at, memory, carry)
    }

    fn beside<const L: usize>(_: [&H; L], prepared: [&Self::Prepared; L]) -> Option<Self::Beside<L>> {
        Some(H::gather(prepared))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance_beside<const L: usize>(
        beside: &Self::Beside<L>,
        at: At<'_, Lanes<L>>,
        memory: &mut Self::Memory<Lanes<L>>,
    ) -> Result<Effort, StepFailure> {
        advance::<H, E, Lanes<L>, Lanes<L>, Plain, D, N, false>(beside, at, memory, &mut Plain)
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
