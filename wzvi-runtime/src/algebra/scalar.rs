//! The number type that generated steps are generic over.
//!
//! One emitted step serves `f64`, dual numbers (tests, sensitivities) and lanes of trajectories.

mod constant;
mod dual;
mod failed;
mod rounded;
mod special;

use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

pub use constant::{
    ComputesWith, Constant, Constants, ConstantsIn, Factored, Parameters, Reals, Truths, Varied,
};
pub use dual::Dual;
pub use rounded::Rounded;
pub use special::Special;

use super::stages::Stages;
use crate::algebra::lanes::{Lanes, elementary};
use crate::error::FailedLanes;
use crate::ground::numbers::Numbers;

/// The truth of a comparison: `bool` for one number, a mask for several at once.
pub trait Mask:
    Copy + Debug + Numbers + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// True in the lanes for which it holds.
    fn of_lanes(holds: impl FnMut(usize) -> bool) -> Self;
    /// One truth for all lanes.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn from_bool(truth: bool) -> Self {
        Self::of_lanes(|_| truth)
    }
    /// Whether every lane is true.
    fn all(self) -> bool;
    /// Whether any lane is true.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn any(self) -> bool {
        !(!self).all()
    }
    /// The truth of one lane.
    fn lane(self, lane: usize) -> bool;
    /// One value of any type for each lane.
    type ByLane<T>: AsMut<[T]>;
    /// The values of a function for each lane.
    fn by_lane<T>(of: impl FnMut(usize) -> T) -> Self::ByLane<T>;
}

impl Mask for bool {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_lanes(mut holds: impl FnMut(usize) -> bool) -> Self {
        holds(0)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn all(self) -> bool {
        self
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lane(self, _lane: usize) -> bool {
        self
    }
    type ByLane<T> = [T; 1];
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn by_lane<T>(mut of: impl FnMut(usize) -> T) -> [T; 1] {
        [of(0)]
    }
}

/// A real number as generated code computes with it.
///
/// Functions have the meaning and the domain of the methods of `f64` with the same name.
#[rustfmt::skip]
pub trait Scalar:
    Copy + Debug + Default + Numbers + 'static + Neg<Output = Self>
    + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
    + Add<f64, Output = Self> + Sub<f64, Output = Self> + Mul<f64, Output = Self> + Div<f64, Output = Self>
{
    /// The truth of a comparison.
    type Mask: Mask;
    /// One number for each of the `N` stages of a step.
    type Stages<const N: usize>: Stages<Self, N>;
    /// Numbers that are the same in all lanes: parameters, times and step sizes. With derivatives where the
    /// type has them.
    type Constant: Constant<Mask = bool, Constant = Self::Constant>;
    /// The type of the number without its derivatives: the type itself where it has none.
    type Value: Scalar<Mask = Self::Mask>;
    /// The number type in which elements of such vectors are evaluated: `T` for `f64`, else the type itself.
    type OfElements<T: Number<f64>>: Number<Self>;

    /// False if the type cannot be `f64`: then nothing is compiled for lists of `f64`.
    #[doc(hidden)]
    const MAY_BE_F64: bool = size_of::<Self>() == size_of::<f64>();
    /// A list of such numbers, if they are `f64`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn as_f64s(_list: &[Self]) -> Option<&[f64]> {
        None
    }
    /// A list of such numbers to be written, if they are `f64`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn as_f64s_mut(_list: &mut [Self]) -> Option<&mut [f64]> {
        None
    }

    /// A constant.
    fn from_f64(value: f64) -> Self;
    /// A constant with its derivatives.
    fn of_constant(constant: Self::Constant) -> Self;
    /// The constant of the first lane.
    fn to_constant(self) -> Self::Constant;
    /// The absolute value of the number itself, without derivatives; the largest of several lanes.
    fn magnitude(self) -> f64;
    /// Numbers that it holds side by side.
    const LANES: usize = 1;
    /// Whether the lanes are independent paths.
    const LANES_ARE_PATHS: bool = false;
    /// Whether some of them take a step that others cannot: a [set](FailedLanes) says which.
    const MAY_FAIL_BY_LANE: bool = Self::LANES_ARE_PATHS && 1 < Self::LANES && Self::LANES <= FailedLanes::MOST;

    /// The number of one lane, without derivatives.
    fn lane(self, lane: usize) -> f64;
    /// Derivatives that it carries.
    const DERIVATIVES: usize = 0;
    /// Whether it carries derivatives of type `f64`.
    const IS_PLAIN_DUAL: bool = Self::DERIVATIVES > 0 && size_of::<Self::Value>() == size_of::<f64>();
    /// The number without its derivatives.
    fn value(self) -> Self::Value;
    /// The number with this value, and derivatives of zero where it has some.
    fn of_value(value: Self::Value) -> Self;
    /// One of its derivatives.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn derivative(self, _number: usize) -> Self::Value {
        Self::Value::from_f64(0.0)
    }
    /// Replaces one of them.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_derivative(&mut self, _number: usize, _derivative: Self::Value) {}
    /// Its derivatives with the value 0.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn infinitesimal(self) -> Self {
        self - Self::of_value(self.value())
    }
    /// True in the lanes in which every part of the number is zero.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn vanishes(self) -> Self::Mask {
        self.equal(Self::from_f64(0.0))
    }
    /// The larger absolute value, part by part; NaN where either is.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn larger(self, other: Self) -> Self {
        let (own, other) = (self.abs(), other.abs());
        Self::select(own.less(other) | !other.equal(other), other, own)
    }
    /// Whether both are the same to the last bit, in every part (derivatives, lanes).
    fn is_identical(self, other: Self) -> bool;
    /// True in the lanes in which every part of the number is finite.
    fn is_finite(self) -> Self::Mask;
    /// True in the lanes in which every part of the first number of each pair is finite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn are_finite<const N: usize>(pairs: [[(Self, Self); N]; 2]) -> Self::Mask {
        let mut all = Self::Mask::from_bool(true);
        for pairs in &pairs {
            for (x, _) in pairs {
                all = all & x.is_finite();
            }
        }
        all
    }
    /// Each of several numbers times a constant of its own.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn weighted<const N: usize>(mut numbers: [Self; N], weights: &[f64; N]) -> [Self; N] {
        for (number, weight) in numbers.iter_mut().zip(weights) {
            *number = *number * *weight;
        }
        numbers
    }
    /// `self < other`
    fn less(self, other: Self) -> Self::Mask;
    /// `self <= other`
    fn less_equal(self, other: Self) -> Self::Mask;
    /// `self == other`
    fn equal(self, other: Self) -> Self::Mask;
    /// `if mask { then } else { otherwise }`, by lane.
    fn select(mask: Self::Mask, then: Self, otherwise: Self) -> Self;

    /// `1 / self`
    fn recip(self) -> Self;
    /// `1 / |self|` within a nineteenth, with any sign: finite for zero, and not defined for sizes above
    /// `8.5e307`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn nearly_recip(self) -> Self {
        (self.abs() + f64::MIN_POSITIVE).recip()
    }
    /// `self^exponent` for an integer exponent.
    fn powi(self, exponent: i32) -> Self;
    /// `self^exponent`
    fn powf(self, exponent: Self) -> Self;
    /// `√self`
    fn sqrt(self) -> Self;
    /// `∛self`
    fn cbrt(self) -> Self;
    /// `√(self² + other²)` without overflow.
    fn hypot(self, other: Self) -> Self;
    /// `e^self`
    fn exp(self) -> Self;
    /// `2^self`
    fn exp2(self) -> Self;
    /// `e^self - 1`
    fn exp_m1(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// `ln(1 + self)`
    fn ln_1p(self) -> Self;
    /// Logarithm to base 2.
    fn log2(self) -> Self;
    /// Logarithm to base 10.
    fn log10(self) -> Self;
    /// Sine.
    fn sin(self) -> Self;
    /// Cosine.
    fn cos(self) -> Self;
    /// Sine and cosine.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sin_cos(self) -> (Self, Self) {
        (self.sin(), self.cos())
    }
    /// Tangent.
    fn tan(self) -> Self;
    /// Arc sine.
    fn asin(self) -> Self;
    /// Arc cosine.
    fn acos(self) -> Self;
    /// Arc tangent.
    fn atan(self) -> Self;
    /// The angle of the point (`other`, `self`).
    fn atan2(self, other: Self) -> Self;
    /// Hyperbolic sine.
    fn sinh(self) -> Self;
    /// Hyperbolic cosine.
    fn cosh(self) -> Self;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// Inverse hyperbolic sine.
    fn asinh(self) -> Self;
    /// Inverse hyperbolic cosine.
    fn acosh(self) -> Self;
    /// Inverse hyperbolic tangent.
    fn atanh(self) -> Self;
    /// A function that `f64` does not have: of numbers and of lanes the same bits.
    fn special(self, function: Special) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The sign: 1 or -1.
    fn signum(self) -> Self;
    /// The smaller of two, and not NaN where one of them is a number. It is the first of two
    /// zeros: `f64::min` takes one that depends on the machine.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn min(self, other: Self) -> Self {
        Self::select(self.less_equal(other) | !other.equal(other), self, other)
    }
    /// The larger of two, as [`Scalar::min`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn max(self, other: Self) -> Self {
        Self::select(other.less_equal(self) | !other.equal(other), self, other)
    }
}

/// The number type of computations on values that are stored as `S`.
pub trait Number<S: Scalar>: Scalar<Constant = S::Constant> {
    /// Whether functions are NaN for some arguments where they have a value.
    const IS_PARTIAL: bool = false;
    /// The number of a stored value.
    fn of(kept: S) -> Self;
    /// As it is kept.
    fn kept(self) -> S;
}

impl<S: Scalar> Number<S> for S {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of(kept: S) -> S {
        kept
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn kept(self) -> S {
        self
    }
}

/// The value of a number that carries no derivatives.
macro_rules! without_derivatives {
    () => {
        type Value = Self;

        #[cfg_attr(not(debug_assertions), inline(always))]
        fn value(self) -> Self {
            self
        }
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn of_value(value: Self) -> Self {
            value
        }
    };
}
pub(in crate::algebra) use without_derivatives;

/// Operations of IEEE 754, which are the same on every machine.
macro_rules! exact {
    ($($function:ident)*) => { $(#[cfg_attr(not(debug_assertions), inline(always))] fn $function(self) -> Self { f64::$function(self) })* };
}

macro_rules! elementary {
    ($($method:ident: $function:ident),*) => {$(
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn $method(self) -> Self {
            elementary::$function::alone(self)
        }
    )*};
}

/// With the elementary functions of [`Lanes`], so that a number alone has the bits of a lane.
impl Scalar for f64 {
    type Mask = bool;
    type Constant = Self;
    type Stages<const N: usize> = Lanes<N>;
    type OfElements<T: Number<f64>> = T;

    without_derivatives!();

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn as_f64s(list: &[f64]) -> Option<&[f64]> {
        Some(list)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn as_f64s_mut(list: &mut [f64]) -> Option<&mut [f64]> {
        Some(list)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn from_f64(value: f64) -> Self {
        value
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_constant(constant: f64) -> Self {
        constant
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn to_constant(self) -> f64 {
        self
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn magnitude(self) -> f64 {
        self.abs()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lane(self, _lane: usize) -> f64 {
        self
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_identical(self, other: Self) -> bool {
        self.to_bits() == other.to_bits()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }
    /// Zero times finite numbers is zero, and NaN otherwise: one test for all.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn are_finite<const N: usize>(pairs: [[(Self, Self); N]; 2]) -> bool {
        let mut zero = 0.0;
        for pairs in &pairs {
            for (x, _) in pairs {
                zero *= x;
            }
        }
        !zero.is_nan()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn less(self, other: Self) -> bool {
        self < other
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn less_equal(self, other: Self) -> bool {
        self <= other
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn equal(self, other: Self) -> bool {
        self == other
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn select(mask: bool, then: Self, otherwise: Self) -> Self {
        if mask { then } else { otherwise }
    }

    exact!(recip sqrt abs signum);
    elementary!(cbrt: Cbrt, exp: Exp, exp2: Exp2, exp_m1: ExpM1, ln: Ln, ln_1p: Ln1p, log2: Log2, log10: Log10);
    elementary!(sin: Sin, cos: Cos, tan: Tan, asin: Asin, acos: Acos, atan: Atan);
    elementary!(sinh: Sinh, cosh: Cosh, tanh: Tanh, asinh: Asinh, acosh: Acosh, atanh: Atanh);

    /// The bits of a number are nearly its logarithm. At most `1.9 / f64::MIN_POSITIVE`, for zero.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn nearly_recip(self) -> Self {
        const TWICE_ONE: u64 = 0x7fde_6238_22fc_16e6;
        Self::from_bits(TWICE_ONE.wrapping_sub(self.to_bits()))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sin_cos(self) -> (Self, Self) {
        elementary::sin_cos_alone(self)
    }
    #[inline]
    fn special(self, function: Special) -> Self {
        function.value(self)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn powi(self, exponent: i32) -> Self {
        powi(self, exponent)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn powf(self, exponent: Self) -> Self {
        elementary::Pow::alone(self, exponent)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn hypot(self, other: Self) -> Self {
        elementary::Hypot::alone(self, other)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn atan2(self, other: Self) -> Self {
        elementary::Atan2::alone(self, other)
    }
}

/// By squaring, from the last bit of the exponent on; a negative exponent takes the reciprocal of the result.
/// `f64::powi` multiplies in an order that depends on the compiler.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(in crate::algebra) fn powi<S: Scalar>(x: S, exponent: i32) -> S {
    let mut rest = exponent.unsigned_abs();
    let (mut power, mut square) = (S::from_f64(1.0), x);
    loop {
        if rest & 1 == 1 {
            power = power * square;
        }
        rest >>= 1;
        if rest == 0 {
            break;
        }
        square = square * square;
    }
    if exponent < 0 { power.recip() } else { power }
}

/// The larger of two; NaN if either is, unlike `f64::max`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}
