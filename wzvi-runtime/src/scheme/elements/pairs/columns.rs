//! Rows of a large system, with the components of points in columns, in the best vector instructions of the
//! machine.

use std::marker::PhantomData;
use std::ops::Range;

use super::block::BLOCK;
use super::partners::Partners;
use super::{Pair, Row};
use crate::algebra::lanes::instructions::{InstructionSet, Kernel};
use crate::algebra::scalar::Number;
use crate::scheme::elements::gather::LEAST_GATHERED;
use crate::scheme::elements::sums::{ElementInput, PointRun, Sums, VectorRun};
use crate::scheme::elements::{Elements, EvaluationPoint, Partials, WeightedRole};

/// Degrees of freedom from which the copy into columns pays.
pub(in crate::scheme::elements) const LEAST_IN_COLUMNS: usize = 64;

/// Sums that are in columns, one for each component of points, while rows are added. Derivatives are computed
/// in numbers `U`, and in exact numbers where `U` has no finite result.
struct ColumnSums<'a, U> {
    sums: &'a mut [f64],
    /// Columns of coordinates and of sums, each followed by a block of padding.
    room: &'a mut PairColumns,
    number: PhantomData<U>,
}

/// Storage for columns, allocated by the first step of a system with pairs that is large enough.
#[derive(Clone, Debug, Default)]
pub struct PairColumns(Vec<f64>);

impl PairColumns {
    pub(in crate::scheme::elements) const EMPTY: Self = Self(Vec::new());
}

/// Numbers in a line of the cache.
const LINE: usize = 8;

/// Distance of two columns in numbers: the points and a block, rounded up to a cache line.
#[cfg_attr(not(debug_assertions), inline(always))]
fn stride<const D: usize>(degrees: usize) -> usize {
    (degrees / D + BLOCK).next_multiple_of(LINE)
}

/// The part of `room` from the first cache-line boundary on.
#[cfg_attr(not(debug_assertions), inline(always))]
fn on_lines(room: &mut [f64]) -> &mut [f64] {
    let first = room.as_ptr().align_offset(LINE * size_of::<f64>()).min(LINE);
    &mut room[first..]
}

impl<U: Number<f64>> Sums<f64> for ColumnSums<'_, U> {
    type Outer = Range<isize>;
    type Run<'r>
        = VectorRun<'r, f64>
    where
        Self: 'r;
    type Points<'r, const D: usize>
        = PointRun<'r, f64, D>
    where
        Self: 'r;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn outer(&self, variable: usize, values: Range<isize>) -> Range<isize> {
        self.sums.outer(variable, values)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run(&mut self, first: usize, len: usize) -> VectorRun<'_, f64> {
        self.sums.run(first, len)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn points<const D: usize>(&mut self, first: usize, len: usize) -> PointRun<'_, f64, D> {
        self.sums.points(first, len)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add<T: Number<f64>>(&mut self, place: usize, value: T) {
        self.sums.add(place, value);
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn gathers(&self, low: isize, end: isize) -> bool {
        end - low >= LEAST_GATHERED
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn begin_rows<const D: usize>(&mut self, q: &[f64]) {
        let stride = stride::<D>(q.len());
        self.room.0.resize(2 * D * stride + LINE, 0.0);
        let (points, slopes) = (q.as_chunks::<D>().0, self.sums.as_chunks::<D>().0);
        let mut columns = on_lines(&mut self.room.0).chunks_exact_mut(stride);
        for points in [points, slopes] {
            for (k, column) in columns.by_ref().take(D).enumerate() {
                column.iter_mut().zip(points).for_each(|(number, point)| *number = point[k]);
            }
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn row<
        T: Number<f64>,
        K: Pair<O, D, M, F>,
        V: ElementInput<f64> + ?Sized,
        const O: usize,
        const D: usize,
        const M: usize,
        const F: usize,
    >(
        &mut self,
        _interaction: K,
        _q: &V,
        row: Row<'_, T, O, M, F>,
    ) {
        let stride = stride::<D>(self.sums.len());
        let (coordinates, sums) = on_lines(&mut self.room.0).split_at_mut(D * stride);
        let first = row.first / D;
        let (mut points, mut entries) = ([&[][..]; D], [&[][..]; M]);
        for k in 0..D {
            points[k] = &coordinates[k * stride + first..(k + 1) * stride];
        }
        for k in 0..M {
            entries[k] = &row.entries[k][..row.len];
        }
        let partners = Partners { points, sums: &mut *sums, first, stride, entries };
        let totals = partners.meet::<T, U, K, O, F>(&row);
        for k in 0..F {
            let place = row.places[k];
            sums[place % D * stride + place / D] += totals[k];
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn end_rows<const D: usize>(&mut self) {
        let stride = stride::<D>(self.sums.len());
        let slopes = self.sums.as_chunks_mut::<D>().0;
        for (k, column) in on_lines(&mut self.room.0).chunks_exact(stride).skip(D).take(D).enumerate() {
            column.iter().zip(&mut *slopes).for_each(|(number, point)| point[k] = *number);
        }
    }
}

/// Whether derivatives of this system may be computed in vector instructions.
pub(in crate::scheme::elements) const fn may_take_vectors<H: Elements>() -> bool {
    H::FACTS.has_pairs || H::FACTS.gathers.by_q || H::FACTS.gathers.by_p
}

/// Whether derivatives of a system of this size are computed in vector instructions:
/// [rows](crate::scheme::plan::Facts::has_pairs) in columns, and [gathered
/// placements](crate::scheme::plan::Facts::gathers) in blocks.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(in crate::scheme::elements) fn takes_vectors<H: Elements>(wanted: Partials, degrees: usize) -> bool {
    let by_q = wanted.by_q && (H::FACTS.has_pairs || H::FACTS.gathers.by_q);
    (by_q || (wanted.by_p && H::FACTS.gathers.by_p)) && degrees >= LEAST_IN_COLUMNS
}

/// [`Elements::gradient`] with rows in columns and blocks of placements.
struct InColumns<'a, H: Elements> {
    system: &'a H,
    weighted: WeightedRole,
    at: &'a EvaluationPoint<'a, f64>,
    wanted: Partials,
    by_q: ColumnSums<'a, H::CommonRange>,
    by_p: ColumnSums<'a, H::CommonRange>,
}

impl<H: Elements> Kernel for InColumns<'_, H> {
    type Output = ();

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) {
        let Self { system, weighted: WeightedRole { role, weight }, at, wanted, mut by_q, mut by_p } = self;
        system.gradient::<f64, f64>(role, weight, at, wanted, &mut by_q, &mut by_p);
    }
}

/// [`Elements::gradient`] in the best vector instructions of the machine.
#[inline(never)]
pub(in crate::scheme::elements) fn gradient_in_columns<H: Elements>(
    system: &H,
    weighted: WeightedRole,
    at: &EvaluationPoint<'_, f64>,
    wanted: Partials,
    by_q: &mut [f64],
    by_p: &mut [f64],
    room: &mut PairColumns,
) {
    let by_q = ColumnSums { sums: by_q, room, number: PhantomData };
    // No rows add to these.
    let by_p = ColumnSums { sums: by_p, room: &mut PairColumns::default(), number: PhantomData };
    InstructionSet::best().run(InColumns { system, weighted, at, wanted, by_q, by_p });
}
