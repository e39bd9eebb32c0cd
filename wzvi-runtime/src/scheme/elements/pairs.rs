//! Sums over pairs of bodies, in vector instructions.
//!
//! The pairs of one body are a [`Row`]: its partners are points next to each other in the state. The slopes of [`LANES`] of them are
//! computed beside each other. Those by the partners go back where these are, those by the body itself into as many sums, one for each
//! lane, which are added in the order of a fixed tree; what is left of a row is added after that, partner by partner:
//!
//! ```text
//! ∂V/∂q_i = ((s_0 + s_4) + (s_2 + s_6)) + ((s_1 + s_5) + (s_3 + s_7)) + rest,   s_l = Σ_c ∂V(q_i, q_{8c+l})/∂q_i
//! ```
//!
//! That is the order of every number type and instruction set, so that bits depend on neither. Rows of less than [`LANES`] partners are
//! added one by one.
//!
//! The components of points are taken apart into columns first, which costs a pass over the state where the pairs take its square.

#![expect(clippy::needless_range_loop, reason = "plain loops over arrays are what becomes vector code")]

mod block;
mod columns;
mod partners;

use super::sums::{Given, Run, Sums};
use crate::algebra::scalar::{Number, Scalar};

pub(super) use block::Block;
pub(super) use columns::{may_take_vectors, slopes, takes_vectors};

/// Partners whose slopes are computed beside each other, on every machine.
pub(super) const LANES: usize = 8;

/// The slopes of an element by two points: by `F` degrees of freedom of a body that is the same in a row, and by the `D` components of a
/// partner. Where an element has no partners in a row, but placements [beside each other](super::Placements), all that it reads are entries.
pub trait Pair<const O: usize, const P: usize, const D: usize, const M: usize, const F: usize> {
    /// From numbers of the body, constants, the partner, and entries of tables beside it.
    fn slopes<T: Scalar>(
        own: [T; O],
        constants: [f64; P],
        partner: [T; D],
        entries: [T; M],
    ) -> ([T; F], [T; D]);
}

/// One body and its partners.
#[derive(Debug)]
pub struct Row<'a, T, const O: usize, const P: usize, const M: usize, const F: usize> {
    /// The place of the first component of the first partner.
    pub first: usize,
    /// How many partners there are.
    pub len: usize,
    /// Numbers of the body.
    pub own: [T; O],
    /// Constants.
    pub constants: [f64; P],
    /// Entries of tables, from that of the first partner on.
    pub entries: [&'a [f64]; M],
    /// The places of the slopes by the body.
    pub places: [usize; F],
}

/// The sum of the sums of all lanes.
#[cfg_attr(not(debug_assertions), inline(always))]
fn total<T: Scalar>([a, b, c, d, e, f, g, h]: [T; LANES]) -> T {
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

impl<T: Scalar, const O: usize, const P: usize, const M: usize, const F: usize> Row<'_, T, O, P, M, F> {
    /// Adds the slopes by the partner at `place` of the row, and gives those by the body.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn meet<S: Copy, K: Pair<O, P, D, M, F>, const D: usize>(
        &self,
        place: usize,
        partner: [S; D],
        into: &mut impl Run<S>,
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
        let (by_own, by_partner) = K::slopes(self.own, self.constants, point, entries);
        for k in 0..D {
            into.add_part(place, k, by_partner[k]);
        }
        by_own
    }
}

/// Adds slopes to sums.
#[cfg_attr(not(debug_assertions), inline(always))]
fn gather<T: Scalar, const F: usize>(sums: &mut [T; F], slopes: [T; F]) {
    for k in 0..F {
        sums[k] = sums[k] + slopes[k];
    }
}

/// A row in whatever numbers and sums: [`Sums::row`].
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn add_row<
    S: Scalar,
    T: Number<S>,
    K: Pair<O, P, D, M, F>,
    V: Given<S> + ?Sized,
    A: Sums<S> + ?Sized,
    const O: usize,
    const P: usize,
    const D: usize,
    const M: usize,
    const F: usize,
>(
    into: &mut A,
    q: &V,
    row: Row<'_, T, O, P, M, F>,
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
