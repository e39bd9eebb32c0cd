//! All paths of an ensemble at one time.
//!
//! Tested by `tests/ensembles/statistics.rs` and `tests/ensembles/control.rs`.

use crate::ground::numbers::numbers;
use crate::saving::table::{TableChunks, TableRows};
use crate::statistics::histogram::Histogram;
use crate::statistics::moments::Moments;
use crate::statistics::quantiles::Quantiles;
use crate::statistics::results::Statistics;
use crate::statistics::statistic::{Seen, Statistic, Tables};

/// The fractions in the table of quantiles.
const FRACTIONS: [f64; 11] = [0.0, 0.001, 0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99, 0.999, 1.0];

/// All paths at each recorded time.
#[derive(Clone, Debug, Default)]
pub(crate) struct RecordedNodes {
    pub(super) all: Vec<StatisticsNode>,
    /// The observable of each histogram.
    pub(super) histogrammed: Vec<usize>,
    scratch: Vec<f64>,
    /// The values of the first path of an antithetic pair, if it reached the node.
    first: Vec<f64>,
    has_first: bool,
}

/// The paths that the node has seen, without scratch.
impl PartialEq for RecordedNodes {
    fn eq(&self, other: &Self) -> bool {
        self.all == other.all && self.histogrammed == other.histogrammed
    }
}

impl RecordedNodes {
    pub(crate) fn new(times: &[f64], node: &StatisticsNode, histogrammed: Vec<usize>) -> Self {
        let all = times.iter().map(|&time| StatisticsNode { time, ..node.clone() }).collect();
        Self { all, histogrammed, scratch: Vec::new(), first: Vec::new(), has_first: false }
    }

    /// Every node with every observable.
    fn each<'s>(&'s self, names: &'s [String]) -> impl Iterator<Item = (&'s StatisticsNode, usize)> {
        self.all.iter().flat_map(|node| (0..names.len()).map(move |index| (node, index)))
    }

    fn moments<'s>(&'s self, names: &'s [String]) -> TableChunks<'s> {
        TableRows::of(self.each(names))
            .column("time", |(node, _)| node.time())
            .column("observable", |&(_, index)| names[index].clone())
            .column("count", |(node, _)| node.count())
            .column("lost", |(node, _)| node.lost())
            .column("not_finite", |&(node, index)| node.not_finite(index))
            .column("mean", |&(node, index)| node.mean(index))
            .column("standard_error", |&(node, index)| node.standard_error(index))
            .column("error_bound", |&(node, index)| node.error_bound(index))
            .column("largest_share", |&(node, index)| node.largest_share(index))
            .column("variance", |&(node, index)| node.variance(index))
            .parts("moments")
    }

    fn covariances<'s>(&'s self, names: &'s [String]) -> TableChunks<'s> {
        let pairs = self.each(names).flat_map(|(node, a)| {
            let partners = if node.has_covariances() { names.len() } else { a + 1 };
            (a..partners).map(move |b| (node, a, b))
        });
        TableRows::of(pairs)
            .column("time", |(node, ..)| node.time())
            .column("first", |&(_, a, _)| names[a].clone())
            .column("second", |&(.., b)| names[b].clone())
            .column("covariance", |&(node, a, b)| node.covariance(a, b))
            .parts("covariances")
    }

    fn quantiles<'s>(&'s self, names: &'s [String]) -> TableChunks<'s> {
        let each = self.each(names).filter_map(|(node, i)| Some((node.time(), i, node.quantiles(i)?)));
        let each = each.flat_map(|(time, i, all)| FRACTIONS.map(|at| (time, i, at, all.at(at))));
        TableRows::of(each)
            .column("time", |&(time, ..)| time)
            .column("observable", |&(_, index, ..)| names[index].clone())
            .column("fraction", |&(.., fraction, _)| fraction)
            .column("quantile", |&(.., quantile)| quantile)
            .parts("quantiles")
    }

    fn histograms<'s>(&'s self, names: &'s [String]) -> TableChunks<'s> {
        let each = self.all.iter().flat_map(|node| {
            node.histograms().iter().zip(&self.histogrammed).map(move |of| (node.time(), of))
        });
        let each =
            each.flat_map(|(time, (histogram, &index))| histogram.bins().map(move |bin| (time, index, bin)));
        TableRows::of(each)
            .column("time", |&(time, ..)| time)
            .column("observable", |&(_, index, _)| names[index].clone())
            .column("count", |&(.., (count, _))| count)
            .column("lower", |&(.., (_, [lower, ..]))| lower)
            .column("upper", |&(.., (_, [_, upper, _]))| upper)
            .column("density", |&(.., (_, [.., density]))| density)
            .parts("histograms")
    }
}

impl Statistic for RecordedNodes {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn see(&mut self, path: u64, seen: &Seen<'_>) {
        let Self { all, histogrammed, scratch, first, has_first } = self;
        match *seen {
            Seen::Values { node, values } => {
                let Some(node) = all.get_mut(node) else { return };
                node.moments.push(values, scratch);
                for (quantiles, value) in node.quantiles.iter_mut().zip(values) {
                    quantiles.push(*value);
                }
                for (histogram, observable) in node.histograms.iter_mut().zip(histogrammed) {
                    histogram.push(values[*observable]);
                }
                let Some(pairs) = &mut node.pairs else { return };
                if path.is_multiple_of(2) {
                    first.clear();
                    first.extend_from_slice(values);
                } else if *has_first {
                    first
                        .iter_mut()
                        .zip(values)
                        .for_each(|(first, second)| *first = 0.5 * *first + 0.5 * second);
                    pairs.push(first, scratch);
                }
                *has_first = path.is_multiple_of(2);
            }
            Seen::Lost { node } => {
                *has_first = false;
                all.get_mut(node).into_iter().for_each(|node| node.lost += 1);
            }
            _ => {}
        }
    }

    fn merge(&mut self, later: &Self) {
        self.all.iter_mut().zip(&later.all).for_each(|(ours, theirs)| ours.merge(theirs));
    }

    fn rows<'s>(&'s self, run: &'s Statistics) -> Tables<'s> {
        let names = run.observables();
        Tables(vec![
            self.moments(names),
            self.covariances(names),
            self.quantiles(names),
            self.histograms(names),
        ])
    }
}

numbers! {
    impl[] Numbers for RecordedNodes { kept: all[..]; fixed: histogrammed; scratch: scratch, first, has_first }
}
numbers! {
    impl[] Numbers for StatisticsNode {
        kept: lost, moments, pairs[..], quantiles[..], histograms[..];
        fixed: time
    }
}

/// All paths at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct StatisticsNode {
    time: f64,
    /// Paths that failed before.
    lost: u64,
    moments: Moments,
    /// Moments of the means of antithetic pairs.
    pairs: Option<Moments>,
    quantiles: Vec<Quantiles>,
    histograms: Vec<Histogram>,
}

impl StatisticsNode {
    /// A node of so many observables, without paths and at no time yet, with or without covariances,
    /// antithetic pairs and quantiles.
    pub(crate) fn new(
        observables: usize,
        has_covariances: bool,
        (has_pairs, has_quantiles): (bool, bool),
        histograms: Vec<Histogram>,
    ) -> Self {
        let moments = Moments::new(observables, has_covariances);
        let quantiles = vec![Quantiles::default(); if has_quantiles { observables } else { 0 }];
        Self {
            time: f64::NAN,
            lost: 0,
            pairs: has_pairs.then(|| moments.clone()),
            moments,
            quantiles,
            histograms,
        }
    }

    /// Bytes of memory that one of these takes.
    pub(crate) fn bytes(
        observables: usize,
        has_covariances: bool,
        (has_pairs, has_quantiles): (bool, bool),
        histograms: &[Histogram],
    ) -> u128 {
        let bins: u128 = histograms.iter().map(|empty| 8 * empty.counts().len() as u128).sum();
        let samples = if has_pairs { 2 } else { 1 };
        let quantiles = if has_quantiles { observables * Quantiles::LEAST_BYTES } else { 0 };
        samples * Moments::bytes(observables, has_covariances) + bins + quantiles as u128
    }

    fn merge(&mut self, other: &Self) {
        self.lost += other.lost;
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

    /// The time, in the units of the Hamiltonian.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Number of paths that reached the node.
    pub fn count(&self) -> u64 {
        self.moments.count()
    }

    /// Number of paths that failed before, and are missing here.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Number of paths whose value of an observable is NaN or infinite.
    pub fn not_finite(&self, observable: usize) -> u64 {
        self.moments.not_finite(observable)
    }

    /// The mean of an observable; NaN for an index that does not exist, and without paths; infinite if a
    /// value is.
    pub fn mean(&self, observable: usize) -> f64 {
        self.moments.mean(observable)
    }

    /// The unbiased covariance of two observables of independent paths; NaN where [`StatisticsNode::mean`] is
    /// or is infinite, for a single path and a single antithetic pair, and of two different ones if the run
    /// was set to omit covariances. It is infinite where it is too large for an `f64`; errors of means are
    /// not.
    ///
    /// Both paths of an antithetic pair depend on each other. For `n` paths, `2m` of them in `m` pairs, the
    /// expectation of `C`, the sum of products of deviations from the mean, is
    /// `(n - u/n) cov - (4m/n) cov_pairs`, with `u = n - 2m` and the covariance `cov_pairs` of the means of
    /// pairs. The estimate is `(C + (4m/n) cov_pairs) / (n - u/n)`, which is `C / (n - 1)` without pairs.
    pub fn covariance(&self, a: usize, b: usize) -> f64 {
        let independent = self.moments.covariance(a, b);
        let Some(pairs) = self.pairs.as_ref().filter(|pairs| pairs.count() > 0) else { return independent };
        let (n, m) = (self.moments.count() as f64, pairs.count() as f64);
        let single = n - 2.0 * m;
        let (of_paths, of_pairs) = ((n - 1.0) / (n - single / n), 4.0 * m / n / (n - single / n));
        of_paths * independent + of_pairs * pairs.covariance(a, b)
    }

    /// The unbiased variance of an observable, as [`StatisticsNode::covariance`].
    pub fn variance(&self, observable: usize) -> f64 {
        self.covariance(observable, observable)
    }

    /// The standard error of the mean: `√(variance / count)`, and for antithetic paths, which depend on each
    /// other, that of the means of their pairs, `√(variance of pairs / number of pairs)`.
    pub fn standard_error(&self, observable: usize) -> f64 {
        self.independent().standard_error(observable)
    }

    /// An upper estimate of the standard error of the mean, `√((variance + 10 D² / count) / count)` with the
    /// largest deviation `D` from the mean that was seen: as if it had occurred ten more times. The standard
    /// error itself is zero until a rare event is seen, and with heavy tails it is too small whenever the
    /// mean is. [`Ensemble::until_error`](crate::ensemble::Ensemble::until_error) compares this bound. NaN
    /// where the observable is the same number on all paths, such as an event that was never seen. Zero where
    /// it differs between paths and all antithetic pairs have the same mean: the observable is odd in the
    /// noise, and its mean is exact.
    pub fn error_bound(&self, observable: usize) -> f64 {
        match &self.pairs {
            Some(pairs) if pairs.is_constant(observable) && !self.is_constant(observable) => 0.0,
            _ => self.independent().error_bound(observable),
        }
    }

    /// The share of the path that is farthest from the mean in the variance of an observable. If one path has
    /// a large share, the error is that of this path: see
    /// [`TargetStatus::Dominated`](super::TargetStatus::Dominated).
    pub fn largest_share(&self, observable: usize) -> f64 {
        self.independent().largest_share(observable)
    }

    /// Whether an observable is the same number on all paths. If so, the frequency and size of other values
    /// are unknown.
    pub fn is_constant(&self, observable: usize) -> bool {
        self.moments.is_constant(observable)
    }

    pub(crate) fn has_covariances(&self) -> bool {
        self.moments.has_covariances()
    }

    /// The distance between the least and the greatest value of an observable.
    pub(crate) fn width(&self, observable: usize) -> f64 {
        self.moments.width(observable)
    }

    /// [`Moments::variance_bound`]
    pub(crate) fn variance_bound(&self, observable: usize, unseen: f64) -> f64 {
        self.moments.variance_bound(observable, unseen)
    }

    /// Samples that do not depend on each other.
    fn independent(&self) -> &Moments {
        self.pairs.as_ref().unwrap_or(&self.moments)
    }

    /// The quantiles of an observable, if they were requested.
    pub fn quantiles(&self, observable: usize) -> Option<&Quantiles> {
        self.quantiles.get(observable)
    }

    /// The histograms, in the order in which they were requested.
    pub fn histograms(&self) -> &[Histogram] {
        &self.histograms
    }
}
