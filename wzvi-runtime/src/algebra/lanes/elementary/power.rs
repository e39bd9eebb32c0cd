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

/// `2^(y log₂ x)` with the logarithm in two parts: 2/(3 ln 2) times `3 ln(x) / 2` by its series in
/// `s = (m - b)/(m + b)`, where `x = 2^n m` and `b` is 1 or 3/2.
#[cfg_attr(not(debug_assertions), inline(always))]
fn pow(x: f64, y: f64) -> f64 {
    const L: [f64; 6] = [
        5.999_999_999_999_946e-1,
        4.285_714_285_785_502e-1,
        3.333_333_298_183_774_3e-1,
        2.727_281_238_085_34e-1,
        2.306_607_457_755_617_5e-1,
        2.069_750_178_003_384_2e-1,
    ];
    const LOG2_1_5_HIGH: f64 = 5.849_624_872_207_642e-1;
    const LOG2_1_5_LOW: f64 = 1.350_039_202_129_749e-8;
    const TWO_THIRDS: f64 = 9.617_966_939_259_756e-1;
    const TWO_THIRDS_HIGH: f64 = 9.617_967_009_544_373e-1;
    const TWO_THIRDS_LOW: f64 = -7.028_461_650_952_758e-9;
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

    let (difference, inverse) = (m - base, 1.0 / (m + base));
    let s = difference * inverse;
    let s_high = high(s);
    let sum_high = high(m + base);
    let sum_low = m - (sum_high - base);
    let s_low = inverse * ((difference - s_high * sum_high) - s_high * sum_low);

    let z = s * s;
    let series = z * z * (L[0] + z * (L[1] + z * (L[2] + z * (L[3] + z * (L[4] + z * L[5])))));
    let series = series + s_low * (s_high + s);
    let z_high = s_high * s_high;
    let t_high = high((3.0 + z_high) + series);
    let t_low = series - ((t_high - 3.0) - z_high);
    let (u, v) = (s_high * t_high, s_low * t_high + t_low * s);
    let p_high = high(u + v);
    let p_low = v - (p_high - u);
    let w_high = TWO_THIRDS_HIGH * p_high;
    let w_low = TWO_THIRDS_LOW * p_high + p_low * TWO_THIRDS + select(is_middle, LOG2_1_5_LOW, 0.0);
    let base_log = select(is_middle, LOG2_1_5_HIGH, 0.0);
    let log_high = high(((w_high + w_low) + base_log) + n);
    let log_low = w_low - (((log_high - n) - base_log) - w_high);

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
