//! Random words by address: one page of 64 words for every cell of the tree of every path.
//!
//! The address is laid out over the key and the stream number of ChaCha8, so that two different addresses
//! never share a word:
//!
//! | bytes of the key | content |
//! |---|---|
//! | 0..8 | seed |
//! | 8..16 | path of an ensemble |
//! | 16..24 | process |
//! | 24..28 | version of this layout and of the tree (a change of either changes every path) |
//! | 28, 29, 30 | side of zero, octave, depth of the page (`grid`) |
//!
//! The stream number is the index of the cell among those of its octave and depth; the words are 0 to 63 of
//! that stream. All integers are little-endian.
//!
//! Tested by `wzvi-runtime/tests/runtime/noise_path.rs`.

use super::random::{self, PAGE};

/// Pairs of normals in a page.
pub(super) const PAIRS: usize = PAGE / 3;
const VERSION: u32 = 1;

/// The numbers that distinguish one Wiener process from all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ProcessId {
    pub(super) seed: u64,
    pub(super) path: u64,
    pub(super) process: u64,
}

/// Address of a page within a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PageAddress {
    pub(super) negative: bool,
    pub(super) octave: u8,
    pub(super) depth: u8,
    pub(super) cell: u64,
}

/// The random words of one page.
#[derive(Clone, Debug)]
pub(super) struct Words([u8; 4 * PAGE]);

impl Words {
    pub(super) const EMPTY: Self = Self([0; 4 * PAGE]);

    /// Fills the page of an address.
    pub(super) fn fill(&mut self, source: &ProcessId, address: &PageAddress) {
        let words = |x: u64| [x as u32, (x >> 32) as u32];
        let ([a, b], [c, d], [e, f]) = (words(source.seed), words(source.path), words(source.process));
        let place = u32::from_le_bytes([u8::from(address.negative), address.octave, address.depth, 0]);
        random::page(&[a, b, c, d, e, f, VERSION, place], address.cell, &mut self.0);
    }

    /// The `index`-th pair of normals, `index < PAIRS`.
    #[inline]
    pub(super) fn normals(&self, index: usize) -> [f64; 2] {
        let word = |i: usize| {
            let at = 4 * (3 * index + i);
            u32::from_le_bytes([self.0[at], self.0[at + 1], self.0[at + 2], self.0[at + 3]])
        };
        random::pair([word(0), word(1), word(2)])
    }
}

#[cfg(test)]
mod tests {
    use super::{PageAddress, ProcessId, Words};

    /// Every field of an address changes the page.
    #[test]
    fn addresses_do_not_collide() {
        let source = ProcessId { seed: 1, path: 2, process: 3 };
        let address = PageAddress { negative: false, octave: 4, depth: 5, cell: 6 };
        let page = |source: ProcessId, address: PageAddress| {
            let mut words = Words::EMPTY;
            words.fill(&source, &address);
            words.0
        };
        let pages = [
            page(source, address),
            page(ProcessId { seed: 2, path: 1, ..source }, address),
            page(ProcessId { path: 3, process: 2, ..source }, address),
            page(ProcessId { process: 0, ..source }, address),
            page(source, PageAddress { negative: true, ..address }),
            page(source, PageAddress { octave: 5, depth: 4, ..address }),
            page(source, PageAddress { depth: 6, ..address }),
            page(source, PageAddress { cell: 5, ..address }),
        ];
        for i in 0..pages.len() {
            for j in 0..i {
                assert_ne!(pages[i], pages[j], "{i} {j}");
            }
        }
        assert_eq!(pages[0], page(source, address));
    }
}
