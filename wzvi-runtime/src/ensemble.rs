//! Statistics of many paths, in vector lanes and on all cores.
//!
//! Paths run in the lanes of vector registers ([`crate::algebra::lanes`]), in chunks of fixed size. Threads
//! take the chunks, and their statistics are merged in the order of the chunks. The result is the same, bit
//! for bit, for any number of threads, any width of the lanes and any [`InstructionSet`].
//!
//! The increments of a seed are those of [`StepNormals`]: `√|h| ξ` with one normal `ξ` for each (seed, step
//! size, process, path, step), truncated where the plan or the caller asks for it. The number of a step is
//! that of its time, `⌊t/h⌋`. They do not form a Wiener tree: another step size is another sample, except
//! between the levels of [`Multilevel`]. [`Ensemble::noise`] takes any other noise.
//!
//! A path is that of [`Stepper::plain`](crate::trajectory::step::Stepper::plain) with the same increments,
//! bit for bit, on every machine: both have the same elementary functions ([`crate::algebra::lanes`]). Hard
//! steps are taken by the stepper.
//!
//! A step that fails is halved if [`Ensemble::retry`] allows it. Otherwise its path ends there, with its
//! number and error in [`Statistics::failures`], and the other paths continue. [`Ensemble::replay`] runs a
//! single path again.

mod account;
mod by_runs;
mod chaos;
mod checks;
mod chunk;
#[cfg(feature = "mpi")]
pub mod cluster;
mod control;
mod crossings;
mod draws;
mod group;
mod increments;
mod job;
mod made_settings;
mod multilevel;
mod observation;
mod provenance;
mod replay;
mod run_identity;
pub(crate) mod schedule;
mod source;
mod starts;
mod stop_poll;

use std::marker::PhantomData;
use std::sync::Arc;

pub use crate::algebra::lanes::instructions::{InstructionSet, Kernel};
pub use crate::saving::FileError;
pub use crate::statistics::StatisticsError;
pub use crate::statistics::{
    Crossings, Histogram, LossError, Passage, Passages, PathCrossing, PathFailure, PathValues, Quantiles,
    Seen, Statistic, Statistics, StatisticsNode, Tables, TargetStatus,
};
use account::ChunkLedger;
pub use chaos::{ChaosMap, MapDeviations};
use chunk::in_chunks;
use control::Control;
pub use draws::Normals;
use job::Inspector;
pub use multilevel::{Level, LevelError, LevelFailure, Multilevel, MultilevelEstimate, Nothing, Observed};
use source::{NoiseSource, NormalSettings};
use starts::ByPath;
pub use starts::{Draw, OneSystem, RunByPath, SystemByPath, Systems};

use crate::algebra::state::State;
use crate::error::wrong;
use crate::increments::Noise;
use crate::noise::{Paths as PathsOfNoise, StepNormals, Truncation};
pub use crate::saving::table::{Column, Table};
use crate::scheme::system::{Discretized, Hamiltonian};
use crate::statistics::AnyStatistic;
use crate::trajectory::Error;
use crate::trajectory::events::{AfterEvent, EventPlace};
use crate::trajectory::exclusive_setting::{ExclusiveSetting, SOME};
use crate::trajectory::options::{self, Observables, OwnObservable, elsewhere, options};
use crate::trajectory::retry::Retry;
use crate::trajectory::section::Direction;

/// An ensemble to run: [`Integrate::ensemble`](crate::integrate::Integrate::ensemble) begins it,
/// [`Ensemble::run`] runs it.
///
/// An ensemble needs a start, an end and a number of paths, and a seed or a noise if the system has noise. A
/// later call of a method replaces an earlier one, and two methods that set the same (`seed` and `noise`) are
/// an error. `N` is the type of the noise, and `P` says whether each path has a
/// system of its own.
#[must_use = "nothing happens before `run`"]
pub struct Ensemble<'a, H: Hamiltonian, E, N = StepNormals, P = OneSystem> {
    setup: EnsembleSetup<'a, H>,
    types: EnsembleTypes<E, N, P>,
}

/// The settings so far.
type EnsembleSetup<'a, H> = options::RunSetup<'a, H, EnsembleSettings<'a, H>>;

/// Settings of ensembles only.
struct EnsembleSettings<'a, H: Hamiltonian> {
    /// A start for each path.
    starts: ExclusiveSetting<ByPath<'a, State<H::Vector>>>,
    systems: ExclusiveSetting<ByPath<'a, H>>,
    paths: Option<u64>,
    source: ExclusiveSetting<NoiseSource<'a>>,
    settings: NormalSettings,
    /// Observables that read the system of the path, by number.
    own: Vec<(usize, OwnObservable<'a, H, H::Vector>)>,
    events: Observables<'a, H::Vector>,
    wanted: ExtraStatistics,
    inspector: Option<Inspector<'a, H::Vector>>,
    control: Control,
}

impl<H: Hamiltonian> Default for EnsembleSettings<'_, H> {
    fn default() -> Self {
        Self {
            starts: ExclusiveSetting::default(),
            systems: ExclusiveSetting::default(),
            paths: None,
            source: ExclusiveSetting::default(),
            settings: NormalSettings::default(),
            own: Vec::new(),
            events: Observables::default(),
            wanted: ExtraStatistics::default(),
            inspector: None,
            control: Control::default(),
        }
    }
}

/// Scheme, noise, and whether each path has its own system.
type EnsembleTypes<E, N, P> = PhantomData<fn() -> (E, N, P)>;

/// The statistics that a run computes besides moments.
#[derive(Default)]
struct ExtraStatistics {
    quantiles: bool,
    /// All by default.
    covariances: Option<bool>,
    /// Observable, lower and upper end, bins.
    histograms: Vec<(String, [f64; 2], usize)>,
    /// Bytes of memory for the paths, if they are kept.
    most_bytes: Option<u64>,
    /// Crossings that are kept, of each path and section.
    most_crossings: u64,
    /// Whether work and heat are observed.
    has_work: bool,
    /// Whether `exp(-work/kT)` is.
    has_weight: bool,
    /// Statistics of the user's own.
    added: Vec<Box<dyn AnyStatistic>>,
}

impl<'a, H: Discretized<E>, E> Ensemble<'a, H, E> {
    /// Paths of `system` in steps of size `h`.
    pub fn new(system: &'a H, h: f64) -> Self {
        Self { setup: EnsembleSetup::new(system, h), types: PhantomData }
    }
}

impl<'a, H: Hamiltonian, E, P> Ensemble<'a, H, E, StepNormals, P> {
    /// Sets whether the increments of a seed are truncated. The default is `k = 4` where
    /// [`Plan::truncates_increments`](crate::scheme::plan::Plan::truncates_increments) holds, and no
    /// truncation elsewhere. Other noises have a truncation of their own, as in
    /// `Wiener::seed(7).truncated(4)`.
    pub fn truncation(mut self, truncation: Truncation) -> Self {
        self.setup.more.settings.truncation = truncation;
        self
    }

    /// Runs paths `2k` and `2k + 1` as pairs with negated normals. An observable that is odd in the noise
    /// then has the exact mean; one that is even gains nothing. Standard errors are those of independent
    /// pairs ([`StatisticsNode::standard_error`]).
    pub fn antithetic(mut self) -> Self {
        self.setup.more.settings.is_antithetic = true;
        self
    }
}

impl<'a, H: Hamiltonian, E, N, P> Ensemble<'a, H, E, N, P> {
    options!(start, end, whole, record, observe, temperatures, section, watch, execution, instructions);

    /// Observes a function of the system of each path, too.
    fn observe_own(
        mut self,
        name: impl Into<String>,
        observable: impl Fn(&H, &State<H::Vector>) -> f64 + Send + Sync + 'a,
    ) -> Self
    where
        H: Sync,
    {
        self.setup.more.own.push((self.setup.observables.len(), Arc::new(observable)));
        self.observe(name, elsewhere)
    }

    /// Sets the first state of each path; all have the same time. It may depend on [`Draw::path`], or be
    /// drawn at random by the seed of the ensemble (0 if it has none). The function is called from several
    /// threads, for some paths more than once, and must depend on its argument alone.
    ///
    /// ```ignore
    /// // A Gaussian cloud of path after path, whatever the scheme and the step size.
    /// let starts = |draw: &mut Draw| State::new([0.1 * draw.normal()], [1.0]);
    /// pendulum.ensemble::<Midpoint>(0.1).starts(starts).paths(10_000).seed(7).until(50.0).run()?
    /// ```
    pub fn starts(mut self, start: impl Fn(&mut Draw) -> State<H::Vector> + Send + Sync + 'a) -> Self {
        self.setup.more.starts.set("starts", SOME, ByPath::Drawn(Box::new(start)));
        self
    }

    /// Sets the first state of each path, in the order of their numbers; all have the same time. There are as
    /// many paths as states, unless [`Ensemble::paths`] says fewer. A list of systems must have the same
    /// length.
    pub fn starts_from(mut self, states: impl IntoIterator<Item = State<H::Vector>>) -> Self {
        let states = ByPath::Listed(states.into_iter().collect());
        self.setup.more.starts.set("starts_from", SOME, states);
        self
    }

    /// Sets the system of each path, in place of the one that began the ensemble. Its parameters may depend
    /// on [`Draw::path`], or be drawn at random by the seed of the ensemble, independently of the starts. All
    /// systems have the same number of degrees of freedom and of noises.
    ///
    /// ```ignore
    /// // 21 × 21 parameters.
    /// let system = |draw: &mut Draw| Duffing { a: 0.1 * (draw.path() % 21) as f64, b: 0.1 * (draw.path() / 21) as f64 };
    /// duffing.ensemble::<Midpoint>(0.1).systems(system).start(start).paths(441).keep_paths(1 << 20).until(50.0).run()?
    /// ```
    ///
    /// The energy and the declared observables that are observed by default are then those of the path's own
    /// system. Each path has noise of its own.
    /// For the same noise at each parameter, run an ensemble for each with the same seed and step size.
    pub fn systems(
        mut self,
        system: impl Fn(&mut Draw) -> H + Send + Sync + 'a,
    ) -> Ensemble<'a, H, E, N, P::Own>
    where
        P: Systems,
    {
        self.setup.more.systems.set("systems", SOME, ByPath::Drawn(Box::new(system)));
        self.marked()
    }

    /// Sets the system of each path, in the order of their numbers, as [`Ensemble::systems`] does. There are
    /// as many paths as systems, unless [`Ensemble::paths`] says fewer. A list of starts must have the same
    /// length.
    pub fn systems_from(mut self, systems: impl IntoIterator<Item = H>) -> Ensemble<'a, H, E, N, P::Own>
    where
        P: Systems,
    {
        self.setup.more.systems.set("systems_from", SOME, ByPath::Listed(systems.into_iter().collect()));
        self.marked()
    }

    /// Sets the number of paths; with [`Ensemble::until_error`], the largest number.
    pub fn paths(mut self, paths: u64) -> Self {
        self.setup.more.paths = Some(paths);
        self
    }

    /// Drives the paths by `StepNormals::seed(seed)`, the fast noise.
    ///
    /// Noise belongs to the time at which it acts. An ensemble that continues another, from the states where
    /// that one ended and at their time, goes on with the same seed; one that starts at `t = 0` again needs
    /// another seed, since the same one repeats the noise of each path.
    pub fn seed(mut self, seed: u64) -> Ensemble<'a, H, E, StepNormals, P> {
        self.setup.more.source.set("seed", seed, NoiseSource::new(StepNormals::seed(seed)));
        self.marked()
    }

    /// In place of [`Ensemble::seed`], drives path `n` of the ensemble by path `n` of this noise; given
    /// [`Increments`](crate::increments::Increments) drive every path. A system without noise accepts any
    /// noise and does not use it.
    ///
    /// [`StepNormals`] are drawn in lanes. Any other noise gives the increments of one path after the other,
    /// and costs as much as in a single run.
    pub fn noise<M: PathsOfNoise + Clone + Send + Sync + 'a>(mut self, noise: M) -> Ensemble<'a, H, E, M, P> {
        self.setup.more.source.set("noise", SOME, NoiseSource::new(noise));
        self.marked()
    }

    /// Halves steps that fail ([`crate::trajectory::retry`]): `Retry::halving(8)` allows 256 parts. The
    /// default is not to. The noise must have increments between the nodes ([`Noise::is_divisible`]); the run
    /// refuses another one.
    ///
    /// A path ends where the halves of a step do not agree
    /// ([`StepFailure::Unresolved`](crate::error::StepFailure::Unresolved)), and where its energy has changed
    /// permanently. A single run starts again in shorter steps; a path of an ensemble does not, because its
    /// nodes have been counted.
    pub fn retry(mut self, retry: Retry) -> Self {
        self.setup.retry = retry;
        self
    }

    /// Sets the fraction of paths that may fail, 0.01 by default. If more fail, the run returns a
    /// [`LossError`] with the statistics of the others. If all fail, it returns the error of the first path.
    pub fn allow_losses(mut self, fraction: f64) -> Self {
        self.setup.more.control.losses = Some(fraction);
        self
    }

    /// Calls `see(path, state)` for every path at each recorded node that it reaches, start and end included.
    /// The nodes of a path come in order; different paths come from several threads at once. A run that is
    /// stopped early may have shown paths that its statistics do not contain.
    pub fn inspect(mut self, see: impl Fn(u64, &State<H::Vector>) + Send + Sync + 'a) -> Self {
        self.setup.more.inspector = Some(Box::new(see));
        self
    }

    /// Records when `event`, a function of the state, first crosses zero, by the rule of
    /// [`Ensemble::section`], which finds all crossings. With noise it is evaluated at the nodes alone, which
    /// limits the accuracy of the times ([`Passages`]). May be called more than once.
    pub fn first_passage(
        mut self,
        name: impl Into<String>,
        event: impl Fn(&State<H::Vector>) -> f64 + Send + Sync + 'a,
    ) -> Self {
        self.setup.more.events.push(name.into(), event);
        self
    }

    /// Sets whether covariances of all pairs of observables are computed, which is the default. Their cost in
    /// time and memory is half the square of the number of observables, at each recorded time. Variances are
    /// always computed.
    pub fn covariances(mut self, are_computed: bool) -> Self {
        self.setup.more.wanted.covariances = Some(are_computed);
        self
    }

    /// Observes `work`, `shadow work` and `heat` of each path since its start, in units of energy, as
    /// [`Trajectory::work`](crate::trajectory::recorded::Trajectory::work), its shadow part, and
    /// [`Trajectory::heat`](crate::trajectory::recorded::Trajectory::heat) do for a single path. It is for
    /// systems with a bath, forces or friction. Where the temperatures of the degrees of freedom differ, it
    /// also observes the heat of each, `heat 0`, `heat 1`, ... Each path is then stepped by itself, which
    /// takes the time of single paths. It excludes `retry` and times between nodes.
    pub fn observe_work(mut self) -> Self {
        self.setup.more.wanted.has_work = true;
        self
    }

    /// Observes what [`observe_work`](Ensemble::observe_work) does, and `exp(-work/kT)`. By Jarzynski's
    /// equality its mean is `e^{-ΔF/kT}`, with `ΔF` the change of the free energy, for paths that start in
    /// equilibrium. It holds at every step size (C. Jarzynski, Phys. Rev. Lett. 78, 1997).
    ///
    /// The run is [`ConfigError::NoEquilibrium`](crate::error::ConfigError::NoEquilibrium) unless the system
    /// has a bath at one constant temperature.
    pub fn observe_jarzynski(mut self) -> Self {
        self.setup.more.wanted.has_weight = true;
        self.observe_work()
    }

    /// Computes quantiles of every observable at every recorded time, to a relative error of
    /// [`Quantiles::RELATIVE_ERROR`].
    pub fn quantiles(mut self) -> Self {
        self.setup.more.wanted.quantiles = true;
        self
    }

    /// Adds a statistic of the caller: see [`Statistic`]. [`Statistics::statistic`] returns it.
    pub fn statistic(mut self, empty: impl Statistic) -> Self {
        self.setup.more.wanted.added.push(Box::new(empty));
        self
    }

    /// Computes a histogram of the observable with this name at every recorded time, with `bins` bins from
    /// `lower` to `upper`.
    pub fn histogram(mut self, observable: impl Into<String>, lower: f64, upper: f64, bins: usize) -> Self {
        self.setup.more.wanted.histograms.push((observable.into(), [lower, upper], bins));
        self
    }

    /// Keeps all observables of every path at every recorded time ([`Statistics::paths`]), and the time of
    /// each event ([`Passages::by_path`]), if that takes at most `bytes` of memory.
    pub fn keep_paths(mut self, bytes: u64) -> Self {
        self.setup.more.wanted.most_bytes = Some(bytes);
        self
    }

    /// Keeps the first `most` crossings of each path and section with their states. By default they are only
    /// counted ([`Crossings`]). It needs a [`section`](Ensemble::section).
    pub fn keep_crossings(mut self, most: u64) -> Self {
        self.setup.more.wanted.most_crossings = most;
        self
    }

    /// Ends the run when the standard error of the mean of an observable at the end of the paths is at most
    /// `target` (units of the observable). [`Ensemble::paths`] is then a limit, and
    /// [`Statistics::met_targets`] says whether it was enough. If this is called more than once, all targets
    /// must be met.
    ///
    /// The test is made after each 512 paths, in the order of their numbers, from 1024 on, so that the result
    /// is the same for any number of threads. An estimated error is sometimes too small by chance, which
    /// would end the run too early. The test therefore uses an upper estimate
    /// ([`StatisticsNode::error_bound`]). An observable that was the same number on all paths continues to
    /// the limit ([`TargetStatus::Constant`]).
    ///
    /// The mean is then within 1.96 targets of the true one in at least 95 % of the runs.
    /// `docs/guide/ensembles.md` shows this for events of probability 0.001 and for the heavy tail of
    /// `exp(2 W)`.
    pub fn until_error(mut self, observable: impl Into<String>, target: f64) -> Self {
        self.setup.more.control.targets.push((observable.into(), target));
        self
    }

    /// This run with other type parameters.
    fn marked<M, Q>(self) -> Ensemble<'a, H, E, M, Q> {
        Ensemble { setup: self.setup, types: PhantomData }
    }
}

impl<'a, H: Hamiltonian, E, N, P> Ensemble<'a, H, E, N, P> {
    /// Acts on each path where `value`, a function of the state, is zero, in both directions, as
    /// [`Simulation::on`](crate::trajectory::simulate::Simulation::on) does. Each path is then a run of its
    /// own, with the bits of a `Simulation` with plain sums. A path that an action ends stays where it is:
    /// later times have its last state.
    pub fn on<R: Into<AfterEvent>>(
        self,
        value: impl Fn(&State<H::Vector>) -> f64 + Send + Sync + 'a,
        action: impl Fn(&mut State<H::Vector>) -> R + Send + Sync + 'a,
    ) -> Ensemble<'a, H, E, N, RunByPath> {
        self.with_event(EventPlace::Crossing(None, Arc::new(value)), action)
    }

    /// As [`Ensemble::on`], for crossings in one direction.
    pub fn on_towards<R: Into<AfterEvent>>(
        self,
        direction: Direction,
        value: impl Fn(&State<H::Vector>) -> f64 + Send + Sync + 'a,
        action: impl Fn(&mut State<H::Vector>) -> R + Send + Sync + 'a,
    ) -> Ensemble<'a, H, E, N, RunByPath> {
        self.with_event(EventPlace::Crossing(Some(direction), Arc::new(value)), action)
    }

    /// As [`Ensemble::on`], at the time `t` (time units of the Hamiltonian).
    pub fn on_time<R: Into<AfterEvent>>(
        self,
        t: f64,
        action: impl Fn(&mut State<H::Vector>) -> R + Send + Sync + 'a,
    ) -> Ensemble<'a, H, E, N, RunByPath> {
        self.with_event(EventPlace::Time(t), action)
    }

    fn with_event<R: Into<AfterEvent>>(
        mut self,
        place: EventPlace<'a, H::Vector>,
        action: impl Fn(&mut State<H::Vector>) -> R + Send + Sync + 'a,
    ) -> Ensemble<'a, H, E, N, RunByPath> {
        self.setup.events.push(place, action);
        self.marked()
    }
}

impl<H, E, N, P> Ensemble<'_, H, E, N, P>
where
    H: Discretized<E> + Sync,
    N: Noise,
    P: Systems,
{
    /// Runs all paths.
    ///
    /// # Errors
    /// * [`Error::Config`] if a setting is missing or invalid.
    /// * [`Error::Noise`] if the given noise has no increments.
    /// * [`Error::Step`] if all paths fail: the first failure.
    /// * [`Error::Losses`] if more paths fail than are allowed; fewer failures are in the [`Statistics`].
    /// * [`Error::Checkpoint`] if a checkpoint cannot be written, or the run cannot resume from it.
    pub fn run(self) -> Result<Statistics, Error> {
        self.run_in::<0>()
    }

    /// [`Ensemble::run`] with `WIDTH` paths in lanes; 0 means as many as suit the instructions. The result is
    /// the same.
    #[doc(hidden)]
    pub fn run_in<const WIDTH: usize>(mut self) -> Result<Statistics, Error> {
        let execution = std::mem::take(&mut self.setup.execution);
        let (control, keeping) =
            (std::mem::take(&mut self.setup.more.control), std::mem::take(&mut self.setup.keeping));
        let (threads, instructions) = (execution.threads()?, execution.instructions());
        let stop = || execution.is_stopped();
        let job = self.job(&stop)?;
        if job.source.is_antithetic() && WIDTH % 2 == 1 {
            return wrong(format!("antithetic pairs in {WIDTH} lanes: take 2 or more"));
        }
        let mut account = ChunkLedger::open(&job, &control, keeping, execution.progress("paths"))?;
        let (chunks, hands) = (account.chunks(), (threads, instructions));
        in_chunks::<H, E, P, WIDTH>(&job, None, chunks, hands, |chunk| account.add_chunk(chunk));
        account.close()
    }
}
