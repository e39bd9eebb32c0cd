//! Mean and variance as the samples come.
//!
//! B. P. Welford, Technometrics 4 (1962) 419; merged as in T. F. Chan, G. H. Golub, R. J. LeVeque, "Updating
//! formulae and a pairwise algorithm for computing sample variances", 1979.

use crate::ground::numbers::numbers;

/// Mean and variance of one quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Welford {
    count: u64,
    mean: f64,
    /// Sum of squares of deviations.
    squares: f64,
}

impl Welford {
    pub(crate) fn push(&mut self, value: f64) {
        self.count += 1;
        let deviation = value - self.mean;
        self.mean += deviation / self.count as f64;
        self.squares += deviation * (value - self.mean);
    }

    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    /// NaN without samples.
    pub(crate) fn mean(&self) -> f64 {
        if self.count == 0 { f64::NAN } else { self.mean }
    }

    /// Unbiased; NaN for fewer than two samples.
    pub(crate) fn variance(&self) -> f64 {
        if self.count < 2 { f64::NAN } else { self.squares / (self.count - 1) as f64 }
    }

    /// The sum of the squares of the deviations from the mean.
    pub(crate) fn squares(&self) -> f64 {
        self.squares
    }

    /// The samples of both. The order matters to the last bit.
    pub(crate) fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        let (a, b) = (self.count as f64, other.count as f64);
        let difference = other.mean - self.mean;
        self.squares += other.squares + difference * difference * (a * b / (a + b));
        self.mean += difference * (b / (a + b));
        self.count += other.count;
    }

    /// The sum of all samples.
    pub(crate) fn sum(&self) -> f64 {
        self.mean * self.count as f64
    }

    pub(crate) fn standard_error(&self) -> f64 {
        (self.variance() / self.count as f64).sqrt()
    }
}

numbers! { impl[] Numbers for Welford { kept: count, mean, squares } }
