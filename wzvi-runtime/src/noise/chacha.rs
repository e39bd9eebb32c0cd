//! ChaCha with 8 rounds (D. J. Bernstein, "ChaCha, a variant of Salsa20", 2008), the generator of everything random here: 64 bits each
//! for the number of the block and of the stream.
//!
//! A block is a function of its address (key, stream, block), without state: [`block`] computes one, and where it is called in a loop over
//! lanes, many beside each other. [`page`] has the first four of a stream from `rand_chacha`, which computes them at once; the tests say that
//! both are the same generator.

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

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

    /// A block, one alone or one of many lanes, has the words that `rand_chacha` has at the same key, stream and position.
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
}
