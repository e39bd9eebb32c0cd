//! The memory of steps in lanes: in lanes as well, or lane by lane.

use crate::algebra::memory::{MemoryRequest, StepMemory};
use crate::error::InternalError;
use crate::ground::numbers::Tape;

/// The memory of `L` lanes, and those of single lanes.
#[derive(Default)]
pub(super) struct LaneMemories<J, S> {
    pub(super) joint: J,
    /// None before they are needed, and where nothing is remembered.
    by_lane: Vec<S>,
    /// A memory without content, for schemes that remember nothing.
    none: S,
    /// Whether the memories by lane are in use: from a step that some lanes could not take by the fast method
    /// to the first one before which all lanes remember as much.
    are_split: bool,
}

impl<J: StepMemory, S: StepMemory> LaneMemories<J, S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn are_split(&self) -> bool {
        self.are_split
    }

    /// Forgets all steps before.
    pub(super) fn forget(&mut self) {
        self.joint.tell(&MemoryRequest::Forget);
        self.are_split = false;
    }

    /// The memory of a lane, where they are split.
    pub(super) fn of(&mut self, lane: usize) -> &mut S {
        self.by_lane.get_mut(lane).unwrap_or(&mut self.none)
    }

    /// From now on, each of `L` lanes remembers by itself.
    ///
    /// # Errors
    /// [`InternalError`] unless what a step leaves has the same shape in lanes and in one.
    pub(super) fn split<const L: usize>(&mut self) -> Result<(), InternalError> {
        // With noise as well: what a step leaves may say how the next one is solved.
        if size_of::<S>() == 0 || self.are_split {
            return Ok(());
        }
        self.by_lane.resize_with(L, Default::default);
        for (lane, memory) in self.by_lane.iter_mut().enumerate() {
            let words = Tape::split(lane, |tape| self.joint.pass(tape));
            Tape::read(words, |tape| memory.pass(tape)).ok_or_else(other_memory)?;
        }
        self.are_split = true;
        Ok(())
    }

    /// Joins the memories of these lanes, if they go side by side and have the same shape; whether they are
    /// joined.
    #[cold]
    #[inline(never)]
    pub(super) fn join<const L: usize>(&mut self, lanes: [usize; L]) -> bool {
        if !lanes.iter().all(|&lane| self.of(lane).allows_lanes()) {
            return false;
        }
        let words = lanes.map(|lane| Tape::write(|tape| self.of(lane).pass(tape)));
        self.are_split = Tape::join(words.into(), |tape| self.joint.pass(tape)).is_none();
        !self.are_split
    }
}

/// The error of memories of different shape, which one scheme does not have.
pub(super) fn other_memory() -> InternalError {
    InternalError::new("what a step leaves is the same for lanes and alone", "a group of paths")
}
