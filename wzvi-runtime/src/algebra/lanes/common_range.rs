//! A number in a loop that becomes vector code.
//!
//! Functions of `f64` are calls. In a loop over neighbours they are inlined without the branch for rare
//! arguments, which would prevent vectorisation. Instead, every value that depends on a rare argument is NaN,
//! comparisons included. A result is therefore either that of `f64` or NaN, and the caller computes NaNs
//! again, as `f64`.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use super::elementary;
use crate::algebra::scalar::{Mask, Number, Scalar, Special, without_derivatives};
use crate::ground::numbers::{Numbers, Tape, numbers};

/// A number in a loop over neighbours: NaN where a function meets a rare argument.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CommonRange(f64);

impl Number<f64> for CommonRange {
    const IS_PARTIAL: bool = true;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of(kept: f64) -> Self {
        Self(kept)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn kept(self) -> f64 {
        self.0
    }
}

/// The truth of a comparison, where its operands are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KnownTruth {
    truth: bool,
    is_known: bool,
}

impl KnownTruth {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of(truth: bool, a: CommonRange, b: CommonRange) -> Self {
        Self { truth, is_known: !a.0.is_nan() & !b.0.is_nan() }
    }
}

impl BitAnd for KnownTruth {
    type Output = Self;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn bitand(self, other: Self) -> Self {
        Self { truth: self.truth & other.truth, is_known: self.is_known & other.is_known }
    }
}

impl BitOr for KnownTruth {
    type Output = Self;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn bitor(self, other: Self) -> Self {
        Self { truth: self.truth | other.truth, is_known: self.is_known & other.is_known }
    }
}

impl Not for KnownTruth {
    type Output = Self;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn not(self) -> Self {
        Self { truth: !self.truth, ..self }
    }
}

numbers! { impl[] Numbers for KnownTruth { kept: truth, is_known } }

impl Mask for KnownTruth {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_lanes(mut holds: impl FnMut(usize) -> bool) -> Self {
        Self { truth: holds(0), is_known: true }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn all(self) -> bool {
        self.truth
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lane(self, _lane: usize) -> bool {
        self.truth
    }
    type ByLane<T> = [T; 1];
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn by_lane<T>(mut of: impl FnMut(usize) -> T) -> [T; 1] {
        [of(0)]
    }
}

macro_rules! arithmetic {
    ($($trait:ident $method:ident)*) => {$(
        impl $trait for CommonRange {
            type Output = Self;

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }

        impl $trait<f64> for CommonRange {
            type Output = Self;

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn $method(self, other: f64) -> Self {
                Self(self.0.$method(other))
            }
        }
    )*};
}

arithmetic!(Add add Sub sub Mul mul Div div);

impl Neg for CommonRange {
    type Output = Self;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Numbers for CommonRange {
    fn pass(&mut self, tape: &mut Tape) {
        self.0.pass(tape);
    }
}

macro_rules! unary {
    ($($method:ident: $function:ident),*) => {$(
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn $method(self) -> Self {
            Self(elementary::$function::usual(self.0))
        }
    )*};
}

macro_rules! exact {
    ($($method:ident)*) => {$(
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn $method(self) -> Self {
            Self(Scalar::$method(self.0))
        }
    )*};
}

impl Scalar for CommonRange {
    type Stages<const N: usize> = [Self; N];
    type Mask = KnownTruth;
    type Constant = f64;
    type OfElements<T: Number<f64>> = Self;

    without_derivatives!();

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn from_f64(value: f64) -> Self {
        Self(value)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_constant(constant: f64) -> Self {
        Self(constant)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn to_constant(self) -> f64 {
        self.0
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn magnitude(self) -> f64 {
        self.0.abs()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lane(self, _lane: usize) -> f64 {
        self.0
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn nearly_recip(self) -> Self {
        Self(self.0.nearly_recip())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_identical(self, other: Self) -> bool {
        self.0.is_identical(other.0)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_finite(self) -> KnownTruth {
        KnownTruth::from_bool(self.0.is_finite())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn less(self, other: Self) -> KnownTruth {
        KnownTruth::of(self.0 < other.0, self, other)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn less_equal(self, other: Self) -> KnownTruth {
        KnownTruth::of(self.0 <= other.0, self, other)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn equal(self, other: Self) -> KnownTruth {
        KnownTruth::of(self.0 == other.0, self, other)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn select(mask: KnownTruth, then: Self, otherwise: Self) -> Self {
        let chosen = if mask.truth { then.0 } else { otherwise.0 };
        Self(if mask.is_known { chosen } else { f64::NAN })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn powi(self, exponent: i32) -> Self {
        Self(Scalar::powi(self.0, exponent))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn powf(self, exponent: Self) -> Self {
        Self(elementary::Pow::usual(self.0, exponent.0))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn hypot(self, other: Self) -> Self {
        Self(elementary::Hypot::usual(self.0, other.0))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn atan2(self, other: Self) -> Self {
        Self(elementary::Atan2::usual(self.0, other.0))
    }
    /// Unknown if either is.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn min(self, other: Self) -> Self {
        Self::select(KnownTruth::of(true, self, other), Self(Scalar::min(self.0, other.0)), self)
    }
    /// Unknown if either is.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn max(self, other: Self) -> Self {
        Self::select(KnownTruth::of(true, self, other), Self(Scalar::max(self.0, other.0)), self)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn special(self, function: Special) -> Self {
        Self(function.value(self.0))
    }

    exact!(recip sqrt abs signum);
    unary!(cbrt: Cbrt, exp: Exp, exp2: Exp2, exp_m1: ExpM1, ln: Ln, ln_1p: Ln1p, log2: Log2, log10: Log10);
    unary!(sin: Sin, cos: Cos, tan: Tan, asin: Asin, acos: Acos, atan: Atan);
    unary!(sinh: Sinh, cosh: Cosh, tanh: Tanh, asinh: Asinh, acosh: Acosh, atanh: Atanh);
}
