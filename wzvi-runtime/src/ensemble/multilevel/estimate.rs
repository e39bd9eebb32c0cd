//! What a multilevel run found out.

use std::fmt;

use crate::ground::digits::estimate;
use crate::statistics::Welford;

/// The observable on one level: at the end of the fine path, and its difference from that of the coarse one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Samples {
    fine: Welford,
    difference: Welford,
}

impl Samples {
    pub(super) fn push(&mut self, fine: f64, difference: f64) {
        self.fine.push(fine);
        self.difference.push(difference);
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.fine.merge(&other.fine);
        self.difference.merge(&other.difference);
    }

    pub(super) fn count(&self) -> u64 {
        self.difference.count()
    }

    /// Whether the observable is the same number on all paths.
    pub(super) fn is_constant(&self) -> bool {
        self.fine.is_constant()
    }
}

/// Upper estimates of the variances of the differences, level by level. Where all differences of a level are equal, one that has not been
/// seen may be as large as values differ on any level.
pub(super) fn variance_bounds(samples: &[Samples]) -> Vec<f64> {
    let width = samples.iter().map(|samples| samples.fine.width()).fold(0.0, f64::max);
    let bound = |samples: &Samples| {
        let unseen = if samples.difference.is_constant() { width } else { 0.0 };
        samples.difference.variance_bound(unseen)
    };
    samples.iter().map(bound).collect()
}

/// The bias that is left, as far as the last three differences show: a remainder of `m / (2^α - 1)` after a difference `m`,
/// if they fall like `2^{-α l}`; the largest of the three, since each may be small by chance. Infinite without differences.
pub(super) fn bias(samples: &[Samples], order: f64) -> f64 {
    let differences = samples.iter().skip(1).rev().take(3).zip(0..);
    let remainders =
        differences.map(|(samples, ago)| samples.difference.mean().abs() / 2f64.powf(order * f64::from(ago)));
    match remainders.reduce(f64::max) {
        Some(largest) => largest / (2f64.powf(order) - 1.0),
        None => f64::INFINITY,
    }
}

/// `β` of the fit `V_l ~ 2^{-β l}` by least squares over the levels from 1 on; `None` for fewer than two that have a variance.
pub(super) fn variance_slope(samples: &[Samples]) -> Option<f64> {
    slope(samples.iter().map(|samples| samples.difference.variance()))
}

/// Minus the slope of binary logarithms against the level, from level 1 on.
fn slope(values: impl Iterator<Item = f64>) -> Option<f64> {
    let points: Vec<(f64, f64)> = (0..)
        .map(f64::from)
        .zip(values)
        .skip(1)
        .filter(|(_, value)| value.is_finite() && *value > 0.0)
        .map(|(level, value)| (level, value.log2()))
        .collect();
    let n = points.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let square: f64 = points.iter().map(|point| (point.0 - x).powi(2)).sum();
    let product: f64 = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    (points.len() > 1).then(|| -product / square)
}

/// One level of a multilevel run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    h: f64,
    steps: u64,
    samples: Samples,
}

impl Level {
    pub(super) fn new(h: f64, steps: u64, samples: Samples) -> Self {
        Self { h, steps, samples }
    }

    /// The step size of its fine paths; that of the coarse ones beside them is twice this.
    pub fn h(&self) -> f64 {
        self.h
    }

    /// Number of Brownian paths.
    pub fn paths(&self) -> u64 {
        self.samples.count()
    }

    /// Steps that each of them takes, fine and coarse together: its cost.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Steps of all of them.
    pub fn cost(&self) -> u64 {
        self.steps.saturating_mul(self.paths())
    }

    /// The mean of the difference `P_l - P_{l-1}`; on level 0 that of the observable.
    pub fn mean(&self) -> f64 {
        self.samples.difference.mean()
    }

    /// The variance of this difference.
    pub fn variance(&self) -> f64 {
        self.samples.difference.variance()
    }

    /// The mean of the observable `P_l` itself.
    pub fn fine_mean(&self) -> f64 {
        self.samples.fine.mean()
    }

    /// The variance of the observable itself: what paths of this step size alone would have to average.
    pub fn fine_variance(&self) -> f64 {
        self.samples.fine.variance()
    }
}

/// The mean of an observable, from paths of several step sizes.
#[derive(Clone, Debug, PartialEq)]
pub struct MultilevelEstimate {
    levels: Vec<Level>,
    bias: f64,
    /// Upper estimate of the standard error.
    error_bound: f64,
    is_partial: bool,
    is_constant: bool,
    met_target: bool,
}

impl MultilevelEstimate {
    pub(super) fn new(
        levels: Vec<Level>,
        order: f64,
        is_partial: bool,
        is_constant: bool,
        met: impl Fn(f64, f64) -> bool,
    ) -> Self {
        let samples: Vec<Samples> = levels.iter().map(|level| level.samples).collect();
        let bias = bias(&samples, order);
        let bounds = variance_bounds(&samples);
        let squares = bounds.iter().zip(&samples).map(|(bound, samples)| bound / samples.count() as f64);
        let error_bound = squares.sum::<f64>().sqrt();
        let met_target = met(error_bound, bias);
        Self { levels, bias, error_bound, is_partial, is_constant, met_target }
    }

    /// The mean: the sum of those of all levels; NaN if there is none.
    pub fn mean(&self) -> f64 {
        if self.levels.is_empty() { f64::NAN } else { self.levels.iter().map(Level::mean).sum() }
    }

    /// Its standard error, `√(Σ V_l / N_l)`.
    pub fn standard_error(&self) -> f64 {
        let square = |level: &Level| level.variance() / level.paths() as f64;
        if self.levels.is_empty() { f64::NAN } else { self.levels.iter().map(square).sum::<f64>().sqrt() }
    }

    /// An upper estimate of it, which allows for what may be too rare to have been seen on enough paths: as
    /// [`StatisticsNode::error_bound`](super::super::StatisticsNode::error_bound), and where all differences of a level are equal, for one as large as the range of the
    /// observable. This one is what the target is compared with.
    pub fn error_bound(&self) -> f64 {
        if self.levels.is_empty() { f64::NAN } else { self.error_bound }
    }

    /// Whether the observable is the same number on all paths: then nothing is known of its error, and the target is not met.
    pub fn is_constant(&self) -> bool {
        self.is_constant
    }

    /// About how far the mean of the finest step size is from its limit, in absolute value, from the last three levels and the
    /// weak order.
    pub fn bias(&self) -> f64 {
        self.bias
    }

    /// The root mean square error that is to be expected, `√(standard_error² + bias²)`.
    pub fn error(&self) -> f64 {
        self.standard_error().hypot(self.bias)
    }

    /// The levels, the coarsest first.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// Steps of all paths.
    pub fn cost(&self) -> u64 {
        self.levels.iter().fold(0, |sum, level| sum.saturating_add(level.cost()))
    }

    /// Steps that paths of the finest step size alone would have taken for the same standard error.
    pub fn plain_cost(&self) -> f64 {
        let Some(finest) = self.levels.last() else { return f64::NAN };
        let steps = if self.levels.len() == 1 { finest.steps as f64 } else { finest.steps as f64 / 1.5 };
        steps * finest.fine_variance() / self.standard_error().powi(2)
    }

    /// `β`, if the variances fall like `h^β`: twice the strong order, for a smooth observable. By least squares over the levels from
    /// 1 on; `None` for fewer than two that have a variance.
    pub fn variance_slope(&self) -> Option<f64> {
        slope(self.levels.iter().map(Level::variance))
    }

    /// The same for the means of the differences: the weak order, where they are larger than their errors.
    pub fn mean_slope(&self) -> Option<f64> {
        slope(self.levels.iter().map(|level| level.mean().abs()))
    }

    /// Whether the run was stopped, by Ctrl-C or [`Ensemble::stop_when`](super::super::Ensemble::stop_when), before it was done.
    pub fn is_partial(&self) -> bool {
        self.is_partial
    }

    /// Whether standard error and bias are what the target asked for; if not, the limit on paths or levels was reached first.
    pub fn met_target(&self) -> bool {
        self.met_target
    }
}

/// A table of the levels, and the result below it.
impl fmt::Display for MultilevelEstimate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "level           h       paths  steps/path        mean    variance       cost")?;
        for (number, level) in self.levels.iter().enumerate() {
            writeln!(
                f,
                "{number:5}  {:10.3e}  {:10}  {:10}  {:10.3e}  {:10.3e}  {:9.2e}",
                level.h(),
                level.paths(),
                level.steps(),
                level.mean(),
                level.variance(),
                level.cost() as f64
            )?;
        }
        write!(f, "mean {}, bias {:.1e} or less", estimate(self.mean(), self.standard_error()), self.bias())?;
        if self.is_partial {
            write!(f, " (partial)")?;
        } else if self.is_constant {
            write!(f, " (the same on all paths)")?;
        } else if !self.met_target {
            write!(f, " (target not met)")?;
        }
        Ok(())
    }
}
