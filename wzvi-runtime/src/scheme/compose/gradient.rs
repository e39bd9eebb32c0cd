//! Kicks by potentials with the square of the force, `b V - c |V'|²`, for quadratic kinetic energies.
//!
//! With the step Hamiltonian `F = T(p) + V(q, t)` and constant `T''` the bracket `{V, {T, V}}` is a function of the coordinates,
//! `|V'|² = V' · T'' V'`, up to its sign, so that its flow is a kick, too, and one that goes together with that of `V`:
//!
//! ```text
//! p ← p - b V' + 2 c V'' T'' V'
//! ```
//!
//! `T'' V'` and `V'' (T'' V')` are derivatives of the generated slopes in one direction each, by dual numbers: two evaluations
//! besides that of the force, at any size. All of them are taken of the fraction `s = -b` of `F`, where the last term is
//! `2 c / s³` times `s³ V'' T'' V'`.

use std::marker::PhantomData;

use super::Partitioned;
use super::flows::{Flows, FlowsOf, Prepared};
use super::lagrangian;
use super::stages::{Memory, Rooms, Stage, Stages, Take, add, advance, check};
use super::substeps::{Substeps, plan};
use crate::algebra::carry::{Carry, Plain};
use crate::algebra::scalar::{Constant, Dual, Of, Over, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state::Vector;
use crate::error::{ConfigError, StepFailure};
use crate::scheme::gauss::{Field, Shape};
use crate::scheme::plan::{KeptEnergy, Plan};
use crate::scheme::system::{
    At, Hamiltonian, Lift, Properties, Scheme, Segment, as_they_are, without_derivatives,
};

/// Tables whose kicks are by `b V - c |V'|²`, with the square of the force in the metric of the inverse masses.
pub trait GradientTable: Partitioned {
    /// The factors `c` of `h³ |V'|²`, one for each drift (zero) and kick of [`Partitioned::SEQUENCE`].
    const GRADIENT: &'static [f64];
    /// What `EQUATIONS` say of it.
    const NOTE: &'static str;
}

/// The drifts and kicks `W` in turn, by the table `T`.
#[derive(Clone, Copy, Debug)]
pub struct GradientKicks<W, T>(PhantomData<(W, T)>);

impl<F: Flows, W: Substeps, T: GradientTable> Scheme<F> for GradientKicks<W, T> {
    const PLAN: Plan = plan(F::FACTS.explicit(), W::ORDER);
    const PROPERTIES: Properties =
        Properties { kept_energy: KeptEnergy::Nearly, ..Properties::of(&<Self as Scheme<F>>::PLAN, 0) };
    type Prepared<K: Constant> = Prepared<Of<F::Parameters, f64>>;
    type Memory<S: Scalar> = Memory<S, F::Shape>;
    type Compensated<S: Scalar> = <F::Shape as Shape>::Compensation<S>;
    type Carry<S: Scalar> = Plain;

    fn memory(system: &F) -> Self::Memory<f64> {
        let mut memory = Memory::of_system(system);
        memory.directional.fit(system.degrees(), system.noises());
        memory
    }

    fn prepare<K: Constant>(system: &F, _: Lift<'_, K>, h: K) -> Result<Self::Prepared<K>, ConfigError> {
        const {
            assert!(
                T::GRADIENT.len() == T::SEQUENCE.len(),
                "a table with gradients has one for each drift and kick"
            );
        }
        without_derivatives(h)?;
        check(system)?;
        Ok(Prepared { parameters: system.parameters(&as_they_are), stages: Stages::of(&W::list()) })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: Over<K>, C: Carry<S>, const CAREFUL: bool>(
        system: &F,
        Prepared { parameters, stages: Stages(stages) }: &Self::Prepared<K>,
        at: At<'_, S, K>,
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let At { t, h, q, p, dw } = at.plain()?;
        let flows = FlowsOf { system, parameters, t, h, count: stages.len() };
        advance(system, &mut Kicks::of::<T>(flows), stages, [q, p], dw, memory, carry)
    }

    /// A kick has the discrete Lagrangian `-b V(q) + c |V'(q)|²`.
    fn discrete_lagrangian(system: &F, segment: &Segment<F::Vector>, dw: &[f64]) -> f64 {
        let stages = Stages::of(&W::list());
        let parameters = &system.parameters(&as_they_are);
        let flows = FlowsOf { system, parameters, t: segment.t, h: segment.h, count: stages.0.len() };
        let kicks = Kicks::of::<T>(flows);
        let degrees = segment.q0.components().len();
        let mut taken = Kicks::of::<T>(kicks.flows.clone());
        let along_kick = |index: usize, stage: &Stage, q: &[f64]| {
            let gradient = kicks.gradient(index);
            if gradient == 0.0 {
                return 0.0;
            }
            let mut directional = Directional::default();
            directional.fit(degrees, dw.len());
            let dw: Vec<f64> = dw.iter().map(|dw| stage.share() * dw).collect();
            let [mut force, mut change] = [vec![0.0; degrees], vec![0.0; degrees]];
            let kick = Kick { flows: &kicks.flows, stage, q, dw: &dw };
            let square = kick.differentiate(&mut directional, &mut force, &mut change);
            gradient / stage.share().powi(3) * square
        };
        lagrangian::value(segment, dw, Hamiltonian::noises(system), || {
            kicks.flows.follow(&mut taken, &stages.0, segment, dw, along_kick)
        })
    }
}

/// The flows in a step, and the factors of the squares of the force.
struct Kicks<'a, F: Field> {
    flows: FlowsOf<'a, F, f64>,
    gradient: &'static [f64],
}

impl<'a, F: Flows> Kicks<'a, F> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of<T: GradientTable>(flows: FlowsOf<'a, F, f64>) -> Self {
        Self { flows, gradient: T::GRADIENT }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn gradient(&self, index: usize) -> f64 {
        self.gradient.get(index).copied().unwrap_or(0.0)
    }
}

impl<F: Flows, S: Scalar> Take<S, F::Shape> for Kicks<'_, F> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take<C: Carry<S>>(
        &mut self,
        index: usize,
        stage: &Stage,
        rooms: &mut Rooms<S, F::Shape>,
        memory: &mut Memory<S, F::Shape>,
    ) -> Result<(), StepFailure> {
        let gradient = self.gradient(index);
        if gradient == 0.0 {
            return self.flows.take::<C>(index, stage, rooms, memory);
        }
        let Rooms { q, p, lost_p, force, velocity, .. } = rooms;
        let (q, force, change) = (q.as_ref(), force.as_mut(), velocity.as_mut());
        let Memory { directional, dw, .. } = memory;
        directional.fit(q.len(), dw.len());
        Kick { flows: &self.flows, stage, q, dw }.differentiate(directional, force, change);
        let factor = 2.0 * gradient / stage.share().powi(3);
        for (force, change) in force.iter_mut().zip(change) {
            *force = *force + *change * factor;
        }
        add::<S, C>(p.as_mut(), force, lost_p.as_mut());
        Ok(())
    }
}

/// Where and for what a force is evaluated: of the fraction of the step Hamiltonian that is the stage's share.
struct Kick<'a, F: Field, S> {
    flows: &'a FlowsOf<'a, F, f64>,
    stage: &'a Stage,
    q: &'a [S],
    dw: &'a [S],
}

impl<F: Flows, S: Scalar> Kick<'_, F, S> {
    /// `V'` into `force` and `V'' T'' V'` into `change`; gives `|V'|²`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn differentiate(&self, room: &mut Directional<S>, force: &mut [S], change: &mut [S]) -> S {
        let &Self { flows: &FlowsOf { system, parameters, t, h, .. }, stage, q, dw } = self;
        let (t, h) = (t + stage.node * h, stage.share() * h);
        let Directional { q: dual_q, p: dual_p, slopes, dw: dual_dw } = room;
        // The momenta do not matter to what is read: `V'`, and the constant `T''`.
        system.step_slopes::<f64, S, true, false>(
            parameters,
            S::from_f64(t),
            S::from_f64(h),
            q,
            q,
            dw,
            force,
            &mut [],
        );
        let zero = S::from_f64(0.0);
        for (dual, &dw) in dual_dw.iter_mut().zip(dw) {
            *dual = Dual::constant(dw);
        }
        for ((dual_q, dual_p), (&q, &force)) in dual_q.iter_mut().zip(&mut *dual_p).zip(q.iter().zip(&*force))
        {
            *dual_q = Dual::constant(q);
            *dual_p = Dual { value: zero, derivative: [force] };
        }
        let [t, h] = [t, h].map(Dual::from_f64);
        system.step_slopes::<f64, Dual<1, S>, false, true>(
            parameters,
            t,
            h,
            dual_q,
            dual_p,
            dual_dw,
            &mut [],
            slopes,
        );
        let mut square = zero;
        for ((dual_q, slope), &force) in dual_q.iter_mut().zip(&*slopes).zip(&*force) {
            let [along] = slope.derivative;
            dual_q.derivative = [along];
            square = square + force * along;
        }
        system.step_slopes::<f64, Dual<1, S>, true, false>(
            parameters,
            t,
            h,
            dual_q,
            dual_p,
            dual_dw,
            slopes,
            &mut [],
        );
        for (change, slope) in change.iter_mut().zip(&*slopes) {
            [*change] = slope.derivative;
        }
        square
    }
}

/// Room for slopes with their derivative in one direction.
#[derive(Debug)]
pub(super) struct Directional<S> {
    q: Vec<Dual<1, S>>,
    p: Vec<Dual<1, S>>,
    slopes: Vec<Dual<1, S>>,
    dw: Vec<Dual<1, S>>,
}

/// None.
impl<S> Default for Directional<S> {
    fn default() -> Self {
        Self { q: Vec::new(), p: Vec::new(), slopes: Vec::new(), dw: Vec::new() }
    }
}

impl<S: Scalar> Directional<S> {
    /// Makes room for so many degrees of freedom and noises, where it is not there.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn fit(&mut self, degrees: usize, noises: usize) {
        if self.q.len() != degrees || self.dw.len() != noises {
            let zero = Dual::from_f64(0.0);
            for list in [&mut self.q, &mut self.p, &mut self.slopes] {
                list.resize(degrees, zero);
            }
            self.dw.resize(noises, zero);
        }
    }
}
