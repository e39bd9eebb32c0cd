//! `x^y`, `∛x` and `√(x² + y²)`.

use super::exponential::exp2_sum;
use super::logarithm::is_normal_and_positive;
use super::{functions, high, select, small_integer};

functions! {
    /// `x^y`
    Pow(x, y): pow(x, y), where is_moderate(x, y), else libm::pow;
    /// `√(x² + y²)`
    Hypot(x, y): hypot(x, y), where squares_fit(x, y), else libm::hypot;
    /// `∛x`
    Cbrt(x): cbrt(x), where is_normal_and_positive(x.abs()), else libm::cbrt;
}

/// Whether `x^y` is far from overflow: `|log₂ x|` is below its exponent plus one.
#[cfg_attr(not(debug_assertions), inline(always))]
fn is_moderate(x: f64, y: f64) -> bool {
    let exponent = small_integer((x.to_bits() >> 52) & 0x7ff) - 1023.0;
    is_normal_and_positive(x) & (y.abs() * (exponent.abs() + 1.0) <= 1020.0)
}

/// `2^(y log₂ x)` with the logarithm in two parts, from `x = 2^n m` and
/// `log₂ (m/b) = C (s + s³/3 + s⁵/5 + ...)` with `s = (m - b)/(m + b)`, `C = 2/ln 2`, and 1 or 3/2 for `b`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn pow(x: f64, y: f64) -> f64 {
    // C and C/3, each as a number of so few bits that its product is exact, and the remainder.
    const C: f64 = 2.885_390_081_777_926_8;
    const C_HIGH: f64 = 2.885_390_081_442_892_6;
    const C_LOW: f64 = 3.350_342_632_977_302_4e-10;
    const THIRD: f64 = 9.617_966_939_259_756e-1;
    const THIRD_HIGH: f64 = 9.619_140_625e-1;
    const THIRD_LOW: f64 = -1.173_685_740_243_950_9e-4;
    // Near C/5, C/7 and so on.
    const L: [f64; 6] = [
        5.770_780_163_555_802e-1,
        4.121_985_831_179_819_6e-1,
        3.205_988_945_946_522_4e-1,
        2.623_090_078_196_821_4e-1,
        2.218_487_427_035_452_3e-1,
        1.990_678_878_356_354_5e-1,
    ];
    const LOG2_1_5_HIGH: f64 = 5.849_624_872_207_642e-1;
    const LOG2_1_5_LOW: f64 = 1.350_039_202_129_749e-8;
    // Mantissas from √(3/2) and from √3 on, by their first 20 bits.
    const ROOT_1_5: u64 = 0x0003_988f_0000_0000;
    const ROOT_3: u64 = 0x000b_b67a_0000_0000;

    let fraction = x.to_bits() & 0x000f_ffff_ffff_ffff;
    let is_upper = fraction >= ROOT_3;
    let is_middle = fraction >= ROOT_1_5 && !is_upper;
    let n = small_integer((x.to_bits() >> 52) & 0x7ff) - select(is_upper, 1022.0, 1023.0);
    let one = if is_upper { 0x3fe0_0000_0000_0000 } else { 0x3ff0_0000_0000_0000 };
    let m = f64::from_bits(fraction | one);
    let base = select(is_middle, 1.5, 1.0);

    // s in two parts, the first with 21 bits.
    let (difference, inverse) = (m - base, 1.0 / (m + base));
    let s = difference * inverse;
    let s_high = high(s);
    let sum_high = high(m + base);
    let sum_low = m - (sum_high - base);
    let s_low = inverse * ((difference - s_high * sum_high) - s_high * sum_low);

    // The logarithm to 21 bits, and what it leaves of the exact products.
    let z = s * s;
    let whole = n + select(is_middle, LOG2_1_5_HIGH, 0.0);
    let log_high = high((whole + s * C) + (s * THIRD) * z);
    let square = s_high * s_high;
    let square_high = high(square);
    let cube = s_high * square_high;
    let lost = ((whole - log_high) + s_high * C_HIGH) + cube * THIRD_HIGH;

    // The remainders of C s and of C s³/3, the slope of their sum for the second part of s, and other terms.
    let left = (s_high * C_LOW + cube * THIRD_LOW) + (s_high * THIRD) * (square - square_high);
    let slope = C + (s_high * (s_high + s) + z) * THIRD;
    let w = z * z;
    let series = ((L[0] + z * L[1]) + w * (L[2] + z * L[3])) + (w * w) * (L[4] + z * L[5]);
    let known = lost + (left + select(is_middle, LOG2_1_5_LOW, 0.0));
    let log_low = known + ((s * w) * series + s_low * slope);

    let y_high = high(y);
    exp2_sum(y_high * log_high, (y - y_high) * log_high + y * log_low)
}

/// Whether squares neither overflow nor lose digits.
#[cfg_attr(not(debug_assertions), inline(always))]
fn squares_fit(x: f64, y: f64) -> bool {
    const SMALL: f64 = 1e-135;
    const LARGE: f64 = 1e150;
    let (x, y) = (x.abs(), y.abs());
    let fits = |x: f64| (SMALL..LARGE).contains(&x);
    (fits(x) | (x == 0.0)) & (fits(y) | (y == 0.0))
}

/// `√(x² + y²)` with the rounding of the squares put back.
#[cfg_attr(not(debug_assertions), inline(always))]
fn hypot(x: f64, y: f64) -> f64 {
    let (x, y) = (x.abs(), y.abs());
    let (larger, smaller) = (select(x < y, y, x), select(x < y, x, y));
    let (upper, upper_lost) = square(larger);
    let (lower, lower_lost) = square(smaller);
    (((lower_lost + upper_lost) + lower) + upper).sqrt()
}

/// `x²` and its rounding error (Dekker).
#[cfg_attr(not(debug_assertions), inline(always))]
fn square(x: f64) -> (f64, f64) {
    let upper = {
        let scaled = x * 134_217_729.0;
        (x - scaled) + scaled
    };
    let lower = x - upper;
    let square = x * x;
    (square, ((upper * upper - square) + 2.0 * upper * lower) + lower * lower)
}

/// `∛x`: a third of the exponent, a polynomial good to 23 bits, and one step of Newton's method.
#[cfg_attr(not(debug_assertions), inline(always))]
fn cbrt(x: f64) -> f64 {
    const P: [f64; 5] = [
        1.875_951_824_271_77,
        -1.884_979_795_433_771_7,
        1.621_429_720_105_354_5,
        -7.583_979_347_787_66e-1,
        1.459_961_928_866_124_5e-1,
    ];
    // (1023 - 1023/3 - 0.0331) 2^20
    const BIAS: u64 = 715_094_163;
    let sign = x.to_bits() & (1 << 63);
    let top = (x.to_bits() >> 32) & 0x7fff_ffff;
    // A third, exact below 2^31.
    let third = (top * 0xaaaa_aaab) >> 33;
    let t = f64::from_bits(((third + BIAS) << 32) | sign);
    let r = (t * t) * (t / x);
    let t = t * ((P[0] + r * (P[1] + r * P[2])) + ((r * r) * r) * (P[3] + r * P[4]));
    // Its square is exact.
    let t = f64::from_bits(t.to_bits().wrapping_add(0x8000_0000) & 0xffff_ffff_c000_0000);
    let r = x / (t * t);
    t + t * ((r - t) / ((t + t) + r))
}
