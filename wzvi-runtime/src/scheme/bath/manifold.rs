//! A bath on the manifold of constraints: [`GBaoab`].
//!
//! ```text
//! kick of h/2, drift of h/2, O, drift of h/2, kick of h/2,    O:  p <- Π (c p + √(kT (1 - c²)) M^{1/2} ξ)
//! ```
//!
//! with `Π = 1 - Gᵀ (G W Gᵀ)⁻¹ G W`, `W = M⁻¹`, after each part; a drift ends on the manifold by the impulse
//! of [RATTLE](crate::scheme::constraints). For one rate of friction O is exact: it keeps the law of momenta
//! that are tangent, with covariance `kT Π M`. The law of the motion is `e^{-H/kT}` on the manifold, in the
//! measure of the constrained motion and not in that of stiff springs (B. Leimkuhler, C. Matthews, "Efficient
//! molecular dynamics using geodesic integration and solvent-solute splitting", Proc. R. Soc. A 472, 2016).

use super::letters::{A, B, Letter, Letters, O};
use super::modes::Decay;
use super::part::{self, BathLaw, BathMemory, OPartShares, OParts};
use super::{GBaoab, with_bath};
use crate::algebra::memory::step_memory;
use crate::algebra::scalar::{ComputesWith, Constant, Scalar};
use crate::algebra::shape::Shape;
use crate::algebra::solve::Effort;
use crate::algebra::state_sum::{self, PlainSum, StateSum};
use crate::error::{ConfigError, StepFailure};
use crate::scheme::constraints::{
    Constrained, ConstrainedStep, ConstraintLayout, ConstraintMemory, ConstraintScratch, Relaxes,
    constrained_plan,
};
use crate::scheme::elements::{Elements, check_new};
use crate::scheme::plan::{KeptEnergy, Plan};
use crate::scheme::system::{
    Exchange, Hamiltonian as _, LiftParameter, Movable, Properties, Scheme, StepArguments, fits,
    varied_without_lists,
};
use crate::scheme::word::{Substep, Word};

const LETTERS: &[Letter] = <(B, A, O, A, B)>::LETTERS;
const SHARES: OPartShares = OPartShares { parts: 1, decay: Decay::Exponential, is_shortened: false };

/// The constants of steps.
#[derive(Clone, Debug)]
pub struct ManifoldBathConstants<K> {
    parameters: Vec<K>,
    word: Word,
    relaxation: BathLaw<K>,
}

/// The memory of steps.
#[derive(Debug)]
pub struct ManifoldBathMemory<S: Scalar, L: ConstraintLayout, H: Shape> {
    bath: BathMemory<S>,
    constraints: ConstraintMemory<S, L, H>,
}

impl<S: Scalar, L: ConstraintLayout, H: Shape> Default for ManifoldBathMemory<S, L, H> {
    fn default() -> Self {
        Self { bath: BathMemory::default(), constraints: ConstraintMemory::default() }
    }
}

step_memory! {
    impl[S: Scalar, L: ConstraintLayout, H: Shape] StepMemory for ManifoldBathMemory<S, L, H> {
        kept: bath, constraints
    }
}

impl<F: Constrained> Scheme<F> for GBaoab {
    const PLAN: Plan = with_bath(constrained_plan::<F>());
    const PROPERTIES: Properties = Properties {
        kept_energy: KeptEnergy::Nearly,
        exchanges: true,
        is_variational: false,
        ..Properties::of(&<Self as Scheme<F>>::PLAN, 0)
    };
    type Prepared<K: Constant> = ManifoldBathConstants<K>;
    type Memory<S: Scalar> = ManifoldBathMemory<S, F::Layout, F::Shape>;
    type Unclocked = Self;
    type CompensatedSum<S: Scalar> = state_sum::CompensatedSum<S, F::Shape>;
    type Sum<S: Scalar> = PlainSum;

    fn increments(system: &F, degrees: usize) -> usize {
        system.noises() + part::normals::<F>(degrees, SHARES.parts)
    }

    fn exchanged(_: &F, memory: &Self::Memory<f64>) -> Exchange {
        Exchange { work: 0.0, heat: memory.bath.heat }
    }

    fn temperature(system: &F) -> Option<f64> {
        part::temperature(system)
    }

    fn memory(system: &F) -> Self::Memory<f64> {
        ManifoldBathMemory { bath: BathMemory::of_system(system), constraints: ConstraintMemory::default() }
    }

    fn prepare<K: Constant>(
        system: &F,
        lift: LiftParameter<'_, K>,
        h: K,
    ) -> Result<Self::Prepared<K>, ConfigError> {
        check_new(system)?;
        let relaxation = part::prepare(system, lift, h, SHARES)?;
        let parameters = varied_without_lists(system, lift)?;
        Ok(ManifoldBathConstants { parameters, word: Word::spelled(LETTERS), relaxation })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        system: &F,
        ManifoldBathConstants { parameters, word, relaxation }: &Self::Prepared<K>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        ManifoldBathMemory { bath, constraints }: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let StepArguments { t, h, q, p, dw } = at.lists();
        let (degrees, noises) = (q.len(), system.noises());
        if !fits(system, degrees) {
            system.check(degrees)?;
        }
        if p.len() != degrees {
            return Err(StepFailure::Dimension { expected: degrees, got: p.len() });
        }
        let parts = bath.parts(system, relaxation, ([t, h], SHARES, degrees), (dw, noises))?;
        let room = constraints.room(system, degrees, word.drifts(), noises);
        let [t, h] = [t, h].map(|constant| S::constant(constant).to_constant());
        let step =
            ConstrainedStep { system, parameters: S::varied(parameters), word, t, h, dw: &dw[..noises] };
        let end = step.take([q, p], carry, room, &mut TangentBath { parts })?;
        bath.heat = end.heat;
        end.effort()
    }
}

/// The O part of a step, before its projection.
struct TangentBath<'m, F: Elements, K: Constant, S> {
    parts: OParts<'m, F, K, S>,
}

impl<F, K, S, L, H> Relaxes<S, L, H> for TangentBath<'_, F, K, S>
where
    F: Elements,
    K: Constant,
    S: ComputesWith<K>,
    L: ConstraintLayout,
    H: Shape,
{
    const IS_WARM: bool = true;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn relax<C: StateSum<S>>(
        &mut self,
        part: &Substep,
        scratch: &mut ConstraintScratch<S, L, H>,
    ) -> Result<(), StepFailure> {
        let momenta = scratch.momenta();
        self.parts.apply::<C>(part.number, None, momenta).map(|_| ())
    }
}
