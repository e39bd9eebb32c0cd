//! Drifts and kicks in turn: for `T(p) + V(q, t)`.
//!
//! With `F = h H_0 + Σ_k ΔW_k H_k = T(p) + V(q, t)` a drift of weight `a` is `q ← q + a ∂T/∂p`, a kick of weight `b` is
//! `p ← p - b ∂V/∂q`: the flows of the parts, both exact. A kick acts at the time that the drifts before it have reached,
//! `t + (a_1 + ... + a_j) h`, since time is a coordinate that the drift moves.
//!
//! What stands beside its like is one (an adjoint pair `DeltaPlus(b)`, `DeltaMinus(a)` is kick, drift, drift, kick), so that
//! every kick evaluates the force at a node of its own, once. Where a step ends with a kick the next one starts with the same force: it is
//! kept with the node, and taken if node, step size, and the time if the force reads it, are the same to the last bit. Reuse is not to be
//! seen in the numbers, and checkpoints need not know of it.
//!
//! What a flow reads of the system is [`Field::step_slopes`]. Another kind of part (a kick by a modified potential, say) is a variant
//! of [`Half`], an arm of `take` and a method of [`Flows`].

use std::marker::PhantomData;

use super::lagrangian::{self, Followed};
use super::stages::{Fits, Memory, Origin, Rooms, Stage, Stages, Take, add, advance, check, follow};
use super::substeps::{Half, Substeps, kept_energy, plan};
use super::windowed::{Givens, least_alone, takes_windows};
use crate::algebra::carry::{Carry, Plain};
use crate::algebra::lanes::Lanes;
use crate::algebra::scalar::Scalar;
use crate::algebra::solve::Effort;
use crate::algebra::state::Vector;
use crate::error::{ConfigError, StepFailure};
use crate::scheme::elements::{self, Flow, Taken, WindowPlan, Word, add_slopes, nothing};
use crate::scheme::gauss::{Field, Shape};
use crate::scheme::plan::{KeptEnergy, Plan};
use crate::scheme::system::{At, Hamiltonian, Properties, Scheme, Segment};

/// A system with `F = T(p) + V(q, t)`; generated.
pub trait Flows: Field {
    /// Whether `V` reads the time.
    const FORCE_READS_TIME: bool;
    /// Whether steps of large systems go window by window.
    const IN_WINDOWS: bool = false;

    /// All parts of a step, window by window, where they [go so](Flows::IN_WINDOWS).
    ///
    /// # Errors
    /// [`StepFailure::NonFinite`] if the new state is not finite.
    fn take_windows<'p, W: Word>(
        &self,
        word: &mut W,
        q: &[f64],
        p: &[f64],
        plan: &'p mut WindowPlan,
    ) -> Option<Result<Taken<'p>, StepFailure>> {
        let _ = (word, q, p, plan);
        None
    }
}

/// What the flows of a step need to know in numbers `S`: of a system, or of several beside each other.
pub(crate) trait Slopes<S: Scalar> {
    /// As [`Field::Shape`].
    type Shape: Shape;
    /// As [`Flows::FORCE_READS_TIME`].
    const FORCE_READS_TIME: bool;
    /// Whether [`Slopes::add_force`] and [`Slopes::add_velocity`] add without room of their own.
    const IN_PLACE: bool;

    /// As [`Field::step_slopes`].
    #[expect(clippy::too_many_arguments, reason = "as there")]
    fn slopes<const BY_Q: bool, const BY_P: bool>(
        &self,
        t: f64,
        h: f64,
        q: &[S],
        p: &[S],
        dw: &[S],
        by_q: &mut [S],
        by_p: &mut [S],
    );

    /// `p ← p + ∂F/∂q`, only where it is [`Slopes::IN_PLACE`].
    fn add_force(&self, t: f64, h: f64, q: &[S], dw: &[S], p: &mut [S]) {
        let _ = (t, h, q, dw, p);
    }

    /// `q ← q + ∂F/∂p`, likewise.
    fn add_velocity(&self, t: f64, h: f64, p: &[S], dw: &[S], q: &mut [S]) {
        let _ = (t, h, p, dw, q);
    }
}

impl<F: Flows, S: Scalar> Slopes<S> for F {
    type Shape = <F as Field>::Shape;
    const FORCE_READS_TIME: bool = <F as Flows>::FORCE_READS_TIME;
    // Loops add to each place in turn.
    const IN_PLACE: bool = !<<F as Field>::Shape as Shape>::IS_FIXED;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn slopes<const BY_Q: bool, const BY_P: bool>(
        &self,
        t: f64,
        h: f64,
        q: &[S],
        p: &[S],
        dw: &[S],
        by_q: &mut [S],
        by_p: &mut [S],
    ) {
        Field::step_slopes::<S, BY_Q, BY_P>(self, S::from_f64(t), S::from_f64(h), q, p, dw, by_q, by_p);
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_force(&self, t: f64, h: f64, q: &[S], dw: &[S], p: &mut [S]) {
        add_slopes(self, Flow { t, h, dw }, q, elements::Slopes::BY_COORDINATES, p);
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_velocity(&self, t: f64, h: f64, p: &[S], dw: &[S], q: &mut [S]) {
        add_slopes(self, Flow { t, h, dw }, p, elements::Slopes::BY_MOMENTA, q);
    }
}

/// The flows of `L` systems beside each other.
#[derive(Debug)]
pub struct FlowsBeside<F: Field, const L: usize> {
    stages: Stages,
    parameters: F::Parameters<Lanes<L>>,
    degrees: usize,
    noises: usize,
}

impl<F: Flows, const L: usize> FlowsBeside<F, L> {
    /// Of systems that go so, with stages that are the same for all.
    pub(crate) fn new(systems: [&F; L], stages: &Stages) -> Option<Self> {
        let first = *systems.first()?;
        let (degrees, noises) = (first.degrees(), Hamiltonian::noises(first));
        let parameters = F::parameters_beside(systems)?;
        Some(Self { stages: stages.clone(), parameters, degrees, noises })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn stages(&self) -> &Stages {
        &self.stages
    }
}

impl<F: Flows, const L: usize> Slopes<Lanes<L>> for FlowsBeside<F, L> {
    type Shape = <F as Field>::Shape;
    const FORCE_READS_TIME: bool = <F as Flows>::FORCE_READS_TIME;
    const IN_PLACE: bool = false;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn slopes<const BY_Q: bool, const BY_P: bool>(
        &self,
        t: f64,
        h: f64,
        q: &[Lanes<L>],
        p: &[Lanes<L>],
        dw: &[Lanes<L>],
        by_q: &mut [Lanes<L>],
        by_p: &mut [Lanes<L>],
    ) {
        let [t, h] = [t, h].map(Lanes::from_f64);
        F::slopes_over::<Lanes<L>, Lanes<L>, BY_Q, BY_P>(&self.parameters, t, h, q, p, dw, by_q, by_p);
    }
}

impl<F: Field, const L: usize> Fits for FlowsBeside<F, L> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn fits(&self, degrees: usize) -> bool {
        degrees == self.degrees
    }
    fn check(&self, degrees: usize) -> Result<(), StepFailure> {
        let (expected, got) = (self.degrees, degrees);
        if got == expected { Ok(()) } else { Err(StepFailure::Dimension { expected, got }) }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn noises(&self) -> usize {
        self.noises
    }
}

/// The drifts and kicks `W` in turn.
#[derive(Clone, Copy, Debug)]
pub struct KickDrift<W>(PhantomData<W>);

impl<F: Flows, W: Substeps> Scheme<F> for KickDrift<W> {
    const PLAN: Plan = plan(F::FACTS.explicit(), W::ORDER);
    const PROPERTIES: Properties = Properties {
        kept_energy: kept_energy(KeptEnergy::KickDriftKick, W::ORDER),
        fills_registers_from: least_alone::<F>(),
        ..Properties::of(&<Self as Scheme<F>>::PLAN, 0)
    };
    type Prepared = Stages;
    type Memory<S: Scalar> = Memory<S, F::Shape>;
    type Compensated<S: Scalar> = <F::Shape as Shape>::Compensation<S>;
    type Carry<S: Scalar> = Plain;

    fn memory(system: &F) -> Self::Memory<f64> {
        Memory::of_system(system)
    }

    fn prepare(system: &F, _: f64) -> Result<Stages, ConfigError> {
        check(system).map(|()| Stages::of(&W::list()))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<S: Scalar, C: Carry<S>, const CAREFUL: bool>(
        system: &F,
        prepared: &Stages,
        At { t, h, q, p, dw }: At<'_, S>,
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        if const { F::IN_WINDOWS && S::MAY_BE_PLAIN && !C::CARRIES }
            && takes_windows::<F>(q.len())
            && let (Some(q), Some(p), Some(dw)) = (S::plain_mut(q), S::plain_mut(p), S::plain(dw))
        {
            let givens = Givens { t, h, q, p, dw };
            let (taken, _) = memory.windows.advance(system, &prepared.0, givens, |flows| flows)?;
            taken.copy(q, p);
            return Ok(Effort::fast(0));
        }
        let mut flows = FlowsOf { system, t, h, count: prepared.0.len() };
        advance(system, &mut flows, &prepared.0, At { t, h, q, p, dw }, memory, carry)
    }

    type Beside<const L: usize> = FlowsBeside<F, L>;

    fn beside<const L: usize>(systems: [&F; L], prepared: [&Stages; L]) -> Option<FlowsBeside<F, L>> {
        FlowsBeside::new(systems, prepared.first()?)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance_beside<const L: usize>(
        beside: &FlowsBeside<F, L>,
        At { t, h, q, p, dw }: At<'_, Lanes<L>>,
        memory: &mut Self::Memory<Lanes<L>>,
    ) -> Result<Effort, StepFailure> {
        let Stages(stages) = &beside.stages;
        let mut flows = FlowsOf { system: beside, t, h, count: stages.len() };
        advance(beside, &mut flows, stages, At { t, h, q, p, dw }, memory, &mut Plain)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance_vectors<C: Carry<f64>, const CAREFUL: bool>(
        system: &F,
        prepared: &Stages,
        [t, h]: [f64; 2],
        [q, p]: [&mut F::Vector; 2],
        dw: &[f64],
        memory: &mut Self::Memory<f64>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        if takes_windows::<F>(q.components().len()) && !C::CARRIES {
            let givens = Givens { t, h, q: q.components(), p: p.components(), dw };
            let (taken, _) = memory.windows.advance(system, &prepared.0, givens, |flows| flows)?;
            taken.exchange(q, p);
            return Ok(Effort::fast(0));
        }
        let at = At { t, h, q: q.components_mut(), p: p.components_mut(), dw };
        Self::advance::<f64, C, CAREFUL>(system, prepared, at, memory, carry)
    }

    fn discrete_lagrangian(system: &F, segment: &Segment<F::Vector>, dw: &[f64]) -> f64 {
        let Stages(stages) = Stages::of(&W::list());
        let flows = FlowsOf { system, t: segment.t, h: segment.h, count: stages.len() };
        lagrangian::value(segment, dw, Hamiltonian::noises(system), || {
            flows.follow(&mut flows.clone(), &stages, segment, dw, |_, _, _| 0.0)
        })
    }
}

/// The flows in a step.
pub(crate) struct FlowsOf<'a, F> {
    pub(crate) system: &'a F,
    pub(crate) t: f64,
    pub(crate) h: f64,
    /// How many parts there are.
    pub(crate) count: usize,
}

impl<F> Clone for FlowsOf<'_, F> {
    fn clone(&self) -> Self {
        Self { ..*self }
    }
}

impl<F: Slopes<S>, S: Scalar> Take<S, F::Shape> for FlowsOf<'_, F> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take<C: Carry<S>>(
        &mut self,
        index: usize,
        stage: &Stage,
        rooms: &mut Rooms<S, F::Shape>,
        memory: &mut Memory<S, F::Shape>,
    ) -> Result<(), StepFailure> {
        let Rooms { q, p, lost_q, lost_p, force, velocity } = rooms;
        let (t, h) = (self.t + stage.node * self.h, stage.share() * self.h);
        match stage.half {
            Half::First => {
                self.drift::<S, C>(h, q.as_mut(), p.as_ref(), &memory.dw, velocity.as_mut(), lost_q.as_mut())
            }
            Half::Second => {
                let is_end = index == 0 || index + 1 == self.count;
                let (q, p, lost_p) = (q.as_ref(), p.as_mut(), lost_p.as_mut());
                self.kick::<S, C>(Origin { t, h }, is_end, q, p, force.as_mut(), lost_p, memory);
            }
        }
        Ok(())
    }
}

impl<F: Flows> FlowsOf<'_, F> {
    /// Where parts lead to, by a way to take them. A drift has the discrete Lagrangian `p · Δq - a T(p)`, a kick at `q` has
    /// `-b V(q)` and what `also` says of it. Both sums of weights are 1, so that `T = F(q_0, ·) - V(q_0)` and `V = F(·, p_0) - T(p_0)` sum
    /// up to values of `F`, less `F(q_0, p_0)`.
    pub(crate) fn follow(
        &self,
        taken: &mut impl Take<f64, F::Shape>,
        stages: &[Stage],
        segment: &Segment<F::Vector>,
        dw: &[f64],
        also: impl Fn(usize, &Stage, &[f64]) -> f64,
    ) -> Option<Followed<F::Vector>> {
        let &Self { system, t, h, .. } = self;
        let (q0, p0) = (segment.q0.components(), segment.p.components());
        system.check(q0.len()).ok()?;
        let value = |q: &[f64], p: &[f64], t: f64| {
            let noises = dw.iter().zip(1..).map(|(dw, term)| dw * system.evaluate(term, q, p, t));
            h * system.evaluate(0, q, p, t) + noises.sum::<f64>()
        };
        let mut followed =
            follow(taken, stages, segment, dw, |index, stage, [before, _], [q, p]| match stage.half {
                Half::First => {
                    let moved: f64 =
                        p.iter().zip(q.iter().zip(before)).map(|(p, (q, before))| p * (q - before)).sum();
                    moved - stage.weight * value(q0, p, t)
                }
                Half::Second => also(index, stage, q) - stage.weight * value(q, p0, t + stage.node * h),
            })?;
        followed.action += value(q0, p0, t);
        Some(followed)
    }
}

impl<F> FlowsOf<'_, F> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn drift<S: Scalar, C: Carry<S>>(
        &self,
        h: f64,
        q: &mut [S],
        p: &[S],
        dw: &[S],
        velocity: &mut [S],
        lost: &mut [S],
    ) where
        F: Slopes<S>,
    {
        if F::IN_PLACE && !C::CARRIES {
            return self.system.add_velocity(self.t, h, p, dw, q);
        }
        self.system.slopes::<false, true>(self.t, h, q, p, dw, &mut [], velocity);
        add::<S, C>(q, velocity, lost);
    }

    #[expect(clippy::too_many_arguments, reason = "lists of a step, which lie beside each other")]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn kick<S: Scalar, C: Carry<S>>(
        &self,
        origin: Origin,
        is_end: bool,
        q: &[S],
        p: &mut [S],
        force: &mut [S],
        lost: &mut [S],
        memory: &mut Memory<S, F::Shape>,
    ) where
        F: Slopes<S>,
    {
        let Origin { t, h } = origin;
        if F::IN_PLACE && !C::CARRIES && !is_end {
            return self.system.add_force(t, h, q, &memory.dw, p);
        }
        let is_kept = is_end && memory.dw.is_empty();
        if is_kept && memory.has_force(origin, F::FORCE_READS_TIME, q) {
            return add::<S, C>(p, memory.kept_force.as_ref(), lost);
        }
        if F::IN_PLACE {
            force.fill(nothing());
            self.system.add_force(t, h, q, &memory.dw, force);
        } else {
            self.system.slopes::<true, false>(t, h, q, p, &memory.dw, force, &mut []);
        }
        add::<S, C>(p, force, lost);
        if is_kept {
            memory.keep_force(origin, q, force);
        }
    }
}
