//! The sums that the derivatives of a tile are added to.

use std::ops::{Index, Range};

use super::super::step::nothing;
use super::super::sums::{AdjacentSums, ElementInput, OntoRun, PointRun, Sums};
use super::layout::{LoopValues, Tile};
use crate::algebra::scalar::Number;

/// Coordinates or momenta of the places from `first` on.
#[derive(Clone, Copy)]
pub(super) struct OffsetSlice<'a> {
    pub(super) numbers: &'a [f64],
    pub(super) first: usize,
    /// The degrees of freedom of the system.
    pub(super) degrees: usize,
}

impl Index<usize> for OffsetSlice<'_> {
    type Output = f64;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn index(&self, place: usize) -> &f64 {
        &self.numbers[place - self.first]
    }
}

impl Index<Range<usize>> for OffsetSlice<'_> {
    type Output = [f64];

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn index(&self, places: Range<usize>) -> &[f64] {
        &self.numbers[places.start - self.first..places.end - self.first]
    }
}

impl ElementInput<f64> for OffsetSlice<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn degrees(&self) -> usize {
        self.degrees
    }
}

/// Sums of a tile in a separate list. Sums before `filled` have terms; the next term of any other sum is
/// its first.
pub(super) struct TileSums<'a> {
    tile: Tile<'a>,
    sums: &'a mut [f64],
    filled: usize,
}

impl<'a> TileSums<'a> {
    /// Sums without terms.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn empty(tile: Tile<'a>, sums: &'a mut [f64]) -> Self {
        Self { tile, sums, filled: 0 }
    }

    /// Sums that begin with the numbers of the tile.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn onto(tile: Tile<'a>, sums: &'a mut [f64], numbers: &[f64]) -> Self {
        let (own, filled) = (tile.own(), tile.unread());
        sums[..own.start].fill(nothing());
        sums[own.clone()].copy_from_slice(numbers);
        sums[own.end..filled].fill(nothing());
        Self { tile, sums, filled }
    }

    /// The position of the sums of `len` places from `first` on, and whether they have no term yet.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn open(&mut self, first: usize, len: usize) -> (usize, bool) {
        let position = self.tile.position(first, len);
        let end = position + len;
        if end <= self.filled || position >= self.tile.unread() {
            return (position, false);
        }
        let is_fresh = position >= self.filled;
        self.sums[self.filled..if is_fresh { position } else { end }].fill(nothing());
        self.filled = end;
        (position, is_fresh)
    }

    /// The sums of the tile.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn finish(self) -> &'a [f64] {
        let Self { tile, sums, filled } = self;
        let own = tile.own();
        if filled < own.end {
            sums[filled..own.end].fill(nothing());
        }
        &sums[own]
    }
}

impl<'a> Sums<f64> for TileSums<'a> {
    type Outer = LoopValues<'a>;
    type Run<'r>
        = TileRun<'r>
    where
        Self: 'r;
    type Points<'r, const D: usize>
        = PointRun<'r, f64, D>
    where
        Self: 'r;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn outer(&self, variable: usize, _values: Range<isize>) -> LoopValues<'a> {
        self.tile.outer(variable)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn clip<const D: usize, const N: usize>(&self, len: usize, first: [usize; N]) -> (usize, usize) {
        self.tile.clip::<D, N>(len, first)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run(&mut self, first: usize, len: usize) -> TileRun<'_> {
        let (position, is_fresh) = self.open(first, len);
        TileRun { sums: &mut self.sums[position..position + len], is_fresh }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn points<const D: usize>(&mut self, first: usize, len: usize) -> PointRun<'_, f64, D> {
        let (position, is_fresh) = self.open(first, D * len);
        let points = self.sums.points(position, len);
        if is_fresh {
            points.0.fill([nothing(); D]);
        }
        points
    }
}

/// A slice of the sums of a tile.
pub(super) struct TileRun<'r> {
    sums: &'r mut [f64],
    is_fresh: bool,
}

impl AdjacentSums<f64> for TileRun<'_> {
    // Written out: with the default, a step of `Verlet` on a lattice takes 10 % longer.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add<T: Number<f64>>(&mut self, place: usize, value: T) {
        let sum = if self.is_fresh { nothing() } else { self.sums[place] };
        self.sums[place] = (T::of(sum) + value).kept();
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add_part<T: Number<f64>>(&mut self, place: usize, part: usize, value: T) {
        self.add(place + part, value);
    }
}

/// Sums of a known number and one term: `next[i] = base[i] + term`.
pub(super) struct OntoTile<'a> {
    pub(super) tile: Tile<'a>,
    pub(super) base: OffsetSlice<'a>,
    /// The places from `first` on.
    pub(super) next: &'a mut [f64],
    pub(super) first: usize,
}

impl<'a> Sums<f64> for OntoTile<'a> {
    type Outer = LoopValues<'a>;
    type Run<'r>
        = OntoRun<'r, f64, 1>
    where
        Self: 'r;
    type Points<'r, const D: usize>
        = OntoRun<'r, f64, D>
    where
        Self: 'r;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn outer(&self, variable: usize, _values: Range<isize>) -> LoopValues<'a> {
        self.tile.outer(variable)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn clip<const D: usize, const N: usize>(&self, len: usize, first: [usize; N]) -> (usize, usize) {
        self.tile.clip::<D, N>(len, first)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run(&mut self, first: usize, len: usize) -> OntoRun<'_, f64, 1> {
        self.points::<1>(first, len)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn points<const D: usize>(&mut self, first: usize, len: usize) -> OntoRun<'_, f64, D> {
        let places = first..first + D * len;
        let next = &mut self.next[places.start - self.first..places.end - self.first];
        OntoRun::new(&self.base[places], next)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add<T: Number<f64>>(&mut self, place: usize, value: T) {
        if (self.tile.start..self.tile.end).contains(&place) {
            self.run(place, 1).add(0, value);
        }
    }
}
