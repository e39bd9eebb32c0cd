//! Hyperbolic functions and their inverses, from `e^x - 1` and `ln(1 + x)`.

use super::exponential::{exp, exp_m1};
use super::logarithm::ln_1p;
use super::{functions, select};

functions! {
    /// Hyperbolic sine.
    Sinh(x): sinh(x), where x.abs() <= 708.0, else libm::sinh;
    /// Hyperbolic cosine.
    Cosh(x): cosh(x), where x.abs() <= 708.0, else libm::cosh;
    /// Hyperbolic tangent.
    Tanh(x): tanh(x), where x.abs() <= f64::INFINITY, else libm::tanh;
    /// Inverse hyperbolic sine.
    Asinh(x): asinh(x), where x.abs() <= 1e8, else libm::asinh;
    /// Inverse hyperbolic cosine.
    Acosh(x): acosh(x), where (1.0..1e8).contains(&x), else libm::acosh;
    /// Inverse hyperbolic tangent.
    Atanh(x): atanh(x), where x.abs() < 1.0, else libm::atanh;
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn sinh(x: f64) -> f64 {
    let size = x.abs();
    let t = exp_m1(size);
    let ratio = t / (t + 1.0);
    let doubled = select(size < 1.0, 2.0 * t - t * ratio, t + ratio);
    (0.5 * doubled).copysign(x)
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn cosh(x: f64) -> f64 {
    let e = exp(x.abs());
    0.5 * (e + 1.0 / e)
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn tanh(x: f64) -> f64 {
    // One to the last digit from here on.
    let size = select(x.abs() < 22.0, x.abs(), 22.0);
    let (is_large, is_middle) = (size > 0.549_306, size > 0.255_412);
    let t = exp_m1(select(is_middle, 2.0, -2.0) * size);
    let ratio = select(is_large, 2.0, select(is_middle, t, -t)) / (t + 2.0);
    select(is_large, 1.0 - ratio, ratio).copysign(x)
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn asinh(x: f64) -> f64 {
    let size = x.abs();
    let square = size * size;
    ln_1p(size + square / ((square + 1.0).sqrt() + 1.0)).copysign(x)
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn acosh(x: f64) -> f64 {
    let above = x - 1.0;
    ln_1p(above + (above * above + 2.0 * above).sqrt())
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn atanh(x: f64) -> f64 {
    let size = x.abs();
    let ratio = size / (1.0 - size);
    let argument = select(size < 0.5, 2.0 * size + 2.0 * size * ratio, 2.0 * ratio);
    (0.5 * ln_1p(argument)).copysign(x)
}
