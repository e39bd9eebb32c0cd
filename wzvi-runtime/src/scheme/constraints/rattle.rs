//! Steps of [`Rattle`] and its compositions, for `p · W p / 2 + V(q, t)` with a diagonal matrix `W`.

use std::marker::PhantomData;

use super::Constrained;
use super::ConstraintLayout;
use super::memory::{ConstraintMemory, ConstraintScratch};
use super::word::{ConstrainedStep, Relaxes};
use crate::algebra::scalar::{ComputesWith, Constant, Scalar};
use crate::algebra::shape::Shape;
use crate::algebra::solve::Effort;
use crate::algebra::state_sum::{self, StateSum};
use crate::error::{ConfigError, StepFailure};
use crate::scheme::compose::{
    BasicMethod, ComposedWord, Composes, General, Listing, Nystrom, PairComposition, Symmetric, WHOLE, plan,
};
use crate::scheme::elements::{Elements, check_new};
use crate::scheme::plan::{KeptEnergy, Plan, Solver};
use crate::scheme::system::{
    LiftParameter, Movable, Properties, Scheme, StepArguments, check_lengths, varied_without_lists,
};
use crate::scheme::word::{Part, Substep, Weighted, Word};

/// RATTLE: [`Verlet`](crate::scheme::compose::Verlet) on the manifold of [constraints](super), symmetric,
/// symplectic, and of order two (H. C. Andersen, J. Comput. Phys. 52, 1983; B. J. Leimkuhler, R. D. Skeel, J.
/// Comput. Phys. 112, 1994). The constraints and their derivatives by the time hold at every node to a
/// rounding of their terms. [`Composed`](crate::scheme::compose::Composed) has higher orders (S. Reich, SIAM
/// J. Numer. Anal. 33, 1996). Friction with one rate for all degrees of freedom acts for half of a step
/// before it and for the other half after it.
///
/// A step fails with [`StepFailure::BeyondCurvature`] where its tangent leaves the manifold farther than it
/// curves, with [`StepFailure::OffManifold`] from a state that is not on the manifold, and with
/// [`StepFailure::Dependent`] where a constraint follows from others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rattle;

const fn part(part: Part, weight: f64) -> Weighted {
    Weighted { part, weight }
}

/// A step without friction.
const STEP: &[Weighted] = &[part(Part::B, 0.5), part(Part::A, 1.0), part(Part::B, 0.5)];
/// A step with friction.
const WITH_FRICTION: &[Weighted] =
    &[part(Part::O, 0.5), part(Part::B, 0.5), part(Part::A, 1.0), part(Part::B, 0.5), part(Part::O, 0.5)];

/// Any Hamiltonian.
impl Symmetric<General> for Rattle {
    type Basic = Self;
    type Adjoint = Self;
    type Part = BasicMethod;
    type Steps<W> = PairComposition<Self, Self, W>;
    const STEP: &'static [Weighted<BasicMethod>] = WHOLE;
}

/// `p · W p / 2 + V(q, t)` with a diagonal matrix `W`.
impl Symmetric<Nystrom> for Rattle {
    type Basic = Self;
    type Adjoint = Self;
    type Part = Part;
    type Steps<W> = RattleSteps<W>;
    const STEP: &'static [Weighted] = STEP;
}

/// The word `W` on the manifold.
#[derive(Clone, Copy, Debug)]
pub struct RattleSteps<W>(PhantomData<W>);

/// The word of a step, and what it reads.
#[derive(Clone, Debug)]
pub struct RattleConstants<K> {
    parameters: Vec<K>,
    word: Word,
    /// The number of its drifts.
    drifts: usize,
    /// The factor of the momenta by friction in each O part.
    decays: Vec<K>,
}

/// The plan of steps that solve for the multipliers.
pub(crate) const fn constrained_plan<F: Constrained>() -> Plan {
    let unknowns = if F::Shape::IS_FIXED { F::CONSTRAINTS } else { usize::MAX };
    F::FACTS.plan(Solver::Newton, unknowns, 2, true)
}

impl<F, E, T, W> Scheme<F> for RattleSteps<ComposedWord<E, T, W>>
where
    F: Constrained,
    W: Composes<E, T, Part = Part>,
{
    const PLAN: Plan = plan(constrained_plan::<F>(), W::ORDER);
    const PROPERTIES: Properties = Properties {
        kept_energy: KeptEnergy::Nearly,
        ..Properties::of(&<Self as Scheme<F>>::PLAN, size_of::<Self::Memory<f64>>())
    };
    type Prepared<K: Constant> = RattleConstants<K>;
    type Memory<S: Scalar> = ConstraintMemory<S, F::Layout, F::Shape>;
    type Unclocked = Self;
    type CompensatedSum<S: Scalar> = state_sum::CompensatedSum<S, F::Shape>;
    type Sum<S: Scalar> = state_sum::CompensatedSum<S, F::Shape>;

    fn prepare<K: Constant>(
        system: &F,
        lift: LiftParameter<'_, K>,
        h: K,
    ) -> Result<Self::Prepared<K>, ConfigError> {
        check_new(system)?;
        let parameters = varied_without_lists(system, lift)?;
        let word = match W::LISTING {
            Listing::Steps(weights) if F::FACTS.kind.is_conformal => Word::composed(WITH_FRICTION, weights),
            _ => W::word(),
        };
        let decay =
            |part: &Substep| (-(Elements::friction_rate(system, &parameters) * h * part.weight)).exp();
        let decays = word.substeps.iter().filter(|part| part.part == Part::O).map(decay).collect();
        Ok(RattleConstants { parameters, drifts: word.drifts(), word, decays })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        system: &F,
        prepared: &Self::Prepared<K>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let RattleConstants { parameters, word, drifts, decays } = prepared;
        let StepArguments { t, h, q, p, dw } = at.lists().shared();
        let is_ready = memory.fits(q.len(), *drifts, dw.len());
        check_lengths(system, is_ready, [q.len(), p.len(), dw.len()])?;
        let room = memory.room(system, q.len(), *drifts, dw.len());
        let step = ConstrainedStep { system, parameters: S::varied(parameters), word, t, h, dw };
        step.take([q, p], carry, room, &mut OneRate { decays })?.effort()
    }
}

/// Friction with one rate.
struct OneRate<'a, K> {
    /// The factor of the momenta in each O part.
    decays: &'a [K],
}

impl<K: Constant, S: ComputesWith<K>, L: ConstraintLayout, H: Shape> Relaxes<S, L, H> for OneRate<'_, K> {
    const IS_WARM: bool = false;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn relax<C: StateSum<S>>(
        &mut self,
        part: &Substep,
        scratch: &mut ConstraintScratch<S, L, H>,
    ) -> Result<(), StepFailure> {
        let decay = S::constant(self.decays[part.number]);
        let ConstraintScratch { p, lost_p, .. } = scratch;
        for (p, lost) in p.as_mut().iter_mut().zip(lost_p.as_mut()) {
            let change = *p * decay - *p;
            (*p, *lost) = C::add(*p, change, *lost * decay);
        }
        Ok(())
    }
}
