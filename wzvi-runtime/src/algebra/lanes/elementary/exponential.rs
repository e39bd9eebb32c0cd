//! `e^x`, `2^x` and `e^x - 1`.

use super::{LN2_HIGH, LN2_LOW, functions, high, inverse_power_of_two, nearest, power_of_two, select};

functions! {
    /// `e^x`
    Exp(x): exp(x), where x.abs() <= 708.0, else libm::exp;
    /// `2^x`
    Exp2(x): exp2_sum(x, 0.0), where x.abs() <= 1021.0, else libm::exp2;
    /// `e^x - 1`
    ExpM1(x): exp_m1(x), where x.abs() <= 36.0 || (0.0..708.0).contains(&x), else libm::expm1;
}

/// `r - r² (P_0 + P_1 r² + ...)`, which is `c` in `e^r = 1 + r + r c/(2 - c)` for `|r| <= ln 2 / 2`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn remainder(r: f64) -> f64 {
    const P: [f64; 5] = [
        1.666_666_666_666_660_2e-1,
        -2.777_777_777_701_559_3e-3,
        6.613_756_321_437_934e-5,
        -1.653_390_220_546_525_2e-6,
        4.138_136_797_057_238_5e-8,
    ];
    let z = r * r;
    r - z * (P[0] + z * (P[1] + z * (P[2] + z * (P[3] + z * P[4]))))
}

/// `e^x` for `|x| <= 708`, from `x = k ln 2 + r`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn exp(x: f64) -> f64 {
    let (k, bits) = nearest(x * std::f64::consts::LOG2_E);
    let (upper, lower) = (x - k * LN2_HIGH, k * LN2_LOW);
    let r = upper - lower;
    let c = remainder(r);
    (1.0 + (r * c / (2.0 - c) - lower + upper)) * power_of_two(bits)
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
    let t = high(tail + fraction);
    let (u, v) = (t * LN2_UPPER, (tail - (t - fraction)) * LN2 + t * LN2_LOWER);
    let r = u + v;
    let lost = v - (r - u);
    let c = remainder(r);
    let y = 1.0 - (((r * c) / (c - 2.0) - (lost + r * lost)) - r);
    y * power_of_two(bits)
}

/// `e^x - 1` for `-36 <= x <= 708`: with `x = k ln 2 + r`, `2^k (e^r - 1) + (2^k - 1)`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn exp_m1(x: f64) -> f64 {
    const Q: [f64; 5] = [
        -3.333_333_333_333_313e-2,
        1.587_301_587_254_814_6e-3,
        -7.936_507_578_674_88e-5,
        4.008_217_827_329_362e-6,
        -2.010_992_181_836_243_7e-7,
    ];
    let (k, bits) = nearest(x * std::f64::consts::LOG2_E);
    let (upper, lower) = (x - k * LN2_HIGH, k * LN2_LOW);
    let r = upper - lower;
    let lost = (upper - r) - lower;
    let half = 0.5 * r;
    let z = r * half;
    let ratio = 1.0 + z * (Q[0] + z * (Q[1] + z * (Q[2] + z * (Q[3] + z * Q[4]))));
    let t = 3.0 - ratio * half;
    // e^r - 1 = r - (r e - z) without the rest of the reduction, r - e with it.
    let e = z * ((ratio - t) / (6.0 - r * t));
    let near_zero = r - (r * e - z);
    let e = (r * (e - lost) - lost) - z;
    let inverse = inverse_power_of_two(bits);
    // If r and 1/2 cancel, their sum is exact and comes first.
    let cancels = k == 1.0 && r < -0.25;
    let moderate = select(cancels, (r + 0.5) - e, (r - e) + (1.0 - inverse));
    let large = (r - (e + inverse)) + 1.0;
    let scaled = select(k < 20.0, moderate, large) * power_of_two(bits);
    select(k == 0.0, near_zero, scaled)
}
