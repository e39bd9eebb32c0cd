//! What the parts of a step leave for those of the next.

use std::fmt::Debug;

use crate::algebra::carry::Carry;
use crate::algebra::memory::{Report, Request, StepMemory};
use crate::algebra::scalar::Scalar;
use crate::error::{FailedLanes, StepFailure};
use crate::ground::numbers::{Numbers, Tape};

/// What all parts of a step remember, so that each starts from what it was in the steps before.
#[derive(Debug, Default)]
pub struct Memory<S, M> {
    pub(crate) parts: M,
    /// The same before the step.
    saved: M,
    /// The state before the step, and what was carried for it.
    start: [Vec<S>; 4],
    /// The increments of a part.
    pub(crate) dw: Vec<S>,
}

/// What the steps before left; scratch is allocated anew where the copy is used.
impl<S, M: Clone + Default> Clone for Memory<S, M> {
    fn clone(&self) -> Self {
        Self::of(self.parts.clone())
    }
}

impl<S, M: Numbers> Numbers for Memory<S, M> {
    fn pass(&mut self, tape: &mut Tape) {
        self.parts.pass(tape);
    }
}

impl<S: Scalar, M: StepMemory> StepMemory for Memory<S, M> {
    fn tell(&mut self, request: &Request) {
        self.parts.tell(request);
    }

    fn adopt(&mut self, left: Self) {
        self.parts.adopt(left.parts);
    }

    fn report(&self) -> Report {
        Report { blocks: 1, ..self.parts.report() }
    }
}

/// What is carried, as lists.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn list_carried<S: Scalar, C: Carry<S>>(
    carry: &C,
    degrees: usize,
    [coordinates, momenta]: [&mut Vec<S>; 2],
) {
    for (list, of) in [(coordinates, C::of_coordinate as fn(&C, usize) -> S), (momenta, C::of_momentum)] {
        list.clear();
        list.extend((0..degrees).map(|i| of(carry, i)));
    }
}

impl<S, M: Default> Memory<S, M> {
    pub(crate) fn of(parts: M) -> Self {
        Self { parts, saved: M::default(), start: std::array::from_fn(|_| Vec::new()), dw: Vec::new() }
    }
}

impl<S: Scalar, M: StepMemory> Memory<S, M> {
    /// With room for what the first step saves.
    pub(crate) fn with_room(mut self, degrees: usize, noises: usize) -> Self {
        self.saved = self.parts.clone();
        self.start.iter_mut().for_each(|list| list.reserve(degrees));
        self.dw.reserve(noises);
        self
    }

    /// A copy of everything that the parts of a step will change. Allocates in the first step only, and only
    /// where the system does not know its size.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn save<C: Carry<S>>(&mut self, q: &[S], p: &[S], carry: &C) {
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

    /// The end of a step that has come to the last of its parts, with the lanes that could not take one of them: they get back what
    /// [`Memory::save`] has seen.
    ///
    /// # Errors
    /// Which lanes these are; something else, and then nothing has moved, if what is remembered is no matter of lanes.
    #[cold]
    #[inline(never)]
    pub(crate) fn end_in_part<C: Carry<S>>(
        &mut self,
        failed: FailedLanes,
        q: &mut [S],
        p: &mut [S],
        carry: &mut C,
    ) -> StepFailure {
        // What is carried is no list of lanes that can be put together again.
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

    /// What one lane remembered before the step; `None` where that differs from what the others remember in what is no matter of lanes.
    fn restore_lane(&mut self, lane: usize) -> Option<()> {
        let words = Tape::split(lane, |tape| self.saved.pass(tape));
        Tape::place(lane, words, |tape| self.parts.pass(tape))
    }

    /// Gives back what [`Memory::save`] has seen.
    #[cold]
    pub(crate) fn restore<C: Carry<S>>(&mut self, q: &mut [S], p: &mut [S], carry: &mut C) {
        let [start_q, start_p, lost_q, lost_p] = &self.start;
        q.copy_from_slice(start_q);
        p.copy_from_slice(start_p);
        if C::CARRIES {
            carry.keep(lost_q, lost_p);
        }
        std::mem::swap(&mut self.parts, &mut self.saved);
    }
}
