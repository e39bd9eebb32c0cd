//! The cost of the iterations of a step, in numbers of operations that follow from the pattern of the
//! Jacobian.
//!
//! A time that was measured would make the steps of one machine differ from those of another. With `n`
//! unknowns and `e` entries of the pattern off the diagonal, a sweep of the fixed point takes about `4 n + e`
//! operations, and an iteration of Newton's method a sweep for its residual and the solution of the linear
//! equations. New factors take three sweeps for the second derivatives, and the elimination. In a step of
//! Newton's method, four iterations follow on factors that two steps share.

use super::linear::LinearSolver;
use crate::algebra::scalar::Scalar;
use crate::algebra::solve::{CONTRACTION, ROUNDING};

/// Operations of a sweep per unknown, for the state.
const PER_UNKNOWN: f64 = 4.0;
/// Second derivatives of all elements, in sweeps.
const SECOND_DERIVATIVES: f64 = 3.0;
/// Iterations of a step of Newton's method.
const ITERATIONS: f64 = 4.0;
/// Iterations that finish a step with new factors.
const WITH_NEW_FACTORS: f64 = 2.0;
/// Steps that share factors.
const SHARED: f64 = 2.0;
/// A step of Newton's method in sweeps where the linear equations are solved by iteration: four iterations,
/// each with ten products with the Jacobian.
const BY_KRYLOV: f64 = 60.0;
/// The first correction of most steps, which starts from an extrapolation.
const FIRST: f64 = 1e-3;
/// Corrections that shrink to this fraction are never replaced by others: twenty of them finish most steps,
/// and take no longer than the recurrences of Newton's method, even for a chain.
pub(super) const FAST: f64 = 0.2;

/// The costs of the iterations, as numbers of other iterations.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Costs {
    /// A step of Newton's method, in sweeps of the fixed point.
    newton: f64,
    /// New factors, in iterations of Newton's method.
    factors: f64,
    /// The slowest contraction with which the fixed point costs less than Newton's method.
    pub(super) slowest: f64,
}

impl Costs {
    /// The costs for a pattern with so many entries off the diagonal; of an explicit step there are none.
    pub(super) fn of<S: Scalar>(entries: usize, unknowns: usize, linear: Option<&LinearSolver<S>>) -> Self {
        let Some(linear) = linear else { return Self::default() };
        let sweep = (PER_UNKNOWN * unknowns as f64 + entries as f64).max(1.0);
        let (newton, factors) = match linear {
            LinearSolver::Band(band) => {
                let iteration = sweep + band.solution_cost();
                let factors = SECOND_DERIVATIVES * sweep + band.elimination_cost();
                ((ITERATIONS * iteration + factors / SHARED) / sweep, factors / iteration)
            }
            LinearSolver::Bordered(bordered) => {
                let terms = bordered.terms.count() as f64;
                let solution = bordered.band.solution_cost() + 2.0 * terms * unknowns as f64;
                let elimination = bordered.band.elimination_cost() + terms * solution;
                let (iteration, factors) = (sweep + solution, SECOND_DERIVATIVES * sweep + elimination);
                ((ITERATIONS * iteration + factors / SHARED) / sweep, factors / iteration)
            }
            LinearSolver::Krylov(_) => (BY_KRYLOV, 0.0),
        };
        let slowest = [CONTRACTION, 0.4, 0.3].into_iter().find(|&ratio| takes(FIRST, ratio) <= newton);
        Self { newton, factors, slowest: slowest.unwrap_or(FAST) }
    }

    /// Whether corrections that shrink by `ratio` finish with fewer operations than others would: those of
    /// the fixed point, or of old factors if `is_newton`.
    pub(super) fn pay(&self, is_newton: bool, relative: f64, ratio: f64) -> bool {
        takes(relative, ratio) <= if is_newton { self.factors + WITH_NEW_FACTORS } else { self.newton }
    }

    /// New factors, in iterations of Newton's method.
    pub(super) fn factors(&self) -> u64 {
        self.factors.ceil() as u64
    }
}

/// How many more corrections are needed after one of this size, if they shrink by `ratio`.
fn takes(relative: f64, ratio: f64) -> f64 {
    if ratio.is_nan() || ratio > CONTRACTION {
        return f64::INFINITY;
    }
    let (mut left, mut corrections) = (relative, 0.0);
    while left > ROUNDING {
        left *= ratio;
        corrections += 1.0;
    }
    corrections
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corrections_are_counted() {
        // 2^-3 to 2^-52
        assert_eq!(takes(0.125, 0.5), 49.0);
        assert_eq!(takes(0.0, 0.5), 0.0);
        assert_eq!(takes(0.125, f64::NAN), f64::INFINITY);
    }

    /// A chain is eliminated as fast as it is swept a few times; a dense matrix is not.
    #[test]
    fn wide_matrices_are_dear() {
        let chain = |visit: &mut dyn FnMut(usize, usize)| (1..100).for_each(|i| visit(i, i - 1));
        let all = |visit: &mut dyn FnMut(usize, usize)| {
            (0..100).for_each(|i| (0..100).filter(|&j| j != i).for_each(|j| visit(i, j)));
        };
        let chain = Costs::of(198, 100, Some(&LinearSolver::<f64>::new(&chain, 100, Default::default())));
        let all = Costs::of(9900, 100, Some(&LinearSolver::<f64>::new(&all, 100, Default::default())));
        assert!((10.0..20.0).contains(&chain.newton), "{chain:?}");
        assert!(all.newton > 2.0 * chain.newton && all.slowest > chain.slowest, "{all:?}");
    }
}
