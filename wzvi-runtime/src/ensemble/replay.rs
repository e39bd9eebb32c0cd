//! One path of an ensemble, alone: to look at one that failed, or at any.

use super::Ensemble;
use super::group::Group;
use crate::error::{ConfigError, Error};
use crate::simulate::{Partial, chosen_steps};
use crate::step::StepInfo;
use crate::system::Discretized;
use crate::trajectory::{Recorder, Recording};

impl<H, E> Ensemble<'_, H, E>
where
    H: Discretized<E> + Sync,
    H::Vector: Send + Sync,
    H::Prepared: Send + Sync,
{
    /// The path with this number as the ensemble has it, bit for bit: as far as it goes, and what ended it early, if anything did. Nodes
    /// are recorded as for a single path, by [`Ensemble::record_every`] and [`Ensemble::record_at`]; observables are not asked.
    ///
    /// ```ignore
    /// let failure = statistics.failures()[0];
    /// let (path, error) = ensemble().record_every(1).replay(failure.path)?;
    /// assert_eq!(error, Some(failure.error.into()));
    /// ```
    ///
    /// Its increments are those of [`StepNormals::path`](crate::noise::StepNormals::path), or of the noise that the ensemble was given, and
    /// drive any other run.
    ///
    /// # Errors
    /// Those of [`Ensemble::run`] that show before the first step, and [`ConfigError::Setting`] for a path that the ensemble does not have.
    pub fn replay(self, path: u64) -> Result<Partial<H::Vector, E>, Error> {
        let (every, chosen) = (self.every, self.chosen.clone());
        let job = self.job(&|| false)?;
        if path >= job.paths {
            let wrong = format!("path {path} of {}: they are numbered from 0", job.paths);
            return Err(ConfigError::Setting(wrong).into());
        }
        let chosen = chosen_steps(&chosen, job.start.t, job.h, job.steps)?;
        let recording = Recording { every, chosen };
        let mut recorder = Recorder::new(&job.start, job.h, job.system.noises(), &recording, job.steps)?;
        // Antithetic paths come in pairs.
        let (first, lane) = (path - path % 2, (path % 2) as usize);
        let mut group = Group::<H, E, 2>::new(&job);
        group.begin(first, job.paths);
        let mut state = job.start.clone();
        for step in 0..job.steps {
            group.draw(step);
            let dw = group.increments_of(lane, step).to_vec();
            group.advance(step);
            if let Some(error) = job.failed_noise.get() {
                return Ok((recorder.finish(state), Some(error.clone().into())));
            }
            if let Some(failure) = group.failure_of(path) {
                return Ok((recorder.finish(state), Some(failure.error.into())));
            }
            state.clone_from(group.state_after(lane, step + 1));
            recorder.step(&dw, &StepInfo::default());
            recorder.reach(&state);
        }
        Ok((recorder.finish(state), None))
    }
}
