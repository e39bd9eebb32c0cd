//! Coupled paths: beside each path of a level a coarser one, in steps twice as long, on the same Brownian
//! path.

use std::f64::consts::FRAC_1_SQRT_2;

use super::Group;
use crate::algebra::lanes::Lanes;
use crate::algebra::scalar::Scalar;
use crate::ensemble::job::EnsembleJob;
use crate::ensemble::starts::Systems;
use crate::scheme::system::Discretized;
use crate::trajectory::Error;
use crate::trajectory::error::{LevelError, LevelFailure};

/// The coarser paths beside a group.
pub(super) struct CoarsePaths<'j, 'a, H: Discretized<E>, E, P, const L: usize> {
    pub(super) group: Group<'j, 'a, H, E, P, L>,
    /// The normals of the first of two steps of the finer paths, by process.
    first: Vec<Lanes<L>>,
}

impl<'j, 'a, H: Discretized<E>, E, P: Systems, const L: usize> CoarsePaths<'j, 'a, H, E, P, L> {
    pub(super) fn new(job: &'j EnsembleJob<'a, H, E>) -> Self {
        Self { group: Group::new(job, None), first: vec![Lanes::from_f64(0.0); job.processes()] }
    }
}

impl<H: Discretized<E>, E, P: Systems, const L: usize> Group<'_, '_, H, E, P, L> {
    /// Gives the normals that were drawn for a step to the coarser paths, which take one after every second.
    ///
    /// # Errors
    /// If the run cannot go on.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn advance_coarse(&mut self, step: u64) -> Result<(), Error> {
        let Some(coarse) = &mut self.coarse else { return Ok(()) };
        let CoarsePaths { group, first } = &mut **coarse;
        for (process, first) in first.iter_mut().enumerate() {
            let drawn = self.increments.normals(process, step)?;
            if step % 2 == 1 {
                group.increments.drive(process, step / 2, (*first + drawn) * FRAC_1_SQRT_2);
            } else {
                *first = drawn;
            }
        }
        if step % 2 == 1 { group.step(step / 2) } else { Ok(()) }
    }

    /// The observable at the end of the path of a lane, and its difference from that of the coarser path; the
    /// same twice where there is none.
    ///
    /// # Errors
    /// Where one of them has no value: of both the coarser one, which is the reason in most cases.
    pub(in crate::ensemble) fn end_of_pair(&mut self, lane: usize) -> Result<[f64; 2], LevelError> {
        let level = self.job.level;
        let coarse = self.coarse.as_mut().map(|coarse| coarse.group.end_of(lane)).transpose();
        let coarse = coarse.map_err(|error| LevelError { level, ..error })?;
        let fine = self.end_of(lane)?;
        Ok([fine, coarse.map_or(fine, |coarse| fine - coarse)])
    }

    fn end_of(&mut self, lane: usize) -> Result<f64, LevelError> {
        let (job, path) = (self.job, self.path(lane));
        let failed = |cause| Err(LevelError { level: job.level, path, h: job.h, cause });
        if let Some(failure) = self.failure_of(path) {
            return failed(LevelFailure::Step(failure.error));
        }
        let value = job.observables.first().map_or(f64::NAN, |f| f(self.state_at(lane, job.steps)));
        if value.is_finite() { Ok(value) } else { failed(LevelFailure::NonFinite(value)) }
    }
}
