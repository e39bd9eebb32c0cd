//! Counts in fixed bins.
//!
//! Tested by `tests/ensembles/statistics.rs`.

use crate::error::{ConfigError, wrong};
use crate::ground::digits::ShortestDecimal;
use crate::ground::numbers::numbers;

/// A limit on the number of bins, 128 MiB of them.
const MOST_BINS: usize = 1 << 24;

/// How many samples fell into each of several bins of equal width, `[lower, upper)` in all: bin `b` has those
/// from [`edge(b)`](Histogram::edge) on and below `edge(b + 1)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    lower: f64,
    upper: f64,
    counts: Vec<u64>,
    below: u64,
    above: u64,
    undefined: u64,
}

impl Histogram {
    /// This many empty bins from `lower` to `upper`.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] unless there is a bin, they have a width, and there are 2^24 at most.
    pub fn new(lower: f64, upper: f64, bins: usize) -> Result<Self, ConfigError> {
        let width = (upper - lower) / bins as f64;
        // The edges are multiples of the whole range.
        let is_finite = ((upper - lower) * bins as f64).is_finite();
        if bins == 0 || !is_finite || width <= 0.0 {
            let [lower, upper] = [lower, upper].map(ShortestDecimal);
            return wrong(format!(
                "a histogram with {bins} bins from {lower} to {upper}: they need a width above 0, and edges below the largest number"
            ));
        }
        if bins > MOST_BINS {
            return wrong(format!("a histogram with {bins} bins: take {MOST_BINS} at most"));
        }
        Ok(Self { lower, upper, counts: vec![0; bins], below: 0, above: 0, undefined: 0 })
    }

    /// One more sample.
    pub fn push(&mut self, sample: f64) {
        if sample.is_nan() {
            self.undefined += 1;
        } else if sample < self.lower {
            self.below += 1;
        } else if sample >= self.upper {
            self.above += 1;
        } else {
            let bin = self.bin(sample);
            self.counts[bin] += 1;
        }
    }

    /// The bin of a sample between `lower` and `upper`. The quotient rounds, and so do the edges: the edges
    /// decide.
    fn bin(&self, sample: f64) -> usize {
        let last = self.counts.len() - 1;
        let place = (sample - self.lower) / (self.upper - self.lower) * self.counts.len() as f64;
        let mut bin = (place as usize).min(last);
        while bin > 0 && sample < self.edge(bin) {
            bin -= 1;
        }
        while bin < last && sample >= self.edge(bin + 1) {
            bin += 1;
        }
        bin
    }

    /// The samples of both; they have the same bins.
    pub(crate) fn merge(&mut self, other: &Self) {
        for (ours, theirs) in self.counts.iter_mut().zip(&other.counts) {
            *ours += theirs;
        }
        self.below += other.below;
        self.above += other.above;
        self.undefined += other.undefined;
    }

    /// The counts, bin by bin.
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// The lower edge of a bin, which is the upper edge of the one before; the last bin ends at
    /// `edge(counts().len())`.
    pub fn edge(&self, bin: usize) -> f64 {
        let bins = self.counts.len();
        if bin == bins {
            self.upper
        } else {
            self.lower + (self.upper - self.lower) * bin as f64 / bins as f64
        }
    }

    /// Samples below all bins.
    pub fn below(&self) -> u64 {
        self.below
    }

    /// Samples at the upper end of all bins or above it.
    pub fn above(&self) -> u64 {
        self.above
    }

    /// Samples that were NaN.
    pub fn undefined(&self) -> u64 {
        self.undefined
    }

    /// All samples, wherever they fell.
    pub fn total(&self) -> u64 {
        self.counts.iter().sum::<u64>() + self.below + self.above + self.undefined
    }

    /// The count, the ends and the density of all bins, including those for values below, above and NaN.
    pub(super) fn bins(&self) -> impl Iterator<Item = (u64, [f64; 3])> {
        let inside = self.counts.iter().enumerate();
        let inside =
            inside.map(|(bin, &count)| (count, [self.edge(bin), self.edge(bin + 1), self.density(bin)]));
        let below = (self.below, [f64::NEG_INFINITY, self.lower, f64::NAN]);
        let above = (self.above, [self.upper, f64::INFINITY, f64::NAN]);
        let undefined = (self.undefined, [f64::NAN; 3]);
        std::iter::once(below).chain(inside).chain([above, undefined])
    }

    /// The density in a bin: the fraction of all samples in it, per unit of the observable. NaN for a bin
    /// that does not exist, and without samples.
    pub fn density(&self, bin: usize) -> f64 {
        let width = (self.upper - self.lower) / self.counts.len() as f64;
        match (self.counts.get(bin), self.total()) {
            (Some(&count), total) if total > 0 => count as f64 / (total as f64 * width),
            _ => f64::NAN,
        }
    }
}

numbers! { impl[] Numbers for Histogram { kept: counts[..], below, above, undefined; fixed: lower, upper } }

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_is_counted_once() {
        let mut histogram = Histogram::new(-1.0, 2.0, 3).unwrap();
        let below_two = 2.0 - f64::EPSILON;
        for x in
            [-1.0, -0.5, 0.0, 0.5, 1.5, below_two, 2.0, 7.0, f64::INFINITY, -1.1, f64::NEG_INFINITY, f64::NAN]
        {
            histogram.push(x);
        }
        assert_eq!(histogram.counts(), [2, 2, 2]);
        assert_eq!(
            (histogram.below(), histogram.above(), histogram.undefined(), histogram.total()),
            (2, 3, 1, 12)
        );
        assert_eq!([0, 1, 2, 3].map(|bin| histogram.edge(bin)), [-1.0, 0.0, 1.0, 2.0]);
        assert_eq!(histogram.density(1), 2.0 / 12.0);
        let mut twice = histogram.clone();
        twice.merge(&histogram);
        assert_eq!((twice.counts(), twice.total()), (&[4, 4, 4][..], 24));
    }

    /// A sample at an edge is in the bin that begins there, and its neighbour below in the one before.
    #[test]
    fn edges_decide() {
        for (lower, upper, bins) in
            [(-1.0, 1.0, 7), (0.0, 1.0, 10), (-2.0, 2.0, 80), (0.1, 0.7, 182), (1e9, 1e9 + 1.0, 33)]
        {
            let empty = Histogram::new(lower, upper, bins).unwrap();
            for bin in 0..bins {
                let edge = empty.edge(bin);
                for (sample, expected) in [(edge, Some(bin)), (edge.next_down(), bin.checked_sub(1))] {
                    let mut histogram = empty.clone();
                    histogram.push(sample);
                    let found = histogram.counts().iter().position(|&count| count == 1);
                    assert_eq!(found, expected, "{sample} of {bins} bins from {lower} to {upper}");
                }
            }
        }
    }

    #[test]
    fn more_bins_than_memory_are_refused() {
        assert!(Histogram::new(0.0, 1.0, 1 << 40).is_err() && Histogram::new(0.0, 1.0, usize::MAX).is_err());
        assert!(Histogram::new(0.0, 1.0, 1 << 20).is_ok());
    }

    #[test]
    fn bins_without_width_are_refused() {
        for (lower, upper, bins) in [
            (0.0, 1.0, 0),
            (1.0, 1.0, 4),
            (2.0, 1.0, 4),
            (f64::NAN, 1.0, 4),
            (0.0, f64::INFINITY, 4),
            (0.0, 1e308, 10),
        ] {
            assert!(Histogram::new(lower, upper, bins).is_err());
        }
    }
}
