//! The O part where rates and masses are lists: `p <- E p + R ξ` for each momentum separately.
//!
//! The heat is summed in blocks, and the block sums in order, so that it does not depend on the number of
//! places computed at once.

use std::array::from_fn;
use std::ops::{Mul, Range};

use super::relaxation::{Momenta, gain};
use crate::algebra::lanes::Lanes;
use crate::algebra::scalar::Scalar;
use crate::algebra::state_sum::{PlainSum, StateSum};
use crate::error::StepFailure;

/// Lists of one number per degree of freedom.
#[derive(Clone, Debug)]
pub(super) struct DiagonalRelaxation<N = f64> {
    /// `E`
    pub(super) decay: Vec<N>,
    /// `R / √h`
    pub(super) deviation: Vec<N>,
    /// `M⁻¹`
    pub(super) inverse_mass: Vec<N>,
    /// The weights of the temperatures at the start and at the end of an O part in `R² / h`, if temperatures
    /// depend on the time: [`Bath::ramp`](super::modes::Bath::ramp). `R` is then that of a step.
    pub(super) ramp: Option<[Vec<N>; 2]>,
}

impl<const L: usize> DiagonalRelaxation<Lanes<L>> {
    /// Gathers the lists of systems in lanes.
    pub(super) fn gather(laws: [&DiagonalRelaxation; L]) -> Self {
        let list = |of: fn(&DiagonalRelaxation) -> &[f64]| {
            let lists = laws.map(of);
            let degrees = lists.iter().map(|list| list.len()).min().unwrap_or(0);
            (0..degrees).map(|i| Lanes::new(from_fn(|lane| lists[lane][i]))).collect()
        };
        Self {
            decay: list(|law| &law.decay),
            deviation: list(|law| &law.deviation),
            inverse_mass: list(|law| &law.inverse_mass),
            ramp: None,
        }
    }
}

/// Number of places per heat sum.
pub(super) const BLOCK: usize = crate::scheme::elements::BLOCK;

/// Number of places computed at once.
const LANES: usize = 8;

impl<N: Copy + Mul<Output = N> + Mul<f64, Output = N>> DiagonalRelaxation<N> {
    /// With `deviation`, moves all momenta, between two drifts over the time `drift` if there is one; returns
    /// the heat.
    ///
    /// # Errors
    /// None of its own: those of [`Momenta::relax`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn all_blocks<S, C: StateSum<S>, D: Copy>(
        &self,
        deviation: &[D],
        mut momenta: Momenta<'_, S>,
        drift: Option<N>,
    ) -> Result<S, StepFailure>
    where
        S: Scalar + Mul<N, Output = S> + Mul<D, Output = S>,
    {
        let Self { decay, inverse_mass, .. } = self;
        let (mut heat, degrees) = (S::from_f64(0.0), decay.len().min(momenta.p.len()));
        // Numbers with several lanes are vectors already.
        if C::CARRIES || S::LANES > 1 || degrees < BLOCK {
            let constants = decay.iter().zip(deviation).zip(inverse_mass);
            let constants = constants.map(|((&decay, &deviation), &inverse)| Ok((decay, deviation, inverse)));
            return momenta.relax::<C, N, D, N>(constants, drift);
        }
        let Momenta { q, normals, p, heats, .. } = momenta;
        for start in (0..degrees).step_by(BLOCK) {
            let places = start..(start + BLOCK).min(degrees);
            let momenta = Momenta {
                q: &mut q[places.clone()],
                normals,
                p: &mut p[places.clone()],
                lost: &mut [],
                heats: heats.get_mut(places.clone()).unwrap_or_default(),
            };
            heat = heat + self.block::<S, PlainSum, D>(places, deviation, momenta, drift);
        }
        Ok(heat)
    }

    /// Moves the momenta of at most one block, and their coordinates by drifts over the time `drift` if there
    /// is one; returns the heat. Its lists are those of `places`, but for the normals, which are those of
    /// all. With compensated sums there is no drift.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn block<S, C: StateSum<S>, D: Copy>(
        &self,
        places: Range<usize>,
        deviation: &[D],
        Momenta { q, normals, p, lost, heats }: Momenta<'_, S>,
        drift: Option<N>,
    ) -> S
    where
        S: Scalar + Mul<N, Output = S> + Mul<D, Output = S>,
    {
        let zero = S::from_f64(0.0);
        let len = places.len().min(BLOCK);
        let [decay, inverse_mass] =
            [&self.decay, &self.inverse_mass].map(|list| &list[places.clone()][..len]);
        let deviation = &deviation[places.clone()][..len];
        // Without temperature there are no normals.
        let none = [zero; BLOCK];
        let normals = normals.get(places).unwrap_or(&none);
        let (normals, p) = (&normals[..len], &mut p[..len]);
        let mut gains = [zero; BLOCK];
        let gains = &mut gains[..len];
        match drift {
            None if C::CARRIES => {
                let lost = &mut lost[..len];
                for i in 0..len {
                    let before = p[i];
                    (p[i], lost[i]) =
                        C::add(before * decay[i], normals[i] * deviation[i], lost[i] * decay[i]);
                    gains[i] = gain(before, p[i], inverse_mass[i]);
                }
            }
            None => {
                for i in 0..len {
                    let before = p[i];
                    p[i] = before * decay[i] + normals[i] * deviation[i];
                    gains[i] = gain(before, p[i], inverse_mass[i]);
                }
            }
            Some(time) => {
                let q = &mut q[..len];
                for i in 0..len {
                    let (before, drift) = (p[i], inverse_mass[i] * time);
                    p[i] = before * decay[i] + normals[i] * deviation[i];
                    q[i] = q[i] + before * drift + p[i] * drift;
                    gains[i] = gain(before, p[i], inverse_mass[i]);
                }
            }
        }
        heats.iter_mut().zip(&*gains).for_each(|(heat, gain)| *heat = *heat + *gain);
        let mut sums = [zero; LANES];
        let (groups, rest) = gains.as_chunks::<LANES>();
        for group in groups {
            for i in 0..LANES {
                sums[i] = sums[i] + group[i];
            }
        }
        rest.iter().chain(&sums).fold(zero, |sum, &heat| sum + heat)
    }
}
