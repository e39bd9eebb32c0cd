//! Steps of two schemes, one after the other: for any Hamiltonian.

use std::marker::PhantomData;

use super::Composes;
use super::kept::Memory;
use super::lagrangian::{self, Followed};
use super::substeps::{By, Half, Substep, joint_plan, kept_energy, plan};
use crate::algebra::carry::Carry;
use crate::algebra::lanes::Lanes;
use crate::algebra::memory::StepMemory;
use crate::algebra::scalar::{Constant, Over, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state::{State, Vector};
use crate::error::{ConfigError, FailedLanes, StepFailure};
use crate::scheme::plan::{KeptEnergy, Plan};
use crate::scheme::system::{
    At, Discretized, Hamiltonian, Lift, MemoryOf, PreparedOf, Properties, Scheme, SchemeOf, Segment, anew,
    as_they_are, fits,
};

/// Steps `W` of the schemes `A` and `B`, which may be the same.
#[derive(Clone, Copy, Debug)]
pub struct Pair<A, B, W>(PhantomData<(A, B, W)>);

/// The prepared parts of a step.
#[derive(Clone, Debug)]
pub struct Prepared<A, B> {
    parts: Vec<Part<A, B>>,
    /// Number of parts of each kind.
    counts: [usize; 2],
}

/// A part of a step: it starts after the fraction `start` of the step, and is the fraction `weight` of it.
#[derive(Clone, Debug)]
struct Part<A, B> {
    start: f64,
    weight: f64,
    kind: Kind<A, B>,
}

#[derive(Clone, Debug)]
enum Kind<A, B> {
    First(A),
    Second(B),
}

/// Number of parts of each kind.
fn counts(substeps: &[Substep]) -> [usize; 2] {
    let first = substeps.iter().filter(|(half, _)| *half == Half::First).count();
    [first, substeps.len() - first]
}

fn rooms<M>(count: usize, room: &dyn Fn() -> M) -> Vec<M> {
    (0..count).map(|_| room()).collect()
}

impl<A, B> Kind<A, B> {
    fn first(&self) -> Option<&A> {
        if let Self::First(first) = self { Some(first) } else { None }
    }

    fn second(&self) -> Option<&B> {
        if let Self::Second(second) = self { Some(second) } else { None }
    }
}

/// A part of the prepared data of each lane; `None` if a lane has none.
fn lanes<P, T, const L: usize>(prepared: [&P; L], part: impl Fn(&P) -> Option<&T>) -> Option<[&T; L]> {
    let parts: Vec<&T> = prepared.into_iter().map(part).collect::<Option<_>>()?;
    parts.try_into().ok()
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn scale<S: Scalar>(dw: &[S], weight: f64, into: &mut Vec<S>) {
    into.clear();
    into.extend(dw.iter().map(|dw| *dw * weight));
}

impl<A, B> Prepared<A, B> {
    /// Takes all parts of a step by `take_first` and `take_second`. On `Err`, everything is as it was.
    ///
    /// # Errors
    /// That of the first part that fails.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: Scalar, C: Carry<S>, M: StepMemory, N: StepMemory>(
        &self,
        At { t, h, q, p, dw }: At<'_, S, K>,
        memory: &mut Memory<S, (Vec<M>, Vec<N>)>,
        carry: &mut C,
        take_first: impl Fn(&A, At<'_, S, K>, &mut M, &mut C) -> Result<Effort, StepFailure>,
        take_second: impl Fn(&B, At<'_, S, K>, &mut N, &mut C) -> Result<Effort, StepFailure>,
    ) -> Result<Effort, StepFailure> {
        let (firsts, seconds) = &mut memory.parts;
        if [firsts.len(), seconds.len()] != self.counts {
            firsts.resize_with(self.counts[0], M::default);
            seconds.resize_with(self.counts[1], N::default);
        }
        memory.save(q, p, carry);
        let mut effort = Effort::fast(0);
        let (mut first, mut second, mut failed) = (0, 0, FailedLanes::default());
        for part in &self.parts {
            let Memory { parts: (firsts, seconds), dw: scaled, .. } = &mut *memory;
            scale(dw, part.weight, scaled);
            let (t, h) = (t + h * part.start, h * part.weight);
            let at = At { t, h, q: &mut *q, p: &mut *p, dw: scaled };
            let taken = match &part.kind {
                Kind::First(prepared) => {
                    first += 1;
                    take_first(prepared, at, &mut firsts[first - 1], carry)
                }
                Kind::Second(prepared) => {
                    second += 1;
                    take_second(prepared, at, &mut seconds[second - 1], carry)
                }
            };
            match taken {
                Ok(taken) => effort = effort.beside(taken),
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
}

impl<H, A, B, E, T, W> Scheme<H> for Pair<A, B, By<E, T, W>>
where
    H: Discretized<A> + Discretized<B>,
    W: Composes<E, T>,
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
            ..Properties::of(&<Self as Scheme<H>>::PLAN, 0)
        }
    };
    type Prepared<K: Constant> = Prepared<PreparedOf<H, A, K>, PreparedOf<H, B, K>>;
    type Memory<S: Scalar> = Memory<S, (Vec<MemoryOf<H, A, S>>, Vec<MemoryOf<H, B, S>>)>;
    type Compensated<S: Scalar> = <SchemeOf<H, A> as Scheme<H>>::Compensated<S>;
    type Carry<S: Scalar> = <SchemeOf<H, A> as Scheme<H>>::Carry<S>;

    fn memory(system: &H) -> Self::Memory<f64> {
        let [first, second] = counts(&W::substeps());
        let first = rooms(first, &|| SchemeOf::<H, A>::memory(system));
        let second = rooms(second, &|| SchemeOf::<H, B>::memory(system));
        Memory::of((first, second)).with_room(system.degrees(), system.noises())
    }

    fn prepare<K: Constant>(system: &H, lift: Lift<'_, K>, h: K) -> Result<Self::Prepared<K>, ConfigError> {
        let (mut start, substeps) = (0.0, W::substeps());
        let parts = substeps.iter().map(|&(half, weight)| {
            let kind = match half {
                Half::First => Kind::First(SchemeOf::<H, A>::prepare(system, lift, h * weight)?),
                Half::Second => Kind::Second(SchemeOf::<H, B>::prepare(system, lift, h * weight)?),
            };
            let part = Part { start, weight, kind };
            start += weight;
            Ok(part)
        });
        Ok(Prepared { parts: parts.collect::<Result<_, _>>()?, counts: counts(&substeps) })
    }

    fn gather<const L: usize>(prepared: [&Self::Prepared<f64>; L]) -> Option<Self::Prepared<Lanes<L>>> {
        let first = prepared.first()?;
        let parts = first.parts.iter().enumerate().map(|(index, Part { start, weight, kind })| {
            let kind = match kind {
                Kind::First(_) => {
                    let of_lanes = lanes(prepared, |prepared| prepared.parts.get(index)?.kind.first())?;
                    Kind::First(SchemeOf::<H, A>::gather(of_lanes)?)
                }
                Kind::Second(_) => {
                    let of_lanes = lanes(prepared, |prepared| prepared.parts.get(index)?.kind.second())?;
                    Kind::Second(SchemeOf::<H, B>::gather(of_lanes)?)
                }
            };
            Some(Part { start: *start, weight: *weight, kind })
        });
        Some(Prepared { parts: parts.collect::<Option<_>>()?, counts: first.counts })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: Over<K>, C: Carry<S>, const CAREFUL: bool>(
        system: &H,
        prepared: &Self::Prepared<K>,
        at: At<'_, S, K>,
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let [expected, got] = [at.q.len(), at.p.len()];
        if !fits(system, expected) || got != expected {
            return Err(StepFailure::Dimension { expected: system.degrees().max(expected), got });
        }
        prepared.advance(
            at,
            memory,
            carry,
            |prepared, at, memory, carry| {
                SchemeOf::<H, A>::advance::<K, S, C, CAREFUL>(system, prepared, at, memory, carry)
            },
            |prepared, at, memory, carry| {
                SchemeOf::<H, B>::advance::<K, S, C, CAREFUL>(system, prepared, at, memory, carry)
            },
        )
    }

    fn discrete_lagrangian(system: &H, segment: &Segment<H::Vector>, dw: &[f64]) -> f64 {
        lagrangian::value(segment, dw, system.noises(), || {
            let mut state = State { q: segment.q0.clone(), p: segment.p.clone(), t: segment.t };
            let (mut action, mut start) = (0.0, 0.0);
            for (half, weight) in W::substeps() {
                state.t = segment.t + start * segment.h;
                let own_dw: Vec<f64> = dw.iter().map(|dw| weight * dw).collect();
                let h = weight * segment.h;
                action += match half {
                    Half::First => part::<H, SchemeOf<H, A>>(system, &mut state, h, &own_dw)?,
                    Half::Second => part::<H, SchemeOf<H, B>>(system, &mut state, h, &own_dw)?,
                };
                start += weight;
            }
            Some(Followed { q: state.q, p: state.p, action })
        })
    }
}

/// Moves the state by one part, and returns its discrete Lagrangian.
fn part<H: Hamiltonian, T: Scheme<H>>(
    system: &H,
    state: &mut State<H::Vector>,
    h: f64,
    dw: &[f64],
) -> Option<f64> {
    let before = state.clone();
    let prepared = T::prepare(system, &as_they_are, h).ok()?;
    let mut memory = T::Memory::<f64>::default();
    let at = At { t: before.t, h, q: state.q.components_mut(), p: state.p.components_mut(), dw };
    anew::advance::<H, T, f64, f64>(system, &prepared, at, &mut memory).ok()?;
    let p = T::step_momentum(system, &before, state, h, dw);
    let segment = Segment { q0: before.q, q1: state.q.clone(), p, t: before.t, h };
    Some(T::discrete_lagrangian(system, &segment, dw))
}
