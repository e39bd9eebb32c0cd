//! The flows of two parts into which the user has split the Hamiltonian: `drift = [H_A, H_B]`.
//!
//! Each part has one of the forms whose flow the compiler knows: a function of the coordinates (a kick), a
//! function of the momenta (a drift), or a quadratic form in both with constant coefficients (a linear map,
//! [`Linear`], computed once for each weight). A part reads the time that the flows of the other part have
//! reached: time is a coordinate that `H_A` moves.
//!
//! A force `f(q, t)` is included in the kick, `p' = -∂H/∂q + f`. Friction with a single rate is included in
//! the linear map, `p' = -∂H/∂q - γ p`, which is then conformally symplectic.

use std::marker::PhantomData;
use std::sync::Arc;

use super::Composes;
use super::lagrangian::{self, Followed};
use super::linear::Linear;
use super::stages::{Memory, Rooms, Stage, Stages, add, advance, follow};
use super::substeps::{By, Half, Substep, plan};
use crate::algebra::carry::{self, Carry, Plain};
use crate::algebra::scalar::{Constant, Over, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state::Vector;
use crate::error::{ConfigError, StepFailure};
use crate::scheme::elements::{Elements, PairColumns, Point, Slopes, check_new, forces, slopes};
use crate::scheme::plan::{KeptEnergy, Plan};
use crate::scheme::system::{
    At, Hamiltonian as _, Lift, Movable, Properties, Scheme, Segment, as_they_are, varied_without_lists,
};

/// The form of a part of the Hamiltonian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// A function of coordinates and time.
    Coordinates,
    /// A function of momenta.
    Momenta,
    /// A polynomial of degree two in coordinates and momenta, with constant coefficients.
    Quadratic,
}

/// The parts of a system whose drift is declared in two.
struct Parts<F>(PhantomData<F>);

impl<F: Elements> Parts<F> {
    /// As [`Facts::parts`](crate::scheme::plan::Facts::parts).
    const OF_DRIFT: (usize, [Form; 2]) =
        F::FACTS.parts.expect("the drift is declared in two parts, `drift = [H_A, H_B]`");
}

/// `h ∂H/∂q` and `h ∂H/∂p` of a part, as far as wanted.
#[cfg_attr(not(debug_assertions), inline(always))]
fn slopes_of_part<F: Elements, S: Scalar, const BY_Q: bool, const BY_P: bool>(
    system: &F,
    part: Half,
    parameters: &[S::Constant],
    [t, h]: [S::Constant; 2],
    [q, p]: [&[S]; 2],
    [by_q, by_p]: [&mut [S]; 2],
    columns: &mut PairColumns,
) {
    by_q.fill(S::from_f64(0.0));
    by_p.fill(S::from_f64(0.0));
    let at = Point { h, ..Point::new([q, p], t, parameters, &[]) };
    let wanted = Slopes { by_q: BY_Q, by_p: BY_P };
    let part = (Parts::<F>::OF_DRIFT.0 + part as usize, 1.0);
    slopes(system, part, &at, wanted, by_q, by_p, columns);
}

/// The flows of the two parts in turn.
#[derive(Clone, Copy, Debug)]
pub struct PartFlows<W>(PhantomData<W>);

/// The parts of a step.
#[derive(Clone, Debug)]
pub struct Prepared<K> {
    parameters: Vec<K>,
    stages: Stages<Act<K>>,
}

/// The flow of a part.
#[derive(Clone, Debug)]
enum Act<K> {
    /// `p ← p - a ∂H/∂q`
    Kick(Half),
    /// `q ← q + a ∂H/∂p`
    Drift(Half),
    /// A linear map.
    Map(Arc<Linear<K>>),
}

/// Prepares the parts of a step, with one map for all stages of the same part and weight.
///
/// # Errors
/// [`ConfigError::Parameter`] where a coefficient is not finite.
fn prepare<F: Elements, K: Constant>(
    system: &F,
    degrees: usize,
    (lift, h): (Lift<'_, K>, K),
    substeps: &[Substep],
) -> Result<Prepared<K>, ConfigError> {
    let parameters = varied_without_lists(system, lift)?;
    let mut columns = PairColumns::default();
    let mut known: Vec<(Stage, Arc<Linear<K>>)> = Vec::new();
    let mut act = |stage: &Stage| {
        let half = stage.act;
        match Parts::<F>::OF_DRIFT.1[half as usize] {
            Form::Coordinates => return Ok(Act::Kick(half)),
            Form::Momenta => return Ok(Act::Drift(half)),
            Form::Quadratic => {}
        }
        if let Some((_, map)) =
            known.iter().find(|(other, _)| (other.act, other.weight) == (half, stage.weight))
        {
            return Ok(Act::Map(map.clone()));
        }
        let map = Linear::new(degrees, h * stage.weight, &mut |x, slopes| {
            let ((q, p), (by_q, by_p)) = (x.split_at(degrees), slopes.split_at_mut(degrees));
            let unit = [0.0, 1.0].map(Scalar::from_f64);
            let varied = K::varied(&parameters);
            let (at, into) = ([q, p], [&mut *by_q, by_p]);
            slopes_of_part::<F, K, true, true>(system, half, varied, unit, at, into, &mut columns);
            if F::FACTS.kind.is_conformal {
                let rate: K = system.friction_rate(&parameters);
                by_q.iter_mut().zip(p).for_each(|(slope, p)| *slope = *slope + rate * *p);
            }
        });
        let map = Arc::new(map?);
        known.push((*stage, map.clone()));
        Ok(Act::Map(map))
    };
    let stages = Stages::of(substeps).0;
    let stages = stages.iter().map(|stage| Ok(stage.with(act(stage)?))).collect::<Result<_, _>>()?;
    Ok(Prepared { parameters, stages: Stages(stages) })
}

impl<F: Elements, E, T, W: Composes<E, T>> Scheme<F> for PartFlows<By<E, T, W>> {
    const PLAN: Plan = plan(F::FACTS.explicit(), W::ORDER);
    const PROPERTIES: Properties =
        Properties { kept_energy: KeptEnergy::Nearly, ..Properties::of(&<Self as Scheme<F>>::PLAN, 0) };
    type Prepared<K: Constant> = Prepared<K>;
    type Memory<S: Scalar> = Memory<S, F::Shape>;
    type Compensated<S: Scalar> = carry::Compensated<S, F::Shape>;
    type Carry<S: Scalar> = Plain;

    fn memory(system: &F) -> Self::Memory<f64> {
        Memory::of_system(system)
    }

    fn prepare<K: Constant>(system: &F, lift: Lift<'_, K>, h: K) -> Result<Prepared<K>, ConfigError> {
        check_new(system)?;
        prepare(system, system.degrees(), (lift, h), &W::substeps())
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: Over<K>, C: Carry<S>, const CAREFUL: bool>(
        system: &F,
        Prepared { parameters, stages }: &Prepared<K>,
        at: At<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let At { t, h, q, p, dw } = at.lists().shared();
        let flows = FlowsOf::<F, S> { system, parameters: S::varied(parameters), t, h };
        let take = |stage: &_, rooms: &mut _, memory: &mut Memory<_, _>| {
            flows.take::<K, C>(stage, rooms, &mut memory.columns)
        };
        advance(system, take, &stages.0, [q, p], dw, memory, carry)
    }

    /// A drift has the discrete Lagrangian `p · Δq - a H(p)`, a kick `-b H(q)`, and a linear map the integral
    /// of `p · q' - H`.
    fn discrete_lagrangian(system: &F, segment: &Segment<F::Vector>, dw: &[f64]) -> f64 {
        if F::FACTS.kind.is_conformal {
            return f64::NAN;
        }
        lagrangian::value(segment, dw, system.noises(), || Self::follow(system, segment, dw))
    }
}

impl<E, T, W: Composes<E, T>> PartFlows<By<E, T, W>> {
    fn follow<F: Elements>(
        system: &F,
        segment: &Segment<F::Vector>,
        dw: &[f64],
    ) -> Option<Followed<F::Vector>> {
        let (t, h, degrees) = (segment.t, segment.h, segment.q0.components().len());
        system.check(degrees).ok()?;
        let prepared = prepare(system, degrees, (&as_they_are, h), &W::substeps()).ok()?;
        let Stages(stages) = prepared.stages;
        let action = |stage: &Stage<Act<f64>>, before: [&[f64]; 2], [q, p]: [&[f64]; 2]| {
            let value = |half: Half| {
                let part = Parts::<F>::OF_DRIFT.0 + half as usize;
                let at = Point::new([q, p], t + stage.node * h, &[], &[]);
                stage.weight * h * system.value(part, 1.0, &at)
            };
            match &stage.act {
                Act::Kick(half) => -value(*half),
                Act::Drift(half) => {
                    let moved =
                        p.iter().zip(q.iter().zip(before[0])).map(|(p, (q, before))| p * (q - before));
                    moved.sum::<f64>() - value(*half)
                }
                Act::Map(map) => map.action(before, [q, p]),
            }
        };
        let flows = FlowsOf { system, parameters: &[], t, h };
        let take = |stage: &_, rooms: &mut _, memory: &mut Memory<_, _>| {
            flows.take::<f64, Plain>(stage, rooms, &mut memory.columns)
        };
        follow(take, &stages, segment, dw, action)
    }
}

/// The flows of the parts in a step.
struct FlowsOf<'a, F, S: Scalar> {
    system: &'a F,
    parameters: &'a [S::Constant],
    t: S::Constant,
    h: S::Constant,
}

impl<F: Elements, S: Scalar> FlowsOf<'_, F, S> {
    /// Moves the state by a part of a step. None of these parts fails.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take<K: Constant, C: Carry<S>>(
        &self,
        stage: &Stage<Act<K>>,
        rooms: &mut Rooms<S, F::Shape>,
        columns: &mut PairColumns,
    ) -> Result<(), StepFailure>
    where
        S: Over<K>,
    {
        let &Self { system, parameters, t, h } = self;
        let [q, p, lost_q, lost_p, force, velocity] = rooms.0.each_mut().map(AsMut::as_mut);
        let (t, h) = (h * stage.node + t, h * stage.weight);
        match &stage.act {
            Act::Kick(half) => {
                let into = [&mut *force, &mut []];
                let (at, times) = ([&*q, &*p], [t, -h]);
                slopes_of_part::<F, S, true, false>(system, *half, parameters, times, at, into, columns);
                if F::FACTS.kind.is_forced {
                    velocity.fill(S::from_f64(0.0));
                    forces(system, &Point::new([&*q, p], t, parameters, &[]), velocity, columns);
                    let h = S::of_constant(h);
                    force.iter_mut().zip(&*velocity).for_each(|(kick, f)| *kick = *kick + *f * h);
                }
                add::<S, C>(p, force, lost_p);
            }
            Act::Drift(half) => {
                let into = [&mut [][..], &mut *velocity];
                let (at, times) = ([&*q, &*p], [t, h]);
                slopes_of_part::<F, S, false, true>(system, *half, parameters, times, at, into, columns);
                add::<S, C>(q, velocity, lost_q);
            }
            Act::Map(map) => {
                map.increments([q, p], [&mut *velocity, &mut *force]);
                add::<S, C>(q, velocity, lost_q);
                add::<S, C>(p, force, lost_p);
            }
        }
        Ok(())
    }
}
