//! The noise of the paths of an ensemble: the normals of its lanes, or any noise that has a path for each
//! member.

use crate::error::wrong;
use crate::increments::{Identity, Interval};
use crate::noise::{Driver, Paths, StepNormals, Truncation};
use crate::scheme::plan::Plan;
use crate::trajectory::Error;

/// The source of the increments of an ensemble.
pub(super) struct NoiseSource<'a> {
    /// Queried path by path.
    noise: Box<dyn Driver + 'a>,
    /// The same noise, if lanes draw it.
    pub(super) normals: Option<StepNormals>,
}

impl<'a> NoiseSource<'a> {
    pub(super) fn new(noise: impl Paths + Clone + Send + Sync + 'a) -> Self {
        Self { normals: noise.step_normals(), noise: Box::new(noise) }
    }

    /// With what the builder says of it, and ready for a run of so many steps from `first` on.
    pub(super) fn prepared(
        self,
        settings: NormalSettings,
        plan: &Plan,
        first: Interval,
        (processes, steps): (usize, u64),
    ) -> Result<Self, Error> {
        let NormalSettings { truncation, is_antithetic } = settings;
        let mut noise = self.noise;
        match self.normals {
            Some(normals) => {
                if truncation != Truncation::Unset && normals.truncation() != Truncation::Unset {
                    return wrong(
                        "`truncation(...)` and a noise with a truncation of its own: leave one of them out",
                    );
                }
                let normals = normals.with_truncation(truncation);
                noise = Box::new(if is_antithetic { normals.antithetic() } else { normals });
            }
            None if is_antithetic => {
                return wrong(
                    "`antithetic()` and a noise that is not `StepNormals`, whose paths have no pairs: leave one of them out",
                );
            }
            None if truncation != Truncation::Unset => {
                return wrong(
                    "`truncation(...)` and `noise(...)`: leave one of them out, and truncate the noise itself, as in \
                     `Wiener::seed(7).truncated(4)`",
                );
            }
            None => {}
        }
        noise.prepare(plan, first.h, processes, first.start)?;
        // A source that ends too early is an error before the run.
        if let Some(step) = steps.checked_sub(1) {
            noise.increments(&Interval { step, ..first }, &mut vec![0.0; processes])?;
        }
        Ok(Self { normals: noise.step_normals(), noise })
    }

    /// The noise of one path, which drives a [`Simulation`](crate::trajectory::simulate::Simulation) just so.
    pub(super) fn path(&self, path: u64) -> Box<dyn Paths + '_> {
        let mut noise = self.noise.copy();
        noise.set_path(path);
        noise
    }

    pub(super) fn is_antithetic(&self) -> bool {
        self.normals.as_ref().is_some_and(StepNormals::is_antithetic)
    }

    /// The largest normal for steps of size `h`, in absolute value; infinite for other noises, which truncate
    /// by themselves.
    pub(super) fn clip(&self, h: f64) -> f64 {
        self.normals.as_ref().map_or(f64::INFINITY, |normals| normals.clip(h))
    }

    /// The largest increment of a step of size `h`, in absolute value.
    pub(super) fn largest_increment(&self, h: f64) -> f64 {
        self.noise.largest_increment(h)
    }

    /// The seed; 0 of a noise that has none.
    pub(super) fn seed(&self) -> u64 {
        self.noise.seed_number().unwrap_or(0)
    }

    /// The name of the noise, for people.
    pub(super) fn in_words(&self) -> String {
        self.identity().map_or_else(|| "given".to_owned(), |identity| identity.to_string())
    }

    /// The identity of the noise; `None` if it does not promise to be the same again.
    pub(super) fn identity(&self) -> Option<Identity> {
        self.noise.identity()
    }
}

/// The settings of normals.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct NormalSettings {
    pub(super) truncation: Truncation,
    pub(super) is_antithetic: bool,
}
