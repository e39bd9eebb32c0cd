//! Means and covariances as the samples come, as in [`Welford`](crate::algebra::welford::Welford).
//!
//! Tested by `tests/ensembles/statistics.rs`.

use crate::algebra::scalar::Scalar;
use crate::ground::numbers::{Numbers, Tape, numbers};

/// How often the largest deviation of a sample may come again without having been expected: ten times more
/// than it was seen is the 95 % bound of Poisson's law for events that were seen 25 times, and beyond it for
/// fewer. The coverage that follows is measured in `control`.
const AGAIN: f64 = 10.0;

/// An upper estimate of the standard error of a mean of `count` samples: as if the largest deviation had come
/// [`AGAIN`] times more. The sample variance alone is zero until a rare event is seen, and too small for
/// heavy tails where the mean is too small as well.
fn error_bound(count: u64, variance: f64, largest: f64) -> f64 {
    let n = count as f64;
    ((variance + AGAIN * largest * (largest / n)) / n).sqrt()
}

/// The least and the greatest of some numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Extremes([f64; 2]);

impl Extremes {
    const NONE: Self = Self([f64::INFINITY, f64::NEG_INFINITY]);

    fn push(&mut self, value: f64) {
        self.merge(&Self([value, value]));
    }

    fn merge(&mut self, other: &Self) {
        let [least, greatest] = other.0;
        // Zeros of both signs count as one, or the order of merging would show.
        self.0 = [self.0[0].min(least) + 0.0, self.0[1].max(greatest) + 0.0];
    }

    /// Whether there are numbers, all of them equal.
    fn is_constant(&self) -> bool {
        self.0[0] == self.0[1]
    }

    fn width(&self) -> f64 {
        self.0[1] - self.0[0]
    }
}

/// Means and covariances of several observables.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Moments {
    count: u64,
    of_each: Vec<Summary>,
    /// Sums of products of scaled deviations: the lower triangle, by rows, or the diagonal alone.
    comoment: Vec<f64>,
    has_covariances: bool,
}

const fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits(((1023 + exponent) << 52).cast_unsigned())
}

/// Outside of this range squares, or sums of 2^50 squares, may be too small or too large for an `f64`.
const UNSCALED: [f64; 2] = [power_of_two(-400), power_of_two(480)];
/// The factors for values below, in and above that range: powers of two, so that nothing is rounded.
const SCALES: [f64; 3] = [power_of_two(800), 1.0, power_of_two(-560)];

/// The scale of a value. Scaled deviations of values of one scale are below 2^490 and, unless zero, above
/// 2^-453, so that neither their squares nor sums of 2^40 of them leave the range of `f64`.
#[inline]
fn scale(value: f64) -> f64 {
    let size = value.abs();
    if size > UNSCALED[1] {
        SCALES[2]
    } else if size < UNSCALED[0] {
        SCALES[0]
    } else {
        SCALES[1]
    }
}

/// One observable.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Summary {
    /// The least scale of the values, that of the largest one. Moments are those of values times this.
    scale: f64,
    mean: f64,
    extremes: Extremes,
    /// Values that are NaN or infinite: how many, and their sum, which is the sum of all.
    not_finite: (u64, f64),
}

impl Summary {
    const EMPTY: Self = Self { scale: SCALES[0], mean: 0.0, extremes: Extremes::NONE, not_finite: (0, 0.0) };

    /// The scaled deviations of one more value from the means without and with it; its `weight` is one over
    /// the number of values.
    #[inline]
    fn push(&mut self, value: f64, weight: f64) -> [f64; 2] {
        let Self { scale, mean, extremes, not_finite } = self;
        // A value that is not finite is replaced by one that changes no moment of the others.
        let finite = if value.is_finite() { value * *scale } else { *mean };
        if value.is_finite() {
            extremes.push(value);
        } else {
            *not_finite = (not_finite.0 + 1, not_finite.1 + value);
        }
        let before = finite - *mean;
        *mean += before * weight;
        [before, finite - *mean]
    }

    /// The largest scaled deviation from the mean.
    fn largest_deviation(&self) -> f64 {
        let [least, greatest] = self.extremes.0.map(|value| value * self.scale);
        (greatest - self.mean).max(self.mean - least)
    }
}

impl Moments {
    pub(crate) fn new(observables: usize, has_covariances: bool) -> Self {
        let products = if has_covariances { observables * (observables + 1) / 2 } else { observables };
        let of_each = vec![Summary::EMPTY; observables];
        Self { count: 0, of_each, comoment: vec![0.0; products], has_covariances }
    }

    /// Bytes for the moments of so many observables.
    pub(crate) fn bytes(observables: usize, has_covariances: bool) -> u128 {
        let n = observables as u128;
        8 * (if has_covariances { n * (n + 1) / 2 } else { n } + 6 * n)
    }

    /// One more sample; `scratch` is room for a number of each observable.
    pub(crate) fn push(&mut self, values: &[f64], scratch: &mut Vec<f64>) {
        for (observable, value) in values.iter().enumerate() {
            let Some(summary) = self.of_each.get(observable) else { break };
            if scale(*value) < summary.scale && value.is_finite() {
                self.rescale(observable, scale(*value));
            }
        }
        self.count += 1;
        let weight = 1.0 / self.count as f64;
        let samples = self.of_each.iter_mut().zip(values);
        let mut sums = self.comoment.iter_mut();
        if !self.has_covariances {
            for ((summary, value), sum) in samples.zip(sums) {
                let [before, after] = summary.push(*value, weight);
                *sum += before * after;
            }
            return;
        }
        scratch.clear();
        for (summary, value) in samples {
            let [before, after] = summary.push(*value, weight);
            scratch.push(after);
            for (after, sum) in scratch.iter().zip(&mut sums) {
                *sum += before * after;
            }
        }
    }

    /// Changes the scale of an observable.
    #[cold]
    fn rescale(&mut self, observable: usize, scale: f64) {
        let Some(summary) = self.of_each.get_mut(observable) else { return };
        // Zero for the largest beside the smallest values, whose deviations are then below rounding.
        let factor = scale / summary.scale;
        summary.scale = scale;
        summary.mean *= factor;
        let observables = self.of_each.len();
        for other in 0..observables {
            if let Some(index) = self.index(observable, other) {
                self.comoment[index] *= if other == observable { factor * factor } else { factor };
            }
        }
    }

    /// The index of the product of two observables, if it is computed.
    fn index(&self, a: usize, b: usize) -> Option<usize> {
        let (row, column) = (a.max(b), a.min(b));
        let index = if self.has_covariances { row * (row + 1) / 2 + column } else { row };
        (row < self.of_each.len() && (self.has_covariances || a == b)).then_some(index)
    }

    /// The samples of both. The order matters to the last bit.
    pub(crate) fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        let scales = |one: &Self| one.of_each.iter().map(|summary| summary.scale).collect::<Vec<_>>();
        if self.of_each.iter().zip(&other.of_each).any(|(ours, theirs)| ours.scale != theirs.scale) {
            let mut other = other.clone();
            for (observable, (ours, theirs)) in scales(self).into_iter().zip(scales(&other)).enumerate() {
                let changed = if theirs < ours { &mut *self } else { &mut other };
                changed.rescale(observable, ours.min(theirs));
            }
            return self.merge(&other);
        }
        let (a, b) = (self.count as f64, other.count as f64);
        let total = a + b;
        let mut sums = self.comoment.iter_mut().zip(&other.comoment);
        for (i, (ours, theirs)) in self.of_each.iter().zip(&other.of_each).enumerate() {
            let first = theirs.mean - ours.mean;
            let partners = if self.has_covariances { 0..=i } else { i..=i };
            let partners = self.of_each[partners.clone()].iter().zip(&other.of_each[partners]);
            for ((ours, theirs), (sum, more)) in partners.zip(&mut sums) {
                *sum += more + first * (theirs.mean - ours.mean) * (a * b / total);
            }
        }
        for (ours, theirs) in self.of_each.iter_mut().zip(&other.of_each) {
            ours.mean += (theirs.mean - ours.mean) * (b / total);
            ours.extremes.merge(&theirs.extremes);
            let (count, sum) = theirs.not_finite;
            ours.not_finite = (ours.not_finite.0 + count, ours.not_finite.1 + sum);
        }
        self.count += other.count;
    }

    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    pub(crate) fn has_covariances(&self) -> bool {
        self.has_covariances
    }

    /// Values of an observable that are NaN or infinite.
    pub(crate) fn not_finite(&self, observable: usize) -> u64 {
        self.of_each.get(observable).map_or(0, |one| one.not_finite.0)
    }

    /// NaN without samples; infinite with an infinite one, NaN with infinite ones of both signs.
    pub(crate) fn mean(&self, observable: usize) -> f64 {
        match self.of_each.get(observable) {
            Some(Summary { scale, mean, not_finite: (0, _), .. }) if self.count > 0 => mean / scale,
            Some(Summary { not_finite: (1.., sum), .. }) => *sum,
            _ => f64::NAN,
        }
    }

    /// The sum of the products of the deviations of two observables, in their scales; NaN if it is not known.
    fn scaled_comoment(&self, a: usize, b: usize) -> f64 {
        match self.index(a, b) {
            Some(index) if self.count >= 2 && self.not_finite(a) + self.not_finite(b) == 0 => {
                self.comoment[index]
            }
            _ => f64::NAN,
        }
    }

    /// A product of two observables in their scales, in their units; infinite where it is too large for an
    /// `f64`.
    fn unscaled(&self, a: usize, b: usize, scaled: f64) -> f64 {
        let [a, b] = [a, b].map(|observable| self.of_each.get(observable).map_or(1.0, |one| one.scale));
        if (a * b).is_normal() { scaled / (a * b) } else { scaled / a / b }
    }

    fn scaled_variance(&self, observable: usize) -> f64 {
        self.scaled_comoment(observable, observable) / self.count.saturating_sub(1) as f64
    }

    pub(crate) fn covariance(&self, a: usize, b: usize) -> f64 {
        self.unscaled(a, b, self.scaled_comoment(a, b) / self.count.saturating_sub(1) as f64)
    }

    /// Whether all samples of an observable are the same number.
    pub(crate) fn is_constant(&self, observable: usize) -> bool {
        self.not_finite(observable) == 0
            && self.of_each.get(observable).is_some_and(|one| one.extremes.is_constant())
    }

    pub(crate) fn standard_error(&self, observable: usize) -> f64 {
        let scale = self.of_each.get(observable).map_or(1.0, |one| one.scale);
        (self.scaled_variance(observable) / self.count as f64).sqrt() / scale
    }

    /// The share of the largest deviation in the sum of the squares of all; NaN where the variance is, and
    /// where there is no deviation.
    pub(crate) fn largest_share(&self, observable: usize) -> f64 {
        let Some(summary) = self.of_each.get(observable) else { return f64::NAN };
        Scalar::powi(summary.largest_deviation(), 2) / self.scaled_comoment(observable, observable)
    }

    /// The distance between the least and the greatest sample.
    pub(crate) fn width(&self, observable: usize) -> f64 {
        self.of_each.get(observable).map_or(f64::NAN, |one| one.extremes.width())
    }

    /// An upper estimate of the variance, where a sample may be `unseen` away from the mean although none
    /// was.
    pub(crate) fn variance_bound(&self, observable: usize, unseen: f64) -> f64 {
        let Some(summary) = self.of_each.get(observable) else { return f64::NAN };
        // In the scale of the unseen deviation where it is the larger one: samples that are all zero have the
        // scale of the smallest.
        let scale = summary.scale.min(scale(unseen));
        let factor = scale / summary.scale;
        let largest = (summary.largest_deviation() * factor).max(unseen * scale);
        let variance = self.scaled_variance(observable) * factor * factor;
        let bound = self.count as f64 * Scalar::powi(error_bound(self.count, variance, largest), 2);
        if (scale * scale).is_normal() { bound / (scale * scale) } else { bound / scale / scale }
    }

    /// As [`error_bound`]; NaN where the variance is, and where all samples are the same number.
    pub(crate) fn error_bound(&self, observable: usize) -> f64 {
        if self.is_constant(observable) {
            return f64::NAN;
        }
        let Some(summary) = self.of_each.get(observable) else { return f64::NAN };
        error_bound(self.count, self.scaled_variance(observable), summary.largest_deviation()) / summary.scale
    }
}

numbers! { impl[] Numbers for Moments { kept: count, comoment[..], of_each[..]; fixed: has_covariances } }

impl Numbers for Summary {
    fn pass(&mut self, tape: &mut Tape) {
        let Self { scale, mean, extremes, not_finite: (count, sum) } = self;
        tape.word(count);
        tape.numbers([scale, mean, sum]);
        tape.numbers(&mut extremes.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::welford::Welford;

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
            let (mut moments, mut single) = (Moments::new(2, true), Welford::default());
            for chunk in samples.chunks(samples.len().div_ceil(parts)) {
                let (mut part, mut part_single) = (Moments::new(2, true), Welford::default());
                for sample in chunk {
                    part.push(sample, &mut Vec::new());
                    part_single.push(sample[0]);
                }
                moments.merge(&part);
                single.merge(&part_single);
            }
            // The nth addition to the mean rounds by 7.5e-9 at most, of which n/3000 is left at the end:
            // 1.2e-5 in all, and twice that in products of deviations below 1. Sums of squares would have
            // lost everything: 1e16 · 1e-16.
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

    /// A value that is not finite changes the mean of its own observable, and no other mean.
    #[test]
    fn infinite_samples_show_in_their_own_mean_only() {
        let rows = [[1.0, f64::INFINITY, 2.0], [3.0, 1.0, -5.0], [5.0, 2.0, 9.0], [7.0, f64::INFINITY, 2.5]];
        let mut all = Moments::new(3, true);
        let mut parts = Moments::new(3, true);
        for pair in rows.chunks(2) {
            let mut part = Moments::new(3, true);
            for row in pair {
                all.push(row, &mut Vec::new());
                part.push(row, &mut Vec::new());
            }
            parts.merge(&part);
        }
        for moments in [&all, &parts] {
            assert_eq!([moments.mean(0), moments.mean(1)], [4.0, f64::INFINITY]);
            assert_eq!([moments.not_finite(0), moments.not_finite(1)], [0, 2]);
            assert!(moments.covariance(0, 1).is_nan() && moments.covariance(1, 1).is_nan());
            assert!(moments.error_bound(1).is_nan());
            // Variance of 1, 3, 5, 7: 20/3.
            assert!((moments.covariance(0, 0) - 20.0 / 3.0).abs() < 1e-14);
        }
        all.push(&[0.0, f64::NEG_INFINITY, 0.0], &mut Vec::new());
        assert!(all.mean(1).is_nan() && all.mean(0) == 3.2);
    }

    /// Samples of any size have the mean, the error and, where an `f64` holds it, the variance of 1, 2, 4 in
    /// their units, in any division of the work, beside an observable of ordinary size. Powers of two round
    /// nothing.
    #[test]
    fn moments_neither_overflow_nor_underflow() {
        for exponent in [-1000, -700, -480, -400, -100, 0, 470, 480, 500, 800, 1020] {
            let unit = 2f64.powi(exponent);
            let rows =
                [1.0, 2.0, 4.0, 1.0, 4.0].map(|x| [x * unit, 8.0 - x, if x < 3.0 { -unit } else { unit }]);
            for parts in [1, 2, 5] {
                let mut moments = Moments::new(3, true);
                for chunk in rows.chunks(rows.len().div_ceil(parts)) {
                    let mut part = Moments::new(3, true);
                    chunk.iter().for_each(|row| part.push(row, &mut Vec::new()));
                    moments.merge(&part);
                }
                // Mean 2.4, squares of deviations 1.96 + 0.16 + 2.56 + 1.96 + 2.56 = 9.2.
                let near = |found: f64, exact: f64| {
                    assert!((found / exact - 1.0).abs() < 1e-14, "2^{exponent}, {parts}: {found} {exact}");
                };
                near(moments.mean(0) / unit, 2.4);
                near(moments.standard_error(0) / unit, (2.3_f64 / 5.0).sqrt());
                near(moments.mean(2) / unit, -0.2);
                near(moments.largest_share(0), 2.56 / 9.2);
                near(moments.covariance(0, 1) / unit, -2.3);
                near(moments.variance_bound(1, 0.0), 2.3 + 10.0 * 2.56 / 5.0);
                near(moments.error_bound(0) / unit, ((2.3 + 10.0 * 2.56 / 5.0) / 5.0_f64).sqrt());
                if exponent.abs() <= 500 {
                    near(moments.covariance(0, 0) / unit / unit, 2.3);
                } else {
                    assert_eq!(moments.covariance(0, 0), if exponent > 0 { f64::INFINITY } else { 0.0 });
                }
            }
        }
        // Samples that are all zero, and a deviation of any size that none of them shows: 10 D² / n².
        for unseen in [1e-200, 1.0, 1e200] {
            let mut zeros = Moments::new(1, false);
            (0..5).for_each(|_| zeros.push(&[0.0], &mut Vec::new()));
            let bound = zeros.variance_bound(0, unseen);
            let exact = 10.0 * unseen * unseen / 5.0;
            assert!(bound == exact || (bound / exact - 1.0).abs() < 1e-14, "{unseen}: {bound} {exact}");
        }
        // The sum of the squares is infinite, the variance is not; sizes that grow and shrink; the whole
        // range of numbers.
        let spread = |values: &[f64]| {
            let mut moments = Moments::new(1, false);
            values.iter().for_each(|value| moments.push(&[*value], &mut Vec::new()));
            moments
        };
        let large: Vec<f64> = (0..100).map(|n| if n % 2 == 0 { 1e154 } else { -1e154 }).collect();
        assert!((spread(&large).covariance(0, 0) / 1e308 - 100.0 / 99.0).abs() < 1e-13);
        let sizes = spread(&[1e-300, 1.0, 3e300, 5.0, 1e-310]);
        assert!(
            (sizes.mean(0) / 6e299 - 1.0).abs() < 1e-14
                && (sizes.standard_error(0) / 6e299 - 1.0).abs() < 1e-14
        );
        let extremes = spread(&[f64::MAX, -f64::MAX]);
        assert_eq!((extremes.mean(0), extremes.standard_error(0)), (0.0, f64::MAX));
    }

    #[test]
    fn variances_alone_are_the_same() {
        let (mut full, mut lean) = (Moments::new(2, true), Moments::new(2, false));
        for i in 0..50_i32 {
            let row = [f64::from(i * i % 7), f64::from(i % 5)];
            let (mut a, mut b) = (Moments::new(2, true), Moments::new(2, false));
            a.push(&row, &mut Vec::new());
            b.push(&row, &mut Vec::new());
            full.merge(&a);
            lean.merge(&b);
        }
        for i in [0, 1] {
            assert_eq!(full.covariance(i, i).to_bits(), lean.covariance(i, i).to_bits());
        }
        assert!(lean.covariance(0, 1).is_nan() && !full.covariance(0, 1).is_nan());
        assert!(Moments::bytes(3000, true) > 100 * Moments::bytes(3000, false));
    }
}
