//! Two standard normals from three words: the polar form of Box and Muller, `sqrt(-2 ln u) (cos a, sin a)`.
//!
//! A fixed number of words per pair keeps every normal addressable. The logarithm, sine and cosine are computed from the
//! polynomials of [`Lanes`](crate::algebra::lanes::Lanes) (errors below one ulp), because those of the platform differ in the last
//! bit between targets: the same seed gives the same bits everywhere.

use crate::algebra::lanes::elementary::{COSINE, SINE, ln_shifted, small_integer};

/// Two independent standard normals from 96 random bits: 53 for the radius, 43 for the angle. Both are finite and at most
/// `sqrt(106 ln 2) = 8.57` in absolute value; the probability beyond is `1e-16`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn pair(words: [u32; 3]) -> [f64; 2] {
    let high = (u64::from(words[0]) << 32) | u64::from(words[1]);
    // In (0, 1] as (m + 1) / 2^53: the logarithm never sees zero.
    let m = (high >> 11) + 1;
    let radius = (-2.0 * ln_shifted(m as f64, -53.0)).sqrt();
    let (sine, cosine) = sin_cos((u64::from(words[2]) << 11) | (high & 0x7ff));
    [radius * cosine, radius * sine]
}

/// Sine and cosine of an angle uniform on the circle, from 43 bits: a quadrant and the middle of one of `2^41` cells of it, so
/// that neither is ever zero and both are symmetric.
#[cfg_attr(not(debug_assertions), inline(always))]
fn sin_cos(angle: u64) -> (f64, f64) {
    let quadrant = angle >> 41;
    let cell = small_integer(angle & ((1 << 41) - 1));
    let x = ((cell + 0.5) * (1.0 / (1u64 << 41) as f64) - 0.5) * std::f64::consts::FRAC_PI_2;
    let z = x * x;
    let sine =
        x + x * z * (SINE[0] + z * (SINE[1] + z * (SINE[2] + z * (SINE[3] + z * (SINE[4] + z * SINE[5])))));
    let cosine = 1.0 - 0.5 * z
        + z * z
            * (COSINE[0]
                + z * (COSINE[1] + z * (COSINE[2] + z * (COSINE[3] + z * (COSINE[4] + z * COSINE[5])))));
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
            let got = ln_shifted(x, -53.0);
            assert!((got - expected).abs() <= 2.0 * f64::EPSILON * expected.abs(), "{m}: {got} {expected}");
        }
        assert_eq!(ln_shifted(2f64.powi(53), -53.0), 0.0);
        assert_eq!(ln_shifted(1.0, -53.0), (0.5f64).powi(53).ln());
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
