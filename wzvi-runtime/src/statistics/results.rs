//! The statistics of an ensemble, in memory that does not grow with the number of paths.
//!
//! Tested by `tests/ensembles/statistics.rs`.

mod node;

use std::fmt;
use std::sync::Arc;

pub(crate) use node::RecordedNodes;
pub use node::StatisticsNode;

use super::crossings::{Crossings, EachSection};
use super::histogram::Histogram;
use super::loss::{Losses, PathFailure};
use super::passage::{Events, Passages};
use super::paths::PathValues;
use super::provenance::Provenance;
use super::statistic::{AnyStatistic, Seen, Statistic};
use crate::error::{InternalError, UnknownName};
use crate::ground::digits::{ShortestDecimal, estimate};
use crate::ground::numbers::{Numbers, Tape};
use crate::saving::FileError;
use crate::saving::table::TableChunks;
use crate::statistics::StatisticsError;

const NO_HISTOGRAM: StatisticsError = StatisticsError::NotComputed {
    what: "histogram of this observable",
    remedy: ".histogram(name, lower, upper, bins)",
};

/// The statistics of an ensemble.
///
/// A path that fails counts up to the last node that it reached, and is missing after that.
/// [`Statistics::failed`] is the number of such paths, [`StatisticsNode::lost`] their number at each time.
/// Printing the statistics shows both beside each mean.
///
/// Methods that take a name answer for the end of the paths. A name that does not exist is an error that
/// lists those that do.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    names: Arc<[String]>,
    nodes: RecordedNodes,
    events: Events,
    sections: EachSection,
    pub(crate) paths: Option<PathValues>,
    losses: Losses,
    /// Statistics that the user added.
    own: Vec<Box<dyn AnyStatistic>>,
    pub(crate) is_partial: bool,
    /// The targets of standard errors, by observable.
    pub(crate) targets: Vec<(usize, TargetStatus)>,
    /// Settings of the whole run; `None` in a chunk.
    pub(crate) origin: Option<Provenance>,
    pub(crate) unsaved: Option<FileError>,
}

/// Whether a run reached the standard error that
/// [`Ensemble::until_error`](crate::ensemble::Ensemble::until_error) set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetStatus {
    /// It was reached.
    Met,
    /// It was not reached within the number of paths, or before the run was stopped.
    NotMet,
    /// The estimate of the error is small enough, but one path contributes more than a tenth of the variance
    /// ([`StatisticsNode::largest_share`]). The mean of such a heavy tail depends on paths that are too rare
    /// to have been seen.
    Dominated,
    /// The observable is the same number on every path, so that its error is unknown. Either it is constant,
    /// or what changes it is rarer than `3 / paths` (with 95 % confidence).
    Constant,
}

impl Statistics {
    /// Statistics of observables with these names, without paths.
    pub(crate) fn new(names: Vec<String>, nodes: RecordedNodes) -> Self {
        Self {
            names: names.into(),
            nodes,
            events: Events(Vec::new()),
            sections: EachSection(Vec::new()),
            paths: None,
            losses: Losses::default(),
            own: Vec::new(),
            is_partial: false,
            targets: Vec::new(),
            origin: None,
            unsaved: None,
        }
    }

    /// Adds the statistics of events, sections, whole paths and the user.
    pub(crate) fn with(
        self,
        events: Vec<Passages>,
        sections: Vec<Crossings>,
        paths: Option<PathValues>,
        own: Vec<Box<dyn AnyStatistic>>,
    ) -> Self {
        Self { events: Events(events), sections: EachSection(sections), paths, own, ..self }
    }

    fn parts(&self) -> impl Iterator<Item = &dyn AnyStatistic> {
        let known: [&dyn AnyStatistic; 5] =
            [&self.nodes, &self.events, &self.sections, &self.losses, &self.paths];
        known.into_iter().chain(self.own.iter().map(|own| &**own))
    }

    fn parts_mut(&mut self) -> impl Iterator<Item = &mut (dyn AnyStatistic + 'static)> {
        let known: [&mut (dyn AnyStatistic + 'static); 5] =
            [&mut self.nodes, &mut self.events, &mut self.sections, &mut self.losses, &mut self.paths];
        known.into_iter().chain(self.own.iter_mut().map(|own| &mut **own))
    }

    /// Shows an observation of a path to each statistic.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn see(&mut self, path: u64, seen: &Seen<'_>) {
        Statistic::see(&mut self.nodes, path, seen);
        let is_at_node = matches!(seen, Seen::Values { .. } | Seen::Lost { .. });
        if !is_at_node || self.paths.is_some() || !self.own.is_empty() {
            self.parts_mut().skip(1).for_each(|part| part.see(path, seen));
        }
    }

    /// The paths of both, which follow each other in number: the order matters to the last bit.
    ///
    /// # Errors
    /// [`InternalError`] if they have other statistics.
    pub(crate) fn merge(&mut self, later: &Self) -> Result<(), InternalError> {
        self.parts_mut().zip(later.parts()).try_for_each(|(ours, theirs)| ours.merge(theirs))
    }

    /// Number of paths, failed ones included.
    pub(crate) fn begun(&self) -> u64 {
        self.nodes().first().map_or(0, StatisticsNode::count)
    }

    /// Names and words of the user's statistics, which distinguish them from others.
    pub(crate) fn added(&self) -> (Vec<String>, Vec<u64>) {
        let words = |mut own: Box<dyn AnyStatistic>| Tape::write(|tape| own.pass(tape));
        let names = self.own.iter().map(|own| own.name()).collect();
        (names, self.own.iter().cloned().flat_map(words).collect())
    }

    /// A statistic that was added to the run ([`Ensemble::statistic`](crate::ensemble::Ensemble::statistic)):
    /// the first of this type.
    ///
    /// # Errors
    /// [`StatisticsError::NotComputed`] if there is none of this type.
    pub fn statistic<T: Statistic>(&self) -> Result<&T, StatisticsError> {
        let found = self.own.iter().find_map(|own| own.as_any().downcast_ref());
        found
            .ok_or(StatisticsError::NotComputed { what: "statistic of this type", remedy: ".statistic(...)" })
    }

    /// The tables of all statistics.
    pub(super) fn rows(&self) -> impl Iterator<Item = TableChunks<'_>> {
        self.parts().flat_map(|part| part.rows(self).0)
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
        &self.nodes.all
    }

    /// The end; never `None`, since the start is always there.
    pub fn last(&self) -> Option<&StatisticsNode> {
        self.nodes().last()
    }

    /// The index of an observable.
    pub(crate) fn known(&self, name: &str) -> Result<usize, StatisticsError> {
        UnknownName::find("observable", name, self.names.iter().zip(0..)).map_err(StatisticsError::Unknown)
    }

    fn at_end<T>(
        &self,
        name: &str,
        what: impl Fn(&StatisticsNode, usize) -> T,
    ) -> Result<T, StatisticsError> {
        let index = self.known(name)?;
        let end = self
            .nodes()
            .last()
            .ok_or(StatisticsError::NotComputed { what: "end", remedy: ".until(time)" })?;
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
    /// The errors of [`Statistics::mean`].
    pub fn variance(&self, name: &str) -> Result<f64, StatisticsError> {
        self.at_end(name, StatisticsNode::variance)
    }

    /// The standard error of its mean, as [`StatisticsNode::standard_error`].
    ///
    /// # Errors
    /// The errors of [`Statistics::mean`].
    pub fn standard_error(&self, name: &str) -> Result<f64, StatisticsError> {
        self.at_end(name, StatisticsNode::standard_error)
    }

    /// An upper estimate of the standard error, as [`StatisticsNode::error_bound`].
    ///
    /// # Errors
    /// The errors of [`Statistics::mean`].
    pub fn error_bound(&self, name: &str) -> Result<f64, StatisticsError> {
        self.at_end(name, StatisticsNode::error_bound)
    }

    /// The covariance of two observables at the end, as [`StatisticsNode::covariance`].
    ///
    /// # Errors
    /// The errors of [`Statistics::mean`], and [`StatisticsError::NotComputed`] if the run was set to omit
    /// covariances.
    pub fn covariance(&self, a: &str, b: &str) -> Result<f64, StatisticsError> {
        let (a, b) = (self.known(a)?, self.known(b)?);
        match self.nodes().last() {
            Some(end) if a == b || end.has_covariances() => Ok(end.covariance(a, b)),
            _ => Err(StatisticsError::NotComputed { what: "covariances", remedy: ".covariances(true)" }),
        }
    }

    /// The quantile of an observable at the end, as [`Quantiles::at`](super::quantiles::Quantiles::at).
    ///
    /// # Errors
    /// The errors of [`Statistics::mean`], [`StatisticsError::NotComputed`] if quantiles were not requested,
    /// and [`StatisticsError::Fraction`] unless the fraction is a number from 0 to 1.
    pub fn quantile(&self, name: &str, fraction: f64) -> Result<f64, StatisticsError> {
        if !(0.0..=1.0).contains(&fraction) {
            return Err(StatisticsError::Fraction(fraction));
        }
        let quantile = |node: &StatisticsNode, index| node.quantiles(index).map(|all| all.at(fraction));
        let missing = StatisticsError::NotComputed { what: "quantiles", remedy: ".quantiles()" };
        self.at_end(name, quantile)?.ok_or(missing)
    }

    /// The observable of each of [`StatisticsNode::histograms`], by its index.
    pub fn histogrammed(&self) -> &[usize] {
        &self.nodes.histogrammed
    }

    /// The first histogram of an observable at the end.
    ///
    /// # Errors
    /// The errors of [`Statistics::mean`], and [`StatisticsError::NotComputed`] if none was requested.
    pub fn histogram(&self, name: &str) -> Result<&Histogram, StatisticsError> {
        let position = self.histogram_position(name)?;
        self.nodes().last().and_then(|end| end.histograms().get(position)).ok_or(NO_HISTOGRAM)
    }

    /// The index of the first histogram of an observable in the list of a node.
    pub(crate) fn histogram_position(&self, name: &str) -> Result<usize, StatisticsError> {
        let observable = self.known(name)?;
        self.histogrammed().iter().position(|&known| known == observable).ok_or(NO_HISTOGRAM)
    }

    /// When paths passed, event by event.
    pub fn passages(&self) -> &[Passages] {
        &self.events.0
    }

    /// When paths passed the event of this name.
    ///
    /// # Errors
    /// [`StatisticsError::Unknown`] for a name that does not exist.
    pub fn passage(&self, name: &str) -> Result<&Passages, StatisticsError> {
        let all = self.events.0.iter().map(|passages| (passages.name(), passages));
        UnknownName::find("event", name, all).map_err(StatisticsError::Unknown)
    }

    /// How often paths crossed each section of the run, in the order in which sections were requested.
    pub fn crossings(&self) -> &[Crossings] {
        &self.sections.0
    }

    /// The paths themselves, if they were kept.
    pub fn paths(&self) -> Option<&PathValues> {
        self.paths.as_ref()
    }

    /// Whether the run was stopped, by Ctrl-C or
    /// [`Ensemble::stop_when`](crate::ensemble::Ensemble::stop_when), before it was done. The statistics then
    /// cover all paths from number 0 up to the last one that was finished. If there are none, all means are
    /// NaN.
    pub fn is_partial(&self) -> bool {
        self.is_partial
    }

    /// Why the last [checkpoint](crate::ensemble::Ensemble::checkpoint) of the run could not be written. Only
    /// these statistics then contain the paths since the previous one. `None` if it was written, and for a
    /// run without checkpoints.
    pub fn unsaved(&self) -> Option<&FileError> {
        self.unsaved.as_ref()
    }

    /// Whether all standard errors meet the targets of
    /// [`Ensemble::until_error`](crate::ensemble::Ensemble::until_error); `None` if it was not called.
    pub fn met_targets(&self) -> Option<bool> {
        let met = self.targets.iter().all(|(_, status)| *status == TargetStatus::Met);
        (!self.targets.is_empty()).then_some(met)
    }

    /// Whether an observable has met its target.
    ///
    /// # Errors
    /// The errors of [`Statistics::mean`], and [`StatisticsError::NotComputed`] if none was requested.
    pub fn target(&self, name: &str) -> Result<TargetStatus, StatisticsError> {
        let observable = self.known(name)?;
        // If one observable has several targets, the first that was not met.
        let mut found =
            self.targets.iter().filter(|(known, _)| *known == observable).map(|(_, status)| *status);
        let first = found.next();
        let missing = StatisticsError::NotComputed { what: "target", remedy: ".until_error(name, target)" };
        first.map(|first| found.fold(first, TargetStatus::worse)).ok_or(missing)
    }

    /// Number of paths that ended early.
    pub fn failed(&self) -> u64 {
        self.losses.failed
    }

    /// The first thousand paths that ended early, by number, with their errors.
    pub fn failures(&self) -> &[PathFailure] {
        &self.losses.failures
    }
}

/// All data that the paths change.
impl Numbers for Statistics {
    fn pass(&mut self, tape: &mut Tape) {
        self.parts_mut().for_each(|part| part.pass(tape));
    }
}

impl TargetStatus {
    fn worse(self, other: Self) -> Self {
        if self == Self::Met { other } else { self }
    }
}

/// The means at the end, with their standard errors and the paths that are missing in them; then the recorded
/// times, the first passages and the crossings.
impl fmt::Display for Statistics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(end) = self.nodes().last() else { return Ok(()) };
        let partial = if self.is_partial { " (partial)" } else { "" };
        write!(f, "{} paths at t = {}{partial}", end.count(), end.time())?;
        if end.lost() > 0 {
            write!(f, ", {} of {} lost", end.lost(), self.begun())?;
        }
        if let Some(why) = self.origin.as_ref().and_then(|origin| origin.no_equilibrium) {
            write!(f, "\nno equilibrium: {why}")?;
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
        if let [first, .., last] = self.nodes() {
            let (first, last) = (ShortestDecimal(first.time()), ShortestDecimal(last.time()));
            write!(f, "\nrecorded at {} times from t = {first} to {last}", self.nodes().len())?;
        }
        for passages in self.passages() {
            write!(f, "\n{passages}")?;
        }
        for (section, crossings) in self.crossings().iter().enumerate() {
            write!(f, "\nsection {section}: {} crossings", crossings.count())?;
        }
        Ok(())
    }
}
