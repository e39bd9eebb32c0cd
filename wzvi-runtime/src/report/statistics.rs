//! Estimators with their standard errors.
//!
//! Over n paths with values x_i: mean m and standard error `s / sqrt(n)`, `s^2 = Σ (x_i - m)^2 / (n - 1)`;
//! root mean square `r = sqrt(Σ x_i^2 / n)` with standard error `se(x^2) / (2 r)` (the delta method).
//!
//! Tested by `tests/paths/report/estimators.rs`.

use serde::{Deserialize, Serialize};

use crate::algebra::student::NORMAL;

/// A number and its standard error (zero for a single deterministic value).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

impl Estimate {
    /// Half the width of the 95 % confidence interval, by the normal law: paths are many.
    pub fn half_width(&self) -> f64 {
        NORMAL * self.standard_error
    }

    /// The mean of some values; NaN of none.
    pub fn mean(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let value = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|x| (x - value) * (x - value)).sum();
        let standard_error = if values.len() > 1 { (squares / (n - 1.0) / n).sqrt() } else { 0.0 };
        Self { value, standard_error }
    }

    /// The root mean square of some values; NaN of none.
    pub fn root_mean_square(values: &[f64]) -> Self {
        // Scaled, so that squares neither vanish nor overflow.
        let scale = values.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        if scale == 0.0 || !scale.is_finite() {
            return Self { value: if values.is_empty() { f64::NAN } else { scale }, standard_error: 0.0 };
        }
        let squares: Vec<f64> = values.iter().map(|x| (x / scale) * (x / scale)).collect();
        let mean = Self::mean(&squares);
        let value = mean.value.sqrt();
        Self { value: scale * value, standard_error: scale * mean.standard_error / (2.0 * value) }
    }
}

/// Median and spread of repeated timings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// The median.
    pub median: f64,
    /// First quartile.
    pub low: f64,
    /// Third quartile.
    pub high: f64,
}

impl Spread {
    /// Statistics of some values; NaN of none.
    pub fn of(values: &[f64]) -> Self {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |fraction: f64| {
            let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
            let place = fraction * last as f64;
            let (below, part) = (place.floor() as usize, place.fract());
            let low = sorted[below];
            low + part * (sorted[(below + 1).min(last)] - low)
        };
        Self { median: at(0.5), low: at(0.25), high: at(0.75) }
    }
}

/// A linear trend and the residual: `y = level + slope t + residual`, by least squares.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Trend {
    /// Slope, per unit of t.
    pub slope: f64,
    /// Root mean square of the residual.
    pub oscillation: f64,
}

impl Trend {
    /// The trend of points `(t, y)`; zero of fewer than two.
    pub fn of(points: &[(f64, f64)]) -> Self {
        let n = points.len() as f64;
        if points.len() < 2 {
            return Self::default();
        }
        let t = points.iter().map(|point| point.0).sum::<f64>() / n;
        let y = points.iter().map(|point| point.1).sum::<f64>() / n;
        let (mut tt, mut ty) = (0.0, 0.0);
        for point in points {
            tt += (point.0 - t) * (point.0 - t);
            ty += (point.0 - t) * (point.1 - y);
        }
        let slope = if tt > 0.0 { ty / tt } else { 0.0 };
        let residual = |point: &(f64, f64)| point.1 - y - slope * (point.0 - t);
        let squares: f64 = points.iter().map(|point| residual(point) * residual(point)).sum();
        Self { slope, oscillation: (squares / n).sqrt() }
    }
}
