//! What paths beside each other show at the nodes of a run: observables, events, and what became of each.

use super::group::Group;
use super::halt::Halt;
use super::job::Job;
use super::pace::Pace;
use super::passage::{Passage, crossing};
use super::statistics::Statistics;
use crate::error::{Error, InternalError};
use crate::steps::Monitor;
use crate::system::Discretized;

/// Collects the statistics of one group of paths after the other.
pub(super) struct Observation<'j, 'a, H: Discretized<E>, E, const L: usize> {
    job: &'j Job<'a, H, E>,
    statistics: Statistics,
    pace: Pace<'j>,
    /// The last node that was looked at, and which of the recorded ones comes next.
    seen: u64,
    next: usize,
    /// What each event's function was at the last node.
    before: Vec<[f64; L]>,
    /// When each event happened; NaN before.
    passed: Vec<[f64; L]>,
    /// Number of each lane among the paths that are kept.
    kept: [usize; L],
    values: Vec<f64>,
    /// The values of the other path of an antithetic pair.
    first_of_pair: Vec<f64>,
    scratch: Vec<f64>,
}

impl<'j, 'a, H: Discretized<E>, E, const L: usize> Observation<'j, 'a, H, E, L> {
    pub(super) fn new(job: &'j Job<'a, H, E>) -> Self {
        let (events, observables) = (job.events.len(), job.observables.len());
        Self {
            job,
            statistics: Statistics::new(&job.wanted),
            pace: Pace::new(job.stop),
            seen: 0,
            next: 0,
            before: vec![[0.0; L]; events],
            passed: vec![[0.0; L]; events],
            kept: [0; L],
            values: vec![0.0; observables],
            first_of_pair: vec![0.0; observables],
            scratch: vec![0.0; observables],
        }
    }

    /// The paths of a group at their start.
    ///
    /// # Errors
    /// If the run was stopped on the way.
    pub(super) fn begin(&mut self, group: &mut Group<'_, '_, H, E, L>) -> Result<(), Halt> {
        (self.seen, self.next) = (0, 0);
        if let Some(paths) = &mut self.statistics.paths {
            for lane in (0..L).filter(|&lane| group.is_path(lane)) {
                self.kept[lane] = paths.begin();
            }
        }
        for lane in (0..L).filter(|_| !self.job.events.is_empty()) {
            let start = group.state_at(lane, 0);
            let memory = self.before.iter_mut().zip(&mut self.passed);
            for ((before, passed), event) in memory.zip(&self.job.events) {
                before[lane] = event(start);
                passed[lane] = if before[lane] == 0.0 { start.t } else { f64::NAN };
            }
        }
        self.record(group, 0)
    }

    /// Looks for the events of the step that ended at this node.
    #[inline(never)]
    fn watch(&mut self, group: &mut Group<'_, '_, H, E, L>, node: u64) {
        let Job { start, h, .. } = self.job;
        let times = [node - 1, node].map(|node| start.t + node as f64 * h);
        for lane in 0..L {
            let is_over = !group.is_path(lane) || group.has_failed(lane);
            if is_over || self.passed.iter().all(|passed| !passed[lane].is_nan()) {
                continue;
            }
            let state = group.state_at(lane, node);
            let memory = self.before.iter_mut().zip(&mut self.passed);
            for ((before, passed), event) in memory.zip(&self.job.events) {
                if passed[lane].is_nan() {
                    let after = event(state);
                    if let Some(time) = crossing(times, [before[lane], after]) {
                        passed[lane] = time;
                    }
                    before[lane] = after;
                }
            }
        }
    }

    /// Adds the paths that are still there to the statistics of the next recorded node, which is this one.
    #[inline(never)]
    fn record(&mut self, group: &mut Group<'_, '_, H, E, L>, node: u64) -> Result<(), Halt> {
        let (job, place) = (self.job, self.next);
        let missing =
            || Error::from(InternalError::new("a recorded node has statistics", format!("node {node}")));
        let moments = self.statistics.nodes.get_mut(place).ok_or_else(missing)?;
        for lane in 0..L {
            self.pace.done(1)?;
            if !group.is_path(lane) {
                continue;
            }
            if group.has_failed(lane) {
                moments.lose();
                continue;
            }
            let path = group.path(lane);
            let state = group.state_at(lane, node);
            if let Some(see) = &job.inspector {
                see(path, state);
            }
            for (value, observable) in self.values.iter_mut().zip(&job.observables) {
                *value = observable(state);
            }
            moments.push(&self.values, &mut self.scratch, &job.wanted);
            if let Some(paths) = &mut self.statistics.paths {
                paths.put(self.kept[lane], place, &self.values);
            }
            if job.wanted.has_pairs {
                if lane.is_multiple_of(2) {
                    self.first_of_pair.copy_from_slice(&self.values);
                } else if !group.has_failed(lane - 1) {
                    moments.push_pair(&mut self.first_of_pair, &self.values, &mut self.scratch);
                }
            }
        }
        self.next += 1;
        Ok(())
    }

    /// What became of the paths of a group, in the order of their numbers.
    pub(super) fn finish(&mut self, group: &mut Group<'_, '_, H, E, L>) {
        let failures = group.take_failures();
        let watched = self.statistics.passages.iter_mut().zip(&self.passed).zip(&self.job.wanted.watches);
        for ((passages, passed), watch) in watched {
            let mut failures = failures.iter();
            for lane in (0..L).filter(|&lane| group.is_path(lane)) {
                let failure = if group.has_failed(lane) { failures.next() } else { None };
                let passage = match failure {
                    _ if !passed[lane].is_nan() => Passage::At(passed[lane]),
                    Some(failure) => Passage::Lost(failure.error.t),
                    None => Passage::Censored,
                };
                passages.push(passage, watch);
            }
        }
        failures.into_iter().for_each(|failure| self.statistics.fail(failure));
    }

    /// The statistics of all groups.
    pub(super) fn into_statistics(self) -> Statistics {
        self.statistics
    }
}

impl<'g, 'j, 'a, H: Discretized<E>, E, const L: usize> Monitor<Group<'g, 'a, H, E, L>>
    for Observation<'j, 'a, H, E, L>
{
    type Error = Halt;

    #[inline(always)]
    fn next(&self, _group: &Group<'g, 'a, H, E, L>, node: u64) -> u64 {
        let recorded = self.job.recorded.get(self.next).map_or(u64::MAX, |recorded| recorded.node);
        let watched = if self.job.events.is_empty() { u64::MAX } else { node + 1 };
        recorded.min(watched).min(node.saturating_add(self.pace.left()))
    }

    #[inline(always)]
    fn look(&mut self, group: &mut Group<'g, 'a, H, E, L>, node: u64) -> Result<(), Halt> {
        self.pace.done(node - self.seen)?;
        self.seen = node;
        if !self.job.events.is_empty() {
            self.watch(group, node);
        }
        if self.job.recorded.get(self.next).is_some_and(|recorded| recorded.node == node) {
            self.record(group, node)?;
        }
        Ok(())
    }
}
