//! The elementary functions of lanes over their whole range against arithmetic of 256 bits.
//!
//! The bounds are those of the table in the documentation of `wzvi_runtime::algebra::lanes`. With `WZVI_SAMPLES=1000000` in the
//! environment every function is measured at so many arguments per range, and `--nocapture` prints what was found.

use astro_float_num::{BigFloat, Consts, RoundingMode};
use wzvi_runtime::algebra::lanes::Lanes;
use wzvi_runtime::algebra::scalar::Scalar;

const L: usize = 8;
const BITS: usize = 256;
const ROUND: RoundingMode = RoundingMode::ToEven;

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

/// Exactly; `from_f64` itself misreads subnormal numbers.
fn big(x: f64) -> BigFloat {
    let (large, small) = (2f64.powi(200), 2f64.powi(-200));
    if x.is_subnormal() {
        BigFloat::from_f64(x * large, BITS).mul(&BigFloat::from_f64(small, BITS), BITS, ROUND)
    } else {
        BigFloat::from_f64(x, BITS)
    }
}

/// `(mantissa in [1/2, 1), exponent)` of a number that is not zero.
fn parts(x: &BigFloat) -> Option<(f64, i32)> {
    let (words, _, _, exponent, _) = x.as_raw_parts()?;
    let top = *words.last()?;
    (top != 0).then(|| (top as f64 / 2f64.powi(64), exponent))
}

/// `|y - exact|` in units in the last place of `exact`.
fn ulps(y: f64, exact: &BigFloat) -> f64 {
    let Some((_, exponent)) = parts(exact) else {
        return if y == 0.0 { 0.0 } else { f64::INFINITY };
    };
    if exponent > 1024 {
        // The nearest number is infinite, or the largest one.
        return if y == f64::INFINITY.copysign(y) { 0.0 } else { f64::INFINITY };
    }
    if !y.is_finite() {
        // Overflow begins half a unit above the largest number.
        let largest = big(f64::MAX).sub(&exact.abs(), BITS, ROUND);
        return if y.is_infinite() && largest.is_negative() { 0.5 } else { f64::INFINITY };
    }
    let unit = (exponent - 53).max(-1074);
    let difference = big(y).sub(exact, BITS, ROUND);
    parts(&difference).map_or(0.0, |(mantissa, e)| mantissa * 2f64.powi(e - unit))
}

fn samples() -> usize {
    std::env::var("WZVI_SAMPLES").ok().and_then(|n| n.parse().ok()).unwrap_or(600)
}

type One = fn(Lanes<L>) -> Lanes<L>;
type Exact = fn(&BigFloat, &mut Consts) -> BigFloat;

/// The largest error over some ranges.
fn measure(name: &str, function: One, exact: Exact, ranges: &[Range], bound: f64) {
    let (mut arguments, mut constants) = (Arguments(name.len() as u64), Consts::new().unwrap());
    let (mut worst, mut at) = (0.0, 0.0);
    for &range in ranges {
        for _ in 0..samples().div_ceil(L) {
            let x: [f64; L] = std::array::from_fn(|_| range.draw(&mut arguments));
            let y = function(Lanes::new(x));
            for i in 0..L {
                let error = ulps(y[i], &exact(&big(x[i]), &mut constants));
                if error.is_nan() || error > worst {
                    (worst, at) = (error, x[i]);
                }
            }
        }
    }
    println!("{name}: {worst:.3} ulp at {at:e}");
    assert!(worst <= bound, "{name}({at:e}) is off by {worst} units");
}

type Two = fn(Lanes<L>, Lanes<L>) -> Lanes<L>;
type ExactTwo = fn(&BigFloat, &BigFloat, &mut Consts) -> BigFloat;

fn measure_two(name: &str, function: Two, exact: ExactTwo, ranges: &[[Range; 2]], bound: f64) {
    let (mut arguments, mut constants) = (Arguments(name.len() as u64), Consts::new().unwrap());
    let (mut worst, mut at) = (0.0, (0.0, 0.0));
    for &[first, second] in ranges {
        for _ in 0..samples().div_ceil(L) {
            let x: [f64; L] = std::array::from_fn(|_| first.draw(&mut arguments));
            let y: [f64; L] = std::array::from_fn(|_| second.draw(&mut arguments));
            let z = function(Lanes::new(x), Lanes::new(y));
            for i in 0..L {
                let error = ulps(z[i], &exact(&big(x[i]), &big(y[i]), &mut constants));
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

#[test]
fn exponentials() {
    measure(
        "exp",
        Scalar::exp,
        |x, c| x.exp(BITS, ROUND, c),
        &[Uniform(-750.0, 712.0), Uniform(-1.0, 1.0), Sizes(-1074.0, 9.0, true)],
        1.0,
    );
    measure(
        "exp2",
        Scalar::exp2,
        |x, c| big(2.0).pow(x, BITS, ROUND, c),
        &[Uniform(-1080.0, 1025.0), Uniform(-1.0, 1.0), Sizes(-60.0, 10.0, true)],
        1.0,
    );
    measure(
        "exp_m1",
        Scalar::exp_m1,
        |x, c| x.exp(BITS, ROUND, c).sub(&big(1.0), BITS, ROUND),
        &[Uniform(-40.0, 712.0), Uniform(-40.0, 1.0), Uniform(-1.0, 1.0), Sizes(-90.0, 6.0, true)],
        1.0,
    );
}

#[test]
fn logarithms() {
    let near_one = Uniform(0.5, 2.0);
    measure("ln", Scalar::ln, |x, c| x.ln(BITS, ROUND, c), &[POSITIVE, near_one, Uniform(0.999, 1.001)], 1.0);
    measure(
        "log2",
        Scalar::log2,
        |x, c| x.log2(BITS, ROUND, c),
        &[POSITIVE, near_one, Uniform(0.999, 1.001)],
        1.0,
    );
    measure(
        "log10",
        Scalar::log10,
        |x, c| x.log10(BITS, ROUND, c),
        &[POSITIVE, near_one, Uniform(0.999, 1.001)],
        1.0,
    );
    measure(
        "ln_1p",
        Scalar::ln_1p,
        |x, c| x.add(&big(1.0), BITS, ROUND).ln(BITS, ROUND, c),
        &[Sizes(-90.0, 1023.0, false), Uniform(-1.0, 2.0), Sizes(-90.0, -1.0, true)],
        1.0,
    );
}

#[test]
fn trigonometry() {
    let ranges = [ALL, Uniform(-10.0, 10.0), Uniform(-2e6, 2e6), Uniform(-0.8, 0.8)];
    measure("sin", Scalar::sin, |x, c| x.sin(BITS, ROUND, c), &ranges, 0.9);
    measure("cos", Scalar::cos, |x, c| x.cos(BITS, ROUND, c), &ranges, 0.9);
    measure("tan", Scalar::tan, |x, c| x.tan(BITS, ROUND, c), &ranges, 0.9);
}

/// The nearest numbers to multiples of `π/2`, where the reduced argument cancels most.
#[test]
fn trigonometry_near_its_zeros() {
    let mut constants = Consts::new().unwrap();
    let mut arguments = Arguments(3);
    let (mut worst, half_pi) = (0.0_f64, constants.pi(BITS, ROUND).div(&big(2.0), BITS, ROUND));
    for i in 0..2000 + samples() {
        let n = if i < 2000 { (i + 1) as f64 } else { arguments.uniform(2e3, 1e6).floor() };
        let x =
            f64::from_bits((n * std::f64::consts::FRAC_PI_2).to_bits() + (arguments.unit() * 3.0) as u64 - 1);
        let rest = big(x).sub(&half_pi.mul(&big(n), BITS, ROUND), BITS, ROUND);
        let (sine, cosine) = (rest.sin(BITS, ROUND, &mut constants), rest.cos(BITS, ROUND, &mut constants));
        let (s, c, t) = (Lanes::new([x]).sin()[0], Lanes::new([x]).cos()[0], Lanes::new([x]).tan()[0]);
        let quarter = n as u64 % 4;
        let exact = [&sine, &cosine];
        let [of_sine, of_cosine] = [exact[quarter as usize % 2], exact[(quarter as usize + 1) % 2]];
        let sign = |negative: bool| if negative { -1.0 } else { 1.0 };
        worst = worst.max(ulps(s * sign(quarter >= 2), of_sine));
        worst = worst.max(ulps(c * sign(quarter == 1 || quarter == 2), of_cosine));
        let tangent = sine.div(&cosine, BITS, ROUND);
        let tangent = if quarter.is_multiple_of(2) { tangent } else { tangent.reciprocal(BITS, ROUND).neg() };
        worst = worst.max(ulps(t, &tangent));
    }
    println!("near multiples of a right angle: {worst:.3} ulp");
    assert!(worst <= 1.0, "{worst}");
}

#[test]
fn inverse_trigonometry() {
    let ranges = [Uniform(-1.0, 1.0), Uniform(0.9, 1.0), Sizes(-1074.0, -0.5, true)];
    measure("asin", Scalar::asin, |x, c| x.asin(BITS, ROUND, c), &ranges, 0.9);
    measure("acos", Scalar::acos, |x, c| x.acos(BITS, ROUND, c), &ranges, 0.9);
    measure("atan", Scalar::atan, |x, c| x.atan(BITS, ROUND, c), &[ALL, Uniform(-4.0, 4.0)], 1.0);
    measure_two(
        "atan2",
        Scalar::atan2,
        |y, x, c| {
            let angle = y.div(x, BITS, ROUND).atan(BITS, ROUND, c);
            match (x.is_negative(), y.is_negative()) {
                (false, _) => angle,
                (true, false) => angle.add(&c.pi(BITS, ROUND), BITS, ROUND),
                (true, true) => angle.sub(&c.pi(BITS, ROUND), BITS, ROUND),
            }
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
    measure("sinh", Scalar::sinh, |x, c| x.sinh(BITS, ROUND, c), &ranges, 2.0);
    measure("cosh", Scalar::cosh, |x, c| x.cosh(BITS, ROUND, c), &ranges, 2.0);
    measure(
        "tanh",
        Scalar::tanh,
        |x, c| x.tanh(BITS, ROUND, c),
        &[Uniform(-25.0, 25.0), Uniform(-1.0, 1.0), Sizes(-90.0, 8.0, true)],
        2.2,
    );
    measure(
        "asinh",
        Scalar::asinh,
        |x, c| x.asinh(BITS, ROUND, c),
        &[Sizes(-90.0, 1023.0, true), Uniform(-3.0, 3.0)],
        2.0,
    );
    measure(
        "acosh",
        Scalar::acosh,
        |x, c| x.acosh(BITS, ROUND, c),
        &[Uniform(1.0, 3.0), Sizes(0.0, 1023.0, false)],
        2.0,
    );
    measure(
        "atanh",
        Scalar::atanh,
        |x, c| x.atanh(BITS, ROUND, c),
        &[Uniform(-1.0, 1.0), Sizes(-90.0, -0.5, true)],
        2.0,
    );
}

#[test]
fn powers_and_roots() {
    measure_two(
        "powf",
        Scalar::powf,
        |x, y, c| x.pow(y, BITS, ROUND, c),
        &[
            [Uniform(0.0, 10.0), Uniform(-10.0, 10.0)],
            [Sizes(-1022.0, 1023.0, false), Uniform(-1.0, 1.0)],
            [Uniform(0.5, 2.0), Uniform(-1100.0, 1100.0)],
            [Uniform(0.999, 1.001), Uniform(-1e6, 1e6)],
        ],
        1.0,
    );
    measure("cbrt", Scalar::cbrt, |x, _| x.cbrt(BITS, ROUND), &[ALL, Uniform(1.0, 8.0)], 1.0);
    measure("sqrt", Scalar::sqrt, |x, _| x.sqrt(BITS, ROUND), &[POSITIVE], 0.5);
    measure("recip", Scalar::recip, |x, _| x.reciprocal(BITS, ROUND), &[ALL], 0.5);
    measure_two(
        "hypot",
        Scalar::hypot,
        |x, y, _| {
            x.mul(x, 4 * BITS, ROUND).add(&y.mul(y, 4 * BITS, ROUND), 4 * BITS, ROUND).sqrt(BITS, ROUND)
        },
        &[
            [Uniform(-1.0, 1.0), Uniform(-1.0, 1.0)],
            [ALL, ALL],
            [Sizes(-4.0, 4.0, true), Sizes(-40.0, 4.0, true)],
            [Sizes(-1074.0, -1000.0, true), Sizes(-1074.0, -1000.0, true)],
        ],
        1.1,
    );
}
