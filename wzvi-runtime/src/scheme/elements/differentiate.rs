//! The derivatives that the numbers of an implicit step carry, by the Jacobian at its solution.
//!
//! `x = φ(x; z)` is solved for the values alone. With `J = 1 - ∂φ/∂x` there, the derivatives of the unknowns
//! are `x' = J⁻¹ φ'`, where `φ'` are those of `φ` at unknowns without derivatives. One factorisation serves
//! all of them. Krylov's method solves for one after the other, with the factors of its preconditioner, so
//! that a large lattice needs no matrix of derivatives.

use super::linear::LinearSolver;
use super::low_rank::SubstitutionScratch;
use super::memory::{IterationMemory, LoopScratch};
use super::step::LoopStep;
use super::{Elements, LoopMemory};
use crate::algebra::scalar::Scalar;
use crate::algebra::solve::{Effort, astray};
use crate::error::StepFailure;
use crate::ground::numbers::numbers;

/// Residual of equations for derivatives that are solved by iteration, in each of [`PASSES`].
const TOLERANCE: f64 = 1e-10;
/// Krylov's method starts again from the residual that it left, so that no more than rounding remains.
const PASSES: u32 = 2;

/// The values of a step, solved for alone.
#[derive(Default)]
pub(super) struct ScalarSolution<S> {
    pub(super) memory: LoopMemory<f64>,
    q: Vec<f64>,
    p: Vec<f64>,
    dw: Vec<f64>,
    /// Scratch for a substitution in numbers with derivatives.
    substitution: SubstitutionScratch<S>,
    /// Whether they have taken this step, and there are factors of its Jacobian.
    pub(super) are_solved: bool,
}

numbers! {
    impl[S] Numbers for ScalarSolution<S> { kept: memory; scratch: q, p, dw, substitution, are_solved }
}

impl<H: Elements + Sync, S: Scalar> LoopStep<'_, H, S> {
    /// Solves for the unknowns with their derivatives; leaves `u` and `P`.
    ///
    /// # Errors
    /// The errors of the step; [`StepFailure::NonFinite`] where second derivatives at its solution are not
    /// finite.
    #[inline(never)]
    pub(super) fn differentiate<const CAREFUL: bool>(
        self,
        memory: &mut LoopMemory<S>,
    ) -> Result<Effort, StepFailure> {
        let mut values = memory.values.take().unwrap_or_default();
        let effort = self.differentiate_at::<CAREFUL>(&mut values, memory);
        memory.values = Some(values);
        effort
    }

    fn differentiate_at<const CAREFUL: bool>(
        self,
        values: &mut ScalarSolution<S>,
        memory: &mut LoopMemory<S>,
    ) -> Result<Effort, StepFailure> {
        let (system, scheme, degrees) = (self.system, self.scheme, self.degrees());
        let ScalarSolution { memory: own, q, p, dw, substitution, are_solved } = values;
        let are_solved = std::mem::take(are_solved);
        for (own, all) in [(&mut *q, self.q), (&mut *p, self.p), (&mut *dw, self.dw)] {
            own.clear();
            own.extend(all.iter().map(|number| number.lane(0)));
        }
        let [t, h] = [self.t, self.h].map(|constant| constant.lane(0));
        let step = LoopStep::<H, f64> { system, scheme, t, h, parameters: &[], q, p, dw, increment: None };
        let effort = if are_solved {
            Effort::fast(0)
        } else {
            if !own.fits(system, degrees) {
                own.fit(system, scheme, degrees)?;
            }
            step.solve_values::<CAREFUL>(own)?
        };
        let LoopMemory {
            work,
            solver: IterationMemory { iteration, diagonal, linear: Some(linear), kept, .. },
            ..
        } = own
        else {
            return Err(astray(0, f64::INFINITY));
        };
        let mut lists = work.lists(scheme, degrees);
        if !are_solved {
            step.residual(&mut lists);
            kept.begin();
            step.renew(&lists, diagonal, linear, kept, *iteration)?;
            kept.succeed(0);
        }
        let mut all = memory.work.lists(scheme, degrees);
        all.x.iter_mut().zip(&*lists.x).for_each(|(x, &value)| *x = S::from_f64(value));
        let passes = if let LinearSolver::Krylov(_) = linear { PASSES } else { 1 };
        for _ in 0..passes {
            self.residual(&mut all);
            all.correction.iter_mut().for_each(|residual| *residual = residual.infinitesimal());
            match linear {
                LinearSolver::Band(band) => band.solve_in_room(all.correction, &mut substitution.solved),
                LinearSolver::Bordered(bordered) => bordered.solve_in_room(all.correction, substitution),
                LinearSolver::Krylov(_) => {
                    for number in 0..S::DERIVATIVES {
                        for (own, residual) in lists.correction.iter_mut().zip(&*all.correction) {
                            *own = residual.derivative(number).lane(0);
                        }
                        step.correct(&mut lists, diagonal, linear, TOLERANCE)?;
                        for (correction, own) in all.correction.iter_mut().zip(&*lists.correction) {
                            correction.set_derivative(number, S::Value::from_f64(*own));
                        }
                    }
                }
            }
            all.x.iter_mut().zip(&*all.correction).for_each(|(x, &correction)| *x = *x - correction);
        }
        self.refresh(&mut all);
        Ok(effort)
    }
}

impl<H: Elements + Sync> LoopStep<'_, H, f64> {
    /// Solves for the values of the unknowns, which remain in the lists of the memory.
    fn solve_values<const CAREFUL: bool>(self, own: &mut LoopMemory<f64>) -> Result<Effort, StepFailure> {
        let (scheme, degrees) = (self.scheme, self.degrees());
        if CAREFUL {
            let effort = self.careful(own)?;
            own.record(scheme, degrees);
            return Ok(effort);
        }
        // Not tile by tile: the unknowns are needed.
        let mut scratch = LoopScratch { is_exact: true, ..own.scratch(scheme, degrees) };
        let solved = self.solve(&mut scratch)?;
        own.solver.preference.learn(solved.solution);
        if scheme.remembers {
            own.record(scheme, degrees);
        }
        Ok(Effort::fast(solved.iterations))
    }
}
