//! The state of a recorder in a checkpoint.

use super::Recorder;
use crate::algebra::state::{State, Vector};
use crate::ground::numbers::{Numbers, Tape};
use crate::trajectory::events::Event;
use crate::trajectory::recorded::{ClockInterval, Iterations, Path};
use crate::trajectory::recording::Recording;
use crate::trajectory::section::Crossing;

impl<V: Vector> Recorder<V> {
    /// Everything that steps change.
    pub(crate) fn pass(&mut self, tape: &mut Tape) {
        let Self { path, recording, pending, kept, next, inside } = self;
        let Path {
            h: _,
            every: _,
            steps,
            iterations,
            processes,
            increments,
            states,
            last: _,
            chosen: _,
            shorter: _,
            observed: _,
            crossings: _,
            events,
            intervals,
            is_clocked,
            exchanged: _,
            heats: _,
            is_accounted: _,
            uncut: _,
            gained: _,
        } = path;
        // The watch of the run counts by itself.
        let Iterations { total, largest, hard, doubtful, halved, halvings, suspected: _ } = iterations;
        for word in [&mut *steps, total, hard, doubtful, halved, kept] {
            tape.word(word);
        }
        tape.count(largest);
        tape.count(halvings);
        for sum in pending {
            sum.pass(tape);
        }
        *next = recording.next_recorded(*steps);
        *inside = recording.inside(*steps);
        // The start is always there.
        let Some(start) = states.first().cloned() else { return };
        let nodes = tape.length(states.len() - 1);
        if *is_clocked {
            // The steps that times are in follow from no number.
            *inside = tape.length(*inside);
            let known = tape.length(intervals.len());
            intervals.resize(known, ClockInterval::default());
            intervals.iter_mut().for_each(|interval| interval.pass(tape));
        } else if nodes as u64 != recording.nodes(*steps) {
            return tape.refuse();
        }
        let happened = tape.length(events.len());
        events.resize_with(happened, || Event::like(&start));
        events.iter_mut().for_each(|event| event.pass(tape));
        states.resize(nodes + 1, start);
        states.iter_mut().skip(1).for_each(|state| state.pass(tape));
        increments.resize(nodes * *processes, 0.0);
        tape.numbers(increments);
    }

    /// The crossings so far, of states like this one.
    pub(crate) fn pass_crossings(&mut self, like: &State<V>, tape: &mut Tape) {
        let crossings = &mut self.path.crossings;
        let length = tape.length(crossings.len());
        crossings.resize_with(length, || Crossing::like(like));
        crossings.iter_mut().for_each(|crossing| crossing.pass(tape));
    }

    /// The recorded nodes.
    pub(crate) fn recording(&self) -> &Recording {
        &self.recording
    }
}
