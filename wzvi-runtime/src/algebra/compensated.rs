//! Compensated sums: `W(t)` to its last digits after any number of steps.
//!
//! With `s + x = r + e` exactly, `r` the rounded sum, Neumaier's method keeps the errors `e` and adds them at
//! the end.

use crate::ground::numbers::{Numbers, Tape, numbers};

/// One compensated sum.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CompensatedNumber {
    rounded: f64,
    lost: f64,
}

impl CompensatedNumber {
    #[inline]
    pub(crate) fn add(&mut self, term: f64) {
        let sum = self.rounded;
        self.rounded = sum + term;
        let (large, small) = if sum.abs() >= term.abs() { (sum, term) } else { (term, sum) };
        self.lost += (large - self.rounded) + small;
    }

    #[inline]
    pub(crate) fn total(self) -> f64 {
        self.rounded + self.lost
    }
}

numbers! { impl[] Numbers for CompensatedNumber { kept: rounded, lost } }

/// Several at once, with their totals at hand.
#[derive(Clone, Debug)]
pub(crate) struct CompensatedTotals {
    sums: Vec<CompensatedNumber>,
    totals: Vec<f64>,
}

impl CompensatedTotals {
    pub(crate) fn new(len: usize) -> Self {
        Self { sums: vec![CompensatedNumber::default(); len], totals: vec![0.0; len] }
    }

    #[inline]
    pub(crate) fn add(&mut self, terms: &[f64]) {
        for ((sum, total), &term) in self.sums.iter_mut().zip(&mut self.totals).zip(terms) {
            sum.add(term);
            *total = sum.total();
        }
    }

    pub(crate) fn totals(&self) -> &[f64] {
        &self.totals
    }

    /// Passes the sums to the tape of a checkpoint.
    pub(crate) fn pass(&mut self, tape: &mut Tape) {
        for (sum, total) in self.sums.iter_mut().zip(&mut self.totals) {
            sum.pass(tape);
            *total = sum.total();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_keep_what_rounding_drops() {
        let mut sums = CompensatedTotals::new(1);
        for term in [1.0, 1e100, 1.0, -1e100] {
            sums.add(&[term]);
        }
        assert_eq!(sums.totals(), [2.0]);
    }
}
