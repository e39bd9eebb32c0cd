//! One path of an ensemble, alone: to look at one that failed, or at any.

use super::Ensemble;
use super::group::{BySteppers, Group, InLanes, StepPaths};
use super::job::EnsembleJob;
use super::starts::Systems;
use crate::error::wrong;
use crate::increments::Noise;
use crate::scheme::dense::DenseOutput;
use crate::scheme::system::Discretized;
use crate::trajectory::Error;
use crate::trajectory::between::{BetweenNodes, StepPart};
use crate::trajectory::following::subtract;
use crate::trajectory::recorded::Recorder;
use crate::trajectory::recording::Recording;
use crate::trajectory::simulate::Partial;
use crate::trajectory::step::StepInfo;

impl<H, E, N, P> Ensemble<'_, H, E, N, P>
where
    H: Discretized<E> + Sync,
    N: Noise,
    P: Systems,
{
    /// The path with this number as the ensemble has it, bit for bit: as far as it goes, and what ended it
    /// early, if anything did. Nodes are recorded as for a single path, by [`Ensemble::record_every`] and
    /// [`Ensemble::record_at`]; observables are not evaluated.
    ///
    /// ```ignore
    /// let failure = statistics.failures()[0];
    /// let (path, error) = ensemble().record_every(1).replay(failure.path)?;
    /// assert_eq!(error, Some(failure.error.into()));
    /// ```
    ///
    /// Its increments are those of [`StepNormals::path`](crate::noise::StepNormals::path), or of the noise
    /// that the ensemble was given, and drive any other run.
    ///
    /// # Errors
    /// The errors of [`Ensemble::run`] that show before the first step, and
    /// [`ConfigError::Setting`](crate::error::ConfigError::Setting) for a path that the ensemble does not
    /// have.
    pub fn replay(self, path: u64) -> Result<Partial<H::Vector, E>, Error> {
        let recorded = self.setup.recorded.clone();
        let job = self.job(&|| false)?;
        if path >= job.paths {
            return wrong(format!("path {path} of {}: they are numbered from 0", job.paths));
        }
        let recording = recorded.checked(0, &job.grid)?;
        if const { P::ARE_RUNS || H::PROPERTIES.is_clocked } {
            return job.run_of(path, recorded.every.unwrap_or(0), recorded.times);
        }
        if const { H::PROPERTIES.in_lanes } && job.not_in_lanes().is_none() {
            follow(Group::new(&job, InLanes::<H, E, P, 2>::new(&job)), &job, path, &recording)
        } else {
            follow(Group::new(&job, BySteppers::<H, E, 2>::new(&job)), &job, path, &recording)
        }
    }
}

/// Takes the steps of a path as part of its group.
fn follow<'j, H: Discretized<E>, E, T: StepPaths<'j, H, E, 2>>(
    mut group: Group<'j, '_, H, E, T, 2>,
    job: &'j EnsembleJob<'_, H, E>,
    path: u64,
    recording: &Recording,
) -> Result<Partial<H::Vector, E>, Error> {
    let start = job.start_of(path)?;
    let mut recorder = Recorder::new(&start, job.grid.h, job.processes(), recording, job.grid.steps)?;
    // Antithetic paths come in pairs.
    let (first, lane) = (path - path % 2, (path % 2) as usize);
    group.begin(first, job.paths)?;
    let manifold = job.systems.of(path).manifold();
    let looks_inside = !job.crossed.sections.is_empty() || !recording.between.is_empty();
    let mut looks = looks_inside.then(|| BetweenNodes::new(&job.crossed.sections, &start, manifold));
    // The state at the last node.
    let (mut dense, mut reached) = (DenseOutput::of(&start), start);
    let taken = (1..=job.grid.steps).try_for_each(|node| {
        group.advance(node - 1)?;
        if let Some(failure) = group.paths.lanes.failure_of(path) {
            return Err(failure.error.into());
        }
        let halvings = group.halvings_of(lane, node - 1);
        recorder.step(group.increments_of(lane, node - 1), &StepInfo { halvings, ..StepInfo::default() });
        if let Some(looks) = looks.as_mut().filter(|looks| looks.wants(node, recorder.next_inside())) {
            let mut later = group.increments_of(lane, node - 1).to_vec();
            group.look_inside(lane, node, &reached, &mut dense, &mut |dense, dw, is_last| {
                subtract(dw, &mut later);
                looks.search(
                    dense,
                    &StepPart { step: node - 1, dw, later: &later, is_last, end: None },
                    &mut recorder,
                );
            })?;
        }
        reached.clone_from(group.state_at(lane, node));
        if let Some(looks) = &mut looks {
            looks.arrive(node, &reached);
        }
        recorder.reach(&reached);
        Ok(())
    });
    Ok((recorder.finish(reached, &job.grid), taken.err()))
}
