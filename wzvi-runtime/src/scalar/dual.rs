//! Dual numbers `a + b ε` with `ε² = 0`: exact derivatives through any generic computation.
//!
//! With `N` infinitesimals at once, `f(x + ε) = f(x) + f'(x) ε` carries a whole gradient through one run. A part that is
//! exactly zero stays zero through every function, also where the slope is infinite: constants are constants.
//!
//! The parts of a dual number may be dual numbers themselves: `Dual<1, Dual<1>>` carries a second derivative, in the
//! direction of each.

use std::f64::consts::{LN_2, LN_10};
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Number, Scalar};
use crate::numbers::{Numbers, Tape};

/// A number with its partial derivatives in `N` directions.
///
/// Comparisons, [`Scalar::min`] and [`Scalar::max`] go by value. Where a function has a kink, the derivative is that of
/// the branch that `f64` takes (`|x|` at 0 has slope `signum(0.0) = 1`); at the origin `hypot` and `atan2` have none,
/// and the derivative is NaN.
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

    /// Independent variable `index`, with derivative 1 in that direction; a constant if there is no such direction.
    pub fn variable(value: S, index: usize) -> Self {
        Self { value, derivative: std::array::from_fn(|i| S::from_f64(f64::from(i == index))) }
    }

    /// The point `values`, each component its own independent variable.
    pub fn variables(values: [S; N]) -> [Self; N] {
        std::array::from_fn(|i| Self::variable(values[i], i))
    }

    /// `f(self)` from `f(value)` and `f'(value)`.
    #[inline]
    fn chain(self, value: S, slope: S) -> Self {
        Self { value, derivative: self.derivative.map(|d| weigh(d, slope)) }
    }

    /// `f(self, other)` from its value and its two partial derivatives.
    #[inline]
    fn chain2(self, other: Self, value: S, slopes: [S; 2]) -> Self {
        let derivative = std::array::from_fn(|i| {
            weigh(self.derivative[i], slopes[0]) + weigh(other.derivative[i], slopes[1])
        });
        Self { value, derivative }
    }
}

/// `derivative slope`, and 0 for what does not depend on the direction even where the slope is infinite or undefined.
#[inline]
fn weigh<S: Scalar>(derivative: S, slope: S) -> S {
    S::select(derivative.vanishes(), S::from_f64(0.0), derivative * slope)
}

impl<const N: usize, S: Scalar> Neg for Dual<N, S> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { value: -self.value, derivative: self.derivative.map(Neg::neg) }
    }
}

impl<const N: usize, S: Scalar> Add for Dual<N, S> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        self.chain2(other, self.value + other.value, [S::from_f64(1.0); 2])
    }
}

impl<const N: usize, S: Scalar> Sub for Dual<N, S> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self.chain2(other, self.value - other.value, [S::from_f64(1.0), S::from_f64(-1.0)])
    }
}

impl<const N: usize, S: Scalar> Mul for Dual<N, S> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        self.chain2(other, self.value * other.value, [other.value, self.value])
    }
}

impl<const N: usize, S: Scalar> Div for Dual<N, S> {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        self.chain2(other, quotient, [other.value.recip(), -quotient / other.value])
    }
}

impl<const N: usize, S: Scalar> Add<f64> for Dual<N, S> {
    type Output = Self;
    #[inline]
    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl<const N: usize, S: Scalar> Sub<f64> for Dual<N, S> {
    type Output = Self;
    #[inline]
    fn sub(self, other: f64) -> Self {
        Self { value: self.value - other, ..self }
    }
}

impl<const N: usize, S: Scalar> Mul<f64> for Dual<N, S> {
    type Output = Self;
    #[inline]
    fn mul(self, other: f64) -> Self {
        self.chain(self.value * other, S::from_f64(other))
    }
}

impl<const N: usize, S: Scalar> Div<f64> for Dual<N, S> {
    type Output = Self;
    #[inline]
    fn div(self, other: f64) -> Self {
        self.chain(self.value / other, S::from_f64(1.0 / other))
    }
}

/// The largest component, part by part.
fn norm<S: Scalar>(components: &[S]) -> S {
    components.iter().fold(S::from_f64(0.0), |largest, &x| x.larger(largest))
}

impl<const N: usize, S: Scalar> Numbers for Dual<N, S> {
    fn pass(&mut self, tape: &mut Tape) {
        self.value.pass(tape);
        self.derivative.pass(tape);
    }
}

impl<const N: usize, S: Scalar> Scalar for Dual<N, S> {
    type Stages<const M: usize> = [Self; M];
    type Mask = S::Mask;
    const LANES: usize = S::LANES;
    type Solver = crate::solve::Together;
    type OfElements<T: Number<f64>> = Self;

    #[inline]
    fn from_f64(value: f64) -> Self {
        Self::constant(S::from_f64(value))
    }
    #[inline]
    fn magnitude(self) -> f64 {
        self.value.magnitude()
    }
    /// The value against the values, the gradient against the gradients (in the largest norm).
    #[inline]
    fn relative_to(self, other: Self) -> f64 {
        let of_gradient = norm(&self.derivative).relative_to(norm(&other.derivative));
        self.value.relative_to(other.value).larger(of_gradient)
    }
    #[inline]
    fn vanishes(self) -> S::Mask {
        self.derivative.iter().fold(self.value.vanishes(), |all, d| all & d.vanishes())
    }
    #[inline]
    fn is_identical(self, other: Self) -> bool {
        let derivatives = self.derivative.iter().zip(&other.derivative);
        self.value.is_identical(other.value) && derivatives.into_iter().all(|(a, b)| a.is_identical(*b))
    }
    #[inline]
    fn larger(self, other: Self) -> Self {
        Self {
            value: self.value.larger(other.value),
            derivative: std::array::from_fn(|i| self.derivative[i].larger(other.derivative[i])),
        }
    }
    #[inline]
    fn lane(self, lane: usize) -> f64 {
        self.value.lane(lane)
    }
    #[inline]
    fn is_finite(self) -> S::Mask {
        self.derivative.iter().fold(self.value.is_finite(), |all, d| all & d.is_finite())
    }
    #[inline]
    fn less(self, other: Self) -> S::Mask {
        self.value.less(other.value)
    }
    #[inline]
    fn less_equal(self, other: Self) -> S::Mask {
        self.value.less_equal(other.value)
    }
    #[inline]
    fn equal(self, other: Self) -> S::Mask {
        self.value.equal(other.value)
    }
    #[inline]
    fn select(mask: S::Mask, then: Self, otherwise: Self) -> Self {
        Self {
            value: S::select(mask, then.value, otherwise.value),
            derivative: std::array::from_fn(|i| S::select(mask, then.derivative[i], otherwise.derivative[i])),
        }
    }

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
    fn exp(self) -> Self {
        let value = self.value.exp();
        self.chain(value, value)
    }
    fn exp2(self) -> Self {
        let value = self.value.exp2();
        self.chain(value, value * LN_2)
    }
    fn exp_m1(self) -> Self {
        self.chain(self.value.exp_m1(), self.value.exp())
    }
    fn ln(self) -> Self {
        self.chain(self.value.ln(), self.value.recip())
    }
    fn ln_1p(self) -> Self {
        self.chain(self.value.ln_1p(), (self.value + 1.0).recip())
    }
    fn log2(self) -> Self {
        self.chain(self.value.log2(), (self.value * LN_2).recip())
    }
    fn log10(self) -> Self {
        self.chain(self.value.log10(), (self.value * LN_10).recip())
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
        self.chain(value, value * value + 1.0)
    }
    fn asin(self) -> Self {
        self.chain(self.value.asin(), arc_slope(self.value))
    }
    fn acos(self) -> Self {
        self.chain(self.value.acos(), -arc_slope(self.value))
    }
    fn atan(self) -> Self {
        self.chain(self.value.atan(), (self.value * self.value + 1.0).recip())
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
        self.chain(self.value.asinh(), self.value.hypot(S::from_f64(1.0)).recip())
    }
    fn acosh(self) -> Self {
        let x = self.value;
        self.chain(x.acosh(), ((x - 1.0).sqrt() * (x + 1.0).sqrt()).recip())
    }
    fn atanh(self) -> Self {
        let x = self.value;
        self.chain(x.atanh(), one_minus_square(x).recip())
    }
    fn abs(self) -> Self {
        self.chain(self.value.abs(), self.value.signum())
    }
    fn signum(self) -> Self {
        Self::constant(self.value.signum())
    }
    fn min(self, other: Self) -> Self {
        Self::select(self.value.less_equal(other.value) | is_nan(other.value), self, other)
    }
    fn max(self, other: Self) -> Self {
        Self::select(other.value.less_equal(self.value) | is_nan(other.value), self, other)
    }
}

fn is_nan<S: Scalar>(x: S) -> S::Mask {
    !x.equal(x)
}

/// `1 - x²`, factored so that the difference from ±1 keeps its digits.
fn one_minus_square<S: Scalar>(x: S) -> S {
    (-x + 1.0) * (x + 1.0)
}

/// `1/√(1 - x²)`
fn arc_slope<S: Scalar>(x: S) -> S {
    one_minus_square(x).sqrt().recip()
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

    /// `d²f/dxdy` of `f(x y)` at `x = at / 2`, `y = 2` is `f'(at) + at f''(at)`, with `f''` as the difference of `f'`.
    #[test]
    fn dual_numbers_of_dual_numbers_have_second_derivatives() {
        type Second = Dual<1, Dual<1>>;
        #[rustfmt::skip]
        const FUNCTIONS: &[fn(Second) -> Second] = &[
            |x| -x, |x| x + 3.0, |x| x - 3.0, |x| x * 3.0, |x| x / 3.0, Second::recip, |x| x.powi(5), |x| x.powi(1),
            |x| x.powi(0), |x| x.powi(-2), |x| x.powf(Second::from_f64(1.3)), |x| Second::from_f64(2.0).powf(x),
            Second::sqrt, Second::cbrt, Second::exp, Second::exp2, Second::exp_m1, Second::ln, Second::ln_1p, Second::log2,
            Second::log10, Second::sin, Second::cos, |x| x.sin_cos().0, |x| x.sin_cos().1, Second::tan, Second::asin,
            Second::acos, Second::atan, Second::sinh, Second::cosh, Second::tanh, Second::asinh, Second::acosh,
            Second::atanh, Second::abs, Second::signum, |x| x.min(Second::from_f64(3.0)), |x| x.max(Second::from_f64(3.0)),
            |x| Second::from_f64(2.0) / x, |x| x.hypot(Second::from_f64(2.0)), |x| x.atan2(Second::from_f64(-2.0)),
            |x| Second::from_f64(2.0).atan2(x),
        ];
        assert_eq!(FUNCTIONS.len(), CASES.len());
        for (&(name, _, _, derivative, at), function) in CASES.iter().zip(FUNCTIONS) {
            let x = Dual { value: Dual::constant(at / 2.0), derivative: [Dual::constant(1.0)] };
            let y = Dual { value: Dual::variable(2.0, 0), derivative: [Dual::constant(0.0)] };
            let z = function(x * y);
            // The step is as long as rounding and the truncation of the difference weigh the same: 1e-16^(1/3).
            let step = 6e-6 * at.abs();
            let curvature =
                if at == 0.0 { 0.0 } else { (derivative(at + step) - derivative(at - step)) / (2.0 * step) };
            let exact = derivative(at) + at * curvature;
            let mixed = z.derivative[0].derivative[0];
            assert!((mixed - exact).abs() < 1e-8 * (1.0 + exact.abs()), "{name}: {mixed} instead of {exact}");
            assert!(z.is_finite() && !z.vanishes(), "{name}");
        }
        let zero = Dual::<1, Dual<1>>::from_f64(0.0);
        assert!(zero.sqrt().vanishes() && zero.hypot(zero).vanishes());
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
