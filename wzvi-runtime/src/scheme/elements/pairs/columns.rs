//! Rows of a large system: the components of its points in columns, in the best vector instructions of the machine.

use std::cell::Cell;
use std::marker::PhantomData;
use std::ops::Range;

use super::block::BLOCK;
use super::partners::Partners;
use super::{Pair, Row};
use crate::algebra::lanes::instructions::{InstructionSet, Kernel};
use crate::algebra::scalar::Number;
use crate::scheme::elements::beside::{InBlocks, LEAST_BESIDE};
use crate::scheme::elements::sums::{Given, Places, Points, Sums};
use crate::scheme::elements::{Elements, Point, Slopes};

/// Degrees of freedom from which columns are worth their pass.
const LEAST_IN_COLUMNS: usize = 64;

/// Sums of which those that rows add to are in columns while rows are added, one for each component of points. Slopes are computed in
/// numbers `U`, and in others where these do not know the result.
struct Columns<'a, U> {
    sums: &'a mut [f64],
    /// Columns of coordinates, and those of sums, each with a block behind it.
    room: &'a mut Vec<f64>,
    number: PhantomData<U>,
}

/// Numbers in a line of the cache.
const LINE: usize = 8;

/// Numbers from one column to the next: those of the points, and a block, to the end of a line.
#[cfg_attr(not(debug_assertions), inline(always))]
fn stride<const D: usize>(degrees: usize) -> usize {
    (degrees / D + BLOCK).next_multiple_of(LINE)
}

/// The room from the beginning of a line on.
#[cfg_attr(not(debug_assertions), inline(always))]
fn on_lines(room: &mut [f64]) -> &mut [f64] {
    let first = room.as_ptr().align_offset(LINE * size_of::<f64>()).min(LINE);
    &mut room[first..]
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
    type Beside<T: Number<f64>, const M: usize, const F: usize> = InBlocks<T, U, M, F>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn outer(&self, variable: usize, values: Range<isize>) -> Range<isize> {
        self.sums.outer(variable, values)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run(&mut self, first: usize, len: usize) -> Places<'_, f64> {
        self.sums.run(first, len)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn points<const D: usize>(&mut self, first: usize, len: usize) -> Points<'_, f64, D> {
        self.sums.points(first, len)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add<T: Number<f64>>(&mut self, place: usize, value: T) {
        self.sums.add(place, value);
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn gathers(&self, low: isize, end: isize) -> bool {
        end - low >= LEAST_BESIDE
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn begin_rows<const D: usize>(&mut self, q: &[f64]) {
        let stride = stride::<D>(q.len());
        self.room.resize(2 * D * stride + LINE, 0.0);
        let (points, slopes) = (q.as_chunks::<D>().0, self.sums.as_chunks::<D>().0);
        let mut columns = on_lines(self.room).chunks_exact_mut(stride);
        for points in [points, slopes] {
            for (k, column) in columns.by_ref().take(D).enumerate() {
                column.iter_mut().zip(points).for_each(|(number, point)| *number = point[k]);
            }
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
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
        _interaction: K,
        _q: &V,
        row: Row<'_, T, O, P, M, F>,
    ) {
        let stride = stride::<D>(self.sums.len());
        let (coordinates, sums) = on_lines(self.room).split_at_mut(D * stride);
        let first = row.first / D;
        let (mut points, mut entries) = ([&[][..]; D], [&[][..]; M]);
        for k in 0..D {
            points[k] = &coordinates[k * stride + first..(k + 1) * stride];
        }
        for k in 0..M {
            entries[k] = &row.entries[k][..row.len];
        }
        let partners = Partners { points, sums: &mut *sums, first, stride, entries };
        let totals = partners.meet::<T, U, K, O, P, F>(&row);
        for k in 0..F {
            let place = row.places[k];
            sums[place % D * stride + place / D] += totals[k];
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn end_rows<const D: usize>(&mut self) {
        let stride = stride::<D>(self.sums.len());
        let slopes = self.sums.as_chunks_mut::<D>().0;
        for (k, column) in on_lines(self.room).chunks_exact(stride).skip(D).take(D).enumerate() {
            column.iter().zip(&mut *slopes).for_each(|(number, point)| point[k] = *number);
        }
    }
}

/// Whether slopes of any system of this kind are taken in vector instructions.
pub(in crate::scheme::elements) const fn may_take_vectors<H: Elements>() -> bool {
    H::FACTS.has_pairs || H::FACTS.gathers.by_q || H::FACTS.gathers.by_p
}

/// Whether slopes of so many degrees of freedom are taken in vector instructions: [rows](crate::scheme::plan::Facts::has_pairs) in columns, and what
/// [gathers](crate::scheme::plan::Facts::gathers) in blocks.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(in crate::scheme::elements) fn takes_vectors<H: Elements>(wanted: Slopes, degrees: usize) -> bool {
    let by_q = wanted.by_q && (H::FACTS.has_pairs || H::FACTS.gathers.by_q);
    (by_q || (wanted.by_p && H::FACTS.gathers.by_p)) && degrees >= LEAST_IN_COLUMNS
}

/// [`Elements::slopes`] with rows in columns and blocks of placements.
struct InColumns<'a, H: Elements> {
    system: &'a H,
    part: usize,
    weight: f64,
    at: &'a Point<'a, f64>,
    wanted: Slopes,
    by_q: Columns<'a, H::Usual>,
    by_p: Columns<'a, H::Usual>,
}

impl<H: Elements> Kernel for InColumns<'_, H> {
    type Output = ();

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) {
        let Self { system, part, weight, at, wanted, mut by_q, mut by_p } = self;
        system.slopes::<f64, H::Exact>(part, weight, at, wanted, &mut by_q, &mut by_p);
    }
}

thread_local! {
    /// Room for columns: allocated by the first step of a thread.
    static ROOM: Cell<Vec<f64>> = const { Cell::new(Vec::new()) };
}

/// [`Elements::slopes`] in the best vector instructions of the machine.
#[inline(never)]
pub(in crate::scheme::elements) fn slopes<H: Elements>(
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
    // No rows add to these.
    let by_p = Columns { sums: by_p, room: &mut Vec::new(), number: PhantomData };
    InstructionSet::best().run(InColumns { system, part, weight, at, wanted, by_q, by_p });
    ROOM.try_with(|kept| kept.set(room)).unwrap_or_default();
}
