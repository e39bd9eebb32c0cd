//! The word of a scheme with one quadrature point at a node.

use super::{LEAST_IN_TILES, NewState, TileParts, TilePlan, advance};
use crate::algebra::scalar::Number;
use crate::error::StepFailure;
use crate::scheme::elements::step::LoopStep;
use crate::scheme::elements::{
    ElementInput, Elements, MomentumUpdate, Partials, Quadrature, QuadraturePoint, Sums, Unknowns,
};
use crate::scheme::word::{Part, Substep};

/// Whether steps of a system of this size go tile by tile.
///
/// The caller checks [`Facts::has_tiles`](crate::scheme::plan::Facts::has_tiles) first, so that nothing
/// is compiled for other systems.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(in crate::scheme::elements) fn takes_tiles(scheme: &Quadrature, degrees: usize) -> bool {
    let is_explicit = scheme.unknowns == Unknowns::None && scheme.takes_roles_once();
    degrees >= LEAST_IN_TILES && is_explicit && (kicks_first(scheme) || kicks_last(scheme))
}

/// `DeltaPlus`: the new momentum is `P`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn kicks_first(scheme: &Quadrature) -> bool {
    scheme.update == MomentumUpdate::Multiple(1.0)
}

/// `DeltaMinus`: `P` is the old momentum.
#[cfg_attr(not(debug_assertions), inline(always))]
fn kicks_last(scheme: &Quadrature) -> bool {
    let is_last = |stage: &QuadraturePoint| stage.start == 0.0 && (stage.end == 1.0 && stage.point == 1.0);
    scheme.update == MomentumUpdate::Slopes && scheme.stages.iter().all(is_last)
}

/// `DeltaPlus`.
const KICK_DRIFT: [Substep; 2] = [Substep::new(Part::B, 1.0, 0.0, 0), Substep::new(Part::A, 1.0, 0.0, 0)];

/// `DeltaMinus`. Its first kick is by the weight that its quadrature points have in `D_1 L_d`, which is zero.
const NOTHING_DRIFT_KICK: [Substep; 3] = [
    Substep::new(Part::B, 0.0, 0.0, 0),
    Substep::new(Part::A, 1.0, 0.0, 0),
    Substep::new(Part::B, 1.0, 1.0, 1),
];

impl<H: Elements + Sync> LoopStep<'_, H, f64> {
    /// The step, tile by tile.
    ///
    /// # Errors
    /// [`StepFailure::NonFinite`] if the new state is not finite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::scheme::elements) fn advance_in_tiles<'p>(
        self,
        plan: &'p mut TilePlan,
    ) -> Result<NewState<'p>, StepFailure> {
        advance(self.system, self, [self.q, self.p], plan)
    }

    /// Takes the step with compensated sums, after steps that lost so much of coordinates and momenta. The
    /// velocities are those of the new momenta.
    ///
    /// # Errors
    /// The errors of [`LoopStep::advance_in_tiles`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::scheme::elements) fn advance_compensated<'p>(
        self,
        lost: [&[f64]; 2],
        plan: &'p mut TilePlan,
    ) -> Result<NewState<'p>, StepFailure> {
        advance(self.system, CompensatedWord { step: self, lost }, [self.q, self.p], plan)
    }
}

/// A step with compensated sums.
struct CompensatedWord<'s, H: Elements> {
    step: LoopStep<'s, H, f64>,
    lost: [&'s [f64]; 2],
}

impl<H: Elements> Clone for CompensatedWord<'_, H> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<H: Elements> Copy for CompensatedWord<'_, H> {}

impl<H: Elements + Sync> TileParts for CompensatedWord<'_, H> {
    const ADDS_TERMS: bool = false;
    const CARRIES: bool = true;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn substeps(&self) -> &[Substep] {
        self.step.substeps()
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lost(&self) -> [&[f64]; 2] {
        self.lost
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_gradient<G, T, V, A>(&self, system: &G, flow: &Substep, state: &V, wanted: Partials, into: &mut A)
    where
        G: Elements + Sync,
        T: Number<f64>,
        V: ElementInput<f64> + ?Sized,
        A: Sums<f64>,
    {
        self.step.add_gradient::<G, T, V, A>(system, flow, state, wanted, into);
    }
}

impl<H: Elements + Sync> TileParts for LoopStep<'_, H, f64> {
    const ADDS_TERMS: bool = false;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn substeps(&self) -> &[Substep] {
        if kicks_first(self.scheme) { &KICK_DRIFT } else { &NOTHING_DRIFT_KICK }
    }

    /// Uses the system of the step, not the argument.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_gradient<G, T, V, A>(&self, _: &G, flow: &Substep, state: &V, wanted: Partials, into: &mut A)
    where
        G: Elements + Sync,
        T: Number<f64>,
        V: ElementInput<f64> + ?Sized,
        A: Sums<f64>,
    {
        let weight_of = |stage: &QuadraturePoint| match flow {
            Substep { part: Part::A, .. } => 1.0,
            Substep { number: 0, .. } => stage.start,
            _ => stage.end,
        };
        self.gradient_of::<T, V, A>(weight_of, state, wanted, into);
    }
}
