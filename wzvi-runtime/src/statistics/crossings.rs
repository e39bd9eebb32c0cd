//! Crossings of sections by many paths.

use super::moments::Welford;
use super::run::Wanted;
use crate::algebra::crossing::{Crossing, Direction};
use crate::algebra::state::Vector;
#[cfg(feature = "serde")]
use crate::ground::numbers::Tape;

/// How often paths crossed a section, and where, as far as that was to be kept: see [`crate::algebra::crossing`].
///
/// A path that fails counts with the crossings that it had before.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossings {
    rising: u64,
    falling: u64,
    /// Crossings of each path.
    of_path: Welford,
    degrees: usize,
    kept: Vec<(u64, Direction)>,
    /// By kept crossing: `t`, `q`, `p`.
    states: Vec<f64>,
}

/// A crossing of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathCrossing<'c> {
    /// Number of the path, from 0.
    pub path: u64,
    /// To which side.
    pub direction: Direction,
    /// When.
    pub t: f64,
    /// Coordinates there.
    pub q: &'c [f64],
    /// Momenta there.
    pub p: &'c [f64],
}

impl Crossings {
    pub(crate) fn new(wanted: &Wanted) -> Self {
        Self {
            rising: 0,
            falling: 0,
            of_path: Welford::default(),
            degrees: wanted.degrees,
            kept: Vec::new(),
            states: Vec::new(),
        }
    }

    /// One more crossing of a path, with its state if that is to be kept.
    pub(crate) fn push<V: Vector>(&mut self, path: u64, crossing: &Crossing<V>, is_kept: bool) {
        let Crossing { direction, state, .. } = crossing;
        match direction {
            Direction::Rising => self.rising += 1,
            Direction::Falling => self.falling += 1,
        }
        if is_kept {
            self.kept.push((path, *direction));
            self.states.push(state.t);
            self.states.extend(state.q.components().iter().chain(state.p.components()));
        }
    }

    /// A path is over that had so many crossings.
    pub(crate) fn finish(&mut self, crossings: u64) {
        self.of_path.push(crossings as f64);
    }

    /// Kept crossings from `first` on are those of paths beside each other: in the order of their numbers.
    pub(crate) fn sort(&mut self, first: usize) {
        let width = 1 + 2 * self.degrees;
        let mut order: Vec<usize> = (first..self.kept.len()).collect();
        // Stable: of one path they are in the order of time.
        order.sort_by_key(|&place| self.kept[place].0);
        let kept: Vec<_> = order.iter().map(|&place| self.kept[place]).collect();
        let states: Vec<f64> = order
            .iter()
            .flat_map(|&place| &self.states[place * width..(place + 1) * width])
            .copied()
            .collect();
        self.kept.splice(first.., kept);
        self.states.splice(first * width.., states);
    }

    /// Degrees of freedom.
    pub(crate) fn degrees(&self) -> usize {
        self.degrees
    }

    /// How many crossings are kept.
    pub(crate) fn kept(&self) -> usize {
        self.kept.len()
    }

    /// The paths of both, which follow each other in number.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.rising += other.rising;
        self.falling += other.falling;
        self.of_path.merge(&other.of_path);
        self.kept.extend(&other.kept);
        self.states.extend(&other.states);
    }

    #[cfg(feature = "serde")]
    pub(crate) fn pass(&mut self, tape: &mut Tape) {
        tape.words([&mut self.rising, &mut self.falling]);
        self.of_path.pass(tape);
        let length = tape.length(self.kept.len());
        self.kept.resize(length, (0, Direction::Rising));
        self.states.resize(length * (1 + 2 * self.degrees), 0.0);
        for (path, direction) in &mut self.kept {
            tape.word(path);
            let mut is_rising = *direction == Direction::Rising;
            tape.flag(&mut is_rising);
            *direction = if is_rising { Direction::Rising } else { Direction::Falling };
        }
        tape.numbers(&mut self.states);
    }

    /// Number of crossings of all paths.
    pub fn count(&self) -> u64 {
        self.rising + self.falling
    }

    /// Number of those in this direction.
    pub fn count_towards(&self, direction: Direction) -> u64 {
        match direction {
            Direction::Rising => self.rising,
            Direction::Falling => self.falling,
        }
    }

    /// The mean number of crossings of a path.
    pub fn mean(&self) -> f64 {
        self.of_path.mean()
    }

    /// The variance of this number.
    pub fn variance(&self) -> f64 {
        self.of_path.variance()
    }

    /// The standard error of [`Crossings::mean`].
    pub fn standard_error(&self) -> f64 {
        self.of_path.standard_error()
    }

    /// Those that were kept ([`Ensemble::keep_crossings`](crate::ensemble::Ensemble::keep_crossings)): path by path, each in the order of the run.
    pub fn iter(&self) -> impl Iterator<Item = PathCrossing<'_>> {
        let rows = self.states.chunks_exact(1 + 2 * self.degrees);
        self.kept.iter().zip(rows).map(|(&(path, direction), row)| {
            let (q, p) = row[1..].split_at(self.degrees);
            PathCrossing { path, direction, t: row[0], q, p }
        })
    }
}
