//! The elementary functions of lanes over their whole range against arithmetic of 256 bits.
//!
//! The bounds are those of the table in the documentation of `wzvi_runtime::algebra::lanes`. With `WZVI_SAMPLES=1000000` in the
//! environment every function is measured at so many arguments per range, and `--nocapture` prints what was found.

use crate::real::{Real, error_in_ulps, with_precision};
use wzvi_runtime::algebra::lanes::Lanes;
use wzvi_runtime::algebra::scalar::Scalar;

const L: usize = 8;

struct Arguments(u64);

impl Arguments {
    /// Uniform in `[0, 1)` (a linear congruence, its upper bits).
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Size between `2^low` and `2^high`, uniform in the exponent.
    fn exponential(&mut self, low: f64, high: f64) -> f64 {
        let exponent = self.uniform(low, high).floor();
        // In two factors: subnormal numbers, too.
        let half = (exponent / 2.0).floor();
        (1.0 + self.unit()) * 2f64.powi(half as i32) * 2f64.powi((exponent - half) as i32)
    }
}

/// How arguments are spread.
#[derive(Clone, Copy)]
enum Range {
    Uniform(f64, f64),
    /// Exponents, and both signs if told so.
    Sizes(f64, f64, bool),
}

impl Range {
    fn draw(self, arguments: &mut Arguments) -> f64 {
        match self {
            Self::Uniform(low, high) => arguments.uniform(low, high),
            Self::Sizes(low, high, signed) => {
                let size = arguments.exponential(low, high);
                if signed && arguments.unit() < 0.5 { -size } else { size }
            }
        }
    }
}

/// `|y - exact|` in units in the last place of `exact`; overflow begins half a unit above the largest number.
fn ulps(y: f64, exact: &Real) -> f64 {
    let is_beyond = exact.abs() > Real::from(f64::MAX);
    match exact.exponent() {
        None if y != 0.0 => f64::INFINITY,
        // The nearest number is infinite, or the largest one.
        Some(1025..) if y.is_finite() => f64::INFINITY,
        Some(1025..) => 0.0,
        _ if y.is_infinite() && is_beyond => 0.5,
        _ => error_in_ulps(y, exact),
    }
}

fn samples() -> usize {
    std::env::var("WZVI_SAMPLES").ok().and_then(|n| n.parse().ok()).unwrap_or(600)
}

type One = fn(Lanes<L>) -> Lanes<L>;
type Exact = fn(&Real) -> Real;

/// The largest error over some ranges.
fn measure(name: &str, function: One, exact: Exact, ranges: &[Range], bound: f64) {
    let pairs: Vec<_> = ranges.iter().map(|&range| [range; 2]).collect();
    measure_two(name, |x, _| function(x), |x, _| exact(x), &pairs, bound);
}

fn measure_two(
    name: &str,
    function: impl Fn(Lanes<L>, Lanes<L>) -> Lanes<L>,
    exact: impl Fn(&Real, &Real) -> Real,
    ranges: &[[Range; 2]],
    bound: f64,
) {
    let mut arguments = Arguments(name.len() as u64);
    let (mut worst, mut at) = (0.0, (0.0, 0.0));
    for &[first, second] in ranges {
        for _ in 0..samples().div_ceil(L) {
            let x: [f64; L] = std::array::from_fn(|_| first.draw(&mut arguments));
            let y: [f64; L] = std::array::from_fn(|_| second.draw(&mut arguments));
            let z = function(Lanes::new(x), Lanes::new(y));
            for i in 0..L {
                let error = ulps(z[i], &exact(&Real::from(x[i]), &Real::from(y[i])));
                if error.is_nan() || error > worst {
                    (worst, at) = (error, (x[i], y[i]));
                }
            }
        }
    }
    println!("{name}: {worst:.3} ulp at {at:?}");
    assert!(worst <= bound, "{name}{at:?} is off by {worst} units");
}

use Range::{Sizes, Uniform};

const ALL: Range = Sizes(-1074.0, 1023.0, true);
const POSITIVE: Range = Sizes(-1074.0, 1023.0, false);

fn pi() -> Real {
    Real::from(-1.0).acos()
}

#[test]
fn exponentials() {
    measure(
        "exp",
        Scalar::exp,
        Real::exp,
        &[Uniform(-750.0, 712.0), Uniform(-1.0, 1.0), Sizes(-1074.0, 9.0, true)],
        0.8,
    );
    measure(
        "exp2",
        Scalar::exp2,
        |x| Real::from(2.0).pow(x),
        &[Uniform(-1080.0, 1025.0), Uniform(-1.0, 1.0), Sizes(-60.0, 10.0, true)],
        0.8,
    );
    measure(
        "exp_m1",
        Scalar::exp_m1,
        |x| x.exp() - 1.0,
        &[Uniform(-40.0, 712.0), Uniform(-40.0, 1.0), Uniform(-1.0, 1.0), Sizes(-90.0, 6.0, true)],
        0.8,
    );
}

#[test]
fn logarithms() {
    let near_one = Uniform(0.5, 2.0);
    measure("ln", Scalar::ln, Real::ln, &[POSITIVE, near_one, Uniform(0.999, 1.001)], 1.0);
    measure("log2", Scalar::log2, Real::log2, &[POSITIVE, near_one, Uniform(0.999, 1.001)], 1.0);
    measure("log10", Scalar::log10, Real::log10, &[POSITIVE, near_one, Uniform(0.999, 1.001)], 1.0);
    measure(
        "ln_1p",
        Scalar::ln_1p,
        |x| (x + 1.0).ln(),
        &[Sizes(-90.0, 1023.0, false), Uniform(-1.0, 2.0), Sizes(-90.0, -1.0, true)],
        1.0,
    );
}

#[test]
fn trigonometry() {
    let ranges = [ALL, Uniform(-10.0, 10.0), Uniform(-2e6, 2e6), Uniform(-0.8, 0.8)];
    measure("sin", Scalar::sin, Real::sin, &ranges, 0.9);
    measure("cos", Scalar::cos, Real::cos, &ranges, 0.9);
    measure("tan", Scalar::tan, Real::tan, &ranges, 0.9);
}

/// The nearest numbers to multiples of `π/2`, where the reduced argument cancels most.
#[test]
fn trigonometry_near_its_zeros() {
    let mut arguments = Arguments(3);
    let (mut worst, half_pi) = (0.0_f64, pi() / 2.0);
    for i in 0..2000 + samples() {
        let n = if i < 2000 { (i + 1) as f64 } else { arguments.uniform(2e3, 1e6).floor() };
        let x =
            f64::from_bits((n * std::f64::consts::FRAC_PI_2).to_bits() + (arguments.unit() * 3.0) as u64 - 1);
        let rest = Real::from(x) - &half_pi * n;
        let (sine, cosine) = (rest.sin(), rest.cos());
        let exact = match n as u64 % 4 {
            0 => [sine, cosine],
            1 => [cosine, -sine],
            2 => [-sine, -cosine],
            _ => [-cosine, sine],
        };
        let x = Lanes::new([x]);
        for (found, exact) in
            [(x.sin(), &exact[0]), (x.cos(), &exact[1]), (x.tan(), &(&exact[0] / &exact[1]))]
        {
            worst = worst.max(ulps(found[0], exact));
        }
    }
    println!("near multiples of a right angle: {worst:.3} ulp");
    assert!(worst <= 1.0, "{worst}");
}

#[test]
fn inverse_trigonometry() {
    let ranges = [Uniform(-1.0, 1.0), Uniform(0.9, 1.0), Sizes(-1074.0, -0.5, true)];
    measure("asin", Scalar::asin, Real::asin, &ranges, 0.9);
    measure("acos", Scalar::acos, Real::acos, &ranges, 0.9);
    measure("atan", Scalar::atan, Real::atan, &[ALL, Uniform(-4.0, 4.0)], 1.0);
    measure_two(
        "atan2",
        Scalar::atan2,
        |y, x| match (x.is_negative(), y.is_negative()) {
            (false, _) => (y / x).atan(),
            (true, false) => (y / x).atan() + pi(),
            (true, true) => (y / x).atan() - pi(),
        },
        &[
            [Uniform(-1.0, 1.0), Uniform(-1.0, 1.0)],
            [Sizes(-30.0, 30.0, true), Sizes(-30.0, 30.0, true)],
            [Sizes(-1000.0, 1000.0, true), Sizes(-20.0, 20.0, true)],
        ],
        2.0,
    );
}

#[test]
fn hyperbolic_functions() {
    let ranges = [Uniform(-712.0, 712.0), Uniform(-2.0, 2.0), Sizes(-90.0, 5.0, true)];
    measure("sinh", Scalar::sinh, Real::sinh, &ranges, 2.0);
    measure("cosh", Scalar::cosh, Real::cosh, &ranges, 2.0);
    measure(
        "tanh",
        Scalar::tanh,
        Real::tanh,
        &[Uniform(-25.0, 25.0), Uniform(-1.0, 1.0), Sizes(-90.0, 8.0, true)],
        2.2,
    );
    measure("asinh", Scalar::asinh, Real::asinh, &[Sizes(-90.0, 1023.0, true), Uniform(-3.0, 3.0)], 2.0);
    measure("acosh", Scalar::acosh, Real::acosh, &[Uniform(1.0, 3.0), Sizes(0.0, 1023.0, false)], 2.0);
    measure("atanh", Scalar::atanh, Real::atanh, &[Uniform(-1.0, 1.0), Sizes(-90.0, -0.5, true)], 2.0);
}

#[test]
fn powers_and_roots() {
    measure_two(
        "powf",
        Scalar::powf,
        Real::pow,
        &[
            [Uniform(0.0, 10.0), Uniform(-10.0, 10.0)],
            [Sizes(-1022.0, 1023.0, false), Uniform(-1.0, 1.0)],
            [Uniform(0.5, 2.0), Uniform(-1100.0, 1100.0)],
            [Uniform(0.999, 1.001), Uniform(-1e6, 1e6)],
        ],
        1.0,
    );
    measure("cbrt", Scalar::cbrt, Real::cbrt, &[ALL, Uniform(1.0, 8.0)], 1.0);
    measure("sqrt", Scalar::sqrt, Real::sqrt, &[POSITIVE], 0.5);
    measure("recip", Scalar::recip, |x| Real::from(1.0) / x, &[ALL], 0.5);
    measure_two(
        "hypot",
        Scalar::hypot,
        // Squares of numbers of very different sizes.
        |x, y| with_precision(1024, || (x * x + y * y).sqrt()),
        &[
            [Uniform(-1.0, 1.0), Uniform(-1.0, 1.0)],
            [ALL, ALL],
            [Sizes(-4.0, 4.0, true), Sizes(-40.0, 4.0, true)],
            [Sizes(-1074.0, -1000.0, true), Sizes(-1074.0, -1000.0, true)],
        ],
        1.1,
    );
}
