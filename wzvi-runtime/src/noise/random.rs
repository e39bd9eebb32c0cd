//! Everything random here: words, and two standard normals from three of them.
//!
//! The words are those of ChaCha with 8 rounds (D. J. Bernstein, "ChaCha, a variant of Salsa20", 2008): 64
//! bits each for the number of the block and of the stream. A block is a function of its address (key,
//! stream, block), without state: [`block`] computes one, and where it is called in a loop over lanes, many
//! beside each other. [`page`] has the first four of a stream from `rand_chacha`, which computes them at
//! once; the tests say that both are the same generator.
//!
//! Normals have the polar form of Box and Muller, `sqrt(-2 ln u) (cos a, sin a)`. A fixed number of words per
//! pair keeps every normal addressable. The logarithm, sine and cosine are computed from the polynomials of
//! [`Lanes`](crate::algebra::lanes::Lanes) (errors below one ulp), because those of the platform differ in
//! the last bit between targets: the same seed gives the same bits everywhere.
//!
//! Tested by `wzvi-runtime/tests/runtime/ensemble_law.rs`.

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use crate::algebra::lanes::elementary::{COSINE, SINE, ln_shifted, small_integer};

/// Words of a page.
pub(crate) const PAGE: usize = 64;

/// The first [`PAGE`] words of a stream, as little-endian bytes.
#[inline]
pub(crate) fn page(key: &[u32; 8], stream: u64, to: &mut [u8; 4 * PAGE]) {
    let mut generator = ChaCha8Rng::from_seed(bytes(key));
    generator.set_stream(stream);
    generator.fill_bytes(to);
}

fn bytes(key: &[u32; 8]) -> [u8; 32] {
    let mut bytes = [0; 32];
    for (to, word) in bytes.chunks_exact_mut(4).zip(key) {
        to.copy_from_slice(&word.to_le_bytes());
    }
    bytes
}

/// One block of 16 words.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn block(key: &[u32; 8], stream: u64, block: u64) -> [u32; 16] {
    let start = [
        // "expand 32-byte k"
        0x6170_7865,
        0x3320_646e,
        0x7962_2d32,
        0x6b20_6574,
        key[0],
        key[1],
        key[2],
        key[3],
        key[4],
        key[5],
        key[6],
        key[7],
        block as u32,
        (block >> 32) as u32,
        stream as u32,
        (stream >> 32) as u32,
    ];
    let mut x = start;
    // Written out: a loop inside would keep the loop over the streams from becoming vector code.
    double_round(&mut x);
    double_round(&mut x);
    double_round(&mut x);
    double_round(&mut x);
    std::array::from_fn(|i| x[i].wrapping_add(start[i]))
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn double_round(x: &mut [u32; 16]) {
    quarter_round(x, [0, 4, 8, 12]);
    quarter_round(x, [1, 5, 9, 13]);
    quarter_round(x, [2, 6, 10, 14]);
    quarter_round(x, [3, 7, 11, 15]);
    quarter_round(x, [0, 5, 10, 15]);
    quarter_round(x, [1, 6, 11, 12]);
    quarter_round(x, [2, 7, 8, 13]);
    quarter_round(x, [3, 4, 9, 14]);
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn quarter_round(x: &mut [u32; 16], [a, b, c, d]: [usize; 4]) {
    x[a] = x[a].wrapping_add(x[b]);
    x[d] = (x[d] ^ x[a]).rotate_left(16);
    x[c] = x[c].wrapping_add(x[d]);
    x[b] = (x[b] ^ x[c]).rotate_left(12);
    x[a] = x[a].wrapping_add(x[b]);
    x[d] = (x[d] ^ x[a]).rotate_left(8);
    x[c] = x[c].wrapping_add(x[d]);
    x[b] = (x[b] ^ x[c]).rotate_left(7);
}

/// Two independent standard normals from 96 random bits: 53 for the radius, 43 for the angle. Both are finite
/// and at most `sqrt(106 ln 2) = 8.57` in absolute value; the probability beyond is `1e-16`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn pair(words: [u32; 3]) -> [f64; 2] {
    let high = (u64::from(words[0]) << 32) | u64::from(words[1]);
    // In (0, 1] as (m + 1) / 2^53: the logarithm never sees zero.
    let m = (high >> 11) + 1;
    let radius = (-2.0 * ln_shifted(m as f64, -53.0)).sqrt();
    let (sine, cosine) = sin_cos((u64::from(words[2]) << 11) | (high & 0x7ff));
    [radius * cosine, radius * sine]
}

/// Sine and cosine of an angle uniform on the circle, from 43 bits: a quadrant and the middle of one of
/// `2^41` cells of it, so that neither is ever zero and both are symmetric.
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
    use super::*;

    /// Keys, streams and blocks with bits in all words.
    const ADDRESSES: [([u32; 8], u64, u64); 5] = [
        ([0; 8], 0, 0),
        ([7, 0, 3, 0, 0, 0, 0x8000_0001, 0], 1 << 40, 5),
        ([u32::MAX; 8], u64::MAX, u64::MAX >> 4),
        ([1, 2, 3, 4, 5, 6, 7, 8], 0xffff_ffff, 1 << 33),
        ([0x9e37_79b9, 0x7f4a_7c15, 0, 1 << 31, 0, 0, 1, 0xabcd], 0x0123_4567_89ab_cdef, 3),
    ];

    /// A block, one alone or one of many lanes, has the words that `rand_chacha` has at the same key, stream
    /// and position.
    #[test]
    fn blocks_are_those_of_rand_chacha() {
        for (key, stream, number) in ADDRESSES {
            let mut reference = ChaCha8Rng::from_seed(bytes(&key));
            reference.set_stream(stream);
            reference.set_word_pos(16 * u128::from(number));
            let words: [u32; 16] = std::array::from_fn(|_| reference.next_u32());
            assert_eq!(block(&key, stream, number), words);
            let lanes: Vec<[u32; 16]> =
                (0..32).map(|lane| block(&key, stream.wrapping_sub(7).wrapping_add(lane), number)).collect();
            assert_eq!(lanes[7], words);
        }
    }

    /// A page is the first four blocks of its stream.
    #[test]
    fn pages_are_blocks() {
        for (key, stream, _) in ADDRESSES {
            let mut read = [0; 4 * PAGE];
            page(&key, stream, &mut read);
            let words = (0..4).flat_map(|number| block(&key, stream, number));
            let expected: Vec<u8> = words.flat_map(u32::to_le_bytes).collect();
            assert_eq!(read.as_slice(), expected);
        }
    }

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

    /// If the first 27 bits are zero the radius is beyond 6.1, and its tail is that of Rayleigh: given that
    /// it exceeds `r`, `exp((r² - radius²)/2)` is uniform. Kolmogorov and Smirnov allow 2.5 once in 130 000.
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
