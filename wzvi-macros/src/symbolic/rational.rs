//! Exact rational numbers whose numerator and denominator fit the significand of an `f64`.

use std::cmp::Ordering;
use std::fmt;

/// Largest numerator and denominator: every integer up to it is exact in binary64, so that
/// [`Rational::to_f64`] is one correctly rounded division.
const LIMIT: i128 = 1 << 53;

/// A reduced fraction with a positive denominator.
///
/// Arithmetic that would leave the representable range answers `None`; the graph then keeps the operation
/// symbolic.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) struct Rational {
    numerator: i64,
    denominator: i64,
}

impl Rational {
    pub(crate) const ZERO: Self = Self { numerator: 0, denominator: 1 };
    pub(crate) const ONE: Self = Self { numerator: 1, denominator: 1 };
    pub(crate) const MINUS_ONE: Self = Self { numerator: -1, denominator: 1 };
    pub(crate) const THIRD: Self = Self { numerator: 1, denominator: 3 };
    pub(crate) const QUARTER: Self = Self { numerator: 1, denominator: 4 };
    pub(crate) const HALF: Self = Self { numerator: 1, denominator: 2 };

    pub(crate) fn new(numerator: i128, denominator: i128) -> Option<Self> {
        let (n, d) = (numerator.unsigned_abs(), denominator.unsigned_abs());
        let divisor = if d == 1 { 1 } else { gcd(n, d) };
        let (n, d) = (n / divisor, d / divisor);
        let sign = (numerator.signum() * denominator.signum()) as i64;
        let is_small = d > 0 && n.max(d) <= LIMIT.unsigned_abs();
        is_small.then(|| Self { numerator: sign * n as i64, denominator: d as i64 })
    }

    pub(crate) const fn integer(value: i32) -> Self {
        Self { numerator: value as i64, denominator: 1 }
    }

    pub(crate) fn numerator(self) -> i64 {
        self.numerator
    }

    pub(crate) fn denominator(self) -> i64 {
        self.denominator
    }

    pub(crate) fn is_zero(self) -> bool {
        self.numerator == 0
    }

    pub(crate) fn is_one(self) -> bool {
        self == Self::ONE
    }

    pub(crate) fn is_integer(self) -> bool {
        self.denominator == 1
    }

    pub(crate) fn is_negative(self) -> bool {
        self.numerator < 0
    }

    /// The nearest binary64 number.
    pub(crate) fn to_f64(self) -> f64 {
        self.numerator as f64 / self.denominator as f64
    }

    pub(crate) const fn negate(self) -> Self {
        Self { numerator: -self.numerator, ..self }
    }

    pub(crate) fn recip(self) -> Option<Self> {
        Self::new(self.denominator.into(), self.numerator.into())
    }

    pub(crate) fn add(self, other: Self) -> Option<Self> {
        let (a, b) = (i128::from(self.numerator), i128::from(self.denominator));
        let (c, d) = (i128::from(other.numerator), i128::from(other.denominator));
        Self::new(a * d + c * b, b * d)
    }

    pub(crate) fn multiply(self, other: Self) -> Option<Self> {
        // Nearly all coefficients and exponents are one.
        if self.is_one() || other.is_one() {
            return Some(if self.is_one() { other } else { self });
        }
        let (a, b) = (i128::from(self.numerator), i128::from(self.denominator));
        let (c, d) = (i128::from(other.numerator), i128::from(other.denominator));
        Self::new(a * c, b * d)
    }

    pub(crate) fn power(self, exponent: i64) -> Option<Self> {
        let base = if exponent < 0 { self.recip()? } else { self };
        power(Self::ONE, base, exponent.unsigned_abs(), Self::multiply)
    }

    /// The exact value of a finite `f64`, if it is representable.
    pub(crate) fn from_f64(value: f64) -> Option<Self> {
        let scaled = value * (1u64 << 52) as f64;
        if !value.is_finite() || scaled.abs() >= i128::MAX as f64 || scaled != scaled.trunc() {
            return None;
        }
        Self::new(scaled as i128, 1 << 52)
    }

    /// The exact value of a decimal literal such as `0.1` or `2.5e-3` (digits, point and exponent; no
    /// suffix).
    pub(crate) fn from_decimal(literal: &str) -> Option<Self> {
        let (mantissa, exponent) = match literal.split_once(['e', 'E']) {
            Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
            None => (literal, 0),
        };
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let digits = format!("{whole}{fraction}");
        let digits = digits.trim_start_matches('0');
        if digits.len() > 30 {
            return None;
        }
        let value: i128 = if digits.is_empty() { 0 } else { digits.parse().ok()? };
        let shift = exponent.checked_sub(i32::try_from(fraction.len()).ok()?)?;
        let scale = 10i128.checked_pow(shift.unsigned_abs().min(30))?;
        match shift {
            -30..=0 => Self::new(value, scale),
            1..=30 => Self::new(value.checked_mul(scale)?, 1),
            _ => None,
        }
    }
}

/// `base^exponent` by repeated squaring; `None` if a product is.
pub(super) fn power<T: Copy>(
    one: T,
    base: T,
    exponent: u64,
    multiply: impl Fn(T, T) -> Option<T>,
) -> Option<T> {
    let (mut square, mut rest, mut result) = (base, exponent, one);
    while rest > 0 {
        if rest & 1 == 1 {
            result = multiply(result, square)?;
        }
        rest >>= 1;
        if rest > 0 {
            square = multiply(square, square)?;
        }
    }
    Some(result)
}

/// The greatest common divisor; 1 of zeros.
pub(crate) fn gcd(mut a: u128, mut b: u128) -> u128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a.max(1)
}

impl PartialOrd for Rational {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Rational {
    fn cmp(&self, other: &Self) -> Ordering {
        let left = i128::from(self.numerator) * i128::from(other.denominator);
        left.cmp(&(i128::from(other.numerator) * i128::from(self.denominator)))
    }
}

impl fmt::Display for Rational {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.denominator {
            1 => write!(f, "{}", self.numerator),
            d => write!(f, "{}/{d}", self.numerator),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn decimal_literals_are_exact() {
        assert_eq!(Rational::from_decimal("0.1"), Rational::new(1, 10));
        assert_eq!(Rational::from_decimal("2.5e-3"), Rational::new(1, 400));
        assert_eq!(Rational::from_decimal("1e5"), Rational::new(100_000, 1));
        assert_eq!(Rational::from_decimal("1e-150"), None);
        assert_eq!(Rational::from_decimal("0.0"), Some(Rational::ZERO));
    }

    #[test]
    fn arithmetic_leaves_the_range_as_none() {
        let large = Rational::new(LIMIT, 1).unwrap();
        assert_eq!(large.multiply(large), None);
        assert_eq!(large.add(Rational::ONE), None);
        assert_eq!(Rational::HALF.power(-3), Some(Rational::integer(8)));
        assert_eq!(Rational::integer(3).power(60), None);
        for (n, d) in
            [(i128::MIN, 1), (1, i128::MIN), (i128::MIN, -1), (i128::MIN, i128::MAX), (1, 0), (0, 0)]
        {
            assert_eq!(Rational::new(n, d), None);
        }
        assert_eq!(Rational::new(i128::MIN, i128::MIN), Some(Rational::ONE));
        assert_eq!(Rational::new(0, i128::MIN), Some(Rational::ZERO));
    }

    #[test]
    fn binary64_round_trips() {
        for value in [0.0, -0.5, 1.25, 3.0, 0.1, 1e15] {
            if let Some(rational) = Rational::from_f64(value) {
                assert_eq!(rational.to_f64(), value);
            }
        }
        assert_eq!(Rational::from_f64(0.375), Rational::new(3, 8));
        assert_eq!(Rational::from_f64(f64::NAN), None);
    }
}
