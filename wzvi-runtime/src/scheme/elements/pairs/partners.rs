//! The partners of a body, block by block.

use std::hint::black_box;

use super::block::{BLOCK, GradientBlock, LARGE_BLOCK, add, add_few};
use super::{LANES, Pair, Row, total};
use crate::algebra::scalar::Number;

/// The partners of a row in columns, each followed by a block of padding: coordinates, the sums of all
/// components, entries of tables.
pub(super) struct Partners<'r, const D: usize, const M: usize> {
    pub(super) points: [&'r [f64]; D],
    pub(super) sums: &'r mut [f64],
    /// The position of the sum by the first component of the first partner; `stride` is the distance to the
    /// next component.
    pub(super) first: usize,
    pub(super) stride: usize,
    pub(super) entries: [&'r [f64]; M],
}

/// `B` numbers of each list from `first` on.
#[cfg_attr(not(debug_assertions), inline(always))]
fn heads<'a, const B: usize, const N: usize>(lists: &[&'a [f64]; N], first: usize) -> [&'a [f64; B]; N] {
    let mut heads = [&[0.0; B]; N];
    for k in 0..N {
        heads[k] = &lists[k][first..].as_chunks().0[0];
    }
    heads
}

/// [`heads`] of lists that may be shorter, padded with their last number.
#[cfg_attr(not(debug_assertions), inline(always))]
fn filled<const B: usize, const N: usize>(lists: &[&[f64]; N], first: usize) -> [[f64; B]; N] {
    let mut filled = [[0.0; B]; N];
    for k in 0..N {
        let list = &lists[k][first..];
        for (place, number) in filled[k].iter_mut().enumerate() {
            *number = list[place.min(list.len() - 1)];
        }
    }
    filled
}

impl<const D: usize, const M: usize> Partners<'_, D, M> {
    /// The sums by component `k` of a block.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sums<const B: usize>(&mut self, k: usize, first: usize) -> &mut [f64; B] {
        &mut self.sums[self.first + k * self.stride + first..].as_chunks_mut().0[0]
    }

    /// Adds the derivatives by the first `few` partners of a block to their sums, and those by the body to
    /// the sums of the lanes, in full groups of [`LANES`]. Returns all derivatives by the body.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn meet_block<T, U, K, const O: usize, const F: usize, const B: usize>(
        &mut self,
        row: &Row<'_, T, O, M, F>,
        [first, few]: [usize; 2],
        lanes: &mut [[f64; LANES]; F],
    ) -> [[f64; B]; F]
    where
        T: Number<f64>,
        U: Number<f64>,
        K: Pair<O, D, M, F>,
    {
        let mut block = GradientBlock { by_own: [[0.0; B]; F], by_partner: [[0.0; B]; D] };
        let points = heads(&self.points, first);
        if few == B || M == 0 {
            block.fill::<T, U, K, O, M>(B, few, row.own, points, heads(&self.entries, first));
        } else {
            let entries = filled(&self.entries, first);
            block.fill::<T, U, K, O, M>(B, few, row.own, points, entries.each_ref());
        }
        // Read from memory: from registers, the compiler would add these one by one.
        let by_own = black_box(&block.by_own);
        for k in 0..D {
            let sums = self.sums(k, first);
            if few == B { add(sums, &block.by_partner[k]) } else { add_few(sums, &block.by_partner[k], few) }
        }
        for k in 0..F {
            for slopes in &by_own[k].as_chunks::<LANES>().0[..few / LANES] {
                add(&mut lanes[k], slopes);
            }
        }
        *by_own
    }

    /// Adds the derivatives by all partners to their sums; returns the sums of those by the body.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn meet<T, U, K, const O: usize, const F: usize>(
        mut self,
        row: &Row<'_, T, O, M, F>,
    ) -> [f64; F]
    where
        T: Number<f64>,
        U: Number<f64>,
        K: Pair<O, D, M, F>,
    {
        let (mut lanes, mut totals) = ([[0.0; LANES]; F], [0.0; F]);
        let mut first = 0;
        while row.len - first >= LARGE_BLOCK {
            let places = [first, LARGE_BLOCK];
            self.meet_block::<T, U, K, O, F, LARGE_BLOCK>(row, places, &mut lanes);
            first += LARGE_BLOCK;
        }
        while first < row.len {
            let few = BLOCK.min(row.len - first);
            let slopes = self.meet_block::<T, U, K, O, F, BLOCK>(row, [first, few], &mut lanes);
            first += few;
            if first == row.len {
                for k in 0..F {
                    totals[k] = total(lanes[k]);
                }
                for place in few / LANES * LANES..few {
                    for k in 0..F {
                        totals[k] += slopes[k][place];
                    }
                }
                return totals;
            }
        }
        for k in 0..F {
            totals[k] = total(lanes[k]);
        }
        totals
    }
}
