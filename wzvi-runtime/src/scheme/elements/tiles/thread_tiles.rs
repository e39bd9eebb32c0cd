//! The adjacent tiles of each thread. Every number is the same as on one thread: the combined result does not
//! depend on the order of the threads.

use std::mem::take;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use super::LINE;
use super::layout::Tiling;
use crate::algebra::scalar::larger;
use crate::algebra::threads::each;
use crate::scheme::elements::change::Change;
use crate::scheme::elements::step::nothing;

/// The work of a thread, the end of its tiles, and scratch for the sums of one of them.
#[derive(Debug)]
pub(super) struct ThreadTiles<W> {
    pub(super) work: W,
    end: usize,
    /// With room to begin at a cache line.
    pub(super) sums: Vec<f64>,
}

impl<W> ThreadTiles<W> {
    /// The work on the tiles `own`.
    pub(super) fn new(tiles: &Tiling, own: &Range<usize>, work: W) -> Self {
        let end = own.end.checked_sub(1).map_or(0, |last| tiles.tile(last).end);
        Self { work, end, sums: vec![nothing(); tiles.room() + LINE] }
    }
}

/// The parts of lists that belong to the tiles of a thread, from the place `first` on. Lists that are not
/// needed are empty.
pub(super) struct ThreadLists<'a, const N: usize> {
    pub(super) first: usize,
    pub(super) lists: [&'a mut [f64]; N],
}

impl<const N: usize> ThreadLists<'_, N> {
    /// Splits the lists at a place; shorter lists stay in the first half.
    fn divide(self, place: usize) -> [Self; 2] {
        let Self { first, lists } = self;
        let mut halves = lists.map(|list| list.split_at_mut((place - first).min(list.len())));
        let before = halves.each_mut().map(|half| take(&mut half.0));
        [Self { first, lists: before }, Self { first: place, lists: halves.map(|half| half.1) }]
    }
}

/// The result of a step or of an iteration in some tiles.
#[derive(Clone, Copy)]
pub(super) struct TileResult {
    /// The largest unknown, and the largest correction: NaN if any is not finite.
    pub(super) size: f64,
    pub(super) corrected: f64,
    pub(super) change: Change,
    /// Whether the state after the step is finite.
    pub(super) is_finite: bool,
}

impl TileResult {
    /// The result in no tile.
    pub(super) const NOTHING: Self =
        Self { size: 0.0, corrected: 0.0, change: Change::Unseen, is_finite: true };

    /// Nothing but whether the state is finite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn finite(is_finite: bool) -> Self {
        Self { is_finite, ..Self::NOTHING }
    }

    fn and(self, other: Self) -> Self {
        Self {
            size: larger(self.size, other.size),
            corrected: larger(self.corrected, other.corrected),
            change: self.change.max(other.change),
            is_finite: self.is_finite && other.is_finite,
        }
    }
}

/// Does the work of each thread, on threads if there are several; returns the combined result.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn on_threads<W: Send, const N: usize>(
    by_thread: &mut [ThreadTiles<W>],
    lists: [&mut [f64]; N],
    work: impl Fn(&mut ThreadTiles<W>, ThreadLists<'_, N>) -> TileResult + Sync,
) -> TileResult {
    let part = ThreadLists { first: 0, lists };
    match by_thread {
        [] => return TileResult::NOTHING,
        [all] => return work(all, part),
        _ => {}
    }
    let (mut jobs, mut behind) = (Vec::with_capacity(by_thread.len()), part);
    for thread_tiles in by_thread {
        let [own, rest] = behind.divide(thread_tiles.end);
        behind = rest;
        jobs.push((thread_tiles, own));
    }
    let all = Mutex::new(TileResult::NOTHING);
    each(jobs, |(thread_tiles, own)| {
        let found = work(thread_tiles, own);
        let mut all = all.lock().unwrap_or_else(PoisonError::into_inner);
        *all = all.and(found);
    });
    all.into_inner().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_found_does_not_depend_on_the_order() {
        let found =
            |size: f64, corrected: f64, change, is_finite| TileResult { size, corrected, change, is_finite };
        let parts = [
            found(1.0, f64::NAN, Change::Unknown, true),
            found(3.0, 2.0, Change::Unseen, true),
            found(2.0, 5.0, Change::Seen, false),
        ];
        for [a, b, c] in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let all = TileResult::NOTHING.and(parts[a]).and(parts[b]).and(parts[c]);
            assert!(all.corrected.is_nan() && all.size == 3.0);
            assert_eq!((all.change, all.is_finite), (Change::Unknown, false));
        }
        let all = parts[1].and(parts[2]);
        assert_eq!((all.size, all.corrected, all.change), (3.0, 5.0, Change::Seen));
    }
}
