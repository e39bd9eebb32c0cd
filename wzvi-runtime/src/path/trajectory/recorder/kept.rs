//! What of a trajectory in the making a checkpoint keeps.

use super::Recorder;
use crate::algebra::state::{State, Vector};
use crate::ground::numbers::Tape;
use crate::path::recording::Recording;
use crate::path::section::Crossing;
use crate::path::trajectory::{Iterations, Path};

/// Nodes after the start and the increments between them, by rows.
pub(crate) type Kept<V> = (Vec<State<V>>, Vec<f64>);

impl<V: Vector> Recorder<V> {
    /// Everything that steps change but the recorded nodes, which only grow.
    pub(crate) fn pass(&mut self, tape: &mut Tape) {
        let Self { path, recording, pending, kept, next, inside } = self;
        let Path {
            h: _,
            every: _,
            steps,
            iterations,
            processes: _,
            increments: _,
            states: _,
            last: _,
            chosen: _,
            observed: _,
            crossings: _,
            exchanged: _,
            is_accounted: _,
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
        *next = recording.next(*steps);
        *inside = recording.inside(*steps);
    }

    /// The crossings so far, of states like this one.
    pub(crate) fn pass_crossings(&mut self, like: &State<V>, tape: &mut Tape) {
        let crossings = &mut self.path.crossings;
        let length = tape.length(crossings.len());
        crossings.resize_with(length, || Crossing::like(like));
        crossings.iter_mut().for_each(|crossing| crossing.pass(tape));
    }

    /// Which nodes are recorded.
    pub(crate) fn recording(&self) -> &Recording {
        &self.recording
    }

    /// The nodes recorded after the first `known`, the start not counted, and the increments that led to them.
    pub(crate) fn nodes_after(&self, known: usize) -> (&[State<V>], &[f64]) {
        let states = self.path.states.get(known + 1..).unwrap_or(&[]);
        (states, self.path.increments.get(known * self.path.processes..).unwrap_or(&[]))
    }

    /// Puts the nodes back that were recorded after the start.
    pub(crate) fn put_back(&mut self, (states, increments): Kept<V>) {
        self.path.states.extend(states);
        self.path.increments.extend(increments);
    }
}
