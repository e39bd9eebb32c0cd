//! O parts of systems beside each other, each with rates, masses and a temperature of its own.

use super::diagonal::Diagonal;
use super::part::{Relaxes, normals};
use super::{Damped, Relaxation};
use crate::algebra::carry::Carry;
use crate::algebra::lanes::Lanes;
use crate::algebra::scalar::Scalar;
use crate::error::StepFailure;

/// The constants of the O parts of `L` systems.
#[derive(Debug)]
pub(super) struct Baths<const L: usize> {
    /// None without friction.
    law: Option<Diagonal<Lanes<L>>>,
    /// How many noises are before the normals, and how many normals each part has.
    noises: usize,
    per_part: usize,
}

impl<const L: usize> Baths<L> {
    /// Where rates and masses of all systems are lists, or none has friction.
    pub(super) fn new<T: Damped>(
        systems: [&T; L],
        relaxations: [&Option<Relaxation>; L],
        noises: impl Fn(&T) -> usize,
    ) -> Option<Self> {
        let first = *systems.first()?;
        let (noises, per_part) = (noises(first), normals(first, first.degrees(), 1));
        let are_still = relaxations.iter().all(|law| law.as_ref().is_some_and(Relaxation::is_still));
        let law = if are_still { None } else { Some(Diagonal::beside(lists(relaxations)?)) };
        Some(Self { law, noises, per_part })
    }

    /// Whether there is no friction.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn are_still(&self) -> bool {
        self.law.is_none()
    }

    /// The increments of the noises, and the O parts of a step, of which there are `parts`.
    ///
    /// # Errors
    /// [`StepFailure::Increments`] unless there is one normal for each part and degree of freedom, or none without temperature.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn parts<'m>(
        &'m self,
        parts: usize,
        dw: &'m [Lanes<L>],
    ) -> Result<(&'m [Lanes<L>], PartsBeside<'m, L>), StepFailure> {
        let (expected, got) = (self.noises + parts * self.per_part, dw.len());
        if got != expected {
            return Err(StepFailure::Increments { expected, got });
        }
        let (own, normals) = dw.split_at(self.noises);
        Ok((own, PartsBeside { law: self.law.as_ref(), normals, per_part: self.per_part }))
    }
}

/// Rates and masses of all, if they are lists.
fn lists<const L: usize>(relaxations: [&Option<Relaxation>; L]) -> Option<[&Diagonal; L]> {
    let mut found = [relaxations.first()?.as_ref()?.diagonal()?; L];
    for (found, relaxation) in found.iter_mut().zip(relaxations) {
        *found = relaxation.as_ref()?.diagonal()?;
    }
    Some(found)
}

/// The O parts of a step.
pub(super) struct PartsBeside<'m, const L: usize> {
    law: Option<&'m Diagonal<Lanes<L>>>,
    normals: &'m [Lanes<L>],
    per_part: usize,
}

impl<const L: usize> Relaxes<Lanes<L>> for PartsBeside<'_, L> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn are_still(&self) -> bool {
        self.law.is_none()
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn apply_between_drifts(
        &mut self,
        time: f64,
        q: &mut [Lanes<L>],
        p: &mut [Lanes<L>],
    ) -> Option<Lanes<L>> {
        Some(self.law?.all_blocks(&self.normals[..self.per_part], Some((time, q)), p))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn apply<C: Carry<Lanes<L>>>(
        &mut self,
        part: usize,
        _: &[Lanes<L>],
        p: &mut [Lanes<L>],
        _: &mut [Lanes<L>],
    ) -> Result<Lanes<L>, StepFailure> {
        let normals = &self.normals[part * self.per_part..(part + 1) * self.per_part];
        Ok(self.law.map_or(Lanes::from_f64(0.0), |law| law.all_blocks(normals, None, p)))
    }
}
