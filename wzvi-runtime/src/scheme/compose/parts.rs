//! The flows of two parts into which the user has split the Hamiltonian: `drift = [H_A, H_B]`.
//!
//! Each part has one of the forms whose flow the compiler knows: a function of the coordinates (a kick), a
//! function of the momenta (a drift), or a quadratic form in both with constant coefficients (a linear map,
//! [`LinearFlow`], computed once for each weight). A part reads the time that the flows of the other part
//! have reached: time is a coordinate that `H_A` moves.
//!
//! A force `f(q, t)` is included in the kick, `p' = -∂H/∂q + f`. Friction with a single rate is included in
//! the linear map, `p' = -∂H/∂q - γ p`, which is then conformally symplectic.

use std::marker::PhantomData;
use std::sync::Arc;

use super::Composes;
use super::lagrangian::{self, SequenceEnd};
use super::linear::LinearFlow;
use super::stages::{
    KeptForce, PartScratch, SplittingLists, SplittingMemory, SplittingRooms, Stage, StageList, StepParts,
    add, follow, take_parts,
};
use super::substeps::{Half, Substep, Substeps, plan};
use crate::algebra::scalar::{ComputesWith, Constant, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state::Vector;
use crate::algebra::state_sum::{self, PlainSum, StateSum};
use crate::error::{ConfigError, StepFailure};
use crate::scheme::elements::{
    Elements, EvaluationPoint, PairColumns, Partials, Role, check_new, forces, slopes,
};
use crate::scheme::plan::{KeptEnergy, Plan};
use crate::scheme::system::{
    Hamiltonian as _, LiftParameter, Movable, Properties, Scheme, Segment, StepArguments, as_they_are,
    varied_without_lists,
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
struct TwoParts<F>(PhantomData<F>);

impl<F: Elements> TwoParts<F> {
    /// As [`Facts::summands`](crate::scheme::plan::Facts::summands).
    const FORMS: [Form; 2] =
        F::FACTS.summands.expect("the drift is declared in two parts, `drift = [H_A, H_B]`");
}

/// `h ∂H/∂q` and `h ∂H/∂p` of a part, as far as wanted.
#[cfg_attr(not(debug_assertions), inline(always))]
fn gradient_of_part<F: Elements, S: Scalar, const BY_Q: bool, const BY_P: bool>(
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
    let at = EvaluationPoint { h, ..EvaluationPoint::new([q, p], t, parameters, &[]) };
    let wanted = Partials { by_q: BY_Q, by_p: BY_P };
    let summand = Role::Summand(part as usize).times(1.0);
    slopes(system, summand, &at, wanted, by_q, by_p, columns);
}

/// The flows of the two parts in turn.
#[derive(Clone, Copy, Debug)]
pub struct PartFlows<W>(PhantomData<W>);

/// The parts of a step.
#[derive(Clone, Debug)]
pub struct PartConstants<K> {
    parameters: Vec<K>,
    stages: StageList<Act<K>>,
}

/// The flow of a part.
#[derive(Clone, Debug)]
enum Act<K> {
    /// `p ← p - a ∂H/∂q`
    Kick(Half),
    /// `q ← q + a ∂H/∂p`
    Drift(Half),
    /// A linear map.
    Map(Arc<LinearFlow<K>>),
}

/// Prepares the parts of a step, with one map for all stages of the same part and weight.
///
/// # Errors
/// [`ConfigError::Parameter`] where a coefficient is not finite.
fn prepare<F: Elements, K: Constant>(
    system: &F,
    degrees: usize,
    lift: LiftParameter<'_, K>,
    h: K,
    substeps: &[Substep],
) -> Result<PartConstants<K>, ConfigError> {
    let parameters = varied_without_lists(system, lift)?;
    let mut columns = PairColumns::default();
    let mut known: Vec<(Stage, Arc<LinearFlow<K>>)> = Vec::new();
    let mut act = |stage: &Stage| {
        let half = stage.act;
        match TwoParts::<F>::FORMS[half as usize] {
            Form::Coordinates => return Ok(Act::Kick(half)),
            Form::Momenta => return Ok(Act::Drift(half)),
            Form::Quadratic => {}
        }
        if let Some((_, map)) =
            known.iter().find(|(other, _)| (other.act, other.weight) == (half, stage.weight))
        {
            return Ok(Act::Map(map.clone()));
        }
        let map = LinearFlow::new(degrees, h * stage.weight, &mut |x, slopes| {
            let ((q, p), (by_q, by_p)) = (x.split_at(degrees), slopes.split_at_mut(degrees));
            let unit = [0.0, 1.0].map(Scalar::from_f64);
            let varied = K::varied(&parameters);
            let (at, into) = ([q, p], [&mut *by_q, by_p]);
            gradient_of_part::<F, K, true, true>(system, half, varied, unit, at, into, &mut columns);
            if F::FACTS.kind.is_conformal {
                let rate: K = system.friction_rate(&parameters);
                by_q.iter_mut().zip(p).for_each(|(slope, p)| *slope = *slope + rate * *p);
            }
        });
        let map = Arc::new(map?);
        known.push((*stage, map.clone()));
        Ok(Act::Map(map))
    };
    let stages = StageList::of(substeps).0;
    let stages = stages.iter().map(|stage| Ok(stage.with(act(stage)?))).collect::<Result<_, _>>()?;
    Ok(PartConstants { parameters, stages: StageList(stages) })
}

impl<F: Elements, E, T, W: Composes<E, T>> Scheme<F> for PartFlows<Substeps<E, T, W>> {
    const PLAN: Plan = plan(F::FACTS.explicit(), W::ORDER);
    const PROPERTIES: Properties =
        Properties { kept_energy: KeptEnergy::Nearly, ..Properties::of(&<Self as Scheme<F>>::PLAN, 0) };
    type Prepared<K: Constant> = PartConstants<K>;
    type Memory<S: Scalar> = SplittingMemory<S, F::Shape>;
    type CompensatedSum<S: Scalar> = state_sum::CompensatedSum<S, F::Shape>;
    type Sum<S: Scalar> = PlainSum;

    fn memory(system: &F) -> Self::Memory<f64> {
        SplittingMemory::of_system(system)
    }

    fn prepare<K: Constant>(
        system: &F,
        lift: LiftParameter<'_, K>,
        h: K,
    ) -> Result<PartConstants<K>, ConfigError> {
        check_new(system)?;
        prepare(system, system.degrees(), lift, h, &W::substeps())
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        system: &F,
        PartConstants { parameters, stages }: &PartConstants<K>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let StepArguments { t, h, q, p, dw } = at.lists().shared();
        let mut flows = TwoPartFlows::<F, S> { system, parameters: S::varied(parameters), t, h };
        take_parts(system, &mut flows, &stages.0, [q, p], dw, memory, carry)
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

impl<E, T, W: Composes<E, T>> PartFlows<Substeps<E, T, W>> {
    fn follow<F: Elements>(
        system: &F,
        segment: &Segment<F::Vector>,
        dw: &[f64],
    ) -> Option<SequenceEnd<F::Vector>> {
        let (t, h, degrees) = (segment.t, segment.h, segment.q0.components().len());
        system.check(degrees).ok()?;
        let prepared = prepare(system, degrees, &as_they_are, h, &W::substeps()).ok()?;
        let StageList(stages) = prepared.stages;
        let action = |stage: &Stage<Act<f64>>, before: [&[f64]; 2], [q, p]: [&[f64]; 2]| {
            let value = |half: Half| {
                let at = EvaluationPoint::new([q, p], t + stage.node * h, &[], &[]);
                stage.weight * h * system.value(Role::Summand(half as usize), 1.0, &at)
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
        let mut flows = TwoPartFlows { system, parameters: &[], t, h };
        follow(&mut flows, &stages, segment, dw, action)
    }
}

/// The flows of the parts in a step.
struct TwoPartFlows<'a, F, S: Scalar> {
    system: &'a F,
    parameters: &'a [S::Constant],
    t: S::Constant,
    h: S::Constant,
}

impl<F: Elements, K: Constant, S: ComputesWith<K>> StepParts<S, F::Shape, Act<K>> for TwoPartFlows<'_, F, S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take_part<C: StateSum<S>, const EXACT: bool>(
        &mut self,
        stage: &Stage<Act<K>>,
        SplittingLists { q, p, rooms }: &mut SplittingLists<'_, S, F::Shape>,
        _: &mut KeptForce<S, F::Shape>,
        PartScratch { columns, .. }: &mut PartScratch<S>,
    ) -> Result<(), StepFailure> {
        let &mut Self { system, parameters, t, h } = self;
        let (q, p) = (&mut **q, &mut **p);
        let SplittingRooms { lost_q, lost_p, force, velocity } = &mut **rooms;
        let [lost_q, lost_p, force, velocity] = [lost_q, lost_p, force, velocity].map(AsMut::as_mut);
        let (t, h) = (h * stage.node + t, h * stage.weight);
        match &stage.act {
            Act::Kick(half) => {
                let into = [&mut *force, &mut []];
                let (at, times) = ([&*q, &*p], [t, -h]);
                gradient_of_part::<F, S, true, false>(system, *half, parameters, times, at, into, columns);
                if F::FACTS.kind.is_forced {
                    velocity.fill(S::from_f64(0.0));
                    forces(system, &EvaluationPoint::new([&*q, p], t, parameters, &[]), velocity, columns);
                    let h = S::of_constant(h);
                    force.iter_mut().zip(&*velocity).for_each(|(kick, f)| *kick = *kick + *f * h);
                }
                add::<S, C>(p, force, lost_p);
            }
            Act::Drift(half) => {
                let into = [&mut [][..], &mut *velocity];
                let (at, times) = ([&*q, &*p], [t, h]);
                gradient_of_part::<F, S, false, true>(system, *half, parameters, times, at, into, columns);
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
