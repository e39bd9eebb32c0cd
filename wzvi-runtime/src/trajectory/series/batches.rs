//! Batch means of every size at once.
//!
//! The mean of `b = 2^k` neighbours is a value of level `k`, and `V_k` is the variance of the values of that
//! level over their number. Once the batches are longer than correlations last, `V_k` is the variance of the
//! mean (H. Flyvbjerg, H. G. Petersen, "Error estimates on averages of correlated data", J. Chem. Phys. 91,
//! 1989); before, it is wrong by a part that falls with `1/b`, and `V_k / V_{k-1} = 1 + r` has the
//! correlation `r` of neighbouring batches of half that size.
//!
//! * The error uses the longest batches of which there are [`LEAST`], 8 to 15 of them at any length, and
//!   takes the part in `1/b` out: `V = V_k² / V_{k-1}`. For a correlation that decays as `e^{-t/τ}` this is
//!   right to 4 % from `b = 3 τ` on, where `V_k` misses a third; the sign does not matter, so that series
//!   which oscillate are not measured too long.
//! * So few batches are long: a slow part that is small beside a fast one shows in no shorter ones, and no
//!   test of the shorter ones finds it. More batches where `V_k` seems to have settled would be more exact,
//!   but `V_k` seems settled most often where it is too small by chance: coverage falls from 94 to 91 % for
//!   series of 20 correlation times of their slow part.
//! * Its degrees of freedom: with `a`, `d` the relative errors of the mean squares of sums and of differences
//!   of neighbours, which are independent and of variances `2/(n - 1)` and `2/n`, `V_{k-1}` is off by
//!   `(a + d)/2` and `V` by `(3a - d)/2`: a variance of `5/n`, as of `2n/5` degrees of freedom. Mean and
//!   error are then compared by Student's t.
//! * There is no error until the differences of neighbours grow by less than [`STEEPEST`] from batches of an
//!   eighth of the size to those of half of it. Differences of different sizes are independent of each other
//!   and of all sums, and the `d` of `V` lowers it: series that pass by chance have an error that is rather
//!   too large.

use crate::algebra::scalar::Scalar;
use crate::algebra::student;
use crate::algebra::welford::Welford;
use crate::ground::numbers::{Numbers, Tape, numbers};

/// So many batches, or up to twice as many, give a variance of 3 to 6 degrees of freedom, and intervals that
/// are 1.55 to 1.2 times as wide as those of many. Twice as many are half as long: they cover 84 to 91 % of
/// series of 20 correlation times, instead of 91 to 95 %.
const LEAST: u64 = 8;

/// The largest ratio of `b d²` with the mean square `d²` of differences of neighbouring batches of `b`
/// values, at half and at an eighth of the size. It is one for independent values and 16 where nothing has
/// been seen to decay; for `e^{-t/τ}` it is 7 at half a size of `1.7 τ`, in series of 27 to 55 `τ`. Its
/// logarithm has the deviation `√(2/8 + 2/32) = 0.56` at most, of which `ln 7` is 3.5.
const STEEPEST: f64 = 7.0;

/// The values of a level, and one that waits for its neighbour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct BatchLevel {
    values: Welford,
    waiting: Option<f64>,
}

impl BatchLevel {
    /// The variance of the mean, if values were independent.
    fn variance_of_mean(&self) -> f64 {
        let count = self.values.count() as f64;
        self.values.squares() / (count * (count - 1.0))
    }

    /// The mean square of the differences of neighbours over two, with the `pairs` that are their means: of
    /// the squares about the mean it is what these leave.
    fn half_differences(&self, pairs: &Self) -> f64 {
        let (count, means) = (self.values.count() as f64, &pairs.values);
        let alone =
            self.waiting.map_or(0.0, |value| Scalar::powi(value - means.mean(), 2) * (count - 1.0) / count);
        (self.values.squares() - alone - 2.0 * means.squares()) / means.count() as f64
    }
}

/// The mean of a series that comes value by value, with its error: 64 levels of memory for any length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BatchMeans {
    levels: Vec<BatchLevel>,
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
                self.levels.push(BatchLevel::default());
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

    /// The longest level of which there are this many batches, if differences show that correlations end
    /// within them.
    fn longest(&self, least: u64) -> Option<usize> {
        let longest = self.levels.iter().rposition(|level| level.values.count() >= least)?;
        let [eighth, quarter, half, long] = self.levels.get(longest.checked_sub(3)?..=longest)? else {
            return None;
        };
        let steepness = 4.0 * half.half_differences(long) / eighth.half_differences(quarter);
        // NaN of values that are all the same: what changes them has not been seen.
        (steepness <= STEEPEST).then_some(longest)
    }

    /// The variance of the mean by the batches of a level and of the one before, and its degrees of freedom.
    fn variance_by(&self, level: usize) -> (f64, f64) {
        let [half, long] = [level - 1, level].map(|level| &self.levels[level]);
        let (halves, whole) = (half.variance_of_mean(), long.variance_of_mean());
        (whole * (whole / halves), 0.4 * long.values.count() as f64)
    }

    /// The variance of the mean, and its degrees of freedom; NaN while correlations last too long for it to
    /// be known.
    fn error(&self) -> (f64, f64) {
        self.longest(LEAST).map_or((f64::NAN, f64::NAN), |longest| self.variance_by(longest))
    }

    /// The standard error of the mean, correlations included; NaN until it can be known: from 64 values on,
    /// and once the path has lasted for some 50 correlation times. An error of few degrees of freedom is
    /// uncertain itself: take [`BatchMeans::error_bound`] for intervals.
    pub fn standard_error(&self) -> f64 {
        self.error().0.sqrt()
    }

    /// The half width of the 95 % interval of Student's t, over 1.96: `mean ± 1.96 error_bound` covers the
    /// mean of a stationary series in 95 %, although the error itself is estimated, if the series lasts for
    /// 40 of its slowest correlation times. NaN until it can be known.
    ///
    /// **A slow part that is hidden below a fast one is not seen in short series**: where it contributes to
    /// the error of the mean and the series has 20 of its correlation times, the interval covers 91 to 95 %,
    /// of 10 some 85 to 90 %, of one less than 80 %. `cargo test --workspace --release --test laws
    /// series_errors` measures it.
    pub fn error_bound(&self) -> f64 {
        half_width(self.error())
    }

    /// Whether the error is this small, or smaller, by batches of two lengths. An error that ends a run when
    /// it is small ends it where it is too small by chance; that both are at the same time is rarer.
    pub(super) fn meets(&self, target: f64) -> bool {
        self.longest(LEAST).is_some_and(|longest| {
            [longest - 1, longest].into_iter().all(|level| half_width(self.variance_by(level)) <= target)
        })
    }

    /// The degrees of freedom of the standard error, as a sample variance has; NaN where there is none.
    pub fn degrees(&self) -> f64 {
        self.error().1
    }

    /// The integrated autocorrelation time in samples: 1/2 for independent values, less for alternating ones;
    /// NaN until it can be known.
    pub fn time(&self) -> f64 {
        0.5 * self.error().0 * self.count() as f64 / self.variance()
    }
}

/// The half width of the 95 % interval of Student's t, over 1.96.
fn half_width((variance, degrees): (f64, f64)) -> f64 {
    variance.sqrt() * student::quantile(degrees) / student::NORMAL
}

impl Numbers for BatchLevel {
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

numbers! { impl[] Numbers for BatchMeans { kept: levels } }

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
        let (series, length) = (64_u32, 1_u32 << 14);
        for a in [0.0, 0.5, 0.9, 0.97] {
            let (mut seed, mut mean_time) = (7, 0.0);
            let time = 0.5 + a / (1.0 - a);
            for _ in 0..series {
                let (mut batches, mut x) = (BatchMeans::new(), 0.0);
                for _ in 0..length {
                    x = a * x + f64::sqrt(3.0 * (1.0 - a * a)) * random(&mut seed);
                    batches.add(x);
                }
                mean_time += batches.time() / f64::from(series);
                assert!((batches.variance() - 1.0).abs() < 5.0 * (4.0 * time / f64::from(length)).sqrt());
                assert!(batches.error_bound() > batches.standard_error());
            }
            // Eight batches, 3.2 degrees of freedom: V to √(2/3.2) = 0.79. The mean of a square of a ratio is
            // (a - d)²/4, 0.13, above its square.
            let allowed = 3.0 * 0.79 / f64::from(series).sqrt();
            assert!((mean_time / time - 1.13).abs() < allowed, "{a} {} {time}", mean_time);
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
        let mut seed = 5;
        (0..63).for_each(|_| batches.add(random(&mut seed)));
        assert_eq!(batches.count(), 63);
        assert!(batches.standard_error().is_nan() && batches.error_bound().is_nan());
        batches.add(random(&mut seed));
        assert!(batches.error_bound() > 0.0);
    }
}
