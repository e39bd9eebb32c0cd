//! `e^x`, `2^x` and `e^x - 1`.

use super::{LN2_HIGH, LN2_LOW, functions, high, inverse_power_of_two, nearest, select};

functions! {
    /// `e^x`
    Exp(x): exp(x), where x.abs() <= 708.0, else libm::exp;
    /// `2^x`
    Exp2(x): exp2_sum(x, -0.0), where x.abs() <= 1021.0, else libm::exp2;
    /// `e^x - 1`
    ExpM1(x): exp_m1(x), where x.abs() <= 36.0 || (0.0..708.0).contains(&x), else libm::expm1;
}

/// `e^r - 1 - r` for `|r| <= ln 2 / 2`, within 5 % of a rounding of `e^r`: the polynomial of
/// `(e^r - 1 - r)/r²` with the smallest largest error, its first coefficient kept at 1/2.
#[cfg_attr(not(debug_assertions), inline(always))]
fn remainder(r: f64) -> f64 {
    const P: [f64; 10] = [
        0.5,
        1.666_666_666_666_643_3e-1,
        4.166_666_666_660_394_4e-2,
        8.333_333_333_500_06e-3,
        1.388_888_892_680_296e-3,
        1.984_126_946_618_649_7e-4,
        2.480_150_867_326_248e-5,
        2.755_764_087_723_435_4e-6,
        2.762_519_087_662_588e-7,
        2.497_838_276_605_662e-8,
    ];
    let z = r * r;
    z * sum_in_pairs(P, r, z)
}

/// `(e^r - 1 - r - r²/2)/r³` for `|r| <= ln 2 / 2`, with one more coefficient: where `e^x - 1` is small,
/// [`remainder`] is too far off.
#[cfg_attr(not(debug_assertions), inline(always))]
fn cubic_remainder(r: f64, z: f64) -> f64 {
    const P: [f64; 10] = [
        1.666_666_666_666_667_7e-1,
        4.166_666_666_666_653e-2,
        8.333_333_333_322_033e-3,
        1.388_888_888_897_341_4e-3,
        1.984_126_988_537_083_5e-4,
        2.480_158_712_625_267_4e-5,
        2.755_724_478_818_082e-6,
        2.755_745_538_310_841_3e-7,
        2.510_888_051_716_209_2e-8,
        2.085_620_477_459_099_4e-9,
    ];
    sum_in_pairs(P, r, z)
}

/// The polynomial of degree nine at r, where `z = r²`: in pairs, so that few operations wait for one another.
#[cfg_attr(not(debug_assertions), inline(always))]
fn sum_in_pairs(p: [f64; 10], r: f64, z: f64) -> f64 {
    let w = z * z;
    let low = (p[0] + r * p[1]) + z * (p[2] + r * p[3]);
    let middle = (p[4] + r * p[5]) + z * (p[6] + r * p[7]);
    low + w * (middle + w * (p[8] + r * p[9]))
}

/// `2^k y` for the bits of [`nearest`], where neither y nor the product is zero, subnormal or infinite.
#[cfg_attr(not(debug_assertions), inline(always))]
fn scaled(y: f64, bits: u64) -> f64 {
    f64::from_bits(y.to_bits().wrapping_add(bits << 52))
}

/// `e^x` for `|x| <= 708`, from `x = k ln 2 + r`: `2^k (1 + r + remainder)`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn exp(x: f64) -> f64 {
    let (k, bits) = nearest(x * std::f64::consts::LOG2_E);
    let (upper, lower) = (x - k * LN2_HIGH, k * LN2_LOW);
    let sum = 1.0 + upper;
    let lost = upper - (sum - 1.0);
    scaled(sum + ((lost - lower) + remainder(upper - lower)), bits)
}

/// `2^(x + tail)` for `|x| <= 1021` and a small tail.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn exp2_sum(x: f64, tail: f64) -> f64 {
    const LN2: f64 = std::f64::consts::LN_2;
    // Its first 24 bits, and the remainder.
    const LN2_UPPER: f64 = 6.931_471_824_645_996e-1;
    const LN2_LOWER: f64 = -1.904_654_299_957_768e-9;
    let (k, bits) = nearest(x);
    let fraction = x - k;
    let t = high(fraction);
    // The first product is exact.
    let (upper, lower) = (t * LN2_UPPER, ((fraction - t) + tail) * LN2 + t * LN2_LOWER);
    let sum = 1.0 + upper;
    let lost = upper - (sum - 1.0);
    scaled(sum + ((lost + lower) + remainder((fraction + tail) * LN2)), bits)
}

/// `e^x - 1` for `-36 <= x <= 708`: with `x = k ln 2 + r`, `2^k ((1 - 2^-k) + (e^r - 1))`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn exp_m1(x: f64) -> f64 {
    let (k, bits) = nearest(x * std::f64::consts::LOG2_E);
    let (upper, lower) = (x - k * LN2_HIGH, k * LN2_LOW);
    let r = upper - lower;
    let r_lost = (upper - r) - lower;
    let inverse = inverse_power_of_two(bits);
    // Zero, or larger than r.
    let whole = 1.0 - inverse;
    let whole_lost = (1.0 - whole) - inverse;
    let sum = whole + r;
    let sum_lost = r - (sum - whole);
    let lost = (sum_lost + whole_lost) + (r_lost + r * r_lost);
    let z = r * r;
    let y = scaled(sum + (0.5 * z + (lost + (r * z) * cubic_remainder(r, z))), bits);
    // The sign of zero; its exponent cannot be raised either.
    select(x == 0.0, x, y)
}
