//! Many paths at once: their statistics at the price of their noise.
//!
//! Paths run in the lanes of vector registers ([`crate::lanes`]), in blocks of fixed size that threads take one after the
//! other; blocks are merged in the order of their numbers. So the result is the same, bit for bit, for any number of
//! threads, any width of the lanes and any [`InstructionSet`]. Increments are those of [`StepNormals`]: `√|h| ξ` with one normal `ξ` for
//! each (seed, step size, process, path, step), truncated where that is asked for, unless another noise is given
//! ([`Ensemble::noise`]). They are no Wiener tree: another step size is another sample, except beside each other on the levels of
//! [`Multilevel`].
//!
//! A path is that of [`Stepper::plain`](crate::step::Stepper::plain) with the same increments: to the last bit if `H` has
//! arithmetic and roots only; elementary functions of lanes ([`crate::lanes`]) are not those of `std`. A step that the
//! short way does not solve is the one that the stepper then takes, with the functions of `std`.
//!
//! A path whose step fails is halved there if that is allowed ([`Ensemble::retry`]), and ends there if not, with its number and error in
//! [`Statistics::failures`]; its neighbours do not notice. [`Ensemble::replay`] runs a single one of them again.

mod account;
mod block;
#[cfg(feature = "mpi")]
pub mod cluster;
#[cfg(feature = "columnar")]
mod columnar;
mod control;
mod draws;
mod error;
mod group;
mod histogram;
mod job;
#[cfg(feature = "serde")]
mod keeping;
#[cfg(not(feature = "serde"))]
#[path = "ensemble/keeping/absent.rs"]
mod keeping;
mod moments;
mod multilevel;
mod origin;
mod pace;
mod passage;
mod paths;
mod quantiles;
mod replay;
mod source;
mod statistics;
mod table;

use std::marker::PhantomData;
use std::sync::OnceLock;

use crate::lanes::instructions as dispatch;
use account::Account;
use control::Control;
pub use dispatch::{InstructionSet, Kernel};
pub use draws::Normals;
pub use error::{LossError, StatisticsError};
pub use histogram::Histogram;
use job::{Job, Observable, Stop};
pub use multilevel::{Level, LevelError, LevelFailure, Multilevel, MultilevelEstimate};
pub use passage::Passages;
use passage::Watch;
pub use paths::Paths;
pub use quantiles::Quantiles;
use source::{Settings, Source};
use statistics::Wanted;
pub use statistics::{Node, PathFailure, Statistics, TargetStatus};

use crate::checkpoint::Keeping;
use crate::error::{ConfigError, Error, UnknownName};
use crate::increments::Interval;
use crate::interrupt::Interrupt;
use crate::noise::{Paths as PathsOfNoise, StepNormals, Truncation};
pub use crate::persist::FileError;
pub use crate::persist::table::{Column, Table};
use crate::retry::Retry;
use crate::schedule::threads;
use crate::simulate::{End, checked, chosen_steps, count};
use crate::state::{State, Vector};
use crate::system::Discretized;

/// More recorded nodes than anyone looks at.
const MOST_NODES: u64 = 1 << 20;
/// Statistics of a block of paths that take more bytes are refused: some blocks wait for others, on each thread.
const MOST_BYTES: u128 = 1 << 30;
/// Bins of passage times.
const PASSAGE_BINS: usize = 100;

/// An ensemble to run: [`Integrate::ensemble`](crate::integrate::Integrate::ensemble) begins it, [`Ensemble::run`] runs
/// it.
///
/// A start, an end and a number of paths are needed, and a seed or a noise if the system has any. A later setting replaces an
/// earlier one.
#[must_use = "nothing happens before `run`"]
pub struct Ensemble<'a, H: Discretized<E>, E> {
    system: &'a H,
    h: f64,
    start: Option<State<H::Vector>>,
    paths: Option<u64>,
    source: Option<Source<'a>>,
    end: Option<End>,
    every: u64,
    chosen: Vec<f64>,
    observables: Vec<Named<'a, H::Vector>>,
    events: Vec<Named<'a, H::Vector>>,
    quantiles: bool,
    covariances: bool,
    histograms: Vec<(String, [f64; 2], usize)>,
    most_bytes: Option<u64>,
    threads: Option<usize>,
    truncation: Truncation,
    instructions: InstructionSet,
    keeping: Keeping,
    is_antithetic: bool,
    retry: Retry,
    control: Control<'a>,
    scheme: PhantomData<fn() -> E>,
}

impl<'a, H: Discretized<E>, E> Ensemble<'a, H, E> {
    /// Paths of `system` in steps of size `h`.
    pub fn new(system: &'a H, h: f64) -> Self {
        Self {
            system,
            h,
            start: None,
            paths: None,
            source: None,
            end: None,
            every: 0,
            chosen: Vec::new(),
            observables: Vec::new(),
            events: Vec::new(),
            quantiles: false,
            covariances: true,
            histograms: Vec::new(),
            most_bytes: None,
            threads: None,
            truncation: Truncation::Unset,
            instructions: InstructionSet::best(),
            keeping: Keeping::default(),
            is_antithetic: false,
            retry: Retry::never(),
            control: Control::default(),
            scheme: PhantomData,
        }
    }

    /// The first state of every path.
    pub fn start(mut self, start: State<H::Vector>) -> Self {
        self.start = Some(start);
        self
    }

    /// How many paths; with [`Ensemble::until_error`], how many at most.
    pub fn paths(mut self, paths: u64) -> Self {
        self.paths = Some(paths);
        self
    }

    /// The noise `StepNormals::seed(seed)`, the fast one.
    pub fn seed(self, seed: u64) -> Self {
        self.noise(StepNormals::seed(seed))
    }

    /// Where the increments come from: path `n` of the ensemble has path `n` of the noise, and [`Increments`](crate::increments::Increments)
    /// are those of every path. A system without noise takes any and asks it for nothing.
    ///
    /// [`StepNormals`] are drawn in lanes; any other noise is asked for each path's increments one by one, and costs what it costs in a
    /// single run.
    pub fn noise(mut self, noise: impl PathsOfNoise + Clone + Send + Sync + 'a) -> Self {
        self.source = Some(Source::new(noise));
        self
    }

    /// Halves steps that fail ([`crate::retry`]): `Retry::halving(8)` allows 256 parts. Not done unless asked for.
    ///
    /// A step that does not resolve the fastest motion ([`StepFailure::Unresolved`](crate::error::StepFailure::Unresolved)) ends its path
    /// nevertheless: a path that starts again would have been counted twice.
    pub fn retry(mut self, retry: Retry) -> Self {
        self.retry = retry;
        self
    }

    /// How many paths may fail, as a fraction of all; 0.01 if this is not called. More are an error ([`LossError`]), which has the
    /// statistics of the others.
    pub fn allow_losses(mut self, fraction: f64) -> Self {
        self.control.losses = Some(fraction);
        self
    }

    /// Runs to time `end` (time units of the Hamiltonian): the first node at or beyond it.
    pub fn until(mut self, end: f64) -> Self {
        self.end = Some(End::Time(end));
        self
    }

    /// Runs `steps` steps.
    pub fn steps(mut self, steps: u64) -> Self {
        self.end = Some(End::Steps(steps));
        self
    }

    /// Statistics at every `stride`-th node, the start and the last; with 0, or if this is not called, only at these two.
    pub fn record_every(mut self, stride: u64) -> Self {
        self.every = stride;
        self
    }

    /// Statistics at these times, too: each at the first node at or beyond it.
    pub fn record_at(mut self, times: impl IntoIterator<Item = f64>) -> Self {
        self.chosen.extend(times);
        self
    }

    /// One more observable, a function of the state, at all recorded times; a value that is infinite or NaN shows in the moments of
    /// its time ([`Node::not_finite`]). Without any, all coordinates `q0, ...`, momenta `p0, ...` and the drift Hamiltonian `energy` are.
    pub fn observe(
        mut self,
        name: impl Into<String>,
        observable: impl Fn(&State<H::Vector>) -> f64 + Send + Sync + 'a,
    ) -> Self {
        self.observables.push((name.into(), Box::new(observable)));
        self
    }

    /// When does `event`, a function of the state, cross zero for the first time? It is asked at every node; what that
    /// means for the times is in [`Passages`]. More than one may be asked.
    pub fn first_passage(
        mut self,
        name: impl Into<String>,
        event: impl Fn(&State<H::Vector>) -> f64 + Send + Sync + 'a,
    ) -> Self {
        self.events.push((name.into(), Box::new(event)));
        self
    }

    /// Whether covariances of all pairs of observables are computed, as they are if this is not called: half the square of the
    /// number of observables in time and memory, at each recorded time. Variances always are.
    pub fn covariances(mut self, are_computed: bool) -> Self {
        self.covariances = are_computed;
        self
    }

    /// Quantiles of every observable at every recorded time, to a relative error of [`Quantiles::RELATIVE_ERROR`].
    pub fn quantiles(mut self) -> Self {
        self.quantiles = true;
        self
    }

    /// A histogram of the observable with this name at every recorded time, in so many bins from `lower` to `upper`.
    pub fn histogram(mut self, observable: impl Into<String>, lower: f64, upper: f64, bins: usize) -> Self {
        self.histograms.push((observable.into(), [lower, upper], bins));
        self
    }

    /// Keeps all observables of every path at every recorded time, if that takes `bytes` of memory at most.
    pub fn keep_paths(mut self, bytes: u64) -> Self {
        self.most_bytes = Some(bytes);
        self
    }

    /// Ends the run when the standard error of the mean of an observable at the end of the paths is `target` (units of the
    /// observable) or less; [`Ensemble::paths`] are then a limit, and [`Statistics::met_targets`] says whether they were
    /// enough. Asked more than once, all errors must be that small.
    ///
    /// That is looked at after each 512 paths, in the order of their numbers, from 1024 on: the result is the same for any
    /// number of threads. An error that is itself estimated is now and then too small by chance, and that would end the run: compared
    /// is an upper estimate ([`Node::error_bound`]), and an observable that has been the same number on all paths is not done before
    /// the limit ([`TargetStatus::Constant`]). The mean is then within 1.96 targets of the true one in 95 % of the runs or more, also for
    /// events of probability 0.001 and for the heavy tail of `exp(2 W)`, which `docs/ensembles.md` shows.
    pub fn until_error(mut self, observable: impl Into<String>, target: f64) -> Self {
        self.control.targets.push((observable.into(), target));
        self
    }

    /// Paths in pairs with negated normals: `2k` and `2k + 1`. An observable that is odd in the noise has the exact mean
    /// then, for one that is even nothing is won. Standard errors are those of independent pairs
    /// ([`Node::standard_error`]).
    pub fn antithetic(mut self) -> Self {
        self.is_antithetic = true;
        self
    }

    /// Ends the run early when `stop` says so: a deadline, for one. The statistics are then those of the paths that are
    /// done, and [`Statistics::is_partial`].
    ///
    /// It is asked from all threads, about every 10 ms, and after each step or observed path that takes longer. With the feature `interrupt`, Ctrl-C stops a
    /// run, too.
    pub fn stop_when(mut self, stop: impl Fn() -> bool + Send + Sync + 'a) -> Self {
        self.control.stop = Some(Box::new(stop));
        self
    }

    /// No progress on the terminal. It shows after a second if standard error is one, and never if it is not.
    pub fn quiet(mut self) -> Self {
        self.control.is_quiet = true;
        self
    }

    /// On so many threads; all cores if this is not called.
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = Some(threads);
        self
    }

    /// Whether the increments of a seed are truncated; if this is not called, with `k = 4` where
    /// [`Plan::truncates_increments`](crate::plan::Plan::truncates_increments).
    pub fn truncation(mut self, truncation: Truncation) -> Self {
        self.truncation = truncation;
        self
    }

    /// With these vector instructions, or the baseline's where the machine does not have them; the best that it has if
    /// this is not called. The result is the same.
    pub fn instructions(mut self, set: InstructionSet) -> Self {
        self.instructions = set;
        self
    }
}

impl<'a, H, E> Ensemble<'a, H, E>
where
    H: Discretized<E> + Sync,
    H::Vector: Send + Sync,
    H::Prepared: Send + Sync,
{
    /// Runs all paths.
    ///
    /// # Errors
    /// [`Error::Config`] if a setting is missing or makes no sense, [`Error::Noise`] if a noise that was given has no increments,
    /// [`Error::Step`] if all paths fail: the first failure, [`Error::Losses`] if more fail than are allowed. Fewer failures are in the
    /// [`Statistics`]. `Error::Checkpoint` if there is a checkpoint that cannot be
    /// written or gone on from.
    pub fn run(self) -> Result<Statistics, Error> {
        self.run_in::<0>()
    }

    /// [`Ensemble::run`] with `WIDTH` paths beside each other, with 0 as many as suit the instructions; the result is the
    /// same.
    #[doc(hidden)]
    pub fn run_in<const WIDTH: usize>(mut self) -> Result<Statistics, Error> {
        let (control, keeping) = (std::mem::take(&mut self.control), std::mem::take(&mut self.keeping));
        let (threads, instructions) = (threads(self.threads)?, self.instructions);
        let interrupt = Interrupt::watch();
        let stop = || interrupt.requested() || control.is_stopped();
        let job = self.job(&stop)?;
        if job.is_antithetic && WIDTH % 2 == 1 {
            return Err(
                ConfigError::Setting(format!("antithetic pairs in {WIDTH} lanes: take 2 or more")).into()
            );
        }
        let mut account = Account::open(&job, &control, keeping)?;
        job.run::<WIDTH>(account.blocks(), threads, instructions, |block| account.take(block));
        match job.failed_noise.into_inner() {
            Some(error) => Err(error.into()),
            None => account.close(),
        }
    }

    fn job<'s>(self, stop: Stop<'s>) -> Result<Job<'s, H, E>, Error>
    where
        'a: 's,
    {
        let Self { system, h, .. } = self;
        if !h.is_finite() || h == 0.0 {
            return Err(ConfigError::StepSize(h).into());
        }
        let start = checked(system, self.start)?;
        let steps = count(self.end, start.t, h)?;
        let paths = self.paths.ok_or(ConfigError::Missing("a number of paths: add `.paths(number)`"))?;
        if paths == 0 {
            return Err(ConfigError::Setting("0 paths: take at least 1".into()).into());
        }
        let processes = system.noises();
        let source = match self.source {
            Some(source) if processes > 0 => source,
            None if processes > 0 => {
                return Err(ConfigError::Missing(
                    "a seed for its noise: add `.seed(number)` or `.noise(...)`",
                )
                .into());
            }
            _ => Source::new(StepNormals::seed(0)),
        };
        let settings = Settings { truncation: self.truncation, is_antithetic: self.is_antithetic };
        let first = Interval { start: start.t, h, step: 0 };
        let source = source.prepared(settings, &H::PLAN, first, (processes, steps))?;
        if self.retry.most() > 0 && !source.is_path() {
            return Err(ConfigError::Setting(GIVEN.to_owned()).into());
        }
        let clip = source.normals().map_or(f64::INFINITY, |normals| normals.clip(h));
        let is_antithetic = source.is_antithetic();
        if is_antithetic && paths % 2 == 1 {
            let wrong = format!("{paths} antithetic paths: they come in pairs");
            return Err(ConfigError::Setting(wrong).into());
        }
        let end = start.t + steps as f64 * h;
        if !end.is_finite() {
            return Err(ConfigError::End { start: start.t, end, h }.into());
        }
        let recorded = recorded(self.every, &self.chosen, start.t, h, steps)?;
        let times: Vec<f64> = recorded.iter().map(|&steps| start.t + steps as f64 * h).collect();
        let observables = if self.observables.is_empty() {
            standard(system, start.q.components().len())
        } else {
            self.observables
        };
        let (names, observables): (Vec<_>, Vec<_>) = observables.into_iter().unzip();
        let (event_names, events): (Vec<_>, Vec<_>) = self.events.into_iter().unzip();
        for names in [&names, &event_names] {
            if let Some(twice) =
                names.iter().enumerate().find_map(|(i, name)| names[..i].contains(name).then_some(name))
            {
                return Err(ConfigError::Setting(format!(
                    "two observables or events have the name `{twice}`"
                ))
                .into());
            }
        }
        let between = [start.t.min(end), start.t.max(end)];
        let watches = event_names
            .into_iter()
            .map(|name| {
                // Without a step there is no time to count.
                let [lower, upper] = if steps == 0 { [start.t, start.t + h.abs()] } else { between };
                let histogram = Histogram::new(lower, upper, PASSAGE_BINS)?;
                Ok(Watch { name, start: start.t, end, histogram })
            })
            .collect::<Result<_, ConfigError>>()?;
        let histograms = self
            .histograms
            .into_iter()
            .map(|(name, [lower, upper], bins)| match names.iter().position(|known| *known == name) {
                Some(observable) => Ok((observable, Histogram::new(lower, upper, bins)?)),
                None => Err(unknown(name, &names)),
            })
            .collect::<Result<_, ConfigError>>()?;
        if let Some(most) = self.most_bytes {
            let bytes = Paths::bytes(paths, recorded.len(), names.len());
            if bytes > u128::from(most) {
                return Err(ConfigError::Setting(format!(
                    "the paths take {bytes} bytes to keep, more than the {most} that are allowed: record fewer times, or fewer \
                     paths"
                ))
                .into());
            }
        }
        let (quantiles, keeps_paths) = (self.quantiles, self.most_bytes.is_some());
        if is_antithetic && !events.is_empty() {
            return Err(ConfigError::Setting(
                "first passages of antithetic paths: their errors would be those of independent ones; leave out one of the two"
                    .into(),
            )
            .into());
        }
        let (has_pairs, has_covariances) = (is_antithetic, self.covariances);
        let wanted =
            Wanted { names, times, quantiles, histograms, watches, keeps_paths, has_pairs, has_covariances };
        let bytes = wanted.bytes();
        if bytes > MOST_BYTES {
            return Err(ConfigError::Setting(format!(
                "the statistics take {bytes} bytes for each block of paths, and {MOST_BYTES} are the most: leave covariances out with \
                 `.covariances(false)`, or record fewer times, observables or bins"
            ))
            .into());
        }
        let prepared = system.prepare(h)?;
        Ok(Job {
            system,
            prepared,
            h,
            start,
            paths,
            steps,
            recorded,
            source,
            clip,
            retry: self.retry,
            failed_noise: OnceLock::new(),
            observables,
            events,
            wanted,
            level: 0,
            is_antithetic,
            stop,
        })
    }
}

type Named<'a, V> = (String, Observable<'a, V>);

const GIVEN: &str = "`.retry(...)` needs increments between the nodes, which these do not have: use `.seed(number)`, `Wiener` or `WongZakai`, \
                     or leave `.retry(...)` out";

/// There is no observable of this name.
fn unknown(name: String, names: &[String]) -> ConfigError {
    ConfigError::Setting(UnknownName { kind: "observable", name, known: names.to_vec() }.to_string())
}

/// The steps before each recorded node, in order: 0, those asked for, all.
fn recorded(every: u64, chosen: &[f64], start: f64, h: f64, steps: u64) -> Result<Vec<u64>, ConfigError> {
    let every = if every == 0 { steps.max(1) } else { every };
    let nodes = steps.div_ceil(every).saturating_add(chosen.len() as u64);
    if nodes > MOST_NODES {
        let wrong = format!("statistics at {nodes} nodes: take a larger `record_every`");
        return Err(ConfigError::Setting(wrong));
    }
    let mut recorded: Vec<u64> = (0..=steps.div_ceil(every)).map(|node| steps.min(node * every)).collect();
    recorded.extend(chosen_steps(chosen, start, h, steps)?);
    recorded.sort_unstable();
    recorded.dedup();
    Ok(recorded)
}

/// What is observed if nothing is asked for.
fn standard<H: Discretized<E> + Sync, E>(system: &H, degrees: usize) -> Vec<Named<'_, H::Vector>> {
    let component =
        |i: usize| move |vector: &H::Vector| vector.components().get(i).copied().unwrap_or(f64::NAN);
    let mut all: Vec<Named<'_, H::Vector>> = Vec::new();
    for i in 0..degrees {
        let q = component(i);
        all.push((format!("q{i}"), Box::new(move |state| q(&state.q))));
    }
    for i in 0..degrees {
        let p = component(i);
        all.push((format!("p{i}"), Box::new(move |state| p(&state.p))));
    }
    all.push(("energy".into(), Box::new(|state| system.energy(state))));
    all
}
