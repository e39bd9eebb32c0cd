//! Real numbers of chosen precision: the reference of the accuracy tests of this crate, of the run time and
//! of the facade.
#![allow(dead_code, reason = "several crates share it, and each uses its part")]

use std::cell::{Cell, RefCell};
use std::ops::{Add, Div, Mul, Neg, Sub};

use astro_float_num::{BigFloat, Consts, RoundingMode};

const ROUNDING: RoundingMode = RoundingMode::ToEven;
/// Two evaluations that agree to this many bits count as exact.
const AGREEMENT: i32 = 90;
const LOWEST_PRECISION: usize = 256;
/// The highest precision in bits: 1 plus the fourth power of the smallest number needs 4300.
const HIGHEST_PRECISION: usize = 5000;

thread_local! {
    static PRECISION: Cell<usize> = const { Cell::new(LOWEST_PRECISION) };
    static CONSTANTS: RefCell<Option<Consts>> = const { RefCell::new(None) };
}

/// A number of the precision that [`with_precision`] sets; operations round to nearest.
#[derive(Clone, Debug)]
pub(crate) struct Real(BigFloat);

/// `compute()` with `bits` binary digits.
pub(crate) fn with_precision<T>(bits: usize, compute: impl FnOnce() -> T) -> T {
    let before = PRECISION.replace(bits);
    let result = compute();
    PRECISION.set(before);
    result
}

/// The precision for expressions in `inputs` that square differences of their squares, enough to resolve
/// terms small against 1.
pub(crate) fn sufficient_precision(inputs: impl Iterator<Item = f64>) -> usize {
    let size = |x: f64| Real::from(x).exponent().map_or(0, i32::unsigned_abs);
    inputs.map(|x| LOWEST_PRECISION + 4 * size(x) as usize).max().unwrap_or(LOWEST_PRECISION)
}

/// The value of `compute` with increasing precision from `bits` on, until the first 90 bits no longer change;
/// `None` if it is not finite or no precision suffices. Zero is accepted at the highest precision only.
pub(crate) fn exact(bits: usize, compute: impl Fn() -> Real) -> Option<Real> {
    let mut bits = bits;
    let mut last = with_precision(bits, &compute);
    while bits < HIGHEST_PRECISION {
        bits += bits / 2;
        let next = with_precision(bits, &compute);
        let agree = match (next.exponent(), (&next - &last).exponent()) {
            (Some(_), None) => true,
            (Some(size), Some(error)) => error < size - AGREEMENT,
            (None, None) => bits >= HIGHEST_PRECISION,
            (None, Some(_)) => false,
        };
        if !next.0.is_nan() && !next.0.is_inf() && agree {
            return Some(next);
        }
        last = next;
    }
    None
}

/// The error of `computed` in units in the last place of the nearest binary64 number, where that is finite.
pub(crate) fn error_in_ulps(computed: f64, exact: &Real) -> f64 {
    if !computed.is_finite() {
        return f64::INFINITY;
    }
    // 0.1… · 2^exponent has its last of 53 digits at 2^(exponent - 53).
    let last_place = exact.exponent().map_or(-1074, |exponent| (exponent - 53).max(-1074));
    (&Real::from(computed) - exact).scaled(-last_place).abs()
}

macro_rules! unary {
    ($($name:ident)*) => {
        $(pub(crate) fn $name(&self) -> Self {
            Self::using_constants(|precision, constants| self.0.$name(precision, ROUNDING, constants))
        })*
    };
}

impl Real {
    unary!(exp ln log2 log10 sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh);

    fn using_constants(compute: impl FnOnce(usize, &mut Consts) -> BigFloat) -> Self {
        CONSTANTS.with_borrow_mut(|constants| match constants {
            Some(constants) => Self(compute(PRECISION.get(), constants)),
            None => match Consts::new() {
                Ok(fresh) => Self(compute(PRECISION.get(), constants.insert(fresh))),
                Err(error) => Self(BigFloat::nan(Some(error))),
            },
        })
    }

    pub(crate) fn sqrt(&self) -> Self {
        Self(self.0.sqrt(PRECISION.get(), ROUNDING))
    }

    pub(crate) fn cbrt(&self) -> Self {
        Self(self.0.cbrt(PRECISION.get(), ROUNDING))
    }

    pub(crate) fn pow(&self, exponent: &Self) -> Self {
        Self::using_constants(|precision, constants| self.0.pow(&exponent.0, precision, ROUNDING, constants))
    }

    pub(crate) fn powi(&self, exponent: i64) -> Self {
        let power = Self(self.0.powi(exponent.unsigned_abs() as usize, PRECISION.get(), ROUNDING));
        if exponent < 0 { &Self::from(1.0) / &power } else { power }
    }

    pub(crate) fn abs(&self) -> Self {
        Self(self.0.abs())
    }

    pub(crate) fn is_negative(&self) -> bool {
        self.0.is_negative()
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.0.is_zero()
    }

    /// `|self|` is in `[2^(exponent-1), 2^exponent)`; `None` for zero and what is not finite.
    pub(crate) fn exponent(&self) -> Option<i32> {
        self.0.exponent().filter(|_| !self.0.is_zero())
    }

    /// `self · 2^shift`, to 64 bits, rounded to binary64.
    pub(crate) fn scaled(&self, shift: i32) -> f64 {
        let Some((words, _, sign, exponent, _)) = self.0.as_raw_parts() else { return f64::NAN };
        let Some(&top) = words.last().filter(|&&top| top != 0) else { return 0.0 };
        // As two factors, each a representable power of two.
        let total =
            exponent.saturating_add(shift).clamp(-2200, 2200) - i32::try_from(u64::BITS).unwrap_or(64);
        let half = total / 2;
        let size = top as f64 * 2.0_f64.powi(half) * 2.0_f64.powi(total - half);
        if sign.is_negative() { -size } else { size }
    }

    pub(crate) fn to_f64(&self) -> f64 {
        self.scaled(0)
    }
}

impl From<f64> for Real {
    fn from(value: f64) -> Self {
        let precision = PRECISION.get();
        if !value.is_subnormal() {
            return Self(BigFloat::from_f64(value, precision));
        }
        // `from_f64` halves subnormal numbers (astro-float-num 0.3.7).
        let (up, down) = (2.0_f64.powi(600), 2.0_f64.powi(-600));
        let large = BigFloat::from_f64(value * up, precision);
        Self(large.mul(&BigFloat::from_f64(down, precision), precision, ROUNDING))
    }
}

impl PartialEq for Real {
    fn eq(&self, other: &Self) -> bool {
        self.0.cmp(&other.0) == Some(0)
    }
}

impl PartialOrd for Real {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        self.0.cmp(&other.0).map(|sign| sign.cmp(&0))
    }
}

macro_rules! operators {
    ($($trait:ident $method:ident $function:ident;)*) => { $(
        impl $trait<&Real> for &Real {
            type Output = Real;
            fn $method(self, other: &Real) -> Real {
                Real(self.0.$function(&other.0, PRECISION.get(), ROUNDING))
            }
        }
        impl $trait<Real> for &Real {
            type Output = Real;
            fn $method(self, other: Real) -> Real {
                self.$method(&other)
            }
        }
        impl $trait<&Real> for Real {
            type Output = Real;
            fn $method(self, other: &Real) -> Real {
                (&self).$method(other)
            }
        }
        impl $trait<Real> for Real {
            type Output = Real;
            fn $method(self, other: Real) -> Real {
                (&self).$method(&other)
            }
        }
        impl $trait<f64> for &Real {
            type Output = Real;
            fn $method(self, other: f64) -> Real {
                self.$method(&Real::from(other))
            }
        }
        impl $trait<f64> for Real {
            type Output = Real;
            fn $method(self, other: f64) -> Real {
                (&self).$method(&Real::from(other))
            }
        }
    )* };
}

operators! {
    Add add add;
    Sub sub sub;
    Mul mul mul;
    Div div div;
}

impl Neg for Real {
    type Output = Real;
    fn neg(self) -> Real {
        Real(BigFloat::neg(&self.0))
    }
}

impl Neg for &Real {
    type Output = Real;
    fn neg(self) -> Real {
        Real(BigFloat::neg(&self.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn binary64_goes_in_and_out() {
        let numbers = [0.0, 1.0, -2.5, 1e300, f64::MAX, 1e-300, f64::MIN_POSITIVE, 3e-310, -5e-324];
        for number in numbers {
            assert_eq!(Real::from(number).to_f64(), number);
            let next = f64::from_bits(number.to_bits() + 1);
            if next.is_finite() {
                assert_eq!(error_in_ulps(next, &Real::from(number)), 1.0, "{number:e}");
            }
        }
    }

    #[test]
    fn digits_are_added_until_they_suffice() {
        // 1 - cos x = x²/2 to all digits of binary64.
        for x in [1e-9, 1e-30, 1e-100, 1e-150] {
            let exact = exact(256, || Real::from(1.0) - Real::from(x).cos()).map(|value| value.to_f64());
            assert_eq!(exact, Some(x * x / 2.0));
        }
        assert!(exact(256, || Real::from(-1.0).sqrt()).is_none());
    }
}
