//! Coupled paths: beside each path of a level a coarser one, in steps twice as long, on the same Brownian
//! path.

use std::f64::consts::FRAC_1_SQRT_2;
use std::marker::PhantomData;

use super::Group;
use super::steps::StepPaths;
use crate::algebra::lanes::Lanes;
use crate::algebra::scalar::Scalar;
use crate::ensemble::job::{EnsembleJob, NotInLanes};
use crate::ensemble::starts::Systems;
use crate::scheme::system::Discretized;
use crate::trajectory::Error;
use crate::trajectory::error::{LevelError, LevelFailure};

/// The paths of a job and, if [`Systems::ARE_PAIRED`], the coarser ones beside them.
pub(in crate::ensemble) struct Coupled<'j, 'a, H: Discretized<E>, E, P, T, const L: usize> {
    pub(in crate::ensemble) fine: Group<'j, 'a, H, E, T, L>,
    /// None on the coarsest level.
    coarse: Option<Group<'j, 'a, H, E, T, L>>,
    /// The normals of the first of two steps of the finer paths, by process.
    first: Vec<Lanes<L>>,
    systems: PhantomData<P>,
}

impl<'j, 'a, H, E, P, T, const L: usize> Coupled<'j, 'a, H, E, P, T, L>
where
    H: Discretized<E>,
    P: Systems,
    T: StepPaths<'j, H, E, L>,
{
    /// The paths of a job, and those of a coarser one, each by what `make` makes for them.
    pub(in crate::ensemble) fn new(
        job: &'j EnsembleJob<'a, H, E>,
        coarse: Option<&'j EnsembleJob<'a, H, E>>,
        make: fn(&'j EnsembleJob<'a, H, E>) -> T,
    ) -> Self {
        let mut fine = Group::new(job, make(job));
        if coarse.is_some() {
            fine.paths.increments.keep_normals();
        } else if L == 1 && job.not_in_lanes() == Some(NotInLanes::LargeSystem) {
            fine.paths.increments.draw_one_path();
        }
        let coarse = coarse.map(|job| Group::new(job, make(job)));
        Self { fine, coarse, first: vec![Lanes::from_f64(0.0); job.processes()], systems: PhantomData }
    }

    /// [`Group::begin`]
    ///
    /// # Errors
    /// The errors of [`Group::begin`].
    pub(in crate::ensemble) fn begin(&mut self, path: u64, end: u64) -> Result<(), Error> {
        self.fine.begin(path, end)?;
        self.coarse.as_mut().map_or(Ok(()), |coarse| coarse.begin(path, end))
    }

    /// [`Group::advance`]; the coarser paths take a step after every second one.
    ///
    /// # Errors
    /// If the run cannot go on.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::ensemble) fn advance(&mut self, step: u64) -> Result<(), Error> {
        self.fine.draw(step)?;
        if const { P::ARE_PAIRED } {
            self.advance_coarse(step)?;
        }
        self.fine.step(step)
    }

    /// Gives the normals that were drawn for a step to the coarser paths.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance_coarse(&mut self, step: u64) -> Result<(), Error> {
        let Self { fine, coarse: Some(coarse), first, .. } = self else { return Ok(()) };
        for (process, first) in first.iter_mut().enumerate() {
            let drawn = fine.paths.increments.normals(process, step)?;
            if step % 2 == 1 {
                coarse.paths.increments.drive(process, step / 2, (*first + drawn) * FRAC_1_SQRT_2);
            } else {
                *first = drawn;
            }
        }
        if step % 2 == 1 { coarse.step(step / 2) } else { Ok(()) }
    }

    /// The observable at the end of the path of a lane, and its difference from that of the coarser path; the
    /// same twice where there is none.
    ///
    /// # Errors
    /// Where one of them has no value: of both the coarser one, which is the reason in most cases.
    pub(in crate::ensemble) fn end_of_pair(&mut self, lane: usize) -> Result<[f64; 2], LevelError> {
        let level = self.fine.job.level;
        let coarse = self.coarse.as_mut().map(|coarse| end_of(coarse, lane)).transpose();
        let coarse = coarse.map_err(|error| LevelError { level, ..error })?;
        let fine = end_of(&mut self.fine, lane)?;
        Ok([fine, coarse.map_or(fine, |coarse| fine - coarse)])
    }
}

/// The observable at the end of the path of a lane.
///
/// # Errors
/// [`LevelError`] if the path failed, or its observable is not finite.
fn end_of<'j, H: Discretized<E>, E, T: StepPaths<'j, H, E, L>, const L: usize>(
    group: &mut Group<'j, '_, H, E, T, L>,
    lane: usize,
) -> Result<f64, LevelError> {
    let (job, path) = (group.job, group.paths.lanes.number(lane));
    let failed = |cause| Err(LevelError { level: job.level, path, h: job.grid.h, cause });
    if let Some(failure) = group.paths.lanes.failure_of(path) {
        return failed(LevelFailure::Step(failure.error));
    }
    let value =
        job.observed.observables.first().map_or(f64::NAN, |f| f(group.state_at(lane, job.grid.steps)));
    if value.is_finite() { Ok(value) } else { failed(LevelFailure::NonFinite(value)) }
}
