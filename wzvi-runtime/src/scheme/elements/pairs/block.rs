//! The derivatives of a body and a block of its partners.

use std::any::TypeId;

use super::{LANES, Pair};
use crate::algebra::scalar::{Number, Scalar};
use crate::scheme::elements::are_finite;

/// Number of partners whose derivatives are computed in one loop. The compiler vectorises this loop; it would
/// unroll one half as long.
pub(super) const BLOCK: usize = 2 * LANES;

/// Number of partners in one loop for rows that have as many: the sums wait for the loop before.
pub(super) const LARGE_BLOCK: usize = 2 * BLOCK;

/// Derivatives by a body and by the first `few` of a block of partners in columns.
#[cfg_attr(not(debug_assertions), inline(always))]
fn fill<
    S: Scalar,
    T: Number<S>,
    K: Pair<O, D, M, F>,
    const O: usize,
    const D: usize,
    const M: usize,
    const F: usize,
    const B: usize,
>(
    few: usize,
    own: [T; O],
    points: [&[S; B]; D],
    entries: [&[S; B]; M],
    by_own: &mut [[S; B]; F],
    by_partner: &mut [[S; B]; D],
) {
    for place in 0..few {
        let (mut point, mut entry) = ([T::from_f64(0.0); D], [T::from_f64(0.0); M]);
        for k in 0..D {
            point[k] = T::of(points[k][place]);
        }
        for k in 0..M {
            entry[k] = T::of(entries[k][place]);
        }
        let slopes = K::gradient(own, point, entry);
        for k in 0..F {
            by_own[k][place] = slopes.0[k].kept();
        }
        for k in 0..D {
            by_partner[k][place] = slopes.1[k].kept();
        }
    }
}

/// The derivatives by a body and by partners in columns, aligned to a cache line, which is as wide as the
/// widest registers.
#[derive(Debug)]
#[repr(align(64))]
pub(in crate::scheme::elements) struct GradientBlock<S, const B: usize, const D: usize, const F: usize> {
    pub(in crate::scheme::elements) by_own: [[S; B]; F],
    pub(in crate::scheme::elements) by_partner: [[S; B]; D],
}

impl<S: Scalar, const B: usize, const D: usize, const F: usize> GradientBlock<S, B, D, F> {
    /// Computes the derivatives of the first `most` of a block of partners, of which the first `few` are
    /// needed, in numbers `U`, and again in numbers `T` if a result in `U` is not finite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::scheme::elements) fn fill<T, U, K, const O: usize, const M: usize>(
        &mut self,
        most: usize,
        few: usize,
        own: [T; O],
        points: [&[S; B]; D],
        entries: [&[S; B]; M],
    ) where
        T: Number<S>,
        U: Number<S>,
        K: Pair<O, D, M, F>,
    {
        let mut usual = [U::from_f64(0.0); O];
        for k in 0..O {
            usual[k] = U::of(own[k].kept());
        }
        let Self { by_own, by_partner } = self;
        fill::<S, U, K, O, D, M, F, B>(most, usual, points, entries, by_own, by_partner);
        if TypeId::of::<T>() != TypeId::of::<U>()
            && !(if few == B { self.is_finite(B) } else { self.is_finite(few) })
        {
            self.fill_in_full_range::<T, K, O, M>(few, own, points, entries);
        }
    }

    /// Fills the block in numbers `T`.
    #[cold]
    #[inline(never)]
    pub(in crate::scheme::elements) fn fill_in_full_range<T, K, const O: usize, const M: usize>(
        &mut self,
        few: usize,
        own: [T; O],
        points: [&[S; B]; D],
        entries: [&[S; B]; M],
    ) where
        T: Number<S>,
        K: Pair<O, D, M, F>,
    {
        let Self { by_own, by_partner } = self;
        fill::<S, T, K, O, D, M, F, B>(few, own, points, entries, by_own, by_partner);
    }

    /// Whether the first `few` of all derivatives are finite: of `f64`, by bits without signs, so that there
    /// is no chain of sums.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_finite(&self, few: usize) -> bool {
        let mut poison = 0;
        for numbers in self.by_own.iter().chain(&self.by_partner) {
            match S::as_f64s(&numbers[..few]) {
                Some(numbers) => numbers.iter().for_each(|number| poison |= (number * 0.0).to_bits() << 1),
                None => poison |= u64::from(!are_finite(&numbers[..few])),
            }
        }
        poison == 0
    }
}

/// `sums += slopes`
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn add<const N: usize>(sums: &mut [f64; N], slopes: &[f64; N]) {
    let (mut new, slopes) = (*sums, *slopes);
    for lane in 0..N {
        new[lane] += slopes[lane];
    }
    *sums = new;
}

/// `sums += slopes` for the first `few`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn add_few<const N: usize>(sums: &mut [f64; N], slopes: &[f64; N], few: usize) {
    let mut slopes = *slopes;
    for lane in 0..N {
        slopes[lane] = if lane < few { slopes[lane] } else { -0.0 };
    }
    add(sums, &slopes);
}
