//! The set of lanes whose paths could not take a step.

/// A set of lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FailedLanes(pub(crate) u64);

impl FailedLanes {
    /// The number of lanes that it can hold.
    pub const MOST: usize = u64::BITS as usize;

    /// The lanes of either set.
    #[cfg_attr(not(debug_assertions), inline(always))]
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether there are none.
    #[cfg_attr(not(debug_assertions), inline(always))]
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether a lane is one of them.
    #[cfg_attr(not(debug_assertions), inline(always))]
    #[must_use]
    pub fn has(self, lane: usize) -> bool {
        lane < Self::MOST && self.0 >> lane & 1 != 0
    }

    /// Their numbers, in order.
    pub fn lanes(self) -> impl Iterator<Item = usize> {
        (0..Self::MOST).filter(move |&lane| self.has(lane))
    }
}
