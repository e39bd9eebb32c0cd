//! Crossings of sections by many paths.
//!
//! Tested by `tests/paths/between/ensembles.rs`.

use super::results::Statistics;
use super::statistic::{Seen, Statistic, Tables};
use crate::algebra::crossing::Direction;
use crate::algebra::welford::Welford;
use crate::ground::numbers::{Numbers, Tape};
use crate::saving::table::{TableChunks, TableRows};

/// How often paths crossed a section, and the states there, as far as they are kept: see
/// [`crate::algebra::crossing`].
///
/// A path that fails counts with the crossings that it had before.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossings {
    rising: u64,
    falling: u64,
    /// Crossings of each path.
    of_path: Welford,
    degrees: usize,
    /// How many of each path are kept.
    most: u64,
    kept: Vec<(u64, Direction)>,
    /// By kept crossing: `t`, `q`, `p`.
    states: Vec<f64>,
}

/// A crossing of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathCrossing<'c> {
    /// Number of the path, from 0.
    pub path: u64,
    /// Whether the function of the section rises or falls.
    pub direction: Direction,
    /// Time of the crossing.
    pub t: f64,
    /// Coordinates there.
    pub q: &'c [f64],
    /// Momenta there.
    pub p: &'c [f64],
}

impl Crossings {
    /// For paths of so many degrees of freedom; so many crossings of each are kept.
    pub(crate) fn new(degrees: usize, most: u64) -> Self {
        let (kept, states) = (Vec::new(), Vec::new());
        Self { rising: 0, falling: 0, of_path: Welford::default(), degrees, most, kept, states }
    }

    /// How many crossings of each path are kept.
    pub(crate) fn most(&self) -> u64 {
        self.most
    }

    fn width(&self) -> usize {
        1 + 2 * self.degrees
    }

    /// Kept crossings arrive in the order of time. Sorts those of paths that ran side by side by path; each
    /// path keeps its order.
    fn merge(&mut self, later: &Self) {
        self.rising += later.rising;
        self.falling += later.falling;
        self.of_path.merge(&later.of_path);
        let mut rows: Vec<_> = later.kept.iter().zip(later.states.chunks_exact(later.width())).collect();
        rows.sort_by_key(|((path, _), _)| *path);
        for (kept, states) in rows {
            self.kept.push(*kept);
            self.states.extend(states);
        }
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

    /// The crossings that were kept
    /// ([`Ensemble::keep_crossings`](crate::ensemble::Ensemble::keep_crossings)): path by path, each in the
    /// order of the run.
    pub fn iter(&self) -> impl Iterator<Item = PathCrossing<'_>> {
        let rows = self.states.chunks_exact(self.width());
        self.kept.iter().zip(rows).map(|(&(path, direction), row)| {
            let (q, p) = row[1..].split_at(self.degrees);
            PathCrossing { path, direction, t: row[0], q, p }
        })
    }
}

impl Numbers for Crossings {
    fn pass(&mut self, tape: &mut Tape) {
        tape.words([&mut self.rising, &mut self.falling]);
        self.of_path.pass(tape);
        let length = tape.length(self.kept.len());
        self.kept.resize(length, (0, Direction::Rising));
        self.states.resize(length * self.width(), 0.0);
        for (path, direction) in &mut self.kept {
            tape.word(path);
            let mut is_rising = *direction == Direction::Rising;
            tape.flag(&mut is_rising);
            *direction = if is_rising { Direction::Rising } else { Direction::Falling };
        }
        tape.numbers(&mut self.states);
    }
}

/// The crossings of each section.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct EachSection(pub(super) Vec<Crossings>);

impl Statistic for EachSection {
    fn see(&mut self, path: u64, seen: &Seen<'_>) {
        match *seen {
            Seen::Crossing { section, before, direction, t, q, p } => {
                let Some(crossings) = self.0.get_mut(section) else { return };
                match direction {
                    Direction::Rising => crossings.rising += 1,
                    Direction::Falling => crossings.falling += 1,
                }
                if before < crossings.most {
                    crossings.kept.push((path, direction));
                    crossings.states.push(t);
                    crossings.states.extend(q.iter().chain(p));
                }
            }
            Seen::Crossings { section, count } => {
                self.0
                    .get_mut(section)
                    .into_iter()
                    .for_each(|crossings| crossings.of_path.push(count as f64));
            }
            _ => {}
        }
    }

    fn merge(&mut self, later: &Self) {
        self.0.iter_mut().zip(&later.0).for_each(|(ours, theirs)| ours.merge(theirs));
    }

    fn rows<'s>(&'s self, _run: &'s Statistics) -> Tables<'s> {
        Tables(vec![self.counts(), self.states()])
    }
}

impl Numbers for EachSection {
    fn pass(&mut self, tape: &mut Tape) {
        self.0.iter_mut().for_each(|crossings| crossings.pass(tape));
    }
}

impl EachSection {
    fn counts(&self) -> TableChunks<'_> {
        TableRows::of((0..).zip(&self.0))
            .column("section", |&(section, _)| section)
            .column("count", |(_, crossings)| crossings.count())
            .column("rising", |(_, crossings)| crossings.count_towards(Direction::Rising))
            .column("falling", |(_, crossings)| crossings.count_towards(Direction::Falling))
            .column("mean", |(_, crossings)| crossings.mean())
            .column("standard_error", |(_, crossings)| crossings.standard_error())
            .column("variance", |(_, crossings)| crossings.variance())
            .parts("crossings")
    }

    fn states(&self) -> TableChunks<'_> {
        let degrees = self.0.first().map_or(0, |crossings| crossings.degrees);
        let each = (0..)
            .zip(&self.0)
            .flat_map(|(section, crossings)| crossings.iter().map(move |crossing| (section, crossing)));
        let mut rows = TableRows::of(each)
            .column("section", |&(section, _)| section)
            .column("path", |(_, crossing)| crossing.path)
            .column("direction", |(_, crossing)| match crossing.direction {
                Direction::Rising => "rising".to_owned(),
                Direction::Falling => "falling".to_owned(),
            })
            .column("time", |(_, crossing)| crossing.t);
        for i in 0..degrees {
            rows = rows.column(format!("q{i}"), move |(_, crossing)| crossing.q[i]);
        }
        for i in 0..degrees {
            rows = rows.column(format!("p{i}"), move |(_, crossing)| crossing.p[i]);
        }
        rows.parts("crossing_states")
    }
}
