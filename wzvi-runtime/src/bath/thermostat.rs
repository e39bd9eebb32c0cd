//! O parts around the steps of any scheme: [`Thermostat`](super::Thermostat).
//!
//! Generated, for a system with [`Damped`] and `Discretized<I>`, where `I` steps its Hamiltonians and forces without friction:
//! `composition! { [impl Discretized<Thermostat<E>> for System] Thermostat<E>, Around<I>, 1, "text", [] }`. It is of the order that `I` has, but not above 2.

use std::fmt::Debug;
use std::marker::PhantomData;

use super::beside::Baths;
use super::modes::Decay;
use super::part::{self, Relaxes, Shares, normals};
use super::relaxation::is_list;
use super::{Damped, Relaxation, with_bath};
use crate::carry::{Carry, Plain};
use crate::compose::kept;
use crate::compose::sequence::{Followed, Sequence, Substep};
use crate::elements::are_finite;
use crate::error::{ConfigError, FailedLanes, StepFailure};
use crate::lanes::Lanes;
use crate::memory::{Iteration, Method, StepMemory, Threads};
use crate::numbers::{Numbers, Tape};
use crate::plan::Plan;
use crate::scalar::Scalar;
use crate::solve::Effort;
use crate::system::{Discretized, Exchange, Segment};

/// O parts in front of and behind a step.
const SHARES: Shares = Shares { parts: 2, decay: Decay::Exponential };

/// Steps of `E`, of the system without its bath, between two O parts.
#[derive(Clone, Copy, Debug)]
pub struct Around<E>(PhantomData<E>);

/// What is computed once.
#[derive(Clone, Debug)]
pub struct Prepared<M> {
    step: M,
    relaxation: Option<Relaxation>,
}

/// What a step leaves.
#[derive(Debug)]
pub struct Memory<S: Scalar, M> {
    /// That of the step between, and the state before it all.
    kept: kept::Memory<S, M, ()>,
    /// What is carried for coordinates and momenta.
    lost: [Vec<S>; 2],
    bath: part::Memory<S>,
}

impl<S: Scalar, M> Memory<S, M> {
    fn of(kept: kept::Memory<S, M, ()>) -> Self {
        Self { kept, lost: [Vec::new(), Vec::new()], bath: Default::default() }
    }
}

impl<S: Scalar, M> Default for Memory<S, M> {
    fn default() -> Self {
        Self::of(Default::default())
    }
}

/// What the steps before left; scratch is allocated anew where the copy is used.
impl<S: Scalar, M: Clone> Clone for Memory<S, M> {
    fn clone(&self) -> Self {
        Self::of(self.kept.clone())
    }
}

impl<S: Scalar, M: Numbers + Default> Numbers for Memory<S, M> {
    fn pass(&mut self, tape: &mut Tape) {
        self.kept.pass(tape);
    }
}

impl<S: Scalar, M: StepMemory> StepMemory for Memory<S, M> {
    fn forget(&mut self) {
        self.kept.forget();
    }

    fn hold(&mut self) {
        self.kept.hold();
    }

    fn adopt(&mut self, left: Self) {
        self.kept.adopt(left.kept);
        self.bath.heat = left.bath.heat;
    }

    fn pin(&mut self, iteration: Iteration) {
        self.kept.pin(iteration);
    }

    fn share(&mut self, threads: Threads) {
        self.kept.share(threads);
    }

    fn pinned(&self) -> Iteration {
        self.kept.pinned()
    }

    fn method(&self) -> Option<Method> {
        self.kept.method()
    }
}

impl<T: Damped + Discretized<E>, E> Sequence<T> for Around<E> {
    const PLAN: Plan = with_bath(<T as Discretized<E>>::PLAN);
    const REMEMBERS: bool = <T as Discretized<E>>::REMEMBERS;
    const IN_LANES: bool = <T as Discretized<E>>::IN_LANES;
    // As far as the plan of `E` says.
    const IS_SYMMETRIC: bool = false;
    const IS_VARIATIONAL: bool = false;
    const EXCHANGES: bool = true;
    type Prepared = Prepared<<T as Discretized<E>>::Prepared>;
    type Memory<S: Scalar> = Memory<S, <T as Discretized<E>>::Memory<S>>;
    type Compensated<S: Scalar> = <T as Discretized<E>>::Compensated<S>;
    type Carry<S: Scalar> = <T as Discretized<E>>::Carry<S>;

    fn increments(system: &T, degrees: usize) -> usize {
        Discretized::<E>::increments(system, degrees) + normals(system, degrees, SHARES.parts)
    }

    fn exchanged(system: &T, memory: &Self::Memory<f64>) -> Exchange {
        let mut exchange = Exchange { work: 0.0, heat: memory.bath.heat };
        if let Some(step) = memory.kept.first.first() {
            exchange += Discretized::<E>::exchanged(system, step);
        }
        exchange
    }

    fn memory(system: &T, _: &[Substep]) -> Self::Memory<f64> {
        let (step, degrees) = (Discretized::<E>::memory(system), system.degrees());
        Memory {
            kept: kept::Memory::of(vec![step], Vec::new()).with_room(degrees, system.noises()),
            lost: std::array::from_fn(|_| Vec::with_capacity(degrees)),
            bath: part::Memory::of_system(system),
        }
    }

    fn prepare(system: &T, h: f64, _: &[Substep]) -> Result<Self::Prepared, ConfigError> {
        let relaxation = part::prepare(system, h, SHARES)?;
        Ok(Prepared { step: Discretized::<E>::prepare(system, h)?, relaxation })
    }

    #[inline(always)]
    fn advance<S: Scalar, C: Carry<S>, const CAREFUL: bool>(
        system: &T,
        prepared: &Self::Prepared,
        t: f64,
        h: f64,
        q: &mut [S],
        p: &mut [S],
        dw: &[S],
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let (degrees, got) = (q.len(), p.len());
        if !system.fits(degrees) {
            system.check(degrees)?;
        }
        if got != degrees {
            return Err(StepFailure::Dimension { expected: degrees, got });
        }
        let Memory { kept, lost, bath } = memory;
        let noises = Discretized::<E>::increments(system, degrees);
        let size = (h, SHARES, degrees);
        let mut parts = bath.parts(system, &prepared.relaxation, size, (dw, noises))?;
        let (effort, heat) = between(&mut parts, [q, p], (kept, lost), carry, |[q, p], memory, carry| {
            let (prepared, dw) = (&prepared.step, &dw[..noises]);
            Discretized::<E>::advance_carrying::<S, C, CAREFUL>(
                system, prepared, t, h, q, p, dw, memory, carry,
            )
        })?;
        bath.heat = heat;
        Ok(effort)
    }

    type Beside<const L: usize> = Beside<<T as Discretized<E>>::Beside<L>, L>;

    fn beside<const L: usize>(systems: [&T; L], prepared: [&Self::Prepared; L]) -> Option<Self::Beside<L>> {
        if !is_list::<T>() || T::PER_STATE {
            return None;
        }
        let relaxations = prepared.map(|prepared| &prepared.relaxation);
        let noises = |system: &T| Discretized::<E>::increments(system, system.degrees());
        let baths = Baths::new(systems, relaxations, noises)?;
        let step = Discretized::<E>::beside(systems, prepared.map(|prepared| &prepared.step))?;
        Some(Beside { step, baths })
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
        let (expected, got) = (q.len(), p.len());
        if got != expected {
            return Err(StepFailure::Dimension { expected, got });
        }
        let (dw, mut parts) = beside.baths.parts(SHARES.parts, dw)?;
        let Memory { kept, lost, .. } = memory;
        let taken = between(&mut parts, [q, p], (kept, lost), &mut Plain, |[q, p], memory, _| {
            <T as Discretized<E>>::advance_beside(&beside.step, t, h, q, p, dw, memory)
        })?;
        Ok(taken.0)
    }

    fn follow(_: &T, _: &Segment<T::Vector>, _: &[f64], _: &[Substep]) -> Option<Followed<T::Vector>> {
        None
    }
}

/// What a step of `L` systems beside each other reads of them.
pub struct Beside<B, const L: usize> {
    step: B,
    baths: Baths<L>,
}

/// A step between its O parts, and the heat of both; a step that fails changes nothing.
#[inline(always)]
fn between<S: Scalar, C: Carry<S>, M: StepMemory>(
    parts: &mut impl Relaxes<S>,
    [q, p]: [&mut [S]; 2],
    (kept, lost): (&mut kept::Memory<S, M, ()>, &mut [Vec<S>; 2]),
    carry: &mut C,
    step: impl FnOnce([&mut [S]; 2], &mut M, &mut C) -> Result<Effort, StepFailure>,
) -> Result<(Effort, S), StepFailure> {
    kept.save([1, 0], q, p, &[], carry);
    let all = |kept: &mut kept::Memory<S, M, ()>, carry: &mut C| {
        let before = relax(parts, 0, q, p, lost, carry)?;
        let (effort, failed) = match step([&mut *q, &mut *p], &mut kept.first[0], carry) {
            Ok(effort) => (effort, FailedLanes::default()),
            Err(StepFailure::Lanes(failed)) => (Effort::fast(0), failed),
            Err(failure) => return Err(failure),
        };
        let after = relax(parts, 1, q, p, lost, carry)?;
        if are_finite(p) { Ok((effort, before + after, failed)) } else { Err(StepFailure::NonFinite) }
    };
    match all(kept, carry) {
        Ok((effort, heat, failed)) if failed.is_empty() => Ok((effort, heat)),
        Ok((_, _, failed)) => Err(kept.end_in_part(failed, q, p, carry)),
        Err(failure) => {
            kept.restore(q, p, carry);
            Err(failure)
        }
    }
}

/// An O part of a state, with what is carried for it.
#[inline(always)]
fn relax<S: Scalar, C: Carry<S>>(
    parts: &mut impl Relaxes<S>,
    part: usize,
    q: &[S],
    p: &mut [S],
    [lost_q, lost_p]: &mut [Vec<S>; 2],
    carry: &mut C,
) -> Result<S, StepFailure> {
    if C::CARRIES {
        kept::list_carried(carry, q.len(), [lost_q, lost_p]);
    }
    let heat = parts.apply::<C>(part, q, p, lost_p)?;
    if C::CARRIES {
        carry.keep(lost_q, lost_p);
    }
    Ok(heat)
}
