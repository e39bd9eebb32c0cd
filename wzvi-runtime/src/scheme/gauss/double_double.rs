//! Numbers with twice the digits: `high + low` (T. J. Dekker, "A floating-point technique for extending the
//! available precision", Numer. Math. 18, 1971). Used for coefficients, which are computed once.

use crate::algebra::scalar::Scalar;
use std::ops::{Add, Div, Mul, Sub};

/// `high + low`, `|low| <= ε |high|`
#[derive(Clone, Copy, Debug)]
pub(super) struct DoubleDouble {
    high: f64,
    low: f64,
}

impl DoubleDouble {
    /// The nearest `f64`.
    pub(super) fn rounded(self) -> f64 {
        self.high + self.low
    }

    /// The nearest multiple of `2^-bits`, below `2^(53 - bits)`: sums and differences of such numbers do not
    /// round.
    pub(super) fn on_grid(self, bits: i32) -> f64 {
        let scale = Scalar::powi(2.0, bits);
        let high = self.high * scale;
        let near = high.round_ties_even();
        // The rest separately: rounding the sum twice would break the symmetry between `x` and `1 - x`.
        let rest = (high - near) + self.low * scale;
        (near + rest.round_ties_even()) / scale
    }

    /// The exact sum.
    fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let taken = high - a;
        Self { high, low: (a - (high - taken)) + (b - taken) }
    }

    /// The exact product.
    #[expect(clippy::disallowed_methods, reason = "exact, so the same on every machine")]
    fn product(a: f64, b: f64) -> Self {
        let high = a * b;
        Self { high, low: a.mul_add(b, -high) }
    }
}

impl From<f64> for DoubleDouble {
    fn from(number: f64) -> Self {
        Self { high: number, low: 0.0 }
    }
}

impl Add for DoubleDouble {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let sum = Self::sum(self.high, other.high);
        let rest = Self::sum(self.low, other.low);
        let sum = Self::sum(sum.high, sum.low + rest.high);
        Self::sum(sum.high, sum.low + rest.low)
    }
}

impl Sub for DoubleDouble {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + Self { high: -other.high, low: -other.low }
    }
}

impl Mul for DoubleDouble {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let product = Self::product(self.high, other.high);
        Self::sum(product.high, product.low + (self.high * other.low + self.low * other.high))
    }
}

impl Div for DoubleDouble {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        let rest = self - other * Self::from(first);
        let second = rest.high / other.high;
        let rest = rest - other * Self::from(second);
        Self::sum(first, second) + Self::from(rest.high / other.high)
    }
}

impl Add<f64> for DoubleDouble {
    type Output = Self;
    fn add(self, other: f64) -> Self {
        self + Self::from(other)
    }
}

impl Mul<f64> for DoubleDouble {
    type Output = Self;
    fn mul(self, other: f64) -> Self {
        self * Self::from(other)
    }
}

impl Div<f64> for DoubleDouble {
    type Output = Self;
    fn div(self, other: f64) -> Self {
        self / Self::from(other)
    }
}
