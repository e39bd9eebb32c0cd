//! Derivatives beside those that are written out.

use super::*;
use crate::algebra::solve::relative_to;

type D = Dual<2>;

/// Every function of one argument: name, the dual one, the value, the derivative as a textbook prints it, a
/// point.
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

/// `d²f/dxdy` of `f(x y)` at `x = at / 2`, `y = 2` is `f'(at) + at f''(at)`, with `f''` as the difference of
/// `f'`.
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
    assert!((relative_to(correction, x) - 1e-2).abs() < 1e-16);
    for hidden in [[f64::NAN, 2.0], [2.0, f64::NAN]] {
        let y = Dual { value: 1.0, derivative: hidden };
        assert!(relative_to(y, x).is_nan() && !y.is_finite());
    }
    assert!(Dual { value: f64::NAN, derivative: [1.0] }.magnitude().is_nan());
    let y = Dual { value: 1.0, derivative: [5.0, 5.0] };
    assert!(x.equal(y) && x.less_equal(y) && !x.less(y));
    assert_eq!(D::select(x.less(y), x, y), y);
    assert_eq!(D::constant(f64::NAN).min(x), x);
    assert_eq!(x.max(D::constant(f64::NAN)), x);
}
