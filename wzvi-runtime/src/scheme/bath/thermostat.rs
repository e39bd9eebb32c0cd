//! O parts around the steps of any scheme: [`Thermostat`](super::Thermostat).
//!
//! It is of the order that `E` has, but not above 2.

use std::marker::PhantomData;

use super::modes::Decay;
use super::part::{self, BathLaw, OPartShares, OParts, normals};
use super::{Damped, with_bath};
use crate::algebra::lanes::Lanes;
use crate::algebra::scalar::{ComputesWith, Constant, Scalar};
use crate::algebra::solve::Effort;
use crate::algebra::state_sum::StateSum;
use crate::error::{ConfigError, FailedLanes, StepFailure};
use crate::scheme::compose::memory;
use crate::scheme::elements::{Elements, are_finite};
use crate::scheme::plan::Plan;
use crate::scheme::system::{
    Discretized, Exchange, LiftParameter, MemoryOf, Movable, PreparedOf, Properties, Scheme, SchemeOf,
    StepArguments, check_state,
};

/// The O parts before and after a step.
const SHARES: OPartShares = OPartShares { parts: 2, decay: Decay::Exponential, is_shortened: false };

/// Steps of `E`, of the system without its bath, between two O parts.
#[derive(Clone, Copy, Debug)]
pub struct ThermostatSteps<E>(PhantomData<E>);

/// The constants of steps.
#[derive(Clone, Debug)]
pub struct ThermostatConstants<M, K> {
    step: M,
    relaxation: BathLaw<K>,
}

/// As far as the plan of `E` says.
impl<T: Elements + Discretized<E>, E> Scheme<T> for ThermostatSteps<E> {
    const PLAN: Plan = with_bath(<SchemeOf<T, E> as Scheme<T>>::PLAN);
    const PROPERTIES: Properties = Properties {
        remembers: <T as Discretized<E>>::PROPERTIES.remembers,
        in_lanes: <T as Discretized<E>>::PROPERTIES.in_lanes,
        exchanges: true,
        has_temperatures: Damped::<T>::FRICTION.has_temperatures,
        is_variational: false,
        ..Properties::of(&<Self as Scheme<T>>::PLAN, 0)
    };
    type Prepared<K: Constant> = ThermostatConstants<PreparedOf<T, E, K>, K>;
    /// The memory of the inner step, with the state before the whole step, and that of the O parts.
    type Memory<S: Scalar> = (memory::CompositionMemory<S, MemoryOf<T, E, S>>, part::BathMemory<S>);
    type Unclocked = Self;
    type CompensatedSum<S: Scalar> = <SchemeOf<T, E> as Scheme<T>>::CompensatedSum<S>;
    type Sum<S: Scalar> = <SchemeOf<T, E> as Scheme<T>>::Sum<S>;

    fn increments(system: &T, degrees: usize) -> usize {
        SchemeOf::<T, E>::increments(system, degrees) + normals::<T>(degrees, SHARES.parts)
    }

    fn exchanged(system: &T, (kept, bath): &Self::Memory<f64>) -> Exchange {
        let mut exchange = Exchange { work: 0.0, heat: bath.heat };
        exchange += SchemeOf::<T, E>::exchanged(system, &kept.parts);
        exchange
    }

    fn heats((_, bath): &Self::Memory<f64>) -> &[f64] {
        &bath.heats
    }

    fn temperature(system: &T) -> Option<f64> {
        part::temperature(system)
    }

    fn memory(system: &T) -> Self::Memory<f64> {
        let (step, degrees) = (SchemeOf::<T, E>::memory(system), Elements::degrees(system));
        (memory::CompositionMemory::of(step).with_room(degrees, 0), part::BathMemory::of_system(system))
    }

    fn prepare<K: Constant>(
        system: &T,
        lift: LiftParameter<'_, K>,
        h: K,
    ) -> Result<Self::Prepared<K>, ConfigError> {
        let relaxation = part::prepare(system, lift, h, SHARES)?;
        Ok(ThermostatConstants { step: SchemeOf::<T, E>::prepare(system, lift, h)?, relaxation })
    }

    fn gather<const L: usize>(prepared: [&Self::Prepared<f64>; L]) -> Option<Self::Prepared<Lanes<L>>> {
        let relaxation = part::gather(prepared.map(|prepared| &prepared.relaxation))?;
        let step = SchemeOf::<T, E>::gather(prepared.map(|prepared| &prepared.step))?;
        Some(ThermostatConstants { step, relaxation })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance<K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
        system: &T,
        prepared: &Self::Prepared<K>,
        at: StepArguments<'_, S, K, impl Movable<S> + ?Sized>,
        (kept, bath): &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let StepArguments { t, h, q, p, dw } = at.lists();
        let degrees = q.len();
        check_state(system, true, [degrees, p.len()])?;
        let noises = SchemeOf::<T, E>::increments(system, degrees);
        let size = ([t, h], SHARES, degrees);
        let mut parts = bath.parts(system, &prepared.relaxation, size, (dw, noises))?;
        kept.save(q, p, carry);
        let at = StepArguments { t, h, q: &mut *q, p: &mut *p, dw: &dw[..noises] };
        match between::<T, E, K, S, C, CAREFUL>(system, &prepared.step, &mut parts, at, kept, carry) {
            Ok((effort, heat, failed)) if failed.is_empty() => {
                bath.heat = heat;
                Ok(effort)
            }
            Ok((_, _, failed)) => Err(kept.end_in_part(failed, q, p, carry)),
            Err(failure) => {
                kept.restore(q, p, carry);
                Err(failure)
            }
        }
    }
}

/// A step between its O parts, the heat of both, and the lanes that it failed in.
#[cfg_attr(not(debug_assertions), inline(always))]
fn between<T, E, K: Constant, S: ComputesWith<K>, C: StateSum<S>, const CAREFUL: bool>(
    system: &T,
    prepared: &PreparedOf<T, E, K>,
    parts: &mut OParts<'_, T, K, S>,
    StepArguments { t, h, q, p, dw }: StepArguments<'_, S, K>,
    kept: &mut memory::CompositionMemory<S, MemoryOf<T, E, S>>,
    carry: &mut C,
) -> Result<(Effort, S, FailedLanes), StepFailure>
where
    T: Elements + Discretized<E>,
{
    let before = relax(parts, 0, q, p, &mut kept.carried, carry)?;
    let at = StepArguments { t, h, q: &mut *q, p: &mut *p, dw };
    let taken = SchemeOf::<T, E>::advance::<K, S, C, CAREFUL>(system, prepared, at, &mut kept.parts, carry);
    let (effort, failed) = match taken {
        Ok(effort) => (effort, FailedLanes::default()),
        Err(StepFailure::Lanes(failed)) => (Effort::fast(0), failed),
        Err(failure) => return Err(failure),
    };
    let after = relax(parts, 1, q, p, &mut kept.carried, carry)?;
    if are_finite(p) { Ok((effort, before + after, failed)) } else { Err(StepFailure::NonFinite) }
}

/// Applies an O part to a state, with compensation.
#[cfg_attr(not(debug_assertions), inline(always))]
fn relax<T: Elements, K: Constant, S: ComputesWith<K>, C: StateSum<S>>(
    parts: &mut OParts<'_, T, K, S>,
    part: usize,
    q: &mut [S],
    p: &mut [S],
    [lost_q, lost_p]: &mut [Vec<S>; 2],
    carry: &mut C,
) -> Result<S, StepFailure> {
    if C::CARRIES {
        memory::list_carried(carry, q.len(), [lost_q, lost_p]);
    }
    let heat = parts.apply::<C>(part, None, [q, p, lost_p])?;
    if C::CARRIES {
        carry.keep(lost_q, lost_p);
    }
    Ok(heat)
}
