//! The memory that the parts of a step keep for the next step.

use std::fmt::Debug;

use crate::algebra::memory::{StepMemory, step_memory};
use crate::algebra::scalar::Scalar;
use crate::algebra::state_sum::StateSum;
use crate::error::{FailedLanes, StepFailure};
use crate::ground::numbers::Tape;

/// The memories of all parts of a step, so that each part starts from its own past steps.
#[derive(Debug, Default)]
pub struct CompositionMemory<S, M> {
    pub(crate) parts: M,
    /// The memories before the step.
    saved: M,
    /// The state before the step, and its carried rounding errors.
    start: [Vec<S>; 4],
    /// The carried rounding errors of coordinates and momenta, for a part that changes them.
    pub(crate) carried: [Vec<S>; 2],
    /// The noise increments of a part.
    pub(crate) dw: Vec<S>,
}

step_memory! {
    impl[S: Scalar, M: StepMemory] StepMemory for CompositionMemory<S, M> {
        kept: parts;
        scratch: saved, start, carried, dw
    }
}

/// The carried rounding errors, as lists.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn list_carried<S: Scalar, C: StateSum<S>>(
    carry: &C,
    degrees: usize,
    [coordinates, momenta]: [&mut Vec<S>; 2],
) {
    for (list, of) in [(coordinates, C::of_coordinate as fn(&C, usize) -> S), (momenta, C::of_momentum)] {
        list.clear();
        list.extend((0..degrees).map(|i| of(carry, i)));
    }
}

impl<S, M: Default> CompositionMemory<S, M> {
    pub(crate) fn of(parts: M) -> Self {
        let (saved, start, carried) = (M::default(), Default::default(), Default::default());
        Self { parts, saved, start, carried, dw: Vec::new() }
    }
}

impl<S: Scalar, M: StepMemory> CompositionMemory<S, M> {
    /// Allocates for the data that the first step saves.
    pub(crate) fn with_room(mut self, degrees: usize, noises: usize) -> Self {
        self.saved = self.parts.clone();
        self.start.iter_mut().chain(&mut self.carried).for_each(|list| list.reserve(degrees));
        self.dw.reserve(noises);
        self
    }

    /// Copies everything that the parts of a step change. Allocates in the first step only, and only if the
    /// system does not know its size.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn save<C: StateSum<S>>(&mut self, q: &[S], p: &[S], carry: &C) {
        self.saved.copy(&self.parts);
        let [start_q, start_p, lost_q, lost_p] = &mut self.start;
        for (saved, numbers) in [(start_q, q), (start_p, p)] {
            saved.clear();
            saved.extend_from_slice(numbers);
        }
        if C::CARRIES {
            list_carried(carry, q.len(), [lost_q, lost_p]);
        }
    }

    /// Ends a step in which some lanes have failed in a part: these lanes are reset to what
    /// [`CompositionMemory::save`] stored.
    ///
    /// # Errors
    /// The failed lanes; or another failure, with all lanes reset, if the memory cannot be restored lane by
    /// lane.
    #[cold]
    #[inline(never)]
    pub(crate) fn end_in_part<C: StateSum<S>>(
        &mut self,
        failed: FailedLanes,
        q: &mut [S],
        p: &mut [S],
        carry: &mut C,
    ) -> StepFailure {
        // Carried rounding errors cannot be restored lane by lane.
        if C::CARRIES || !failed.lanes().all(|lane| self.restore_lane(lane).is_some()) {
            self.restore(q, p, carry);
            return StepFailure::NonFinite;
        }
        let is_failed = failed.mask::<S>();
        let [start_q, start_p, ..] = &self.start;
        for (now, start) in q.iter_mut().chain(p).zip(start_q.iter().chain(start_p)) {
            *now = S::select(is_failed, *start, *now);
        }
        StepFailure::Lanes(failed)
    }

    /// Restores the memory of one lane from before the step; `None` if it differs from the others in data
    /// that all lanes share.
    fn restore_lane(&mut self, lane: usize) -> Option<()> {
        let words = Tape::split(lane, |tape| self.saved.pass(tape));
        Tape::place(lane, words, |tape| self.parts.pass(tape))
    }

    /// Restores what [`CompositionMemory::save`] stored.
    #[cold]
    pub(crate) fn restore<C: StateSum<S>>(&mut self, q: &mut [S], p: &mut [S], carry: &mut C) {
        let [start_q, start_p, lost_q, lost_p] = &self.start;
        q.copy_from_slice(start_q);
        p.copy_from_slice(start_p);
        if C::CARRIES {
            carry.keep(lost_q, lost_p);
        }
        std::mem::swap(&mut self.parts, &mut self.saved);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::solve::Extrapolation;
    use crate::ground::numbers::Numbers;

    /// A composition of compositions copies the memories of its parts in every step.
    #[test]
    fn copies_keep_their_room() {
        let mut memory = CompositionMemory::of(Extrapolation::<f64, 1>::default()).with_room(3, 2);
        memory.parts.record::<true>([7.0]);
        let mut copy = CompositionMemory::of(Extrapolation::default()).with_room(3, 2);
        let room = |memory: &CompositionMemory<f64, _>| [memory.start[0].as_ptr(), memory.dw.as_ptr()];
        let before = room(&copy);
        copy.copy(&memory);
        assert_eq!(room(&copy), before);
        assert_eq!(copy.parts.guess::<true>(), [7.0]);
        let words = |memory: &mut CompositionMemory<f64, _>| Tape::write(|tape| Numbers::pass(memory, tape));
        assert_eq!(words(&mut copy), words(&mut memory));
    }
}
