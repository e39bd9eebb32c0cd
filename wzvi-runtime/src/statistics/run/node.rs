//! All paths of an ensemble at one time.

use super::Wanted;
#[cfg(feature = "serde")]
use crate::ground::numbers::Tape;
use crate::statistics::histogram::Histogram;
use crate::statistics::moments::Moments;
use crate::statistics::quantiles::Quantiles;

/// Room to add paths to sums, one after the other.
#[derive(Clone, Debug)]
pub(crate) struct PathTally {
    scratch: Vec<f64>,
    /// The values of the first path of an antithetic pair, if it had any.
    first: Vec<f64>,
    has_first: bool,
    /// Whether the next one is the second of a pair.
    is_second: bool,
}

impl PathTally {
    pub(crate) fn new(observables: usize) -> Self {
        let room = || vec![0.0; observables];
        Self { scratch: room(), first: room(), has_first: false, is_second: false }
    }
}

/// All paths at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct StatisticsNode {
    time: f64,
    /// Paths that failed before.
    lost: u64,
    moments: Moments,
    /// Of the means of antithetic pairs.
    pairs: Option<Moments>,
    quantiles: Vec<Quantiles>,
    histograms: Vec<Histogram>,
}

impl StatisticsNode {
    pub(crate) fn new(time: f64, wanted: &Wanted) -> Self {
        let observables = wanted.names.len();
        Self {
            time,
            lost: 0,
            moments: Moments::new(observables, wanted.has_covariances),
            pairs: wanted.has_pairs.then(|| Moments::new(observables, wanted.has_covariances)),
            quantiles: vec![Quantiles::default(); if wanted.quantiles { observables } else { 0 }],
            histograms: wanted.histograms.iter().map(|(_, empty)| empty.clone()).collect(),
        }
    }

    /// The observables of the next path, if it has not failed before.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn tally(&mut self, values: Option<&[f64]>, tally: &mut PathTally, wanted: &Wanted) {
        let PathTally { scratch, first, has_first, is_second } = tally;
        match values {
            Some(values) => {
                self.push(values, scratch, wanted);
                if wanted.has_pairs && !*is_second {
                    first.copy_from_slice(values);
                } else if wanted.has_pairs && *has_first {
                    self.push_pair(first, values, scratch);
                }
            }
            None => self.lost += 1,
        }
        (*has_first, *is_second) = (values.is_some(), wanted.has_pairs && !*is_second);
    }

    /// The observables of one more path; `scratch` has as many elements.
    pub(crate) fn push(&mut self, values: &[f64], scratch: &mut [f64], wanted: &Wanted) {
        self.moments.push(values, scratch);
        for (quantiles, value) in self.quantiles.iter_mut().zip(values) {
            quantiles.push(*value);
        }
        for (histogram, (observable, _)) in self.histograms.iter_mut().zip(&wanted.histograms) {
            histogram.push(values[*observable]);
        }
    }

    /// The observables of both paths of an antithetic pair, which have been pushed, too; `first` becomes their mean.
    fn push_pair(&mut self, first: &mut [f64], second: &[f64], scratch: &mut [f64]) {
        let Some(pairs) = &mut self.pairs else { return };
        for (first, second) in first.iter_mut().zip(second) {
            *first = 0.5 * *first + 0.5 * second;
        }
        pairs.push(first, scratch);
    }

    pub(crate) fn merge(&mut self, other: &Self) {
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

    #[cfg(feature = "serde")]
    pub(crate) fn pass(&mut self, tape: &mut Tape) {
        tape.word(&mut self.lost);
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

    /// Number of paths that failed before, and are missing here.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Number of paths whose value of an observable is NaN or infinite.
    pub fn not_finite(&self, observable: usize) -> u64 {
        self.moments.not_finite(observable)
    }

    /// The mean of an observable; NaN for an index that does not exist, and without paths; infinite if a value is.
    pub fn mean(&self, observable: usize) -> f64 {
        self.moments.mean(observable)
    }

    /// The unbiased covariance of two observables; NaN where [`StatisticsNode::mean`] is or is infinite, for a single path, and of two different
    /// ones if the run was told to leave covariances out.
    pub fn covariance(&self, a: usize, b: usize) -> f64 {
        self.moments.covariance(a, b)
    }

    /// The unbiased variance of an observable, as [`StatisticsNode::covariance`].
    pub fn variance(&self, observable: usize) -> f64 {
        self.covariance(observable, observable)
    }

    /// The standard error of the mean: `√(variance / count)`, and for antithetic paths, which depend on each other, that of
    /// the means of their pairs, `√(variance of pairs / number of pairs)`.
    pub fn standard_error(&self, observable: usize) -> f64 {
        self.independent().standard_error(observable)
    }

    /// An upper estimate of the standard error of the mean, `√((variance + 10 D² / count) / count)` with the largest deviation `D` from the
    /// mean that was seen: as if that had come ten times more. The standard error itself is zero until a rare event is seen, and with
    /// heavy tails too small just where the mean is, too; this one is what [`Ensemble::until_error`](crate::ensemble::Ensemble::until_error) compares.
    /// NaN where the observable is the same number on all paths, as an event that was never seen.
    pub fn error_bound(&self, observable: usize) -> f64 {
        self.independent().error_bound(observable)
    }

    /// The share of the path that is farthest from the mean in the variance of an observable. An error in which one path has a large share is that of this
    /// path: see [`TargetStatus::Dominated`](super::TargetStatus::Dominated).
    pub fn largest_share(&self, observable: usize) -> f64 {
        self.independent().largest_share(observable)
    }

    /// Whether an observable is the same number on all paths: then nothing is known of how often, and how far, it is another.
    pub fn is_constant(&self, observable: usize) -> bool {
        self.moments.is_constant(observable)
    }

    pub(crate) fn has_covariances(&self) -> bool {
        self.moments.has_covariances()
    }

    /// Samples that do not depend on each other.
    fn independent(&self) -> &Moments {
        self.pairs.as_ref().unwrap_or(&self.moments)
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
