//! Dual numbers `a + b ε` with `ε² = 0`: exact derivatives through any generic computation.
//!
//! With `N` infinitesimals at once, `f(x + ε) = f(x) + f'(x) ε` carries a whole gradient through one run. A part that is
//! exactly zero stays zero through every function, also where the slope is infinite: constants are constants.

use std::f64::consts::{LN_2, LN_10};
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::Scalar;
use crate::numbers::{Numbers, Tape};

/// A number with its partial derivatives in `N` directions.
///
/// Comparisons, [`Scalar::min`] and [`Scalar::max`] go by value. Where a function has a kink, the derivative is that of
/// the branch that `f64` takes (`|x|` at 0 has slope `signum(0.0) = 1`); at the origin `hypot` and `atan2` have none,
/// and the derivative is NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const N: usize> {
    /// The number.
    pub value: f64,
    /// Its partial derivatives.
    pub derivative: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// A number that depends on nothing.
    pub const fn constant(value: f64) -> Self {
        Self { value, derivative: [0.0; N] }
    }

    /// Independent variable `index`, with derivative 1 in that direction; a constant if there is no such direction.
    pub fn variable(value: f64, index: usize) -> Self {
        Self { value, derivative: std::array::from_fn(|i| if i == index { 1.0 } else { 0.0 }) }
    }

    /// The point `values`, each component its own independent variable.
    pub fn variables(values: [f64; N]) -> [Self; N] {
        std::array::from_fn(|i| Self::variable(values[i], i))
    }

    /// `f(self)` from `f(value)` and `f'(value)`.
    #[inline]
    fn chain(self, value: f64, slope: f64) -> Self {
        Self { value, derivative: self.derivative.map(|d| weigh(d, slope)) }
    }

    /// `f(self, other)` from its value and its two partial derivatives.
    #[inline]
    fn chain2(self, other: Self, value: f64, slopes: [f64; 2]) -> Self {
        let derivative = std::array::from_fn(|i| {
            weigh(self.derivative[i], slopes[0]) + weigh(other.derivative[i], slopes[1])
        });
        Self { value, derivative }
    }
}

/// `derivative slope`, and 0 for what does not depend on the direction even where the slope is infinite or undefined.
#[inline]
fn weigh(derivative: f64, slope: f64) -> f64 {
    if derivative == 0.0 { 0.0 } else { derivative * slope }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { value: -self.value, derivative: self.derivative.map(Neg::neg) }
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        self.chain2(other, self.value + other.value, [1.0, 1.0])
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self.chain2(other, self.value - other.value, [1.0, -1.0])
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        self.chain2(other, self.value * other.value, [other.value, self.value])
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        self.chain2(other, quotient, [1.0 / other.value, -quotient / other.value])
    }
}

impl<const N: usize> Add<f64> for Dual<N> {
    type Output = Self;
    #[inline]
    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl<const N: usize> Sub<f64> for Dual<N> {
    type Output = Self;
    #[inline]
    fn sub(self, other: f64) -> Self {
        Self { value: self.value - other, ..self }
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;
    #[inline]
    fn mul(self, other: f64) -> Self {
        self.chain(self.value * other, other)
    }
}

impl<const N: usize> Div<f64> for Dual<N> {
    type Output = Self;
    #[inline]
    fn div(self, other: f64) -> Self {
        self.chain(self.value / other, 1.0 / other)
    }
}

/// The larger of two; NaN if either is, unlike `f64::max`.
fn larger(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

fn norm(components: &[f64]) -> f64 {
    components.iter().fold(0.0, |largest, x| larger(x.abs(), largest))
}

impl<const N: usize> Numbers for Dual<N> {
    fn pass(&mut self, tape: &mut Tape) {
        self.value.pass(tape);
        self.derivative.pass(tape);
    }
}

impl<const N: usize> Scalar for Dual<N> {
    type Stages<const M: usize> = [Self; M];
    type Mask = bool;
    type Solver = crate::solve::Together;

    #[inline]
    fn from_f64(value: f64) -> Self {
        Self::constant(value)
    }
    #[inline]
    fn magnitude(self) -> f64 {
        self.value.abs()
    }
    /// The value against the values, the gradient against the gradients (in the largest norm).
    #[inline]
    fn relative_to(self, other: Self) -> f64 {
        let of_gradient = norm(&self.derivative).relative_to(norm(&other.derivative));
        larger(self.value.relative_to(other.value), of_gradient)
    }
    #[inline]
    fn is_identical(self, other: Self) -> bool {
        let derivatives = self.derivative.iter().zip(&other.derivative);
        self.value.is_identical(other.value) && derivatives.into_iter().all(|(a, b)| a.is_identical(*b))
    }
    #[inline]
    fn lane(self, _lane: usize) -> f64 {
        self.value
    }
    #[inline]
    fn is_finite(self) -> bool {
        self.value.is_finite() && self.derivative.iter().all(|d| d.is_finite())
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

    fn recip(self) -> Self {
        let value = self.value.recip();
        self.chain(value, -value * value)
    }
    fn powi(self, exponent: i32) -> Self {
        let slope = match exponent {
            0 => 0.0,
            1 => 1.0,
            // Saturating: the one exponent that it changes is out of reach of f64 in any case.
            _ => f64::from(exponent) * self.value.powi(exponent.saturating_sub(1)),
        };
        self.chain(self.value.powi(exponent), slope)
    }
    fn powf(self, exponent: Self) -> Self {
        let (x, y) = (self.value, exponent.value);
        let value = x.powf(y);
        let by_base = if y == 0.0 { 0.0 } else { y * x.powf(y - 1.0) };
        // x^y ln x → 0 as x → 0 for y > 0.
        let by_exponent = if value == 0.0 && x == 0.0 { 0.0 } else { value * x.ln() };
        self.chain2(exponent, value, [by_base, by_exponent])
    }
    fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        self.chain(value, 0.5 / value)
    }
    fn cbrt(self) -> Self {
        let value = self.value.cbrt();
        self.chain(value, 1.0 / (3.0 * value * value))
    }
    fn hypot(self, other: Self) -> Self {
        let value = self.value.hypot(other.value);
        self.chain2(other, value, [self.value / value, other.value / value])
    }
    fn exp(self) -> Self {
        let value = self.value.exp();
        self.chain(value, value)
    }
    fn exp2(self) -> Self {
        let value = self.value.exp2();
        self.chain(value, LN_2 * value)
    }
    fn exp_m1(self) -> Self {
        self.chain(self.value.exp_m1(), self.value.exp())
    }
    fn ln(self) -> Self {
        self.chain(self.value.ln(), self.value.recip())
    }
    fn ln_1p(self) -> Self {
        self.chain(self.value.ln_1p(), (1.0 + self.value).recip())
    }
    fn log2(self) -> Self {
        self.chain(self.value.log2(), (LN_2 * self.value).recip())
    }
    fn log10(self) -> Self {
        self.chain(self.value.log10(), (LN_10 * self.value).recip())
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
    fn tan(self) -> Self {
        let value = self.value.tan();
        self.chain(value, 1.0 + value * value)
    }
    fn asin(self) -> Self {
        self.chain(self.value.asin(), arc_slope(self.value))
    }
    fn acos(self) -> Self {
        self.chain(self.value.acos(), -arc_slope(self.value))
    }
    fn atan(self) -> Self {
        self.chain(self.value.atan(), (1.0 + self.value * self.value).recip())
    }
    fn atan2(self, other: Self) -> Self {
        let (y, x) = (self.value, other.value);
        let radius = y.hypot(x);
        self.chain2(other, y.atan2(x), [x / radius / radius, -y / radius / radius])
    }
    fn sinh(self) -> Self {
        self.chain(self.value.sinh(), self.value.cosh())
    }
    fn cosh(self) -> Self {
        self.chain(self.value.cosh(), self.value.sinh())
    }
    fn tanh(self) -> Self {
        // 1/cosh² keeps its digits where 1 - tanh² cancels.
        let secant = self.value.cosh().recip();
        self.chain(self.value.tanh(), secant * secant)
    }
    fn asinh(self) -> Self {
        self.chain(self.value.asinh(), self.value.hypot(1.0).recip())
    }
    fn acosh(self) -> Self {
        let x = self.value;
        self.chain(x.acosh(), ((x - 1.0).sqrt() * (x + 1.0).sqrt()).recip())
    }
    fn atanh(self) -> Self {
        let x = self.value;
        self.chain(x.atanh(), ((1.0 - x) * (1.0 + x)).recip())
    }
    fn abs(self) -> Self {
        self.chain(self.value.abs(), self.value.signum())
    }
    fn signum(self) -> Self {
        Self::constant(self.value.signum())
    }
    fn min(self, other: Self) -> Self {
        if self.value <= other.value || other.value.is_nan() { self } else { other }
    }
    fn max(self, other: Self) -> Self {
        if self.value >= other.value || other.value.is_nan() { self } else { other }
    }
}

/// `1/√(1 - x²)`, factored so that the difference from ±1 keeps its digits.
fn arc_slope(x: f64) -> f64 {
    ((1.0 - x) * (1.0 + x)).sqrt().recip()
}

#[cfg(test)]
mod tests {
    use super::*;

    type D = Dual<2>;

    /// Every function of one argument: name, the dual one, the value, the derivative as a textbook prints it, a point.
    type Case = (&'static str, fn(D) -> D, fn(f64) -> f64, fn(f64) -> f64, f64);

    #[rustfmt::skip]
    const CASES: &[Case] = &[
        ("neg", |x| -x, |x| -x, |_| -1.0, 0.7),
        ("+", |x| x + 3.0, |x| x + 3.0, |_| 1.0, 0.7),
        ("-", |x| x - 3.0, |x| x - 3.0, |_| 1.0, 0.7),
        ("*", |x| x * 3.0, |x| x * 3.0, |_| 3.0, 0.7),
        ("/", |x| x / 3.0, |x| x / 3.0, |_| 1.0 / 3.0, 0.7),
        ("recip", D::recip, f64::recip, |x| -1.0 / (x * x), 0.7),
        ("powi 5", |x| x.powi(5), |x| x.powi(5), |x| 5.0 * x.powi(4), -0.7),
        ("powi 1", |x| x.powi(1), |x| x, |_| 1.0, 0.0),
        ("powi 0", |x| x.powi(0), |_| 1.0, |_| 0.0, 0.0),
        ("powi -2", |x| x.powi(-2), |x| x.powi(-2), |x| -2.0 / (x * x * x), 0.7),
        ("powf", |x| x.powf(D::constant(1.3)), |x| x.powf(1.3), |x| 1.3 * x.powf(0.3), 0.7),
        ("2^x", |x| D::constant(2.0).powf(x), |x| 2f64.powf(x), |x| LN_2 * x.exp2(), 0.7),
        ("sqrt", D::sqrt, f64::sqrt, |x| 1.0 / (2.0 * x.sqrt()), 0.7),
        ("cbrt", D::cbrt, f64::cbrt, |x| x.cbrt() / (3.0 * x), -0.7),
        ("exp", D::exp, f64::exp, f64::exp, 0.7),
        ("exp2", D::exp2, f64::exp2, |x| LN_2 * x.exp2(), 0.7),
        ("exp_m1", D::exp_m1, f64::exp_m1, f64::exp, 1e-9),
        ("ln", D::ln, f64::ln, |x| 1.0 / x, 0.7),
        ("ln_1p", D::ln_1p, f64::ln_1p, |x| 1.0 / (1.0 + x), 1e-9),
        ("log2", D::log2, f64::log2, |x| 1.0 / (LN_2 * x), 0.7),
        ("log10", D::log10, f64::log10, |x| 1.0 / (LN_10 * x), 0.7),
        ("sin", D::sin, f64::sin, f64::cos, 0.7),
        ("cos", D::cos, f64::cos, |x| -x.sin(), 0.7),
        ("sin_cos.0", |x| x.sin_cos().0, f64::sin, f64::cos, 0.7),
        ("sin_cos.1", |x| x.sin_cos().1, f64::cos, |x| -x.sin(), 0.7),
        ("tan", D::tan, f64::tan, |x| x.cos().powi(-2), 0.7),
        ("asin", D::asin, f64::asin, |x| 1.0 / (1.0 - x * x).sqrt(), 0.7),
        ("acos", D::acos, f64::acos, |x| -1.0 / (1.0 - x * x).sqrt(), 0.7),
        ("atan", D::atan, f64::atan, |x| 1.0 / (1.0 + x * x), 0.7),
        ("sinh", D::sinh, f64::sinh, f64::cosh, 0.7),
        ("cosh", D::cosh, f64::cosh, f64::sinh, 0.7),
        ("tanh", D::tanh, f64::tanh, |x| 1.0 - x.tanh().powi(2), 0.7),
        ("asinh", D::asinh, f64::asinh, |x| 1.0 / (x * x + 1.0).sqrt(), -0.7),
        ("acosh", D::acosh, f64::acosh, |x| 1.0 / (x * x - 1.0).sqrt(), 1.7),
        ("atanh", D::atanh, f64::atanh, |x| 1.0 / (1.0 - x * x), 0.7),
        ("abs", D::abs, f64::abs, |_| -1.0, -0.7),
        ("signum", D::signum, f64::signum, |_| 0.0, -0.7),
        ("min", |x| x.min(D::constant(3.0)), |x| x, |_| 1.0, 0.7),
        ("max", |x| x.max(D::constant(3.0)), |_| 3.0, |_| 0.0, 0.7),
        ("/ dual", |x| D::constant(2.0) / x, |x| 2.0 / x, |x| -2.0 / (x * x), 0.7),
        ("hypot", |x| x.hypot(D::constant(2.0)), |x| x.hypot(2.0), |x| x / x.hypot(2.0), 0.7),
        ("atan2 y", |y| y.atan2(D::constant(-2.0)), |y| y.atan2(-2.0), |y| -2.0 / (4.0 + y * y), 0.7),
        ("atan2 x", |x| D::constant(2.0).atan2(x), |x| 2f64.atan2(x), |x| -2.0 / (4.0 + x * x), 0.7),
    ];

    /// A few roundings of each side.
    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() <= 16.0 * f64::EPSILON * (1.0 + b.abs())
    }

    #[test]
    fn every_function_has_its_textbook_derivative() {
        for &(name, dual, value, derivative, x) in CASES {
            let y = dual(D::variable(x, 1));
            // `powi` may round differently from call to call on some targets; everything else is the same call.
            assert!(close(y.value, value(x)), "{name}: {y:?}");
            assert!(close(y.derivative[1], derivative(x)), "{name}: {y:?} instead of {}", derivative(x));
            assert_eq!(y.derivative[0], 0.0, "{name}");
        }
    }

    #[test]
    fn every_function_obeys_the_chain_rule() {
        // u = x₀ (x₁ + 2) through the point of the case: df = f'(u) du.
        for &(name, dual, _, derivative, at) in CASES {
            let [x, y] = Dual::variables([at / 4.0, 2.0]);
            let z = dual(x * (y + 2.0));
            assert!(close(z.derivative[0], 4.0 * derivative(at)), "{name}: {z:?}");
            assert!(close(z.derivative[1], at / 4.0 * derivative(at)), "{name}: {z:?}");
        }
    }

    #[test]
    fn products_and_quotients_of_two_variables() {
        let [x, y] = Dual::variables([3.0, -2.0]);
        assert_eq!((x * y).derivative, [-2.0, 3.0]);
        assert_eq!((x / y).derivative, [-0.5, -0.75]);
        assert_eq!((x - y).derivative, [1.0, -1.0]);
        let power = x.powf(y);
        assert!(close(power.derivative[0], -2.0 / 27.0) && close(power.derivative[1], 3f64.ln() / 9.0));
    }

    #[test]
    fn constants_stay_constants_where_slopes_are_infinite() {
        let zero = D::constant(0.0);
        for y in [zero.sqrt(), zero.cbrt(), zero.hypot(zero), zero.powf(D::constant(0.5)), zero.atan2(zero)] {
            assert_eq!(y.derivative, [0.0; 2]);
        }
        assert!(!D::variable(0.0, 0).sqrt().is_finite());
        assert_eq!(zero.powf(D::variable(2.0, 0)).derivative, [0.0; 2]);
    }

    #[test]
    fn size_and_order_see_what_they_should() {
        let x = Dual { value: 1.0, derivative: [-3.0, 2.0] };
        assert_eq!(x.magnitude(), 1.0);
        assert!(x.is_finite());
        let correction = Dual { value: 1e-3, derivative: [0.0, 3e-2] };
        assert!((correction.relative_to(x) - 1e-2).abs() < 1e-16);
        for hidden in [[f64::NAN, 2.0], [2.0, f64::NAN]] {
            let y = Dual { value: 1.0, derivative: hidden };
            assert!(y.relative_to(x).is_nan() && !y.is_finite());
        }
        assert!(Dual { value: f64::NAN, derivative: [1.0] }.magnitude().is_nan());
        let y = Dual { value: 1.0, derivative: [5.0, 5.0] };
        assert!(x.equal(y) && x.less_equal(y) && !x.less(y));
        assert_eq!(D::select(x.less(y), x, y), y);
        assert_eq!(D::constant(f64::NAN).min(x), x);
        assert_eq!(x.max(D::constant(f64::NAN)), x);
    }
}
