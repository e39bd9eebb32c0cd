//! One long path that is not kept: its averages, until they are exact enough.

use std::fmt;

use super::BatchMeans;
use super::tally::{Averaged, NamedTargets, Tally};
use crate::algebra::state::State;
use crate::error::{UnknownName, wrong};
use crate::ground::digits::estimate;
use crate::increments::Noise;
use crate::saving::FileError;
use crate::scheme::system::{Discretized, Exchange, disequilibrium};
use crate::trajectory::Error;
use crate::trajectory::simulate::{Observer, Simulation, Summation, UsualSums};

/// Averages along one path: [`Simulation::time_averages`] begins it, [`TimeAveraging::run`] runs it.
#[must_use = "nothing happens before `run`"]
pub struct TimeAveraging<'a, H: Discretized<E>, E, N, O, S = UsualSums> {
    simulation: Simulation<'a, H, E, N, O, S>,
    discarded: f64,
    targets: NamedTargets,
    stop: Option<Box<dyn Fn() -> bool + 'a>>,
}

/// The average of one observable.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeAverage {
    /// The name that it was observed under.
    pub name: String,
    /// The mean over time, in units of the observable.
    pub mean: f64,
    /// The variance of the values.
    pub variance: f64,
    /// The standard error of the mean, correlations included ([`BatchMeans::standard_error`]); NaN while the
    /// path is too short to know it.
    pub standard_error: f64,
    /// `mean ± 1.96 error_bound` covers the mean in 95 % of paths that last for 40 of their slowest
    /// correlation times: [`BatchMeans::error_bound`].
    pub error_bound: f64,
    /// Degrees of freedom of the error ([`BatchMeans::degrees`]).
    pub degrees: f64,
    /// The integrated autocorrelation time, in time units; NaN as the error is.
    pub time: f64,
}

/// The result of a run of averages.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeAverages<V> {
    /// One for each observable, in the order of the requests.
    pub averages: Vec<TimeAverage>,
    /// The last state of the path, from which a next one can start.
    pub last: State<V>,
    /// Steps that it took.
    pub steps: u64,
    /// Energy that it took from forces and bath, in units of energy.
    pub exchanged: Exchange,
    /// The heat by degree of freedom
    /// ([`Trajectory::heat_by_degree`](crate::trajectory::recorded::Trajectory::heat_by_degree)).
    pub heat_by_degree: Vec<f64>,
    /// Why the system has no equilibrium, if it has none: its temperatures differ, or depend on the time.
    pub no_equilibrium: Option<&'static str>,
    /// Whether all targets are met, if there are any.
    pub met_targets: Option<bool>,
    /// Whether the run was stopped before its end and its targets.
    pub is_partial: bool,
    /// Why the last [checkpoint](Simulation::checkpoint) could not be written; `None` if it was, and without
    /// one.
    pub unsaved: Option<FileError>,
}

impl<V> TimeAverages<V> {
    /// The average of the observable with this name.
    ///
    /// # Errors
    /// [`UnknownName`] for a name that nothing was observed under.
    pub fn of(&self, name: &str) -> Result<&TimeAverage, UnknownName> {
        UnknownName::find("observable", name, self.averages.iter().map(|average| (&average.name, average)))
    }
}

/// `q²  1.002 ± 0.003`, with the standard error; three digits where that is not known.
impl fmt::Display for TimeAverage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.padded(0, f)
    }
}

impl TimeAverage {
    /// With the name filled up to this width.
    fn padded(&self, width: usize, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:width$}  {}", self.name, estimate(self.mean, self.standard_error))?;
        if self.standard_error.is_nan() {
            f.write_str(" (error not known yet)")?;
        }
        Ok(())
    }
}

/// The averages of all observables, a line each.
impl<V> fmt::Display for TimeAverages<V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let partial = if self.is_partial { " (partial)" } else { "" };
        write!(f, "averages over {} steps{partial}", self.steps)?;
        match self.met_targets {
            Some(true) => f.write_str(", targets met")?,
            Some(false) => f.write_str(", targets not met")?,
            None => {}
        }
        if let Some(why) = self.no_equilibrium {
            write!(f, "\nno equilibrium: {why}")?;
        }
        let width = self.averages.iter().map(|average| average.name.chars().count()).max().unwrap_or(0);
        self.averages.iter().try_for_each(|average| {
            f.write_str("\n")?;
            average.padded(width, f)
        })
    }
}

impl<'a, H: Discretized<E>, E, N, O, S> Simulation<'a, H, E, N, O, S> {
    /// Averages of the observables along the path, which is not kept: over all nodes, or every
    /// `record_every`-th.
    ///
    /// ```ignore
    /// let run = system.simulate::<Baoab>(0.1).start(start).noise(Wiener::seed(7)).until(1e6);
    /// let run = run.observe("q²", |state| state.q[0].powi(2)).time_averages();
    /// let averages = run.discard(20.0).until_error("q²", 1e-3).run()?;
    /// println!("{}", averages.of("q²")?);
    /// ```
    ///
    /// With `checkpoint` a stopped run resumes from its file; its targets may differ.
    pub fn time_averages(self) -> TimeAveraging<'a, H, E, N, O, S> {
        TimeAveraging { simulation: self, discarded: 0.0, targets: Vec::new(), stop: None }
    }
}

impl<H: Discretized<E>, E, N, O, S> fmt::Debug for TimeAveraging<'_, H, E, N, O, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut all = f.debug_struct("TimeAveraging");
        all.field("discarded", &self.discarded).field("targets", &self.targets).finish_non_exhaustive()
    }
}

impl<'a, H, E, N, O, S> TimeAveraging<'a, H, E, N, O, S>
where
    H: Discretized<E>,
    N: Noise,
    O: Observer<H::Vector>,
    S: Summation<H, E>,
{
    /// Leaves out the nodes of the first `time` (time units), until the path has forgotten its start.
    pub fn discard(mut self, time: f64) -> Self {
        self.discarded = time;
        self
    }

    /// Ends the run when the error of the average of an observable is `target` (units of the observable) or
    /// less, correlations included; the end of the run is then a limit. The test uses
    /// [`BatchMeans::error_bound`], and the same by batches of half the length; they are known once the path
    /// has lasted for some 50 correlation times. If this is called more than once, all targets must be met.
    ///
    /// **A path samples only the regions that it visits.** A path that has stayed in one of two wells has a
    /// small error of the mean over that well, and meets the target. Where a system may have more than one
    /// region, run several paths from starts in different ones, and compare their means:
    /// [`Chains`](super::Chains).
    pub fn until_error(mut self, observable: impl Into<String>, target: f64) -> Self {
        self.targets.push((observable.into(), target));
        self
    }

    /// Ends the run early when `stop` returns true, at a deadline for example. The averages then cover the
    /// path so far ([`TimeAverages::is_partial`]). It is called about ten times a second. The
    /// [handle](Simulation::handle) of the path stops it, too.
    pub fn stop_when(mut self, stop: impl Fn() -> bool + 'a) -> Self {
        self.stop = Some(Box::new(stop));
        self
    }

    /// Runs the path.
    ///
    /// # Errors
    /// The errors of [`Simulation::run`]; [`Error::Name`] for the target of an unknown observable,
    /// [`Error::Config`] for targets that are not positive, for a time to discard that is negative or not
    /// finite, and for settings without meaning here: times, sections, observers. `Error::Checkpoint` for a
    /// checkpoint that cannot be written or resumed.
    pub fn run(self) -> Result<TimeAverages<H::Vector>, Error> {
        let Self { simulation, discarded, targets, stop } = self;
        if H::PROPERTIES.is_clocked {
            return wrong(
                "`time_averages` of a path by a clock, whose steps have no common length: record it at equal times, \
                 `.record_at(times)`, and average what is observed there",
            );
        }
        let (simulation, averaged) = simulation.without_path()?;
        let Averaged { h, stride, .. } = averaged;
        let run = simulation.observed_by(Tally::new(averaged, discarded, &targets)?);
        let ((path, error), tally) = run.run_until(stop.as_deref())?;
        let is_partial = matches!(error, Some(Error::Stopped(_)));
        if let Some(error) = error.filter(|_| !is_partial) {
            return Err(error);
        }
        let met_targets = (!targets.is_empty()).then(|| tally.meets_targets());
        let average = |(name, batches): (&String, &BatchMeans)| TimeAverage {
            name: name.clone(),
            mean: batches.mean(),
            variance: batches.variance(),
            standard_error: batches.standard_error(),
            error_bound: batches.error_bound(),
            degrees: batches.degrees(),
            time: batches.time() * (h * stride as f64).abs(),
        };
        let (steps, exchanged) = path.taken();
        Ok(TimeAverages {
            averages: tally.batches().map(average).collect(),
            last: path.last().clone(),
            steps,
            exchanged,
            no_equilibrium: disequilibrium(&H::PLAN, &H::PROPERTIES),
            heat_by_degree: path.heat_by_degree().to_vec(),
            met_targets,
            is_partial,
            unsaved: path.unsaved().cloned(),
        })
    }
}
