//! The range of the gradient that each tile writes.
//!
//! A step of a large system proceeds in tiles that stay in the first-level cache: first all derivatives of a
//! tile, then the numbers that follow from them. Every entry gets the same terms in the same order as in
//! one pass over all placements, so that the bits of a step do not depend on the tiles. Terms that
//! placements at the border of a tile add outside of it go to a margin or, if they are too far away, to
//! entries that are never read.

use std::cell::{Cell, RefCell};
use std::iter::{Cloned, Flatten};
use std::ops::Range;
use std::slice;

use super::super::sums::{AdjacentSums, Sums};
use super::BLOCK;
use crate::algebra::scalar::Number;

/// A tile of a plan, with the places from `start` to `end`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tile<'a> {
    pub(super) start: usize,
    pub(super) end: usize,
    /// The number of the tile in the plan.
    number: usize,
    plan: &'a Tiling,
}

/// The values of an outermost loop, in ranges.
pub(super) type LoopValues<'a> = Flatten<Cloned<slice::Iter<'a, Range<isize>>>>;

impl<'a> Tile<'a> {
    /// As [`Sums::outer`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn outer(self, variable: usize) -> LoopValues<'a> {
        let rows = self.plan.rows.iter().find(|rows| rows.variable == variable);
        let own = rows.and_then(|rows| rows.of_tile.get(self.number)).map_or(&[][..], |own| &own[..]);
        own.iter().cloned().flatten()
    }

    /// As [`Sums::clip`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn clip<const D: usize, const N: usize>(
        self,
        len: usize,
        first: [usize; N],
    ) -> (usize, usize) {
        // Tiles begin with a point.
        clip(self.start / D..self.end / D, len, first.map(|place| place / D))
    }

    /// The range of the sums of the tile in a list of length [`Tiles::room`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn own(self) -> Range<usize> {
        let margin = self.plan.margin;
        margin..margin + (self.end - self.start)
    }

    /// The start of the sums that are never read.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn unread(self) -> usize {
        self.plan.size + 2 * self.plan.margin
    }

    /// The position of the sums of `len` places from `first` on.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn position(self, first: usize, len: usize) -> usize {
        let margin = self.plan.margin;
        let is_near = first + margin >= self.start && first + len <= self.end + margin;
        if is_near { first + margin - self.start } else { self.unread() }
    }
}

/// As [`Sums::clip`], for placements that write into `places`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn clip<const N: usize>(places: Range<usize>, len: usize, first: [usize; N]) -> (usize, usize) {
    // Rows of a lattice mostly lie in one tile, so that a single run decides. Chains, with one or two runs,
    // do not.
    if N > 2 && first.iter().any(|&first| places.start <= first && first + len <= places.end) {
        return (0, len);
    }
    let (mut start, mut end) = (len, 0);
    for first in first {
        let (from, to) = (places.start.saturating_sub(first), places.end.saturating_sub(first).min(len));
        if from < to {
            (start, end) = (start.min(from), end.max(to));
        }
    }
    (start.min(end), end.saturating_sub(start))
}

/// A run of placements, as passed to [`Sums::clip`].
#[derive(Clone, Debug)]
struct PlacementRun {
    /// The outermost loop around it and the value of its variable, if there is one.
    outer: Option<(usize, isize)>,
    /// Places from one placement to the next.
    stride: usize,
    len: usize,
    first: Vec<usize>,
}

/// Records the runs of a system without computing anything.
#[derive(Debug, Default)]
pub(super) struct PlacementRecorder {
    runs: RefCell<Vec<PlacementRun>>,
    outer: Cell<Option<(usize, isize)>>,
}

/// The values of an outermost loop, each of which is first passed to the recorder.
pub(super) struct RecordedValues<'a> {
    variable: usize,
    values: Range<isize>,
    recorder: &'a PlacementRecorder,
}

impl Iterator for RecordedValues<'_> {
    type Item = isize;

    fn next(&mut self) -> Option<isize> {
        let value = self.values.next();
        self.recorder.outer.set(value.map(|value| (self.variable, value)));
        value
    }
}

impl<'a> Sums<f64> for &'a PlacementRecorder {
    type Outer = RecordedValues<'a>;
    type Run<'r>
        = DiscardedSums
    where
        Self: 'r;
    type Points<'r, const D: usize>
        = DiscardedSums
    where
        Self: 'r;

    fn outer(&self, variable: usize, values: Range<isize>) -> RecordedValues<'a> {
        RecordedValues { variable, values, recorder: self }
    }
    fn clip<const D: usize, const N: usize>(&self, len: usize, first: [usize; N]) -> (usize, usize) {
        let first = first.to_vec();
        self.runs.borrow_mut().push(PlacementRun { outer: self.outer.get(), stride: D, len, first });
        (0, 0)
    }
    fn run(&mut self, _first: usize, _len: usize) -> DiscardedSums {
        DiscardedSums
    }
    fn points<const D: usize>(&mut self, _first: usize, _len: usize) -> DiscardedSums {
        DiscardedSums
    }
    fn add<T: Number<f64>>(&mut self, _place: usize, _value: T) {}
}

/// Sums that are not stored.
pub(super) struct DiscardedSums;

impl AdjacentSums<f64> for DiscardedSums {
    fn add_part<T: Number<f64>>(&mut self, _place: usize, _part: usize, _value: T) {}
}

/// The values of one outermost loop that write into each tile, in ranges.
#[derive(Clone, Debug)]
struct LoopRanges {
    variable: usize,
    of_tile: Vec<Vec<Range<isize>>>,
}

/// The tiles of a system of one size.
#[derive(Clone, Debug)]
pub(super) struct Tiling {
    degrees: usize,
    /// Number of places of a tile; the last one may have fewer.
    size: usize,
    /// Number of entries before, and after, those of a tile.
    margin: usize,
    /// Number of entries, after all others, that are never read.
    unread: usize,
    rows: Vec<LoopRanges>,
    /// For each tile, the tiles whose coordinates its derivatives read, itself included.
    neighbours: Vec<Vec<usize>>,
}

/// Least length of a tile in units of the reach of placements; placements across a border are computed
/// twice.
const REACHES: usize = 8;

/// The median distance of the places that a placement writes to; the few placements that wrap around do not
/// affect it.
fn reach(runs: &[PlacementRun]) -> usize {
    let reach = |run: &PlacementRun| {
        let (least, most) = (run.first.iter().min(), run.first.iter().max());
        least.zip(most).map_or(0, |(least, most)| most - least)
    };
    let mut reaches: Vec<(usize, usize)> = runs.iter().map(|run| (reach(run), run.len)).collect();
    reaches.sort_unstable();
    let half = runs.iter().map(|run| run.len).sum::<usize>() / 2;
    let mut before = 0;
    let median = reaches.into_iter().find(|&(_, len)| {
        before += len;
        before > half
    });
    median.map_or(0, |(reach, _)| reach)
}

impl Tiling {
    /// Tiles of `size` places, or more if placements write far apart, from the recorded runs of a system.
    pub(super) fn new(degrees: usize, size: usize, recorder: PlacementRecorder) -> Self {
        let runs = recorder.runs.into_inner();
        let stride = runs.iter().map(|run| run.stride).max().unwrap_or(1);
        let size = size.max(REACHES * reach(&runs)).next_multiple_of(BLOCK * stride).min(degrees).max(1);
        let count = degrees.div_ceil(size);
        let neighbours = (0..count).map(|number| vec![number]).collect();
        let mut tiles = Self { degrees, size, margin: 0, unread: 1, rows: Vec::new(), neighbours };
        for run in runs {
            for number in tiles.touched(&run) {
                tiles.add(&run, number, count);
            }
        }
        for number in 0..count {
            for neighbour in tiles.neighbours[number].clone() {
                tiles.neighbours[neighbour].push(number);
            }
        }
        for neighbours in &mut tiles.neighbours {
            neighbours.sort_unstable();
            neighbours.dedup();
        }
        tiles
    }

    /// The tiles that a run writes into.
    fn touched(&self, run: &PlacementRun) -> Vec<usize> {
        let ends = |&first: &usize| first / self.size..(first + run.stride * run.len).div_ceil(self.size);
        let mut all: Vec<usize> = run.first.iter().filter(|_| run.len > 0).flat_map(ends).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    fn add(&mut self, run: &PlacementRun, number: usize, count: usize) {
        let (start, end) = self.bounds(number);
        let stride = run.stride;
        let points = start / stride..end / stride;
        let clips = run.first.iter().map(|&first| clip(points.clone(), run.len, [first / stride]));
        let (from, to) = clips
            .filter(|&(_, len)| len > 0)
            .fold((run.len, 0), |(from, to), (skip, len)| (from.min(skip), to.max(skip + len)));
        for first in &run.first {
            let (first, last) = (first + stride * from, first + stride * to);
            if first < end && start < last {
                self.margin = self.margin.max(start.saturating_sub(first)).max(last.saturating_sub(end));
            }
            self.unread = self.unread.max(stride * (to - from));
            if from < to {
                self.neighbours[number].extend(first / self.size..=(last - 1) / self.size);
            }
        }
        let Some((variable, value)) = run.outer else { return };
        let known = self.rows.iter().position(|rows| rows.variable == variable);
        let at = known.unwrap_or_else(|| {
            self.rows.push(LoopRanges { variable, of_tile: vec![Vec::new(); count] });
            self.rows.len() - 1
        });
        let ranges = &mut self.rows[at].of_tile[number];
        match ranges.last_mut() {
            Some(last) if last.contains(&value) => {}
            Some(last) if last.end == value => last.end += 1,
            _ => ranges.push(value..value + 1),
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn bounds(&self, number: usize) -> (usize, usize) {
        (number * self.size, ((number + 1) * self.size).min(self.degrees))
    }

    /// Number of entries for the derivatives of a tile.
    pub(super) fn room(&self) -> usize {
        self.size + 2 * self.margin + self.unread
    }

    /// Number of entries before those of a tile.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn margin(&self) -> usize {
        self.margin
    }

    /// For each tile, the tiles whose coordinates its derivatives read, itself included. The relation is
    /// symmetric.
    pub(super) fn neighbours(&self) -> &[Vec<usize>] {
        &self.neighbours
    }

    /// Whether the derivatives of each tile read only its own coordinates.
    pub(super) fn are_independent(&self) -> bool {
        self.neighbours.iter().all(|neighbours| neighbours.len() == 1)
    }

    /// All tiles in `number` contiguous ranges, or in fewer if there are fewer tiles.
    pub(super) fn by_thread(&self, number: usize) -> impl Iterator<Item = Range<usize>> {
        let all = self.neighbours.len();
        let parts = number.clamp(1, all.max(1));
        (0..parts).map(move |part| part * all / parts..(part + 1) * all / parts)
    }

    /// A tile by its number.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn tile(&self, number: usize) -> Tile<'_> {
        let (start, end) = self.bounds(number);
        Tile { start, end, number, plan: self }
    }
}
