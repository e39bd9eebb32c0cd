//! Which nodes of a run are recorded.

use crate::error::ConfigError;
use crate::span::steps_between;

/// The nodes to record, as the user says them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Request {
    /// Every so many steps; 0 for none.
    pub(crate) every: Option<u64>,
    /// At the first nodes at or beyond these times.
    pub(crate) times: Vec<f64>,
}

impl Request {
    /// Those of a run of so many steps of size `h` from the time `start`; every `default` steps if nothing was said.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] for a time that the run does not get to.
    pub(crate) fn checked(
        &self,
        default: u64,
        (start, h, steps): (f64, f64, u64),
    ) -> Result<Recording, ConfigError> {
        let every = self.every.unwrap_or(if self.times.is_empty() { default } else { 0 });
        Ok(Recording { every, chosen: chosen_steps(&self.times, start, h, steps)? })
    }
}

/// Which nodes a run records, besides the start and the end.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Recording {
    /// Every so many steps; 0 for none.
    pub(crate) every: u64,
    /// After so many steps, in order.
    pub(crate) chosen: Vec<u64>,
}

impl Recording {
    /// All recorded nodes of a run of so many steps: 0, those asked for, the last.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] if there are more than `most`.
    #[cfg(feature = "ensemble")]
    pub(crate) fn all(&self, steps: u64, most: u64) -> Result<Vec<u64>, ConfigError> {
        let every = if self.every == 0 { steps.max(1) } else { self.every };
        let nodes = steps.div_ceil(every).saturating_add(self.chosen.len() as u64);
        if nodes > most {
            let wrong = format!("statistics at {nodes} nodes: take a larger `record_every`");
            return Err(ConfigError::Setting(wrong));
        }
        let mut all: Vec<u64> = (0..=steps.div_ceil(every)).map(|node| steps.min(node * every)).collect();
        all.extend(&self.chosen);
        all.sort_unstable();
        all.dedup();
        Ok(all)
    }

    /// Whether a run adds nodes before its end.
    #[cfg(feature = "serde")]
    pub(crate) fn adds(&self) -> bool {
        self.every > 0 || !self.chosen.is_empty()
    }

    /// Chosen nodes up to this step that are not recorded anyway.
    pub(crate) fn extra(&self, step: u64) -> u64 {
        let is_regular = |chosen: u64| chosen.checked_rem(self.every) == Some(0);
        let extra = self.chosen.iter().filter(|&&chosen| chosen > 0 && chosen <= step && !is_regular(chosen));
        extra.count() as u64
    }

    /// Nodes after the start that are recorded when this step has been taken, the end not counted.
    #[cfg(feature = "serde")]
    pub(crate) fn nodes(&self, step: u64) -> u64 {
        step.checked_div(self.every).unwrap_or(0) + self.extra(step)
    }

    /// The next step, after this one, whose node is recorded; the largest number if there is none.
    pub(crate) fn next(&self, step: u64) -> u64 {
        let regular = step.checked_div(self.every).map(|count| (count + 1).saturating_mul(self.every));
        let chosen = self.chosen.get(self.chosen.partition_point(|&chosen| chosen <= step)).copied();
        regular.unwrap_or(u64::MAX).min(chosen.unwrap_or(u64::MAX))
    }
}

/// The steps before the nodes at these times, in order: each the first at or beyond it.
fn chosen_steps(times: &[f64], start: f64, h: f64, steps: u64) -> Result<Vec<u64>, ConfigError> {
    let step = |&time: &f64| match steps_between(start, time, h) {
        Some(step) if step <= steps => Ok(step),
        _ => {
            let end = start + steps as f64 * h;
            let wrong = format!("recorded at t = {time}, which is not between {start} and {end}");
            Err(ConfigError::Setting(wrong))
        }
    };
    let mut chosen: Vec<u64> = times.iter().map(step).collect::<Result<_, _>>()?;
    chosen.sort_unstable();
    chosen.dedup();
    Ok(chosen)
}
