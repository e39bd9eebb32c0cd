//! Truncated increments (Milstein, Repin, Tretyakov, SIAM J. Numer. Anal. 40 (2002) 1583).
//!
//! `dW = s zeta`, with `s` the standard deviation (`sqrt(h)` for a Wiener process) and
//!
//! ```text
//! zeta = clip(xi, +-A_h),   A_h = max(6, sqrt(2 k |ln h|)),   0 <= 1 - E zeta^2 <= max(1e-8, (1 + 2 A_h) h^k)
//! ```
//!
//! The floor of 6 is ours: `|ln h|` is measured in the user's unit of time, and without it steps near one in
//! that unit would lose a noticeable part of the noise (0.86 % of the variance for k = 4), however short they
//! are physically.
//!
//! An implicit step can have a pole at a finite increment; truncated increments stay away from it once h is
//! small enough. Take k at least twice the strong order.
//!
//! Tested by `tests/ensembles/poles.rs`.

use super::NoiseError;
use crate::algebra::lanes::elementary::ln_shifted;

/// Whether and how increments are truncated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Truncation {
    /// The user said nothing: a run may choose.
    #[default]
    Unset,
    /// Never.
    Off,
    /// With this `k >= 1`.
    On(f64),
}

impl Truncation {
    /// The `k` that a run chooses for an implicit scheme with multiplicative noise.
    pub const DEFAULT: f64 = 4.0;

    pub(super) fn check(&self) -> Result<(), NoiseError> {
        match *self {
            Self::On(k) if !(k.is_finite() && k >= 1.0) => Err(NoiseError::Truncation(k)),
            _ => Ok(()),
        }
    }

    /// The truncation that acts in a run, given whether the run truncates by default.
    pub(super) fn in_run(self, truncates: bool) -> Self {
        if self == Self::Unset && truncates { Self::On(Self::DEFAULT) } else { self }
    }

    /// The largest increment of a step, given the standard deviation; infinite without truncation.
    pub(super) fn bound(&self, h: f64, deviation: f64) -> f64 {
        match *self {
            Self::On(k) => deviation * clip_bound(h, k),
            Self::Unset | Self::Off => f64::INFINITY,
        }
    }
}

/// The methods that set the truncation of a noise through `$with`: `|noise, truncation| noise`.
macro_rules! truncation_setters {
    ($with:expr) => {
        /// Truncates the increments of steps to `±A_h` of their standard deviations,
        /// `A_h = max(6, √(2 k |ln h|))`, `k >= 1` ([`clip_bound`](crate::noise::clip_bound)). The path
        /// itself is not changed.
        pub fn truncated(self, k: impl Into<f64>) -> Self {
            ($with)(self, crate::noise::Truncation::On(k.into()))
        }

        /// Leaves the increments as they are, also where a run would truncate them by default.
        pub fn untruncated(self) -> Self {
            ($with)(self, crate::noise::Truncation::Off)
        }
    };
}
pub(super) use truncation_setters;

/// The least bound, in standard deviations.
const FLOOR: f64 = 6.0;

/// `A_h = max(6, sqrt(2 k |ln h|))`, the bound on a truncated increment in standard deviations; the same bits
/// on all targets.
///
/// `h` is the step size (its sign does not matter), `k >= 1`.
pub fn clip_bound(h: f64, k: f64) -> f64 {
    let h = h.abs();
    // Subnormal step sizes are raised to the least normal one, infinite ones lowered to the largest.
    let logarithm = ln_shifted(h.clamp(f64::MIN_POSITIVE, f64::MAX), 0.0).abs();
    (2.0 * k * logarithm).sqrt().max(FLOOR)
}

#[cfg(test)]
mod tests {
    use super::clip_bound;

    /// `1 - E zeta^2 = 2 int_A^inf (x^2 - A^2) phi(x) dx`, by Simpson's rule.
    fn defect(bound: f64) -> f64 {
        let (n, width) = (4000, 12.0);
        let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
        let f = |i: i32| {
            let x = bound + width * f64::from(i) / f64::from(n);
            (x * x - bound * bound) * density(x)
        };
        let sum: f64 = (1..n).map(|i| f(i) * if i % 2 == 1 { 4.0 } else { 2.0 }).sum();
        2.0 * (sum + f(0) + f(n)) * width / f64::from(n) / 3.0
    }

    #[test]
    fn variance_is_lost_within_the_bound() {
        for k in [1.0, 2.0, 4.0] {
            for h in [3.0, 1.0, 0.9, 0.3, 0.1, 0.02, 1e-3, 1e-5, 1e-8] {
                let (bound, lost) = (clip_bound(h, k), defect(clip_bound(h, k)));
                let allowed = ((1.0 + 2.0 * bound) * f64::powf(h, k)).max(1e-8);
                assert!(lost > 0.0 && lost <= allowed, "{h} {k}: {lost}");
            }
        }
    }

    /// Whatever the unit of time: no step loses more of the variance than 1e-8 where the published bound
    /// would be below the floor.
    #[test]
    fn steps_of_order_one_keep_their_variance() {
        for h in [1.0, 0.9, -2.0, 0.02, f64::MIN_POSITIVE, 5e-324] {
            assert!(clip_bound(h, 4.0) >= 6.0, "{h}");
        }
        assert!(defect(clip_bound(1.0, 4.0)) < 1e-8);
        assert!((clip_bound(1e-4, 4.0) - (8.0 * 1e4f64.ln()).sqrt()).abs() < 1e-14);
    }
}
