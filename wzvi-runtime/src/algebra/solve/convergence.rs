//! When an iteration has converged: see `newton`.
//!
//! Relative corrections may be a nineteenth too large or too small ([`Scalar::nearly_recip`]).

use crate::algebra::scalar::{Scalar, larger};

/// Corrections below this fraction of an unknown change nothing.
pub(super) const ROUNDING: f64 = f64::EPSILON;
/// The largest correction that may be omitted after the last one, in roundings: a third, including the error
/// of the measured sizes.
pub(super) const UNSEEN: f64 = 0.25;
/// The largest ratio of the next correction to the square of this one. Relative to the step, the correction
/// after `c` is at most `ω c² / 2`, with `ω` the Lipschitz constant of `J⁻¹ J'`. From zero the first
/// correction is the whole step, and the Kantorovich number of the start is `ω`. Up to 1/2 there is one
/// solution near the start (P. Deuflhard, *Newton Methods for Nonlinear Problems*, section 2.1), and the
/// number grows with the size of the step. Other starts measure the same `ω`.
pub(super) const CURVATURE: f64 = 0.25;
/// The largest second correction, relative to the step: half of the bound from the Kantorovich number 1/2.
/// From zero the first correction is always 1, so the second is the only measurement of `ω`. Later ones are
/// then below 0.21 of the square of the one before (theorem 2.1 there), 0.24 in the measured sizes.
pub(super) const FIRST: f64 = 0.5 * CURVATURE;
/// The bound on the second correction from an extrapolated start, whatever the first was. Such a start may be
/// anywhere; the bound ensures that the Jacobian is constant to `ω = 2^-9` between start and solution. It is
/// for a stiff unknown that alternates.
const ASTRAY: f64 = CURVATURE * GUIDED * GUIDED;
/// A first correction below this part of the step is followed by smaller ones in any case.
pub(super) const GUIDED: f64 = 1.0 / 16.0;
/// Corrections below twice this fraction of an unknown cannot lead to another solution, and need only halve.
pub(super) const NEAR: f64 = 1.0 / 4096.0;
/// The largest square of a correction that predicts the next one: that of the whole step. A correction is
/// larger where it leaves an unknown near zero, which says nothing about the others.
pub(super) const WHOLE: f64 = 1.0;

/// How large a number is against `|other|`, part by part (value, derivatives, lanes): the largest ratio, 0
/// for a part that vanishes; NaN if any part is. `f64::MIN_POSITIVE` is added to the divisor: a number that
/// is nearest to another differs from it by `ε (|x| + MIN_POSITIVE)` at most, subnormal or not. Derivatives
/// are compared as a gradient, by the largest.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn relative_to<S: Scalar>(number: S, other: S) -> f64 {
    if const { S::DERIVATIVES > 0 } {
        let of_values = relative_to(number.value(), other.value());
        return larger(of_values, relative_to(largest_derivative(number), largest_derivative(other)));
    }
    let of_lane = |lane| number.lane(lane).abs() / (other.lane(lane).abs() + f64::MIN_POSITIVE);
    (1..S::LANES).fold(of_lane(0), |most, lane| larger(most, of_lane(lane)))
}

fn largest_derivative<S: Scalar>(number: S) -> S::Value {
    let zero = S::Value::from_f64(0.0);
    (0..S::DERIVATIVES).fold(zero, |largest, part| number.derivative(part).larger(largest))
}

/// `|correction| / |unknown|` within a nineteenth, by lane; not finite where that is larger than all numbers.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn nearly_relative<S: Scalar>(correction: S, unknown: S) -> S {
    // One operation of all lanes after the other: compilers take the lanes of several at once apart.
    (correction * unknown.nearly_recip()).abs()
}

/// The square of a correction, as far as it predicts the next one.
#[cfg_attr(not(debug_assertions), inline(always))]
fn predicting(relative: f64) -> f64 {
    f64::min(relative * relative, WHOLE)
}

/// The corrections of an iteration, as far as they say when to stop.
#[derive(Clone, Copy)]
pub(crate) struct Convergence {
    /// The bound on the next correction if convergence is quadratic; below it no other test is needed.
    curved: f64,
    /// The cube of the relative correction that is good enough: `ROUNDING³` or `last² ROUNDING unseen`.
    enough: f64,
    unseen: f64,
    pub(crate) iterations: u32,
    /// The bound on the second correction.
    second: f64,
    /// Whether corrections need only halve.
    is_patient: bool,
    /// Whether `curved` follows from unknowns beyond rounding only.
    is_beyond_rounding: bool,
}

/// The verdict on a correction.
pub(crate) enum Verdict {
    /// It was the last.
    Converged,
    /// It is at most half of the one before.
    Contracting,
    /// It is not.
    Straying,
}

impl Convergence {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn new(is_guess: bool) -> Self {
        let (curved, second) = if is_guess { (GUIDED, ASTRAY) } else { (0.0, FIRST) };
        let enough = ROUNDING * ROUNDING * ROUNDING;
        let (unseen, iterations, is_patient, is_beyond_rounding) = (UNSEEN, 0, false, false);
        Self { curved, enough, unseen, iterations, second, is_patient, is_beyond_rounding }
    }

    /// Where an iteration is after corrections that were good at a glance.
    pub(super) fn resumed(iterations: u32, curved: f64, enough: f64, is_guess: bool) -> Self {
        let new = Self::new(is_guess);
        if iterations == 0 { new } else { Self { iterations, curved, enough, ..new } }
    }

    /// An extrapolated start that turned out to be zero claims nothing: there was no solution to extrapolate.
    pub(super) fn claim_nothing(&mut self) {
        self.second = FIRST;
    }

    /// With corrections that need only halve, for callers that judge solutions by other means.
    pub(super) fn patient(unseen: f64) -> Self {
        Self { curved: f64::INFINITY, is_patient: true, unseen, ..Self::new(false) }
    }

    /// The first correction.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn begin(&mut self, relative: f64) {
        self.iterations = 1;
        self.expect(predicting(relative));
        self.curved = self.second;
    }

    /// The verdict on the largest correction relative to its unknown, where that is all it takes; `None`, and
    /// nothing is noted, where it depends on the residuals.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn glance(&mut self, relative: f64) -> Option<Verdict> {
        let square = relative * relative;
        // `relative <= ROUNDING || relative (relative / last)² <= ROUNDING unseen` without dividing.
        let verdict = if square * relative <= self.enough {
            Verdict::Converged
        } else if relative < self.curved && !self.is_patient {
            self.expect(square);
            Verdict::Contracting
        } else {
            // NaN, too.
            return None;
        };
        self.iterations += 1;
        Some(verdict)
    }

    /// `relative`: largest correction relative to its unknown. `beyond_rounding`: the same of the unknowns
    /// whose residual was more than its rounding; 0 if there are none.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn judge(&mut self, relative: f64, beyond_rounding: impl FnOnce() -> f64) -> Verdict {
        if let Some(verdict) = self.glance(relative) {
            return verdict;
        }
        if !relative.is_finite() {
            self.iterations += 1;
            return Verdict::Straying;
        }
        if self.iterations == 0 && !self.is_patient {
            self.begin(relative);
            return Verdict::Contracting;
        }
        self.iterations += 1;
        let (allowed, square) = (self.allowed(self.curved), predicting(relative));
        if relative < allowed {
            self.expect(square);
            return Verdict::Contracting;
        }
        let beyond = beyond_rounding();
        if beyond == 0.0 {
            return Verdict::Converged;
        }
        // What is rounding may have been the larger part of the correction before.
        let own = if self.is_beyond_rounding { 0.0 } else { self.allowed(CURVATURE * square) };
        if beyond < allowed.max(own) {
            self.is_beyond_rounding = true;
            self.expect(predicting(beyond));
            return Verdict::Contracting;
        }
        Verdict::Straying
    }

    /// What the next correction has to be below.
    fn allowed(&self, curved: f64) -> f64 {
        if self.is_patient { curved.sqrt() } else { allowed(curved) }
    }

    /// Quadratic convergence from a correction with this square, at most [`WHOLE`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn expect(&mut self, square: f64) {
        self.curved = CURVATURE * square;
        // The correction is above `ROUNDING` here, so that neither product underflows.
        let (predicted, floor) = (self.unseen * ROUNDING * square, ROUNDING * ROUNDING * ROUNDING);
        self.enough = if predicted > floor { predicted } else { floor };
    }

    /// A correction that does not count as one of a sequence: the next is judged by itself.
    pub(crate) fn forget(&mut self) {
        (self.curved, self.enough) = (f64::INFINITY, ROUNDING * ROUNDING * ROUNDING);
        self.is_beyond_rounding = false;
    }
}

/// The bound on the next correction: `CURVATURE` times the square of the last one, and at most half of it.
#[cfg_attr(not(debug_assertions), inline(always))]
fn allowed(curved: f64) -> f64 {
    let half = curved.sqrt();
    half.min(curved.max(NEAR))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The correction after one that ended near zero is as large as the step, and not the last.
    #[test]
    fn a_first_correction_that_ends_near_zero_predicts_nothing() {
        let mut convergence = Convergence::new(true);
        assert!(matches!(convergence.judge(1e10, || 1e10), Verdict::Contracting));
        assert!(matches!(convergence.judge(0.5, || 0.5), Verdict::Straying));
    }

    /// Nor does a later one, whose square may overflow.
    #[test]
    fn a_correction_that_ends_at_zero_is_no_contraction() {
        let mut convergence = Convergence::new(false);
        convergence.begin(1.0);
        assert!(matches!(convergence.judge(1e307, || 1e306), Verdict::Straying));
    }

    /// Between two powers of two the error does not depend on the power.
    #[test]
    fn sizes_are_nearly_right() {
        let mantissas = || (0..=1000).map(|k| 1.0 + f64::from(k) / 1000.0);
        for power in [-900, -500, -1, 0, 1, 500, 1000, 1020] {
            for mantissa in mantissas() {
                let size = mantissa * 2f64.powi(power);
                for number in [size, -0.3 * size, 1e-16 * size] {
                    let (near, exact) = (nearly_relative(number, -size), number.abs() / size);
                    assert!((near - exact).abs() <= exact / 19.0, "{number:e} {size:e}");
                    assert_eq!(near.to_bits(), number.nearly_over(size).to_bits());
                }
            }
        }
    }

    /// Where numbers have fewer digits, roundings are of one size, and so are errors of two and a half.
    #[test]
    fn what_is_subnormal_is_small() {
        for size in (0..52).map(|power| f64::from_bits(1 << power)) {
            let (near, exact) = (nearly_relative(5e-324, size), relative_to(5e-324, size));
            assert!(near > 0.0 && near <= 2.5 * exact, "{size:e}: {near:e} {exact:e}");
        }
        assert_eq!(nearly_relative(0.0, 0.0), 0.0);
        assert!(!nearly_relative(f64::INFINITY, f64::INFINITY).is_finite());
        assert!(!nearly_relative(f64::NAN, 1.0).is_finite());
    }
}
