//! Which iteration a step starts with.
//!
//! Whether the fixed point contracts is known for certain where it was tried: at smooth corrections it may look as if it did where rounding,
//! which is not smooth, grows. A try in vain costs about as much as a step. So each one in a row doubles the steps until the next: all
//! that are in vain take a small part of the time, and a fixed point that contracts again is found after as many steps as it was missed.

use crate::ground::numbers::Tape;

/// Tries in vain after which waiting grows no longer: for 64 steps.
const MOST_IN_VAIN: u8 = 6;

/// What the steps before say of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Preference {
    /// Steps that start with Newton's method from here on, as long as they say that the fixed point may contract.
    steps: u8,
    /// Tries of the fixed point in a row that Newton's method had to end.
    in_vain: u8,
}

/// How the equations of a step were solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Solution {
    FixedPoint,
    /// Newton's method was first; whether `J` is about the identity, where the fixed point contracts as well.
    Newton {
        may_contract: bool,
    },
    /// The fixed point was first, and Newton's method ended it.
    GaveWay,
}

impl Preference {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn is_newton(self) -> bool {
        self.steps > 0
    }

    /// A step has succeeded.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn learn(&mut self, solution: Solution) {
        match solution {
            Solution::FixedPoint => *self = Self::default(),
            Solution::Newton { may_contract: true } => self.steps = self.steps.saturating_sub(1),
            Solution::Newton { may_contract: false } => self.steps = self.steps.max(1),
            Solution::GaveWay => {
                self.in_vain = (self.in_vain + 1).min(MOST_IN_VAIN);
                self.steps = 1 << self.in_vain;
            }
        }
    }

    pub(super) fn pass(&mut self, tape: &mut Tape) {
        tape.count(&mut self.steps);
        tape.count(&mut self.in_vain);
        self.in_vain = self.in_vain.min(MOST_IN_VAIN);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of so many steps that do not contract, though the Jacobian says so: those that try.
    fn tries(steps: usize) -> usize {
        let mut preference = Preference::default();
        let mut tries = 0;
        for _ in 0..steps {
            let newton = preference.is_newton();
            tries += usize::from(!newton);
            preference.learn(if newton {
                Solution::Newton { may_contract: true }
            } else {
                Solution::GaveWay
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
        let mut preference = Preference { steps: 0, in_vain: MOST_IN_VAIN };
        preference.learn(Solution::FixedPoint);
        assert_eq!(preference, Preference::default());
        preference.learn(Solution::Newton { may_contract: false });
        assert!(preference.is_newton(), "what the Jacobian says holds for the next step");
    }
}
