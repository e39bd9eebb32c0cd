//! Steps of two schemes, one after the other: for any Hamiltonian.

use std::marker::PhantomData;

use super::kept::Memory;
use super::sequence::{Followed, Half, Sequence, Substep, joint_plan};
use crate::carry::{Carry, Plain};
use crate::error::{ConfigError, FailedLanes, StepFailure};
use crate::lanes::Lanes;
use crate::memory::StepMemory;
use crate::plan::{KeptEnergy, Plan};
use crate::scalar::Scalar;
use crate::solve::Effort;
use crate::state::{State, Vector};
use crate::system::{Discretized, Segment};

/// Steps of `A` and of `B`, which may be one.
#[derive(Clone, Copy, Debug)]
pub struct Pair<A, B>(PhantomData<(A, B)>);

/// What is prepared for each part of a step.
#[derive(Clone, Debug)]
pub struct Prepared<A, B> {
    parts: Vec<Part<A, B>>,
    /// How many parts are of which kind.
    counts: [usize; 2],
}

/// A part of a step: it starts after the fraction `start` of the step, and is the fraction `weight` of it.
#[derive(Clone, Debug)]
struct Part<A, B> {
    start: f64,
    weight: f64,
    scheme: Scheme<A, B>,
}

#[derive(Clone, Debug)]
enum Scheme<A, B> {
    First(A),
    Second(B),
}

/// How many parts are of which kind.
fn counts(substeps: &[Substep]) -> [usize; 2] {
    let first = substeps.iter().filter(|(half, _)| *half == Half::First).count();
    [first, substeps.len() - first]
}

impl<A, B> Scheme<A, B> {
    fn first(&self) -> Option<&A> {
        if let Self::First(first) = self { Some(first) } else { None }
    }

    fn second(&self) -> Option<&B> {
        if let Self::Second(second) = self { Some(second) } else { None }
    }
}

/// A part of what is prepared for each lane; `None` if one has none.
fn lanes<P, T, const L: usize>(prepared: [&P; L], part: impl Fn(&P) -> Option<&T>) -> Option<[&T; L]> {
    let parts: Vec<&T> = prepared.into_iter().map(part).collect::<Option<_>>()?;
    parts.try_into().ok()
}

impl<A, B> Prepared<A, B> {
    /// All parts of a step from `t` on, of size `h`, by what takes one of each kind. On `Err`, everything is as it was.
    ///
    /// # Errors
    /// That of the first part that has one.
    #[expect(clippy::too_many_arguments, reason = "as `Discretized::advance_carrying`")]
    #[inline(always)]
    fn advance<S: Scalar, C: Carry<S>, M: StepMemory, N: StepMemory>(
        &self,
        [t, h]: [f64; 2],
        q: &mut [S],
        p: &mut [S],
        dw: &[S],
        memory: &mut Memory<S, M, N>,
        carry: &mut C,
        take_first: impl Fn(&A, [f64; 2], &mut [S], &mut [S], &[S], &mut M, &mut C) -> Result<Effort, StepFailure>,
        take_second: impl Fn(
            &B,
            [f64; 2],
            &mut [S],
            &mut [S],
            &[S],
            &mut N,
            &mut C,
        ) -> Result<Effort, StepFailure>,
    ) -> Result<Effort, StepFailure> {
        memory.save(self.counts, q, p, dw, carry);
        let mut effort = Effort::fast(0);
        let (mut first, mut second, mut failed) = (0, 0, FailedLanes::default());
        for part in &self.parts {
            let Memory { first: firsts, second: seconds, dw: scaled, .. } = &mut *memory;
            for (scaled, dw) in scaled.iter_mut().zip(dw) {
                *scaled = *dw * part.weight;
            }
            let time = [t + part.start * h, part.weight * h];
            let taken = match &part.scheme {
                Scheme::First(scheme) => {
                    first += 1;
                    take_first(scheme, time, q, p, scaled, &mut firsts[first - 1], carry)
                }
                Scheme::Second(scheme) => {
                    second += 1;
                    take_second(scheme, time, q, p, scaled, &mut seconds[second - 1], carry)
                }
            };
            match taken {
                Ok(taken) => effort = effort.beside(taken),
                // Lanes that could not take a part go on from where they are, and end where they started.
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

impl<H, A, B> Sequence<H> for Pair<A, B>
where
    H: Discretized<A> + Discretized<B>,
{
    const PLAN: Plan = joint_plan(<H as Discretized<A>>::PLAN, <H as Discretized<B>>::PLAN);
    const KEPT_ENERGY: KeptEnergy =
        match (<H as Discretized<A>>::KEPT_ENERGY, <H as Discretized<B>>::KEPT_ENERGY) {
            (KeptEnergy::Point(_), KeptEnergy::Point(_)) => KeptEnergy::KickDriftKick,
            _ => KeptEnergy::Hamiltonian,
        };
    const REMEMBERS: bool = <H as Discretized<A>>::REMEMBERS || <H as Discretized<B>>::REMEMBERS;
    const IN_LANES: bool = <H as Discretized<A>>::IN_LANES && <H as Discretized<B>>::IN_LANES;
    type Prepared = Prepared<<H as Discretized<A>>::Prepared, <H as Discretized<B>>::Prepared>;
    type Memory<S: Scalar> = Memory<S, <H as Discretized<A>>::Memory<S>, <H as Discretized<B>>::Memory<S>>;
    type Compensated<S: Scalar> = <H as Discretized<A>>::Compensated<S>;
    type Carry<S: Scalar> = <H as Discretized<A>>::Carry<S>;

    fn memory(system: &H, substeps: &[Substep]) -> Self::Memory<f64> {
        let [first, second] = counts(substeps);
        Memory::of(
            (0..first).map(|_| Discretized::<A>::memory(system)).collect(),
            (0..second).map(|_| Discretized::<B>::memory(system)).collect(),
        )
        .with_room(system.degrees(), system.noises())
    }

    fn prepare(system: &H, h: f64, substeps: &[Substep]) -> Result<Self::Prepared, ConfigError> {
        let mut start = 0.0;
        let parts = substeps.iter().map(|&(half, weight)| {
            let scheme = match half {
                Half::First => Scheme::First(Discretized::<A>::prepare(system, weight * h)?),
                Half::Second => Scheme::Second(Discretized::<B>::prepare(system, weight * h)?),
            };
            let part = Part { start, weight, scheme };
            start += weight;
            Ok(part)
        });
        Ok(Prepared { parts: parts.collect::<Result<_, _>>()?, counts: counts(substeps) })
    }

    #[inline(always)]
    fn advance<S: Scalar, C: Carry<S>, const CAREFUL: bool>(
        system: &H,
        prepared: &Self::Prepared,
        t: f64,
        h: f64,
        q: &mut [S],
        p: &mut [S],
        dw: &[S],
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let [expected, got] = [q.len(), p.len()];
        if !system.fits(expected) || got != expected {
            return Err(StepFailure::Dimension { expected: system.degrees().max(expected), got });
        }
        prepared.advance(
            [t, h],
            q,
            p,
            dw,
            memory,
            carry,
            |prepared, [t, h], q, p, dw, memory, carry| {
                Discretized::<A>::advance_carrying::<S, C, CAREFUL>(
                    system, prepared, t, h, q, p, dw, memory, carry,
                )
            },
            |prepared, [t, h], q, p, dw, memory, carry| {
                Discretized::<B>::advance_carrying::<S, C, CAREFUL>(
                    system, prepared, t, h, q, p, dw, memory, carry,
                )
            },
        )
    }

    type Beside<const L: usize> =
        Prepared<<H as Discretized<A>>::Beside<L>, <H as Discretized<B>>::Beside<L>>;

    fn beside<const L: usize>(systems: [&H; L], prepared: [&Self::Prepared; L]) -> Option<Self::Beside<L>> {
        let first = prepared.first()?;
        let parts = first.parts.iter().enumerate().map(|(index, Part { start, weight, scheme })| {
            let scheme = match scheme {
                Scheme::First(_) => {
                    let of_lanes = lanes(prepared, |prepared| prepared.parts.get(index)?.scheme.first())?;
                    Scheme::First(<H as Discretized<A>>::beside(systems, of_lanes)?)
                }
                Scheme::Second(_) => {
                    let of_lanes = lanes(prepared, |prepared| prepared.parts.get(index)?.scheme.second())?;
                    Scheme::Second(<H as Discretized<B>>::beside(systems, of_lanes)?)
                }
            };
            Some(Part { start: *start, weight: *weight, scheme })
        });
        Some(Prepared { parts: parts.collect::<Option<_>>()?, counts: first.counts })
    }

    #[inline(always)]
    fn advance_beside<const L: usize>(
        beside: &Self::Beside<L>,
        t: f64,
        h: f64,
        q: &mut [Lanes<L>],
        p: &mut [Lanes<L>],
        dw: &[Lanes<L>],
        memory: &mut Self::Memory<Lanes<L>>,
    ) -> Result<Effort, StepFailure> {
        let [expected, got] = [q.len(), p.len()];
        if got != expected {
            return Err(StepFailure::Dimension { expected, got });
        }
        beside.advance(
            [t, h],
            q,
            p,
            dw,
            memory,
            &mut Plain,
            |beside, [t, h], q, p, dw, memory, _| {
                <H as Discretized<A>>::advance_beside(beside, t, h, q, p, dw, memory)
            },
            |beside, [t, h], q, p, dw, memory, _| {
                <H as Discretized<B>>::advance_beside(beside, t, h, q, p, dw, memory)
            },
        )
    }

    fn follow(
        system: &H,
        segment: &Segment<H::Vector>,
        dw: &[f64],
        substeps: &[Substep],
    ) -> Option<Followed<H::Vector>> {
        let mut state = State { q: segment.q0.clone(), p: segment.p.clone(), t: segment.t };
        let (mut action, mut start) = (0.0, 0.0);
        for &(half, weight) in substeps {
            state.t = segment.t + start * segment.h;
            let own_dw: Vec<f64> = dw.iter().map(|dw| weight * dw).collect();
            let h = weight * segment.h;
            action += match half {
                Half::First => part::<H, A>(system, &mut state, h, &own_dw)?,
                Half::Second => part::<H, B>(system, &mut state, h, &own_dw)?,
            };
            start += weight;
        }
        Some(Followed { q: state.q, p: state.p, action })
    }
}

/// Moves the state by one part, and gives its discrete Lagrangian.
fn part<H: Discretized<E>, E>(system: &H, state: &mut State<H::Vector>, h: f64, dw: &[f64]) -> Option<f64> {
    let before = state.clone();
    let prepared = system.prepare(h).ok()?;
    let mut memory = H::Memory::<f64>::default();
    let (q, p) = (state.q.components_mut(), state.p.components_mut());
    system.advance::<f64>(&prepared, before.t, h, q, p, dw, &mut memory).ok()?;
    let momentum = system.step_momentum(&before, state, h, dw);
    let segment = Segment { q0: before.q, q1: state.q.clone(), p: momentum, t: before.t, h };
    Some(system.discrete_lagrangian(&segment, dw))
}
