//! Many paths at once: their statistics at the price of their noise.
//!
//! Paths run in the lanes of vector registers ([`crate::lanes`]), in blocks of fixed size that threads take one after the
//! other; blocks are merged in the order of their numbers. So the result is the same, bit for bit, for any number of
//! threads, any width of the lanes and any [`InstructionSet`]. Increments are `√|h| ξ` with one [`normal`] `ξ` for
//! each (seed, process, path, step), truncated where that is asked for. They are no Wiener tree: another step size is another
//! sample.
//!
//! A path is that of [`Stepper::plain`](crate::step::Stepper::plain) with the same increments: to the last bit if `H` has
//! arithmetic and roots only; elementary functions of lanes ([`crate::lanes`]) are not those of `std`. A step that the
//! short way does not solve is the one that the stepper then takes, with the functions of `std`.
//!
//! A path whose step fails ends there, with its number and error in [`Statistics::failures`]; its neighbours do not notice.

mod block;
mod dispatch;
mod draws;
mod schedule;
mod statistics;

use std::marker::PhantomData;
use std::num::NonZero;
use std::ops::ControlFlow;

use block::{Block, Job, Observable, PATHS};
pub use dispatch::{InstructionSet, Kernel};
pub use draws::normal;
use schedule::in_order;
pub use statistics::{Moments, PathFailure, Statistics};

use crate::error::{ConfigError, Error};
use crate::noise::{Truncation, clip_bound};
use crate::simulate::{End, checked, count};
use crate::state::{State, Vector};
use crate::system::Discretized;

/// Trajectories per group: two registers of AVX-512, four of AVX2.
const WIDTH: usize = 16;
/// More recorded nodes than anyone looks at.
const MOST_NODES: u64 = 1 << 24;

/// An ensemble to run: [`Integrate::ensemble`](crate::integrate::Integrate::ensemble) begins it, [`Ensemble::run`] runs
/// it.
///
/// A start, an end and a number of paths are needed, and a seed if the system has noise. A later setting replaces an
/// earlier one.
#[must_use = "nothing happens before `run`"]
pub struct Ensemble<'a, H: Discretized<E>, E> {
    system: &'a H,
    h: f64,
    start: Option<State<H::Vector>>,
    paths: Option<u64>,
    seed: Option<u64>,
    end: Option<End>,
    every: u64,
    observables: Vec<(Option<String>, Observable<'a, H::Vector>)>,
    threads: Option<usize>,
    truncation: Truncation,
    instructions: InstructionSet,
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
            seed: None,
            end: None,
            every: 0,
            observables: Vec::new(),
            threads: None,
            truncation: Truncation::Unset,
            instructions: InstructionSet::best(),
            scheme: PhantomData,
        }
    }

    /// The first state of every path.
    pub fn start(mut self, start: State<H::Vector>) -> Self {
        self.start = Some(start);
        self
    }

    /// How many paths.
    pub fn paths(mut self, paths: u64) -> Self {
        self.paths = Some(paths);
        self
    }

    /// What the random numbers are made of.
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = Some(seed);
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

    /// One more observable, a function of the state; a value that is not finite shows in the moments of its time. Without
    /// any, all coordinates `q0, ...`, momenta `p0, ...` and the
    /// drift Hamiltonian `energy` are.
    pub fn observe(mut self, observable: impl Fn(&State<H::Vector>) -> f64 + Send + Sync + 'a) -> Self {
        self.observables.push((None, Box::new(observable)));
        self
    }

    /// Names the observable that was added last; without a name it is `observable0` and so on, by its index.
    pub fn named(mut self, name: impl Into<String>) -> Self {
        if let Some((named, _)) = self.observables.last_mut() {
            *named = Some(name.into());
        }
        self
    }

    /// On so many threads; all cores if this is not called.
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = Some(threads);
        self
    }

    /// Whether increments are truncated; if this is not called, with `k = 4` where
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
    /// [`Error::Config`] if a setting is missing or makes no sense, [`Error::Step`] if no path reaches the end: the first
    /// failure. Fewer failures are in the [`Statistics`].
    pub fn run(self) -> Result<Statistics, Error> {
        self.run_in::<WIDTH>()
    }

    /// [`Ensemble::run`] with `L` paths beside each other; the result is the same.
    #[doc(hidden)]
    pub fn run_in<const L: usize>(self) -> Result<Statistics, Error> {
        let (threads, instructions) = (self.threads, self.instructions);
        let job = self.job()?;
        let blocks = job.paths.div_ceil(PATHS);
        let threads = match threads {
            Some(0) => return Err(ConfigError::Setting("0 threads: take at least 1".into()).into()),
            Some(threads) => threads,
            None => std::thread::available_parallelism().map_or(1, NonZero::get),
        };
        let mut statistics = Statistics::new(&job.names, &job.times);
        in_order(
            0..blocks,
            threads,
            |number| instructions.run(Block::<H, E, L> { job: &job, number }),
            |_, block| {
                statistics.merge(&block);
                ControlFlow::Continue(())
            },
        );
        match (statistics.last().map_or(0, Moments::count), statistics.failures.first()) {
            (0, Some(failure)) => Err(failure.error.into()),
            _ => Ok(statistics),
        }
    }

    fn job(self) -> Result<Job<'a, H, E>, Error> {
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
        let seed = match self.seed {
            Some(seed) => seed,
            None if system.noises() == 0 => 0,
            None => return Err(ConfigError::Missing("a seed for its noise: add `.seed(number)`").into()),
        };
        let clip = match self.truncation {
            Truncation::Off => f64::INFINITY,
            Truncation::On(k) if k.is_finite() && k >= 1.0 => clip_bound(h, k),
            Truncation::On(k) => {
                return Err(ConfigError::Setting(format!("truncation with k = {k}: take at least 1")).into());
            }
            Truncation::Unset if H::PLAN.truncates_increments() => clip_bound(h, Truncation::DEFAULT),
            Truncation::Unset => f64::INFINITY,
        };
        let every = if self.every == 0 { steps.max(1) } else { self.every };
        let nodes = steps.div_ceil(every);
        if nodes > MOST_NODES {
            return Err(ConfigError::Setting(format!(
                "statistics at {nodes} nodes: take a larger `record_every`"
            ))
            .into());
        }
        let end = start.t + steps as f64 * h;
        if !end.is_finite() {
            return Err(ConfigError::End { start: start.t, end, h }.into());
        }
        let times = (0..=nodes).map(|node| start.t + steps.min(node * every) as f64 * h).collect();
        let observables = if self.observables.is_empty() {
            standard(system, start.q.components().len())
        } else {
            self.observables
        };
        let (names, observables) = observables
            .into_iter()
            .enumerate()
            .map(|(i, (name, observable))| (name.unwrap_or_else(|| format!("observable{i}")), observable))
            .unzip();
        let prepared = system.prepare(h)?;
        Ok(Job { system, prepared, h, start, paths, steps, every, times, seed, clip, observables, names })
    }
}

type Named<'a, V> = (Option<String>, Observable<'a, V>);

/// What is observed if nothing is asked for.
fn standard<H: Discretized<E> + Sync, E>(system: &H, degrees: usize) -> Vec<Named<'_, H::Vector>> {
    let component =
        |i: usize| move |vector: &H::Vector| vector.components().get(i).copied().unwrap_or(f64::NAN);
    let mut all: Vec<Named<'_, H::Vector>> = Vec::new();
    for i in 0..degrees {
        let q = component(i);
        all.push((Some(format!("q{i}")), Box::new(move |state| q(&state.q))));
    }
    for i in 0..degrees {
        let p = component(i);
        all.push((Some(format!("p{i}")), Box::new(move |state| p(&state.p))));
    }
    all.push((Some("energy".into()), Box::new(|state| system.energy(state))));
    all
}
