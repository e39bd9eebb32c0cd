//! What a run of paths was asked for: what its results are of.

use super::job::Job;
use crate::names::short_name;
use crate::system::Discretized;

/// The settings without which a result means nothing.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Origin {
    pub(super) system: String,
    pub(super) scheme: String,
    pub(super) h: f64,
    /// Time of the first state.
    pub(super) start: f64,
    pub(super) steps: u64,
    /// 0 for a noise without one.
    pub(super) seed: u64,
    /// What the increments are of, in words; `none` where the steps take none.
    pub(super) noise: String,
    /// Paths that were asked for, at most.
    pub(super) paths: u64,
}

impl Origin {
    pub(super) fn of<H: Discretized<E>, E>(job: &Job<'_, H, E>) -> Self {
        Self {
            system: short_name::<H>(),
            scheme: short_name::<E>(),
            h: job.h,
            start: job.start.t,
            steps: job.steps,
            seed: job.seed,
            noise: if job.processes() == 0 { "none".into() } else { job.source.in_words() },
            paths: job.paths,
        }
    }
}
