//! The flows of two summands into which the user has split the Hamiltonian: `drift = [H_A, H_B]`.
//!
//! Each summand has one of the forms whose flow the compiler knows: a function of the coordinates (a kick), a
//! function of the momenta (a drift), a quadratic form in both with constant coefficients (a linear map,
//! [`LinearFlow`], computed once for each weight), or a sum of Kepler problems ([`KeplerFlow`]). A summand
//! reads the time that the flows of the other one have reached: time is a coordinate that `H_A` moves.
//!
//! A force `f(q, t)` is included in the kick, `p' = -∂H/∂q + f`. Friction with a single rate is included in
//! the linear map, `p' = -∂H/∂q - γ p`, which is then conformally symplectic.

use std::marker::PhantomData;
use std::sync::Arc;

use super::kepler::KeplerFlow;
use super::lagrangian::{self, SequenceEnd};
use super::linear::LinearFlow;
use super::lists::{
    KeptForce, ListParts, PartScratch, SplittingLists, SplittingMemory, SplittingRooms, add, follow,
    take_parts,
};
use super::plans::plan;
use super::{ComposedWord, Composes};
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
use crate::scheme::word::{Part, PartKind, Substep, Weighted, Word};

/// A summand of `drift = [H_A, H_B]`, as the part of a word: its flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Summand {
    /// `H_A`
    A,
    /// `H_B`
    B,
}

/// Each summand acts at the time that the flow of the other has reached.
impl PartKind for Summand {
    const IS_FLOW: bool = true;

    fn moves_time_of(self, other: Self) -> bool {
        self != other
    }

    fn of_table(table: &[Weighted<Part>]) -> Word<Self> {
        Word::of(table.iter().map(|&Weighted { part, weight }| Weighted {
            part: if part == Part::A { Self::A } else { Self::B },
            weight,
        }))
    }
}

/// The form of a summand of the Hamiltonian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// A function of coordinates and time.
    Coordinates,
    /// A function of momenta.
    Momenta,
    /// A polynomial of degree two in coordinates and momenta, with constant coefficients.
    Quadratic,
    /// Kepler problems of bodies that do not act on each other.
    Kepler {
        /// The coordinates of a body, which follow each other.
        components: usize,
    },
}

/// The summands of a system whose drift is declared in two.
struct SummandsOf<F>(PhantomData<F>);

impl<F: Elements> SummandsOf<F> {
    /// As [`Facts::summands`](crate::scheme::plan::Facts::summands). A system without summands is an error
    /// when this constant is compiled, not in a run.
    const FORMS: [Form; 2] =
        F::FACTS.summands.expect("the drift is declared in two parts, `drift = [H_A, H_B]`");
}

/// `h ∂H/∂q` and `h ∂H/∂p` of a summand, as far as wanted.
#[cfg_attr(not(debug_assertions), inline(always))]
fn gradient_of_summand<F: Elements, S: Scalar, const BY_Q: bool, const BY_P: bool>(
    system: &F,
    summand: Summand,
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
    let term = Role::Summand(summand as usize).times(1.0);
    slopes(system, term, &at, wanted, by_q, by_p, columns);
}

/// The flows of the two summands in turn.
#[derive(Clone, Copy, Debug)]
pub struct SummandSplitting<W>(PhantomData<W>);

/// The parameters of a system, and the word of a step.
#[derive(Clone, Debug)]
pub struct SummandConstants<K> {
    parameters: Vec<K>,
    word: Word<SummandFlow<K>>,
}

/// The flow of a summand.
#[derive(Clone, Debug)]
enum SummandFlow<K> {
    /// `p ← p - a ∂H/∂q`
    Kick(Summand),
    /// `q ← q + a ∂H/∂p`
    Drift(Summand),
    /// A linear map.
    Map(Arc<LinearFlow<K>>),
    /// Bodies that do not act on each other.
    Kepler(Arc<KeplerFlow<K>>),
}

/// Prepares a word, with one map for all parts of the same summand and weight.
///
/// # Errors
/// [`ConfigError::Parameter`] where a coefficient is not finite.
fn prepare<F: Elements, K: Constant>(
    system: &F,
    degrees: usize,
    lift: LiftParameter<'_, K>,
    h: K,
    word: &Word<Summand>,
) -> Result<SummandConstants<K>, ConfigError> {
    let parameters = varied_without_lists(system, lift)?;
    let mut columns = PairColumns::default();
    let mut slopes_of = |summand: Summand, x: &[K], slopes: &mut [K]| {
        let ((q, p), (by_q, by_p)) = (x.split_at(degrees), slopes.split_at_mut(degrees));
        let unit = [0.0, 1.0].map(Scalar::from_f64);
        let varied = K::varied(&parameters);
        let (at, into) = ([q, p], [&mut *by_q, by_p]);
        gradient_of_summand::<F, K, true, true>(system, summand, varied, unit, at, into, &mut columns);
        if F::FACTS.kind.is_conformal {
            let rate: K = system.friction_rate(&parameters);
            by_q.iter_mut().zip(p).for_each(|(slope, p)| *slope = *slope + rate * *p);
        }
    };
    let mut known: Vec<(Summand, f64, SummandFlow<K>)> = Vec::new();
    let mut flow = |&Substep { part: summand, weight, .. }: &Substep<Summand>| {
        let form = SummandsOf::<F>::FORMS[summand as usize];
        // The flow of bodies takes its time when it acts.
        let depends_on_weight = form == Form::Quadratic;
        let is_known = |(of, with, _): &&(Summand, f64, SummandFlow<K>)| {
            *of == summand && (*with == weight || !depends_on_weight)
        };
        if let Some((.., flow)) = known.iter().find(is_known) {
            return Ok(flow.clone());
        }
        let mut slopes = |x: &[K], slopes: &mut [K]| slopes_of(summand, x, slopes);
        let flow = match form {
            Form::Coordinates => SummandFlow::Kick(summand),
            Form::Momenta => SummandFlow::Drift(summand),
            Form::Quadratic => SummandFlow::Map(Arc::new(LinearFlow::new(degrees, h * weight, &mut slopes)?)),
            Form::Kepler { components } => {
                SummandFlow::Kepler(Arc::new(KeplerFlow::new(degrees, components, &mut slopes)?))
            }
        };
        known.push((summand, weight, flow.clone()));
        Ok(flow)
    };
    let substeps = word.substeps.iter().map(|substep| Ok(substep.with(flow(substep)?)));
    let word = Word { substeps: substeps.collect::<Result<_, _>>()? };
    Ok(SummandConstants { parameters, word })
}

impl<F: Elements, E, T, W: Composes<E, T, Part = Summand>> Scheme<F>
    for SummandSplitting<ComposedWord<E, T, W>>
{
    const PLAN: Plan = plan(F::FACTS.explicit(), W::ORDER);
    const PROPERTIES: Properties =
        Properties { kept_energy: KeptEnergy::Nearly, ..Properties::of(&<Self as Scheme<F>>::PLAN, 0) };
    type Prepared<K: Constant> = SummandConstants<K>;
    type Memory<S: Scalar> = SplittingMemory<S, F::Shape>;
    type Unclocked = Self;
    type CompensatedSum<S: Scalar> = state_sum::CompensatedSum<S, F::Shape>;
    type Sum<S: Scalar> = PlainSum;

    fn memory(system: &F) -> Self::Memory<f64> {
        SplittingMemory::of_system(system)
    }

    fn prepare<K: Constant>(
        system: &F,
        lift: LiftParameter<'_, K>,
        h: K,
    ) -> Result<SummandConstants<K>, ConfigError> {
        check_new(system)?;
        prepare(system, system.degrees(), lift, h, &W::word())
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        system: &F,
        SummandConstants { parameters, word }: &SummandConstants<K>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let StepArguments { t, h, q, p, dw } = at.lists().shared();
        let mut flows = SummandFlows::<F, S> { system, parameters: S::varied(parameters), t, h };
        take_parts(system, &mut flows, word, [q, p], dw, memory, carry)
    }

    /// A drift has the discrete Lagrangian `p · Δq - a H(p)`, a kick `-b H(q)`, and the other flows the
    /// integral of `p · q' - H`.
    fn discrete_lagrangian(system: &F, segment: &Segment<F::Vector>, dw: &[f64]) -> f64 {
        if F::FACTS.kind.is_conformal {
            return f64::NAN;
        }
        lagrangian::value(segment, dw, system.noises(), || Self::follow(system, segment, dw))
    }
}

impl<E, T, W: Composes<E, T, Part = Summand>> SummandSplitting<ComposedWord<E, T, W>> {
    fn follow<F: Elements>(
        system: &F,
        segment: &Segment<F::Vector>,
        dw: &[f64],
    ) -> Option<SequenceEnd<F::Vector>> {
        let (t, h, degrees) = (segment.t, segment.h, segment.q0.components().len());
        system.check(degrees).ok()?;
        let SummandConstants { word, .. } = prepare(system, degrees, &as_they_are, h, &W::word()).ok()?;
        let action = |substep: &Substep<SummandFlow<f64>>, before: [&[f64]; 2], [q, p]: [&[f64]; 2]| {
            let value = |summand: Summand| {
                let at = EvaluationPoint::new([q, p], t + substep.node * h, &[], &[]);
                substep.weight * h * system.value(Role::Summand(summand as usize), 1.0, &at)
            };
            match &substep.part {
                SummandFlow::Kick(summand) => -value(*summand),
                SummandFlow::Drift(summand) => {
                    let moved =
                        p.iter().zip(q.iter().zip(before[0])).map(|(p, (q, before))| p * (q - before));
                    moved.sum::<f64>() - value(*summand)
                }
                SummandFlow::Map(map) => map.action(before, [q, p]),
                SummandFlow::Kepler(bodies) => bodies.action(substep.weight * h, before),
            }
        };
        let mut flows = SummandFlows { system, parameters: &[], t, h };
        follow(&mut flows, &word, segment, dw, action)
    }
}

/// The flows of the summands in a step.
struct SummandFlows<'a, F, S: Scalar> {
    system: &'a F,
    parameters: &'a [S::Constant],
    t: S::Constant,
    h: S::Constant,
}

impl<F: Elements, K: Constant, S: ComputesWith<K>> ListParts<S, F::Shape, SummandFlow<K>>
    for SummandFlows<'_, F, S>
{
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take_part<C: StateSum<S>, const EXACT: bool>(
        &mut self,
        substep: &Substep<SummandFlow<K>>,
        SplittingLists { q, p, rooms }: &mut SplittingLists<'_, S, F::Shape>,
        _: &mut KeptForce<S, F::Shape>,
        PartScratch { columns, .. }: &mut PartScratch<S>,
    ) -> Result<(), StepFailure> {
        let &mut Self { system, parameters, t, h } = self;
        let (q, p) = (&mut **q, &mut **p);
        let SplittingRooms { lost_q, lost_p, force, velocity } = &mut **rooms;
        let [lost_q, lost_p, force, velocity] = [lost_q, lost_p, force, velocity].map(AsMut::as_mut);
        let (t, h) = (h * substep.node + t, h * substep.weight);
        match &substep.part {
            SummandFlow::Kick(summand) => {
                let into = [&mut *force, &mut []];
                let (at, times) = ([&*q, &*p], [t, -h]);
                gradient_of_summand::<F, S, true, false>(
                    system, *summand, parameters, times, at, into, columns,
                );
                if F::FACTS.kind.is_forced {
                    velocity.fill(S::from_f64(0.0));
                    forces(system, &EvaluationPoint::new([&*q, p], t, parameters, &[]), velocity, columns);
                    let h = S::of_constant(h);
                    force.iter_mut().zip(&*velocity).for_each(|(kick, f)| *kick = *kick + *f * h);
                }
                add::<S, C>(p, force, lost_p);
            }
            SummandFlow::Drift(summand) => {
                let into = [&mut [][..], &mut *velocity];
                let (at, times) = ([&*q, &*p], [t, h]);
                gradient_of_summand::<F, S, false, true>(
                    system, *summand, parameters, times, at, into, columns,
                );
                add::<S, C>(q, velocity, lost_q);
            }
            SummandFlow::Map(map) => {
                map.increments([q, p], [&mut *velocity, &mut *force]);
                add::<S, C>(q, velocity, lost_q);
                add::<S, C>(p, force, lost_p);
            }
            SummandFlow::Kepler(bodies) => {
                bodies.increments(S::of_constant(h), [q, p], [&mut *velocity, &mut *force])?;
                add::<S, C>(q, velocity, lost_q);
                add::<S, C>(p, force, lost_p);
            }
        }
        Ok(())
    }
}
