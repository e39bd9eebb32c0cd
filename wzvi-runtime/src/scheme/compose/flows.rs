//! Alternating drifts and kicks, for `T(p) + V(q, t)`.
//!
//! With `F = h H_0 + Σ_k ΔW_k H_k = T(p) + V(q, t)` a drift of weight `a` is `q ← q + a ∂T/∂p`, a kick of
//! weight `b` is `p ← p - b ∂V/∂q`: the flows of the parts, both exact. A kick acts at the time that the
//! drifts before it have reached, `t + (a_1 + ... + a_j) h`, since time is a coordinate that the drift moves.
//!
//! Adjacent flows of the same kind are merged (an adjoint pair `DeltaPlus(b)`, `DeltaMinus(a)` is kick,
//! drift, drift, kick), so that every kick evaluates the force once, at its own node. If a step ends with a
//! kick, the next one starts with the same force: it is kept with the node, and reused if node, step size
//! and, if the force reads it, time are the same to the last bit. Reuse changes no number, and checkpoints do
//! not contain the force.
//!
//! Flows evaluate the system by [`Field::step_gradient`]. The compiler proves the form of `F`.

use std::marker::PhantomData;

use super::gradient::KickInput;
use super::lagrangian::{self, SequenceEnd};
use super::lists::{
    ForceTime, KeptForce, ListParts, PartScratch, SplittingLists, SplittingMemory, SplittingRooms, add,
    follow, take_parts,
};
use super::plans::{kept_energy, plan};
use super::tiled::{TiledInput, least_scalar, takes_tiles};
use super::{ComposedWord, Composes};
use crate::algebra::lanes::Lanes;
use crate::algebra::scalar::{ComputesWith, Constant, ConstantsIn, Parameters as _, Scalar};
use crate::algebra::shape::Shape;
use crate::algebra::solve::Effort;
use crate::algebra::state::Vector;
use crate::algebra::state_sum::{self, PlainSum, StateSum};
use crate::error::{ConfigError, StepFailure, StepPromise};
use crate::scheme::elements::{
    Flow, PairColumns, Partials, add_gradient, check_new, nothing, takes_common_range,
};
use crate::scheme::gauss::{Field, gather};
use crate::scheme::plan::{KeptEnergy, Plan};
use crate::scheme::system::{
    Hamiltonian, LiftParameter, Movable, Properties, Scheme, Segment, StepArguments, as_they_are,
};
use crate::scheme::word::{ForceUse, Part, Substep, Word};

/// The drifts and kicks `W` in turn; `SQUARES` if kicks are by potentials with the square of the force.
#[derive(Clone, Copy, Debug)]
pub struct KickDrift<W, const SQUARES: bool = false>(PhantomData<W>);

impl<F, E, T, W, const SQUARES: bool> Scheme<F> for KickDrift<ComposedWord<E, T, W>, SQUARES>
where
    F: Field,
    W: Composes<E, T, Part = Part>,
{
    const PLAN: Plan = plan(F::FACTS.explicit(), W::ORDER);
    const PROPERTIES: Properties = Properties {
        kept_energy: match SQUARES {
            true => KeptEnergy::Nearly,
            false => kept_energy(KeptEnergy::KickDriftKick, W::ORDER),
        },
        scalar_paths_from: if SQUARES { usize::MAX } else { least_scalar::<F>() },
        ..Properties::of(&<Self as Scheme<F>>::PLAN, 0)
    };
    type Prepared<K: Constant> =
        KickDriftConstants<ConstantsIn<F::Parameters, K>, ConstantsIn<F::Parameters, K::Lifted>>;
    type Memory<S: Scalar> = SplittingMemory<S, F::Shape>;
    type Unclocked = Self;
    type CompensatedSum<S: Scalar> = state_sum::CompensatedSum<S, F::Shape>;
    type Sum<S: Scalar> = PlainSum;

    fn memory(system: &F) -> Self::Memory<f64> {
        let mut memory = SplittingMemory::of_system(system);
        if SQUARES {
            memory.scratch.directional.fit(system.degrees(), Hamiltonian::noises(system));
        }
        memory
    }

    fn prepare<K: Constant>(
        system: &F,
        lift: LiftParameter<'_, K>,
        _: K,
    ) -> Result<Self::Prepared<K>, ConfigError> {
        check_new(system)?;
        let along = SQUARES.then(|| system.parameters(&|number, value| lift(number, value).lifted()));
        Ok(KickDriftConstants { parameters: system.parameters(lift), along, word: W::word() })
    }

    /// The size of a step is no part of its data.
    fn resize<K: Constant>(
        _: &F,
        _: LiftParameter<'_, K>,
        _: &mut Self::Prepared<K>,
        _: K,
    ) -> Result<(), ConfigError> {
        Ok(())
    }

    fn gather<const L: usize>(prepared: [&Self::Prepared<f64>; L]) -> Option<Self::Prepared<Lanes<L>>> {
        if SQUARES {
            return None;
        }
        let parameters = gather::<F, L>(prepared.map(|prepared| &prepared.parameters))?;
        Some(KickDriftConstants { parameters, along: None, word: prepared.first()?.word.clone() })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        system: &F,
        KickDriftConstants { parameters, along, word }: &Self::Prepared<K>,
        StepArguments { t, h, q, p, dw }: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        if const { F::FACTS.has_tiles && S::MAY_BE_F64 && !SQUARES }
            && takes_tiles::<F>(q.list().len())
            && let (Some(own_q), Some(own_p), Some(dw)) =
                (S::as_f64s_mut(q.list()), S::as_f64s_mut(p.list()), S::as_f64s(dw))
        {
            let lost = carry.lists(own_q.len()).map(|lost| S::as_f64s(lost).unwrap_or_default());
            let givens =
                TiledInput { t: t.lane(0), h: h.lane(0), stretch: 1.0, q: own_q, p: own_p, lost, dw };
            let taken = match C::CARRIES {
                true => memory.tiles.take_parts_in_tiles::<F, false, true>(system, word, givens, None)?,
                false => memory.tiles.take_parts_in_tiles::<F, false, false>(system, word, givens, None)?,
            };
            taken.store(q, p, carry);
            return Ok(Effort::fast(0));
        }
        let mut flows =
            KickDriftFlows::<_, _, SQUARES> { system, parameters, along, t, h, stretch: K::from_f64(1.0) };
        take_parts(system, &mut flows, word, [q.list(), p.list()], dw, memory, carry)
    }

    fn discrete_lagrangian(system: &F, segment: &Segment<F::Vector>, dw: &[f64]) -> f64 {
        let parameters = &system.parameters(&as_they_are);
        let Segment { t, h, .. } = *segment;
        let along = &SQUARES.then(|| system.parameters(&as_they_are));
        let flows = KickDriftFlows::<_, _, SQUARES> { system, parameters, along, t, h, stretch: 1.0 };
        lagrangian::value(segment, dw, Hamiltonian::noises(system), || flows.follow(&W::word(), segment, dw))
    }
}

/// The parameters of a system, and the word of a step.
#[derive(Clone, Debug)]
pub struct KickDriftConstants<P, A> {
    parameters: P,
    /// The parameters for kicks with the square of the force, which take one more derivative.
    along: Option<A>,
    word: Word,
}

/// The flows in a step.
pub(crate) struct KickDriftFlows<'a, F: Field, K: Constant, const SQUARES: bool = false> {
    pub(crate) system: &'a F,
    pub(crate) parameters: &'a ConstantsIn<F::Parameters, K>,
    pub(crate) along: &'a Option<ConstantsIn<F::Parameters, K::Lifted>>,
    pub(crate) t: K,
    pub(crate) h: K,
    /// The ratio of the time of all flows to that in the word.
    pub(crate) stretch: K,
}

impl<F: Field, K: Constant, const SQUARES: bool> Clone for KickDriftFlows<'_, F, K, SQUARES> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<F: Field, K: Constant, const SQUARES: bool> Copy for KickDriftFlows<'_, F, K, SQUARES> {}

impl<F: Field, K: Constant, S: ComputesWith<K>, const SQUARES: bool> ListParts<S, F::Shape, Part>
    for KickDriftFlows<'_, F, K, SQUARES>
{
    const IS_PARTIAL: bool = !F::Shape::IS_FIXED && takes_common_range::<F, S>();

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take_part<C: StateSum<S>, const EXACT: bool>(
        &mut self,
        substep: &Substep,
        lists: &mut SplittingLists<'_, S, F::Shape>,
        kept: &mut KeptForce<S, F::Shape>,
        scratch: &mut PartScratch<S>,
    ) -> Result<(), StepFailure> {
        let SplittingLists { q, p, rooms } = lists;
        let (t, h) = (self.t + self.h * substep.node, self.h * (self.stretch * substep.share));
        match substep.part {
            Part::A => {
                let SplittingRooms { lost_q, velocity, .. } = &mut **rooms;
                self.drift::<S, C, EXACT>(h, q, p, &scratch.dw, velocity.as_mut(), lost_q.as_mut());
            }
            Part::GradientB(factor) if SQUARES => {
                let PartScratch { directional, dw, .. } = scratch;
                let (force, change) = (rooms.force.as_mut(), rooms.velocity.as_mut());
                directional.fit(q.len(), dw.len());
                KickInput { flows: self, substep, q, dw }.differentiate(directional, force, change)?;
                let factor = 2.0 * factor / Scalar::powi(substep.share, 3);
                for (force, change) in force.iter_mut().zip(change) {
                    *force = *force + *change * factor;
                }
                add::<S, C>(p, force, rooms.lost_p.as_mut());
            }
            Part::B | Part::GradientB(_) => {
                self.kick::<S, C, EXACT>(ForceTime { t, h }, substep.force, lists, kept, scratch);
            }
            Part::O | Part::AOA => return Err(StepFailure::Internal(StepPromise::Bath)),
        }
        Ok(())
    }
}

impl<F: Field, K: Constant, const SQUARES: bool> KickDriftFlows<'_, F, K, SQUARES> {
    /// Loops add to each place in turn, and need no separate list of derivatives.
    const IN_PLACE: bool = !F::Shape::IS_FIXED;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn drift<S: ComputesWith<K>, C: StateSum<S>, const EXACT: bool>(
        &self,
        h: K,
        q: &mut [S],
        p: &[S],
        dw: &[S],
        velocity: &mut [S],
        lost: &mut [S],
    ) {
        let &Self { system, parameters, t, .. } = self;
        // No pairs add to the velocities.
        let columns = &mut PairColumns::default();
        if Self::IN_PLACE {
            let flow = self.flow(ForceTime { t, h }, dw);
            if !C::CARRIES {
                return add_gradient::<F, S, EXACT>(system, flow, p, Partials::BY_MOMENTA, q, columns);
            }
            velocity.fill(nothing());
            add_gradient::<F, S, EXACT>(system, flow, p, Partials::BY_MOMENTA, velocity, columns);
            return add::<S, C>(q, velocity, lost);
        }
        let [t, h] = [t, h].map(S::constant);
        let (at, into) = (([t, h], [&*q, p], dw), [&mut [][..], &mut *velocity]);
        system.step_gradient::<K, S, false, true>(parameters, at, into, columns);
        add::<S, C>(q, velocity, lost);
    }

    /// `p ← p + ∂F/∂q`, in loops.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_force<S: ComputesWith<K>, const EXACT: bool>(
        &self,
        origin: ForceTime<K>,
        q: &[S],
        dw: &[S],
        p: &mut [S],
        columns: &mut PairColumns,
    ) {
        add_gradient::<F, S, EXACT>(
            self.system,
            self.flow(origin, dw),
            q,
            Partials::BY_COORDINATES,
            p,
            columns,
        );
    }

    /// For elements, of which all lanes have the same constants.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn flow<'s, S: ComputesWith<K>>(&'s self, ForceTime { t, h }: ForceTime<K>, dw: &'s [S]) -> Flow<'s, S> {
        let [t, h] = [t, h].map(|constant| S::constant(constant).to_constant());
        Flow { t, h, parameters: S::varied(F::Parameters::varied(self.parameters)), dw }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn kick<S: ComputesWith<K>, C: StateSum<S>, const EXACT: bool>(
        &self,
        origin: ForceTime<K>,
        force_use: ForceUse,
        SplittingLists { q, p, rooms }: &mut SplittingLists<'_, S, F::Shape>,
        kept: &mut KeptForce<S, F::Shape>,
        PartScratch { dw, columns, .. }: &mut PartScratch<S>,
    ) {
        let &Self { system, parameters, .. } = self;
        let ForceTime { t, h } = origin;
        if Self::IN_PLACE && !C::CARRIES && !force_use.is_at_end() {
            return self.add_force::<S, EXACT>(origin, q, dw, p, columns);
        }
        let SplittingRooms { force, lost_p, .. } = &mut **rooms;
        let force_use = if dw.is_empty() { force_use } else { ForceUse::Once };
        if force_use == ForceUse::FromStepBefore
            && let Some(force) = kept.for_kick(origin, F::FORCE_READS_TIME)
        {
            return add::<S, C>(p, force, lost_p.as_mut());
        }
        if Self::IN_PLACE {
            force.as_mut().fill(nothing());
            self.add_force::<S, EXACT>(origin, q, dw, force.as_mut(), columns);
        } else {
            let [t, h] = [t, h].map(S::constant);
            let (at, into) = (([t, h], [&**q, &**p], &dw[..]), [force.as_mut(), &mut []]);
            system.step_gradient::<K, S, true, false>(parameters, at, into, columns);
        }
        add::<S, C>(p, force.as_ref(), lost_p.as_mut());
        if force_use == ForceUse::ForNextStep {
            kept.keep(origin, force);
        }
    }
}

impl<F: Field, const SQUARES: bool> KickDriftFlows<'_, F, f64, SQUARES> {
    /// The end of the parts and their discrete Lagrangian. A drift has `p · Δq - a T(p)`, a kick at `q` has
    /// `-b V(q) + c |V'(q)|²`. The weights of each kind sum to 1, so that `T = F(q_0, ·) - V(q_0)` and
    /// `V = F(·, p_0) - T(p_0)` sum to values of `F`, less `F(q_0, p_0)`.
    fn follow(
        mut self,
        word: &Word,
        segment: &Segment<F::Vector>,
        dw: &[f64],
    ) -> Option<SequenceEnd<F::Vector>> {
        let Self { system, t, h, .. } = self;
        let (q0, p0) = (segment.q0.components(), segment.p.components());
        Hamiltonian::check(system, q0.len()).ok()?;
        let value = |q: &[f64], p: &[f64], t: f64| {
            let noises = dw.iter().zip(1..).map(|(dw, term)| dw * system.evaluate(term, q, p, t));
            h * system.evaluate(0, q, p, t) + noises.sum::<f64>()
        };
        let flows = self;
        let mut followed =
            follow(&mut self, word, segment, dw, |substep, [before, _], [q, p]| match substep.part {
                Part::A => {
                    let moved: f64 =
                        p.iter().zip(q.iter().zip(before)).map(|(p, (q, before))| p * (q - before)).sum();
                    moved - substep.weight * value(q0, p, t)
                }
                _ => flows.of_square(substep, q, dw) - substep.weight * value(q, p0, t + substep.node * h),
            })?;
        followed.action += value(q0, p0, t);
        Some(followed)
    }
}
