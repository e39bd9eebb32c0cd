//! Quantiles in memory that does not grow with the number of samples, to a known relative error.
//!
//! Samples are counted in bins between neighbouring numbers of nine binary digits behind the leading one, and
//! a quantile is the middle of the bin that the exact one is in. Counts of the same bins add up in any order
//! to the same numbers, so that merging loses nothing (C. Masson, J. E. Rim, H. K. Lee, "DDSketch: a fast and
//! fully-mergeable quantile sketch with relative-error guarantees", Proc. VLDB Endow. 12, 2019, with the bins
//! of binary numbers in place of a logarithm).
//!
//! Tested by `tests/ensembles/statistics.rs`.

use std::borrow::Cow;
use std::fmt;

use crate::ground::numbers::{Numbers, Tape};

/// Bits of the mantissa that a bin ignores.
const IGNORED: u32 = 52 - 9;
/// Bins of an octave: from a power of two to the next.
const OCTAVE: usize = 1 << 9;
/// Samples that are listed before they are counted: a list of them costs less than the counts of its octaves,
/// where samples are few.
const MOST_LISTED: usize = 1 << 10;

/// Samples for which the list has room from the first on: the paths of a chunk of an ensemble, say.
const FIRST_LISTED: usize = 1 << 6;

/// The distribution of samples, for their quantiles.
///
/// A quantile is off by at most [`Quantiles::RELATIVE_ERROR`] of the exact one, whatever the distribution: if
/// numbers far from zero differ little, subtract a common value first. Memory is 4 KiB for each factor of
/// two, of each sign, that a sample fell into.
#[derive(Clone, Default)]
pub struct Quantiles {
    /// Bins of samples that are not counted yet.
    listed: Vec<i32>,
    /// Counts of the bins of the octaves that occur.
    counts: Vec<u64>,
    /// The start in `counts` of the bins of each octave, from the octave `least` on; [`NOWHERE`] for octaves
    /// that do not occur.
    octaves: Vec<usize>,
    least: i32,
    count: u64,
    undefined: u64,
    extremes: Option<[f64; 2]>,
}

const NOWHERE: usize = usize::MAX;

/// The bins that samples fell into, in order: how they are kept depends on the order in which they came.
impl fmt::Debug for Quantiles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bins: Vec<_> = self.counted().bins().collect();
        let mut fields = f.debug_struct("Quantiles");
        fields.field("bins", &bins).field("undefined", &self.undefined).field("extremes", &self.extremes);
        fields.finish_non_exhaustive()
    }
}

impl PartialEq for Quantiles {
    fn eq(&self, other: &Self) -> bool {
        self.count == other.count
            && self.undefined == other.undefined
            && self.extremes == other.extremes
            && self.counted().bins().eq(other.counted().bins())
    }
}

impl Quantiles {
    /// Bytes of memory before samples are counted.
    pub(crate) const LEAST_BYTES: usize = size_of::<Self>() + MOST_LISTED * size_of::<i32>();

    /// Half a bin: `2^-10`.
    pub const RELATIVE_ERROR: f64 = 1.0 / 1024.0;

    /// One more sample.
    pub fn push(&mut self, sample: f64) {
        if sample.is_nan() {
            self.undefined += 1;
            return;
        }
        self.count += 1;
        if self.listed.capacity() == 0 {
            self.listed.reserve(FIRST_LISTED);
        }
        self.listed.push(bin(sample));
        self.extend([sample, sample]);
        if self.listed.len() >= MOST_LISTED {
            self.count_listed();
        }
    }

    /// The samples of both.
    pub fn merge(&mut self, other: &Self) {
        self.listed.extend(&other.listed);
        other.bins().for_each(|(bin, count)| *self.at_bin(bin) += count);
        self.count += other.count;
        self.undefined += other.undefined;
        if let Some(extremes) = other.extremes {
            self.extend(extremes);
        }
        if self.listed.len() >= MOST_LISTED {
            self.count_listed();
        }
    }

    #[inline(never)]
    fn count_listed(&mut self) {
        let mut listed = std::mem::take(&mut self.listed);
        listed.drain(..).for_each(|bin| *self.at_bin(bin) += 1);
        self.listed = listed;
    }

    /// With all samples counted.
    fn counted(&self) -> Cow<'_, Self> {
        if self.listed.is_empty() {
            return Cow::Borrowed(self);
        }
        let mut counted = self.clone();
        counted.count_listed();
        Cow::Owned(counted)
    }

    /// The count of a bin.
    #[inline]
    fn at_bin(&mut self, bin: i32) -> &mut u64 {
        let octave = bin >> OCTAVE.ilog2();
        let first = match self.octaves.get((octave - self.least) as usize) {
            Some(&first) if first != NOWHERE => first,
            _ => self.open(octave),
        };
        &mut self.counts[first + (bin as usize & (OCTAVE - 1))]
    }

    /// Makes room for the counts of an octave; returns where they begin.
    #[cold]
    fn open(&mut self, octave: i32) -> usize {
        if self.octaves.is_empty() {
            self.least = octave;
        }
        let before = usize::try_from(self.least - octave).unwrap_or(0);
        if before > 0 {
            self.octaves.splice(..0, std::iter::repeat_n(NOWHERE, before));
            self.least = octave;
        }
        let place = (octave - self.least) as usize;
        if place >= self.octaves.len() {
            self.octaves.resize(place + 1, NOWHERE);
        }
        let first = self.counts.len();
        self.octaves[place] = first;
        self.counts.resize(first + OCTAVE, 0);
        first
    }

    /// The bins that are not empty, with their counts, in order.
    fn bins(&self) -> impl Iterator<Item = (i32, u64)> {
        let octaves = (self.least..).zip(&self.octaves).filter(|(_, first)| **first != NOWHERE);
        octaves.flat_map(|(octave, &first)| {
            let counts = (octave * OCTAVE as i32..).zip(&self.counts[first..first + OCTAVE]);
            counts.filter(|(_, count)| **count > 0).map(|(bin, count)| (bin, *count))
        })
    }

    fn extend(&mut self, [least, greatest]: [f64; 2]) {
        let [a, b] = self.extremes.unwrap_or([least, greatest]);
        // Zeros of both signs count as one, or the order of merging would show.
        self.extremes = Some([a.min(least) + 0.0, b.max(greatest) + 0.0]);
    }

    /// Number of samples, without those that are not numbers.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Samples that were NaN.
    pub fn undefined(&self) -> u64 {
        self.undefined
    }

    /// The least sample, exactly; NaN without any.
    pub fn minimum(&self) -> f64 {
        self.extremes.map_or(f64::NAN, |[least, _]| least)
    }

    /// The greatest sample, exactly; NaN without any.
    pub fn maximum(&self) -> f64 {
        self.extremes.map_or(f64::NAN, |[_, greatest]| greatest)
    }

    /// The least sample that at least this fraction of all samples does not exceed, to a relative error of
    /// [`Quantiles::RELATIVE_ERROR`]; exactly for 0 and 1. NaN for other fractions than 0 to 1, without
    /// samples, and if any was NaN.
    pub fn at(&self, fraction: f64) -> f64 {
        if !(0.0..=1.0).contains(&fraction) || self.undefined > 0 {
            return f64::NAN;
        }
        let Some([least, greatest]) = self.extremes else { return f64::NAN };
        let rank = rank(fraction, self.count);
        if rank <= 1 {
            return least;
        }
        if rank >= self.count {
            return greatest;
        }
        let mut seen = 0;
        let found = self.counted().bins().find(|(_, count)| {
            seen += count;
            seen >= rank
        });
        found.map_or(greatest, |(bin, _)| middle(bin).clamp(least, greatest))
    }
}

impl Numbers for Quantiles {
    fn pass(&mut self, tape: &mut Tape) {
        self.count_listed();
        tape.words([&mut self.count, &mut self.undefined]);
        let mut is_any = self.extremes.is_some();
        tape.flag(&mut is_any);
        let mut extremes = self.extremes.unwrap_or_default();
        tape.numbers(&mut extremes);
        self.extremes = is_any.then_some(extremes);
        let mut bins: Vec<(i32, u64)> = self.bins().collect();
        let length = tape.length(bins.len());
        if tape.is_reading() {
            self.counts.clear();
            self.octaves.clear();
            bins = vec![(0, 0); length];
        }
        for (bin, count) in &mut bins {
            let mut word = i64::from(*bin).cast_unsigned();
            tape.words([&mut word, count]);
            match i32::try_from(word.cast_signed()) {
                // No bin lies beyond those of infinity, the number with the most bits.
                Ok(read) if (-self::bin(f64::INFINITY) - 1..=self::bin(f64::INFINITY)).contains(&read) => {
                    *bin = read
                }
                _ => return tape.refuse(),
            }
        }
        if tape.is_reading() {
            bins.into_iter().for_each(|(bin, count)| *self.at_bin(bin) += count);
        }
    }
}

/// The least `k` for which `k / n` is not below the fraction. The quotient decides, not the product: 0.07 is
/// the number next to 7/100, but 0.07 · 100 is above 7.
fn rank(fraction: f64, n: u64) -> u64 {
    let is_enough = |k: u64| k as f64 / n as f64 >= fraction;
    let near = ((fraction * n as f64).ceil() as u64).min(n);
    match near {
        1.. if is_enough(near - 1) => near - 1,
        _ if is_enough(near) => near,
        _ => near + 1,
    }
}

/// Subnormal numbers times this are normal.
const RAISE: f64 = (1_u64 << RAISED) as f64;
const RAISED: u32 = 53;
/// The octaves below the least normal number: one for zero, and those of subnormal numbers.
const BELOW: u64 = RAISED as u64 - 1;

/// The bin of a number; the order of bins is that of the numbers in them. Zero has a bin of its own, 0.
fn bin(x: f64) -> i32 {
    let size = x.abs();
    let octaves = if size < f64::MIN_POSITIVE { size * RAISE } else { size }.to_bits() >> IGNORED;
    // Below 2^21.
    let bin = if size == 0.0 {
        0
    } else if size < f64::MIN_POSITIVE {
        octaves - OCTAVE as u64
    } else {
        octaves + BELOW * OCTAVE as u64
    } as i32;
    if x < 0.0 { -1 - bin } else { bin }
}

/// The middle of the numbers in a bin.
fn middle(bin: i32) -> f64 {
    let size = u64::from(if bin < 0 { -1 - bin } else { bin }.cast_unsigned());
    let middle_of = |octaves: u64| f64::from_bits((2 * octaves + 1) << (IGNORED - 1));
    let least_normal = (BELOW + 1) * OCTAVE as u64;
    let middle = if size == 0 {
        0.0
    } else if size < least_normal {
        // Such a bin holds one number, which is the middle: half the distance to the next is rounded down.
        middle_of(size + OCTAVE as u64).next_down() / RAISE
    } else {
        let octaves = size - BELOW * OCTAVE as u64;
        let lower = f64::from_bits(octaves << IGNORED);
        if lower.is_finite() { middle_of(octaves) } else { lower }
    };
    if bin < 0 { -middle } else { middle }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples() -> Vec<f64> {
        let unit = |n: u64| (n.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11) as f64 / 2f64.powi(53);
        // Sizes from 1e-30 to 1e30 and both signs, many small integers, zeros.
        let wide = (1..5000).map(|n| (unit(n) - 0.5).signum() * 10f64.powf(60.0 * unit(7 * n) - 30.0));
        // The least number, its multiples, and others that are not normal.
        let subnormal = (1..300).flat_map(|n| {
            let least = f64::from_bits(n);
            [least, -least, 1e-310 * unit(n), least * 1e13, f64::MIN_POSITIVE * (0.5 + unit(n))]
        });
        wide.chain((0..2000).map(|n| f64::from(n % 13) - 6.0)).chain(subnormal).chain([0.0, -0.0]).collect()
    }

    /// Against the sorted samples, at every fifth rank: each is a pass over all bins.
    #[test]
    fn every_quantile_is_within_the_error_it_states() {
        let mut sorted = samples();
        let mut sketch = Quantiles::default();
        sorted.iter().for_each(|&x| sketch.push(x));
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len();
        for rank in (1..=n).step_by(5) {
            // In the middle between two ranks: no rounding decides.
            let (got, exact) = (sketch.at((rank as f64 - 0.5) / n as f64), sorted[rank - 1]);
            let allowed = Quantiles::RELATIVE_ERROR * exact.abs();
            assert!((got - exact).abs() <= allowed, "rank {rank}: {got}, exactly {exact}");
        }
        assert_eq!([sketch.at(0.0), sketch.at(1.0)], [sorted[0], sorted[n - 1]]);
        assert!(sketch.at(-0.1).is_nan() && sketch.at(f64::NAN).is_nan());
    }

    /// Every decimal fraction of a number of samples that it divides has the rank of that part.
    #[test]
    fn ranks_of_decimal_fractions_are_exact() {
        for (digits, n) in [(100_u32, 100_u64), (100, 300), (1000, 1000), (1000, 7000)] {
            for part in 0..=digits {
                let fraction: f64 = format!("{}e-{}", part, digits.ilog10()).parse().unwrap();
                assert_eq!(
                    rank(fraction, n),
                    u64::from(part) * n / u64::from(digits),
                    "{part}/{digits} of {n}"
                );
            }
        }
        let mut sketch = Quantiles::default();
        (1..=100).for_each(|i| sketch.push(f64::from(i)));
        assert_eq!(sketch.at(0.07), middle(bin(7.0)));
    }

    #[test]
    fn merging_in_any_order_is_the_same() {
        let all = samples();
        let mut whole = Quantiles::default();
        all.iter().for_each(|&x| whole.push(x));
        let mut parts: Vec<Quantiles> = all
            .chunks(97)
            .map(|chunk| {
                let mut part = Quantiles::default();
                chunk.iter().for_each(|&x| part.push(x));
                part
            })
            .collect();
        for _ in 0..2 {
            let mut merged = Quantiles::default();
            parts.iter().for_each(|part| merged.merge(part));
            assert_eq!(merged, whole);
            assert_eq!(merged.minimum().to_bits(), whole.minimum().to_bits());
            parts.reverse();
        }
    }

    /// Every number is in a bin whose middle is within the error of it, and bins are ordered.
    #[test]
    fn bins_are_narrow_and_ordered_at_every_size() {
        let sizes = (0..2047_u64)
            .flat_map(|e| [0, 1, 2, 3, (1 << 43) - 1, 1 << 43, (1 << 52) - 1].map(|m| (e << 52) + m));
        let octaves = (0..52).flat_map(|e| [(1 << e) - 1, 1 << e, (1 << e) + 1]);
        let mut all: Vec<u64> = sizes.chain(octaves).collect();
        all.sort_unstable();
        let mut last = -1;
        for x in all.into_iter().map(f64::from_bits) {
            let (number, middle) = (bin(x), middle(bin(x)));
            assert!(number >= last && (x == 0.0 || number > 0), "{x:e}");
            assert!((middle - x).abs() <= Quantiles::RELATIVE_ERROR * x, "{x:e} {middle:e}");
            assert_eq!((bin(-x), super::middle(bin(-x))), (if x == 0.0 { 0 } else { -1 - number }, -middle));
            last = number;
        }
        let mut sketch = Quantiles::default();
        [-1.0, 0.0, 0.0, 0.0, 1.0].into_iter().for_each(|x| sketch.push(x));
        assert_eq!(sketch.at(0.5).to_bits(), 0.0_f64.to_bits());
    }

    #[test]
    fn what_is_not_a_number_shows() {
        let mut sketch = Quantiles::default();
        assert!(sketch.at(0.5).is_nan() && sketch.minimum().is_nan());
        for x in [1.0, f64::INFINITY, 3.0, f64::NEG_INFINITY] {
            sketch.push(x);
        }
        assert_eq!(
            (sketch.at(0.0), sketch.at(0.5), sketch.at(1.0)),
            (f64::NEG_INFINITY, middle(bin(1.0)), f64::INFINITY)
        );
        sketch.push(f64::NAN);
        assert!(sketch.at(0.5).is_nan());
        assert_eq!((sketch.count(), sketch.undefined()), (4, 1));
    }
}
