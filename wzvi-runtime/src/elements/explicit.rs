//! One step of a scheme that solves nothing: `v` and then `u` are assigned.

use super::memory::Lists;
use super::passes::{add, are_finite};
use super::step::Step;
use super::{Elements, Memory, MomentumUpdate, Scheme, Slopes};
use crate::carry::Carry;
use crate::error::StepFailure;
use crate::scalar::Scalar;
use crate::solve::Effort;

/// One step from `(q, p)` at `t` in place; on `Err` nothing but scratch is changed.
///
/// Inlined into the step of one system by one scheme, where the table of the scheme, and often the number of degrees of
/// freedom, are constants: no loop over stages or parts, and no check of a length, is left.
///
/// # Errors
/// [`StepFailure`]: sizes that do not fit, a state that is not finite.
#[expect(clippy::too_many_arguments, reason = "as `Discretized::advance_carrying`")]
#[inline(always)]
pub fn advance_explicit<H: Elements, S: Scalar, C: Carry<S>>(
    system: &H,
    scheme: &Scheme,
    t: f64,
    h: f64,
    q: &mut [S],
    p: &mut [S],
    dw: &[S],
    memory: &mut Memory<S>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    if !memory.fits(system, q.len()) {
        memory.fit(system, scheme, q.len())?;
    }
    let step = Step::new(system, scheme, t, h, q, p, dw)?;
    let mut lists = memory.work.lists(scheme, step.degrees());
    step.assign(&mut lists);
    if !C::CARRIES && scheme.update == MomentumUpdate::Multiple(1.0) {
        // `P` is the new momentum.
        let Lists { u, momentum, .. } = lists;
        if !(add(u, step.q) && are_finite(momentum)) {
            return Err(StepFailure::NonFinite);
        }
        q.copy_from_slice(u);
        p.copy_from_slice(momentum);
    } else {
        step.finish(&mut lists);
        lists.store(q, p, carry)?;
    }
    Ok(Effort::fast(0))
}

impl<H: Elements, S: Scalar> Step<'_, H, S> {
    /// `P` from the slopes that `D_1 L_d` has, all of them at `q_i`, then `u`.
    #[inline(always)]
    pub(super) fn assign(&self, lists: &mut Lists<'_, S>) {
        let Lists { u, momentum, stages, by_p, .. } = lists;
        let (_, by_q) = stages.at_mut(0);
        let zero = S::from_f64(0.0);
        by_q.fill(zero);
        u.fill(zero);
        for stage in self.scheme.stages {
            if stage.start != 0.0 {
                self.slopes(stage, self.q, self.p, Slopes::BY_COORDINATES, by_q, by_p);
            }
        }
        for (momentum, (&p, &force)) in momentum.iter_mut().zip(self.p.iter().zip(&*by_q)) {
            *momentum = p - force;
        }
        self.velocities(momentum, by_p, u);
    }
}
