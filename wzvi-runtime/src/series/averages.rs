//! One long path that is not kept: its averages, until they are exact enough.

use std::ops::ControlFlow;

use super::BatchMeans;
use crate::error::{ConfigError, Error, UnknownName};
use crate::increments::Noise;
use crate::retry::Serves;
use crate::simulate::{Observer, Simulation};
use crate::state::State;
use crate::system::{Discretized, Exchange};

/// Averages along one path: [`Simulation::time_averages`] begins it, [`TimeAveraging::run`] runs it.
#[must_use = "nothing happens before `run`"]
#[derive(Debug)]
pub struct TimeAveraging<'a, H: Discretized<E>, E, N, O, R> {
    simulation: Simulation<'a, H, E, N, O, R>,
    discarded: f64,
    targets: Vec<(String, f64)>,
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
    /// The standard error of the mean, correlations included.
    pub standard_error: f64,
    /// An upper estimate of it: [`BatchMeans::error_bound`].
    pub error_bound: f64,
    /// The integrated autocorrelation time, in time units.
    pub time: f64,
}

/// What a run of averages leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeAverages<V> {
    /// By observable, in the order in which they were asked for.
    pub averages: Vec<TimeAverage>,
    /// Where the path ended: a start for the next.
    pub last: State<V>,
    /// Steps that it took.
    pub steps: u64,
    /// Energy that it took from forces and bath, in units of energy.
    pub exchanged: Exchange,
    /// Whether all targets were met, if there were any.
    pub met_targets: Option<bool>,
}

impl<V> TimeAverages<V> {
    /// The average of the observable with this name.
    ///
    /// # Errors
    /// [`UnknownName`] for a name that nothing was observed under.
    pub fn of(&self, name: &str) -> Result<&TimeAverage, UnknownName> {
        self.averages.iter().find(|average| average.name == name).ok_or_else(|| UnknownName {
            kind: "observable",
            name: name.to_owned(),
            known: self.averages.iter().map(|average| average.name.clone()).collect(),
        })
    }
}

impl<'a, H: Discretized<E>, E, N, O, R> Simulation<'a, H, E, N, O, R> {
    /// Averages of the observables along the path, which is not kept: over all nodes, or every `record_every`-th.
    ///
    /// ```ignore
    /// let run = system.simulate::<Baoab>(0.1).start(start).noise(Wiener::seed(7)).until(1e6);
    /// let run = run.observe("q²", |state| state.q[0].powi(2)).time_averages();
    /// let averages = run.discard(20.0).until_error("q²", 1e-3).run()?;
    /// println!("{:?}", averages.of("q²")?);
    /// ```
    pub fn time_averages(self) -> TimeAveraging<'a, H, E, N, O, R> {
        TimeAveraging { simulation: self, discarded: 0.0, targets: Vec::new() }
    }
}

/// When it is looked again whether errors are small enough: after so many values, and after a fiftieth more.
const LOOKS: u64 = 64;

impl<H, E, N, O, R> TimeAveraging<'_, H, E, N, O, R>
where
    H: Discretized<E>,
    N: Noise + Serves<R>,
    O: Observer<H::Vector>,
{
    /// Leaves out the nodes of the first `time` (time units), until the path has forgotten its start.
    pub fn discard(mut self, time: f64) -> Self {
        self.discarded = time;
        self
    }

    /// Ends the run when the error of the average of an observable is `target` (units of the observable) or less, correlations included; the end of the
    /// run is then a limit. Compared is an upper estimate ([`BatchMeans::error_bound`]), which is there once the path has lasted for some 640 correlation
    /// times. Asked more than once, all errors must be that small.
    pub fn until_error(mut self, observable: impl Into<String>, target: f64) -> Self {
        self.targets.push((observable.into(), target));
        self
    }

    /// Runs the path.
    ///
    /// # Errors
    /// Those of [`Simulation::run`]; [`Error::Name`] for a target of an observable that there is not, [`Error::Config`] for targets that are not positive
    /// and settings that averages have no use for: times, sections, checkpoints, observers.
    pub fn run(self) -> Result<TimeAverages<H::Vector>, Error> {
        let Self { mut simulation, discarded, targets } = self;
        let (names, functions) = simulation.take_observables()?;
        let mut wanted = vec![f64::INFINITY; names.len()];
        for (name, target) in &targets {
            let place = names.iter().position(|known| known == name);
            let place = place.ok_or_else(|| UnknownName {
                kind: "observable",
                name: name.clone(),
                known: names.clone(),
            })?;
            if !(target.is_finite() && *target > 0.0) {
                let wrong = format!("an error of {target} for `{name}`: take a finite number above 0");
                return Err(ConfigError::Setting(wrong).into());
            }
            wanted[place] = wanted[place].min(*target);
        }
        let (h, stride) = simulation.spacing();
        let mut batches = vec![BatchMeans::new(); names.len()];
        let (mut next, mut met) = (LOOKS, false);
        let has_targets = !targets.is_empty();
        let end = simulation.visit(|state, time| {
            if time.abs() < discarded {
                return ControlFlow::Continue(());
            }
            for (batches, function) in batches.iter_mut().zip(&functions) {
                batches.add(function(state));
            }
            let count = batches.first().map_or(0, BatchMeans::count);
            if has_targets && count >= next {
                next = count + LOOKS.max(count / 50);
                met = batches
                    .iter()
                    .zip(&wanted)
                    .all(|(batches, wanted)| *wanted == f64::INFINITY || batches.error_bound() <= *wanted);
            }
            if met { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })?;
        let averages = names.into_iter().zip(&batches).map(|(name, batches)| TimeAverage {
            name,
            mean: batches.mean(),
            variance: batches.variance(),
            standard_error: batches.standard_error(),
            error_bound: batches.error_bound(),
            time: batches.time() * (h * stride as f64).abs(),
        });
        Ok(TimeAverages {
            averages: averages.collect(),
            last: end.last,
            steps: end.steps,
            exchanged: end.exchanged,
            met_targets: has_targets.then_some(met),
        })
    }
}
