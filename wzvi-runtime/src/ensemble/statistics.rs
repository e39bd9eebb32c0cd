//! Moments as the paths run, in memory that does not grow with their number.

use crate::error::StepError;

/// Failed paths that are kept with their errors; further ones are only counted.
const MOST_FAILURES: usize = 1000;

/// Means and covariances of several observables over paths (B. P. Welford, Technometrics 4 (1962) 419; merged as in T. F. Chan,
/// G. H. Golub, R. J. LeVeque, "Updating formulae and a pairwise algorithm for computing sample variances", 1979).
#[derive(Clone, Debug, PartialEq)]
pub struct Moments {
    time: f64,
    count: u64,
    mean: Vec<f64>,
    /// Sums of products of deviations, by rows.
    comoment: Vec<f64>,
}

impl Moments {
    pub(super) fn new(time: f64, observables: usize) -> Self {
        Self { time, count: 0, mean: vec![0.0; observables], comoment: vec![0.0; observables * observables] }
    }

    /// One more path; `scratch` has as many elements as `values`.
    pub(super) fn push(&mut self, values: &[f64], scratch: &mut [f64]) {
        self.count += 1;
        let weight = 1.0 / self.count as f64;
        for ((mean, deviation), value) in self.mean.iter_mut().zip(scratch.iter_mut()).zip(values) {
            *deviation = value - *mean;
            *mean += *deviation * weight;
        }
        let rows = self.comoment.chunks_exact_mut(values.len());
        for (row, deviation) in rows.zip(scratch.iter()) {
            for ((sum, value), mean) in row.iter_mut().zip(values).zip(&self.mean) {
                *sum += deviation * (value - mean);
            }
        }
    }

    /// The paths of both. The order matters to the last bit.
    pub(super) fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        let (a, b) = (self.count as f64, other.count as f64);
        let (n, total) = (self.mean.len(), a + b);
        let difference: Vec<f64> =
            other.mean.iter().zip(&self.mean).map(|(theirs, ours)| theirs - ours).collect();
        for (i, (sum, theirs)) in self.comoment.iter_mut().zip(&other.comoment).enumerate() {
            *sum += theirs + difference[i / n] * difference[i % n] * (a * b / total);
        }
        for (mean, difference) in self.mean.iter_mut().zip(&difference) {
            *mean += difference * (b / total);
        }
        self.count += other.count;
    }

    /// The time, in the units of the Hamiltonian.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Number of paths that got here.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The mean of an observable; NaN for one that does not exist, and without paths.
    pub fn mean(&self, observable: usize) -> f64 {
        if self.count == 0 { f64::NAN } else { self.mean.get(observable).copied().unwrap_or(f64::NAN) }
    }

    /// The unbiased covariance of two observables; NaN where [`Moments::mean`] is, and for a single path.
    pub fn covariance(&self, a: usize, b: usize) -> f64 {
        let n = self.mean.len();
        if a >= n || b >= n || self.count < 2 {
            return f64::NAN;
        }
        self.comoment[a * n + b] / (self.count - 1) as f64
    }

    /// The unbiased variance of an observable, as [`Moments::covariance`].
    pub fn variance(&self, observable: usize) -> f64 {
        self.covariance(observable, observable)
    }

    /// The standard error of the mean, `√(variance / count)`.
    pub fn standard_error(&self, observable: usize) -> f64 {
        (self.variance(observable) / self.count as f64).sqrt()
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

/// What an ensemble found out.
///
/// A path that fails counts until the last node that it reached, and is missing after that: [`Statistics::failed`] says of
/// how many that is true.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    pub(super) names: Vec<String>,
    pub(super) nodes: Vec<Moments>,
    pub(super) failed: u64,
    pub(super) failures: Vec<PathFailure>,
}

impl Statistics {
    pub(super) fn new(names: &[String], times: &[f64]) -> Self {
        let nodes = times.iter().map(|&time| Moments::new(time, names.len())).collect();
        Self { names: names.to_vec(), nodes, failed: 0, failures: Vec::new() }
    }

    pub(super) fn fail(&mut self, failure: PathFailure) {
        self.failed += 1;
        if self.failures.len() < MOST_FAILURES {
            self.failures.push(failure);
        }
    }

    pub(super) fn merge(&mut self, other: &Self) {
        for (ours, theirs) in self.nodes.iter_mut().zip(&other.nodes) {
            ours.merge(theirs);
        }
        self.failed += other.failed;
        let room = MOST_FAILURES - self.failures.len();
        self.failures.extend(other.failures.iter().take(room));
    }

    /// The names of the observables, in the order of the indices.
    pub fn observables(&self) -> &[String] {
        &self.names
    }

    /// The index of an observable.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// The moments at each recorded time, the start first.
    pub fn nodes(&self) -> &[Moments] {
        &self.nodes
    }

    /// The moments at the end; `None` never, since the start is always there.
    pub fn last(&self) -> Option<&Moments> {
        self.nodes.last()
    }

    /// The mean of an observable at the end; NaN for a name that does not exist.
    pub fn mean(&self, name: &str) -> f64 {
        self.at_end(name, Moments::mean)
    }

    /// Its variance.
    pub fn variance(&self, name: &str) -> f64 {
        self.at_end(name, Moments::variance)
    }

    /// The standard error of its mean.
    pub fn standard_error(&self, name: &str) -> f64 {
        self.at_end(name, Moments::standard_error)
    }

    fn at_end(&self, name: &str, what: fn(&Moments, usize) -> f64) -> f64 {
        self.last().zip(self.index(name)).map_or(f64::NAN, |(moments, index)| what(moments, index))
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
