//! What is known of an ensemble, in memory that does not grow with the number of paths.

mod node;

use std::fmt;

pub(crate) use node::PathTally;
pub use node::StatisticsNode;

use super::crossings::Crossings;
use super::histogram::Histogram;
use super::moments::Moments;
use super::origin::Origin;
use super::passage::{Passages, Watch};
use super::paths::Paths;
use crate::error::StatisticsError;
#[cfg(feature = "serde")]
use crate::error::StepFailure;
use crate::error::{FileError, StepError, UnknownName};
use crate::ground::digits::estimate;
#[cfg(feature = "serde")]
use crate::ground::numbers::Tape;

/// Failed paths that are kept with their errors; further ones are only counted.
const MOST_FAILURES: usize = 1000;

const NO_HISTOGRAM: StatisticsError = StatisticsError::NotComputed {
    what: "histogram of this observable",
    remedy: ".histogram(name, lower, upper, bins)",
};

/// What a run is to find out.
#[derive(Debug, Default)]
pub(crate) struct Wanted {
    /// The observables.
    pub(crate) names: Vec<String>,
    /// The recorded times, the start first.
    pub(crate) times: Vec<f64>,
    pub(crate) quantiles: bool,
    /// Each of an observable, at every recorded time.
    pub(crate) histograms: Vec<(usize, Histogram)>,
    pub(crate) watches: Vec<Watch>,
    pub(crate) keeps_paths: bool,
    /// Whether paths `2k` and `2k + 1` are antithetic.
    pub(crate) has_pairs: bool,
    pub(crate) has_covariances: bool,
    /// Sections whose crossings are counted.
    pub(crate) sections: usize,
    /// How many of each path and section are kept.
    pub(crate) most_crossings: u64,
    /// Degrees of freedom.
    pub(crate) degrees: usize,
}

impl Wanted {
    /// Bytes of memory that it takes for a block of paths, without the paths themselves.
    pub(crate) fn bytes(&self) -> u128 {
        let moments = Moments::bytes(self.names.len(), self.has_covariances);
        let bins: u128 = self.histograms.iter().map(|(_, empty)| 8 * empty.counts().len() as u128).sum();
        let pairs = if self.has_pairs { 2 } else { 1 };
        self.times.len() as u128 * (pairs * moments + bins)
    }
}

/// A path that ended early.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathFailure {
    /// Number of the path, from 0.
    pub path: u64,
    /// Where and why.
    pub error: StepError,
}

#[cfg(feature = "serde")]
impl PathFailure {
    /// To be replaced by what a tape says.
    const NONE: Self =
        Self { path: 0, error: StepError { step: 0, t: 0.0, h: 0.0, cause: StepFailure::NonFinite } };

    fn pass(&mut self, tape: &mut Tape) {
        tape.words([&mut self.path, &mut self.error.step]);
        tape.numbers([&mut self.error.t, &mut self.error.h]);
        self.error.cause.pass(tape);
    }
}

/// The statistics of an ensemble.
///
/// A path that fails counts up to the last node that it reached, and is missing after that. [`Statistics::failed`] is the number of such
/// paths, [`StatisticsNode::lost`] their number at each time. Printing the statistics shows both beside each mean.
///
/// Methods that take a name answer for the end of the paths. A name that does not exist is an error that lists those that do.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    names: Vec<String>,
    /// The observable of each histogram.
    histogrammed: Vec<usize>,
    pub(crate) nodes: Vec<StatisticsNode>,
    pub(crate) passages: Vec<Passages>,
    pub(crate) crossings: Vec<Crossings>,
    pub(crate) paths: Option<Paths>,
    failed: u64,
    failures: Vec<PathFailure>,
    pub(crate) is_partial: bool,
    /// What was to be found out to a standard error, by observable.
    pub(crate) targets: Vec<(usize, TargetStatus)>,
    /// What the whole run is of; a block does not say so.
    pub(crate) origin: Option<Origin>,
    pub(crate) unsaved: Option<FileError>,
}

/// Whether a run reached the standard error that [`Ensemble::until_error`](crate::ensemble::Ensemble::until_error) set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetStatus {
    /// It was reached.
    Met,
    /// It was not reached within the number of paths, or before the run was stopped.
    NotMet,
    /// The estimate of the error is small enough, but one path contributes more than a tenth of the variance
    /// ([`StatisticsNode::largest_share`]). The mean of such a heavy tail depends on paths that are too rare to have been seen.
    Dominated,
    /// The observable is the same number on every path, so that its error is unknown. Either it is constant, or what changes it is rarer
    /// than `3 / paths` (with 95 % confidence).
    Constant,
}

impl Statistics {
    pub(crate) fn new(wanted: &Wanted) -> Self {
        Self {
            names: wanted.names.clone(),
            histogrammed: wanted.histograms.iter().map(|&(observable, _)| observable).collect(),
            nodes: wanted.times.iter().map(|&time| StatisticsNode::new(time, wanted)).collect(),
            passages: wanted.watches.iter().map(|watch| Passages::new(watch, wanted.keeps_paths)).collect(),
            crossings: (0..wanted.sections).map(|_| Crossings::new(wanted)).collect(),
            paths: wanted.keeps_paths.then(|| Paths::new(wanted.times.len(), wanted.names.len())),
            failed: 0,
            failures: Vec::new(),
            is_partial: false,
            targets: Vec::new(),
            origin: None,
            unsaved: None,
        }
    }

    pub(crate) fn fail(&mut self, failure: PathFailure) {
        self.failed += 1;
        if self.failures.len() < MOST_FAILURES {
            self.failures.push(failure);
        }
    }

    /// The paths of both, which follow each other in number: the order matters to the last bit.
    pub(crate) fn merge(&mut self, other: &Self) {
        for (ours, theirs) in self.nodes.iter_mut().zip(&other.nodes) {
            ours.merge(theirs);
        }
        for (ours, theirs) in self.passages.iter_mut().zip(&other.passages) {
            ours.merge(theirs);
        }
        for (ours, theirs) in self.crossings.iter_mut().zip(&other.crossings) {
            ours.merge(theirs);
        }
        if let (Some(ours), Some(theirs)) = (&mut self.paths, &other.paths) {
            ours.merge(theirs);
        }
        self.failed += other.failed;
        let room = MOST_FAILURES - self.failures.len();
        self.failures.extend(other.failures.iter().take(room));
    }

    /// Number of paths, failed ones included.
    pub(crate) fn begun(&self) -> u64 {
        self.nodes.first().map_or(0, StatisticsNode::count)
    }

    /// Everything that the paths change.
    #[cfg(feature = "serde")]
    pub(crate) fn pass(&mut self, tape: &mut Tape) {
        self.nodes.iter_mut().for_each(|node| node.pass(tape));
        self.passages.iter_mut().for_each(|passages| passages.pass(tape));
        self.crossings.iter_mut().for_each(|crossings| crossings.pass(tape));
        self.paths.iter_mut().for_each(|paths| paths.pass(tape));
        tape.word(&mut self.failed);
        let length = tape.length(self.failures.len());
        if length > MOST_FAILURES {
            tape.refuse();
            return;
        }
        self.failures.resize(length, PathFailure::NONE);
        self.failures.iter_mut().for_each(|failure| failure.pass(tape));
    }

    /// The names of the observables, in the order of the indices.
    pub fn observables(&self) -> &[String] {
        &self.names
    }

    /// The index of an observable.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// Each recorded time, the start first.
    pub fn nodes(&self) -> &[StatisticsNode] {
        &self.nodes
    }

    /// The end; `None` never, since the start is always there.
    pub fn last(&self) -> Option<&StatisticsNode> {
        self.nodes.last()
    }

    /// The index of an observable.
    pub(crate) fn known(&self, name: &str) -> Result<usize, StatisticsError> {
        let known = || self.names.clone();
        let unknown = || UnknownName { kind: "observable", name: name.to_owned(), known: known() };
        self.index(name).ok_or_else(|| StatisticsError::Unknown(unknown()))
    }

    fn at_end<T>(
        &self,
        name: &str,
        what: impl Fn(&StatisticsNode, usize) -> T,
    ) -> Result<T, StatisticsError> {
        let index = self.known(name)?;
        let end =
            self.nodes.last().ok_or(StatisticsError::NotComputed { what: "end", remedy: ".until(time)" })?;
        Ok(what(end, index))
    }

    /// The mean of an observable at the end, as [`StatisticsNode::mean`].
    ///
    /// # Errors
    /// [`StatisticsError::Unknown`] for a name that does not exist.
    pub fn mean(&self, name: &str) -> Result<f64, StatisticsError> {
        self.at_end(name, StatisticsNode::mean)
    }

    /// Its variance, as [`StatisticsNode::variance`].
    ///
    /// # Errors
    /// Those of [`Statistics::mean`].
    pub fn variance(&self, name: &str) -> Result<f64, StatisticsError> {
        self.at_end(name, StatisticsNode::variance)
    }

    /// The standard error of its mean, as [`StatisticsNode::standard_error`].
    ///
    /// # Errors
    /// Those of [`Statistics::mean`].
    pub fn standard_error(&self, name: &str) -> Result<f64, StatisticsError> {
        self.at_end(name, StatisticsNode::standard_error)
    }

    /// An upper estimate of it, as [`StatisticsNode::error_bound`].
    ///
    /// # Errors
    /// Those of [`Statistics::mean`].
    pub fn error_bound(&self, name: &str) -> Result<f64, StatisticsError> {
        self.at_end(name, StatisticsNode::error_bound)
    }

    /// The covariance of two observables at the end, as [`StatisticsNode::covariance`].
    ///
    /// # Errors
    /// Those of [`Statistics::mean`], and [`StatisticsError::NotComputed`] if the run was told to leave covariances out.
    pub fn covariance(&self, a: &str, b: &str) -> Result<f64, StatisticsError> {
        let (a, b) = (self.known(a)?, self.known(b)?);
        match self.nodes.last() {
            Some(end) if a == b || end.has_covariances() => Ok(end.covariance(a, b)),
            _ => Err(StatisticsError::NotComputed { what: "covariances", remedy: ".covariances(true)" }),
        }
    }

    /// The quantile of an observable at the end, as [`Quantiles::at`](super::quantiles::Quantiles::at).
    ///
    /// # Errors
    /// Those of [`Statistics::mean`], and [`StatisticsError::NotComputed`] if the run was not asked for quantiles.
    pub fn quantile(&self, name: &str, fraction: f64) -> Result<f64, StatisticsError> {
        let quantile = |node: &StatisticsNode, index| node.quantiles(index).map(|all| all.at(fraction));
        let missing = StatisticsError::NotComputed { what: "quantiles", remedy: ".quantiles()" };
        self.at_end(name, quantile)?.ok_or(missing)
    }

    /// The observable of each of [`StatisticsNode::histograms`], by its index.
    pub fn histogrammed(&self) -> &[usize] {
        &self.histogrammed
    }

    /// The first histogram of an observable at the end.
    ///
    /// # Errors
    /// Those of [`Statistics::mean`], and [`StatisticsError::NotComputed`] if the run was not asked for one.
    pub fn histogram(&self, name: &str) -> Result<&Histogram, StatisticsError> {
        let position = self.histogram_position(name)?;
        self.nodes.last().and_then(|end| end.histograms().get(position)).ok_or(NO_HISTOGRAM)
    }

    /// Where the first histogram of an observable is among those of a node.
    pub(crate) fn histogram_position(&self, name: &str) -> Result<usize, StatisticsError> {
        let observable = self.known(name)?;
        self.histogrammed.iter().position(|&known| known == observable).ok_or(NO_HISTOGRAM)
    }

    /// When paths passed, event by event.
    pub fn passages(&self) -> &[Passages] {
        &self.passages
    }

    /// When paths passed the event of this name.
    ///
    /// # Errors
    /// [`StatisticsError::Unknown`] for a name that does not exist.
    pub fn passage(&self, name: &str) -> Result<&Passages, StatisticsError> {
        let found = self.passages.iter().find(|passages| passages.name() == name);
        let known = || self.passages.iter().map(|passages| passages.name().to_owned()).collect();
        let unknown = || UnknownName { kind: "event", name: name.to_owned(), known: known() };
        found.ok_or_else(|| StatisticsError::Unknown(unknown()))
    }

    /// How often paths crossed each section of the run, in the order in which they were asked for.
    pub fn crossings(&self) -> &[Crossings] {
        &self.crossings
    }

    /// The paths themselves, if they were kept.
    pub fn paths(&self) -> Option<&Paths> {
        self.paths.as_ref()
    }

    /// Whether the run was stopped, by Ctrl-C or [`Ensemble::stop_when`](crate::ensemble::Ensemble::stop_when), before it was done. The
    /// statistics then cover all paths from number 0 up to the last one that was finished. If there are none, all means are NaN.
    pub fn is_partial(&self) -> bool {
        self.is_partial
    }

    /// Why the last [checkpoint](crate::ensemble::Ensemble::checkpoint) of the run could not be written. Only these statistics then contain
    /// the paths since the previous one. `None` if it was written, and for a run without checkpoints.
    pub fn unsaved(&self) -> Option<&FileError> {
        self.unsaved.as_ref()
    }

    /// Whether all standard errors meet the targets of [`Ensemble::until_error`](crate::ensemble::Ensemble::until_error); `None` if it was
    /// not called.
    pub fn met_targets(&self) -> Option<bool> {
        let met = self.targets.iter().all(|(_, status)| *status == TargetStatus::Met);
        (!self.targets.is_empty()).then_some(met)
    }

    /// What became of the standard error that was asked for an observable.
    ///
    /// # Errors
    /// Those of [`Statistics::mean`], and [`StatisticsError::NotComputed`] if none was asked for.
    pub fn target(&self, name: &str) -> Result<TargetStatus, StatisticsError> {
        let observable = self.known(name)?;
        // Asked for more than once, the first that was not met.
        let mut found =
            self.targets.iter().filter(|(known, _)| *known == observable).map(|(_, status)| *status);
        let first = found.next();
        let missing = StatisticsError::NotComputed { what: "target", remedy: ".until_error(name, target)" };
        first.map(|first| found.fold(first, TargetStatus::worse)).ok_or(missing)
    }

    /// Number of paths that ended early.
    pub fn failed(&self) -> u64 {
        self.failed
    }

    /// The first thousand of them by number, with their errors.
    pub fn failures(&self) -> &[PathFailure] {
        &self.failures
    }
}

impl TargetStatus {
    fn worse(self, other: Self) -> Self {
        if self == Self::Met { other } else { self }
    }
}

/// The means at the end, with their standard errors and the paths that are missing in them.
impl fmt::Display for Statistics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(end) = self.nodes.last() else { return Ok(()) };
        let partial = if self.is_partial { " (partial)" } else { "" };
        write!(f, "{} paths at t = {}{partial}", end.count(), end.time())?;
        if end.lost() > 0 {
            write!(f, ", {} of {} lost", end.lost(), self.begun())?;
        }
        let width = self.names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
        for (index, name) in self.names.iter().enumerate() {
            write!(f, "\n{name:width$}  {}", estimate(end.mean(index), end.standard_error(index)))?;
            if end.lost() > 0 {
                write!(f, " ({} lost)", end.lost())?;
            }
            if end.not_finite(index) > 0 {
                write!(f, " ({} not finite)", end.not_finite(index))?;
            }
            if let Some((_, status)) = self.targets.iter().find(|(observable, _)| *observable == index) {
                let words = match status {
                    TargetStatus::Met => "target met",
                    TargetStatus::NotMet => "target not met",
                    TargetStatus::Dominated => {
                        "target not met: one path has more than a tenth of the variance"
                    }
                    TargetStatus::Constant => "the same on all paths",
                };
                write!(f, " ({words})")?;
            }
        }
        Ok(())
    }
}
