//! Batch means of every size at once.
//!
//! The mean of `b = 2^k` neighbours is a value of level `k`, and `V_k` is the variance of the values of that level over their number. Once the batches
//! are longer than correlations last, `V_k` is the variance of the mean (H. Flyvbjerg, H. G. Petersen, "Error estimates on averages of correlated data",
//! J. Chem. Phys. 91, 1989); before, it is wrong by a part that falls with `1/b`, and `V_k / V_{k-1} = 1 + r` has the correlation `r` of neighbouring batches
//! of half that size.
//!
//! * The error uses the longest batches of which there are [`LEAST`], 32 to 63 of them at any length, and takes the part in `1/b` out:
//!   `V = V_k² / V_{k-1}`. For a correlation that decays as `e^{-t/τ}` this is right to 4 % from `b = 3 τ` on, where `V_k` misses a third; the sign does not
//!   matter, so that series which oscillate are not measured too long.
//! * Its degrees of freedom: with `a`, `d` the relative errors of the mean squares of sums and of differences of neighbours, which are independent and of variances
//!   `2/(n - 1)` and `2/n`, `V_{k-1}` is off by `(a + d)/2` and `V` by `(3a - d)/2`: a variance of `5/n`, as of `2n/5` degrees of freedom. Mean and error are then compared by
//!   Student's t.
//! * There is no error until neighbours among the batches of a quarter of the size, 128 or more, are correlated by less than [`MOST`], and until their differences
//!   grow by less than [`STEEPEST`] from batches of an eighth of the size to those of half of it. The first sees what changes more slowly than any batch. But it is small
//!   by chance where the sums that `V` comes from are: of series that are half as long as needed, 7 % would have an error, which covers 90 %. The second
//!   depends on differences alone. Those of different sizes are independent of each other and of all sums, and the `d` of `V` lowers it: series that pass
//!   by chance have an error that is rather too large. Both together cover 95 ± 2 % of the AR(1) and AR(2) series that have an error, where at least one in a hundred has one.
//!   Where fewer have, 91 % (`x_n = 0.5 x_{n-1} + 0.4 x_{n-2} + ξ_n`, 1024 values: six in a thousand).

use crate::algebra::student;
use crate::algebra::welford::Welford;
use crate::ground::numbers::{Numbers, Tape};

/// So many batches give a variance to a quarter, and Student's t of 13 degrees of freedom, a tenth above that of many.
const LEAST: u64 = 32;

/// The largest correlation of neighbouring batches of a quarter of the size. It is estimated as `(V_{k-1} / V_{k-2}) - 1` from `m >= 128` batches, to
/// `√(2/m) = 0.125` for independent ones: 0.55 is 4.4 of these deviations. For `e^{-t/τ}` it is the correlation of batches of `τ`, and the longest batches then
/// have `4 τ`.
const MOST: f64 = 0.55;

/// The largest ratio of `b d²` with the mean square `d²` of differences of neighbouring batches of `b` values, at half and at an eighth of the size. It is one for
/// independent values and 16 where nothing has been seen to decay; for `e^{-t/τ}` it is 5.1 at an eighth of `0.7 τ`, and the longest batches then have `5.6 τ`. Its
/// logarithm has the deviation `√(2/32 + 2/128) = 0.28`, of which `ln 5` is 5.8.
const STEEPEST: f64 = 5.0;

/// The values of a level, and one that waits for its neighbour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Level {
    values: Welford,
    waiting: Option<f64>,
}

impl Level {
    /// The variance of the mean, if values were independent.
    fn variance_of_mean(&self) -> f64 {
        let count = self.values.count() as f64;
        self.values.squares() / (count * (count - 1.0))
    }

    /// The mean square of the differences of neighbours over two, with the `pairs` that are their means: of the squares about the mean it is what these leave.
    fn half_differences(&self, pairs: &Self) -> f64 {
        let (count, means) = (self.values.count() as f64, &pairs.values);
        let alone = self.waiting.map_or(0.0, |value| (value - means.mean()).powi(2) * (count - 1.0) / count);
        (self.values.squares() - alone - 2.0 * means.squares()) / means.count() as f64
    }
}

/// The mean of a series that comes value by value, with its error: 64 levels of memory for any length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BatchMeans {
    levels: Vec<Level>,
}

impl BatchMeans {
    /// Without values.
    pub fn new() -> Self {
        Self::default()
    }

    /// One more value; about two additions on average.
    pub fn add(&mut self, value: f64) {
        let mut value = value;
        for level in 0.. {
            if self.levels.len() == level {
                self.levels.push(Level::default());
            }
            let level = &mut self.levels[level];
            level.values.push(value);
            match level.waiting.take() {
                None => {
                    level.waiting = Some(value);
                    return;
                }
                Some(other) => value = 0.5 * (other + value),
            }
        }
    }

    /// Values so far.
    pub fn count(&self) -> u64 {
        self.levels.first().map_or(0, |level| level.values.count())
    }

    /// The mean; NaN without values.
    pub fn mean(&self) -> f64 {
        self.levels.first().map_or(f64::NAN, |level| level.values.mean())
    }

    /// The variance; NaN for fewer than two values.
    pub fn variance(&self) -> f64 {
        self.levels.first().map_or(f64::NAN, |level| level.values.variance())
    }

    /// The variance of the mean, and its degrees of freedom; NaN while correlations last too long for it to be known.
    fn error(&self) -> (f64, f64) {
        let longest = self.levels.iter().rposition(|level| level.values.count() >= LEAST);
        let known = longest.and_then(|longest| self.levels.get(longest.checked_sub(3)?..=longest));
        let Some([eighth, quarter, half, long]) = known else { return (f64::NAN, f64::NAN) };
        let [quarters, halves, whole] = [quarter, half, long].map(Level::variance_of_mean);
        let steepness = 4.0 * half.half_differences(long) / eighth.half_differences(quarter);
        // NaN of values that are all the same: what changes them has not been seen.
        let is_known = (halves / quarters - 1.0).abs() <= MOST && steepness <= STEEPEST;
        if is_known {
            (whole * (whole / halves), 0.4 * long.values.count() as f64)
        } else {
            (f64::NAN, f64::NAN)
        }
    }

    /// The standard error of the mean, correlations included; NaN until it can be known: from 256 values on, and once the path has lasted for some 200
    /// correlation times. An error of few degrees of freedom is uncertain itself: the interval `mean ± 1.96 standard_error` covers 93 %, that with
    /// [`BatchMeans::error_bound`] 95 %.
    pub fn standard_error(&self) -> f64 {
        self.error().0.sqrt()
    }

    /// The half width of the 95 % interval of Student's t, over 1.96: `mean ± 1.96 error_bound` covers the mean of a stationary series in 95 %,
    /// although the error itself is estimated. NaN until it can be known.
    pub fn error_bound(&self) -> f64 {
        let (variance, degrees) = self.error();
        variance.sqrt() * student::quantile(degrees) / student::NORMAL
    }

    /// The degrees of freedom of the standard error, as a sample variance has; NaN where there is none.
    pub fn degrees(&self) -> f64 {
        self.error().1
    }

    /// The integrated autocorrelation time in samples: 1/2 for independent values, less for alternating ones; NaN until it can be known.
    pub fn time(&self) -> f64 {
        0.5 * self.error().0 * self.count() as f64 / self.variance()
    }
}

impl Numbers for Level {
    fn pass(&mut self, tape: &mut Tape) {
        let Self { values, waiting } = self;
        values.pass(tape);
        let mut waits = waiting.is_some();
        waits.pass(tape);
        let mut value = waiting.unwrap_or_default();
        value.pass(tape);
        *waiting = waits.then_some(value);
    }
}

impl Numbers for BatchMeans {
    fn pass(&mut self, tape: &mut Tape) {
        self.levels.pass(tape);
    }
}

#[cfg(test)]
mod tests {
    use super::BatchMeans;

    /// Numbers in `(-1, 1)` that repeat after 2^64.
    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    #[test]
    fn the_error_of_a_correlated_series_is_that_of_theory() {
        // x' = a x + √(1 - a²) ξ has ρ = aᵗ, τ = 1/2 + a / (1 - a).
        for a in [0.0, 0.5, 0.9, 0.98] {
            let (mut batches, mut x, mut seed) = (BatchMeans::new(), 0.0, 7);
            for _ in 0..1 << 20 {
                x = a * x + f64::sqrt(3.0 * (1.0 - a * a)) * random(&mut seed);
                batches.add(x);
            }
            let time = 0.5 + a / (1.0 - a);
            // 32 batches, 13 degrees of freedom: V to √(2/13) = 0.39.
            assert!((batches.time() / time - 1.0).abs() < 3.0 * 0.39, "{a} {} {time}", batches.time());
            assert!(batches.mean().abs() < 4.0 * batches.standard_error(), "{a} {}", batches.mean());
            assert!((batches.variance() - 1.0).abs() < 4.0 * (4.0 * time / f64::from(1 << 20)).sqrt());
            assert!(batches.error_bound() >= batches.standard_error());
        }
    }

    #[test]
    fn differences_are_those_of_neighbours() {
        let (mut batches, mut seed) = (BatchMeans::new(), 3);
        let values: Vec<f64> = (0..301).map(|_| 5.0 + random(&mut seed)).collect();
        values.iter().for_each(|&value| batches.add(value));
        for level in 0..5 {
            let size = 1 << level;
            let means: Vec<f64> =
                values.chunks_exact(size).map(|batch| batch.iter().sum::<f64>() / size as f64).collect();
            let squares = means.chunks_exact(2).map(|pair| 0.5 * (pair[0] - pair[1]).powi(2));
            let expected = squares.sum::<f64>() / (means.len() / 2) as f64;
            assert!(
                (batches.levels[level].half_differences(&batches.levels[level + 1]) / expected - 1.0).abs()
                    < 1e-12,
                "{size}"
            );
        }
    }

    #[test]
    fn few_values_have_no_error() {
        let mut batches = BatchMeans::new();
        assert!(batches.mean().is_nan());
        (0..255).for_each(|i| batches.add(f64::from(i % 2)));
        assert_eq!((batches.count(), batches.mean()), (255, 127.0 / 255.0));
        assert!(batches.standard_error().is_nan() && batches.error_bound().is_nan());
    }
}
