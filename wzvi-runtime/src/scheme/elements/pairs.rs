//! Sums over pairs of bodies, in vector instructions.
//!
//! The pairs of one body form a [`Row`]: its partners are adjacent points of the state. The derivatives of
//! [`LANES`] pairs are computed together. Derivatives by the partners go to the sums of the partners.
//! Derivatives by the body go to one sum for each lane; these sums are added in the order of a fixed tree,
//! followed by the rest of the row, partner by partner:
//!
//! ```text
//! ∂V/∂q_i = ((s_0 + s_4) + (s_2 + s_6)) + ((s_1 + s_5) + (s_3 + s_7)) + rest,   s_l = Σ_c ∂V(q_i, q_{8c+l})/∂q_i
//! ```
//!
//! This order is the same for every number type and instruction set, so that the bits depend on neither. Rows
//! of fewer than [`LANES`] partners are added one by one.
//!
//! The components of points are first copied into columns, which takes `O(N)` operations where the pairs take
//! `O(N²)`.

#![expect(clippy::needless_range_loop, reason = "plain loops over arrays are what becomes vector code")]

mod block;
mod columns;
mod partners;

use super::sums::{AdjacentSums, ElementInput, Sums};
use crate::algebra::scalar::{Number, Scalar};

pub(super) use block::GradientBlock;
pub use columns::PairColumns;
pub(super) use columns::{LEAST_IN_COLUMNS, gradient_in_columns, may_take_vectors, takes_vectors};

/// Number of partners whose derivatives are computed together, on every machine.
pub(super) const LANES: usize = 8;

/// The derivatives of an element by two points: by `F` degrees of freedom of a body, the same for a whole
/// row, and by the `D` components of a partner. For placements that are [evaluated
/// together](super::Placements), without partners, all numbers that are read are entries.
pub trait Pair<const O: usize, const D: usize, const M: usize, const F: usize> {
    /// The derivatives from numbers of the body and constants, the partner, and its entries of tables.
    fn gradient<T: Scalar>(own: [T; O], partner: [T; D], entries: [T; M]) -> ([T; F], [T; D]);
}

/// One body and its partners.
#[derive(Debug)]
pub struct Row<'a, T: Scalar, const O: usize, const M: usize, const F: usize> {
    /// The place of the first component of the first partner.
    pub first: usize,
    /// Number of partners.
    pub len: usize,
    /// Numbers of the body.
    pub own: [T; O],
    /// Entries of tables, starting with those of the first partner.
    pub entries: [&'a [f64]; M],
    /// The places of the derivatives by the body.
    pub places: [usize; F],
}

/// The sum over all lanes.
#[cfg_attr(not(debug_assertions), inline(always))]
fn total<T: Scalar>([a, b, c, d, e, f, g, h]: [T; LANES]) -> T {
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

impl<T: Scalar, const O: usize, const M: usize, const F: usize> Row<'_, T, O, M, F> {
    /// Adds the derivatives by the partner at `place` of the row, and returns those by the body.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn meet<S: Scalar, K: Pair<O, D, M, F>, const D: usize>(
        &self,
        place: usize,
        partner: [S; D],
        into: &mut impl AdjacentSums<S>,
    ) -> [T; F]
    where
        T: Number<S>,
    {
        let (mut point, mut entries) = ([T::from_f64(0.0); D], [T::from_f64(0.0); M]);
        for k in 0..D {
            point[k] = T::of(partner[k]);
        }
        for k in 0..M {
            entries[k] = T::from_f64(self.entries[k][place]);
        }
        let (by_own, by_partner) = K::gradient(self.own, point, entries);
        for k in 0..D {
            into.add_part(place, k, by_partner[k]);
        }
        by_own
    }
}

/// Adds derivatives to sums.
#[cfg_attr(not(debug_assertions), inline(always))]
fn gather<T: Scalar, const F: usize>(sums: &mut [T; F], slopes: [T; F]) {
    for k in 0..F {
        sums[k] = sums[k] + slopes[k];
    }
}

/// [`Sums::row`] for any numbers and sums.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn add_row<
    S: Scalar,
    T: Number<S>,
    K: Pair<O, D, M, F>,
    V: ElementInput<S> + ?Sized,
    A: Sums<S> + ?Sized,
    const O: usize,
    const D: usize,
    const M: usize,
    const F: usize,
>(
    into: &mut A,
    q: &V,
    row: Row<'_, T, O, M, F>,
) {
    let Row { first, len, .. } = row;
    let row = Row { entries: row.entries.map(|list| &list[..len]), ..row };
    let points = &q[first..first + D * len].as_chunks::<D>().0[..len];
    let mut partners = into.points::<D>(first, len);
    let mut sums = [T::from_f64(0.0); F];
    if len < LANES {
        for (place, point) in points.iter().enumerate() {
            gather(&mut sums, row.meet::<S, K, D>(place, *point, &mut partners));
        }
    } else {
        let (whole, mut lanes) = (len / LANES * LANES, [[T::from_f64(0.0); F]; LANES]);
        for place in 0..whole {
            let slopes = row.meet::<S, K, D>(place, points[place], &mut partners);
            gather(&mut lanes[place % LANES], slopes);
        }
        for k in 0..F {
            sums[k] = total(lanes.map(|lane| lane[k]));
        }
        for place in whole..len {
            gather(&mut sums, row.meet::<S, K, D>(place, points[place], &mut partners));
        }
    }
    drop(partners);
    for k in 0..F {
        into.add(row.places[k], sums[k]);
    }
}
