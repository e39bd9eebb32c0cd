//! The O parts of a step: their constants, their normals and their heat.

use std::any::Any;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use super::diagonal::{BLOCK, DiagonalRelaxation};
use super::modes::Decay;
use super::relaxation::{Momenta, RelaxationScratch};
use super::{Damped, Relaxation};
use crate::algebra::lanes::Lanes;
use crate::algebra::memory::step_memory;
use crate::algebra::scalar::{ComputesWith, Constant, Mask as _, Scalar};
use crate::algebra::state_sum::{FixedCompensatedSum, PlainSum, StateSum};
use crate::error::{BathError, ConfigError, StepFailure, StepPromise};
use crate::scheme::elements::{Elements, PairColumns};
use crate::scheme::system::{Hamiltonian as _, LiftParameter, varied_without_lists};

/// The number of O parts of a step, of equal duration, and their decay.
#[derive(Clone, Copy, Debug)]
pub(super) struct OPartShares {
    pub(super) parts: usize,
    pub(super) decay: Decay,
    /// Whether kicks and drifts are shortened by a factor that depends on the rate, of which there is one.
    pub(super) is_shortened: bool,
}

impl OPartShares {
    fn of_one(self) -> (f64, Decay) {
        (1.0 / self.parts as f64, self.decay)
    }
}

/// The rate of all degrees of freedom.
///
/// # Errors
/// [`BathError::Rates`] if they have several, or rates that depend on the state.
pub(super) fn rate<T: Elements, K: Constant>(
    (system, parameters): (&T, &[K]),
    degrees: usize,
) -> Result<K, BathError> {
    let zero = K::from_f64(0.0);
    let (mut rates, friction) = (vec![K::from_f64(f64::NAN); degrees], Damped::<T>::FRICTION);
    if !friction.is_matrix && !friction.is_per_state {
        friction.damping(
            (system, K::varied(parameters)),
            &vec![zero; degrees],
            &mut rates,
            &mut PairColumns::default(),
        );
    }
    let rate = rates.first().copied().unwrap_or(zero);
    let is_one = zero.less_equal(rate).all() && rates.iter().all(|other| other.equal(rate).all());
    if is_one { Ok(rate) } else { Err(BathError::Rates) }
}

/// The constants of the O parts.
#[derive(Clone, Debug)]
pub(super) enum BathLaw<K> {
    /// With all parameters, where these have derivatives.
    Known(Relaxation<K>, Vec<K>),
    /// They follow from the size of the state, and from all parameters, where these have derivatives.
    OfState(Vec<K>),
}

impl<K> BathLaw<K> {
    fn known(&self) -> Option<&Relaxation<K>> {
        if let Self::Known(relaxation, _) = self { Some(relaxation) } else { None }
    }
}

/// The constants of the O parts of steps of size `h`.
///
/// # Errors
/// [`ConfigError::Bath`]
pub(super) fn prepare<T: Elements, K: Constant>(
    system: &T,
    lift: LiftParameter<'_, K>,
    h: K,
    shares: OPartShares,
) -> Result<BathLaw<K>, ConfigError> {
    let (degrees, friction) = (system.degrees(), Damped::<T>::FRICTION);
    let parameters = varied_without_lists(system, lift)?;
    if degrees == 0 {
        if !friction.is_out_of_equilibrium() {
            Relaxation::<f64>::check((system, &[]), friction).map_err(ConfigError::Bath)?;
        }
        return Ok(BathLaw::OfState(parameters));
    }
    let relaxation = Relaxation::new((system, &*parameters), friction, degrees, h, shares.of_one());
    relaxation.map(|relaxation| BathLaw::Known(relaxation, parameters)).map_err(ConfigError::Bath)
}

/// The constants of systems in lanes; `None` if there are none, and where each step has its own temperatures.
pub(super) fn gather<const L: usize>(of_lanes: [&BathLaw<f64>; L]) -> Option<BathLaw<Lanes<L>>> {
    let mut relaxations = [of_lanes.first()?.known()?; L];
    for (relaxation, of_lane) in relaxations.iter_mut().zip(of_lanes) {
        *relaxation = of_lane.known()?;
    }
    Relaxation::gather(relaxations).map(|relaxation| BathLaw::Known(relaxation, Vec::new()))
}

/// The constants for one step size and number of degrees of freedom.
#[derive(Debug)]
struct CachedRelaxation {
    h: f64,
    degrees: usize,
    /// A [`Relaxation`] in the constants of the steps.
    relaxation: Box<dyn Any + Send + Sync>,
}

impl CachedRelaxation {
    #[cold]
    fn new<T: Elements, K: Constant>(
        of: (&T, &[K]),
        degrees: usize,
        h: K,
        shares: OPartShares,
    ) -> Result<Self, StepFailure> {
        let (system, _) = of;
        system.check(degrees)?;
        if shares.is_shortened {
            rate(of, degrees).map_err(StepFailure::Bath)?;
        }
        let relaxation = Relaxation::new(of, Damped::<T>::FRICTION, degrees, h, shares.of_one());
        let relaxation = Box::new(relaxation.map_err(StepFailure::Bath)?);
        Ok(Self { h: h.lane(0), degrees, relaxation })
    }
}

/// The scratch of the O parts, and their heat.
#[derive(Debug, Default)]
pub struct BathMemory<S> {
    own: Option<CachedRelaxation>,
    room: RelaxationScratch<S>,
    driving: BathTemperatures<S>,
    /// The heat of each part, block by block, where a step goes tile by tile.
    blocks: Vec<AtomicU64>,
    /// The heat of each degree of freedom there, if they have temperatures of their own.
    by_degree: Vec<AtomicU64>,
    /// The heat of the last step.
    pub(super) heat: S,
    /// The heat of each degree of freedom in the last step, if they have temperatures of their own; else
    /// empty.
    pub(super) heats: Vec<S>,
}

/// The temperatures of the O parts of a step, if they depend on the time or belong to a friction of the
/// place: for each part the numbers `R / √h` of the degrees of freedom or modes, or the temperatures at its
/// start and those at its end.
#[derive(Debug, Default)]
struct BathTemperatures<S> {
    numbers: Vec<S>,
    ends: [Vec<S>; 2],
}

impl<S: Scalar> BathTemperatures<S> {
    /// For a step from `t` of size `h`. The O parts share its time, one after the other.
    ///
    /// # Errors
    /// [`BathError::Temperature`]
    fn fill<T: Elements, K: Constant>(
        &mut self,
        (system, parameters): (&T, &[K]),
        relaxation: &Relaxation<K>,
        [t, h]: [K; 2],
        shares: OPartShares,
        degrees: usize,
    ) -> Result<(), BathError>
    where
        S: ComputesWith<K>,
    {
        let Self { numbers, ends } = self;
        let (friction, share) = (Damped::<T>::FRICTION, 1.0 / shares.parts as f64);
        let length = if friction.has_temperatures { degrees } else { 1 };
        ends.iter_mut().for_each(|end| end.resize(length, S::from_f64(0.0)));
        numbers.clear();
        for part in 0..shares.parts {
            let fractions = match shares.decay {
                Decay::Exponential => [part as f64, part as f64 + 1.0],
                Decay::Cayley => [part as f64 + 0.5; 2],
            };
            for (end, fraction) in ends.iter_mut().zip(fractions) {
                let t = S::constant(t + h * (fraction * share)).to_constant();
                friction.temperatures((system, S::varied(parameters)), t, end)?;
            }
            let [first, last] = &*ends;
            match relaxation.ramp() {
                Some([of_first, of_last]) => numbers.extend(of_first.iter().zip(of_last).enumerate().map(
                    |(i, (&of_first, &of_last))| {
                        let i = if friction.has_temperatures { i } else { 0 };
                        (first[i] * of_first + last[i] * of_last).sqrt()
                    },
                )),
                None => numbers.extend(first.iter().chain(last)),
            }
        }
        Ok(())
    }
}

step_memory! {
    impl[S: Scalar] StepMemory for BathMemory<S> {
        kept: ;
        result: heat, heats;
        scratch: own, room, driving, blocks, by_degree
    }
}

impl<S: Scalar> BathMemory<S> {
    /// With scratch for a system that knows its size.
    pub(super) fn of_system<T: Elements>(system: &T) -> Self {
        let mut memory = Self::default();
        memory.fit::<T>(system.degrees());
        memory
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn fit<T: Elements>(&mut self, degrees: usize) {
        let room = 2 * degrees;
        if self.room.numbers.len() != room {
            self.room.numbers.resize(room, S::from_f64(0.0));
        }
        if const { Damped::<T>::FRICTION.has_temperatures } && S::LANES == 1 {
            self.heats.clear();
            self.heats.resize(degrees, S::from_f64(0.0));
        }
    }

    /// Takes the heats of degrees of freedom from the tiles of a step.
    pub(super) fn collect_heats(&mut self) {
        for (heat, of_tiles) in self.heats.iter_mut().zip(&self.by_degree) {
            *heat = S::from_f64(f64::from_bits(of_tiles.load(Ordering::Relaxed)));
        }
    }

    /// The O parts of a step of size `h` from `t`, driven by `normals`. Allocates in the first step only, and
    /// only where the system does not know its size.
    ///
    /// # Errors
    /// [`StepFailure::Increments`] unless there is one normal for each part and degree of freedom, or none
    /// without temperature; [`StepFailure::Bath`] as [`prepare`]; in the first step, those of
    /// [`Hamiltonian::check`](crate::scheme::system::Hamiltonian::check).
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn parts<'m, T: Elements, K: Constant>(
        &'m mut self,
        system: &'m T,
        prepared: &'m BathLaw<K>,
        ([t, h], shares, degrees): ([K; 2], OPartShares, usize),
        (dw, noises): (&'m [S], usize),
    ) -> Result<OParts<'m, T, K, S>, StepFailure>
    where
        S: ComputesWith<K>,
    {
        let expected = noises + normals::<T>(degrees, shares.parts);
        if dw.len() != expected {
            return Err(StepFailure::Increments { expected, got: dw.len() });
        }
        self.fit::<T>(degrees);
        let (relaxation, parameters) = match prepared {
            BathLaw::Known(relaxation, parameters) => (relaxation, parameters),
            BathLaw::OfState(parameters) => {
                let is_alike = |own: &CachedRelaxation| own.h == h.lane(0) && own.degrees == degrees;
                let own = match self.own.take().filter(is_alike) {
                    Some(own) => own,
                    None => CachedRelaxation::new((system, parameters), degrees, h, shares)?,
                };
                // A memory belongs to the steps of one stepper, which have one type of constants.
                let relaxation = (self.own.insert(own).relaxation.downcast_ref())
                    .ok_or(StepFailure::Internal(StepPromise::PlainConstants))?;
                (relaxation, parameters)
            }
        };
        if const { drives::<T>() } && !relaxation.is_still() {
            let of = (system, &parameters[..]);
            self.driving.fill(of, relaxation, [t, h], shares, degrees).map_err(StepFailure::Bath)?;
        }
        let per_part = (expected - noises) / shares.parts;
        let Self { room, driving, blocks, by_degree, heats, .. } = self;
        let driving = &driving.numbers[..];
        Ok(OParts {
            system,
            relaxation,
            normals: &dw[noises..],
            per_part,
            driving,
            parts: shares.parts,
            room,
            blocks,
            by_degree,
            heats,
        })
    }
}

/// The value as type `B`, if that is its type.
fn same<A: Any, B: Any>(value: &A) -> Option<&B> {
    (value as &dyn Any).downcast_ref()
}

/// Whether temperatures act step by step: where they depend on the time, and where they differ and friction
/// is that of a place.
const fn drives<T: Elements>() -> bool {
    let friction = Damped::<T>::FRICTION;
    friction.is_timed || (friction.has_temperatures && friction.is_per_state)
}

/// `kT` of a bath at one constant temperature.
pub(super) fn temperature<T: Elements>(system: &T) -> Option<f64> {
    let friction = Damped::<T>::FRICTION;
    let is_one = friction.is_heated && !friction.is_out_of_equilibrium();
    is_one.then(|| Relaxation::<f64>::check((system, &[]), friction).ok()).flatten()
}

/// The number of standard normals that drive a step with `parts` O parts.
pub(super) fn normals<T: Elements>(degrees: usize, parts: usize) -> usize {
    if Damped::<T>::FRICTION.is_heated { parts * degrees } else { 0 }
}

/// The O parts of a step.
pub(super) struct OParts<'m, T, K, S> {
    system: &'m T,
    relaxation: &'m Relaxation<K>,
    normals: &'m [S],
    per_part: usize,
    /// The temperatures of all parts: [`BathTemperatures`].
    driving: &'m [S],
    parts: usize,
    room: &'m mut RelaxationScratch<S>,
    blocks: &'m mut Vec<AtomicU64>,
    by_degree: &'m mut Vec<AtomicU64>,
    heats: &'m mut [S],
}

impl<'m, T: Elements, K: Constant, S: ComputesWith<K>> OParts<'m, T, K, S> {
    /// The parts place by place, `parts` in number, where rates and masses are lists and numbers are `f64`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn by_place(self, parts: usize, degrees: usize) -> Option<OPartsByPlace<'m>> {
        let Self { relaxation, normals, per_part, driving, blocks, by_degree, heats, .. } = self;
        let (law, normals, driving) =
            (same(relaxation.diagonal()?)?, S::as_f64s(normals)?, S::as_f64s(driving)?);
        blocks.resize_with(parts * degrees.div_ceil(BLOCK), AtomicU64::default);
        by_degree.resize_with(heats.len(), AtomicU64::default);
        by_degree.iter_mut().for_each(|heat| *heat.get_mut() = 0.0_f64.to_bits());
        Some(OPartsByPlace { law, normals, per_part, driving, blocks, by_degree, parts })
    }

    /// Whether there is no friction.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn are_still(&self) -> bool {
        self.relaxation.is_still()
    }

    /// Whether rates and masses are lists.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn are_lists(&self) -> bool {
        self.relaxation.diagonal().is_some()
    }

    /// Forgets the heats of a step that is taken again.
    pub(super) fn begin_again(&mut self) {
        self.heats.fill(S::from_f64(0.0));
    }

    /// [Applies](Relaxation::apply) part number `part`, between two drifts over the time `drift` if there is
    /// one; returns its heat.
    ///
    /// # Errors
    /// [`StepFailure::Bath`] where friction is negative; `p` is then unspecified.
    /// [`StepPromise::ListedRates`] for drifts where rates and masses are not lists.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn apply<C: StateSum<S>>(
        &mut self,
        part: usize,
        drift: Option<K>,
        [q, p, lost]: [&mut [S]; 3],
    ) -> Result<S, StepFailure> {
        let normals = &self.normals[part * self.per_part..(part + 1) * self.per_part];
        let of_part = self.driving.len() / self.parts;
        let driving = &self.driving[part * of_part..(part + 1) * of_part];
        let heats = if const { Damped::<T>::FRICTION.has_temperatures } { &mut *self.heats } else { &mut [] };
        let momenta = Momenta { q, normals, p, lost, heats };
        self.relaxation.apply::<T, S, C>(self.system, momenta, (drift, driving), self.room)
    }
}

/// The O parts of a step, for places in any order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OPartsByPlace<'m> {
    law: &'m DiagonalRelaxation,
    normals: &'m [f64],
    per_part: usize,
    /// `R / √h` of all parts in this step; empty if it is that of the law.
    driving: &'m [f64],
    /// The bits of the heats of the `parts` of each block: threads share the list, but each writes to its own
    /// blocks.
    blocks: &'m [AtomicU64],
    /// The bits of the heats of the degrees of freedom, likewise; empty where they share one bath.
    by_degree: &'m [AtomicU64],
    parts: usize,
}

impl OPartsByPlace<'_> {
    /// Applies a part to `places`, from the first of a block on, between two drifts if coordinates are given.
    /// `lost` is what rounding took from the momenta, if it `CARRIES` that.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn apply<const CARRIES: bool>(
        &self,
        part: usize,
        places: Range<usize>,
        mut drift: Option<(f64, &mut [f64])>,
        p: &mut [f64],
        lost: &mut [f64],
    ) {
        let normals = &self.normals[part * self.per_part..(part + 1) * self.per_part];
        let deviation = match self.driving.len() / self.parts {
            0 => &self.law.deviation[..],
            degrees => &self.driving[part * degrees..(part + 1) * degrees],
        };
        let heats = self.blocks[places.start / BLOCK * self.parts..].chunks(self.parts);
        for (block, (p, heats)) in p.chunks_mut(BLOCK).zip(heats).enumerate() {
            let (from, len) = (block * BLOCK, p.len());
            let (time, q) = match &mut drift {
                Some((time, q)) => (Some(*time), &mut q[from..from + len]),
                None => (None, &mut [][..]),
            };
            let lost = if CARRIES { &mut lost[from..from + len] } else { &mut [] };
            let places = places.start + from..places.start + from + len;
            let by_degree = self.by_degree.get(places.clone()).unwrap_or_default();
            let mut own = [0.0; BLOCK];
            let momenta = Momenta { q, normals, p, lost, heats: &mut own[..by_degree.len()] };
            let heat = match CARRIES {
                true => self.law.block::<_, FixedCompensatedSum<f64, 1>, _>(places, deviation, momenta, time),
                false => self.law.block::<_, PlainSum, _>(places, deviation, momenta, time),
            };
            heats[part].store(heat.to_bits(), Ordering::Relaxed);
            for (sum, gain) in by_degree.iter().zip(own) {
                let sum_so_far = f64::from_bits(sum.load(Ordering::Relaxed));
                sum.store((sum_so_far + gain).to_bits(), Ordering::Relaxed);
            }
        }
    }

    /// The heat of all parts.
    pub(super) fn heat(&self) -> f64 {
        let of_block = |heat: &AtomicU64| f64::from_bits(heat.load(Ordering::Relaxed));
        let of_part = |part| {
            self.blocks.iter().skip(part).step_by(self.parts).map(of_block).fold(0.0, |sum, heat| sum + heat)
        };
        (0..self.parts).fold(0.0, |sum, part| sum + of_part(part))
    }
}
