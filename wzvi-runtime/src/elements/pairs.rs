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

use std::any::TypeId;
use std::cell::Cell;
use std::marker::PhantomData;
use std::ops::Range;

use super::sums::{Given, Places, Points, Run, Sums};
use super::{Elements, Point, Slopes};
use crate::lanes::instructions::{InstructionSet, Kernel};
use crate::scalar::{Number, Scalar};

/// Partners whose slopes are computed beside each other, on every machine.
pub(super) const LANES: usize = 8;

/// Degrees of freedom from which columns are worth their pass.
const LEAST_IN_COLUMNS: usize = 48;

/// The slopes of an element by two points: by `F` degrees of freedom of a body that is the same in a row, and by the `D` components of a
/// partner.
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
#[inline(always)]
fn total<T: Scalar>([a, b, c, d, e, f, g, h]: [T; LANES]) -> T {
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

impl<T: Scalar, const O: usize, const P: usize, const M: usize, const F: usize> Row<'_, T, O, P, M, F> {
    /// Adds the slopes by the partner at `place` of the row, and gives those by the body.
    #[inline(always)]
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
#[inline(always)]
fn gather<T: Scalar, const F: usize>(sums: &mut [T; F], slopes: [T; F]) {
    for k in 0..F {
        sums[k] = sums[k] + slopes[k];
    }
}

/// A row in whatever numbers and sums: [`Sums::row`].
#[inline(always)]
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
    let whole = len / LANES * LANES;
    let mut sums = [T::from_f64(0.0); F];
    if whole > 0 {
        let mut lanes = [[T::from_f64(0.0); F]; LANES];
        for place in 0..whole {
            let slopes = row.meet::<S, K, D>(place, points[place], &mut partners);
            gather(&mut lanes[place % LANES], slopes);
        }
        for k in 0..F {
            sums[k] = total(lanes.map(|lane| lane[k]));
        }
    }
    for place in whole..len {
        gather(&mut sums, row.meet::<S, K, D>(place, points[place], &mut partners));
    }
    drop(partners);
    for k in 0..F {
        into.add(row.places[k], sums[k]);
    }
}

/// Partners whose slopes are computed in one loop, which the compiler takes for one over neighbours: half as many it would write out.
const BLOCK: usize = 2 * LANES;

/// The same where a row has as many: sums wait for the loop before.
const LARGE_BLOCK: usize = 2 * BLOCK;

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

/// The slopes by a body, and those by partners in columns.
struct Block<const B: usize, const D: usize, const F: usize> {
    by_own: [[f64; B]; F],
    by_partner: [[f64; B]; D],
}

impl<const B: usize, const D: usize, const F: usize> Block<B, D, F> {
    /// Those of a block of partners, of which the first `few` are of interest, computed in numbers `U`; in numbers `T` where these do not
    /// know the result.
    #[inline(always)]
    fn fill<T, U, K, const O: usize, const P: usize, const M: usize>(
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
fn add<const N: usize>(sums: &mut [f64; N], slopes: &[f64; N]) {
    let (mut new, slopes) = (*sums, *slopes);
    for lane in 0..N {
        new[lane] += slopes[lane];
    }
    *sums = new;
}

/// The same of the first `few`.
#[inline(always)]
fn add_few<const N: usize>(sums: &mut [f64; N], slopes: &[f64; N], few: usize) {
    let mut slopes = *slopes;
    for lane in 0..N {
        slopes[lane] = if lane < few { slopes[lane] } else { -0.0 };
    }
    add(sums, &slopes);
}

/// The partners of a row in columns: coordinates and sums, with room for as many behind as are in a block, and entries of tables.
struct Partners<'r, const D: usize, const M: usize> {
    points: [&'r [f64]; D],
    sums: [&'r mut [f64]; D],
    entries: [&'r [f64]; M],
}

impl<const D: usize, const M: usize> Partners<'_, D, M> {
    /// Adds the slopes by whole blocks of partners from `first` on to their sums, and those by the body to the sums of lanes; which partner is
    /// the next.
    #[inline(always)]
    fn meet_blocks<T, U, K, const O: usize, const P: usize, const F: usize, const B: usize>(
        &mut self,
        row: &Row<'_, T, O, P, M, F>,
        first: usize,
        lanes: &mut [[f64; LANES]; F],
    ) -> usize
    where
        T: Number<f64>,
        U: Number<f64>,
        K: Pair<O, P, D, M, F>,
    {
        let blocks = (row.len - first) / B;
        let points = self.points.map(|column| &column[first..].as_chunks::<B>().0[..blocks]);
        let sums = self.sums.each_mut().map(|column| &mut column[first..].as_chunks_mut::<B>().0[..blocks]);
        let entries = self.entries.map(|list| &list[first..].as_chunks::<B>().0[..blocks]);
        let mut block = Block { by_own: [[0.0; B]; F], by_partner: [[0.0; B]; D] };
        for number in 0..blocks {
            let (points, entries) = (points.map(|column| &column[number]), entries.map(|list| &list[number]));
            block.fill::<T, U, K, O, P, M>(row, B, points, entries);
            for k in 0..D {
                add(&mut sums[k][number], &block.by_partner[k]);
            }
            for k in 0..F {
                for slopes in block.by_own[k].as_chunks::<LANES>().0 {
                    add(&mut lanes[k], slopes);
                }
            }
        }
        first + B * blocks
    }

    /// Adds the slopes by all partners to their sums; the sums of those by the body.
    #[inline(always)]
    fn meet<T, U, K, const O: usize, const P: usize, const F: usize>(
        mut self,
        row: &Row<'_, T, O, P, M, F>,
    ) -> [f64; F]
    where
        T: Number<f64>,
        U: Number<f64>,
        K: Pair<O, P, D, M, F>,
    {
        let (mut lanes, mut first) = ([[0.0; LANES]; F], 0);
        if row.len >= LARGE_BLOCK {
            first = self.meet_blocks::<T, U, K, O, P, F, LARGE_BLOCK>(row, 0, &mut lanes);
        }
        let mut block = Block { by_own: [[0.0; BLOCK]; F], by_partner: [[0.0; BLOCK]; D] };
        let mut few = 0;
        while first < row.len {
            few = BLOCK.min(row.len - first);
            let points = self.points.map(|column| &column[first..].as_chunks().0[0]);
            let entries = self.entries.map(|list| filled(&list[first..row.len]));
            block.fill::<T, U, K, O, P, M>(row, few, points, entries.each_ref());
            for k in 0..D {
                let sums = &mut self.sums[k][first..].as_chunks_mut().0[0];
                add_few(sums, &block.by_partner[k], few);
            }
            for k in 0..F {
                for slopes in &block.by_own[k].as_chunks::<LANES>().0[..few / LANES] {
                    add(&mut lanes[k], slopes);
                }
            }
            first += few;
        }
        let mut totals = if row.len >= LANES { lanes.map(total) } else { [0.0; F] };
        for place in few / LANES * LANES..few {
            for k in 0..F {
                totals[k] += block.by_own[k][place];
            }
        }
        totals
    }
}

/// The first numbers of a list, and the last of them again where there are too few.
#[inline(always)]
fn filled(numbers: &[f64]) -> [f64; BLOCK] {
    if let Some(all) = numbers.first_chunk() {
        return *all;
    }
    let mut all = [0.0; BLOCK];
    let last = numbers.len().saturating_sub(1);
    for (place, number) in all.iter_mut().enumerate() {
        *number = numbers[place.min(last)];
    }
    all
}

/// Sums of which those that rows add to are in columns while rows are added, one for each component of points. Slopes are computed in
/// numbers `U`, and in others where these do not know the result.
struct Columns<'a, U> {
    sums: &'a mut [f64],
    /// Columns of coordinates, and those of sums, each with a block behind it.
    room: &'a mut Vec<f64>,
    number: PhantomData<U>,
}

/// The columns of coordinates, and those of sums.
#[inline(always)]
fn halves_mut(room: &mut [f64]) -> (&mut [f64], &mut [f64]) {
    room.split_at_mut(room.len() / 2)
}

/// The numbers of points, component by component.
#[inline(always)]
fn columns<const D: usize>(list: &[f64]) -> [&[f64]; D] {
    let mut columns = list.chunks_exact(list.len() / D);
    [(); D].map(|()| columns.next().unwrap_or_default())
}

/// The same, to be written.
#[inline(always)]
fn columns_mut<const D: usize>(list: &mut [f64]) -> [&mut [f64]; D] {
    let mut columns = list.chunks_exact_mut(list.len() / D);
    [(); D].map(|()| columns.next().unwrap_or_default())
}

impl<U: Number<f64>> Sums<f64> for Columns<'_, U> {
    type Outer = Range<isize>;
    type Run<'r>
        = Places<'r, f64>
    where
        Self: 'r;
    type Points<'r, const D: usize>
        = Points<'r, f64, D>
    where
        Self: 'r;

    #[inline(always)]
    fn outer(&self, variable: usize, values: Range<isize>) -> Range<isize> {
        self.sums.outer(variable, values)
    }
    #[inline(always)]
    fn clip<const D: usize, const N: usize>(&self, len: usize, first: [usize; N]) -> (usize, usize) {
        self.sums.clip::<D, N>(len, first)
    }
    #[inline(always)]
    fn run(&mut self, first: usize, len: usize) -> Places<'_, f64> {
        self.sums.run(first, len)
    }
    #[inline(always)]
    fn points<const D: usize>(&mut self, first: usize, len: usize) -> Points<'_, f64, D> {
        self.sums.points(first, len)
    }
    #[inline(always)]
    fn add<T: Number<f64>>(&mut self, place: usize, value: T) {
        self.sums.add(place, value);
    }

    #[inline(always)]
    fn begin_rows<const D: usize>(&mut self, q: &[f64]) {
        self.room.resize(2 * (q.len() + D * BLOCK), 0.0);
        let (coordinates, sums) = halves_mut(self.room);
        let (coordinates, sums) = (columns_mut::<D>(coordinates), columns_mut::<D>(sums));
        let (points, slopes) = (q.as_chunks::<D>().0, self.sums.as_chunks::<D>().0);
        for (k, (coordinates, sums)) in coordinates.into_iter().zip(sums).enumerate() {
            coordinates.iter_mut().zip(points).for_each(|(number, point)| *number = point[k]);
            sums.iter_mut().zip(slopes).for_each(|(number, point)| *number = point[k]);
        }
    }

    #[inline(always)]
    fn row<
        T: Number<f64>,
        K: Pair<O, P, D, M, F>,
        V: Given<f64> + ?Sized,
        const O: usize,
        const P: usize,
        const D: usize,
        const M: usize,
        const F: usize,
    >(
        &mut self,
        _q: &V,
        row: Row<'_, T, O, P, M, F>,
    ) {
        let (coordinates, sums) = halves_mut(self.room);
        let mut sums = columns_mut::<D>(sums);
        let first = row.first / D;
        let points = columns::<D>(coordinates).map(|column| &column[first..]);
        let of_partners = sums.each_mut().map(|column| &mut column[first..]);
        let partners = Partners { points, sums: of_partners, entries: row.entries };
        let totals = partners.meet::<T, U, K, O, P, F>(&row);
        for k in 0..F {
            sums[row.places[k] % D][row.places[k] / D] += totals[k];
        }
    }

    #[inline(always)]
    fn end_rows<const D: usize>(&mut self) {
        let (_, sums) = halves_mut(self.room);
        let slopes = self.sums.as_chunks_mut::<D>().0;
        for (k, sums) in columns::<D>(sums).into_iter().enumerate() {
            sums.iter().zip(&mut *slopes).for_each(|(number, point)| point[k] = *number);
        }
    }
}

/// Whether slopes of so many degrees of freedom are taken in columns, if the system [has pairs](Elements::HAS_PAIRS).
#[inline(always)]
pub(super) fn takes_columns(wanted: Slopes, degrees: usize) -> bool {
    wanted.by_q && degrees >= LEAST_IN_COLUMNS
}

/// [`Elements::slopes`] with rows in columns.
struct InColumns<'a, H: Elements> {
    system: &'a H,
    part: usize,
    weight: f64,
    at: &'a Point<'a, f64>,
    wanted: Slopes,
    by_q: Columns<'a, H::Usual>,
    by_p: &'a mut [f64],
}

impl<H: Elements> Kernel for InColumns<'_, H> {
    type Output = ();

    #[inline(always)]
    fn run<const L: usize, const HALF: usize>(self) {
        let Self { system, part, weight, at, wanted, mut by_q, by_p } = self;
        system.slopes::<f64, H::Exact, [f64], _, [f64]>(part, weight, at, wanted, &mut by_q, by_p);
    }
}

thread_local! {
    /// Room for columns: allocated by the first step of a thread.
    static ROOM: Cell<Vec<f64>> = const { Cell::new(Vec::new()) };
}

/// [`Elements::slopes`] in the best vector instructions of the machine.
#[inline(never)]
pub(super) fn slopes<H: Elements>(
    system: &H,
    part: usize,
    weight: f64,
    at: &Point<'_, f64>,
    wanted: Slopes,
    by_q: &mut [f64],
    by_p: &mut [f64],
) {
    // A thread that ends has no room any more.
    let mut room = ROOM.try_with(Cell::take).unwrap_or_default();
    let by_q = Columns { sums: by_q, room: &mut room, number: PhantomData };
    InstructionSet::best().run(InColumns { system, part, weight, at, wanted, by_q, by_p });
    ROOM.try_with(|kept| kept.set(room)).unwrap_or_default();
}
