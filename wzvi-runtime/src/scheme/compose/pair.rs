//! Steps of two schemes, one after the other: for any Hamiltonian.

use std::marker::PhantomData;

use super::lagrangian::{self, SequenceEnd};
use super::memory::CompositionMemory;
use super::plans::{joint_plan, kept_energy, plan};
use super::text::Listing;
use super::{ComposedWord, Composes};
use crate::algebra::lanes::Lanes;
use crate::algebra::scalar::{ComputesWith, Constant, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state::{State, Vector};
use crate::algebra::state_sum::StateSum;
use crate::error::{ConfigError, FailedLanes, StepFailure};
use crate::scheme::plan::{KeptEnergy, Plan};
use crate::scheme::poles::Poles;
use crate::scheme::system::{
    Discretized, Hamiltonian, LiftParameter, MemoryOf, Movable, PreparedOf, Properties, Scheme, SchemeOf,
    Segment, StepArguments, anew, as_they_are, check_state,
};
use crate::scheme::word::{Part, PartKind, Substep, Weighted, Word};

/// Steps `W` of the basic method `A` and its adjoint `B`, which may be the same.
#[derive(Clone, Copy, Debug)]
pub struct PairComposition<A, B, W>(PhantomData<(A, B, W)>);

/// The scheme that takes a step of a composition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BasicMethod {
    /// The basic method, such as `DeltaPlus`.
    Itself,
    /// Its adjoint, such as `DeltaMinus`.
    Adjoint,
}

/// The steps take all of the system along, with its time.
impl PartKind for BasicMethod {
    const NOTE: &'static str = ", by steps of DeltaMinus (drift) and DeltaPlus (kick) of which each is a coefficient less the one before";
    const IS_FLOW: bool = false;

    fn moves_time_of(self, _: Self) -> bool {
        true
    }

    /// Alternating steps with the weights `z_1 = x_1`, `z_{i+1} = x_{i+1} - z_i` for the coefficients `x`
    /// without the last one. A drift comes first in `DeltaMinus`, a kick in `DeltaPlus`.
    fn of_table(table: &[Weighted<Part>]) -> Word<Self> {
        let mut weight = 0.0;
        let coefficients = table.split_last().map_or(&[][..], |(_, coefficients)| coefficients);
        Word::of(coefficients.iter().map(|coefficient| {
            weight = coefficient.weight - weight;
            let part = if coefficient.part == Part::A { Self::Adjoint } else { Self::Itself };
            Weighted { part, weight }
        }))
    }
}

/// The prepared parts of a step.
#[derive(Clone, Debug)]
pub struct PairConstants<A, B> {
    word: Word<BasicMethod>,
    /// The constants of the steps of each method, in the order of the word.
    of: (Vec<A>, Vec<B>),
}

/// The prepared steps of one method, in lanes.
fn gather_all<H: Discretized<E>, E, const L: usize>(
    of_lanes: [&Vec<PreparedOf<H, E>>; L],
) -> Option<Vec<PreparedOf<H, E, Lanes<L>>>> {
    // One composition has prepared all lanes, so they have the same parts.
    let part = |index| SchemeOf::<H, E>::gather(of_lanes.map(|parts| &parts[index]));
    (0..of_lanes.first()?.len()).map(part).collect()
}

/// The poles of steps of two schemes with these weights: of both halves of each, or of the one scheme that
/// both are.
const fn poles(first: Option<Poles>, second: Option<Poles>, listing: Listing) -> Option<Poles> {
    let (Some(first), Some(second), Listing::Steps(mut weights)) = (first, second, listing) else {
        return None;
    };
    let mut largest = 0.0;
    while let [weight, rest @ ..] = weights {
        largest = if weight.abs() > largest { weight.abs() } else { largest };
        weights = rest;
    }
    let points = [first.points[0], second.points[1]];
    let halves = if points[0] == points[1] { 1.0 } else { 0.5 };
    Some(Poles { points, fraction: halves * largest * first.fraction })
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn scale<S: Scalar>(dw: &[S], weight: f64, into: &mut Vec<S>) {
    into.clear();
    into.extend(dw.iter().map(|dw| *dw * weight));
}

impl<H, A, B, E, T, W> Scheme<H> for PairComposition<A, B, ComposedWord<E, T, W>>
where
    H: Discretized<A> + Discretized<B>,
    W: Composes<E, T, Part = BasicMethod>,
{
    const PLAN: Plan =
        plan(joint_plan(<SchemeOf<H, A> as Scheme<H>>::PLAN, <SchemeOf<H, B> as Scheme<H>>::PLAN), W::ORDER);
    const PROPERTIES: Properties = {
        let (first, second) = (<H as Discretized<A>>::PROPERTIES, <H as Discretized<B>>::PROPERTIES);
        let kept = match (first.kept_energy, second.kept_energy) {
            (KeptEnergy::Point(_), KeptEnergy::Point(_)) => KeptEnergy::KickDriftKick,
            _ => KeptEnergy::Hamiltonian,
        };
        Properties {
            kept_energy: kept_energy(kept, W::ORDER),
            stages: if first.stages > second.stages { first.stages } else { second.stages },
            remembers: first.remembers || second.remembers,
            in_lanes: first.in_lanes && second.in_lanes,
            poles: poles(first.poles, second.poles, W::LISTING),
            ..Properties::of(&<Self as Scheme<H>>::PLAN, 0)
        }
    };
    type Prepared<K: Constant> = PairConstants<PreparedOf<H, A, K>, PreparedOf<H, B, K>>;
    type Memory<S: Scalar> = CompositionMemory<S, (Vec<MemoryOf<H, A, S>>, Vec<MemoryOf<H, B, S>>)>;
    type Unclocked = Self;
    type CompensatedSum<S: Scalar> = <SchemeOf<H, A> as Scheme<H>>::CompensatedSum<S>;
    type Sum<S: Scalar> = <SchemeOf<H, A> as Scheme<H>>::Sum<S>;

    fn memory(system: &H) -> Self::Memory<f64> {
        let mut parts = (Vec::new(), Vec::new());
        for Substep { part, .. } in W::word().substeps {
            match part {
                BasicMethod::Itself => parts.0.push(SchemeOf::<H, A>::memory(system)),
                BasicMethod::Adjoint => parts.1.push(SchemeOf::<H, B>::memory(system)),
            }
        }
        CompositionMemory::of(parts).with_room(system.degrees(), system.noises())
    }

    fn prepare<K: Constant>(
        system: &H,
        lift: LiftParameter<'_, K>,
        h: K,
    ) -> Result<Self::Prepared<K>, ConfigError> {
        let (word, mut of) = (W::word(), (Vec::new(), Vec::new()));
        for &Substep { part, weight, .. } in &word.substeps {
            match part {
                BasicMethod::Itself => of.0.push(SchemeOf::<H, A>::prepare(system, lift, h * weight)?),
                BasicMethod::Adjoint => of.1.push(SchemeOf::<H, B>::prepare(system, lift, h * weight)?),
            }
        }
        Ok(PairConstants { word, of })
    }

    fn gather<const L: usize>(prepared: [&Self::Prepared<f64>; L]) -> Option<Self::Prepared<Lanes<L>>> {
        let first = gather_all::<H, A, L>(prepared.map(|prepared| &prepared.of.0))?;
        let second = gather_all::<H, B, L>(prepared.map(|prepared| &prepared.of.1))?;
        Some(PairConstants { word: prepared.first()?.word.clone(), of: (first, second) })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        system: &H,
        prepared: &Self::Prepared<K>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let StepArguments { t, h, q, p, dw } = at.lists();
        check_state(system, true, [q.len(), p.len()])?;
        let (firsts, seconds) = &mut memory.parts;
        firsts.resize_with(prepared.of.0.len(), Default::default);
        seconds.resize_with(prepared.of.1.len(), Default::default);
        memory.save(q, p, carry);
        let mut effort = Effort::fast(0);
        let mut failed = FailedLanes::default();
        for &Substep { part, node, weight, number, .. } in &prepared.word.substeps {
            let CompositionMemory { parts: (firsts, seconds), dw: scaled, .. } = &mut *memory;
            scale(dw, weight, scaled);
            let at = StepArguments { t: t + h * node, h: h * weight, q: &mut *q, p: &mut *p, dw: scaled };
            let taken = match part {
                BasicMethod::Itself => {
                    let (prepared, memory) = (&prepared.of.0[number], &mut firsts[number]);
                    SchemeOf::<H, A>::advance::<K, S, C, CAREFUL>(system, prepared, at, memory, carry)
                }
                BasicMethod::Adjoint => {
                    let (prepared, memory) = (&prepared.of.1[number], &mut seconds[number]);
                    SchemeOf::<H, B>::advance::<K, S, C, CAREFUL>(system, prepared, at, memory, carry)
                }
            };
            match taken {
                Ok(taken) => effort = effort.and_block(taken),
                // Failed lanes continue from their current state, and are reset at the end.
                Err(StepFailure::Lanes(lanes)) => failed = failed.or(lanes),
                Err(failure) => {
                    memory.restore(q, p, carry);
                    return Err(failure);
                }
            }
        }
        if failed.is_empty() { Ok(effort) } else { Err(memory.end_in_part(failed, q, p, carry)) }
    }

    fn discrete_lagrangian(system: &H, segment: &Segment<H::Vector>, dw: &[f64]) -> f64 {
        lagrangian::value(segment, dw, system.noises(), || {
            let mut state = State { q: segment.q0.clone(), p: segment.p.clone(), t: segment.t };
            let mut action = 0.0;
            for Substep { part, weight, node, .. } in W::word().substeps {
                state.t = segment.t + node * segment.h;
                let own_dw: Vec<f64> = dw.iter().map(|dw| weight * dw).collect();
                let h = weight * segment.h;
                action += match part {
                    BasicMethod::Itself => follow::<H, SchemeOf<H, A>>(system, &mut state, h, &own_dw)?,
                    BasicMethod::Adjoint => follow::<H, SchemeOf<H, B>>(system, &mut state, h, &own_dw)?,
                };
            }
            Some(SequenceEnd { q: state.q, p: state.p, action })
        })
    }
}

/// Moves the state by one step of the composition, and returns its discrete Lagrangian.
fn follow<H: Hamiltonian, T: Scheme<H>>(
    system: &H,
    state: &mut State<H::Vector>,
    h: f64,
    dw: &[f64],
) -> Option<f64> {
    let before = state.clone();
    let prepared = T::prepare(system, &as_they_are, h).ok()?;
    let mut memory = T::Memory::<f64>::default();
    let at = StepArguments { t: before.t, h, q: state.q.components_mut(), p: state.p.components_mut(), dw };
    anew::advance::<H, T, f64, f64>(system, &prepared, at, &mut memory).ok()?;
    let p = T::step_momentum(system, &before, state, h, dw);
    let segment = Segment { q0: before.q, q1: state.q.clone(), p, t: before.t, h };
    Some(T::discrete_lagrangian(system, &segment, dw))
}
