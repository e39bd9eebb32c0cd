//! Several paths of one system, compared by their means.

use super::TimeAverages;
use crate::algebra::scalar::Scalar;
use crate::algebra::student::{NORMAL, normal_of_ratio, quantile};
use crate::error::wrong;
use crate::trajectory::Error;

/// The average of an observable over several independent paths, and whether they agree.
///
/// A path that has not left the region of its start has a small error, but of the mean over that region.
/// Paths from starts in different regions then have different means:
///
/// ```ignore
/// let run = |start, seed| {
///     let run = well.simulate::<Baoab>(0.1).start(start).noise(StepNormals::seed(seed)).until(1e5);
///     run.observe("q", |state| state.q[0]).time_averages().discard(50.0).until_error("q", 0.02).run()
/// };
/// let starts = [-1.0, 1.0, -1.0, 1.0].map(|q| State::new([q], [0.0]));
/// let runs: Result<Vec<_>, _> = starts.into_iter().zip(1..).map(|(start, seed)| run(start, seed)).collect();
/// let chains = Chains::of("q", &runs?)?;
/// assert!(chains.agree(), "{chains:?}");
/// ```
///
/// The paths must be independent (a seed for each), and equally long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chains {
    /// The mean of their means.
    pub mean: f64,
    /// Its standard error by the spread of their means: also where they disagree, if their starts are drawn
    /// by the law of the system.
    pub standard_error: f64,
    /// `mean ± 1.96 error_bound` is the interval of Student's t, of one degree of freedom less than there are
    /// paths.
    pub error_bound: f64,
    /// The difference of their means beyond the errors of the single paths, as a standard normal number:
    /// above 1.645 in 5 % of the cases where all have the same law (an analysis of variance, in E. Paulson's
    /// approximation). NaN while a path is too short to know its error.
    pub disagreement: f64,
}

impl Chains {
    /// Compares the averages of the observable with this name.
    ///
    /// # Errors
    /// [`Error::Name`] for a name that nothing was observed under, [`Error::Config`] for fewer than two
    /// paths.
    pub fn of<V>(name: &str, chains: &[TimeAverages<V>]) -> Result<Self, Error> {
        let averages: Vec<_> = chains.iter().map(|chain| chain.of(name)).collect::<Result<_, _>>()?;
        if averages.len() < 2 {
            return wrong(format!("a comparison of {} paths: give two or more", averages.len()));
        }
        let count = averages.len() as f64;
        let mean = averages.iter().map(|average| average.mean).sum::<f64>() / count;
        let squares = averages.iter().map(|average| Scalar::powi(average.mean - mean, 2)).sum::<f64>();
        let between = squares / (count - 1.0);
        let inside =
            averages.iter().map(|average| Scalar::powi(average.standard_error, 2)).sum::<f64>() / count;
        let degrees = averages.iter().map(|average| average.degrees).sum();
        let standard_error = (between / count).sqrt();
        Ok(Self {
            mean,
            standard_error,
            error_bound: standard_error * quantile(count - 1.0) / NORMAL,
            disagreement: normal_of_ratio(between / inside, [count - 1.0, degrees]),
        })
    }

    /// Whether their means differ by no more than their errors allow, at a level of 5 %.
    pub fn agree(&self) -> bool {
        self.disagreement <= 1.645
    }
}
