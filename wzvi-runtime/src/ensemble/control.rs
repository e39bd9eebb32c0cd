//! What ends a run before all its paths are done.

use super::statistics::{Node, Statistics};
use crate::error::ConfigError;

/// An error that is estimated from fewer paths is not trusted.
const LEAST_PATHS: u64 = 1024;

/// What the user wants of a run besides its result.
#[derive(Default)]
pub(super) struct Control<'a> {
    pub(super) stop: Option<Box<dyn Fn() -> bool + Send + Sync + 'a>>,
    /// Observables and the standard errors that are small enough for them.
    pub(super) targets: Vec<(String, f64)>,
    pub(super) is_quiet: bool,
}

impl Control<'_> {
    pub(super) fn is_stopped(&self) -> bool {
        self.stop.as_ref().is_some_and(|stop| stop())
    }

    /// The targets, if they are for some of the observables `names`.
    pub(super) fn targets(&self, names: &[String]) -> Result<Targets, ConfigError> {
        let target = |(name, target): &(String, f64)| {
            if !(target.is_finite() && *target > 0.0) {
                let wrong = format!("a standard error of {target} as target: take a finite number above 0");
                return Err(ConfigError::Setting(wrong));
            }
            match names.iter().position(|known| known == name) {
                Some(observable) => Ok((observable, *target)),
                None => Err(ConfigError::Setting(format!(
                    "an error of `{name}`, which is none of the observables ({})",
                    names.join(", ")
                ))),
            }
        };
        Ok(Targets(self.targets.iter().map(target).collect::<Result<_, _>>()?))
    }
}

/// Observables by index, with the standard errors that are small enough.
pub(super) struct Targets(Vec<(usize, f64)>);

impl Targets {
    /// Whether all errors are small enough, and about how many paths that takes, of `limit` at most.
    pub(super) fn look(&self, statistics: &Statistics, limit: u64) -> (bool, u64) {
        let Some(end) = statistics.last() else { return (false, limit) };
        if self.0.is_empty() {
            return (false, limit);
        }
        let ratio = self.ratio(end);
        // Also for NaN, where paths have no finite values: only the limit ends the run.
        let expected = (ratio * ratio * statistics.begun() as f64).ceil();
        let expected = if expected < limit as f64 { expected as u64 } else { limit };
        (end.count() >= LEAST_PATHS && ratio <= 1.0, expected)
    }

    /// Whether all errors are small enough, if there are targets.
    pub(super) fn met(&self, statistics: &Statistics) -> Option<bool> {
        let end = statistics.last().filter(|_| !self.0.is_empty())?;
        Some(end.count() >= LEAST_PATHS && self.ratio(end) <= 1.0)
    }

    /// The largest error in units of its target; NaN if one is.
    fn ratio(&self, end: &Node) -> f64 {
        let ratios = self.0.iter().map(|&(observable, target)| end.standard_error(observable) / target);
        ratios.fold(0.0, |largest, ratio| if ratio <= largest { largest } else { ratio })
    }
}
