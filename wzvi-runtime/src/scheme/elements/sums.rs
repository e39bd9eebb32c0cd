//! The sums that the derivatives of elements are added to.
//!
//! The loops of a system give the places and the values that a run of placements adds. The types here decide
//! whether these go to a vector, to the part of a vector in a tile, or directly to the new state.

use std::ops::{Index, Range};

use super::pairs::{Pair, Row, add_row};
use crate::algebra::scalar::{Number, Scalar};

/// Input numbers of elements by degree of freedom: all of them, or a slice of them.
pub trait ElementInput<S>: Index<usize, Output = S> + Index<Range<usize>, Output = [S]> {
    /// The degrees of freedom of the system.
    fn degrees(&self) -> usize;
}

impl<S> ElementInput<S> for [S] {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn degrees(&self) -> usize {
        self.len()
    }
}

/// Sums by degree of freedom.
pub trait Sums<S: Scalar> {
    /// Values of the variable of a loop.
    type Outer: Iterator<Item = isize>;
    /// Adjacent sums.
    type Run<'r>: AdjacentSums<S>
    where
        Self: 'r;
    /// Adjacent sums, in points of `D` components.
    type Points<'r, const D: usize>: AdjacentSums<S>
    where
        Self: 'r;

    /// The `values` of the outermost loop number `variable` whose placements add to any of the sums.
    fn outer(&self, variable: usize, values: Range<isize>) -> Self::Outer;

    /// How many of `len` placements to skip, and how many to take then. The placements add to consecutive
    /// points of `D` components from the places `first` on.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn clip<const D: usize, const N: usize>(&self, len: usize, first: [usize; N]) -> (usize, usize) {
        let _ = first;
        (0, len)
    }

    /// The first and the number of the placements `low..end` of a loop that are taken, by [`Sums::clip`];
    /// placement `low` adds to the places `first`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn stretch<const D: usize, const N: usize>(
        &self,
        low: isize,
        end: isize,
        first: [usize; N],
    ) -> (isize, usize) {
        let (low, len) = stretch(low, end);
        if len == 0 {
            return (low, 0);
        }
        let (skipped, len) = self.clip::<D, N>(len, first);
        (low + skipped as isize, len)
    }

    /// The sums of `len` places from `first` on.
    fn run(&mut self, first: usize, len: usize) -> Self::Run<'_>;

    /// The sums of `len` points from place `first` on.
    fn points<const D: usize>(&mut self, first: usize, len: usize) -> Self::Points<'_, D>;

    /// Adds to a place.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add<T: Number<S>>(&mut self, place: usize, value: T) {
        self.run(place, 1).add(0, value);
    }

    /// Whether the placements of a loop from `low` to `end` are evaluated [together](super::Placements).
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn gathers(&self, _low: isize, _end: isize) -> bool {
        false
    }

    /// Called before the rows of an element whose partners are points of `D` components in the coordinates
    /// `q`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn begin_rows<const D: usize>(&mut self, _q: &[S]) {}

    /// Adds the derivatives by a body and its partners, see [`Pair`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn row<
        T: Number<S>,
        K: Pair<O, D, M, F>,
        V: ElementInput<S> + ?Sized,
        const O: usize,
        const D: usize,
        const M: usize,
        const F: usize,
    >(
        &mut self,
        _interaction: K,
        q: &V,
        row: Row<'_, T, O, M, F>,
    ) where
        S: Scalar,
    {
        add_row::<S, T, K, V, Self, O, D, M, F>(self, q, row);
    }

    /// Called after the rows of an element.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn end_rows<const D: usize>(&mut self) {}
}

/// Adjacent sums.
pub trait AdjacentSums<S: Scalar> {
    /// Adds to a place.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add<T: Number<S>>(&mut self, place: usize, value: T) {
        self.add_part(place, 0, value);
    }
    /// Adds to the part of a point.
    fn add_part<T: Number<S>>(&mut self, place: usize, part: usize, value: T);
}

/// `sum += value`
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn add_to<S: Scalar, T: Number<S>>(sum: &mut S, value: T) {
    *sum = (T::of(*sum) + value).kept();
}

/// The first of the placements `low..end` of a loop, and how many there are.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn stretch(low: isize, end: isize) -> (isize, usize) {
    (low, if low < end { (end - low) as usize } else { 0 })
}

/// How many of `len` placements may be taken together if their derivatives are first added to the places from
/// `first` on and then to those from `second` on, such that each place gets its derivatives in the order of
/// the placements.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn disjoint_placements(len: usize, first: usize, second: usize) -> usize {
    if second > first { len.min(second - first) } else { len }
}

/// All of a vector.
impl<S: Scalar> Sums<S> for [S] {
    type Outer = Range<isize>;
    type Run<'r> = VectorRun<'r, S>;
    type Points<'r, const D: usize> = PointRun<'r, S, D>;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn outer(&self, _variable: usize, values: Range<isize>) -> Range<isize> {
        values
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run(&mut self, first: usize, len: usize) -> VectorRun<'_, S> {
        VectorRun(&mut self[first..first + len])
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn points<const D: usize>(&mut self, first: usize, len: usize) -> PointRun<'_, S, D> {
        PointRun(&mut self[first..first + D * len].as_chunks_mut::<D>().0[..len])
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add<T: Number<S>>(&mut self, place: usize, value: T) {
        add_to(&mut self[place], value);
    }
}

/// Sums of a known number and one term, for a whole vector: `next[i] = base[i] + term`.
pub(super) struct OntoVector<'a, S> {
    pub(super) base: &'a [S],
    pub(super) next: &'a mut [S],
}

impl<S: Scalar> Sums<S> for OntoVector<'_, S> {
    type Outer = Range<isize>;
    type Run<'r>
        = OntoRun<'r, S, 1>
    where
        Self: 'r;
    type Points<'r, const D: usize>
        = OntoRun<'r, S, D>
    where
        Self: 'r;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn outer(&self, _variable: usize, values: Range<isize>) -> Range<isize> {
        values
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run(&mut self, first: usize, len: usize) -> OntoRun<'_, S, 1> {
        self.points::<1>(first, len)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn points<const D: usize>(&mut self, first: usize, len: usize) -> OntoRun<'_, S, D> {
        let places = first..first + D * len;
        OntoRun::new(&self.base[places.clone()], &mut self.next[places])
    }
}

/// A slice of such sums, in points.
pub(super) struct OntoRun<'r, S, const D: usize> {
    base: &'r [[S; D]],
    next: &'r mut [[S; D]],
}

impl<'r, S, const D: usize> OntoRun<'r, S, D> {
    /// From two lists of the same length.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn new(base: &'r [S], next: &'r mut [S]) -> Self {
        let (base, next) = (base.as_chunks().0, next.as_chunks_mut().0);
        let len = base.len().min(next.len());
        Self { base: &base[..len], next: &mut next[..len] }
    }
}

impl<S: Scalar, const D: usize> AdjacentSums<S> for OntoRun<'_, S, D> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_part<T: Number<S>>(&mut self, place: usize, part: usize, value: T) {
        self.next[place][part] = (T::of(self.base[place][part]) + value).kept();
    }
}

/// A slice of a vector.
#[derive(Debug)]
pub struct VectorRun<'r, S>(pub(super) &'r mut [S]);

impl<S: Scalar> AdjacentSums<S> for VectorRun<'_, S> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_part<T: Number<S>>(&mut self, place: usize, part: usize, value: T) {
        add_to(&mut self.0[place + part], value);
    }
}

/// Points of a vector.
#[derive(Debug)]
pub struct PointRun<'r, S, const D: usize>(pub(super) &'r mut [[S; D]]);

impl<S: Scalar, const D: usize> AdjacentSums<S> for PointRun<'_, S, D> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_part<T: Number<S>>(&mut self, place: usize, part: usize, value: T) {
        add_to(&mut self.0[place][part], value);
    }
}
