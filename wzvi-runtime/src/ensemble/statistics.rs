//! What is known of an ensemble, in memory that does not grow with the number of paths.

use super::histogram::Histogram;
use super::moments::Moments;
use super::origin::Origin;
use super::passage::{Passages, Watch};
use super::paths::Paths;
use super::quantiles::Quantiles;
use crate::error::StepError;
#[cfg(feature = "serde")]
use crate::error::StepFailure;
#[cfg(feature = "serde")]
use crate::numbers::Tape;

/// Failed paths that are kept with their errors; further ones are only counted.
const MOST_FAILURES: usize = 1000;

/// What a run is to find out.
#[derive(Debug, Default)]
pub(super) struct Wanted {
    /// The observables.
    pub(super) names: Vec<String>,
    /// The recorded times, the start first.
    pub(super) times: Vec<f64>,
    pub(super) quantiles: bool,
    /// Each of an observable, at every recorded time.
    pub(super) histograms: Vec<(usize, Histogram)>,
    pub(super) watches: Vec<Watch>,
    pub(super) keeps_paths: bool,
    /// Whether paths `2k` and `2k + 1` are antithetic.
    pub(super) has_pairs: bool,
}

/// All paths at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    time: f64,
    moments: Moments,
    /// Of the means of antithetic pairs.
    pairs: Option<Moments>,
    quantiles: Vec<Quantiles>,
    histograms: Vec<Histogram>,
}

impl Node {
    fn new(time: f64, wanted: &Wanted) -> Self {
        let observables = wanted.names.len();
        Self {
            time,
            moments: Moments::new(observables),
            pairs: wanted.has_pairs.then(|| Moments::new(observables)),
            quantiles: vec![Quantiles::default(); if wanted.quantiles { observables } else { 0 }],
            histograms: wanted.histograms.iter().map(|(_, empty)| empty.clone()).collect(),
        }
    }

    /// The observables of one more path; `scratch` has as many elements.
    pub(super) fn push(&mut self, values: &[f64], scratch: &mut [f64], wanted: &Wanted) {
        self.moments.push(values, scratch);
        for (quantiles, value) in self.quantiles.iter_mut().zip(values) {
            quantiles.push(*value);
        }
        for (histogram, (observable, _)) in self.histograms.iter_mut().zip(&wanted.histograms) {
            histogram.push(values[*observable]);
        }
    }

    /// The observables of both paths of an antithetic pair, which have been pushed, too; `first` becomes their mean.
    pub(super) fn push_pair(&mut self, first: &mut [f64], second: &[f64], scratch: &mut [f64]) {
        let Some(pairs) = &mut self.pairs else { return };
        for (first, second) in first.iter_mut().zip(second) {
            *first = 0.5 * *first + 0.5 * second;
        }
        pairs.push(first, scratch);
    }

    fn merge(&mut self, other: &Self) {
        self.moments.merge(&other.moments);
        if let (Some(ours), Some(theirs)) = (&mut self.pairs, &other.pairs) {
            ours.merge(theirs);
        }
        for (ours, theirs) in self.quantiles.iter_mut().zip(&other.quantiles) {
            ours.merge(theirs);
        }
        for (ours, theirs) in self.histograms.iter_mut().zip(&other.histograms) {
            ours.merge(theirs);
        }
    }

    #[cfg(feature = "serde")]
    fn pass(&mut self, tape: &mut Tape) {
        self.moments.pass(tape);
        self.pairs.iter_mut().for_each(|pairs| pairs.pass(tape));
        self.quantiles.iter_mut().for_each(|quantiles| quantiles.pass(tape));
        self.histograms.iter_mut().for_each(|histogram| histogram.pass(tape));
    }

    /// The time, in the units of the Hamiltonian.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Number of paths that got here.
    pub fn count(&self) -> u64 {
        self.moments.count()
    }

    /// The mean of an observable; NaN for one that does not exist, and without paths.
    pub fn mean(&self, observable: usize) -> f64 {
        self.moments.mean(observable)
    }

    /// The unbiased covariance of two observables; NaN where [`Node::mean`] is, and for a single path.
    pub fn covariance(&self, a: usize, b: usize) -> f64 {
        self.moments.covariance(a, b)
    }

    /// The unbiased variance of an observable, as [`Node::covariance`].
    pub fn variance(&self, observable: usize) -> f64 {
        self.covariance(observable, observable)
    }

    /// The standard error of the mean: `√(variance / count)`, and for antithetic paths, which depend on each other, that of
    /// the means of their pairs, `√(variance of pairs / number of pairs)`.
    pub fn standard_error(&self, observable: usize) -> f64 {
        let samples = self.pairs.as_ref().unwrap_or(&self.moments);
        (samples.covariance(observable, observable) / samples.count() as f64).sqrt()
    }

    /// The quantiles of an observable, if the run was asked for them.
    pub fn quantiles(&self, observable: usize) -> Option<&Quantiles> {
        self.quantiles.get(observable)
    }

    /// The histograms, in the order in which the run was asked for them.
    pub fn histograms(&self) -> &[Histogram] {
        &self.histograms
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

/// What an ensemble found out.
///
/// A path that fails counts until the last node that it reached, and is missing after that: [`Statistics::failed`] says of
/// how many that is true.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    names: Vec<String>,
    /// The observable of each histogram.
    histogrammed: Vec<usize>,
    pub(super) nodes: Vec<Node>,
    pub(super) passages: Vec<Passages>,
    pub(super) paths: Option<Paths>,
    failed: u64,
    failures: Vec<PathFailure>,
    pub(super) is_partial: bool,
    pub(super) met_targets: Option<bool>,
    /// What the whole run is of; a block does not say so.
    pub(super) origin: Option<Origin>,
}

impl Statistics {
    pub(super) fn new(wanted: &Wanted) -> Self {
        Self {
            names: wanted.names.clone(),
            histogrammed: wanted.histograms.iter().map(|&(observable, _)| observable).collect(),
            nodes: wanted.times.iter().map(|&time| Node::new(time, wanted)).collect(),
            passages: wanted.watches.iter().map(Passages::new).collect(),
            paths: wanted.keeps_paths.then(|| Paths::new(wanted.times.len(), wanted.names.len())),
            failed: 0,
            failures: Vec::new(),
            is_partial: false,
            met_targets: None,
            origin: None,
        }
    }

    pub(super) fn fail(&mut self, failure: PathFailure) {
        self.failed += 1;
        if self.failures.len() < MOST_FAILURES {
            self.failures.push(failure);
        }
    }

    /// The paths of both, which follow each other in number: the order matters to the last bit.
    pub(super) fn merge(&mut self, other: &Self) {
        for (ours, theirs) in self.nodes.iter_mut().zip(&other.nodes) {
            ours.merge(theirs);
        }
        for (ours, theirs) in self.passages.iter_mut().zip(&other.passages) {
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
    pub(super) fn begun(&self) -> u64 {
        self.nodes.first().map_or(0, Node::count)
    }

    /// Everything that the paths change.
    #[cfg(feature = "serde")]
    pub(super) fn pass(&mut self, tape: &mut Tape) {
        self.nodes.iter_mut().for_each(|node| node.pass(tape));
        self.passages.iter_mut().for_each(|passages| passages.pass(tape));
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
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The end; `None` never, since the start is always there.
    pub fn last(&self) -> Option<&Node> {
        self.nodes.last()
    }

    /// The mean of an observable at the end; NaN for a name that does not exist.
    pub fn mean(&self, name: &str) -> f64 {
        self.at_end(name, Node::mean)
    }

    /// Its variance.
    pub fn variance(&self, name: &str) -> f64 {
        self.at_end(name, Node::variance)
    }

    /// The standard error of its mean.
    pub fn standard_error(&self, name: &str) -> f64 {
        self.at_end(name, Node::standard_error)
    }

    /// The covariance of two observables at the end, as [`Node::covariance`].
    pub fn covariance(&self, a: &str, b: &str) -> f64 {
        let b = self.index(b);
        self.at_end(a, |node, a| b.map_or(f64::NAN, |b| node.covariance(a, b)))
    }

    /// The quantile of an observable at the end, as [`Quantiles::at`]; NaN if the run was not asked for quantiles.
    pub fn quantile(&self, name: &str, fraction: f64) -> f64 {
        self.at_end(name, |node, index| node.quantiles(index).map_or(f64::NAN, |all| all.at(fraction)))
    }

    fn at_end(&self, name: &str, what: impl Fn(&Node, usize) -> f64) -> f64 {
        self.last().zip(self.index(name)).map_or(f64::NAN, |(node, index)| what(node, index))
    }

    /// The observable of each of [`Node::histograms`], by its index.
    pub fn histogrammed(&self) -> &[usize] {
        &self.histogrammed
    }

    /// The first histogram of an observable at the end, if the run was asked for one.
    pub fn histogram(&self, name: &str) -> Option<&Histogram> {
        let observable = self.index(name)?;
        let position = self.histogrammed.iter().position(|&known| known == observable)?;
        self.last()?.histograms().get(position)
    }

    /// When paths passed, event by event.
    pub fn passages(&self) -> &[Passages] {
        &self.passages
    }

    /// When paths passed the event of this name.
    pub fn passage(&self, name: &str) -> Option<&Passages> {
        self.passages.iter().find(|passages| passages.name() == name)
    }

    /// The paths themselves, if they were kept.
    pub fn paths(&self) -> Option<&Paths> {
        self.paths.as_ref()
    }

    /// Whether the run was stopped, by Ctrl-C or [`Ensemble::stop_when`](super::Ensemble::stop_when), before it was done: these
    /// are the paths with the numbers that it had finished from 0 on, none left out. Without any, all means are NaN.
    pub fn is_partial(&self) -> bool {
        self.is_partial
    }

    /// Whether all standard errors are below what [`Ensemble::until_error`](super::Ensemble::until_error) asked for; `None` if it
    /// was not called.
    pub fn met_targets(&self) -> Option<bool> {
        self.met_targets
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
