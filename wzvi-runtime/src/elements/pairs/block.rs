//! The slopes of a body and a block of its partners.

use std::any::TypeId;

use super::{LANES, Pair, Row};
use crate::scalar::Number;

/// Partners whose slopes are computed in one loop, which the compiler takes for one over neighbours: half as many it would write out.
pub(super) const BLOCK: usize = 2 * LANES;

/// The same where a row has as many: sums wait for the loop before.
pub(super) const LARGE_BLOCK: usize = 2 * BLOCK;

/// Slopes of a body and a block of partners in columns.
#[inline(always)]
fn fill<
    T: Number<f64>,
    K: Pair<O, P, D, M, F>,
    const O: usize,
    const P: usize,
    const D: usize,
    const M: usize,
    const F: usize,
    const B: usize,
>(
    own: [T; O],
    constants: [f64; P],
    points: [&[f64; B]; D],
    entries: [&[f64; B]; M],
    by_own: &mut [[f64; B]; F],
    by_partner: &mut [[f64; B]; D],
) {
    for place in 0..B {
        let (mut point, mut entry) = ([T::from_f64(0.0); D], [T::from_f64(0.0); M]);
        for k in 0..D {
            point[k] = T::of(points[k][place]);
        }
        for k in 0..M {
            entry[k] = T::from_f64(entries[k][place]);
        }
        let slopes = K::slopes(own, constants, point, entry);
        for k in 0..F {
            by_own[k][place] = slopes.0[k].kept();
        }
        for k in 0..D {
            by_partner[k][place] = slopes.1[k].kept();
        }
    }
}

/// The slopes by a body, and those by partners in columns: at the beginning of a line of the cache, which the widest registers fill.
#[repr(align(64))]
pub(super) struct Block<const B: usize, const D: usize, const F: usize> {
    pub(super) by_own: [[f64; B]; F],
    pub(super) by_partner: [[f64; B]; D],
}

impl<const B: usize, const D: usize, const F: usize> Block<B, D, F> {
    /// Those of a block of partners, of which the first `few` are of interest, computed in numbers `U`; in numbers `T` where these do not
    /// know the result.
    #[inline(always)]
    pub(super) fn fill<T, U, K, const O: usize, const P: usize, const M: usize>(
        &mut self,
        row: &Row<'_, T, O, P, M, F>,
        few: usize,
        points: [&[f64; B]; D],
        entries: [&[f64; B]; M],
    ) where
        T: Number<f64>,
        U: Number<f64>,
        K: Pair<O, P, D, M, F>,
    {
        let mut own = [U::from_f64(0.0); O];
        for k in 0..O {
            own[k] = U::of(row.own[k].kept());
        }
        fill::<U, K, O, P, D, M, F, B>(
            own,
            row.constants,
            points,
            entries,
            &mut self.by_own,
            &mut self.by_partner,
        );
        if TypeId::of::<T>() != TypeId::of::<U>() && !self.is_finite(few) {
            self.fill_exactly::<T, K, O, P, M>(row, points, entries);
        }
    }

    #[cold]
    #[inline(never)]
    fn fill_exactly<T, K, const O: usize, const P: usize, const M: usize>(
        &mut self,
        row: &Row<'_, T, O, P, M, F>,
        points: [&[f64; B]; D],
        entries: [&[f64; B]; M],
    ) where
        T: Number<f64>,
        K: Pair<O, P, D, M, F>,
    {
        let Self { by_own, by_partner } = self;
        fill::<T, K, O, P, D, M, F, B>(row.own, row.constants, points, entries, by_own, by_partner);
    }

    #[inline(always)]
    fn is_finite(&self, few: usize) -> bool {
        let mut zeros = [0.0; B];
        for numbers in self.by_own.iter().chain(&self.by_partner) {
            for (zero, number) in zeros.iter_mut().zip(&numbers[..few]) {
                *zero += number * 0.0;
            }
        }
        zeros.iter().sum::<f64>() == 0.0
    }
}

/// `sums += slopes`
#[inline(always)]
pub(super) fn add<const N: usize>(sums: &mut [f64; N], slopes: &[f64; N]) {
    let (mut new, slopes) = (*sums, *slopes);
    for lane in 0..N {
        new[lane] += slopes[lane];
    }
    *sums = new;
}

/// The same of the first `few`.
#[inline(always)]
pub(super) fn add_few<const N: usize>(sums: &mut [f64; N], slopes: &[f64; N], few: usize) {
    let mut slopes = *slopes;
    for lane in 0..N {
        slopes[lane] = if lane < few { slopes[lane] } else { -0.0 };
    }
    add(sums, &slopes);
}
