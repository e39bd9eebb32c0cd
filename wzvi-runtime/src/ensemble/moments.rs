//! Means, variances and covariances as the samples come.
//!
//! B. P. Welford, Technometrics 4 (1962) 419; merged as in T. F. Chan, G. H. Golub, R. J. LeVeque, "Updating formulae and a
//! pairwise algorithm for computing sample variances", 1979.

#[cfg(feature = "serde")]
use crate::numbers::Tape;

/// Mean and variance of one quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Welford {
    count: u64,
    mean: f64,
    /// Sum of squares of deviations.
    squares: f64,
}

impl Welford {
    pub(super) fn push(&mut self, value: f64) {
        self.count += 1;
        let deviation = value - self.mean;
        self.mean += deviation / self.count as f64;
        self.squares += deviation * (value - self.mean);
    }

    /// The samples of both. The order matters to the last bit.
    pub(super) fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        let (a, b) = (self.count as f64, other.count as f64);
        let difference = other.mean - self.mean;
        self.squares += other.squares + difference * difference * (a * b / (a + b));
        self.mean += difference * (b / (a + b));
        self.count += other.count;
    }

    #[cfg(feature = "serde")]
    pub(super) fn pass(&mut self, tape: &mut Tape) {
        tape.word(&mut self.count);
        tape.numbers([&mut self.mean, &mut self.squares]);
    }

    pub(super) fn count(&self) -> u64 {
        self.count
    }

    /// NaN without samples.
    pub(super) fn mean(&self) -> f64 {
        if self.count == 0 { f64::NAN } else { self.mean }
    }

    /// Unbiased; NaN for fewer than two samples.
    pub(super) fn variance(&self) -> f64 {
        if self.count < 2 { f64::NAN } else { self.squares / (self.count - 1) as f64 }
    }

    pub(super) fn standard_error(&self) -> f64 {
        (self.variance() / self.count as f64).sqrt()
    }
}

/// Means and covariances of several observables.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Moments {
    count: u64,
    mean: Vec<f64>,
    /// Sums of products of deviations: the lower triangle, by rows.
    comoment: Vec<f64>,
}

impl Moments {
    pub(super) fn new(observables: usize) -> Self {
        Self {
            count: 0,
            mean: vec![0.0; observables],
            comoment: vec![0.0; observables * (observables + 1) / 2],
        }
    }

    /// One more sample; `scratch` has as many elements as `values`.
    pub(super) fn push(&mut self, values: &[f64], scratch: &mut [f64]) {
        self.count += 1;
        let weight = 1.0 / self.count as f64;
        for ((mean, deviation), value) in self.mean.iter_mut().zip(scratch.iter_mut()).zip(values) {
            *deviation = value - *mean;
            *mean += *deviation * weight;
        }
        let mut sums = self.comoment.iter_mut();
        for (i, deviation) in scratch.iter().enumerate() {
            for ((value, mean), sum) in values.iter().zip(&self.mean).take(i + 1).zip(&mut sums) {
                *sum += deviation * (value - mean);
            }
        }
    }

    /// The samples of both. The order matters to the last bit.
    pub(super) fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        let (a, b) = (self.count as f64, other.count as f64);
        let total = a + b;
        let difference: Vec<f64> =
            other.mean.iter().zip(&self.mean).map(|(theirs, ours)| theirs - ours).collect();
        let mut sums = self.comoment.iter_mut().zip(&other.comoment);
        for (i, first) in difference.iter().enumerate() {
            for (second, (sum, theirs)) in difference.iter().take(i + 1).zip(&mut sums) {
                *sum += theirs + first * second * (a * b / total);
            }
        }
        for (mean, difference) in self.mean.iter_mut().zip(&difference) {
            *mean += difference * (b / total);
        }
        self.count += other.count;
    }

    #[cfg(feature = "serde")]
    pub(super) fn pass(&mut self, tape: &mut Tape) {
        tape.word(&mut self.count);
        tape.numbers(self.mean.iter_mut().chain(&mut self.comoment));
    }

    pub(super) fn count(&self) -> u64 {
        self.count
    }

    pub(super) fn mean(&self, observable: usize) -> f64 {
        if self.count == 0 { f64::NAN } else { self.mean.get(observable).copied().unwrap_or(f64::NAN) }
    }

    pub(super) fn covariance(&self, a: usize, b: usize) -> f64 {
        let n = self.mean.len();
        if a >= n || b >= n || self.count < 2 {
            return f64::NAN;
        }
        let (row, column) = (a.max(b), a.min(b));
        self.comoment[row * (row + 1) / 2 + column] / (self.count - 1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In two passes over numbers with a large mean, where the textbook formula would lose everything.
    #[test]
    fn pushed_and_merged_moments_are_those_of_two_passes() {
        let unit = |n: u64| (n.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11) as f64 / 2f64.powi(53);
        let samples: Vec<[f64; 2]> =
            (1..3001).map(|n| [1e8 + unit(n), unit(n) - 2.0 * unit(3 * n + 1)]).collect();
        let n = samples.len() as f64;
        let mean = [0, 1].map(|i| samples.iter().map(|x| x[i] - [1e8, 0.0][i]).sum::<f64>() / n);
        let centred = |x: &[f64; 2], i: usize| x[i] - [1e8, 0.0][i] - mean[i];
        let covariance =
            |i, j| samples.iter().map(|x| centred(x, i) * centred(x, j)).sum::<f64>() / (n - 1.0);
        for parts in [1, 2, 7, 3000] {
            let (mut moments, mut single) = (Moments::new(2), Welford::default());
            for chunk in samples.chunks(samples.len().div_ceil(parts)) {
                let (mut part, mut part_single) = (Moments::new(2), Welford::default());
                for sample in chunk {
                    part.push(sample, &mut [0.0; 2]);
                    part_single.push(sample[0]);
                }
                moments.merge(&part);
                single.merge(&part_single);
            }
            // The nth addition to the mean rounds by 7.5e-9 at most, of which n/3000 is left at the end: 1.2e-5 in all, and twice
            // that in products of deviations below 1. Sums of squares would have lost everything: 1e16 · 1e-16.
            assert!((moments.mean(0) - 1e8 - mean[0]).abs() < 1.2e-5);
            assert!((moments.mean(1) - mean[1]).abs() < 1e-13);
            for (i, j) in [(0, 0), (0, 1), (1, 0)] {
                assert!((moments.covariance(i, j) - covariance(i, j)).abs() < 2.4e-5, "{parts} {i} {j}");
            }
            assert!((moments.covariance(1, 1) - covariance(1, 1)).abs() < 1e-13);
            assert!((single.variance() - covariance(0, 0)).abs() < 2.4e-5 && single.count() == 3000);
            assert_eq!(single.standard_error(), (single.variance() / n).sqrt());
        }
    }
}
