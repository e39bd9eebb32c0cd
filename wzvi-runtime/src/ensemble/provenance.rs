//! The settings of a run of paths, which identify its results.

use super::job::EnsembleJob;
use crate::ground::names::short_name;
use crate::scheme::system::{Discretized, disequilibrium};
use crate::statistics::Provenance;

impl Provenance {
    pub(super) fn of<H: Discretized<E>, E>(job: &EnsembleJob<'_, H, E>) -> Self {
        let (mut parameters, mut varying) = (Vec::new(), Vec::new());
        for index in 0.. {
            let Some((name, own)) = job.systems.common.parameter(index) else { break };
            let value = |system: &H| system.parameter(index).map_or(f64::NAN, |(_, value)| value);
            let first = job.systems.own.first().map_or(own, value);
            if job.systems.own.iter().all(|system| value(system).to_bits() == first.to_bits()) {
                parameters.push((name.to_owned(), first));
            } else if job.observed.empty.paths.is_some() {
                varying.push((name.to_owned(), job.systems.own.iter().map(value).collect()));
            }
        }
        Self {
            parameters,
            varying,
            system: short_name::<H>(),
            scheme: short_name::<E>(),
            no_equilibrium: disequilibrium(&H::PLAN, &H::PROPERTIES),
            h: job.grid.h,
            start: job.starts.first.t,
            steps: job.grid.steps,
            seed: job.starts.seed,
            noise: if job.processes() == 0 { "none".into() } else { job.source.in_words() },
            paths: job.paths,
        }
    }
}
