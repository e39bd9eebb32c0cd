//! The equations of a step in the form that [`damped`] takes, for steps where the fast iteration fails.

use super::linear::LinearSolver;
use super::memory::{CarefulScratch, IterationMemory, LoopScratch, StepLists};
use super::rounding::Rounding;
use super::step::LoopStep;
use super::{Elements, LoopMemory};
use crate::algebra::scalar::Scalar;
use crate::algebra::solve::{Effort, Problem, astray, damped};
use crate::error::StepFailure;

/// Residual of linear equations solved by iteration: small enough for nearly quadratic convergence of
/// Newton's method.
const TOLERANCE: f64 = 1e-10;

impl<H: Elements, S: Scalar> LoopStep<'_, H, S> {
    /// Solves for the unknowns, if there are any, by [`damped`]; leaves `u` and `P`.
    #[inline(never)]
    pub(super) fn careful(self, memory: &mut LoopMemory<S>) -> Result<Effort, StepFailure> {
        memory.solver.kept.lose();
        let known = memory.solver.past.known;
        let mut scratch = memory.scratch(self.scheme, self.degrees());
        scratch.guess(known);
        let LoopScratch { mut lists, solver, .. } = scratch;
        let IterationMemory {
            diagonal,
            linear,
            rounding,
            care: CarefulScratch { start, are_settled, room },
            ..
        } = solver;
        let Some(linear) = linear else { return Err(astray(0, f64::INFINITY)) };
        start.clear();
        start.extend_from_slice(lists.x);
        let lists = &mut lists;
        let mut sweep = CarefulEquations { step: self, lists, diagonal, linear, rounding, are_settled };
        let effort = damped(&mut sweep, room, start)?;
        lists.x.copy_from_slice(room.solution());
        self.refresh(lists);
        Ok(effort)
    }
}

/// The equations of a step with their scratch.
struct CarefulEquations<'a, 's, H, S: Scalar> {
    step: LoopStep<'s, H, S>,
    lists: &'a mut StepLists<'s, S>,
    diagonal: &'a mut [S],
    linear: &'a mut LinearSolver<S>,
    rounding: &'a mut Option<Box<Rounding>>,
    are_settled: &'a mut Vec<bool>,
}

impl<H: Elements, S: Scalar> Problem for CarefulEquations<'_, '_, H, S> {
    type Number = S;
    type Vector = Vec<S>;

    fn residual(&mut self, x: &Vec<S>, into: &mut Vec<S>) {
        self.lists.x.copy_from_slice(x);
        self.step.residual(self.lists);
        into.copy_from_slice(self.lists.correction);
    }

    fn factor(&mut self) -> Result<usize, StepFailure> {
        self.step.factor_with_care(self.lists, self.diagonal, self.linear)
    }

    fn correct(&mut self, r: &mut Vec<S>) -> Result<(), StepFailure> {
        self.lists.correction.copy_from_slice(r);
        self.step.correct(self.lists, self.diagonal, self.linear, TOLERANCE)?;
        r.copy_from_slice(self.lists.correction);
        Ok(())
    }

    fn are_settled(&mut self, x: &Vec<S>) -> impl AsRef<[bool]> {
        self.are_settled.clear();
        let residuals = self.step.round(x, self.rounding);
        self.are_settled.extend(residuals.iter().map(|residual| residual.is_below(1.0)));
        &*self.are_settled
    }

    /// `false` if the determinant is not known.
    fn is_reversed(&self) -> bool {
        self.linear.is_reversed()
    }
}
