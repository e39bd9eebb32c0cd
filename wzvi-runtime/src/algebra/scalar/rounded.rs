//! Numbers with a bound on their rounding error: running error analysis.
//!
//! An operation adds its own rounding, `ε |result|` and the smallest number for underflow, to the errors of
//! its operands, multiplied by its derivatives (N. J. Higham, *Accuracy and Stability of Numerical
//! Algorithms*, SIAM 2002, section 3.3). Where an iteration stagnates, the emitted equations of a step are
//! evaluated on these numbers, to decide whether the residual is more than rounding. The bounds do not depend
//! on units: each compares a number only with itself.

use std::f64::consts::{LN_2, LN_10};
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::dual::{functions_by_slope, one_minus_square};
use super::{Number, Scalar, Special, without_derivatives};
use crate::ground::numbers::numbers;

/// Twice the largest rounding error of one operation: the bound also holds where the errors of many add up.
const EPSILON: f64 = f64::EPSILON;
/// Nearly twice the largest error of an elementary function ([`Lanes`](crate::algebra::lanes)), 2.2 units in
/// the last place.
const FUNCTION: f64 = 4.0 * f64::EPSILON;
/// The spacing of numbers where they underflow.
const SMALLEST: f64 = f64::MIN_POSITIVE * f64::EPSILON;

/// A number and how far rounding may have taken it from its exact value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rounded {
    /// The number as `f64` has it.
    pub value: f64,
    /// The bound of its error.
    pub error: f64,
}

impl Rounded {
    /// An exact number.
    #[inline]
    pub fn exact(value: f64) -> Self {
        Self { value, error: 0.0 }
    }

    /// A rounded number: it stands for all numbers that round to it.
    #[inline]
    pub fn nearest(value: f64) -> Self {
        Self::computed(value, 0.0, EPSILON)
    }

    /// Whether the number is at most so many times its error: for 1, whether it may be zero. False for NaN.
    #[inline]
    pub fn is_below(self, errors: f64) -> bool {
        self.value.abs() <= errors * self.error
    }

    #[inline]
    fn computed(value: f64, inherited: f64, own: f64) -> Self {
        Self { value, error: inherited + own * value.abs() + SMALLEST }
    }

    /// `f(self)` from `f(value)` and `|f'(value)|`.
    #[inline]
    fn function(self, value: f64, slope: f64) -> Self {
        Self::computed(value, spread(self.error, slope), FUNCTION)
    }
}

/// `error slope`; 0 for an exact number, even where the slope is infinite.
#[inline]
fn spread(error: f64, slope: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error * slope.abs() }
}

numbers! { impl[] Numbers for Rounded { kept: value, error } }

impl Neg for Rounded {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { value: -self.value, ..self }
    }
}

impl Add for Rounded {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self::computed(self.value + other.value, self.error + other.error, EPSILON)
    }
}

impl Sub for Rounded {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self::computed(self.value - other.value, self.error + other.error, EPSILON)
    }
}

impl Mul for Rounded {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        let inherited = spread(other.error, self.value)
            + spread(self.error, other.value)
            + spread(self.error, other.error);
        Self::computed(self.value * other.value, inherited, EPSILON)
    }
}

impl Div for Rounded {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        // `a/b - (a + δ)/(b + η) = (a/b η - δ) / (b + η)`
        let inherited = self.error + spread(other.error, quotient);
        let least = other.value.abs() - other.error;
        let inherited = match inherited == 0.0 {
            true => 0.0,
            false if least > 0.0 => inherited / least,
            false => f64::INFINITY,
        };
        Self::computed(quotient, inherited, EPSILON)
    }
}

macro_rules! with_a_constant {
    ($($operator:ident $method:ident)*) => {$(
        impl $operator<f64> for Rounded {
            type Output = Self;
            #[inline]
            fn $method(self, other: f64) -> Self {
                self.$method(Self::exact(other))
            }
        }
    )*};
}

with_a_constant!(Add add Sub sub Mul mul Div div);

impl Scalar for Rounded {
    type Stages<const N: usize> = [Self; N];
    type Mask = bool;
    type Constant = f64;
    type OfElements<T: Number<f64>> = Self;

    without_derivatives!();

    functions_by_slope!(function);

    #[inline]
    fn from_f64(value: f64) -> Self {
        Self::exact(value)
    }
    #[inline]
    fn of_constant(constant: f64) -> Self {
        Self::exact(constant)
    }
    #[inline]
    fn to_constant(self) -> f64 {
        self.value
    }
    #[inline]
    fn magnitude(self) -> f64 {
        self.value.abs()
    }
    #[inline]
    fn is_identical(self, other: Self) -> bool {
        self.value.is_identical(other.value) && self.error.is_identical(other.error)
    }
    #[inline]
    fn lane(self, _lane: usize) -> f64 {
        self.value
    }
    #[inline]
    fn is_finite(self) -> bool {
        self.value.is_finite()
    }
    #[inline]
    fn less(self, other: Self) -> bool {
        self.value < other.value
    }
    #[inline]
    fn less_equal(self, other: Self) -> bool {
        self.value <= other.value
    }
    #[inline]
    fn equal(self, other: Self) -> bool {
        self.value == other.value
    }
    #[inline]
    fn select(mask: bool, then: Self, otherwise: Self) -> Self {
        if mask { then } else { otherwise }
    }

    #[inline]
    fn recip(self) -> Self {
        Self::exact(1.0) / self
    }
    #[inline]
    fn powi(self, exponent: i32) -> Self {
        let power = |size: f64| Scalar::powi(size, exponent.saturating_abs());
        let size = self.value.abs();
        // The power is monotonic: the error of its argument is largest at the larger end.
        let inherited = if self.error == 0.0 { 0.0 } else { power(size + self.error) - power(size) };
        let own = f64::from(exponent.unsigned_abs()) * EPSILON;
        let positive = Self::computed(Scalar::powi(self.value, exponent.saturating_abs()), inherited, own);
        if exponent < 0 { positive.recip() } else { positive }
    }
    #[inline]
    fn powf(self, exponent: Self) -> Self {
        let (x, y) = (self.value, exponent.value);
        let value = Scalar::powf(x, y);
        let by_base = spread(self.error, y * Scalar::powf(x, y - 1.0));
        // x^y ln x → 0 as x → 0 for y > 0.
        let by_exponent = spread(exponent.error, if value == 0.0 { 0.0 } else { value * Scalar::ln(x) });
        Self::computed(value, by_base + by_exponent, FUNCTION)
    }
    #[inline]
    fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        // `√x - √(x - δ) = δ / (√x + √(x - δ))`
        let inherited = if self.error == 0.0 { 0.0 } else { (self.error / value).min(self.error.sqrt()) };
        Self::computed(value, inherited, EPSILON)
    }
    #[inline]
    fn cbrt(self) -> Self {
        let value = Scalar::cbrt(self.value);
        // `∛x - ∛(x - δ)` is largest, `∛4 ∛δ`, on both sides of zero.
        let inherited = match self.error == 0.0 {
            true => 0.0,
            false => (self.error / value / value).min(1.6 * Scalar::cbrt(self.error)),
        };
        Self::computed(value, inherited, FUNCTION)
    }
    #[inline]
    fn hypot(self, other: Self) -> Self {
        Self::computed(Scalar::hypot(self.value, other.value), self.error + other.error, FUNCTION)
    }
    #[inline]
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    #[inline]
    fn cos(self) -> Self {
        self.sin_cos().1
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = Scalar::sin_cos(self.value);
        // The second term of the expansion counts where the slope vanishes.
        let square = 0.5 * self.error * self.error;
        let mut pair = (self.function(sin, cos), self.function(cos, sin));
        pair.0.error += square;
        pair.1.error += square;
        pair
    }
    #[inline]
    fn asin(self) -> Self {
        self.function(Scalar::asin(self.value), arc_slope(self.value, self.error))
    }
    #[inline]
    fn acos(self) -> Self {
        self.function(Scalar::acos(self.value), arc_slope(self.value, self.error))
    }
    #[inline]
    fn atan2(self, other: Self) -> Self {
        let (y, x) = (self.value, other.value);
        let radius = Scalar::hypot(y, x);
        let inherited = spread(self.error, x / radius / radius) + spread(other.error, y / radius / radius);
        Self::computed(Scalar::atan2(y, x), inherited, FUNCTION)
    }
    #[inline]
    fn cosh(self) -> Self {
        let mut cosh = self.function(Scalar::cosh(self.value), Scalar::sinh(self.value));
        cosh.error += 0.5 * self.error * self.error;
        cosh
    }
    #[inline]
    fn asinh(self) -> Self {
        self.function(Scalar::asinh(self.value), Scalar::hypot(1.0, self.value).recip())
    }
    #[inline]
    fn acosh(self) -> Self {
        let below = (self.value - 1.0).max(self.error).sqrt();
        self.function(Scalar::acosh(self.value), (below * (self.value + 1.0).sqrt()).recip())
    }
    #[inline]
    fn special(self, function: Special) -> Self {
        let size = self.value.abs();
        let slope = function.steepest(size - self.error, size + self.error);
        let error = spread(self.error, slope) + function.rounding(self.value) + SMALLEST;
        Self { value: function.value(self.value), error }
    }
    #[inline]
    fn abs(self) -> Self {
        Self { value: self.value.abs(), ..self }
    }
    #[inline]
    fn signum(self) -> Self {
        Self::exact(self.value.signum())
    }
}

/// `1 / √(1 - x²)`, at its poles over the distance that the error allows.
fn arc_slope(x: f64, error: f64) -> f64 {
    ((1.0 - x.abs()).max(error) * (1.0 + x.abs())).sqrt().recip()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_hold_and_are_not_far_off() {
        // (1 - cos x) / x² at x = 1e-5: rounding of 1 - cos x is that of 1.
        let x = Rounded::exact(1e-5);
        let y = (-x.cos() + 1.0) / (x * x);
        let error = (y.value - (0.5 - 1e-10 / 24.0)).abs();
        assert!(error <= y.error && y.error <= 1e3 * error.max(f64::EPSILON / 1e-10), "{error:e} {y:?}");
        // A zero of the sine, as near as numbers are.
        let turn = Rounded::nearest(2.0 * std::f64::consts::PI);
        assert!(turn.sin().is_below(1.0) && !Rounded::exact(1e-3).sin().is_below(1e12));
    }

    #[test]
    fn bounds_scale_with_the_numbers() {
        // Powers of two: nothing rounds but what rounded before.
        for exponent in [-900, -300, 0, 300, 900] {
            let scale = 2.0_f64.powi(exponent);
            let difference = |x: f64| Rounded::nearest(x * scale) - Rounded::nearest(scale);
            let sum = difference(1.0 + 1e-10) * 3.0 / 7.0;
            let one = (Rounded::nearest(1.0 + 1e-10) - Rounded::nearest(1.0)) * 3.0 / 7.0;
            assert_eq!((sum.value, sum.error), (one.value * scale, one.error * scale), "2^{exponent}");
        }
    }

    #[test]
    fn poles_and_corners_do_not_lose_the_error() {
        for x in [Rounded::nearest(1.0), Rounded { value: 0.0, error: 1e-16 }] {
            for y in
                [x.sqrt(), x.cbrt(), x.asin(), x.acos(), x.powi(3), x.powi(2), x * x, x.cos(), x.hypot(x)]
            {
                assert!(y.error > 0.0 && y.error < 1e-4, "{x:?} {y:?}");
            }
        }
        assert!((Rounded::exact(1.0) / Rounded { value: 1e-17, error: 1e-16 }).error.is_infinite());
        assert!(Rounded::exact(0.0).is_below(0.0) && !Rounded::exact(f64::NAN).is_below(f64::INFINITY));
    }
}
