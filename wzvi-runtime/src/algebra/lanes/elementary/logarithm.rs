//! Logarithms: `ln x = k ln 2 + ln(1 + f)`, and `ln(1 + f) = f - f²/2 + s (f²/2 + R(s))` with
//! `s = f/(2 + f)`.

use super::{LN2_HIGH, LN2_LOW, exponent_and_mantissa, functions, high, select};

functions! {
    /// Natural logarithm.
    Ln(x): ln(x), where is_normal_and_positive(x), else libm::log;
    /// `ln(1 + x)`
    Ln1p(x): ln_1p(x), where x > -1.0 && x < 1e300, else libm::log1p;
    /// Logarithm to base 2.
    Log2(x): log2(x), where is_normal_and_positive(x), else libm::log2;
    /// Logarithm to base 10.
    Log10(x): log10(x), where is_normal_and_positive(x), else libm::log10;
}

#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn is_normal_and_positive(x: f64) -> bool {
    (f64::MIN_POSITIVE..f64::INFINITY).contains(&x)
}

/// `f²/2` and `s (f²/2 + R) + tail` for f and `2 + f`
#[cfg_attr(not(debug_assertions), inline(always))]
fn series(f: f64, sum: f64, tail: f64) -> (f64, f64) {
    const L: [f64; 7] = [
        6.666_666_666_666_735e-1,
        3.999_999_999_940_942e-1,
        2.857_142_874_366_239e-1,
        2.222_219_843_214_978_4e-1,
        1.818_357_216_161_805e-1,
        1.531_383_769_920_937_3e-1,
        1.479_819_860_511_658_6e-1,
    ];
    let s = f / sum;
    let z = s * s;
    let w = z * z;
    // In pairs, so that few operations wait for one another.
    let low = (L[0] + z * L[1]) + w * (L[2] + z * L[3]);
    let high = (L[4] + z * L[5]) + w * L[6];
    let half = 0.5 * f * f;
    (half, (s * half + tail) + (s * z) * (low + (w * w) * high))
}

/// `ln x` of a positive normal number.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn ln(x: f64) -> f64 {
    let (k, mantissa) = exponent_and_mantissa(x);
    of_parts(k, mantissa)
}

/// `ln(x 2^shift)` of a positive normal number, for a whole `shift`.
#[cfg(feature = "noise")]
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn ln_shifted(x: f64, shift: f64) -> f64 {
    let (k, mantissa) = exponent_and_mantissa(x);
    of_parts(k + shift, mantissa)
}

/// `ln(2^k m)`
#[cfg_attr(not(debug_assertions), inline(always))]
fn of_parts(k: f64, mantissa: f64) -> f64 {
    let f = mantissa - 1.0;
    let (half, rest) = series(f, 1.0 + mantissa, k * LN2_LOW);
    k * LN2_HIGH - ((half - rest) - f)
}

/// `ln(1 + x)` for `-1 < x < 1e300`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn ln_1p(x: f64) -> f64 {
    let sum = 1.0 + x;
    let (k, mantissa) = exponent_and_mantissa(sum);
    // The rounding error of the sum, relative to it.
    let lost = select(k >= 2.0, 1.0 - (sum - x), x - (sum - 1.0)) / sum;
    // 1 + x is between √½ and √2: x itself is f.
    let is_near = x > -0.292_893_2 && x < 0.414_213_5;
    let k = select(is_near, 0.0, k);
    let lost = select(is_near, 0.0, lost);
    let f = select(is_near, x, mantissa - 1.0);
    let (half, rest) = series(f, 2.0 + f, k * LN2_LOW + lost);
    let y = k * LN2_HIGH - ((half - rest) - f);
    // The sign of zero.
    select(x == 0.0, x, y)
}

/// `ln m` as a sum whose first part has 21 bits.
#[cfg_attr(not(debug_assertions), inline(always))]
fn split(m: f64) -> (f64, f64) {
    let f = m - 1.0;
    let (half, rest) = series(f, 1.0 + m, -0.0);
    let upper = high(f - half);
    (upper, ((f - upper) - half) + rest)
}

/// `log₂ x` of a positive normal number.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn log2(x: f64) -> f64 {
    const HIGH: f64 = 1.442_695_040_721_446_3;
    const LOW: f64 = 1.675_171_316_488_651_2e-10;
    let (k, mantissa) = exponent_and_mantissa(x);
    let (upper, lower) = split(mantissa);
    let product = upper * HIGH;
    let sum = k + product;
    let tail = upper * LOW + ((k - sum) + product);
    (tail + lower * (HIGH + LOW)) + sum
}

/// `log₁₀ x` of a positive normal number.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn log10(x: f64) -> f64 {
    const HIGH: f64 = 4.342_944_818_781_689e-1;
    const LOW: f64 = 2.508_294_671_164_527_5e-11;
    const LOG10_2_HIGH: f64 = 3.010_299_956_636_117_7e-1;
    const LOG10_2_LOW: f64 = 3.694_239_077_158_931e-13;
    let (k, mantissa) = exponent_and_mantissa(x);
    let (upper, lower) = split(mantissa);
    let (product, whole) = (upper * HIGH, k * LOG10_2_HIGH);
    let sum = whole + product;
    let tail = (k * LOG10_2_LOW + upper * LOW) + ((whole - sum) + product);
    (tail + lower * (HIGH + LOW)) + sum
}
