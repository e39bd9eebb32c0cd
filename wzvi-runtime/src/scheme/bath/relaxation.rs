//! Friction and noise alone, an Ornstein-Uhlenbeck process: `p <- E p + R ξ`.
//!
//! With `M⁻¹ = C Cᵀ` and `N = C⁻ᵀ`, so that `M = N Nᵀ`, the friction `A = Cᵀ Γ C = V Λ Vᵀ` is symmetric, and
//! with `W = N V` and the time `s`
//!
//! ```text
//! E = exp(-s Γ M⁻¹) = W exp(-s Λ) W⁻¹ = e^{-s μ} (1 - W (1 - exp(-s (Λ - μ))) W⁻¹),   W⁻¹ = Vᵀ Cᵀ,   μ the smallest of Λ
//! R Rᵀ = kT (M - E M Eᵀ) = kT W (1 - exp(-2 s Λ)) Wᵀ
//! ```
//!
//! [`Decay::Cayley`] has `E = (1 + s Γ M⁻¹/2)⁻¹ (1 - s Γ M⁻¹/2)` instead of the exponential.
//!
//! There is no cancellation at small or large friction, and undamped degrees of freedom keep their momenta to
//! the last bit.

use std::ops::Mul;

use super::diagonal::DiagonalRelaxation;
use super::modes::{Bath, Decay, Factors, FrictionModes, refuse_negative};
use super::{Damped, Friction};
use crate::algebra::lanes::Lanes;
use crate::algebra::scalar::{ComputesWith, Constant, Mask as _, Scalar};
use crate::algebra::state_sum::StateSum;
use crate::error::{BathError, StepFailure, StepPromise};
use crate::scheme::elements::{Elements, PairColumns};

/// The constants of an O part, which do not depend on the state. Lists have one number per degree of freedom;
/// matrices are row-major.
#[derive(Clone, Debug)]
pub(super) enum Relaxation<K = f64> {
    /// No friction.
    Still,
    /// Rates and masses as lists.
    Diagonal(DiagonalRelaxation<K>),
    /// Rates and masses as matrices, of one system.
    Matrix {
        decay: Vec<K>,
        deviation: Vec<K>,
        inverse_mass: Vec<K>,
        /// As of [`DiagonalRelaxation`], by mode; `deviation` is then that of modes with unit noise.
        ramp: Option<[Vec<K>; 2]>,
    },
    /// Rates that depend on the state.
    Frozen(StateRelaxation<K>),
}

/// The constants of an O part with rates that depend on the state.
#[derive(Clone, Debug)]
pub(super) struct StateRelaxation<K = f64> {
    /// A list if masses are a list, else a matrix.
    inverse_mass: Vec<K>,
    /// The lower triangular `L` with `M = L Lᵀ`; empty if masses are a list.
    mass: Vec<K>,
    bath: Bath<K>,
    /// All parameters, where they have derivatives.
    parameters: Vec<K>,
}

/// The scratch of an O part.
#[derive(Debug, Default)]
pub(super) struct RelaxationScratch<S> {
    /// Two per degree of freedom.
    pub(super) numbers: Vec<S>,
    columns: PairColumns,
}

/// The momenta that an O part moves, and the normals that drive it.
pub(super) struct Momenta<'m, S> {
    /// The coordinates.
    pub(super) q: &'m mut [S],
    /// `√h ξ`, none without temperature.
    pub(super) normals: &'m [S],
    pub(super) p: &'m mut [S],
    /// The compensation of the momenta.
    pub(super) lost: &'m mut [S],
    /// The heat of each degree of freedom so far; empty where they share one bath.
    pub(super) heats: &'m mut [S],
}

impl<K: Constant> Relaxation<K> {
    /// The O part over the fraction `share` of a step of size `h`, with this decay.
    ///
    /// # Errors
    /// [`BathError`] for an invalid friction, temperature or mass, and for steps backwards in time.
    pub(super) fn new<T: Elements>(
        (system, parameters): (&T, &[K]),
        friction: Friction,
        degrees: usize,
        h: K,
        (share, decay): (f64, Decay),
    ) -> Result<Self, BathError> {
        let (zero, varied) = (K::from_f64(0.0), K::varied(parameters));
        let temperature = match friction.is_out_of_equilibrium() {
            true => zero,
            false => Self::check((system, varied), friction)?,
        };
        let mut temperatures = vec![zero; if friction.has_temperatures { degrees } else { 0 }];
        if friction.has_temperatures && !friction.is_timed {
            friction.temperatures((system, varied), Scalar::from_f64(0.0), &mut temperatures)?;
        }
        let mut gamma = vec![zero; if friction.is_matrix { degrees * degrees } else { degrees }];
        if !friction.is_per_state {
            friction.damping((system, varied), &vec![zero; degrees], &mut gamma, &mut PairColumns::default());
            if let Some(&rate) = gamma.iter().find(|gamma| !gamma.is_finite().all()) {
                return Err(BathError::Friction { rate: rate.lane(0) });
            }
            if gamma.iter().all(|gamma| gamma.vanishes().all()) {
                return Ok(Self::Still);
            }
        }
        if h.less(zero).any() {
            return Err(BathError::Backwards { h: h.lane(0) });
        }
        let bath = Bath { time: h * share, temperature, unit: h.abs().sqrt().recip(), decay };
        let inverse_mass: Vec<K> = inverse_mass((system, varied), friction, degrees);
        if friction.is_matrix && friction.is_list() && !friction.is_per_state {
            gamma = rates_of_diagonal(&gamma, &inverse_mass)?;
        }
        let mass = if friction.is_list() { Factors::default() } else { Factors::of(&inverse_mass, degrees)? };
        if friction.is_per_state {
            if friction.is_list()
                && let Some(degree) = inverse_mass.iter().position(|inverse| inverse.less_equal(zero).any())
            {
                return Err(BathError::Mass { degree, inverse: inverse_mass[degree].lane(0) });
            }
            let parameters = parameters.to_vec();
            return Ok(Self::Frozen(StateRelaxation { mass: mass.mass, inverse_mass, bath, parameters }));
        }
        match (!friction.is_list() && friction.is_matrix, friction.has_diagonal_masses) {
            (false, true) if friction.is_timed => ramped(&gamma, inverse_mass, &bath),
            (false, true) => diagonal(&gamma, inverse_mass, &bath, &temperatures),
            (false, false) => {
                uniform(gamma.first().copied(), &mass, inverse_mass, (&bath, friction.is_timed))
            }
            (true, _) => constant(gamma, &mass, inverse_mass, (&bath, friction.is_timed), degrees),
        }
    }

    /// The temperature, 0 if there is none.
    ///
    /// # Errors
    /// [`BathError::Temperature`]
    pub(super) fn check<T: Elements>(of: (&T, &[K::Constant]), friction: Friction) -> Result<K, BathError> {
        let zero = K::from_f64(0.0);
        let mut temperature = [zero];
        friction.temperatures(of, Scalar::from_f64(0.0), &mut temperature)?;
        Ok(temperature[0])
    }

    /// Whether there is no friction.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn is_still(&self) -> bool {
        matches!(self, Self::Still)
    }

    /// The weights of the temperatures at both ends of an O part, where these depend on the time.
    pub(super) fn ramp(&self) -> Option<&[Vec<K>; 2]> {
        match self {
            Self::Diagonal(DiagonalRelaxation { ramp, .. }) | Self::Matrix { ramp, .. } => ramp.as_ref(),
            Self::Still | Self::Frozen(_) => None,
        }
    }

    /// Rates and masses, if they are lists.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn diagonal(&self) -> Option<&DiagonalRelaxation<K>> {
        if let Self::Diagonal(law) = self { Some(law) } else { None }
    }

    /// Moves the momenta, and the coordinates by a drift over the time `drift` before and one after; returns
    /// the heat, the gain of kinetic energy. Lanes do not account for it. `driving` is what the temperatures
    /// of the step give the part, where they do.
    ///
    /// # Errors
    /// [`BathError::Friction`] where friction is negative; `p` is then unspecified.
    /// [`StepPromise::ListedRates`] for drifts where rates and masses are not lists, or sums are compensated.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn apply<T: Elements, S: ComputesWith<K>, C: StateSum<S>>(
        &self,
        system: &T,
        mut momenta: Momenta<'_, S>,
        (drift, driving): (Option<K>, &[S]),
        room: &mut RelaxationScratch<S>,
    ) -> Result<S, StepFailure> {
        if drift.is_some() && (C::CARRIES || self.diagonal().is_none()) {
            return Err(StepFailure::Internal(StepPromise::ListedRates));
        }
        Ok(match self {
            Self::Still => S::from_f64(0.0),
            Self::Diagonal(law) if const { Damped::<T>::FRICTION.is_timed } => {
                law.all_blocks::<S, C, S>(driving, momenta, drift)?
            }
            Self::Diagonal(law) => law.all_blocks::<S, C, K>(&law.deviation, momenta, drift)?,
            Self::Matrix { decay, deviation, inverse_mass, .. } => {
                let d = momenta.p.len();
                for (i, to) in room.numbers.iter_mut().enumerate().take(d) {
                    let kept = (0..d).fold(S::from_f64(0.0), |sum, j| sum + momenta.p[j] * decay[i * d + j]);
                    let row = &deviation[i * d..(i + 1) * d];
                    *to = match const { Damped::<T>::FRICTION.is_timed } {
                        true => row.iter().zip(driving).enumerate().fold(kept, |sum, (k, (entry, noise))| {
                            sum + *noise * of_normal(momenta.normals, k) * *entry
                        }),
                        false => momenta.with_noise(kept, i, row),
                    };
                }
                momenta.replace::<C, K>(&room.numbers[..d], inverse_mass)
            }
            Self::Frozen(frozen) => {
                frozen.apply::<T, S, C>((system, S::varied(&frozen.parameters)), momenta, driving, room)?
            }
        })
    }
}

impl Relaxation {
    /// Gathers systems in lanes: if rates and masses of all are lists and no temperature depends on the time,
    /// or none has friction.
    pub(super) fn gather<const L: usize>(of_lanes: [&Self; L]) -> Option<Relaxation<Lanes<L>>> {
        if of_lanes.iter().all(|law| law.is_still()) {
            return Some(Relaxation::Still);
        }
        let mut laws = [of_lanes.first()?.diagonal()?; L];
        for (law, of_lane) in laws.iter_mut().zip(of_lanes) {
            *law = of_lane.diagonal().filter(|law| law.ramp.is_none())?;
        }
        Some(Relaxation::Diagonal(DiagonalRelaxation::gather(laws)))
    }
}

/// `√h ξ` of a degree of freedom; zero without temperature.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn of_normal<S: Scalar>(normals: &[S], i: usize) -> S {
    normals.get(i).copied().unwrap_or(S::from_f64(0.0))
}

impl<S: Scalar> Momenta<'_, S> {
    /// `number` plus the product of row `i` of a lower triangular matrix and the noise.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn with_noise<T: Copy>(&self, number: S, i: usize, row: &[T]) -> S
    where
        S: Mul<T, Output = S>,
    {
        let mut sum = number;
        for (j, entry) in row[..=i].iter().enumerate() {
            sum = sum + of_normal(self.normals, j) * *entry;
        }
        sum
    }

    /// `p <- E p + R ξ` by degree of freedom, with compensation, and `q` by a drift before and one after if
    /// there is a time for them; returns the heat.
    ///
    /// # Errors
    /// The errors of the `constants` `E`, `R / √h` and `M⁻¹`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn relax<C: StateSum<S>, D: Copy, V: Copy, K: Copy + Mul<Output = K> + Mul<f64, Output = K>>(
        &mut self,
        constants: impl Iterator<Item = Result<(D, V, K), StepFailure>>,
        drift: Option<K>,
    ) -> Result<S, StepFailure>
    where
        S: Mul<D, Output = S> + Mul<V, Output = S> + Mul<K, Output = S>,
    {
        let mut heat = S::from_f64(0.0);
        for ((i, p), constants) in self.p.iter_mut().enumerate().zip(constants) {
            let (decay, deviation, inverse) = constants?;
            let (before, noise) = (*p, of_normal(self.normals, i) * deviation);
            if C::CARRIES {
                (*p, self.lost[i]) = C::add(before * decay, noise, self.lost[i] * decay);
            } else {
                *p = before * decay + noise;
            }
            if let Some(time) = drift {
                let drift = inverse * time;
                self.q[i] = self.q[i] + before * drift + *p * drift;
            }
            let gain = gain(before, *p, inverse);
            if let Some(own) = self.heats.get_mut(i) {
                *own = *own + gain;
            }
            heat = heat + gain;
        }
        Ok(heat)
    }

    /// Stores the new momenta and returns the heat: `(p_1 - p_0) · M⁻¹ (p_1 + p_0) / 2`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn replace<C: StateSum<S>, K: Constant>(&mut self, new: &[S], inverse_mass: &[K]) -> S
    where
        S: ComputesWith<K>,
    {
        let (zero, d) = (S::from_f64(0.0), self.p.len());
        let mut heat = zero;
        if S::LANES == 1 {
            for (i, row) in inverse_mass.chunks_exact(d).enumerate() {
                let sum = (0..d).fold(zero, |sum, j| sum + (new[j] + self.p[j]) * row[j]);
                heat = heat + (new[i] - self.p[i]) * sum * 0.5;
            }
        }
        self.p.copy_from_slice(new);
        if C::CARRIES {
            self.lost.fill(zero);
        }
        heat
    }
}

/// The gain of kinetic energy of one momentum.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn gain<S, N>(before: S, after: S, inverse_mass: N) -> S
where
    S: Scalar + Mul<N, Output = S>,
    N: Mul<f64, Output = N>,
{
    if S::LANES == 1 { (after - before) * (after + before) * (inverse_mass * 0.5) } else { S::from_f64(0.0) }
}

/// `M⁻¹`: a list if friction is a list, else a matrix.
fn inverse_mass<T: Elements, S: Scalar>(
    system: (&T, &[S::Constant]),
    friction: Friction,
    d: usize,
) -> Vec<S> {
    let zeros = |length| vec![S::from_f64(0.0); length];
    let mut inverse_mass = zeros(if friction.has_diagonal_masses { d } else { d * d });
    friction.inverse_mass(system, &mut inverse_mass);
    if !friction.has_diagonal_masses || friction.is_list() {
        return inverse_mass;
    }
    let mut rows = zeros(d * d);
    rows.iter_mut().step_by(d + 1).zip(inverse_mass).for_each(|(entry, inverse)| *entry = inverse);
    rows
}

/// # Errors
/// [`BathError::Friction`] unless the rate is a finite number that is not negative.
fn check_rate<K: Constant>(rate: K) -> Result<K, BathError> {
    let is_rate = rate.is_finite() & K::from_f64(0.0).less_equal(rate);
    if is_rate.all() { Ok(rate) } else { Err(BathError::Friction { rate: rate.lane(0) }) }
}

/// The mass of a degree of freedom with friction is positive.
///
/// # Errors
/// [`BathError::Mass`]
fn check_mass<K: Constant>(degree: usize, inverse: K) -> Result<(), BathError> {
    let is_mass = K::from_f64(0.0).less(inverse).all();
    if is_mass { Ok(()) } else { Err(BathError::Mass { degree, inverse: inverse.lane(0) }) }
}

/// Whether a matrix of so many rows is diagonal.
///
/// # Errors
/// [`BathError::Coupled`]
fn check_diagonal<S: Scalar>(gamma: &[S], d: usize) -> Result<(), BathError> {
    let coupled = |at: &usize| at % d != at / d && !gamma[*at].vanishes().all();
    match (0..d * d).find(coupled) {
        Some(at) => Err(BathError::Coupled { entry: [at / d, at % d] }),
        None => Ok(()),
    }
}

/// `Γ_ii / m_i` of a diagonal matrix.
///
/// # Errors
/// [`BathError::Coupled`]
fn rates_of_diagonal<K: Constant>(gamma: &[K], inverse_mass: &[K]) -> Result<Vec<K>, BathError> {
    let d = inverse_mass.len();
    check_diagonal(gamma, d)?;
    let rate = |(degree, inverse): (usize, &K)| match gamma[degree * d + degree].vanishes().all() {
        // A degree of freedom without friction may have any mass.
        true => K::from_f64(0.0),
        false => gamma[degree * d + degree] * *inverse,
    };
    Ok(inverse_mass.iter().enumerate().map(rate).collect())
}

/// At temperatures that depend on the time.
fn ramped<K: Constant>(
    rates: &[K],
    inverse_mass: Vec<K>,
    bath: &Bath<K>,
) -> Result<Relaxation<K>, BathError> {
    let list = |number| vec![K::from_f64(number); rates.len()];
    let (mut decay, mut first, mut last) = (list(1.0), list(0.0), list(0.0));
    for (degree, (&rate, &inverse)) in rates.iter().zip(&inverse_mass).enumerate() {
        if rate.vanishes().all() {
            continue;
        }
        check_mass(degree, inverse)?;
        let (kept, weights) = bath.ramp(check_rate(rate)?);
        decay[degree] = kept;
        [first[degree], last[degree]] = weights.map(|weight| weight / inverse);
    }
    let (deviation, ramp) = (Vec::new(), Some([first, last]));
    Ok(Relaxation::Diagonal(DiagonalRelaxation { decay, deviation, inverse_mass, ramp }))
}

/// At the temperature of the bath, or at `temperatures` if there are any.
fn diagonal<K: Constant>(
    rates: &[K],
    inverse_mass: Vec<K>,
    bath: &Bath<K>,
    temperatures: &[K],
) -> Result<Relaxation<K>, BathError> {
    let [mut decay, mut deviation] = [1.0, 0.0].map(|number| vec![K::from_f64(number); rates.len()]);
    for (degree, (&rate, &inverse)) in rates.iter().zip(&inverse_mass).enumerate() {
        if rate.vanishes().all() {
            continue;
        }
        check_mass(degree, inverse)?;
        let temperature = temperatures.get(degree).copied().unwrap_or(bath.temperature);
        let (kept, noise) = Bath { temperature, ..*bath }.mode(check_rate(rate)?);
        (decay[degree], deviation[degree]) = (kept, noise / inverse.sqrt());
    }
    Ok(Relaxation::Diagonal(DiagonalRelaxation { decay, deviation, inverse_mass, ramp: None }))
}

/// One rate, with a mass matrix.
fn uniform<K: Constant>(
    rate: Option<K>,
    mass: &Factors<K>,
    inverse_mass: Vec<K>,
    (bath, is_timed): (&Bath<K>, bool),
) -> Result<Relaxation<K>, BathError> {
    let zero = K::from_f64(0.0);
    let rate = check_rate(rate.unwrap_or(zero))?;
    let (kept, noise) = bath.mode(rate);
    let degrees = mass.mass.len().isqrt();
    let ramp = is_timed.then(|| bath.ramp(rate).1.map(|weight| vec![weight; degrees]));
    let noise = if is_timed { K::from_f64(1.0) } else { noise };
    let deviation: Vec<K> = mass.mass.iter().map(|entry| noise * *entry).collect();
    let mut decay = vec![zero; deviation.len()];
    decay.iter_mut().step_by(deviation.len().isqrt() + 1).for_each(|entry| *entry = kept);
    Ok(Relaxation::Matrix { decay, deviation, inverse_mass, ramp })
}

/// A constant friction matrix.
fn constant<K: Constant>(
    mut gamma: Vec<K>,
    mass: &Factors<K>,
    inverse_mass: Vec<K>,
    (bath, is_timed): (&Bath<K>, bool),
    d: usize,
) -> Result<Relaxation<K>, BathError> {
    let (zero, one) = (K::from_f64(0.0), K::from_f64(1.0));
    for i in 0..d {
        for j in 0..i {
            if !gamma[i * d + j].equal(gamma[j * d + i]).all() {
                return Err(BathError::Asymmetric { entry: [i, j] });
            }
        }
    }
    let (mut vectors, mut modes) = (vec![zero; d * d], vec![zero; d * d]);
    let mut found = FrictionModes { rates: &mut gamma, vectors: &mut vectors, modes: &mut modes };
    found.solve(mass, d).map_err(|rate| BathError::Friction { rate })?;
    let (smallest, slowest) = found.slowest(bath, d);
    let mut decay = vec![zero; d * d];
    for (at, entry) in decay.iter_mut().enumerate() {
        let (i, j) = (at / d, at % d);
        let lost = (0..d).fold(zero, |sum, k| {
            let faster = found.faster(bath, smallest, k, d);
            sum + found.modes[i * d + k] * faster * found.inverse(mass, [k, j], d)
        });
        *entry = slowest * (if i == j { one } else { zero } - lost);
    }
    let ramp = is_timed.then(|| {
        let weights: Vec<[K; 2]> = (0..d).map(|k| bath.ramp(found.rates[k * (d + 1)]).1).collect();
        [0, 1].map(|end| weights.iter().map(|weights| weights[end]).collect())
    });
    if !is_timed {
        found.deviation(bath, d);
    }
    Ok(Relaxation::Matrix { decay, deviation: modes, inverse_mass, ramp })
}

/// The error for negative friction.
#[cold]
fn negative(rate: f64) -> StepFailure {
    StepFailure::Bath(BathError::Friction { rate })
}

impl<K: Constant> StateRelaxation<K> {
    /// Decay and noise of a mode with this rate, as [`Bath::mode`]; at the temperatures of both ends of the
    /// part, if there are any.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mode<S: ComputesWith<K>>(&self, rate: S, ends: Option<[S; 2]>) -> Result<(S, S), StepFailure> {
        refuse_negative(rate).map_err(negative)?;
        Ok(match ends {
            None => self.bath.mode(rate),
            Some([first, last]) => {
                let (kept, [of_first, of_last]) = self.bath.ramp(rate);
                (kept, (first * of_first + last * of_last).sqrt())
            }
        })
    }

    /// Rates by degree of freedom, or one rate with a mass matrix.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn apply<T: Elements, S: ComputesWith<K>, C: StateSum<S>>(
        &self,
        system: (&T, &[S::Constant]),
        mut momenta: Momenta<'_, S>,
        driving: &[S],
        RelaxationScratch { numbers, columns }: &mut RelaxationScratch<S>,
    ) -> Result<S, StepFailure> {
        let (first, last) = driving.split_at(driving.len() / 2);
        let ends = |degree: usize| {
            let degree = if Damped::<T>::FRICTION.has_temperatures { degree } else { 0 };
            Some([*first.get(degree)?, *last.get(degree)?])
        };
        let (rates, new) = numbers.split_at_mut(momenta.p.len());
        Damped::<T>::FRICTION.damping(system, momenta.q, rates, columns);
        if Damped::<T>::FRICTION.has_diagonal_masses {
            let constants =
                rates.iter().zip(&self.inverse_mass).enumerate().map(|(degree, (&rate, &inverse))| {
                    let (decay, noise) = self.mode(rate, ends(degree))?;
                    Ok((decay, noise / inverse.sqrt(), inverse))
                });
            return momenta.relax::<C, S, S, K>(constants, None);
        }
        let Some(&rate) = rates.first() else { return Ok(S::from_f64(0.0)) };
        let (decay, noise) = self.mode(rate, ends(0))?;
        let masses = self.mass.chunks_exact(momenta.p.len());
        for (i, (new, mass)) in new.iter_mut().zip(masses).enumerate() {
            *new = momenta.p[i] * decay + momenta.with_noise(S::from_f64(0.0), i, mass) * noise;
        }
        Ok(momenta.replace::<C, K>(new, &self.inverse_mass))
    }
}
