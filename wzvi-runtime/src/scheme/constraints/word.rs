//! Words on the manifold: the executor of their parts.

use super::flows::ConstrainedFlows;
use super::manifold::NEAR;
use super::memory::{ConstraintScratch, StepRoom};
use super::{Constrained, ConstraintLayout};
use crate::algebra::scalar::{Mask, Scalar};
use crate::algebra::shape::Shape;
use crate::algebra::solve::Effort;
use crate::algebra::state_sum::StateSum;
use crate::error::{StepFailure, StepPromise};
use crate::scheme::plan::NoiseClass;
use crate::scheme::word::{ForceUse, Part, Substep, Word};

/// The O parts of a word.
pub(crate) trait Relaxes<S: Scalar, L: ConstraintLayout, H: Shape> {
    /// Whether it draws normals, which leave the tangent plane, and accounts for heat.
    const IS_WARM: bool;

    /// Moves the momenta of the scratch by the O part.
    ///
    /// # Errors
    /// [`StepFailure::Bath`]
    fn relax<C: StateSum<S>>(
        &mut self,
        part: &Substep,
        scratch: &mut ConstraintScratch<S, L, H>,
    ) -> Result<(), StepFailure>;
}

/// A step of a word.
pub(crate) struct ConstrainedStep<'a, F, S: Scalar> {
    pub(crate) system: &'a F,
    pub(crate) parameters: &'a [S::Constant],
    pub(crate) word: &'a Word,
    pub(crate) t: S::Constant,
    pub(crate) h: S::Constant,
    /// The increments of the noises.
    pub(crate) dw: &'a [S],
}

impl<F: Constrained, S: Scalar> ConstrainedStep<'_, F, S> {
    /// Takes the step; returns its effort and its heat. On `Err`, `q`, `p` and `carry` of the paths that
    /// failed are as they were.
    ///
    /// # Errors
    /// [`StepFailure::OffManifold`] for a state that is not there, [`StepFailure::NotConverged`] where no end
    /// of a drift was found, or the failure of an O part.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn take<C: StateSum<S>>(
        &self,
        [q, p]: [&mut [S]; 2],
        carry: &mut C,
        StepRoom { past, reached, scratch }: StepRoom<'_, S, F::Layout, F::Shape>,
        relaxation: &mut impl Relaxes<S, F::Layout, F::Shape>,
    ) -> Result<ConstrainedEnd<S>, StepFailure> {
        let &Self { system, parameters, word, t, h, dw } = self;
        let flows = ConstrainedFlows { system, parameters };
        let is_same = scratch.begin(q, p, carry) & std::mem::take(&mut reached.0);
        if !is_same {
            flows.weigh(scratch);
        }
        if F::READ_TIME || !is_same {
            flows.evaluate_here(scratch, t);
        }
        if !is_same {
            let distance = flows.distance(scratch);
            if !distance.less_equal(S::from_f64(NEAR)).all() {
                return Err(StepFailure::OffManifold { coordinates: distance.magnitude(), momenta: 0.0 });
            }
        }
        let may_reuse = is_same && dw.is_empty() && !F::FACTS.kind.reads_time;
        let uses_past = const { matches!(F::FACTS.noise, NoiseClass::None) } && !warm(relaxation);
        let mut end = ConstrainedEnd {
            taken: S::Mask::from_bool(true),
            iterations: 0,
            residual: S::from_f64(0.0),
            heat: S::from_f64(0.0),
        };
        let mut is_tangent = true;
        let mut past = past.iter_mut();
        for part in &word.substeps {
            let (node, time) = (t + h * part.node, h * part.weight);
            match part.part {
                Part::B => {
                    let may_reuse = may_reuse && part.force == ForceUse::FromStepBefore;
                    flows.kick::<C>(scratch, node, time, dw, part.weight, may_reuse);
                    is_tangent = false;
                }
                Part::A => {
                    let (Some(past), node) = (past.next(), t + h * (part.node + part.weight)) else {
                        return Err(StepFailure::Internal(StepPromise::ConstraintRoom));
                    };
                    let outcome = match uses_past {
                        true => flows.drift::<C, true>(scratch, past, node, time),
                        false => flows.drift::<C, false>(scratch, past, node, time),
                    };
                    end.residual = S::select(outcome.taken, end.residual, outcome.residual);
                    end.taken = end.taken & outcome.taken;
                    end.iterations += outcome.iterations;
                    is_tangent = false;
                    if !end.taken.any() {
                        break;
                    }
                }
                Part::O => {
                    if warm(relaxation) {
                        if !is_tangent {
                            end.taken = end.taken & flows.project::<C>(scratch);
                        }
                        let before = flows.kinetic_energy(scratch);
                        relaxation.relax::<C>(part, scratch)?;
                        end.taken = end.taken & flows.project::<C>(scratch);
                        end.heat = end.heat + (flows.kinetic_energy(scratch) - before);
                        is_tangent = true;
                    } else {
                        relaxation.relax::<C>(part, scratch)?;
                        is_tangent &= !F::READ_TIME;
                    }
                }
                Part::GradientB(_) | Part::AOA => {
                    return Err(StepFailure::Internal(StepPromise::ConstraintParts));
                }
            }
        }
        if !is_tangent {
            end.taken = end.taken & flows.project::<C>(scratch);
        }
        end.taken = scratch.arrive(end.taken, q, p, carry);
        reached.0 = end.taken.all();
        Ok(end)
    }
}

/// Whether O parts draw normals.
#[cfg_attr(not(debug_assertions), inline(always))]
const fn warm<S: Scalar, L: ConstraintLayout, H: Shape, R: Relaxes<S, L, H>>(_: &R) -> bool {
    R::IS_WARM
}

/// The end of a step.
pub(crate) struct ConstrainedEnd<S: Scalar> {
    /// The paths that have taken it.
    taken: S::Mask,
    iterations: u32,
    /// The largest constraint, relative to its terms, of a path that has not.
    residual: S,
    /// The energy that O parts gave.
    pub(crate) heat: S,
}

impl<S: Scalar> ConstrainedEnd<S> {
    /// The effort of a step that was taken.
    ///
    /// # Errors
    /// [`StepFailure::NotConverged`], for paths in lanes the set of those that failed.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn effort(&self) -> Result<Effort, StepFailure> {
        let &Self { taken, iterations, residual, .. } = self;
        if taken.all() {
            return Ok(Effort::fast(iterations));
        }
        if S::MAY_FAIL_BY_LANE {
            return Err(StepFailure::but_of::<S>(taken));
        }
        Err(StepFailure::NotConverged { iterations, correction: residual.magnitude() })
    }
}
