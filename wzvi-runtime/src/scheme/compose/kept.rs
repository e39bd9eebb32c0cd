//! What the parts of a step leave for those of the next.

use std::fmt::Debug;

use crate::algebra::carry::Carry;
use crate::algebra::memory::{Iteration, Method, StepMemory, Threads};
use crate::algebra::scalar::Scalar;
use crate::error::{FailedLanes, StepFailure};
use crate::ground::numbers::{Numbers, Tape};

/// One memory for each part of a step, so that a part starts from what it was in the steps before; `A` for parts of the
/// first kind, `B` for those of the second.
#[derive(Debug)]
pub struct Memory<S, A, B> {
    pub(crate) first: Vec<A>,
    pub(crate) second: Vec<B>,
    /// The same before the step.
    saved: (Vec<A>, Vec<B>),
    /// The state before the step, and what was carried for it.
    start: [Vec<S>; 4],
    /// The increments of a part.
    pub(crate) dw: Vec<S>,
}

impl<S, A, B> Default for Memory<S, A, B> {
    fn default() -> Self {
        Self::of(Vec::new(), Vec::new())
    }
}

/// What the steps before left; scratch is allocated anew where the copy is used.
impl<S, A: Clone, B: Clone> Clone for Memory<S, A, B> {
    fn clone(&self) -> Self {
        Self::of(self.first.clone(), self.second.clone())
    }
}

impl<S, A: Numbers + Default, B: Numbers + Default> Numbers for Memory<S, A, B> {
    fn pass(&mut self, tape: &mut Tape) {
        self.first.pass(tape);
        self.second.pass(tape);
    }
}

impl<S: Scalar, A: StepMemory, B: StepMemory> StepMemory for Memory<S, A, B> {
    fn forget(&mut self) {
        self.first.iter_mut().for_each(A::forget);
        self.second.iter_mut().for_each(B::forget);
    }

    fn hold(&mut self) {
        self.first.iter_mut().for_each(A::hold);
        self.second.iter_mut().for_each(B::hold);
    }

    fn adopt(&mut self, left: Self) {
        adopt(&mut self.first, left.first);
        adopt(&mut self.second, left.second);
    }

    fn pin(&mut self, iteration: Iteration) {
        self.first.iter_mut().for_each(|memory| memory.pin(iteration));
        self.second.iter_mut().for_each(|memory| memory.pin(iteration));
    }

    fn share(&mut self, threads: Threads) {
        self.first.iter_mut().for_each(|memory| memory.share(threads));
        self.second.iter_mut().for_each(|memory| memory.share(threads));
    }

    fn pinned(&self) -> Iteration {
        let first = self.first.first().map_or(Iteration::Automatic, A::pinned);
        if first == Iteration::Automatic {
            self.second.first().map_or(Iteration::Automatic, B::pinned)
        } else {
            first
        }
    }

    fn method(&self) -> Option<Method> {
        self.first.first().and_then(A::method).or_else(|| self.second.first().and_then(B::method))
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

/// Memory by memory; as many as there are in `left` where none was in use yet.
fn adopt<M: StepMemory>(memories: &mut Vec<M>, left: Vec<M>) {
    if memories.len() == left.len() {
        memories.iter_mut().zip(left).for_each(|(memory, left)| memory.adopt(left));
    } else {
        *memories = left;
    }
}

/// One lane of each memory as it was saved; `None` where they differ in what is no matter of lanes.
fn restore_lane<M: StepMemory>(memories: &mut [M], saved: &mut [M], lane: usize) -> Option<()> {
    if size_of::<M>() == 0 {
        return Some(());
    }
    memories.iter_mut().zip(saved).try_for_each(|(memory, saved)| {
        let words = Tape::split(lane, |tape| saved.pass(tape));
        Tape::place(lane, words, |tape| memory.pass(tape))
    })
}

impl<S, A, B> Memory<S, A, B> {
    pub(crate) fn of(first: Vec<A>, second: Vec<B>) -> Self {
        Self {
            first,
            second,
            saved: (Vec::new(), Vec::new()),
            start: std::array::from_fn(|_| Vec::new()),
            dw: Vec::new(),
        }
    }
}

impl<S: Scalar, A: StepMemory, B: StepMemory> Memory<S, A, B> {
    /// With room for what the first step saves.
    pub(crate) fn with_room(mut self, degrees: usize, noises: usize) -> Self {
        self.saved = (self.first.clone(), self.second.clone());
        self.start.iter_mut().for_each(|list| list.reserve(degrees));
        self.dw.reserve(noises);
        self
    }

    /// Room for the parts of a step, and a copy of everything that they will change. Allocates in the first step only, and only
    /// where the system does not know its size.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn save<C: Carry<S>>(&mut self, parts: [usize; 2], q: &[S], p: &[S], dw: &[S], carry: &C) {
        if self.first.len() != parts[0] || self.second.len() != parts[1] {
            self.first.resize_with(parts[0], A::default);
            self.second.resize_with(parts[1], B::default);
        }
        // A part without memory has nothing to lose.
        if size_of::<A>() != 0 {
            self.saved.0.clone_from(&self.first);
        }
        if size_of::<B>() != 0 {
            self.saved.1.clone_from(&self.second);
        }
        let [start_q, start_p, lost_q, lost_p] = &mut self.start;
        for (saved, numbers) in [(start_q, q), (start_p, p), (&mut self.dw, dw)] {
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

    /// What one lane remembered before the step.
    fn restore_lane(&mut self, lane: usize) -> Option<()> {
        restore_lane(&mut self.first, &mut self.saved.0, lane)?;
        restore_lane(&mut self.second, &mut self.saved.1, lane)
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
        if size_of::<A>() != 0 {
            std::mem::swap(&mut self.first, &mut self.saved.0);
        }
        if size_of::<B>() != 0 {
            std::mem::swap(&mut self.second, &mut self.saved.1);
        }
    }
}
