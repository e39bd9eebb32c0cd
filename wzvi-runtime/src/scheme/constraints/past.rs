//! The impulses of past steps, from which those of the next one are extrapolated.

use crate::algebra::memory::{MemoryRequest, StepMemory};
use crate::algebra::scalar::{Mask, Scalar};
use crate::algebra::shape::Shape;
use crate::ground::numbers::{Numbers, Tape};

/// The impulses of a part of the last two steps.
#[derive(Clone, Debug)]
pub(super) struct PastImpulses<S: Scalar, M: Shape> {
    last: M::List<S>,
    before: M::List<S>,
    /// Where the last step is known, and where the one before.
    known: [S::Mask; 2],
}

impl<S: Scalar, M: Shape> Default for PastImpulses<S, M> {
    fn default() -> Self {
        let list = || M::list(0, S::from_f64(0.0));
        Self { last: list(), before: list(), known: [S::Mask::from_bool(false); 2] }
    }
}

impl<S: Scalar, M: Shape> PastImpulses<S, M> {
    /// Makes room for so many constraints.
    pub(super) fn fit(&mut self, constraints: usize) {
        if self.last.as_ref().len() != constraints {
            let list = || M::list(constraints, S::from_f64(0.0));
            *self = Self { last: list(), before: list(), ..Self::default() };
        }
    }

    /// The start of the iteration: a line through two steps, one step, or zero.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn guess(&self, into: &mut [S]) {
        let zero = S::from_f64(0.0);
        let [one, two] = self.known;
        for ((into, &last), &before) in into.iter_mut().zip(self.last.as_ref()).zip(self.before.as_ref()) {
            let line = S::select(two, last + (last - before), last);
            *into = S::select(one, line, zero);
        }
    }

    /// Takes the impulses of a step, where it was `taken`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn record(&mut self, taken: S::Mask, impulses: &[S]) {
        let lists = self.last.as_mut().iter_mut().zip(self.before.as_mut());
        for ((last, before), &impulse) in lists.zip(impulses) {
            *before = S::select(taken, *last, *before);
            *last = S::select(taken, impulse, *last);
        }
        let [one, two] = self.known;
        self.known = [one | taken, two | (one & taken)];
    }
}

impl<S: Scalar, M: Shape> StepMemory for PastImpulses<S, M> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn tell(&mut self, request: &MemoryRequest) {
        match request {
            MemoryRequest::Forget => self.known = [S::Mask::from_bool(false); 2],
            MemoryRequest::Hold => self.known[1] = S::Mask::from_bool(false),
            _ => {}
        }
    }
}

impl<S: Scalar, M: Shape> Numbers for PastImpulses<S, M> {
    fn pass(&mut self, tape: &mut Tape) {
        if !M::IS_FIXED {
            self.fit(tape.length(self.last.as_ref().len()));
        }
        let lists = [&mut self.last, &mut self.before];
        lists.into_iter().for_each(|list| list.as_mut().iter_mut().for_each(|number| number.pass(tape)));
        let count = |lane: usize| self.known.iter().map(|known| u8::from(known.lane(lane))).sum();
        let mut counts: Vec<u8> = (0..S::LANES).map(count).collect();
        tape.counts(&mut counts);
        if tape.is_reading() {
            self.known = [0, 1].map(|steps| S::Mask::of_lanes(|lane| counts[lane] > steps));
        }
    }
}
