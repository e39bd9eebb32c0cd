//! Observation of paths in lanes at the nodes of a run: observables, events, and the outcome of each path.

use super::crossings::PathCrossings;
use super::group::{Coupled, Group, StepPaths};
use super::job::{EnsembleJob, OwnWork};
use super::starts::Systems;
use super::stop_poll::StopPoll;
use crate::algebra::state::{State, Vector, copy_state};
use crate::error::StoppedError;
use crate::scheme::constraints::put_on;
use crate::scheme::dense::DenseOutput;
use crate::scheme::system::Discretized;
use crate::statistics::{PathFailure, Seen, Statistics};
use crate::trajectory::Error;
use crate::trajectory::recording::RecordedTime;
use crate::trajectory::steps::{Advance, NodeOutcome};

/// Collects the statistics of one group of paths after the other.
pub(super) struct Observation<'j, 'a, H: Discretized<E>, E, const L: usize> {
    job: &'j EnsembleJob<'a, H, E>,
    pub(super) statistics: Statistics,
    pace: StopPoll<'j>,
    /// The last node that was looked at, and which of the recorded ones comes next.
    seen: u64,
    next: usize,
    /// Crossings of sections and events, by lane; none if a run looks for none.
    crossings: Vec<PathCrossings<H::Vector>>,
    /// The views inside steps, by lane; none if nobody looks there.
    lanes: Vec<LaneInside<H::Vector>>,
    values: Vec<f64>,
}

/// The view inside the steps of one lane.
struct LaneInside<V> {
    /// The state at the last node that was looked at.
    before: State<V>,
    dense: DenseOutput<V>,
    /// A recorded state.
    room: State<V>,
}

impl<V: Vector> LaneInside<V> {
    fn new<H: Discretized<E, Vector = V>, E>(job: &EnsembleJob<'_, H, E>) -> Self {
        let start = &job.starts.first;
        Self { before: start.clone(), dense: DenseOutput::of(start), room: start.clone() }
    }
}

impl<'j, 'a, H: Discretized<E>, E, const L: usize> Observation<'j, 'a, H, E, L> {
    pub(super) fn new(job: &'j EnsembleJob<'a, H, E>) -> Self {
        let (mut crossings, mut lanes) = (Vec::new(), Vec::new());
        let (has_crossings, looks_between) = (job.crossed.has_any(), job.looks_between());
        for _ in 0..L {
            if has_crossings {
                crossings.push(PathCrossings::new(job));
            }
            if looks_between {
                lanes.push(LaneInside::new(job));
            }
        }
        Self {
            job,
            statistics: job.observed.empty.clone(),
            pace: StopPoll::new(job.stop),
            seen: 0,
            next: 0,
            crossings,
            lanes,
            values: vec![0.0; job.observed.observables.len()],
        }
    }

    /// The paths of a group at their start.
    ///
    /// # Errors
    /// If the run was stopped on the way.
    pub(super) fn begin<P: Systems, T: StepPaths<'j, H, E, L>>(
        &mut self,
        paths: &mut Coupled<'j, 'a, H, E, P, T, L>,
    ) -> Result<(), Error> {
        let group = &mut paths.fine;
        (self.seen, self.next) = (0, 0);
        for (lane, crossings) in self.crossings.iter_mut().enumerate() {
            crossings.begin(self.job, group.state_at(lane, 0));
        }
        for (lane, LaneInside { before, dense, .. }) in self.lanes.iter_mut().enumerate() {
            copy_state(before, group.state_at(lane, 0));
            dense.forget();
        }
        self.record(paths, 0)
    }

    /// Looks for the crossings of the step that ended at this node.
    #[inline(never)]
    fn cross<T: StepPaths<'j, H, E, L>>(
        &mut self,
        group: &mut Group<'j, 'a, H, E, T, L>,
        node: u64,
    ) -> Result<(), Error> {
        let Self { job, statistics, crossings, lanes, .. } = self;
        let times = [job.grid.time(node - 1), job.grid.time(node)];
        for (lane, crossings) in crossings.iter_mut().enumerate() {
            if !group.paths.lanes.goes_on(lane) {
                continue;
            }
            if job.has_passages_at_nodes() {
                crossings.look_at_node(job, times, group.state_at(lane, node));
            }
            let (path, number) = (group.paths.lanes.number(lane), crossings.looked_for_inside(job));
            if number > 0
                && let Some(LaneInside { before, dense, .. }) = lanes.get_mut(lane)
            {
                group.look_inside(lane, node, before, dense, &mut |dense, _, _| {
                    crossings.look_inside(job, number, dense, path, &mut *statistics);
                })?;
            }
        }
        Ok(())
    }

    /// This much more work is done, at a node.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn work(&mut self, pieces: u64, node: u64) -> Result<(), StoppedError> {
        let stopped = StoppedError { done: node, all: self.job.grid.steps };
        if self.pace.ends_after(pieces) { Err(stopped) } else { Ok(()) }
    }

    /// Adds the paths of a group to the statistics of all recorded times that belong to this node, those that
    /// have failed as lost.
    #[inline(never)]
    fn record<P: Systems, T: StepPaths<'j, H, E, L>>(
        &mut self,
        paths: &mut Coupled<'j, 'a, H, E, P, T, L>,
        node: u64,
    ) -> Result<(), Error> {
        while let Some(recorded) = self.job.observed.recorded.get(self.next)
            && recorded.node == node
        {
            self.record_at(paths, recorded)?;
            self.next += 1;
        }
        Ok(())
    }

    fn record_at<P: Systems, T: StepPaths<'j, H, E, L>>(
        &mut self,
        paths: &mut Coupled<'j, 'a, H, E, P, T, L>,
        &RecordedTime { node, t, is_inside }: &RecordedTime,
    ) -> Result<(), Error> {
        let (job, place) = (self.job, self.next);
        for lane in 0..L {
            self.work(1, node)?;
            if !paths.fine.paths.lanes.is_path(lane) {
                continue;
            }
            let path = paths.fine.paths.lanes.number(lane);
            if const { P::ARE_PAIRED } {
                let values = &paths.end_of_pair(lane).map_err(Error::Level)?;
                self.statistics.see(path, &Seen::Values { node: place, values });
                continue;
            }
            let group = &mut paths.fine;
            if group.paths.lanes.has_failed(lane) {
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
                    put_on(job.systems.of(path).manifold(), room);
                    &*room
                }
                _ => group.state_at(lane, node),
            };
            if let Some(see) = &job.observed.inspector {
                see(path, state);
            }
            job.observe(path, state, &mut self.values);
            if let Some(OwnWork { places, has_weight }) = &job.observed.work {
                group.work_of(lane, node, *has_weight, &mut self.values[places.clone()])?;
            }
            self.statistics.see(path, &Seen::Values { node: place, values: &self.values });
        }
        Ok(())
    }

    /// Adds the outcomes of the paths of a group, in the order of their numbers.
    pub(super) fn finish<P, T>(&mut self, paths: &mut Coupled<'j, 'a, H, E, P, T, L>) {
        let group = &mut paths.fine.paths.lanes;
        let failures = group.take_failures();
        for event in 0..self.job.crossed.events.len() {
            let mut failures = failures.iter();
            for (lane, crossings) in self.crossings.iter().enumerate() {
                if !group.is_path(lane) {
                    continue;
                }
                let failure = if group.has_failed(lane) { failures.next() } else { None };
                let failed = failure.map(|failure| self.job.grid.time(failure.error.step));
                let passage = crossings.passage(event, failed);
                self.statistics.see(group.number(lane), &Seen::Passage { event, passage });
            }
        }
        for PathFailure { path, error } in failures {
            self.statistics.see(path, &Seen::Failure(error));
        }
        for section in 0..self.job.crossed.sections.len() {
            for (lane, crossings) in self.crossings.iter().enumerate() {
                if !group.is_path(lane) {
                    continue;
                }
                let count = crossings.count(section);
                self.statistics.see(group.number(lane), &Seen::Crossings { section, count });
            }
        }
    }
}

impl<'j, 'a, H, E, P, T, const L: usize> Advance
    for (&mut Coupled<'j, 'a, H, E, P, T, L>, &mut Observation<'j, 'a, H, E, L>)
where
    H: Discretized<E>,
    P: Systems,
    T: StepPaths<'j, H, E, L>,
{
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance(&mut self, step: u64) -> Result<(), Error> {
        self.0.advance(step)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn next_node(&self, node: u64) -> u64 {
        let Observation { job, next, pace, crossings, .. } = &*self.1;
        let recorded = job.observed.recorded.get(*next).map_or(u64::MAX, |recorded| {
            // Both nodes of a step that is looked into.
            if recorded.is_inside && recorded.node > node + 1 { recorded.node - 1 } else { recorded.node }
        });
        let crossed = if crossings.is_empty() { u64::MAX } else { node + 1 };
        recorded.min(crossed).min(node.saturating_add(pace.left()))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn at_node(&mut self, node: u64) -> Result<NodeOutcome, Error> {
        let (paths, observation) = self;
        observation.work(node - observation.seen, node)?;
        observation.seen = node;
        if !observation.crossings.is_empty() {
            observation.cross(&mut paths.fine, node)?;
        }
        observation.record(paths, node)?;
        for (lane, inside) in observation.lanes.iter_mut().enumerate() {
            copy_state(&mut inside.before, paths.fine.state_at(lane, node));
        }
        Ok(NodeOutcome::GoesOn)
    }
}
