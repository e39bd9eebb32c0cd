//! Dual numbers `a + b ε` with `ε² = 0`: exact derivatives through any generic computation.
//!
//! With `N` infinitesimals at once, `f(x + ε) = f(x) + f'(x) ε` carries a whole gradient through one run. A
//! part that is exactly zero stays zero through every function, also where the slope is infinite: constants
//! are constants.
//!
//! The parts of a dual number may be dual numbers themselves: `Dual<1, Dual<1>>` carries a second derivative,
//! in the direction of each.

use std::f64::consts::{LN_2, LN_10};
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Number, Scalar, Special};
use crate::ground::numbers::numbers;

/// Functions that numbers with additional parts compute from value and slope alone; `$with` takes these two.
macro_rules! functions_by_slope {
    ($with:ident) => {
        fn exp(self) -> Self {
            let value = Scalar::exp(self.value);
            self.$with(value, value)
        }
        fn exp2(self) -> Self {
            let value = Scalar::exp2(self.value);
            self.$with(value, value * LN_2)
        }
        fn exp_m1(self) -> Self {
            self.$with(Scalar::exp_m1(self.value), Scalar::exp(self.value))
        }
        fn ln(self) -> Self {
            self.$with(Scalar::ln(self.value), self.value.recip())
        }
        fn ln_1p(self) -> Self {
            self.$with(Scalar::ln_1p(self.value), (self.value + 1.0).recip())
        }
        fn log2(self) -> Self {
            self.$with(Scalar::log2(self.value), (self.value * LN_2).recip())
        }
        fn log10(self) -> Self {
            self.$with(Scalar::log10(self.value), (self.value * LN_10).recip())
        }
        fn tan(self) -> Self {
            let value = Scalar::tan(self.value);
            self.$with(value, value * value + 1.0)
        }
        fn atan(self) -> Self {
            self.$with(Scalar::atan(self.value), (self.value * self.value + 1.0).recip())
        }
        fn sinh(self) -> Self {
            self.$with(Scalar::sinh(self.value), Scalar::cosh(self.value))
        }
        fn tanh(self) -> Self {
            // 1/cosh² keeps its digits where 1 - tanh² cancels.
            let secant = Scalar::cosh(self.value).recip();
            self.$with(Scalar::tanh(self.value), secant * secant)
        }
        fn atanh(self) -> Self {
            let x = self.value;
            self.$with(Scalar::atanh(x), one_minus_square(x).recip())
        }
    };
}

pub(super) use functions_by_slope;

/// A number with its partial derivatives in `N` directions.
///
/// Comparisons, [`Scalar::min`] and [`Scalar::max`] go by value. Where a function has a kink, the derivative
/// is that of the branch that `f64` takes (`|x|` at 0 has slope `signum(0.0) = 1`); at the origin `hypot` and
/// `atan2` have none, and the derivative is NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const N: usize, S = f64> {
    /// The number.
    pub value: S,
    /// Its partial derivatives.
    pub derivative: [S; N],
}

impl<const N: usize, S: Scalar> Dual<N, S> {
    /// A number that depends on nothing.
    pub fn constant(value: S) -> Self {
        Self { value, derivative: [S::from_f64(0.0); N] }
    }

    /// Independent variable `index`, with derivative 1 in that direction; a constant if there is no such
    /// direction.
    pub fn variable(value: S, index: usize) -> Self {
        Self { value, derivative: std::array::from_fn(|i| S::from_f64(f64::from(i == index))) }
    }

    /// The point `values`, each component its own independent variable.
    pub fn variables(values: [S; N]) -> [Self; N] {
        std::array::from_fn(|i| Self::variable(values[i], i))
    }

    /// `f(self)` from `f(value)` and `f'(value)`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn chain(self, value: S, slope: S) -> Self {
        let mut derivative = self.derivative;
        for d in &mut derivative {
            *d = weigh(*d, slope);
        }
        Self { value, derivative }
    }

    /// `f(self, other)` from its value and its two partial derivatives.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn chain2(self, other: Self, value: S, slopes: [S; 2]) -> Self {
        let mut derivative = self.derivative;
        for (d, other) in derivative.iter_mut().zip(other.derivative) {
            *d = weigh(*d, slopes[0]) + weigh(other, slopes[1]);
        }
        Self { value, derivative }
    }
}

/// `derivative slope`; 0 for a derivative of zero, even where the slope is infinite or undefined.
#[cfg_attr(not(debug_assertions), inline(always))]
fn weigh<S: Scalar>(derivative: S, slope: S) -> S {
    S::select(derivative.vanishes(), S::from_f64(0.0), derivative * slope)
}

/// Zero.
impl<const N: usize, S: Scalar> Default for Dual<N, S> {
    fn default() -> Self {
        Self::from_f64(0.0)
    }
}

impl<const N: usize, S: Scalar> Neg for Dual<N, S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn neg(self) -> Self {
        let mut derivative = self.derivative;
        for d in &mut derivative {
            *d = -*d;
        }
        Self { value: -self.value, derivative }
    }
}

impl<const N: usize, S: Scalar> Add for Dual<N, S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add(self, other: Self) -> Self {
        self.chain2(other, self.value + other.value, [S::from_f64(1.0); 2])
    }
}

impl<const N: usize, S: Scalar> Sub for Dual<N, S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sub(self, other: Self) -> Self {
        self.chain2(other, self.value - other.value, [S::from_f64(1.0), S::from_f64(-1.0)])
    }
}

impl<const N: usize, S: Scalar> Mul for Dual<N, S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, other: Self) -> Self {
        self.chain2(other, self.value * other.value, [other.value, self.value])
    }
}

impl<const N: usize, S: Scalar> Div for Dual<N, S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        self.chain2(other, quotient, [other.value.recip(), -quotient / other.value])
    }
}

impl<const N: usize, S: Scalar> Add<f64> for Dual<N, S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl<const N: usize, S: Scalar> Sub<f64> for Dual<N, S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sub(self, other: f64) -> Self {
        Self { value: self.value - other, ..self }
    }
}

impl<const N: usize, S: Scalar> Mul<f64> for Dual<N, S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, other: f64) -> Self {
        self.chain(self.value * other, S::from_f64(other))
    }
}

impl<const N: usize, S: Scalar> Div<f64> for Dual<N, S> {
    type Output = Self;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn div(self, other: f64) -> Self {
        self.chain(self.value / other, S::from_f64(1.0 / other))
    }
}

numbers! { impl[const N: usize, S: Scalar] Numbers for Dual<N, S> { kept: value, derivative } }

impl<const N: usize, S: Scalar> Scalar for Dual<N, S> {
    type Stages<const M: usize> = [Self; M];
    type Mask = S::Mask;
    type Constant = Dual<N, S::Constant>;
    const LANES: usize = S::LANES;
    type OfElements<T: Number<f64>> = Self;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn from_f64(value: f64) -> Self {
        Self::constant(S::from_f64(value))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_constant(Dual { value, derivative }: Self::Constant) -> Self {
        Self { value: S::of_constant(value), derivative: derivative.map(S::of_constant) }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn to_constant(self) -> Self::Constant {
        Dual { value: self.value.to_constant(), derivative: self.derivative.map(S::to_constant) }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn magnitude(self) -> f64 {
        self.value.magnitude()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn vanishes(self) -> S::Mask {
        let mut all = self.value.vanishes();
        for d in &self.derivative {
            all = all & d.vanishes();
        }
        all
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_identical(self, other: Self) -> bool {
        let derivatives = self.derivative.iter().zip(&other.derivative);
        self.value.is_identical(other.value) && derivatives.into_iter().all(|(a, b)| a.is_identical(*b))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn larger(self, other: Self) -> Self {
        Self {
            value: self.value.larger(other.value),
            derivative: std::array::from_fn(|i| self.derivative[i].larger(other.derivative[i])),
        }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lane(self, lane: usize) -> f64 {
        self.value.lane(lane)
    }
    const DERIVATIVES: usize = N;
    type Value = S;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn value(self) -> S {
        self.value
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn of_value(value: S) -> Self {
        Self::constant(value)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn derivative(self, number: usize) -> S {
        self.derivative[number]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_derivative(&mut self, number: usize, derivative: S) {
        self.derivative[number] = derivative;
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_finite(self) -> S::Mask {
        let mut all = self.value.is_finite();
        for d in &self.derivative {
            all = all & d.is_finite();
        }
        all
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn less(self, other: Self) -> S::Mask {
        self.value.less(other.value)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn less_equal(self, other: Self) -> S::Mask {
        self.value.less_equal(other.value)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn equal(self, other: Self) -> S::Mask {
        self.value.equal(other.value)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn select(mask: S::Mask, then: Self, otherwise: Self) -> Self {
        Self {
            value: S::select(mask, then.value, otherwise.value),
            derivative: std::array::from_fn(|i| S::select(mask, then.derivative[i], otherwise.derivative[i])),
        }
    }

    functions_by_slope!(chain);

    fn recip(self) -> Self {
        let value = self.value.recip();
        self.chain(value, -value * value)
    }
    fn powi(self, exponent: i32) -> Self {
        let slope = match exponent {
            0 => S::from_f64(0.0),
            1 => S::from_f64(1.0),
            // Saturating: the one exponent that it changes is out of reach of f64 in any case.
            _ => self.value.powi(exponent.saturating_sub(1)) * f64::from(exponent),
        };
        self.chain(self.value.powi(exponent), slope)
    }
    fn powf(self, exponent: Self) -> Self {
        let (x, y) = (self.value, exponent.value);
        let value = x.powf(y);
        let zero = S::from_f64(0.0);
        let by_base = S::select(y.vanishes(), zero, y * x.powf(y - 1.0));
        // x^y ln x → 0 as x → 0 for y > 0.
        let by_exponent = S::select(value.equal(zero) & x.equal(zero), zero, value * x.ln());
        self.chain2(exponent, value, [by_base, by_exponent])
    }
    fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        self.chain(value, S::from_f64(0.5) / value)
    }
    fn cbrt(self) -> Self {
        let value = self.value.cbrt();
        self.chain(value, (value * 3.0 * value).recip())
    }
    fn hypot(self, other: Self) -> Self {
        let value = self.value.hypot(other.value);
        self.chain2(other, value, [self.value / value, other.value / value])
    }
    fn sin(self) -> Self {
        let (sin, cos) = self.value.sin_cos();
        self.chain(sin, cos)
    }
    fn cos(self) -> Self {
        let (sin, cos) = self.value.sin_cos();
        self.chain(cos, -sin)
    }
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.value.sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }
    fn asin(self) -> Self {
        self.chain(self.value.asin(), arc_slope(self.value))
    }
    fn acos(self) -> Self {
        self.chain(self.value.acos(), -arc_slope(self.value))
    }
    fn atan2(self, other: Self) -> Self {
        let (y, x) = (self.value, other.value);
        let radius = y.hypot(x);
        self.chain2(other, y.atan2(x), [x / radius / radius, -y / radius / radius])
    }
    fn cosh(self) -> Self {
        self.chain(self.value.cosh(), self.value.sinh())
    }
    fn asinh(self) -> Self {
        self.chain(self.value.asinh(), self.value.hypot(S::from_f64(1.0)).recip())
    }
    fn acosh(self) -> Self {
        let x = self.value;
        self.chain(x.acosh(), ((x - 1.0).sqrt() * (x + 1.0).sqrt()).recip())
    }
    fn special(self, function: Special) -> Self {
        self.chain(self.value.special(function), function.slope(self.value))
    }
    fn abs(self) -> Self {
        self.chain(self.value.abs(), self.value.signum())
    }
    fn signum(self) -> Self {
        Self::constant(self.value.signum())
    }
}

/// `1 - x²`, factored so that the difference from ±1 keeps its digits.
pub(super) fn one_minus_square<S: Scalar>(x: S) -> S {
    (-x + 1.0) * (x + 1.0)
}

/// `1/√(1 - x²)`
fn arc_slope<S: Scalar>(x: S) -> S {
    one_minus_square(x).sqrt().recip()
}

#[cfg(test)]
mod tests;
