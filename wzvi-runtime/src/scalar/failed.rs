//! Which of the paths beside each other could not take a step.

use super::{Mask, Scalar};

/// A set of lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FailedLanes(pub(crate) u64);

impl FailedLanes {
    /// So many lanes have a place in it.
    pub const MOST: usize = u64::BITS as usize;

    /// Those of a mask.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn of<S: Scalar>(mask: S::Mask) -> Self {
        let mut bits = 0;
        for lane in 0..S::LANES {
            bits |= u64::from(mask.lane(lane)) << lane;
        }
        Self(bits)
    }

    /// As a mask.
    pub(crate) fn mask<S: Scalar>(self) -> S::Mask {
        let none = S::Mask::from_bool(false);
        (0..S::LANES).filter(|&lane| self.has(lane)).map(S::Mask::of_lane).fold(none, |all, lane| all | lane)
    }

    /// Those of either set.
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
