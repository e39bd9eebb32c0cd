//! Sine, cosine and tangent.

use super::{choice, functions, high, nearest, select};

/// `n π/2` is known to the last digit for `n` below 2^20: that is `|x|` up to here.
const LARGEST: f64 = 1.6e6;

/// The polynomial of `(sin x - x) / x³` in `x²`.
pub(crate) const SINE: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];

/// The polynomial of `(cos x - 1 + x²/2) / x⁴` in `x²`.
pub(crate) const COSINE: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

functions! {
    /// Sine.
    Sin(x): sin::<ALONE>(x), where x.abs() <= LARGEST, else libm::sin;
    /// Cosine.
    Cos(x): cos::<ALONE>(x), where x.abs() <= LARGEST, else libm::cos;
    /// Tangent.
    Tan(x): tan::<ALONE>(x), where x.abs() <= LARGEST, else libm::tan;
}

/// Below `π/4`: reduction leaves such a number as it is, with `n = 0`.
const REDUCED: f64 = 0.785;

/// `x - n π/2` in two parts, at most about `π/4`, and bits that end in `n`. The second part is at most the
/// rounding of the first and is not waited for.
///
/// `π/2` in three parts of 33 bits and a remainder (W. J. Cody, W. Waite, "Software Manual for the Elementary
/// Functions", 1980): their products with `n` are exact.
#[cfg_attr(not(debug_assertions), inline(always))]
fn reduce<const ALONE: bool>(x: f64) -> (f64, f64, u64) {
    const FIRST: f64 = 1.570_796_326_734_125_6;
    const SECOND: f64 = 6.077_100_506_303_966e-11;
    const THIRD: f64 = 2.022_266_248_711_166_5e-21;
    const REST: f64 = 8.478_427_660_368_9e-32;
    if ALONE && x.abs() <= REDUCED {
        return (x, 0.0, 0);
    }
    let (n, bits) = nearest(x * std::f64::consts::FRAC_2_PI);
    let (r, first_lost) = difference(x - n * FIRST, n * SECOND);
    let (head, second_lost) = difference(r, n * THIRD);
    (head, (first_lost + second_lost) - n * REST, bits)
}

/// `a - b` and its rounding error (Knuth).
#[cfg_attr(not(debug_assertions), inline(always))]
fn difference(a: f64, b: f64) -> (f64, f64) {
    let rounded = a - b;
    let taken = a - rounded;
    (rounded, (a - (rounded + taken)) - (b - taken))
}

/// `sin(x + tail)` for `|x| <= π/4`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn sine(x: f64, tail: f64) -> f64 {
    let z = x * x;
    let w = z * z;
    // In pairs, so that few operations wait for one another.
    let p = ((SINE[0] + z * SINE[1]) + w * (SINE[2] + z * SINE[3])) + (w * w) * (SINE[4] + z * SINE[5]);
    x + ((z * x) * p + (tail - 0.5 * z * tail))
}

/// `cos(x + tail)` for `|x| <= π/4`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn cosine(x: f64, tail: f64) -> f64 {
    let z = x * x;
    let w = z * z;
    let r = ((COSINE[0] + z * COSINE[1]) + w * (COSINE[2] + z * COSINE[3]))
        + (w * w) * (COSINE[4] + z * COSINE[5]);
    let half = 0.5 * z;
    let rounded = 1.0 - half;
    rounded + (((1.0 - rounded) - half) + (w * r - x * tail))
}

/// The value with its sign turned if bit 1 of `bits` is set.
#[cfg_attr(not(debug_assertions), inline(always))]
fn turned(value: f64, bits: u64) -> f64 {
    f64::from_bits(value.to_bits() ^ ((bits & 2) << 62))
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn sin<const ALONE: bool>(x: f64) -> f64 {
    let (head, tail, n) = reduce::<ALONE>(x);
    let y = choice!(ALONE: n & 1 == 0 => sine(head, tail), else cosine(head, tail));
    // The sign of zero.
    select(x == 0.0, x, turned(y, n))
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn cos<const ALONE: bool>(x: f64) -> f64 {
    let (head, tail, n) = reduce::<ALONE>(x);
    let y = choice!(ALONE: n & 1 == 0 => cosine(head, tail), else sine(head, tail));
    turned(y, n.wrapping_add(n & 1))
}

/// Sine and cosine of any number, as a call.
#[inline(never)]
pub(in crate::algebra) fn sin_cos_alone(x: f64) -> (f64, f64) {
    if !Sin::is_usual(x) {
        return (Sin::rare(x), Cos::rare(x));
    }
    let (head, tail, n) = reduce::<true>(x);
    let (sine, cosine) = (sine(head, tail), cosine(head, tail));
    let is_even = n & 1 == 0;
    let sin = turned(select(is_even, sine, cosine), n);
    let cos = turned(select(is_even, cosine, sine), n.wrapping_add(n & 1));
    (select(x == 0.0, x, sin), cos)
}

/// `tan(x)`, and `-1/tan` of the reduced argument for odd `n`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn tan<const ALONE: bool>(x: f64) -> f64 {
    const T: [f64; 13] = [
        3.333_333_333_333_341e-1,
        1.333_333_333_332_012_4e-1,
        5.396_825_397_622_605e-2,
        2.186_948_829_485_954_2e-2,
        8.863_239_823_599_3e-3,
        3.592_079_107_591_312_4e-3,
        1.456_209_454_325_290_3e-3,
        5.880_412_408_202_641e-4,
        2.464_631_348_184_699e-4,
        7.817_944_429_395_571e-5,
        7.140_724_913_826_082e-5,
        -1.855_863_748_552_754_6e-5,
        2.590_730_518_636_337e-5,
    ];
    const QUARTER: f64 = std::f64::consts::FRAC_PI_4;
    const QUARTER_LOW: f64 = 3.061_616_997_868_383e-17;
    let (head, tail, n) = reduce::<ALONE>(x);
    let is_odd = n & 1 == 1;
    // Near π/4: from the tangent of the distance to it.
    let is_large = head.abs() >= 0.674_34;
    let sign = select(head < 0.0, -1.0, 1.0);
    let missing = (QUARTER - sign * head) + (QUARTER_LOW - sign * tail);
    let (u, v) = (select(is_large, missing, head), select(is_large, 0.0, tail));
    let z = u * u;
    let w = z * z;
    let odd = T[1] + w * (T[3] + w * (T[5] + w * (T[7] + w * (T[9] + w * T[11]))));
    let even = z * (T[2] + w * (T[4] + w * (T[6] + w * (T[8] + w * (T[10] + w * T[12])))));
    let s = z * u;
    let r = (v + z * (s * (odd + even) + v)) + s * T[0];
    let t = u + r;

    let y = choice!(ALONE: is_large => tan_near_quarter(is_odd, sign, u, r, t),
        else choice!(ALONE: is_odd => minus_recip(u, r, t), else t));
    select(x == 0.0, x, y)
}

/// `±tan(π/4 - x)`, or `-1/tan`, from `t = u + r`, the tangent of `x`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn tan_near_quarter(is_odd: bool, sign: f64, u: f64, r: f64, t: f64) -> f64 {
    let one = select(is_odd, -1.0, 1.0);
    sign * (one - 2.0 * (u + (r - t * t / (t + one))))
}

/// `-1/(u + r)` to the last digit, where `t = u + r`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn minus_recip(u: f64, r: f64, t: f64) -> f64 {
    let t_high = high(t);
    let inverse = -1.0 / t;
    let inverse_high = high(inverse);
    let rest = 1.0 + inverse_high * t_high + inverse_high * (r - (t_high - u));
    inverse_high + inverse * rest
}
