//! What paths beside each other show at the nodes of a run: observables, events, and what became of each.

use super::group::Group;
use super::job::Job;
use super::pace::Pace;
use super::starts::Systems;
use crate::algebra::state::{State, Vector, copy_state};
use crate::error::StoppedError;
use crate::path::Error;
use crate::path::recording::Recorded;
use crate::path::section::{Crossing, Sections, Watch, first_zero};
use crate::path::steps::Advance;
use crate::scheme::dense::DenseOutput;
use crate::scheme::system::Discretized;
use crate::statistics::{Passage, PathFailure, Seen, Statistics, crossing};

/// Collects the statistics of one group of paths after the other.
pub(super) struct Observation<'j, 'a, H: Discretized<E>, E, const L: usize> {
    job: &'j Job<'a, H, E>,
    pub(super) statistics: Statistics,
    pace: Pace<'j>,
    /// The last node that was looked at, and which of the recorded ones comes next.
    seen: u64,
    next: usize,
    /// What each event's function was at the last node.
    before: Vec<[f64; L]>,
    /// When each event happened; NaN before.
    passed: Vec<[f64; L]>,
    /// The values of events at both nodes of the step in which they happened, of one lane.
    changes: Vec<Option<[f64; 2]>>,
    /// What is needed to look inside steps, by lane; none if nobody does.
    lanes: Vec<LaneInside<H::Vector>>,
    values: Vec<f64>,
}

/// What looks inside the steps of one lane.
struct LaneInside<V> {
    /// The state at the last node that was looked at.
    before: State<V>,
    dense: DenseOutput<V>,
    watch: Watch<V>,
    /// Crossings of the path so far, by section.
    counts: Vec<u64>,
    /// A recorded state.
    room: State<V>,
}

impl<V: Vector> LaneInside<V> {
    fn of_lanes(lanes: usize, sections: &Sections<'_, V>, start: &State<V>) -> Vec<Self> {
        (0..lanes).map(|_| Self::new(sections, start)).collect()
    }

    fn new(sections: &Sections<'_, V>, start: &State<V>) -> Self {
        Self {
            before: start.clone(),
            dense: DenseOutput::of(start),
            watch: Watch::new(sections, start),
            counts: vec![0; sections.len()],
            room: start.clone(),
        }
    }
}

impl<'j, 'a, H: Discretized<E>, E, const L: usize> Observation<'j, 'a, H, E, L> {
    pub(super) fn new(job: &'j Job<'a, H, E>) -> Self {
        let (events, observables) = (job.events.len(), job.observables.len());
        let looks_inside = job.looks_between();
        let lanes = if looks_inside { L } else { 0 };
        Self {
            job,
            statistics: job.empty.clone(),
            pace: Pace::new(job.stop),
            seen: 0,
            next: 0,
            before: vec![[0.0; L]; events],
            passed: vec![[0.0; L]; events],
            changes: vec![None; events],
            lanes: LaneInside::of_lanes(lanes, &job.sections, &job.start),
            values: vec![0.0; observables],
        }
    }

    /// The paths of a group at their start.
    ///
    /// # Errors
    /// If the run was stopped on the way.
    pub(super) fn begin<P: Systems>(&mut self, group: &mut Group<'_, '_, H, E, P, L>) -> Result<(), Error> {
        (self.seen, self.next) = (0, 0);
        for lane in if self.job.events.is_empty() { 0..0 } else { 0..L } {
            let start = group.state_at(lane, 0);
            let memory = self.before.iter_mut().zip(&mut self.passed);
            for ((before, passed), event) in memory.zip(&self.job.events) {
                before[lane] = event(start);
                passed[lane] = if before[lane] == 0.0 { start.t } else { f64::NAN };
            }
        }
        for (lane, LaneInside { before, watch, dense, counts, .. }) in self.lanes.iter_mut().enumerate() {
            copy_state(before, group.state_at(lane, 0));
            watch.begin(&self.job.sections, before);
            dense.forget();
            counts.fill(0);
        }
        self.record(group, 0)
    }

    /// Looks for the events of the step that ended at this node.
    #[inline(never)]
    fn watch<P: Systems>(&mut self, group: &mut Group<'_, '_, H, E, P, L>, node: u64) -> Result<(), Error> {
        let times = [node - 1, node].map(|node| self.job.grid.time(node));
        for lane in 0..L {
            let is_over = !group.is_path(lane) || group.has_failed(lane);
            if is_over || have_passed(&self.passed, lane) {
                continue;
            }
            let mut crossed = false;
            let state = group.state_at(lane, node);
            let memory = self.before.iter_mut().zip(&mut self.passed).zip(&mut self.changes);
            for (((before, passed), change), event) in memory.zip(&self.job.events) {
                *change = None;
                if passed[lane].is_nan() {
                    let values = [before[lane], event(state)];
                    if let Some(time) = crossing(times, values) {
                        (passed[lane], *change, crossed) = (time, Some(values), true);
                    }
                    before[lane] = values[1];
                }
            }
            if crossed && self.job.processes() == 0 {
                self.refine(group, lane, node)?;
            }
        }
        Ok(())
    }

    /// The times of the events that happened in the step of a lane before this node, on its dense output.
    #[cold]
    fn refine<P: Systems>(
        &mut self,
        group: &mut Group<'_, '_, H, E, P, L>,
        lane: usize,
        node: u64,
    ) -> Result<(), Error> {
        let Some(LaneInside { before, dense, room, .. }) = self.lanes.get_mut(lane) else { return Ok(()) };
        let (events, changes, passed) = (&self.job.events, &mut self.changes, &mut self.passed);
        group.look_inside(lane, node, before, dense, &mut |dense, _, _| {
            for ((event, change), passed) in events.iter().zip(&mut *changes).zip(&mut *passed) {
                let Some([value, _]) = change else { continue };
                let next = event(dense.end());
                match first_zero(dense, &**event, [*value, next], room) {
                    Some(time) => (passed[lane], *change) = (time, None),
                    None => *value = next,
                }
            }
        })
    }

    /// Counts the crossings of the step that ended at this node.
    #[inline(never)]
    fn follow<P: Systems>(&mut self, group: &mut Group<'_, '_, H, E, P, L>, node: u64) -> Result<(), Error> {
        let (sections, statistics) = (&self.job.sections, &mut self.statistics);
        for (lane, LaneInside { before, dense, watch, counts, .. }) in self.lanes.iter_mut().enumerate() {
            if !group.is_path(lane) || group.has_failed(lane) {
                continue;
            }
            let path = group.path(lane);
            group.look_inside(lane, node, before, dense, &mut |dense, _, _| {
                watch.follow(sections, dense, |Crossing { section, direction, state }| {
                    let (before, t) = (counts[section], state.t);
                    let (q, p) = (state.q.components(), state.p.components());
                    statistics.see(path, &Seen::Crossing { section, before, direction, t, q, p });
                    counts[section] += 1;
                });
            })?;
        }
        Ok(())
    }

    /// This much more work is done, at a node.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn work(&mut self, pieces: u64, node: u64) -> Result<(), StoppedError> {
        let stopped = StoppedError { done: node, all: self.job.steps };
        if self.pace.ends_after(pieces) { Err(stopped) } else { Ok(()) }
    }

    /// Adds the paths that are still there to the statistics of all recorded times that belong to this node.
    #[inline(never)]
    fn record<P: Systems>(&mut self, group: &mut Group<'_, '_, H, E, P, L>, node: u64) -> Result<(), Error> {
        while let Some(recorded) = self.job.recorded.get(self.next).filter(|recorded| recorded.node == node) {
            self.record_at(group, recorded)?;
            self.next += 1;
        }
        Ok(())
    }

    fn record_at<P: Systems>(
        &mut self,
        group: &mut Group<'_, '_, H, E, P, L>,
        &Recorded { node, t, is_inside }: &Recorded,
    ) -> Result<(), Error> {
        let (job, place) = (self.job, self.next);
        for lane in 0..L {
            self.work(1, node)?;
            if !group.is_path(lane) {
                continue;
            }
            let path = group.path(lane);
            if const { P::ARE_PAIRED } {
                let values = &group.end_of_pair(lane).map_err(Error::Level)?;
                self.statistics.see(path, &Seen::Values { node: place, values });
                continue;
            }
            if group.has_failed(lane) {
                self.statistics.see(path, &Seen::Lost { node: place });
                continue;
            }
            let state = match self.lanes.get_mut(lane) {
                Some(LaneInside { before, dense, room, .. }) if is_inside => {
                    let mut is_found = false;
                    group.look_inside(lane, node, before, dense, &mut |dense, _, is_last| {
                        let theta = dense.fraction(t);
                        if !is_found && (theta <= 1.0 || is_last) {
                            dense.write(theta.clamp(0.0, 1.0), room);
                            is_found = true;
                        }
                    })?;
                    room.t = t;
                    &*room
                }
                _ => group.state_at(lane, node),
            };
            if let Some(see) = &job.inspector {
                see(path, state);
            }
            job.observe(path, state, &mut self.values);
            if let Some(first) = job.own_work {
                let own = group.work_of(lane, node)?;
                self.values[first..first + own.len()].copy_from_slice(&own);
            }
            self.statistics.see(path, &Seen::Values { node: place, values: &self.values });
        }
        Ok(())
    }

    /// What became of the paths of a group, in the order of their numbers.
    pub(super) fn finish<P: Systems>(&mut self, group: &mut Group<'_, '_, H, E, P, L>) {
        let failures = group.take_failures();
        for (event, passed) in self.passed.iter().enumerate() {
            let mut failures = failures.iter();
            for (lane, time) in passed.iter().enumerate() {
                if !group.is_path(lane) {
                    continue;
                }
                let failure = if group.has_failed(lane) { failures.next() } else { None };
                let passage = match failure {
                    _ if !time.is_nan() => Passage::At(*time),
                    Some(failure) => Passage::Lost(self.job.grid.time(failure.error.step)),
                    None => Passage::Censored,
                };
                self.statistics.see(group.path(lane), &Seen::Passage { event, passage });
            }
        }
        for PathFailure { path, error } in failures {
            self.statistics.see(path, &Seen::Failure(error));
        }
        for section in 0..self.job.sections.len() {
            for (lane, inside) in self.lanes.iter().enumerate().filter(|(lane, _)| group.is_path(*lane)) {
                let count = inside.counts[section];
                self.statistics.see(group.path(lane), &Seen::Crossings { section, count });
            }
        }
    }
}

/// Whether all events of a lane have happened.
fn have_passed<const L: usize>(passed: &[[f64; L]], lane: usize) -> bool {
    passed.iter().all(|passed| !passed[lane].is_nan())
}

impl<H: Discretized<E>, E, P: Systems, const L: usize> Advance
    for (&mut Group<'_, '_, H, E, P, L>, &mut Observation<'_, '_, H, E, L>)
{
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance(&mut self, step: u64) -> Result<(), Error> {
        self.0.advance(step)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn next(&self, node: u64) -> u64 {
        let Observation { job, next, pace, .. } = &*self.1;
        let recorded = job.recorded.get(*next).map_or(u64::MAX, |recorded| {
            // Both nodes of a step that is looked into.
            if recorded.is_inside && recorded.node > node + 1 { recorded.node - 1 } else { recorded.node }
        });
        let is_watched = !job.events.is_empty() || !job.sections.is_empty();
        let watched = if is_watched { node + 1 } else { u64::MAX };
        recorded.min(watched).min(node.saturating_add(pace.left()))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn look(&mut self, node: u64) -> Result<(), Error> {
        let (group, observation) = self;
        observation.work(node - observation.seen, node)?;
        observation.seen = node;
        if !observation.job.events.is_empty() {
            observation.watch(group, node)?;
        }
        if !observation.job.sections.is_empty() {
            observation.follow(group, node)?;
        }
        observation.record(group, node)?;
        for (lane, inside) in observation.lanes.iter_mut().enumerate() {
            copy_state(&mut inside.before, group.state_at(lane, node));
        }
        Ok(())
    }
}
