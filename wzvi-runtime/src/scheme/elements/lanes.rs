//! The fixed point of independent paths in the lanes of a number.
//!
//! Each path takes the decisions that it takes alone, by the same comparisons. Its unknowns stay as they are
//! once its equations are solved, while those of others go on. Where a path needs more than a fixed point
//! that contracts, all go alone in this step.

use super::costs::{Costs, FAST};
use super::iterate::{IterationState, NEARLY_SOLVED};
use super::memory::StepLists;
use super::pairs::LEAST_IN_COLUMNS;
use super::step::LoopStep;
use super::{Elements, Quadrature, Unknowns};
use crate::algebra::scalar::{Mask, Scalar};
use crate::algebra::solve::{Contraction, ROUNDING, UNSEEN, astray};
use crate::error::StepFailure;
use crate::scheme::plan::Facts;

/// The most degrees of freedom of paths of an implicit scheme that go side by side: the lists of many larger
/// ones fill the cache.
const MOST: usize = 64;

/// Whether paths of an implicit scheme are solved side by side: not where the derivatives of each are in
/// vector instructions by themselves. Equations with a constant Jacobian are solved with kept factors.
pub(super) const fn allow_lanes(facts: &Facts, quadrature: &Quadrature) -> bool {
    let takes_vectors = facts.has_pairs || facts.gathers.by_q || facts.gathers.by_p;
    let is_small = facts.degrees <= MOST && !(takes_vectors && facts.degrees >= LEAST_IN_COLUMNS);
    is_small && !quadrature.linearity.is_constant()
}

/// Whether numbers are several independent paths.
pub(super) const fn is_in_lanes<S: Scalar>() -> bool {
    S::LANES_ARE_PATHS && S::LANES > 1
}

/// A correction relative to the largest unknown, and what it says together with the one before.
#[derive(Clone, Copy)]
pub(super) struct ConvergenceRate<R: Scalar> {
    relative: R,
    ratio: R,
    contraction: Contraction<R>,
}

impl<R: Scalar> ConvergenceRate<R> {
    /// From the last two corrections; the one before the first is infinite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn of(relative: R, last: R) -> Self {
        let zero = R::from_f64(0.0);
        let last = R::select(last.less(R::from_f64(f64::INFINITY)), last, zero);
        let contraction = Contraction::new(relative, last);
        Self { relative, ratio: contraction.ratio(), contraction }
    }

    /// The ratio of the next correction to this one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn expected(self) -> R {
        R::select(self.contraction.contracts(), self.ratio, R::from_f64(1.0))
    }

    /// Whether this correction or the next one is at the rounding of the largest unknown, so that it is worth
    /// looking at each ([`LoopStep::resolves`]).
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn is_enough(self) -> R::Mask {
        self.relative.less_equal(R::from_f64(ROUNDING)) | self.contraction.leaves_unseen(UNSEEN)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn stagnates(self) -> R::Mask {
        self.contraction.stagnates()
    }

    /// Whether other corrections are worth their cost.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn needs_more(self, is_newton: bool, costs: Costs) -> R::Mask {
        let is_slow = self.contraction.is_second() & R::from_f64(FAST).less(self.ratio);
        let is_open = is_slow & R::from_f64(NEARLY_SOLVED).less(self.relative);
        if is_open.any() {
            let Self { relative, ratio, .. } = self;
            let pay = R::Mask::of_lanes(|lane| costs.pay(is_newton, relative.lane(lane), ratio.lane(lane)));
            return self.stagnates() | (is_open & !pay);
        }
        self.stagnates()
    }
}

impl<H: Elements + Sync, S: Scalar> LoopStep<'_, H, S> {
    /// [`LoopStep::is_solved`] of all paths.
    ///
    /// # Errors
    /// If a path needs another method.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn are_solved(
        self,
        lists: &StepLists<'_, S>,
        iteration: &mut IterationState<S>,
        relative: S,
    ) -> Result<bool, StepFailure> {
        let pace = ConvergenceRate::of(relative, iteration.last);
        let mut solved = iteration.solved;
        let is_enough = pace.is_enough() & !solved;
        if is_enough.any() {
            solved = solved | (is_enough & self.resolves(lists, pace.expected(), S::abs));
        }
        if !solved.all() {
            solved = solved | self.changes_nothing(lists);
        }
        (iteration.solved, iteration.last) = (solved, relative);
        if (pace.needs_more(false, iteration.costs) & !solved).any() {
            return Err(astray(iteration.iterations, relative.magnitude()));
        }
        Ok(solved.all())
    }
}

/// Corrections of zero where equations are solved.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn hold<S: Scalar>(corrections: &mut [S], solved: S::Mask) {
    if !solved.any() {
        return;
    }
    for correction in corrections {
        *correction = S::select(solved, S::from_f64(0.0), *correction);
    }
}

/// [`subtract`](super::passes::subtract) of each path.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn subtract_in_lanes<S: Scalar>(kind: Unknowns, x: &mut [S], corrections: &[S]) -> S {
    let [mut first, mut second] = [LargestInLanes::<S>::none(), LargestInLanes::none()];
    if kind == Unknowns::Both {
        let pairs = x.as_chunks_mut().0.iter_mut().zip(corrections.as_chunks().0);
        for ([u, v], &[of_u, of_v]) in pairs {
            first.correct(u, of_u);
            second.correct(v, of_v);
        }
    } else {
        for (x, &correction) in x.iter_mut().zip(corrections) {
            first.correct(x, correction);
        }
    }
    let (zeros, [first, second]) = (first.zeros + second.zeros, [first.relative(), second.relative()]);
    S::select(first.less(second), second, first) + zeros
}

/// The largest unknown of a kind, and the largest correction. One variable for each, which stays in
/// registers.
struct LargestInLanes<S> {
    size: S,
    change: S,
    /// NaN after a correction that is not finite, which a maximum may lose; else zero.
    zeros: S,
}

impl<S: Scalar> LargestInLanes<S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn none() -> Self {
        let zero = S::from_f64(0.0);
        Self { size: zero, change: zero, zeros: zero }
    }

    /// Subtracts the correction of an unknown, and includes both.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn correct(&mut self, x: &mut S, correction: S) {
        let moved = *x - correction;
        *x = moved;
        let (size, change) = (moved.abs(), correction.abs());
        self.size = S::select(self.size.less(size), size, self.size);
        self.change = S::select(self.change.less(change), change, self.change);
        self.zeros = self.zeros + correction * 0.0;
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn relative(&self) -> S {
        self.change / (self.size + f64::MIN_POSITIVE)
    }
}
