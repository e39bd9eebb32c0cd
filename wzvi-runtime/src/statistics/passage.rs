//! The first time at which something happens.
//!
//! Tested by `tests/ensembles/statistics.rs`.

use std::fmt;

use super::histogram::Histogram;
use super::quantiles::Quantiles;
use super::results::Statistics;
use super::statistic::{Seen, Statistic, Tables};
use crate::algebra::student;
use crate::algebra::welford::Welford;
use crate::ground::digits::estimate;
use crate::ground::numbers::{Numbers, Tape};
use crate::saving::table::{TableChunks, TableRows};

/// When paths first crossed a zero of a function of the state.
///
/// A passage is the first crossing that a [section](crate::trajectory::section) counts: a change of sign, in
/// either direction. A path that starts at zero has not passed, and passes when the function changes the sign
/// that it has after the start. A path that starts beyond the level passes when it comes back. One that ends
/// at zero, or touches it, has not passed. A path that has not passed at the end is censored there; one that
/// fails before is lost at its last node.
///
/// Without noise, crossings are found as those of sections are, between the nodes, too. With noise, signs are
/// compared at the nodes, and the time is interpolated linearly: a path that crosses and returns within a
/// step is not seen. For a quantity that diffuses, mean times are therefore too long by a relative error of
/// order `√h`. A quantity that the noise reaches through a derivative, such as a position under noise in the
/// momentum, does not have this error.
#[derive(Clone, Debug, PartialEq)]
pub struct Passages {
    name: String,
    times: Welford,
    quantiles: Quantiles,
    histogram: Histogram,
    censored: u64,
    lost: u64,
    /// The times at which all start and end.
    span: [f64; 2],
    /// Time that paths without a passage spent on the way.
    waits: Welford,
    /// Time that all paths together spent on the way.
    exposure: f64,
    /// Path by path, if paths are kept.
    kept: Option<Vec<Passage>>,
}

/// The outcome of a first passage on one path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Passage {
    /// It passed at this time.
    At(f64),
    /// It reached the end.
    Censored,
    /// It failed, after a last node at this time.
    Lost(f64),
}

impl Numbers for Passage {
    fn pass(&mut self, tape: &mut Tape) {
        let (mut outcome, mut time) = match *self {
            Self::At(time) => (0, time),
            Self::Censored => (1, 0.0),
            Self::Lost(time) => (2, time),
        };
        tape.word(&mut outcome);
        tape.number(&mut time);
        *self = match outcome {
            0 => Self::At(time),
            1 => Self::Censored,
            2 => Self::Lost(time),
            _ => return tape.refuse(),
        };
    }
}

/// `rise: 812 of 1000 paths passed, at t = 3.14 ± 0.05 in the mean; 188 had not at the end`
impl fmt::Display for Passages {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (passed, all) = (self.passed(), self.passed() + self.censored + self.lost);
        write!(f, "{}: {passed} of {all} paths passed", self.name)?;
        if passed > 0 {
            write!(f, ", at t = {} in the mean", estimate(self.mean(), self.standard_error()))?;
        }
        if self.censored > 0 {
            write!(f, "; {} had not at the end", self.censored)?;
        }
        if self.lost > 0 {
            write!(f, "; {} were lost before", self.lost)?;
        }
        Ok(())
    }
}

impl Passages {
    /// For an event between two times, with bins between these; with the outcome of each path, if paths are
    /// kept.
    pub(crate) fn new(name: String, span: [f64; 2], histogram: Histogram, keeps_paths: bool) -> Self {
        Self {
            name,
            times: Welford::default(),
            quantiles: Quantiles::default(),
            histogram,
            censored: 0,
            lost: 0,
            span,
            waits: Welford::default(),
            exposure: 0.0,
            kept: keeps_paths.then(Vec::new),
        }
    }

    fn push(&mut self, passage: Passage) {
        if let Some(kept) = &mut self.kept {
            kept.push(passage);
        }
        let [start, end] = self.span;
        let until = match passage {
            Passage::At(time) => {
                self.times.push(time);
                self.quantiles.push(time);
                // The last bin has its upper end, where a run ends or, back in time, starts.
                self.histogram.push(time.min(self.histogram.edge(self.histogram.counts().len()).next_down()));
                time
            }
            Passage::Censored => {
                self.censored += 1;
                end
            }
            Passage::Lost(time) => {
                self.lost += 1;
                time
            }
        };
        let wait = (until - start).abs();
        self.exposure += wait;
        if !matches!(passage, Passage::At(_)) {
            self.waits.push(wait);
        }
    }

    fn merge(&mut self, other: &Self) {
        self.times.merge(&other.times);
        self.quantiles.merge(&other.quantiles);
        self.histogram.merge(&other.histogram);
        self.censored += other.censored;
        self.lost += other.lost;
        self.waits.merge(&other.waits);
        self.exposure += other.exposure;
        if let (Some(ours), Some(theirs)) = (&mut self.kept, &other.kept) {
            ours.extend(theirs);
        }
    }

    /// The name of the event.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of paths that passed.
    pub fn passed(&self) -> u64 {
        self.times.count()
    }

    /// Number of paths that reached the end without a passage.
    pub fn censored(&self) -> u64 {
        self.censored
    }

    /// Number of paths that failed before.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// The outcome of each path, by its number, if paths are kept
    /// ([`Ensemble::keep_paths`](crate::ensemble::Ensemble::keep_paths)).
    pub fn by_path(&self) -> Option<&[Passage]> {
        self.kept.as_deref()
    }

    /// The mean time of the paths that passed; it is too short where some are censored.
    pub fn mean(&self) -> f64 {
        self.times.mean()
    }

    /// The variance of these times.
    pub fn variance(&self) -> f64 {
        self.times.variance()
    }

    /// The standard error of [`Passages::mean`]. With few passages it is uncertain itself: `mean ± 1.96
    /// standard_error` covers 69, 89, 92 % for 2, 5, 10 of them.
    pub fn standard_error(&self) -> f64 {
        self.times.standard_error()
    }

    /// The half width of the 95 % interval of Student's t for [`Passages::mean`], over 1.96: `mean ± 1.96
    /// error_bound` covers 95 % for normal times, of any number from two on. Times of rare passages are
    /// exponential: for 5, 10, 30, 100 of them it covers 88, 90, 93, 94 %. NaN of fewer than two.
    pub fn error_bound(&self) -> f64 {
        let degrees = self.passed().saturating_sub(1) as f64;
        self.standard_error() * student::quantile(degrees) / student::NORMAL
    }

    /// The quantiles of these times.
    pub fn quantiles(&self) -> &Quantiles {
        &self.quantiles
    }

    /// These times in equal bins from the start to the end; the last bin includes its upper end.
    pub fn histogram(&self) -> &Histogram {
        &self.histogram
    }

    /// Passages per unit of time that paths spent before passing: the maximum-likelihood estimate of a
    /// constant rate, including censored and lost paths. NaN if no time was spent.
    pub fn rate(&self) -> f64 {
        if self.exposure > 0.0 { self.passed() as f64 / self.exposure } else { f64::NAN }
    }

    /// The standard error of [`Passages::rate`] as a ratio of two means over paths,
    /// `√(Σ (d - rate T)²) / Σ T`, for any law of the times. `d` is 1 for a path that passed and 0 for
    /// others, and `T` its time before passing. NaN of one path, and if none passed; the rate is then below
    /// three passages in the time of all paths, with 95 % confidence.
    pub fn rate_error(&self) -> f64 {
        if self.passed() == 0 || self.passed() + self.waits.count() == 1 {
            return f64::NAN;
        }
        let (rate, passed) = (self.rate(), self.passed() as f64);
        // By the spread of the times of both kinds: sums of what is positive.
        let missed = 1.0 - rate * (self.times.mean() - self.span[0]).abs();
        let waited =
            self.waits.squares() + self.waits.sum() * (self.waits.sum() / self.waits.count().max(1) as f64);
        (passed * missed * missed + rate * rate * (self.times.squares() + waited)).sqrt() / self.exposure
    }
}

impl Numbers for Passages {
    fn pass(&mut self, tape: &mut Tape) {
        self.times.pass(tape);
        self.quantiles.pass(tape);
        self.histogram.pass(tape);
        tape.words([&mut self.censored, &mut self.lost]);
        self.waits.pass(tape);
        tape.number(&mut self.exposure);
        let Some(kept) = &mut self.kept else { return };
        let length = tape.length(kept.len());
        kept.resize(length, Passage::Censored);
        kept.iter_mut().for_each(|passage| passage.pass(tape));
    }
}

/// The passages of each event.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Events(pub(super) Vec<Passages>);

impl Statistic for Events {
    fn see(&mut self, _path: u64, seen: &Seen<'_>) {
        if let Seen::Passage { event, passage } = *seen
            && let Some(passages) = self.0.get_mut(event)
        {
            passages.push(passage);
        }
    }

    fn merge(&mut self, later: &Self) {
        self.0.iter_mut().zip(&later.0).for_each(|(ours, theirs)| ours.merge(theirs));
    }

    fn rows<'s>(&'s self, _run: &'s Statistics) -> Tables<'s> {
        Tables(vec![self.counts(), self.times(), self.of_paths()])
    }
}

impl Numbers for Events {
    fn pass(&mut self, tape: &mut Tape) {
        self.0.iter_mut().for_each(|passages| passages.pass(tape));
    }
}

impl Events {
    fn counts(&self) -> TableChunks<'_> {
        TableRows::of(self.0.iter())
            .column("event", |passages| passages.name().to_owned())
            .column("passed", |passages| passages.passed())
            .column("censored", |passages| passages.censored())
            .column("lost", |passages| passages.lost())
            .column("mean", |passages| passages.mean())
            .column("standard_error", |passages| passages.standard_error())
            .column("error_bound", |passages| passages.error_bound())
            .column("rate", |passages| passages.rate())
            .column("rate_error", |passages| passages.rate_error())
            .parts("passages")
    }

    fn times(&self) -> TableChunks<'_> {
        let bins = self
            .0
            .iter()
            .flat_map(|passages| passages.histogram().bins().map(move |bin| (passages.name(), bin)));
        TableRows::of(bins)
            .column("event", |(event, _)| (*event).to_owned())
            .column("count", |&(_, (count, _))| count)
            .column("lower", |&(_, (_, [lower, ..]))| lower)
            .column("upper", |&(_, (_, [_, upper, _]))| upper)
            .column("density", |&(_, (_, [.., density]))| density)
            .parts("passage_times")
    }

    fn of_paths(&self) -> TableChunks<'_> {
        let each = self.0.iter().flat_map(|passages| {
            let kept = (0..).zip(passages.by_path().unwrap_or_default());
            kept.map(move |(path, passage)| (path, passages.name(), *passage))
        });
        let outcome = |passage| match passage {
            Passage::At(time) => ("passed", time),
            Passage::Censored => ("censored", f64::NAN),
            Passage::Lost(time) => ("lost", time),
        };
        TableRows::of(each)
            .column("path", |&(path, ..)| path)
            .column("event", |(_, event, _)| (*event).to_owned())
            .column("outcome", move |&(.., passage)| outcome(passage).0.to_owned())
            .column("time", move |&(.., passage)| outcome(passage).1)
            .parts("path_passages")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A standard error is a spread between paths: one path has none, as for a mean.
    #[test]
    fn one_path_has_no_error_of_its_rate() {
        let mut passages =
            Passages::new("one".into(), [0.0, 2.0], Histogram::new(0.0, 2.0, 4).unwrap(), false);
        passages.push(Passage::At(0.5));
        assert_eq!((passages.rate(), passages.rate_error().is_nan()), (2.0, true));
        passages.push(Passage::Censored);
        // Σ (d - rate T)² of d, T = 1, 0.5 and 0, 2 with the rate 1/2.5.
        assert!((passages.rate_error() - f64::hypot(0.8, 0.8) / 2.5).abs() < 1e-15);
    }

    #[test]
    fn errors_of_few_times_are_those_of_student() {
        let bins = Histogram::new(0.0, 4.0, 4).unwrap();
        let mut passages = Passages::new("few".into(), [0.0, 4.0], bins, false);
        passages.push(Passage::At(1.0));
        assert!(passages.error_bound().is_nan());
        passages.push(Passage::At(3.0));
        // A deviation of √2, of two times: a standard error of 1, and t = 12.706.
        assert!((1.959_964 * passages.error_bound() - 12.706).abs() < 1e-3, "{}", passages.error_bound());
    }

    /// Exponential times with rate 1.5, censored at 1: the rate comes out right, the mean does not.
    #[test]
    fn censored_times_count_for_the_rate() {
        let bins = Histogram::new(0.0, 1.0, 10).unwrap();
        let mut passages = Passages::new("decay".into(), [0.0, 1.0], bins, false);
        let n = 200_000;
        for i in 0..n {
            let time = -((f64::from(i) + 0.5) / f64::from(n)).ln() / 1.5;
            passages.push(if time < 1.0 { Passage::At(time) } else { Passage::Censored });
        }
        // Stratified samples: the only error is that of the middle rule, below 1/n of the largest time.
        assert!((passages.rate() - 1.5).abs() < 1e-4, "{}", passages.rate());
        assert!((passages.censored() as f64 / f64::from(n) - (-1.5f64).exp()).abs() < 1e-5);
        assert!(passages.mean() < 0.5);
        assert_eq!(passages.histogram().total() + passages.censored(), 200_000);
    }
}
