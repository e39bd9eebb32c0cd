//! What paths beside each other show at the nodes of a run: observables, events, and what became of each.

use super::group::Group;
use super::job::{Job, OwnWork};
use super::pace::Pace;
use super::starts::Systems;
use crate::algebra::state::{State, Vector, copy_state};
use crate::error::StoppedError;
use crate::path::Error;
use crate::path::recording::Recorded;
use crate::path::section::{Change, Crossing, Side, Watch, crossing_of_chord};
use crate::path::steps::Advance;
use crate::scheme::dense::DenseOutput;
use crate::scheme::system::Discretized;
use crate::statistics::{Passage, PathFailure, Seen, Statistics};

/// Collects the statistics of one group of paths after the other.
pub(super) struct Observation<'j, 'a, H: Discretized<E>, E, const L: usize> {
    job: &'j Job<'a, H, E>,
    pub(super) statistics: Statistics,
    pace: Pace<'j>,
    /// The last node that was looked at, and which of the recorded ones comes next.
    seen: u64,
    next: usize,
    /// Whether events are looked for inside steps, or at nodes alone.
    watches_inside: bool,
    watches_nodes: bool,
    /// On which side each event's function was at the last node, and when it was zero; not used where steps
    /// are looked into.
    sides: Vec<[Side<f64>; L]>,
    /// When each event happened; NaN before.
    passed: Vec<[f64; L]>,
    /// What is needed to look inside steps, by lane; none if nobody does.
    lanes: Vec<LaneInside<H::Vector>>,
    values: Vec<f64>,
}

/// What looks inside the steps of one lane.
struct LaneInside<V> {
    /// The state at the last node that was looked at.
    before: State<V>,
    dense: DenseOutput<V>,
    sections: Watch<V>,
    events: Watch<V>,
    /// Crossings of the path so far, by section.
    counts: Vec<u64>,
    /// A recorded state.
    room: State<V>,
}

impl<V: Vector> LaneInside<V> {
    fn new<H: Discretized<E, Vector = V>, E>(job: &Job<'_, H, E>) -> Self {
        let start = &job.start;
        Self {
            before: start.clone(),
            dense: DenseOutput::of(start),
            sections: Watch::new(job.sections.functions(), start),
            events: Watch::new(job.events.iter(), start),
            counts: vec![0; job.sections.len()],
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
            watches_inside: job.has_passages_inside(),
            watches_nodes: job.has_passages_at_nodes(),
            sides: vec![[Side::at(0.0); L]; events],
            passed: vec![[f64::NAN; L]; events],
            lanes: (0..lanes).map(|_| LaneInside::new(job)).collect(),
            values: vec![0.0; observables],
        }
    }

    /// The paths of a group at their start.
    ///
    /// # Errors
    /// If the run was stopped on the way.
    pub(super) fn begin<P: Systems>(&mut self, group: &mut Group<'_, '_, H, E, P, L>) -> Result<(), Error> {
        (self.seen, self.next) = (0, 0);
        self.passed.fill([f64::NAN; L]);
        if self.watches_nodes {
            for (sides, event) in self.sides.iter_mut().zip(&self.job.events) {
                for (lane, side) in sides.iter_mut().enumerate() {
                    *side = Side::at(event(group.state_at(lane, 0)));
                }
            }
        }
        for (lane, LaneInside { before, sections, events, dense, counts, .. }) in
            self.lanes.iter_mut().enumerate()
        {
            copy_state(before, group.state_at(lane, 0));
            sections.begin(self.job.sections.functions(), before);
            events.begin(self.job.events.iter(), before);
            dense.forget();
            counts.fill(0);
        }
        self.record(group, 0)
    }

    /// Looks for the events of the step that ended at this node, by the states at its nodes.
    #[inline(never)]
    fn watch<P: Systems>(&mut self, group: &mut Group<'_, '_, H, E, P, L>, node: u64) {
        let times = [node - 1, node].map(|node| self.job.grid.time(node));
        for lane in 0..L {
            let is_over = !group.is_path(lane) || group.has_failed(lane);
            if is_over || have_passed(&self.passed, lane) {
                continue;
            }
            let state = group.state_at(lane, node);
            let memory = self.sides.iter_mut().zip(&mut self.passed);
            for ((sides, passed), event) in memory.zip(&self.job.events) {
                if passed[lane].is_nan() {
                    let (side, value) = (&mut sides[lane], event(state));
                    let values = [side.value(), value];
                    match side.go(value, || times[1]) {
                        Some(Change::At(time)) => passed[lane] = time,
                        Some(Change::Between) => passed[lane] = crossing_of_chord(times, values),
                        None => {}
                    }
                }
            }
        }
    }

    /// Looks into the step that ended at this node: for crossings of sections, and for the events of paths
    /// without noise.
    #[inline(never)]
    fn follow<P: Systems>(&mut self, group: &mut Group<'_, '_, H, E, P, L>, node: u64) -> Result<(), Error> {
        let Self { job, statistics, passed, lanes, watches_inside, .. } = self;
        for (lane, LaneInside { before, dense, sections, events, counts, .. }) in lanes.iter_mut().enumerate()
        {
            let waits = *watches_inside && !have_passed(passed, lane);
            if !group.is_path(lane) || group.has_failed(lane) || (job.sections.is_empty() && !waits) {
                continue;
            }
            let path = group.path(lane);
            group.look_inside(lane, node, before, dense, &mut |dense, _, _| {
                sections.follow(job.sections.functions(), dense, &mut |crossing| {
                    if !job.sections.want(&crossing) {
                        return;
                    }
                    let Crossing { section, direction, state } = crossing;
                    let (before, t) = (counts[section], state.t);
                    let (q, p) = (state.q.components(), state.p.components());
                    statistics.see(path, &Seen::Crossing { section, before, direction, t, q, p });
                    counts[section] += 1;
                });
                if waits {
                    events.follow(
                        job.events.iter(),
                        dense,
                        &mut |Crossing { section: event, state, .. }| {
                            let passed = &mut passed[event][lane];
                            if passed.is_nan() {
                                *passed = state.t;
                            }
                        },
                    );
                }
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
            if let Some(OwnWork { places, has_weight }) = &job.own_work {
                group.work_of(lane, node, *has_weight, &mut self.values[places.clone()])?;
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
        if observation.watches_nodes {
            observation.watch(group, node);
        }
        if observation.watches_inside || !observation.job.sections.is_empty() {
            observation.follow(group, node)?;
        }
        observation.record(group, node)?;
        for (lane, inside) in observation.lanes.iter_mut().enumerate() {
            copy_state(&mut inside.before, group.state_at(lane, node));
        }
        Ok(())
    }
}
