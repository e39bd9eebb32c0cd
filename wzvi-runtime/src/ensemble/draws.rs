//! Normals by address: one for every (seed, process, path, step).
//!
//! The random words are those of ChaCha8. Its key holds the seed and the process, its stream number is the path, and the
//! block number is the step divided by [`STEPS`]: a block of 16 words makes [`STEPS`] normals, in pairs of three words
//! ([`crate::noise`] has the same pairs), and leaves one word over.
//!
//! | bytes of the key | content |
//! |---|---|
//! | 0..8 | seed |
//! | 8..16 | process |
//! | 16..20 | level of a multilevel run; zero for its first, and for all other runs |
//! | 20..24 | zero |
//! | 24..28 | version of this layout (a change changes every path) |
//!
//! Integers are little-endian. Keys of a Wiener path (`noise::stream`) have another version.

#![expect(clippy::needless_range_loop, reason = "plain loops over arrays are what becomes vector code")]

use std::array::from_fn;
use std::ops::Range;

use super::dispatch::{InstructionSet, Kernel};
use crate::noise::normal::pair;

/// Steps whose normals one block of random words makes.
pub(crate) const STEPS: usize = 10;
const VERSION: u32 = 0x8000_0001;

/// The key of one process of an ensemble, on one level.
pub(crate) fn key(seed: u64, process: u64, level: u32) -> [u32; 8] {
    let words = |x: u64| [x as u32, (x >> 32) as u32];
    let ([a, b], [c, d]) = (words(seed), words(process));
    [a, b, c, d, level, 0, VERSION, 0]
}

/// The standard normal of one step, path and process of an ensemble with this seed, before truncation: for whoever wants to
/// see what drove a path. It costs as much as a block of [`Normals`].
pub fn normal(seed: u64, process: u64, path: u64, step: u64) -> f64 {
    Normals::new(seed, process).of_path(path, step / STEPS as u64)[(step % STEPS as u64) as usize]
}

/// The standard normals of one process of an ensemble, before truncation, in blocks of ten steps: block `b` is for the
/// steps from `10 b` on.
#[derive(Clone, Copy, Debug)]
pub struct Normals {
    key: [u32; 8],
}

impl Normals {
    /// Of process `process`, from 0, with this seed.
    pub fn new(seed: u64, process: u64) -> Self {
        Self { key: key(seed, process, 0) }
    }

    /// One block of one path.
    #[inline(always)]
    pub fn of_path(&self, path: u64, block: u64) -> [f64; STEPS] {
        let mut drawn = [[0.0; 1]; STEPS];
        normals(&self.key, path, block, &mut drawn);
        drawn.map(|[normal]| normal)
    }

    /// Visits blocks of 16 paths beside each other, as `[step][path]`: of the first 16 `paths`, all `blocks` in order, then of
    /// the next 16. A last group that is not full has the paths that follow.
    pub fn visit(
        &self,
        paths: Range<u64>,
        blocks: Range<u64>,
        set: InstructionSet,
        visit: impl FnMut(&[[f64; 16]; STEPS]),
    ) {
        set.run(Visit { key: &self.key, paths, blocks, visit });
    }
}

struct Visit<'k, F> {
    key: &'k [u32; 8],
    paths: Range<u64>,
    blocks: Range<u64>,
    visit: F,
}

impl<F: FnMut(&[[f64; 16]; STEPS])> Kernel for Visit<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<const L: usize>(self) {
        let Self { key, paths, blocks, mut visit } = self;
        let mut drawn = [[0.0; 16]; STEPS];
        let mut path = paths.start;
        while path < paths.end {
            for block in blocks.clone() {
                normals(key, path, block, &mut drawn);
                visit(&drawn);
            }
            path += 16;
        }
    }
}

/// Normals of steps `STEPS * block ..` of paths `path ..`: `[step][path]`.
#[inline(always)]
pub(crate) fn normals<const L: usize>(key: &[u32; 8], path: u64, block: u64, to: &mut [[f64; L]; STEPS]) {
    normals_at(key, |lane| (path.wrapping_add(lane), block), to);
}

/// Normals of steps `STEPS * block ..` of a path for each lane, which `address` gives: `[step][lane]`.
#[inline(always)]
pub(crate) fn normals_at<const L: usize>(
    key: &[u32; 8],
    address: impl Fn(u64) -> (u64, u64),
    to: &mut [[f64; L]; STEPS],
) {
    if L != 32 {
        return side_by_side(key, address, to);
    }
    // Twice 16 words do not fit into the registers of AVX-512.
    let mut part = [[0.0; 16]; STEPS];
    for half in 0..2 {
        side_by_side(key, |lane| address(16 * half as u64 + lane), &mut part);
        for (to, part) in to.iter_mut().zip(&part) {
            for i in 0..16 {
                to[16 * half + i] = part[i];
            }
        }
    }
}

/// [`normals_at`], all at once.
#[inline(always)]
fn side_by_side<const L: usize>(
    key: &[u32; 8],
    address: impl Fn(u64) -> (u64, u64),
    to: &mut [[f64; L]; STEPS],
) {
    let mut words = [[0; L]; 16];
    for i in 0..L {
        let (path, block) = address(i as u64);
        let block = chacha8(key, path, block);
        for w in 0..16 {
            words[w][i] = block[w];
        }
    }
    for k in 0..STEPS / 2 {
        for i in 0..L {
            [to[2 * k][i], to[2 * k + 1][i]] =
                pair([words[3 * k][i], words[3 * k + 1][i], words[3 * k + 2][i]]);
        }
    }
}

/// One block of ChaCha with 8 rounds (D. J. Bernstein, "ChaCha, a variant of Salsa20", 2008), with 64 bits each for the
/// number of the block and of the stream.
#[inline(always)]
fn chacha8(key: &[u32; 8], stream: u64, block: u64) -> [u32; 16] {
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
    from_fn(|i| x[i].wrapping_add(start[i]))
}

#[inline(always)]
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

#[inline(always)]
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
    use rand_chacha::ChaCha8Rng;
    use rand_core::{Rng, SeedableRng};

    use super::*;

    /// The words that `rand_chacha` has at the same address, and the normals of its pairs.
    #[test]
    fn the_generator_is_chacha8() {
        for (seed, process, path, block) in [
            (0, 0, 0, 0),
            (7, 3, 1 << 40, 5),
            (u64::MAX, u64::MAX, u64::MAX, u64::MAX >> 4),
            (1, 2, u64::from(u32::MAX), 1 << 33),
        ] {
            let key = key(seed, process, 0);
            let mut bytes = [0; 32];
            for (to, word) in bytes.chunks_exact_mut(4).zip(key) {
                to.copy_from_slice(&word.to_le_bytes());
            }
            let mut reference = ChaCha8Rng::from_seed(bytes);
            reference.set_stream(path);
            reference.set_word_pos(16 * u128::from(block));
            let words: [u32; 16] = from_fn(|_| reference.next_u32());
            assert_eq!(chacha8(&key, path, block), words);
            let mut drawn = [[0.0; 2]; STEPS];
            normals(&key, path, block, &mut drawn);
            for k in 0..STEPS / 2 {
                let expected = pair([words[3 * k], words[3 * k + 1], words[3 * k + 2]]);
                assert_eq!([drawn[2 * k][0], drawn[2 * k + 1][0]], expected);
            }
        }
    }

    /// A normal is a function of its address: no matter how many paths are drawn at once.
    #[test]
    fn widths_agree() {
        let key = key(11, 1, 0);
        let mut wide = [[0.0; 32]; STEPS];
        normals(&key, 96, 3, &mut wide);
        for first in 0..32 {
            let mut one = [[0.0; 1]; STEPS];
            normals(&key, 96 + first as u64, 3, &mut one);
            for k in 0..STEPS {
                assert_eq!(one[k][0], wide[k][first]);
            }
        }
    }
}
