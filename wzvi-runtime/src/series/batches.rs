//! Batch means of every size at once.
//!
//! The mean of `2^k` neighbours is a value of level `k`. From the level on whose values are independent, the variance of these over their number
//! is that of the mean (H. Flyvbjerg, H. G. Petersen, "Error estimates on averages of correlated data", J. Chem. Phys. 91, 1989); below, it is too small where
//! correlations are positive. The error is therefore the largest of all levels that have [`LEAST`] values.

/// Values of a level that say something of their variance: to a tenth.
const LEAST: u64 = 64;

/// Mean and spread of the values of a level (B. P. Welford), and one that waits for its neighbour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Level {
    count: u64,
    mean: f64,
    /// The sum of the squares of the deviations.
    squares: f64,
    waiting: Option<f64>,
}

impl Level {
    fn add(&mut self, value: f64) {
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (value - self.mean);
    }

    /// The variance of the mean, if values were independent.
    fn variance_of_mean(&self) -> f64 {
        let count = self.count as f64;
        self.squares / (count * (count - 1.0))
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
            level.add(value);
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
        self.levels.first().map_or(0, |level| level.count)
    }

    /// Their mean; NaN of none.
    pub fn mean(&self) -> f64 {
        self.levels.first().map_or(f64::NAN, |level| level.mean)
    }

    /// Their variance; NaN of fewer than two.
    pub fn variance(&self) -> f64 {
        self.levels
            .first()
            .filter(|level| level.count > 1)
            .map_or(f64::NAN, |level| level.squares / (level.count - 1) as f64)
    }

    /// The standard error of the mean; infinite while there are fewer than 64 values.
    pub fn standard_error(&self) -> f64 {
        let levels = self.levels.iter().filter(|level| level.count >= LEAST);
        let largest = levels.map(Level::variance_of_mean).fold(f64::NAN, f64::max);
        if largest.is_nan() { f64::INFINITY } else { largest.sqrt() }
    }

    /// An upper estimate of the standard error: with the one of which the error is estimated to be too small by chance once in forty, and only once batches
    /// of many times the correlation time are there; infinite before.
    pub fn error_bound(&self) -> f64 {
        let error = self.standard_error();
        // The longest batches that count are at least 10 correlation times, and their variance is uncertain by √(2 / count).
        let longest = self.levels.iter().rposition(|level| level.count >= LEAST);
        match longest {
            Some(level) if (1_u64 << level.min(63)) as f64 >= 10.0 * self.time() => {
                let uncertain = (2.0 / (self.levels[level].count - 1) as f64).sqrt();
                error * (1.0 + 1.96 * 0.5 * uncertain)
            }
            _ => f64::INFINITY,
        }
    }

    /// The integrated autocorrelation time in samples; 1/2 of independent values, NaN while there are too few.
    pub fn time(&self) -> f64 {
        let (error, variance) = (self.standard_error(), self.variance());
        if error.is_finite() { 0.5 * error * error * self.count() as f64 / variance } else { f64::NAN }
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
            // The largest of several levels, with some 64 values in the last, is above by up to a third.
            assert!((0.9..1.6).contains(&(batches.time() / time)), "{a} {} {time}", batches.time());
            assert!(batches.mean().abs() < 4.0 * batches.standard_error(), "{a} {}", batches.mean());
            assert!((batches.variance() - 1.0).abs() < 4.0 * (4.0 * time / f64::from(1 << 20)).sqrt());
            assert!(batches.error_bound() >= batches.standard_error());
        }
    }

    #[test]
    fn few_values_have_no_error() {
        let mut batches = BatchMeans::new();
        assert!(batches.mean().is_nan());
        (0..63).for_each(|i| batches.add(f64::from(i)));
        assert_eq!((batches.count(), batches.mean(), batches.standard_error()), (63, 31.0, f64::INFINITY));
    }
}
