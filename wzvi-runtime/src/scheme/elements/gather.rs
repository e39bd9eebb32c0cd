//! Placements of an element that are evaluated together but read and add at scattered places, such as the
//! ends of bonds from a table.
//!
//! The arguments of the derivatives are gathered one by one into lists, the derivatives are computed in
//! vector registers, and then added to their places one by one, in the order of the placements:
//!
//! ```text
//! x_k[l] = q[i_k(b + l)]        for l = 0..B, k = 1..M
//! s_j[l] = ∂V/∂x_j(x_1[l], ..., x_M[l])
//! (∂V/∂q)[i_j(b + l)] += s_j[l]       for l = 0..B, j = 1..F
//! ```
//!
//! Two placements of one block may share a place: as the sums are not formed in vector registers, no conflict
//! arises, and the bits are those of one placement after the other, for any table and registers.

use std::marker::PhantomData;

use super::pairs::{GradientBlock, Pair};
use crate::algebra::scalar::{Number, Scalar};

/// Number of placements whose derivatives are computed in one loop: two of the widest registers, which do not
/// wait for each other.
const AT_ONCE: usize = 16;

/// Number of placements of a loop from which this pays.
pub(super) const LEAST_GATHERED: isize = 4;

/// For at most this many placements, only this many are computed.
const HALF: usize = AT_ONCE / 2;

/// Fewer placements are computed one by one.
const FEW: usize = 3;

/// Numbers of a block, aligned to a cache line.
#[derive(Debug)]
#[repr(align(64))]
struct AlignedColumns<S, const M: usize>([[S; AT_ONCE]; M]);

/// A block of placements of an element, which read `M` numbers and have `F` derivatives each: in numbers `U`,
/// and in numbers `T` if a result in `U` is not finite.
#[derive(Debug)]
pub struct Placements<S, T, U, const M: usize, const F: usize> {
    numbers: AlignedColumns<S, M>,
    block: GradientBlock<S, AT_ONCE, 0, F>,
    kinds: PhantomData<(T, U)>,
}

impl<S: Scalar, T: Number<S>, U: Number<S>, const M: usize, const F: usize> Placements<S, T, U, M, F> {
    /// Storage without placements.
    #[cfg_attr(not(debug_assertions), inline(always))]
    #[expect(clippy::new_without_default, reason = "generated code calls it by this name")]
    pub fn new() -> Self {
        let zeros = [S::from_f64(0.0); AT_ONCE];
        let block = GradientBlock { by_own: [zeros; F], by_partner: [] };
        Self { numbers: AlignedColumns([zeros; M]), block, kinds: PhantomData }
    }

    /// How many of the `left` placements are evaluated together.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn few(&self, left: usize) -> usize {
        left.min(AT_ONCE)
    }

    /// Takes the numbers that one placement reads.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn read(&mut self, lane: usize, numbers: [T; M]) {
        for (list, number) in self.numbers.0.iter_mut().zip(numbers) {
            list[lane] = number.kept();
        }
    }

    /// Computes the derivatives of the first `few` placements; `own` numbers are the same for all.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn take<K: Pair<O, 0, M, F>, const O: usize>(&mut self, few: usize, own: [T; O]) {
        let numbers = self.numbers.0.each_ref();
        if few < FEW {
            self.block.fill_in_full_range::<T, K, O, M>(few, own, [], numbers);
        } else if few > HALF {
            self.block.fill::<T, U, K, O, M>(AT_ONCE, few, own, [], numbers);
        } else {
            self.block.fill::<T, U, K, O, M>(HALF, few, own, [], numbers);
        }
    }

    /// The derivatives of one placement.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn gradient(&self, lane: usize) -> [T; F] {
        self.block.by_own.each_ref().map(|slopes| T::of(slopes[lane]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::lanes::common_range::CommonRange;
    use crate::algebra::lanes::instructions::{InstructionSet, Kernel};

    /// `c sin(k (x - y))`
    struct Bond;

    impl Pair<2, 0, 2, 2> for Bond {
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn gradient<T: Scalar>([c, k]: [T; 2], _partner: [T; 0], [x, y]: [T; 2]) -> ([T; 2], [T; 0]) {
            let slope = c * ((x - y) * k).sin();
            ([slope, -slope], [])
        }
    }

    const FACTORS: [f64; 2] = [0.3, 1.7];

    /// Adds the derivatives of all bonds.
    struct Added<'a> {
        bonds: &'a [[usize; 2]],
        q: &'a [f64],
        sums: &'a mut [f64],
    }

    fn add(sums: &mut [f64], bond: [usize; 2], slopes: [f64; 2]) {
        for (site, slope) in bond.into_iter().zip(slopes) {
            sums[site] += slope;
        }
    }

    impl Kernel for Added<'_> {
        type Output = ();

        #[cfg_attr(not(debug_assertions), inline(always))]
        fn run<const L: usize, const HALF: usize>(self) {
            let Self { bonds, q, sums } = self;
            let (mut placements, mut first) = (Placements::<f64, f64, CommonRange, 2, 2>::new(), 0);
            while first < bonds.len() {
                let few = placements.few(bonds.len() - first);
                for lane in 0..few {
                    placements.read(lane, bonds[first + lane].map(|site| q[site]));
                }
                placements.take::<Bond, 2>(few, FACTORS);
                for lane in 0..few {
                    add(sums, bonds[first + lane], placements.gradient(lane));
                }
                first += few;
            }
        }
    }

    #[test]
    fn all_instruction_sets_have_the_bits_of_one_placement_after_the_other() {
        for (count, far) in (0..70).flat_map(|count| [(count, 0.5), (count, 1e9)]) {
            // Sites recur in the next placements, and some bonds have both ends at the same site.
            let bonds: Vec<[usize; 2]> = (0..count).map(|b| [b * b % 7, b % 5]).collect();
            let mut q = [0.2, -1.4, 3.3, 0.0, 2.1, -0.7, 9.1];
            // Inside or outside the range of the reduction by π/2 in lanes.
            q[4] = far;
            let mut reference = [0.1; 7];
            for &bond in &bonds {
                let (slopes, []) = Bond::gradient(FACTORS, [], bond.map(|site| q[site]));
                add(&mut reference, bond, slopes);
            }
            for set in [InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Avx512] {
                let mut sums = [0.1; 7];
                set.run(Added { bonds: &bonds, q: &q, sums: &mut sums });
                assert_eq!(sums.map(f64::to_bits), reference.map(f64::to_bits), "{set:?}, {count}, {far}");
            }
        }
    }
}
