//! The paths of a register that could not take a step, as a mask.

use super::{Mask, Scalar};
use crate::error::{FailedLanes, StepFailure};

impl FailedLanes {
    /// The lanes of a mask.
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
        S::Mask::of_lanes(|lane| self.has(lane))
    }
}

impl StepFailure {
    /// The failure of a step that succeeded in some lanes only. Numbers without independent lanes get
    /// [`StepFailure::NonFinite`], and none of them has moved.
    #[cfg_attr(not(debug_assertions), inline(always))]
    #[must_use]
    pub fn but_of<S: Scalar>(taken: S::Mask) -> Self {
        if S::MAY_FAIL_BY_LANE { Self::Lanes(FailedLanes::of::<S>(!taken)) } else { Self::NonFinite }
    }
}
