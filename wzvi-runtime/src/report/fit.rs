//! The slope of error against step size, on the part of the curve that has one.
//!
//! With error `e_k ± s_k` at step size h_k, the line `ln e = ln c + slope ln h` is fitted by least squares
//! with the weights `1 / σ_k^2`, `σ_k^2 = (s_k / e_k)^2 + MODEL^2`; MODEL is how far from a straight line an
//! honest power law may be. The longest run of consecutive step sizes is taken that
//!
//! * has at least [`LEAST`] points and is straight: `χ^2 / (n - 2) <= STRAIGHT`, no residual beyond `3 σ`,
//!   and the slopes of its two halves differ by no more than `BEND` and the standard error of that
//!   difference,
//! * falls: slope at least [`FLAT`].
//!
//! Among runs of the same length the one with the smallest steps wins. Points to its left (larger steps) are
//! pre-asymptotic, points to its right the plateau: an error that smaller steps do not lower, be it rounding,
//! the reference or a wrong limit.
//!
//! Tested by `tests/paths/report/fit.rs`.

use serde::{Deserialize, Serialize};

/// Fewest points that make a slope.
pub const LEAST: usize = 3;
/// Below this, error does not depend on step size.
pub const FLAT: f64 = 0.2;
/// Relative deviation from a power law that is tolerated.
const MODEL: f64 = 0.04;
/// Largest `χ^2` per degree of freedom of a straight part.
const STRAIGHT: f64 = 2.5;
/// Largest difference between the slopes of both halves of a straight part.
const BEND: f64 = 0.1;

/// One measured error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Step size.
    pub h: f64,
    /// Error.
    pub error: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// The result of the fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Slope {
    /// A straight part: `error ≈ factor h^order`.
    Order {
        /// The slope.
        order: f64,
        /// Its standard error.
        standard_error: f64,
        /// The factor.
        factor: f64,
        /// Step sizes used, the largest first.
        used: Vec<f64>,
        /// Larger step sizes, left out: not yet straight.
        pre_asymptotic: Vec<f64>,
        /// Smaller step sizes, left out: the error does not follow.
        plateau: Vec<f64>,
    },
    /// The error does not depend on the step size.
    Flat {
        /// The error at the smallest step.
        error: f64,
        /// The step sizes, the largest first.
        used: Vec<f64>,
    },
    /// Fewer than [`LEAST`] usable points.
    TooFew {
        /// How many there were.
        points: usize,
    },
    /// Enough points, but no three in a row lie on a falling straight line.
    Crooked {
        /// How many there were.
        points: usize,
    },
}

struct Line {
    order: f64,
    standard_error: f64,
    intercept: f64,
    straight: bool,
}

/// Fits the slope; samples in any order, unusable ones (not finite, not positive) are dropped.
pub fn fit(samples: &[Sample]) -> Slope {
    let usable = |sample: &&Sample| {
        [sample.h, sample.error].iter().all(|x| x.is_finite() && *x > 0.0)
            && sample.standard_error.is_finite()
    };
    let mut samples: Vec<Sample> = samples.iter().filter(usable).copied().collect();
    samples.sort_by(|a, b| b.h.total_cmp(&a.h));
    let n = samples.len();
    if n < LEAST {
        return Slope::TooFew { points: n };
    }
    let steps = |samples: &[Sample]| samples.iter().map(|sample| sample.h).collect::<Vec<_>>();
    let mut flat = None;
    for length in (LEAST..=n).rev() {
        // The smallest steps first.
        for begin in (0..=n - length).rev() {
            let Some(line) = line(&samples[begin..begin + length]) else { continue };
            if !line.straight || bent(&samples[begin..begin + length]) {
                continue;
            }
            if line.order >= FLAT {
                return Slope::Order {
                    order: line.order,
                    standard_error: line.standard_error,
                    factor: line.intercept.exp(),
                    used: steps(&samples[begin..begin + length]),
                    pre_asymptotic: steps(&samples[..begin]),
                    plateau: steps(&samples[begin + length..]),
                };
            }
            // The whole curve, or its end: no matter what larger steps do, this is where it leads.
            if line.order.abs() < FLAT && begin + length == n && 2 * length > n {
                let found = Slope::Flat { error: samples[n - 1].error, used: steps(&samples[begin..]) };
                flat.get_or_insert(found);
            }
        }
        if flat.is_some() {
            break;
        }
    }
    flat.unwrap_or(Slope::Crooked { points: n })
}

/// Whether the two halves have different slopes: a bend that is too smooth for residuals to show.
fn bent(samples: &[Sample]) -> bool {
    let half = samples.len().div_ceil(2);
    let halves = (samples.get(..half), samples.get(samples.len() - half..));
    let (Some(first), Some(second)) = halves else { return false };
    if half == samples.len() || samples.len() == LEAST {
        return false;
    }
    let (Some(a), Some(b)) = (line(first), line(second)) else { return false };
    let chance = |samples: &[Sample]| {
        let (Some(one), Some(two)) = (samples.first(), samples.last()) else { return 0.0 };
        let relative = |sample: &Sample| sample.standard_error / sample.error;
        relative(one).hypot(relative(two)) / (one.h / two.h).ln()
    };
    (a.order - b.order).abs() > BEND + chance(first).hypot(chance(second))
}

fn line(samples: &[Sample]) -> Option<Line> {
    let (mut w0, mut wx, mut wy) = (0.0, 0.0, 0.0);
    let point = |sample: &Sample| {
        let relative = sample.standard_error / sample.error;
        (sample.h.ln(), sample.error.ln(), 1.0 / (relative * relative + MODEL * MODEL))
    };
    for (x, y, w) in samples.iter().map(point) {
        w0 += w;
        wx += w * x;
        wy += w * y;
    }
    let (x0, y0) = (wx / w0, wy / w0);
    let (mut xx, mut xy) = (0.0, 0.0);
    for (x, y, w) in samples.iter().map(point) {
        xx += w * (x - x0) * (x - x0);
        xy += w * (x - x0) * (y - y0);
    }
    if xx <= 0.0 || xx.is_nan() {
        return None;
    }
    let order = xy / xx;
    let residuals = samples.iter().map(point).map(|(x, y, w)| (y - y0 - order * (x - x0)) * w.sqrt());
    let (mut chi, mut largest) = (0.0, 0.0_f64);
    for residual in residuals {
        chi += residual * residual;
        largest = largest.max(residual.abs());
    }
    let freedom = samples.len().saturating_sub(2).max(1) as f64;
    Some(Line {
        order,
        standard_error: (1.0 / xx).sqrt(),
        intercept: y0 - order * x0,
        straight: chi / freedom <= STRAIGHT && largest <= 3.0,
    })
}

impl Slope {
    /// The order and its standard error, where there is one.
    pub fn order(&self) -> Option<(f64, f64)> {
        match self {
            Self::Order { order, standard_error, .. } => Some((*order, *standard_error)),
            _ => None,
        }
    }

    /// In words: the slope, the points that it used and those left out.
    pub fn words(&self) -> String {
        match self {
            Self::Order { order, standard_error, used, pre_asymptotic, plateau, .. } => {
                let mut words = format!(
                    "order {order:.2} ± {standard_error:.2} from {} points, h = {} to {}",
                    used.len(),
                    super::number(used.first().copied().unwrap_or(f64::NAN)),
                    super::number(used.last().copied().unwrap_or(f64::NAN)),
                );
                for (left_out, why) in [(pre_asymptotic, "pre-asymptotic"), (plateau, "plateau")] {
                    if !left_out.is_empty() {
                        let list: Vec<String> = left_out.iter().map(|h| super::number(*h)).collect();
                        words += &format!("; left out as {why}: {}", list.join(", "));
                    }
                }
                words
            }
            Self::Flat { error, used } => format!(
                "no convergence: the error stays at {} over the last {} step sizes",
                super::number(*error),
                used.len()
            ),
            Self::TooFew { points } => {
                format!("no slope: {points} usable points are too few, {LEAST} are needed")
            }
            Self::Crooked { points } => {
                format!("no slope: no {LEAST} in a row of the {points} points lie on a falling line")
            }
        }
    }
}
