//! The unknowns of past steps, from which the next one starts: the counterpart of
//! [`Extrapolation`](crate::algebra::solve::Extrapolation) for any number of unknowns.

use crate::algebra::scalar::Scalar;
use crate::ground::numbers::{Numbers, Tape};

/// The unknowns of three steps, and of how many of these they are known.
#[derive(Clone, Debug, Default)]
pub(super) struct PastUnknowns<S> {
    /// The latest first.
    pub(super) lists: [Vec<S>; 3],
    pub(super) known: u8,
}

impl<S: Scalar> PastUnknowns<S> {
    /// Room for so many unknowns.
    pub(super) fn resize(&mut self, unknowns: usize) {
        self.lists.iter_mut().for_each(|list| list.resize(unknowns, S::from_f64(0.0)));
    }

    /// Records the unknowns of a step.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn record(&mut self, unknowns: &[S]) {
        if self.lists[0].len() != unknowns.len() {
            self.resize(unknowns.len());
        }
        self.lists.rotate_right(1);
        self.lists[0].copy_from_slice(unknowns);
        self.count();
    }

    /// One step more is known.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn count(&mut self) {
        self.known = (self.known + 1).min(3);
    }

    /// Becomes a copy, without allocating where it has room.
    pub(super) fn copy(&mut self, other: &Self) {
        if other.known > 0 {
            self.lists.clone_from(&other.lists);
        }
        self.known = other.known;
    }
}

/// The lists are there once a step is known.
impl<S: Scalar> Numbers for PastUnknowns<S> {
    fn pass(&mut self, tape: &mut Tape) {
        let unknowns = tape.length(if self.known == 0 { 0 } else { self.lists[0].len() });
        tape.count(&mut self.known);
        if unknowns != 0 {
            self.resize(unknowns);
            self.lists.iter_mut().flatten().for_each(|number| number.pass(tape));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::PastUnknowns;
    use crate::ground::numbers::{Numbers as _, Tape};

    /// The words have the steps that are known, and their number.
    #[test]
    fn words_have_all_steps_that_are_known() {
        let mut past = PastUnknowns::<f64>::default();
        for steps in 0_u8..5 {
            let mut read = PastUnknowns::default();
            Tape::read(Tape::write(|tape| past.pass(tape)), |tape| read.pass(tape)).unwrap();
            assert_eq!((read.known, &read.lists), (steps.min(3), &past.lists));
            past.record(&[f64::from(steps), -0.5]);
        }
    }
}
