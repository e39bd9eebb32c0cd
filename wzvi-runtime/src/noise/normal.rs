//! Two standard normals from three words: the polar form of Box and Muller, `sqrt(-2 ln u) (cos a, sin a)`.
//!
//! A fixed number of words per pair keeps every normal addressable. The logarithm, sine and cosine are computed here, from
//! the polynomials of fdlibm (Sun Microsystems, 1993; errors below one ulp), because those of the platform differ in the last
//! bit between targets: the same seed gives the same bits everywhere.

/// Two independent standard normals from 96 random bits: 53 for the radius, 43 for the angle. Both are finite and at most
/// `sqrt(106 ln 2) = 8.57` in absolute value; the probability beyond is `1e-16`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn pair(words: [u32; 3]) -> [f64; 2] {
    let high = (u64::from(words[0]) << 32) | u64::from(words[1]);
    // In (0, 1] as (m + 1) / 2^53: the logarithm never sees zero.
    let m = (high >> 11) + 1;
    let radius = (-2.0 * ln_shifted(m as f64, -53)).sqrt();
    let (sine, cosine) = sin_cos((u64::from(words[2]) << 11) | (high & 0x7ff));
    [radius * cosine, radius * sine]
}

/// `ln(x 2^shift)` for positive normal `x`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn ln_shifted(x: f64, shift: i64) -> f64 {
    const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
    const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    const L: [f64; 7] = [
        6.666_666_666_666_735e-1,
        3.999_999_999_940_942e-1,
        2.857_142_874_366_239e-1,
        2.222_219_843_214_978_4e-1,
        1.818_357_216_161_805e-1,
        1.531_383_769_920_937_3e-1,
        1.479_819_860_511_658_6e-1,
    ];
    // x = 2^k (1 + f) with 1 + f between sqrt(1/2) and sqrt(2).
    const ONE: u64 = 0x3ff0_0000_0000_0000;
    const ROOT_HALF: u64 = 0x3fe6_a09e_0000_0000;
    let bits = x.to_bits() + (ONE - ROOT_HALF);
    let k = small_integer(bits >> 52) - (1023 - shift) as f64;
    let f = f64::from_bits((bits & 0x000f_ffff_ffff_ffff) + ROOT_HALF) - 1.0;
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let odd = z * (L[0] + w * (L[2] + w * (L[4] + w * L[6])));
    let even = w * (L[1] + w * (L[3] + w * L[5]));
    let half = 0.5 * f * f;
    k * LN2_HIGH - ((half - (s * (half + (odd + even)) + k * LN2_LOW)) - f)
}

/// An integer below 2^52 as a number; the conversion instruction has no vector form before AVX-512.
#[cfg_attr(not(debug_assertions), inline(always))]
fn small_integer(n: u64) -> f64 {
    const TWO_52: f64 = 4_503_599_627_370_496.0;
    f64::from_bits(n | TWO_52.to_bits()) - TWO_52
}

/// Sine and cosine of an angle uniform on the circle, from 43 bits: a quadrant and the middle of one of `2^41` cells of it, so
/// that neither is ever zero and both are symmetric.
#[cfg_attr(not(debug_assertions), inline(always))]
fn sin_cos(angle: u64) -> (f64, f64) {
    const S: [f64; 6] = [
        -1.666_666_666_666_663_2e-1,
        8.333_333_333_322_49e-3,
        -1.984_126_982_985_795e-4,
        2.755_731_370_707_006_8e-6,
        -2.505_076_025_340_686_3e-8,
        1.589_690_995_211_55e-10,
    ];
    const C: [f64; 6] = [
        4.166_666_666_666_66e-2,
        -1.388_888_888_887_411e-3,
        2.480_158_728_947_673e-5,
        -2.755_731_435_139_066_3e-7,
        2.087_572_321_298_175e-9,
        -1.135_964_755_778_819_5e-11,
    ];
    let quadrant = angle >> 41;
    let cell = small_integer(angle & ((1 << 41) - 1));
    let x = ((cell + 0.5) * (1.0 / (1u64 << 41) as f64) - 0.5) * std::f64::consts::FRAC_PI_2;
    let z = x * x;
    let sine = x + x * z * (S[0] + z * (S[1] + z * (S[2] + z * (S[3] + z * (S[4] + z * S[5])))));
    let cosine =
        1.0 - 0.5 * z + z * z * (C[0] + z * (C[1] + z * (C[2] + z * (C[3] + z * (C[4] + z * C[5])))));
    // A quarter turn maps (cos, sin) to (-sin, cos).
    let (c, s) = if quadrant & 1 == 0 { (cosine, sine) } else { (sine, cosine) };
    let flip = |value: f64, sign: u64| f64::from_bits(value.to_bits() ^ (sign << 63));
    (flip(s, quadrant >> 1), flip(c, (quadrant ^ (quadrant >> 1)) & 1))
}

#[cfg(test)]
mod tests {
    use super::{ln_shifted, pair, sin_cos};

    #[test]
    fn logarithm_agrees_with_the_platform() {
        for i in 1..200_000u64 {
            let m = i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11;
            let (x, expected) = (m as f64, (m as f64 / 2f64.powi(53)).ln());
            let got = ln_shifted(x, -53);
            assert!((got - expected).abs() <= 2.0 * f64::EPSILON * expected.abs(), "{m}: {got} {expected}");
        }
        assert_eq!(ln_shifted(2f64.powi(53), -53), 0.0);
        assert_eq!(ln_shifted(1.0, -53), (0.5f64).powi(53).ln());
    }

    #[test]
    fn circle_agrees_with_the_platform() {
        for i in 0..200_000u64 {
            let angle = i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 21;
            let (sine, cosine) = sin_cos(angle);
            // The quadrants start at -pi/4.
            let turn = (angle as f64 + 0.5) / 2f64.powi(43);
            let expected = (std::f64::consts::TAU * (turn - 0.125)).sin_cos();
            assert!((sine - expected.0).abs() < 1e-15, "{turn}: {sine} {expected:?}");
            assert!((cosine - expected.1).abs() < 1e-15, "{turn}: {cosine} {expected:?}");
        }
    }

    #[test]
    fn extreme_words_give_finite_normals() {
        for words in [[0, 0, 0], [u32::MAX; 3], [0, 0, u32::MAX], [u32::MAX, u32::MAX, 0]] {
            let normals = pair(words);
            assert!(normals.iter().all(|x| x.is_finite() && x.abs() < 8.58), "{words:?}: {normals:?}");
        }
    }

    /// Where the first 27 bits are zero the radius is beyond 6.1, and its tail is that of Rayleigh: given that it exceeds `r`,
    /// `exp((r² - radius²)/2)` is uniform. Kolmogorov and Smirnov allow 2.5 once in 130 000.
    #[test]
    fn beyond_six_deviations_the_law_is_the_same() {
        let n = 200_000_u64;
        let mut uniform: Vec<f64> = (1..=n)
            .map(|i| {
                let random =
                    i.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (i << 40).wrapping_mul(0xd6e8_feb8_6659_fd93);
                let [a, b] = pair([(random as u32) & 31, (random >> 32) as u32, (random >> 13) as u32]);
                let radius = a.hypot(b);
                assert!(radius > 6.1);
                // u is below 2^-27.
                (27.0 * std::f64::consts::LN_2 - 0.5 * radius * radius).exp()
            })
            .collect();
        uniform.sort_by(f64::total_cmp);
        let distance = uniform.iter().enumerate().fold(0.0, |largest: f64, (i, u)| {
            let (below, above) = (i as f64 / n as f64, (i + 1) as f64 / n as f64);
            largest.max((u - below).abs()).max((above - u).abs())
        });
        assert!(distance * (n as f64).sqrt() < 2.5, "{distance}");
    }
}
