//! The choice of the nodes, and of the times between them, that a run records.

use crate::error::{ConfigError, wrong};
use crate::ground::digits::ShortestDecimal;
use crate::trajectory::span::{NodeGrid, NodeOrInside};

/// The user's request for recorded nodes and times.
#[derive(Clone, Debug, Default)]
pub(crate) struct RecordingRequest {
    /// Every so many steps; 0 for none.
    pub(crate) every: Option<u64>,
    /// At these times.
    pub(crate) times: Vec<f64>,
}

impl RecordingRequest {
    /// The recording of a run with these nodes; every `default` steps if nothing was said.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] for a time that the run does not get to, or that does not come after the one
    /// before.
    pub(crate) fn checked(&self, default: u64, grid: &NodeGrid) -> Result<Recording, ConfigError> {
        let every = self.every.unwrap_or(if self.times.is_empty() { default } else { 0 });
        let (times, is_clocked) = (self.times.clone(), grid.is_clocked);
        if let (true, None, Some(&t)) = (is_clocked, grid.end, times.last()) {
            let t = ShortestDecimal(t);
            return wrong(format!(
                "`record_at` with `steps`, of a clock: no one knows before whether so many steps get to t = {t}; \
                 write `.until({t})` in place of `.steps(number)`"
            ));
        }
        let mut recording = Recording { every, times, is_clocked, ..Recording::default() };
        let mut before = f64::NAN;
        for &t in &self.times {
            let Some(place) = grid.place(t) else {
                let [t, start, end] = [t, grid.time(0), grid.time(grid.steps)].map(ShortestDecimal);
                return wrong(format!("recorded at t = {t}, which is not between {start} and {end}"));
            };
            if (t - before) / grid.h <= 0.0 {
                let [t, before] = [t, before].map(ShortestDecimal);
                return wrong(format!(
                    "recorded at t = {t} after t = {before}: give the times in the order of the run, each once"
                ));
            }
            before = t;
            match place {
                NodeOrInside::Node(node) if recording.chosen.last() == Some(&node) => {
                    return wrong(format!(
                        "recorded at t = {t:?} and at the time before it, which are the same node up to rounding: give one of them"
                    ));
                }
                NodeOrInside::Node(node) => recording.chosen.push(node),
                NodeOrInside::Inside(step) => recording.between.push(TimeInStep { step, t }),
            }
        }
        Ok(recording)
    }
}

/// A time inside a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TimeInStep {
    /// The number of the step.
    pub(crate) step: u64,
    pub(crate) t: f64,
}

/// The recorded nodes and times of a run, besides its start and end.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Recording {
    /// Every so many steps; 0 for none.
    pub(crate) every: u64,
    /// The times that were asked for, in order: after the `chosen` numbers of steps, or `between` nodes.
    pub(crate) times: Vec<f64>,
    /// After so many steps, in order.
    pub(crate) chosen: Vec<u64>,
    /// Inside steps, in order.
    pub(crate) between: Vec<TimeInStep>,
    /// Whether the steps that these times are in are not known before.
    pub(crate) is_clocked: bool,
}

impl Recording {
    /// All recorded times of a run, in order: the start, the requested times, the end.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] if there are more than `most`.
    pub(crate) fn all(&self, grid: &NodeGrid, most: u64) -> Result<Vec<RecordedTime>, ConfigError> {
        let steps = grid.steps;
        let every = if self.every == 0 { steps.max(1) } else { self.every };
        let asked = (self.chosen.len() + self.between.len()) as u64;
        let nodes = steps.div_ceil(every).saturating_add(asked);
        if nodes > most {
            return wrong(format!("statistics at {nodes} nodes: take a larger `record_every`"));
        }
        let regular = (0..=steps.div_ceil(every)).map(|node| steps.min(node * every));
        let nodes = regular.chain(self.chosen.iter().copied());
        let mut all: Vec<RecordedTime> =
            nodes.map(|node| RecordedTime { node, t: grid.time(node), is_inside: false }).collect();
        all.extend(self.between.iter().map(|moment| RecordedTime {
            node: moment.step + 1,
            t: moment.t,
            is_inside: true,
        }));
        // Before its end comes what is inside of a step, in the order that it has.
        all.sort_by_key(|recorded| (recorded.node, !recorded.is_inside));
        all.dedup();
        Ok(all)
    }

    /// Chosen nodes up to this step that are not recorded anyway.
    pub(crate) fn extra(&self, step: u64) -> u64 {
        let is_regular = |chosen: u64| chosen.checked_rem(self.every) == Some(0);
        let extra = self.chosen.iter().filter(|&&chosen| chosen > 0 && chosen <= step && !is_regular(chosen));
        extra.count() as u64
    }

    /// Times inside of the first so many steps.
    pub(crate) fn inside(&self, steps: u64) -> usize {
        self.between.partition_point(|moment| moment.step < steps)
    }

    /// The number of nodes and times recorded after the start up to this step, the end not counted.
    pub(crate) fn nodes(&self, step: u64) -> u64 {
        step.checked_div(self.every).unwrap_or(0) + self.extra(step) + self.inside(step) as u64
    }

    /// The next step, after this one, whose node is recorded; the largest number if there is none.
    pub(crate) fn next_recorded(&self, step: u64) -> u64 {
        let regular = step.checked_div(self.every).map(|count| (count + 1).saturating_mul(self.every));
        let chosen = self.chosen.get(self.chosen.partition_point(|&chosen| chosen <= step)).copied();
        regular.unwrap_or(u64::MAX).min(chosen.unwrap_or(u64::MAX))
    }
}

/// A recorded time of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RecordedTime {
    /// The node, or that at the end of the step that has it inside.
    pub(crate) node: u64,
    pub(crate) t: f64,
    pub(crate) is_inside: bool,
}
