//! The equations of a sweep for the steps where the short way fails: what [`damped`] asks of them.

use super::jacobian::Linear;
use super::memory::Work;
use super::rounding::Rounding;
use super::step::Step;
use super::{Elements, Memory, Unknowns};
use crate::error::StepFailure;
use crate::scalar::Scalar;
use crate::solve::{Effort, Problem, Room, astray, damped};

/// Residual of linear equations that are solved by iteration: below what a convergence that is nearly quadratic shows.
const TOLERANCE: f64 = 1e-10;

impl<H: Elements, S: Scalar> Step<'_, H, S> {
    /// Solves for the unknowns with care.
    pub(super) fn careful(&self, memory: &mut Memory<S>) -> Result<Effort, StepFailure> {
        if self.scheme.unknowns == Unknowns::None {
            self.explicit(&mut memory.work);
            return Ok(Effort::fast(0));
        }
        memory.guess(memory.known);
        let is_guess = memory.known > 0;
        memory.factored = None;
        let Memory { work, linear, rounding, .. } = memory;
        let Some(linear) = linear else { return Err(astray(0, f64::INFINITY)) };
        let start = work.x.clone();
        let mut room = Room::of(&start);
        let effort = damped(&mut Sweep { step: self, work, linear, rounding }, &mut room, &start, is_guess)?;
        work.x.copy_from_slice(room.solution());
        self.refresh(work);
        Ok(effort)
    }
}

/// The equations of a step with their scratch.
struct Sweep<'a, 's, H, S> {
    step: &'a Step<'s, H, S>,
    work: &'a mut Work<S>,
    linear: &'a mut Linear<S>,
    rounding: &'a mut Option<Box<Rounding>>,
}

impl<H: Elements, S: Scalar> Problem for Sweep<'_, '_, H, S> {
    type Number = S;
    type Vector = Vec<S>;

    fn residual(&mut self, x: &Vec<S>, into: &mut Vec<S>) {
        self.work.x.copy_from_slice(x);
        self.step.residual(self.work);
        into.copy_from_slice(&self.work.correction);
    }

    fn factor(&mut self) -> Result<(), StepFailure> {
        self.step.linearise(self.work, self.linear)
    }

    fn correct(&mut self, r: &mut Vec<S>) -> Result<(), StepFailure> {
        self.work.correction.copy_from_slice(r);
        self.step.correct(self.work, self.linear, TOLERANCE)?;
        r.copy_from_slice(&self.work.correction);
        Ok(())
    }

    fn are_settled(&mut self, x: &Vec<S>, roundings: f64) -> impl Fn(usize) -> bool {
        let rounding = self.step.round(x, self.rounding);
        move |k| rounding.is_settled(k, roundings)
    }

    /// Not known where the matrix is not.
    fn is_reversed(&self) -> bool {
        match &*self.linear {
            Linear::Band(band) => band.is_reversed(),
            Linear::Krylov(_) => false,
        }
    }
}
