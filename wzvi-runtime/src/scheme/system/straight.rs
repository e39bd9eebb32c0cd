//! Steps in straight-line code, block by block: the generated part for one scheme of a small system, what it
//! solves for and in which lists, and the common part.

use std::marker::PhantomData;

use super::{LagrangianGradient, LiftParameter, Movable, Properties, Scheme, Segment, StepArguments};
use crate::algebra::lanes::Lanes;
use crate::algebra::memory::StepMemory;
use crate::algebra::scalar::{ComputesWith, Constant, Constants, ConstantsIn, Mask, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state::State;
use crate::algebra::state_sum::{FixedCompensatedSum, StateSum};
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
    type Sum<S: Scalar>: StateSum<S>;

    /// Computes the constants.
    ///
    /// # Errors
    /// If a parameter is NaN, or a matrix that is factored here is singular.
    fn prepare<K: Constant>(
        &self,
        lift: LiftParameter<'_, K>,
        h: K,
    ) -> Result<ConstantsIn<Self::Prepared, K>, ConfigError>;

    /// Writes the end of the step into `next`.
    ///
    /// # Errors
    /// If no solution of a block was found, or the end is not finite.
    #[expect(clippy::too_many_arguments, reason = "generated code reads each by its name")]
    fn solve<S: ComputesWith<K>, K: Constant, C: StateSum<S>, const CAREFUL: bool>(
        prepared: &ConstantsIn<Self::Prepared, K>,
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

/// One solved step of a system with `D` degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<S, const D: usize> {
    /// `q_{i+1}`, and its rounding error.
    pub q: [(S, S); D],
    /// `p_{i+1}`, and its rounding error.
    pub p: [(S, S); D],
    /// The effort of Newton's method over all blocks.
    pub effort: Effort,
}

impl<S: Scalar, const D: usize> Solution<S, D> {
    /// The place for a solution. It is not returned in a `Result`: numbers that share memory with a
    /// [`StepFailure`] are not kept in vector registers.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn nowhere() -> Self {
        let nan = S::from_f64(f64::NAN);
        Self { q: [(nan, nan); D], p: [(nan, nan); D], effort: Effort::fast(0) }
    }

    /// The nodes that the increments `dq`, `dp` lead to from `q`, `p`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new<C: StateSum<S>>(
        carry: &C,
        [q, p]: [[S; D]; 2],
        [dq, dp]: [[S; D]; 2],
        effort: Effort,
    ) -> Self {
        // Plain loops: closures would be compiled without the vector instructions of the caller.
        let zero = S::from_f64(0.0);
        let (mut next_q, mut next_p) = ([(zero, zero); D], [(zero, zero); D]);
        for i in 0..D {
            next_q[i] = C::add(q[i], dq[i], carry.of_coordinate(i));
            next_p[i] = C::add(p[i], dp[i], carry.of_momentum(i));
        }
        Self { q: next_q, p: next_p, effort }
    }

    /// Whether every component is finite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn is_finite(&self) -> bool {
        S::are_finite([self.q, self.p]).all()
    }

    /// The paths for which every component is finite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn are_finite(&self) -> S::Mask {
        S::are_finite([self.q, self.p])
    }

    /// Checks that every component is finite, for paths that succeed or fail together.
    ///
    /// # Errors
    /// [`StepFailure::NonFinite`]
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn ensure_finite(&self) -> Result<(), StepFailure> {
        if self.is_finite() { Ok(()) } else { Err(StepFailure::NonFinite) }
    }

    /// Checks that all paths in lanes have `taken` the step.
    ///
    /// # Errors
    /// The errors of the paths that have not.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn ensure_taken(&self, taken: S::Mask) -> Result<(), StepFailure> {
        if taken.all() { Ok(()) } else { Err(StepFailure::but_of::<S>(taken)) }
    }

    /// [`Solution::store`] if the step was solved; of paths in lanes, only those that have solved it move.
    ///
    /// # Errors
    /// The failure of the solution.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn arrive<C: StateSum<S>>(
        self,
        solved: Result<(), StepFailure>,
        q: &mut [S; D],
        p: &mut [S; D],
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        match solved {
            Ok(()) => Ok(self.store(q, p, carry)),
            Err(cause) => {
                if S::MAY_FAIL_BY_LANE {
                    self.store_in_part(q, p, carry);
                }
                Err(cause)
            }
        }
    }

    /// Inlined: the solution has no address, and stays in registers unless the step fails.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn store_in_part<C: StateSum<S>>(&self, q: &mut [S; D], p: &mut [S; D], carry: &mut C) {
        let are_finite = self.are_finite();
        let mut lost = [[S::from_f64(0.0); D]; 2];
        for i in 0..D {
            q[i] = S::select(are_finite, self.q[i].0, q[i]);
            p[i] = S::select(are_finite, self.p[i].0, p[i]);
            lost[0][i] = S::select(are_finite, self.q[i].1, carry.of_coordinate(i));
            lost[1][i] = S::select(are_finite, self.p[i].1, carry.of_momentum(i));
        }
        carry.keep(&lost[0], &lost[1]);
    }

    /// Moves the state.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn store<C: StateSum<S>>(self, q: &mut [S; D], p: &mut [S; D], carry: &mut C) -> Effort {
        let mut lost = [[S::from_f64(0.0); D]; 2];
        for i in 0..D {
            (q[i], lost[0][i]) = self.q[i];
            (p[i], lost[1][i]) = self.p[i];
        }
        carry.keep(&lost[0], &lost[1]);
        self.effort
    }
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
        differentiates_lanes: true,
        kept_energy: H::QUADRATURE.kept_energy(H::PLAN.order),
        poles: H::QUADRATURE.poles(),
        ..Properties::of(&H::PLAN, size_of::<H::Memory<f64>>())
    };
    const POINTS: Option<&'static [elements::QuadraturePoint]> = Some(H::QUADRATURE.stages);
    type Prepared<K: Constant> = ConstantsIn<H::Prepared, K>;
    type Memory<S: Scalar> = H::Memory<S>;
    type Unclocked = Self;
    type CompensatedSum<S: Scalar> = FixedCompensatedSum<S, D>;
    type Sum<S: Scalar> = H::Sum<S>;

    fn prepare<K: Constant>(
        system: &H,
        lift: LiftParameter<'_, K>,
        h: K,
    ) -> Result<Self::Prepared<K>, ConfigError> {
        let prepared = system.prepare(lift, h)?;
        elements::check_places(system)?;
        Ok(prepared)
    }

    fn gather<const L: usize>(prepared: [&Self::Prepared<f64>; L]) -> Option<Self::Prepared<Lanes<L>>> {
        Some(H::Prepared::gather(prepared))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        _: &H,
        prepared: &Self::Prepared<K>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let StepArguments { t, h, q, p, dw } = at.lists();
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

/// `slice` as an array of the degrees of freedom.
///
/// # Errors
/// [`StepFailure::Dimension`] if its length is another.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn array_mut<S, const D: usize>(slice: &mut [S]) -> Result<&mut [S; D], StepFailure> {
    let got = slice.len();
    slice.try_into().map_err(|_| StepFailure::Dimension { expected: D, got })
}

/// Fills `by_q` and `by_p` with a gradient, or with NaN if their length is another.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn gradient<S: Scalar, const D: usize>(by_q: &mut [S], by_p: &mut [S], of_q: [S; D], of_p: [S; D]) {
    if by_q.len() == D && by_p.len() == D {
        by_q.copy_from_slice(&of_q);
        by_p.copy_from_slice(&of_p);
    } else {
        by_q.fill(S::from_f64(f64::NAN));
        by_p.fill(S::from_f64(f64::NAN));
    }
}

/// Fills `into` with a covector, or with NaN if its length is another.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn covector<S: Scalar, const D: usize>(into: &mut [S], components: [S; D]) {
    if into.len() == D {
        into.copy_from_slice(&components);
    } else {
        into.fill(S::from_f64(f64::NAN));
    }
}

/// `dw` as an array of one increment per noise.
///
/// # Errors
/// [`StepFailure::Increments`] if its length is another.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn increments<S: Copy, const K: usize>(dw: &[S]) -> Result<[S; K], StepFailure> {
    dw.try_into().map_err(|_| StepFailure::Increments { expected: K, got: dw.len() })
}
