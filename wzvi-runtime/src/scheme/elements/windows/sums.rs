//! The sums that the slopes of a window are added to.

use std::ops::{Index, Range};

use super::super::step::nothing;
use super::super::sums::{Given, OntoRun, Points, Run, Sums};
use super::layout::{Strip, Values};
use crate::algebra::scalar::Number;

/// Coordinates or momenta of the places from `first` on.
#[derive(Clone, Copy)]
pub(super) struct Stretch<'a> {
    pub(super) numbers: &'a [f64],
    pub(super) first: usize,
    /// The degrees of freedom of the system.
    pub(super) degrees: usize,
}

impl Index<usize> for Stretch<'_> {
    type Output = f64;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn index(&self, place: usize) -> &f64 {
        &self.numbers[place - self.first]
    }
}

impl Index<Range<usize>> for Stretch<'_> {
    type Output = [f64];

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn index(&self, places: Range<usize>) -> &[f64] {
        &self.numbers[places.start - self.first..places.end - self.first]
    }
}

impl Given<f64> for Stretch<'_> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn degrees(&self) -> usize {
        self.degrees
    }
}

/// Sums of a window in a separate list. Sums before `filled` have terms; the next term of any other sum is
/// its first.
pub(super) struct Window<'a> {
    strip: Strip<'a>,
    sums: &'a mut [f64],
    filled: usize,
}

impl<'a> Window<'a> {
    /// Sums without terms.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn empty(strip: Strip<'a>, sums: &'a mut [f64]) -> Self {
        Self { strip, sums, filled: 0 }
    }

    /// Sums that begin with the numbers of the window.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn onto(strip: Strip<'a>, sums: &'a mut [f64], numbers: &[f64]) -> Self {
        let (own, filled) = (strip.own(), strip.unread());
        sums[..own.start].fill(nothing());
        sums[own.clone()].copy_from_slice(numbers);
        sums[own.end..filled].fill(nothing());
        Self { strip, sums, filled }
    }

    /// The position of the sums of `len` places from `first` on, and whether they have no term yet.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn open(&mut self, first: usize, len: usize) -> (usize, bool) {
        let position = self.strip.position(first, len);
        let end = position + len;
        if end <= self.filled || position >= self.strip.unread() {
            return (position, false);
        }
        let is_fresh = position >= self.filled;
        self.sums[self.filled..if is_fresh { position } else { end }].fill(nothing());
        self.filled = end;
        (position, is_fresh)
    }

    /// The sums of the window.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn finish(self) -> &'a [f64] {
        let Self { strip, sums, filled } = self;
        let own = strip.own();
        if filled < own.end {
            sums[filled..own.end].fill(nothing());
        }
        &sums[own]
    }
}

impl<'a> Sums<f64> for Window<'a> {
    type Outer = Values<'a>;
    type Run<'r>
        = Gathered<'r>
    where
        Self: 'r;
    type Points<'r, const D: usize>
        = Points<'r, f64, D>
    where
        Self: 'r;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn outer(&self, variable: usize, _values: Range<isize>) -> Values<'a> {
        self.strip.outer(variable)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn clip<const D: usize, const N: usize>(&self, len: usize, first: [usize; N]) -> (usize, usize) {
        self.strip.clip::<D, N>(len, first)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run(&mut self, first: usize, len: usize) -> Gathered<'_> {
        let (position, is_fresh) = self.open(first, len);
        Gathered { sums: &mut self.sums[position..position + len], is_fresh }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn points<const D: usize>(&mut self, first: usize, len: usize) -> Points<'_, f64, D> {
        let (position, is_fresh) = self.open(first, D * len);
        let points = self.sums.points(position, len);
        if is_fresh {
            points.0.fill([nothing(); D]);
        }
        points
    }
}

/// A stretch of a window.
pub(super) struct Gathered<'r> {
    sums: &'r mut [f64],
    is_fresh: bool,
}

impl Run<f64> for Gathered<'_> {
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
pub(super) struct Moved<'a> {
    pub(super) strip: Strip<'a>,
    pub(super) base: Stretch<'a>,
    /// The places from `first` on.
    pub(super) next: &'a mut [f64],
    pub(super) first: usize,
}

impl<'a> Sums<f64> for Moved<'a> {
    type Outer = Values<'a>;
    type Run<'r>
        = OntoRun<'r, f64, 1>
    where
        Self: 'r;
    type Points<'r, const D: usize>
        = OntoRun<'r, f64, D>
    where
        Self: 'r;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn outer(&self, variable: usize, _values: Range<isize>) -> Values<'a> {
        self.strip.outer(variable)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn clip<const D: usize, const N: usize>(&self, len: usize, first: [usize; N]) -> (usize, usize) {
        self.strip.clip::<D, N>(len, first)
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
        if (self.strip.start..self.strip.end).contains(&place) {
            self.run(place, 1).add(0, value);
        }
    }
}
