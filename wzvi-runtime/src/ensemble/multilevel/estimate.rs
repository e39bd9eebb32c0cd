//! The results of a multilevel run.

use std::fmt;

use crate::algebra::scalar::Scalar;
use crate::ground::digits::estimate;
use crate::saving::FileError;
use crate::statistics::StatisticsNode;

/// Observables of a level: at the end of the fine path, and its difference from that of the coarse one.
pub(super) const FINE: usize = 0;
const DIFFERENCE: usize = 1;

/// Upper estimates of the variances of the differences, level by level. Where all differences of a level are
/// equal, one that has not been seen may be as large as values differ on any level.
pub(super) fn variance_bounds(levels: &[&StatisticsNode]) -> Vec<f64> {
    let width = levels.iter().map(|end| end.width(FINE)).fold(0.0, f64::max);
    let bound = |end: &&StatisticsNode| {
        let unseen = if end.is_constant(DIFFERENCE) { width } else { 0.0 };
        end.variance_bound(DIFFERENCE, unseen)
    };
    levels.iter().map(bound).collect()
}

/// The remaining bias, estimated from the last three differences: a remainder of `m / (2^α - 1)` after a
/// difference `m`, if they fall like `2^{-α l}`; the largest of the three, since each may be small by chance.
/// Infinite without differences.
pub(super) fn bias(levels: &[&StatisticsNode], order: f64) -> f64 {
    let differences = levels.iter().skip(1).rev().take(3).zip(0..);
    let remainders =
        differences.map(|(end, ago)| end.mean(DIFFERENCE).abs() / Scalar::exp2(order * f64::from(ago)));
    match remainders.reduce(f64::max) {
        Some(largest) => largest / (Scalar::exp2(order) - 1.0),
        None => f64::INFINITY,
    }
}

/// `β` of the fit `V_l ~ 2^{-β l}` by least squares over the levels from 1 on; `None` for fewer than two that
/// have a variance.
pub(super) fn variance_slope(levels: &[&StatisticsNode]) -> Option<f64> {
    slope(levels.iter().map(|end| end.variance(DIFFERENCE)))
}

/// Minus the slope of binary logarithms against the level, from level 1 on.
fn slope(values: impl Iterator<Item = f64>) -> Option<f64> {
    let points: Vec<(f64, f64)> = (0..)
        .map(f64::from)
        .zip(values)
        .skip(1)
        .filter(|(_, value)| value.is_finite() && *value > 0.0)
        .map(|(level, value)| (level, Scalar::log2(value)))
        .collect();
    let n = points.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let square: f64 = points.iter().map(|point| Scalar::powi(point.0 - x, 2)).sum();
    let product: f64 = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    (points.len() > 1).then(|| -product / square)
}

/// One level of a multilevel run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    h: f64,
    paths: u64,
    steps: u64,
    /// Mean and variance of the difference.
    difference: [f64; 2],
    /// Mean and variance of the observable.
    fine: [f64; 2],
}

impl Level {
    /// The step size of its fine paths; their coarse partners have twice this.
    pub fn h(&self) -> f64 {
        self.h
    }

    /// Number of Brownian paths.
    pub fn paths(&self) -> u64 {
        self.paths
    }

    /// Steps of a pair, fine and coarse together: its cost.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Steps of all pairs.
    pub fn cost(&self) -> u64 {
        self.steps.saturating_mul(self.paths())
    }

    /// The mean of the difference `P_l - P_{l-1}`; on level 0 that of the observable.
    pub fn mean(&self) -> f64 {
        self.difference[0]
    }

    /// The variance of this difference.
    pub fn variance(&self) -> f64 {
        self.difference[1]
    }

    /// The mean of the observable `P_l` itself.
    pub fn fine_mean(&self) -> f64 {
        self.fine[0]
    }

    /// The variance of the observable itself: what paths of this step size alone would have to average.
    pub fn fine_variance(&self) -> f64 {
        self.fine[1]
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
    pub(super) unsaved: Option<FileError>,
}

impl MultilevelEstimate {
    /// From the step size of each level, the steps of its paths and what is known of their ends.
    pub(super) fn new<'s>(
        levels: impl Iterator<Item = (f64, u64, &'s StatisticsNode)>,
        order: f64,
        is_partial: bool,
        is_constant: bool,
        met: impl Fn(f64, f64) -> bool,
    ) -> Self {
        let (levels, ends): (Vec<Level>, Vec<_>) = levels
            .map(|(h, steps, end)| {
                let [difference, fine] = [DIFFERENCE, FINE].map(|of| [end.mean(of), end.variance(of)]);
                (Level { h, paths: end.count(), steps, difference, fine }, end)
            })
            .unzip();
        let bias = bias(&ends, order);
        let squares =
            variance_bounds(&ends).into_iter().zip(&levels).map(|(bound, level)| bound / level.paths as f64);
        let error_bound = squares.sum::<f64>().sqrt();
        let met_target = met(error_bound, bias);
        Self { levels, bias, error_bound, is_partial, is_constant, met_target, unsaved: None }
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

    /// An upper estimate of the standard error, which allows for events too rare to have been seen on enough
    /// paths, as [`StatisticsNode::error_bound`](super::super::StatisticsNode::error_bound) does. Where all
    /// differences of a level are equal, it allows for one as large as the range of the observable. The
    /// target is compared with this.
    pub fn error_bound(&self) -> f64 {
        if self.levels.is_empty() { f64::NAN } else { self.error_bound }
    }

    /// Whether the observable is the same number on all paths: then nothing is known of its error, and the
    /// target is not met.
    pub fn is_constant(&self) -> bool {
        self.is_constant
    }

    /// The estimated distance of the mean at the finest step size from its limit, from the last three levels
    /// and the weak order.
    pub fn bias(&self) -> f64 {
        self.bias
    }

    /// The expected root mean square error, `√(standard_error² + bias²)`.
    pub fn error(&self) -> f64 {
        Scalar::hypot(self.standard_error(), self.bias)
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
        steps * finest.fine_variance() / Scalar::powi(self.standard_error(), 2)
    }

    /// `β`, if the variances fall like `h^β`: twice the strong order, for a smooth observable. By least
    /// squares over the levels from 1 on; `None` for fewer than two that have a variance.
    pub fn variance_slope(&self) -> Option<f64> {
        slope(self.levels.iter().map(Level::variance))
    }

    /// The exponent of the means of the differences: the weak order, where they are larger than their errors.
    pub fn mean_slope(&self) -> Option<f64> {
        slope(self.levels.iter().map(|level| level.mean().abs()))
    }

    /// Whether the run was stopped, by Ctrl-C or [`Ensemble::stop_when`](super::super::Ensemble::stop_when),
    /// before it was done.
    pub fn is_partial(&self) -> bool {
        self.is_partial
    }

    /// Why the last checkpoint could not be written, if it could not: see [`crate::trajectory::checkpoint`].
    pub fn unsaved(&self) -> Option<&FileError> {
        self.unsaved.as_ref()
    }

    /// Whether standard error and bias meet the target; if not, the limit on paths or levels was reached
    /// first.
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
