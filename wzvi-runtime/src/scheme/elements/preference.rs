//! The iteration that a step starts with.
//!
//! Only a trial shows for certain whether the fixed point contracts: it may contract smooth corrections while
//! rounding errors, which are not smooth, grow. A failed trial costs about as much as a step. Each
//! consecutive failure doubles the number of steps until the next trial: failed trials take a small part of
//! the run time, and a fixed point that contracts again is found within about as many steps as it failed
//! before. Where the Jacobian suggests that the fixed point does not contract, it is tried in one of
//! [`RARELY`] steps nevertheless: the Jacobian shows the contraction of one correction only.

use crate::ground::numbers::{Numbers, Tape};

/// Consecutive failed trials after which the wait stays at 64 steps.
const MOST_IN_VAIN: u8 = 6;

/// Steps of Newton's method after which the fixed point is tried, whatever the Jacobian suggests.
const RARELY: u8 = 64;

/// The preference learnt from the steps so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Preference {
    /// Number of further steps that start with Newton's method. Only steps after which the fixed point may
    /// contract count down.
    steps: u8,
    /// Consecutive trials of the fixed point that Newton's method had to finish.
    in_vain: u8,
    /// Steps since the last trial after which the Jacobian suggested that the fixed point does not contract.
    against: u8,
}

/// How the equations of a step were solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SolvedBy {
    FixedPoint,
    /// Newton's method came first; `may_contract` if `J` is close to the identity, where the fixed point
    /// contracts, too.
    Newton {
        may_contract: bool,
    },
    /// The fixed point came first, and Newton's method finished.
    GaveWay,
}

impl Preference {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn is_newton(self) -> bool {
        self.steps > 0
    }

    /// Updates the preference after a successful step.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn learn(&mut self, solution: SolvedBy) {
        match solution {
            SolvedBy::FixedPoint => *self = Self::default(),
            SolvedBy::Newton { may_contract: true } => self.steps = self.steps.saturating_sub(1),
            SolvedBy::Newton { may_contract: false } if self.against + 1 < RARELY => {
                self.against += 1;
                self.steps = self.steps.max(1);
            }
            SolvedBy::Newton { may_contract: false } => (self.steps, self.against) = (0, 0),
            SolvedBy::GaveWay => {
                self.against = 0;
                self.in_vain = (self.in_vain + 1).min(MOST_IN_VAIN);
                self.steps = 1 << self.in_vain;
            }
        }
    }
}

impl Numbers for Preference {
    fn pass(&mut self, tape: &mut Tape) {
        tape.count(&mut self.steps);
        tape.count(&mut self.in_vain);
        tape.count(&mut self.against);
        self.in_vain = self.in_vain.min(MOST_IN_VAIN);
        self.against = self.against.min(RARELY);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of trials in `steps` steps that do not contract although the Jacobian suggests it.
    fn tries(steps: usize) -> usize {
        let mut preference = Preference::default();
        let mut tries = 0;
        for _ in 0..steps {
            let newton = preference.is_newton();
            tries += usize::from(!newton);
            preference.learn(if newton {
                SolvedBy::Newton { may_contract: true }
            } else {
                SolvedBy::GaveWay
            });
        }
        tries
    }

    /// After 1, 2 + 1, 4 + 1, ... steps, and then each 65th.
    #[test]
    fn tries_in_vain_become_rare() {
        assert_eq!([1, 3, 4, 8, 9].map(tries), [1, 1, 2, 2, 3]);
        assert_eq!(tries(133 + 65 * 10) - tries(133), 10);
    }

    #[test]
    fn a_fixed_point_that_contracts_again_is_kept() {
        let mut preference = Preference { in_vain: MOST_IN_VAIN, ..Preference::default() };
        preference.learn(SolvedBy::FixedPoint);
        assert_eq!(preference, Preference::default());
        preference.learn(SolvedBy::Newton { may_contract: false });
        assert!(preference.is_newton(), "what the Jacobian says holds for the next step");
    }

    /// One close encounter does not decide the rest of a run.
    #[test]
    fn a_fixed_point_that_seems_not_to_contract_is_tried_rarely() {
        let mut preference = Preference::default();
        preference.learn(SolvedBy::GaveWay);
        let tries = (0..10 * u32::from(RARELY)).filter(|_| {
            let is_tried = !preference.is_newton();
            preference.learn(match is_tried {
                true => SolvedBy::GaveWay,
                false => SolvedBy::Newton { may_contract: false },
            });
            is_tried
        });
        assert_eq!(tries.count(), 9);
    }
}
