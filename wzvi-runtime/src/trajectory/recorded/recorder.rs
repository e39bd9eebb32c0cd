//! A trajectory in the making.

mod saved;

use std::marker::PhantomData;

use super::{Iterations, Path, Trajectory};
use crate::algebra::compensated::CompensatedNumber;
use crate::algebra::state::{State, Vector};
use crate::error::ConfigError;
use crate::scheme::system::Exchange;
use crate::trajectory::events::Event;
use crate::trajectory::recorded::ClockInterval;
use crate::trajectory::recording::{Recording, TimeInStep};
use crate::trajectory::section::Crossing;
use crate::trajectory::span::NodeGrid;
use crate::trajectory::step::StepInfo;

/// Records the nodes that a run passes.
pub(crate) struct Recorder<V> {
    path: Path<V>,
    recording: Recording,
    /// Sums of the increments since the last recorded node.
    pending: Vec<CompensatedNumber>,
    /// The step of the last recorded node, and that of the next.
    kept: u64,
    next: u64,
    /// How many of the times inside steps are recorded.
    inside: usize,
}

impl<V: Vector> Recorder<V> {
    /// Makes room for the whole path at once, so that steps allocate nothing and a path too long for the
    /// memory is refused before it runs.
    pub(crate) fn new(
        start: &State<V>,
        h: f64,
        processes: usize,
        recording: &Recording,
        steps: u64,
    ) -> Result<Self, ConfigError> {
        let every = recording.every;
        let regular = if every == 0 { steps.min(1) } else { steps.div_ceil(every) };
        let intervals = regular.saturating_add(recording.extra(steps) + recording.between.len() as u64);
        let (mut states, mut increments) = (Vec::new(), Vec::new());
        let reserved = usize::try_from(intervals).ok().and_then(|intervals| {
            states.try_reserve_exact(intervals.checked_add(1)?).ok()?;
            increments.try_reserve_exact(intervals.checked_mul(processes)?).ok()
        });
        reserved.ok_or_else(|| {
            let nodes = intervals.saturating_add(1);
            ConfigError::Setting(format!("{nodes} states do not fit in memory; use a larger `record_every`"))
        })?;
        states.push(start.clone());
        let iterations = Iterations::default();
        let last = start.clone();
        let path = Path {
            h,
            every,
            steps: 0,
            iterations,
            processes,
            increments,
            states,
            last,
            chosen: 0,
            shorter: None,
            uncut: None,
            observed: Vec::new(),
            crossings: Vec::new(),
            events: Vec::new(),
            intervals: Vec::new(),
            is_clocked: recording.is_clocked,
            exchanged: Exchange::default(),
            heats: Vec::new(),
            is_accounted: false,
            gained: None,
        };
        let (recording, next) = (recording.clone(), recording.next_recorded(0));
        Ok(Self {
            path,
            recording,
            pending: vec![CompensatedNumber::default(); processes],
            kept: 0,
            next,
            inside: 0,
        })
    }

    /// A step was taken.
    #[inline]
    pub(crate) fn step(&mut self, dw: &[f64], info: &StepInfo) {
        self.path.steps += 1;
        self.path.iterations.count(info);
        for (sum, &dw) in self.pending.iter_mut().zip(dw) {
            sum.add(dw);
        }
    }

    /// The next node that is to be recorded; the largest number if there is none.
    #[inline]
    pub(crate) fn next_node(&self) -> u64 {
        self.next
    }

    /// Whether nodes in between are seen by an observer, too.
    #[inline]
    pub(crate) fn shows_all(&self) -> bool {
        self.path.every == 0
    }

    /// Keeps the node just reached if it is to be recorded; whether it is. The last node is kept by
    /// [`Recorder::finish`].
    #[inline]
    pub(crate) fn reach(&mut self, state: &State<V>) -> bool {
        let due = self.path.steps == self.next;
        if due {
            self.keep(state);
        }
        due
    }

    /// An event or the end of the run cut the last step, which had this length.
    pub(crate) fn cut(&mut self, length: f64) {
        self.path.uncut = Some(length);
    }

    /// The next time inside a step that is to be recorded.
    #[inline]
    pub(crate) fn next_inside(&self) -> Option<TimeInStep> {
        self.recording.between.get(self.inside).copied()
    }

    /// Keeps the state at that time, in the step that was taken last, which has these increments left after
    /// it.
    pub(crate) fn keep_inside(&mut self, state: &State<V>, rest: impl Fn(usize) -> f64) {
        self.path.states.push(state.clone());
        for (process, sum) in self.pending.iter_mut().enumerate() {
            let rest = rest(process);
            sum.add(-rest);
            self.path.increments.push(sum.total());
            *sum = CompensatedNumber::default();
            sum.add(rest);
        }
        self.inside += 1;
    }

    /// Keeps an event.
    pub(crate) fn happen(&mut self, event: Event<V>) {
        self.path.events.push(event);
    }

    /// Keeps the step by a clock that ended at the node just reached, if that is recorded.
    pub(crate) fn keep_interval(&mut self, interval: ClockInterval) {
        if self.path.steps == self.next || self.path.steps == self.kept {
            self.path.intervals.push(interval);
        }
    }

    /// Keeps a crossing.
    pub(crate) fn cross(&mut self, crossing: Crossing<V>) {
        self.path.crossings.push(crossing);
    }

    fn keep(&mut self, state: &State<V>) {
        self.path.states.push(state.clone());
        self.path.increments.extend(self.pending.iter().map(|sum| sum.total()));
        self.pending.fill(CompensatedNumber::default());
        self.kept = self.path.steps;
        // Without chosen nodes the next is as far as the last: no division.
        self.next = if self.kept == self.next && self.recording.chosen.is_empty() {
            self.next.saturating_add(self.path.every)
        } else {
            self.recording.next_recorded(self.kept)
        };
    }

    /// The trajectory on these nodes, which ends at `last`.
    pub(crate) fn finish<E>(mut self, mut last: State<V>, grid: &NodeGrid) -> Trajectory<V, E> {
        let is_over = self.path.steps == grid.steps;
        self.path.shorter = grid.shorter.filter(|_| is_over);
        if let Some(end) = grid.end.filter(|_| is_over) {
            last.t = end;
            if self.kept == self.path.steps
                && let Some(state) = self.path.states.last_mut()
            {
                state.t = end;
            }
        }
        Trajectory { path: self.path(last), variables: None, unsaved: None, scheme: PhantomData }
    }

    fn path(mut self, last: State<V>) -> Path<V> {
        if self.path.steps > self.kept {
            self.keep(&last);
        }
        self.path.last = last;
        // The last node is recorded anyway.
        self.path.chosen = self.recording.extra(self.path.steps.saturating_sub(1)) + self.inside as u64;
        // A crossing at a node is known one step later than those of other sections.
        let sign = self.path.h.signum();
        self.path.crossings.sort_by(|a, b| (sign * a.state.t).total_cmp(&(sign * b.state.t)));
        self.path
    }
}
