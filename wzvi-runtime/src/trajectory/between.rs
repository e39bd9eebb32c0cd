//! The search for recorded times and crossings of sections between the nodes of a run.

use crate::algebra::state::{State, Vector, copy_state};
use crate::scheme::constraints::{Manifold, put_on};
use crate::scheme::dense::DenseOutput;
use crate::trajectory::recorded::Recorder;
use crate::trajectory::recording::TimeInStep;
use crate::trajectory::section::{Crossing, SectionWatch, Sections};

/// Looks into the steps of one path.
pub(crate) struct BetweenNodes<'s, 'a, V> {
    sections: &'s Sections<'a, V>,
    pub(crate) watch: SectionWatch<V>,
    /// The last node that was looked at.
    pub(crate) before: State<V>,
    node: u64,
    /// A recorded state.
    room: State<V>,
    /// The manifold on which states between nodes are.
    manifold: Option<&'s dyn Manifold>,
}

/// A step, or a part of it.
pub(crate) struct StepPart<'p, V> {
    /// The number of the step.
    pub(crate) step: u64,
    /// Its increments.
    pub(crate) dw: &'p [f64],
    /// The increments of the parts after it; empty where there are none.
    pub(crate) later: &'p [f64],
    /// Whether the step ends with it.
    pub(crate) is_last: bool,
    /// The end of the run, where an event is that: nothing comes after it.
    pub(crate) end: Option<&'p State<V>>,
}

impl<'s, 'a, V: Vector> BetweenNodes<'s, 'a, V> {
    /// For a path that starts at this state, on a manifold if there is one.
    pub(crate) fn new(
        sections: &'s Sections<'a, V>,
        start: &State<V>,
        manifold: Option<&'s dyn Manifold>,
    ) -> Self {
        Self {
            sections,
            watch: SectionWatch::new(sections.functions(), start),
            before: start.clone(),
            node: 0,
            room: start.clone(),
            manifold,
        }
    }

    /// The next node, after this one, at which to look: both nodes of each step that something is looked for
    /// in.
    pub(crate) fn next_node(&self, node: u64, inside: Option<TimeInStep>) -> u64 {
        match inside {
            _ if !self.sections.is_empty() => node + 1,
            Some(moment) if moment.step > node => moment.step,
            Some(moment) => moment.step + 1,
            None => u64::MAX,
        }
    }

    /// Whether something is looked for in the step that ends at this node.
    pub(crate) fn wants(&self, node: u64, inside: Option<TimeInStep>) -> bool {
        let wants = !self.sections.is_empty() || inside.is_some_and(|moment| moment.step + 1 == node);
        debug_assert!(!wants || self.node + 1 == node, "both nodes of a step are looked at");
        wants
    }

    /// The path is at this node.
    pub(crate) fn arrive(&mut self, node: u64, state: &State<V>) {
        self.node = node;
        copy_state(&mut self.before, state);
    }

    /// Everything that steps change of it, and the crossings so far; nothing where there are no sections.
    pub(crate) fn pass(&mut self, recorder: &mut Recorder<V>, tape: &mut crate::ground::numbers::Tape) {
        if !self.sections.is_empty() {
            self.watch.pass(tape);
            recorder.pass_crossings(&self.before, tape);
        }
    }

    /// Looks into a step, or a part of it.
    pub(crate) fn search(
        &mut self,
        dense: &DenseOutput<V>,
        part: &StepPart<'_, V>,
        recorder: &mut Recorder<V>,
    ) {
        self.record_times(dense, part, recorder);
        self.find_crossings(dense, recorder, &mut |_| {});
    }

    /// Records the times that are in a step, or in a part of it. What is at the end of a part that ends with
    /// an event has the state after it, at the start of the next part.
    pub(crate) fn record_times(
        &mut self,
        dense: &DenseOutput<V>,
        part: &StepPart<'_, V>,
        recorder: &mut Recorder<V>,
    ) {
        let Self { room, manifold, .. } = self;
        while let Some(moment) = recorder.next_inside().filter(|moment| moment.step == part.step) {
            let theta = dense.fraction(moment.t);
            let is_at_end = part.end.is_some_and(|end| end.t == moment.t);
            let is_later = if part.end.is_some() { theta > 1.0 } else { theta >= 1.0 && !part.is_last };
            if is_later && !is_at_end {
                break;
            }
            let theta = theta.clamp(0.0, 1.0);
            match part.end {
                Some(end) if is_at_end => copy_state(room, end),
                _ => {
                    dense.write(theta, room);
                    room.t = moment.t;
                    put_on(*manifold, room);
                }
            }
            let later = |process: usize| part.later.get(process).copied().unwrap_or(0.0);
            recorder.keep_inside(room, |process| (1.0 - theta) * part.dw[process] + later(process));
        }
    }

    /// Finds the crossings in a step, or in a part of it; `refine` may put each on its section.
    pub(crate) fn find_crossings(
        &mut self,
        dense: &DenseOutput<V>,
        recorder: &mut Recorder<V>,
        refine: &mut dyn FnMut(&mut Crossing<V>),
    ) {
        let Self { sections, watch, manifold, .. } = self;
        watch.follow(sections.functions(), dense, &mut |mut crossing, _| {
            if sections.want(&crossing) {
                refine(&mut crossing);
                put_on(*manifold, &mut crossing.state);
                recorder.cross(crossing);
            }
        });
    }

    /// The sections that are looked for.
    pub(crate) fn sections(&self) -> &'s Sections<'a, V> {
        self.sections
    }
}
