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
            let mut values = Vec::new();
            for system in &job.systems.own {
                values.push(system.parameter(index).map_or(f64::NAN, |(_, value)| value));
            }
            let first = values.first().copied().unwrap_or(own);
            if are_all(&values, first) {
                parameters.push((name.to_owned(), first));
            } else if job.observed.empty.paths.is_some() {
                varying.push((name.to_owned(), values));
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

/// Whether each of these numbers is the same, to the last bit.
fn are_all(values: &[f64], first: f64) -> bool {
    values.iter().all(|value| value.to_bits() == first.to_bits())
}
