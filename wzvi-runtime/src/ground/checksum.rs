//! The checksum of files and of given increments: CRC-64/XZ, which misses no change within 64 neighbouring
//! bits.
//!
//! Parameters from the catalogue of G. Cook: polynomial `42F0E1EBA9EA3693` (ECMA-182), reflected, all ones
//! before and after.

use std::fmt;

/// A checksum in the making.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Checksum(u64);

/// The polynomial with its bits in the order in which reflected arithmetic meets them.
const POLYNOMIAL: u64 = 0x42F0_E1EB_A9EA_3693_u64.reverse_bits();

/// The remainder of each byte.
const TABLE: [u64; 256] = {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut remainder = byte as u64;
        let mut bit = 0;
        while bit < 8 {
            remainder = (remainder >> 1) ^ if remainder & 1 == 1 { POLYNOMIAL } else { 0 };
            bit += 1;
        }
        table[byte] = remainder;
        byte += 1;
    }
    table
};

impl Default for Checksum {
    fn default() -> Self {
        Self(u64::MAX)
    }
}

impl Checksum {
    /// Goes on with more bytes.
    pub(crate) fn add(&mut self, bytes: &[u8]) {
        self.0 = bytes
            .iter()
            .fold(self.0, |remainder, byte| TABLE[usize::from(remainder as u8 ^ byte)] ^ (remainder >> 8));
    }

    /// The checksum of what was added.
    pub(crate) fn value(self) -> u64 {
        !self.0
    }
}

/// Sixteen hexadecimal digits.
impl fmt::Debug for Checksum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.value())
    }
}

#[cfg(test)]
mod tests {
    use super::Checksum;

    #[test]
    fn the_catalogue_agrees() {
        let mut checksum = Checksum::default();
        checksum.add(b"1234");
        checksum.add(b"56789");
        assert_eq!(checksum.value(), 0x995D_C9BB_DF19_39FA);
        assert_eq!(format!("{checksum:?}"), "995dc9bbdf1939fa");
    }
}
