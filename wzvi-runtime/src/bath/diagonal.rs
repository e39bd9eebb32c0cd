//! The O part where rates and masses are lists: every momentum by itself, `p <- E p + R ξ`.
//!
//! The heat is summed in blocks, whose sums are added in their order, so that it does not depend on how many places are taken at once.

use std::ops::Range;

use super::relaxation::{gain, of_normal};
use crate::scalar::Scalar;

/// Lists of one number per degree of freedom.
#[derive(Clone, Debug)]
pub(super) struct Diagonal {
    /// `E`
    pub(super) decay: Vec<f64>,
    /// `R / √h`
    pub(super) deviation: Vec<f64>,
    /// `M⁻¹`
    pub(super) inverse_mass: Vec<f64>,
}

/// Places whose heat is one sum.
pub(super) const BLOCK: usize = crate::elements::BLOCK;

/// Places that are taken beside each other.
const BESIDE: usize = 8;

impl Diagonal {
    /// All momenta, between two drifts over a time where there are coordinates; the heat.
    #[inline(always)]
    pub(super) fn all_blocks<S: Scalar>(
        &self,
        normals: &[S],
        mut drift: Option<(f64, &mut [S])>,
        p: &mut [S],
    ) -> S {
        let (mut heat, degrees) = (S::from_f64(0.0), self.decay.len().min(p.len()));
        // Numbers of several parts have them beside each other already.
        if S::LANES > 1 || degrees < BLOCK {
            return self.one_by_one(normals, drift, p);
        }
        for start in (0..degrees).step_by(BLOCK) {
            let places = start..(start + BLOCK).min(degrees);
            let drift = drift.as_mut().map(|(time, q)| (*time, &mut q[places.clone()]));
            let p = &mut p[places.clone()];
            heat = heat + self.block(places, normals, drift, p);
        }
        heat
    }

    /// The same.
    #[inline(always)]
    fn one_by_one<S: Scalar>(&self, normals: &[S], mut drift: Option<(f64, &mut [S])>, p: &mut [S]) -> S {
        let Self { decay, deviation, inverse_mass } = self;
        let mut heat = S::from_f64(0.0);
        let constants = decay.iter().zip(deviation).zip(inverse_mass);
        for ((i, p), ((&decay, &deviation), &inverse)) in p.iter_mut().enumerate().zip(constants) {
            let before = *p;
            *p = before * decay + of_normal(normals, i) * deviation;
            if let Some((time, q)) = &mut drift {
                let drift = *time * inverse;
                q[i] = q[i] + before * drift + *p * drift;
            }
            heat = heat + gain(before, *p, inverse);
        }
        heat
    }

    /// The momenta of at most one block, with their coordinates; the heat.
    #[inline(always)]
    pub(super) fn block<S: Scalar>(
        &self,
        places: Range<usize>,
        normals: &[S],
        drift: Option<(f64, &mut [S])>,
        p: &mut [S],
    ) -> S {
        let zero = S::from_f64(0.0);
        let len = places.len().min(BLOCK);
        let [decay, deviation, inverse_mass] =
            [&self.decay, &self.deviation, &self.inverse_mass].map(|list| &list[places.clone()][..len]);
        // Without temperature there are none.
        let none = [zero; BLOCK];
        let normals = normals.get(places).unwrap_or(&none);
        let (normals, p) = (&normals[..len], &mut p[..len]);
        let mut gains = [zero; BLOCK];
        let gains = &mut gains[..len];
        match drift {
            None => {
                for i in 0..len {
                    let before = p[i];
                    p[i] = before * decay[i] + normals[i] * deviation[i];
                    gains[i] = gain(before, p[i], inverse_mass[i]);
                }
            }
            Some((time, q)) => {
                let q = &mut q[..len];
                for i in 0..len {
                    let (before, drift) = (p[i], time * inverse_mass[i]);
                    p[i] = before * decay[i] + normals[i] * deviation[i];
                    q[i] = q[i] + before * drift + p[i] * drift;
                    gains[i] = gain(before, p[i], inverse_mass[i]);
                }
            }
        }
        let mut heats = [zero; BESIDE];
        let (groups, rest) = gains.as_chunks::<BESIDE>();
        for group in groups {
            for i in 0..BESIDE {
                heats[i] = heats[i] + group[i];
            }
        }
        rest.iter().chain(&heats).fold(zero, |sum, &heat| sum + heat)
    }
}
