//! Inverse trigonometric functions.

use std::f64::consts::{FRAC_PI_2, PI};

use super::{choice, functions, high, select};

functions! {
    /// Arc sine.
    Asin(x): asin::<ALONE>(x), where x.abs() <= 1.0, else libm::asin;
    /// Arc cosine.
    Acos(x): acos::<ALONE>(x), where x.abs() <= 1.0, else libm::acos;
    /// Arc tangent.
    Atan(x): atan::<ALONE>(x), where x.abs() <= f64::INFINITY, else libm::atan;
    /// The angle of the point (`x`, `y`).
    Atan2(y, x): atan2::<ALONE>(y, x), where is_moderate(y) & is_moderate(x), else libm::atan2;
}

/// `π/2 - FRAC_PI_2`
const FRAC_PI_2_LOW: f64 = 6.123_233_995_736_766e-17;

/// `(asin(x) - x)/x` as a function of `z = x²`, for `|x| <= 1/2`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn excess(z: f64) -> f64 {
    const P: [f64; 6] = [
        1.666_666_666_666_666_6e-1,
        -3.255_658_186_224_009e-1,
        2.012_125_321_348_629_3e-1,
        -4.005_553_450_067_941e-2,
        7.915_349_942_898_145e-4,
        3.479_331_075_960_212e-5,
    ];
    const Q: [f64; 4] = [
        -2.403_394_911_734_414,
        2.020_945_760_233_505_7,
        -6.882_839_716_054_533e-1,
        7.703_815_055_590_194e-2,
    ];
    let p = z * (P[0] + z * (P[1] + z * (P[2] + z * (P[3] + z * (P[4] + z * P[5])))));
    let q = 1.0 + z * (Q[0] + z * (Q[1] + z * (Q[2] + z * Q[3])));
    p / q
}

/// `asin(x) = π/2 - 2 asin √((1 - x)/2)` above one half.
#[cfg_attr(not(debug_assertions), inline(always))]
fn asin<const ALONE: bool>(x: f64) -> f64 {
    let size = x.abs();
    let is_small = size < 0.5;
    let z = select(is_small, x * x, (1.0 - size) * 0.5);
    let r = excess(z);
    choice!(ALONE: is_small => x + x * r, else asin_of_large(size, z, r).copysign(x))
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn asin_of_large(size: f64, z: f64, r: f64) -> f64 {
    let root = z.sqrt();
    let near_one = FRAC_PI_2 - (2.0 * (root + root * r) - FRAC_PI_2_LOW);
    let upper = high(root);
    let lower = (z - upper * upper) / (root + upper);
    let half = 0.5 * FRAC_PI_2;
    let middle = half - ((2.0 * root * r - (FRAC_PI_2_LOW - 2.0 * lower)) - (half - 2.0 * upper));
    select(size >= 0.975, near_one, middle)
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn acos<const ALONE: bool>(x: f64) -> f64 {
    let size = x.abs();
    let is_small = size < 0.5;
    let z = select(is_small, x * x, (1.0 - size) * 0.5);
    let r = excess(z);
    choice!(ALONE: is_small => FRAC_PI_2 - (x - (FRAC_PI_2_LOW - x * r)), else acos_of_large(x, z, r))
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn acos_of_large(x: f64, z: f64, r: f64) -> f64 {
    let root = z.sqrt();
    let negative = 2.0 * (FRAC_PI_2 - (root + (r * root - FRAC_PI_2_LOW)));
    let upper = high(root);
    let lower = select(z == 0.0, 0.0, (z - upper * upper) / (root + upper));
    let positive = 2.0 * (upper + (r * root + lower));
    select(x < 0.0, negative, positive)
}

/// `atan(x) = atan(c) + atan((x - c)/(1 + c x))` with `c` one of 0, 1/2, 1, 3/2, ∞.
#[cfg_attr(not(debug_assertions), inline(always))]
fn atan<const ALONE: bool>(x: f64) -> f64 {
    const T: [f64; 11] = [
        3.333_333_333_333_293e-1,
        -1.999_999_999_987_648_3e-1,
        1.428_571_427_250_346_6e-1,
        -1.111_111_040_546_235_6e-1,
        9.090_887_133_436_507e-2,
        -7.691_876_205_044_83e-2,
        6.661_073_137_387_531e-2,
        -5.833_570_133_790_573_5e-2,
        4.976_877_994_615_932_4e-2,
        -3.653_157_274_421_691_6e-2,
        1.628_582_011_536_578_2e-2,
    ];
    let a = x.abs();
    let (b0, b1, b2, b3) = (a >= 0.4375, a >= 0.6875, a >= 1.1875, a >= 2.4375);
    let pick = |zero: f64, half: f64, one: f64, more: f64, infinite: f64| {
        select(b3, infinite, select(b2, more, select(b1, one, select(b0, half, zero))))
    };
    let numerator = pick(a, 2.0 * a - 1.0, a - 1.0, a - 1.5, -1.0);
    let denominator = pick(1.0, 2.0 + a, a + 1.0, 1.0 + 1.5 * a, a);
    let upper =
        pick(0.0, 4.636_476_090_008_061e-1, std::f64::consts::FRAC_PI_4, 9.827_937_232_473_29e-1, FRAC_PI_2);
    let lower = pick(
        0.0,
        2.269_877_745_296_168_7e-17,
        3.061_616_997_868_383e-17,
        1.390_331_103_123_099_8e-17,
        FRAC_PI_2_LOW,
    );
    let t = if ALONE && !b0 { a } else { numerator / denominator };
    let z = t * t;
    let w = z * z;
    let odd = z * (T[0] + w * (T[2] + w * (T[4] + w * (T[6] + w * (T[8] + w * T[10])))));
    let even = w * (T[1] + w * (T[3] + w * (T[5] + w * (T[7] + w * T[9]))));
    (upper - ((t * (odd + even) - lower) - t)).copysign(x)
}

/// Whether quotients of two such numbers are normal.
#[cfg_attr(not(debug_assertions), inline(always))]
fn is_moderate(x: f64) -> bool {
    (1e-150..1e150).contains(&x.abs())
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn atan2<const ALONE: bool>(y: f64, x: f64) -> f64 {
    const PI_LOW: f64 = 1.224_646_799_147_353_2e-16;
    let angle = atan::<ALONE>((y / x).abs());
    select(x < 0.0, PI - (angle - PI_LOW), angle).copysign(y)
}
