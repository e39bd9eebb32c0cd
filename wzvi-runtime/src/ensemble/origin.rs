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
    /// Parameters by name that are those of all paths.
    pub(super) parameters: Vec<(String, f64)>,
    /// Those that are not, path by path, where paths are kept.
    pub(super) varying: Vec<(String, Vec<f64>)>,
}

impl Origin {
    pub(super) fn of<H: Discretized<E>, E>(job: &Job<'_, H, E>) -> Self {
        let (mut parameters, mut varying) = (Vec::new(), Vec::new());
        for index in 0.. {
            let Some((name, own)) = job.system.parameter(index) else { break };
            let value = |system: &H| system.parameter(index).map_or(f64::NAN, |(_, value)| value);
            let first = job.systems.first().map_or(own, value);
            if job.systems.iter().all(|system| value(system).to_bits() == first.to_bits()) {
                parameters.push((name.to_owned(), first));
            } else if job.wanted.keeps_paths {
                varying.push((name.to_owned(), job.systems.iter().map(value).collect()));
            }
        }
        Self {
            parameters,
            varying,
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
