//! The settings of an ensemble that were made.
//!
//! Tested by `tests/paths/refused.rs` and `tests/ensembles/chaos.rs`.

use super::control::Control;
use super::source::{NoiseSource, NormalSettings};
use super::{EnsembleSettings, EnsembleSetup, ExtraStatistics};
use crate::scheme::system::Hamiltonian;
use crate::trajectory::made_settings::{MadeSetting, made};

/// The settings that were made: those of all runs of paths, then those of ensembles only.
pub(super) fn made_of<H: Hamiltonian>(setup: &EnsembleSetup<'_, H>) -> impl Iterator<Item = MadeSetting> {
    let EnsembleSettings {
        starts,
        systems,
        paths: _,
        source,
        settings: NormalSettings { truncation: _, is_antithetic },
        own,
        events,
        wanted,
        inspector,
        control: Control { targets, losses },
    } = &setup.more;
    let ExtraStatistics {
        quantiles,
        covariances,
        histograms,
        most_bytes,
        most_crossings,
        has_work,
        // Never without work.
        has_weight: _,
        added,
    } = wanted;
    let noise = source.value();
    let of_ensemble = made([
        (MadeSetting::Antithetic, *is_antithetic || noise.is_some_and(NoiseSource::is_antithetic)),
        (MadeSetting::OtherNoise, noise.is_some_and(|noise| noise.normals.is_none())),
        (MadeSetting::Systems, systems.value().is_some()),
        (MadeSetting::Starts, starts.value().is_some()),
        (MadeSetting::OwnObservables, !own.is_empty()),
        (MadeSetting::FirstPassage, !events.is_empty()),
        (MadeSetting::Quantiles, *quantiles),
        (MadeSetting::Histogram, !histograms.is_empty()),
        (MadeSetting::Covariances, covariances.is_some()),
        (MadeSetting::KeepPaths, most_bytes.is_some()),
        (MadeSetting::KeepCrossings, *most_crossings > 0),
        (MadeSetting::Inspect, inspector.is_some()),
        (MadeSetting::ObserveWork, *has_work),
        (MadeSetting::Statistic, !added.is_empty()),
        (MadeSetting::UntilError, !targets.is_empty()),
        (MadeSetting::AllowLosses, losses.is_some()),
    ]);
    setup.made().chain(of_ensemble)
}
