//! Many paths at once: their statistics at the price of their noise.
//!
//! Paths run in the lanes of vector registers ([`crate::algebra::lanes`]), in blocks of fixed size that threads take one after the
//! other; blocks are merged in the order of their numbers. So the result is the same, bit for bit, for any number of
//! threads, any width of the lanes and any [`InstructionSet`]. Increments are those of [`StepNormals`]: `√|h| ξ` with one normal `ξ` for
//! each (seed, step size, process, path, step), truncated where that is asked for, unless another noise is given
//! ([`Ensemble::noise`]). They are no Wiener tree: another step size is another sample, except beside each other on the levels of
//! [`Multilevel`].
//!
//! A path is that of [`Stepper::plain`](crate::path::step::Stepper::plain) with the same increments: to the last bit if `H` has
//! arithmetic and roots only; elementary functions of lanes ([`crate::algebra::lanes`]) are not those of `std`. A step that the
//! short way does not solve is the one that the stepper then takes, with the functions of `std`.
//!
//! A path whose step fails is halved there if that is allowed ([`Ensemble::retry`]), and ends there if not, with its number and error in
//! [`Statistics::failures`]; its neighbours do not notice. [`Ensemble::replay`] runs a single one of them again.

mod account;
mod block;
mod checks;
#[cfg(feature = "mpi")]
pub mod cluster;
mod control;
mod draws;
pub(crate) mod execution;
mod group;
mod halt;
mod increments;
mod job;
#[cfg(feature = "serde")]
mod keeping;
#[cfg(not(feature = "serde"))]
#[path = "ensemble/keeping/absent.rs"]
mod keeping;
mod multilevel;
mod observation;
mod origin;
mod pace;
mod piece;
mod replay;
pub(crate) mod schedule;
mod source;
mod starts;

use std::marker::PhantomData;
use std::sync::Arc;

pub use crate::algebra::lanes::instructions::{InstructionSet, Kernel};
pub use crate::error::{FileError, StatisticsError};
pub use crate::statistics::{
    Crossings, Histogram, LossError, Passage, Passages, PathCrossing, PathFailure, Paths, Quantiles,
    Statistics, StatisticsNode, TargetStatus,
};
use account::Account;
use block::Block;
use control::Control;
pub use draws::Normals;
use job::Inspector;
pub use multilevel::{Level, LevelError, LevelFailure, Multilevel, MultilevelEstimate, Nothing, Observed};
use source::{Settings, Source};
use starts::ByPath;
pub use starts::{Draw, OneSystem, SystemByPath, Systems};

use crate::algebra::state::State;
use crate::ensemble::execution::Execution;
use crate::ensemble::schedule::in_order;
use crate::error::ConfigError;
use crate::ground::interrupt::Interrupt;
use crate::increments::Noise;
use crate::noise::{Paths as PathsOfNoise, StepNormals, Truncation};
use crate::path::Error;
use crate::path::checkpoint::Keeping;
use crate::path::options::{Observables, OwnObservable, elsewhere, options};
use crate::path::recording::Request;
use crate::path::retry::{Halved, Retry, Serves, Whole};
use crate::path::section::Sections;
use crate::path::span::Span;
pub use crate::saving::table::{Column, Table};
use crate::scheme::system::{Discretized, Hamiltonian};

/// An ensemble to run: [`Integrate::ensemble`](crate::integrate::Integrate::ensemble) begins it, [`Ensemble::run`] runs
/// it.
///
/// A start, an end and a number of paths are needed, and a seed or a noise if the system has any. A later setting replaces an
/// earlier one. `N` is the type of the noise, `R` whether steps may be halved, and `P` whether each path has a system of its own: what makes no
/// sense together does not compile.
#[must_use = "nothing happens before `run`"]
pub struct Ensemble<'a, H: Hamiltonian, E, N = StepNormals, R = Whole, P = OneSystem> {
    setup: Setup<'a, H>,
    types: Types<E, N, R, P>,
}

/// What was said so far.
struct Setup<'a, H: Hamiltonian> {
    system: &'a H,
    h: f64,
    span: Span<H::Vector>,
    /// Of each path its own, unless `span` has one that was said later.
    starts: Option<ByPath<'a, State<H::Vector>>>,
    systems: Option<ByPath<'a, H>>,
    paths: Option<u64>,
    source: Option<Source<'a>>,
    settings: Settings,
    recorded: Request,
    observables: Observables<'a, H::Vector>,
    /// Those that read the system of the path, by number.
    own: Vec<(usize, OwnObservable<'a, H, H::Vector>)>,
    events: Observables<'a, H::Vector>,
    sections: Sections<'a, H::Vector>,
    wanted: Extras,
    inspector: Option<Inspector<'a, H::Vector>>,
    execution: Execution<'a>,
    keeping: Keeping,
    retry: Retry,
    is_watched: bool,
    control: Control,
}

/// Scheme, noise, whether steps may be halved, and whether each path has its own system.
type Types<E, N, R, P> = PhantomData<fn() -> (E, N, R, P)>;

/// What is computed besides moments.
struct Extras {
    quantiles: bool,
    /// All, if nothing was said.
    covariances: Option<bool>,
    /// Observable, lower and upper end, bins.
    histograms: Vec<(String, [f64; 2], usize)>,
    /// Bytes of memory for the paths, if they are kept.
    most_bytes: Option<u64>,
    /// Crossings that are kept, of each path and section.
    most_crossings: u64,
    /// Whether work and heat are observed.
    has_work: bool,
}

impl<'a, H: Discretized<E>, E> Ensemble<'a, H, E> {
    /// Paths of `system` in steps of size `h`.
    pub fn new(system: &'a H, h: f64) -> Self {
        let setup = Setup {
            system,
            h,
            span: Span::default(),
            starts: None,
            systems: None,
            paths: None,
            source: None,
            settings: Settings::default(),
            recorded: Request::default(),
            observables: Observables::default(),
            own: Vec::new(),
            events: Observables::default(),
            sections: Sections::default(),
            wanted: Extras {
                quantiles: false,
                covariances: None,
                histograms: Vec::new(),
                most_bytes: None,
                most_crossings: 0,
                has_work: false,
            },
            inspector: None,
            execution: Execution::default(),
            keeping: Keeping::default(),
            retry: Retry::never(),
            is_watched: true,
            control: Control::default(),
        };
        Self { setup, types: PhantomData }
    }
}

impl<'a, H: Hamiltonian, E, R, P> Ensemble<'a, H, E, StepNormals, R, P> {
    /// Whether the increments of a seed are truncated; if this is not called, with `k = 4` where
    /// [`Plan::truncates_increments`](crate::scheme::plan::Plan::truncates_increments). Another noise truncates by itself, as in
    /// `Wiener::seed(7).truncated(4)`.
    pub fn truncation(mut self, truncation: Truncation) -> Self {
        self.setup.settings.truncation = truncation;
        self
    }

    /// Paths in pairs with negated normals: `2k` and `2k + 1`. An observable that is odd in the noise has the exact mean
    /// then, for one that is even nothing is won. Standard errors are those of independent pairs
    /// ([`StatisticsNode::standard_error`]).
    pub fn antithetic(mut self) -> Self {
        self.setup.settings.is_antithetic = true;
        self
    }
}

impl<'a, H: Hamiltonian, E, N, R, P> Ensemble<'a, H, E, N, R, P> {
    options!(start, end, exact, record, observe, temperatures, section, watch, execution, instructions);

    /// Observes a function of the system of each path, too.
    fn observe_own(
        mut self,
        name: impl Into<String>,
        observable: impl Fn(&H, &State<H::Vector>) -> f64 + Send + Sync + 'a,
    ) -> Self
    where
        H: Sync,
    {
        self.setup.own.push((self.setup.observables.len(), Arc::new(observable)));
        self.observe(name, elsewhere)
    }

    /// The first state of each path, at one time for all: that of [`Draw::path`], or drawn at random by the seed of the ensemble (0 if it has
    /// none). It is called once for each path, from several threads, and has to depend on nothing but its argument.
    ///
    /// ```ignore
    /// // A Gaussian cloud of path after path, whatever the scheme and the step size.
    /// let starts = |draw: &mut Draw| State::new([0.1 * draw.normal()], [1.0]);
    /// pendulum.ensemble::<Midpoint>(0.1).starts(starts).paths(10_000).seed(7).until(50.0).run()?
    /// ```
    pub fn starts(mut self, start: impl Fn(&mut Draw) -> State<H::Vector> + Send + Sync + 'a) -> Self {
        (self.setup.span.start, self.setup.starts) = (None, Some(ByPath::Drawn(Box::new(start))));
        self
    }

    /// The first state of each path, in the order of their numbers, at one time for all. There are as many paths as states, unless
    /// [`Ensemble::paths`] says fewer; systems that are listed, too, have to be as many.
    pub fn starts_from(mut self, states: impl IntoIterator<Item = State<H::Vector>>) -> Self {
        let states = ByPath::Listed(states.into_iter().collect());
        (self.setup.span.start, self.setup.starts) = (None, Some(states));
        self
    }

    /// The system of each path, in the place of the one that began the ensemble: of the parameters that belong to [`Draw::path`], or drawn at
    /// random by the seed of the ensemble, independently of the starts. They have the same number of degrees of freedom and of noises.
    ///
    /// ```ignore
    /// // 21 × 21 parameters.
    /// let system = |draw: &mut Draw| Duffing { a: 0.1 * (draw.path() % 21) as f64, b: 0.1 * (draw.path() / 21) as f64 };
    /// duffing.ensemble::<Midpoint>(0.1).systems(system).start(start).paths(441).keep_paths(1 << 20).until(50.0).run()?
    /// ```
    ///
    /// What is observed by default is then the energy of the path's own system.
    pub fn systems(
        mut self,
        system: impl Fn(&mut Draw) -> H + Send + Sync + 'a,
    ) -> Ensemble<'a, H, E, N, R, SystemByPath> {
        self.setup.systems = Some(ByPath::Drawn(Box::new(system)));
        self.marked()
    }

    /// The system of each path, in the order of their numbers, as with [`Ensemble::systems`]. There are as many paths as systems, unless
    /// [`Ensemble::paths`] says fewer; starts that are listed, too, have to be as many.
    pub fn systems_from(
        mut self,
        systems: impl IntoIterator<Item = H>,
    ) -> Ensemble<'a, H, E, N, R, SystemByPath> {
        self.setup.systems = Some(ByPath::Listed(systems.into_iter().collect()));
        self.marked()
    }

    /// How many paths; with [`Ensemble::until_error`], how many at most.
    pub fn paths(mut self, paths: u64) -> Self {
        self.setup.paths = Some(paths);
        self
    }

    /// The noise `StepNormals::seed(seed)`, the fast one.
    pub fn seed(mut self, seed: u64) -> Ensemble<'a, H, E, StepNormals, R, P> {
        self.setup.source = Some(Source::new(StepNormals::seed(seed)));
        self.marked()
    }

    /// Where the increments come from: path `n` of the ensemble has path `n` of the noise, and [`Increments`](crate::increments::Increments)
    /// are those of every path. A system without noise takes any and asks it for nothing.
    ///
    /// [`StepNormals`] are drawn in lanes; any other noise is asked for each path's increments one by one, and costs what it costs in a
    /// single run.
    pub fn noise<M: PathsOfNoise + Clone + Send + Sync + 'a>(
        mut self,
        noise: M,
    ) -> Ensemble<'a, H, E, M, R, P> {
        self.setup.source = Some(Source::new(noise));
        self.setup.settings = Settings::default();
        self.marked()
    }

    /// Halves steps that fail ([`crate::path::retry`]): `Retry::halving(8)` allows 256 parts. Not done unless asked for, and not with
    /// a noise that has no increments between the nodes.
    ///
    /// Where the halves of a step do not agree ([`StepFailure::Unresolved`](crate::error::StepFailure::Unresolved)) its path ends, and so does one
    /// whose energy has changed for good: it does not start again in shorter steps, as a single run does, because it has been counted.
    pub fn retry(mut self, retry: Retry) -> Ensemble<'a, H, E, N, Halved, P> {
        self.setup.retry = retry;
        self.marked()
    }

    /// How many paths may fail, as a fraction of all; 0.01 if this is not called. More are an error ([`LossError`]), which has the
    /// statistics of the others. Where all fail, there are none, and the run returns the error of the first, whatever is allowed.
    pub fn allow_losses(mut self, fraction: f64) -> Self {
        self.setup.control.losses = Some(fraction);
        self
    }

    /// Calls `see(path, state)` for every path at each recorded node that it reaches, start and end included: a path in order, different ones from
    /// several threads at once. A run that is stopped or ends early may have shown paths that its statistics do not have.
    pub fn inspect(mut self, see: impl Fn(u64, &State<H::Vector>) + Send + Sync + 'a) -> Self {
        self.setup.inspector = Some(Box::new(see));
        self
    }

    /// When does `event`, a function of the state, cross zero for the first time? It is asked at every node; what that
    /// means for the times is in [`Passages`]. All crossings are found by [`Ensemble::section`]. More than one may be asked.
    pub fn first_passage(
        mut self,
        name: impl Into<String>,
        event: impl Fn(&State<H::Vector>) -> f64 + Send + Sync + 'a,
    ) -> Self {
        self.setup.events.push(name.into(), event);
        self
    }

    /// Whether covariances of all pairs of observables are computed, as they are if this is not called: half the square of the
    /// number of observables in time and memory, at each recorded time. Variances always are.
    pub fn covariances(mut self, are_computed: bool) -> Self {
        self.setup.wanted.covariances = Some(are_computed);
        self
    }

    /// Observes `work`, `shadow work` and `heat` of each path since its start, in units of energy: what
    /// [`Trajectory::work`](crate::path::trajectory::Trajectory::work), its shadow part, and [`Trajectory::heat`](crate::path::trajectory::Trajectory::heat) are of a single
    /// one. For systems with a bath, forces or friction; each path is then stepped by itself, which takes the time of single paths. Not together with
    /// `retry`, `exactly`, or times between nodes.
    pub fn observe_work(mut self) -> Self {
        self.setup.wanted.has_work = true;
        self
    }

    /// Quantiles of every observable at every recorded time, to a relative error of [`Quantiles::RELATIVE_ERROR`].
    pub fn quantiles(mut self) -> Self {
        self.setup.wanted.quantiles = true;
        self
    }

    /// A histogram of the observable with this name at every recorded time, in so many bins from `lower` to `upper`.
    pub fn histogram(mut self, observable: impl Into<String>, lower: f64, upper: f64, bins: usize) -> Self {
        self.setup.wanted.histograms.push((observable.into(), [lower, upper], bins));
        self
    }

    /// Keeps all observables of every path at every recorded time ([`Statistics::paths`]), and when it passed each event
    /// ([`Passages::by_path`]), if that takes `bytes` of memory at most.
    pub fn keep_paths(mut self, bytes: u64) -> Self {
        self.setup.wanted.most_bytes = Some(bytes);
        self
    }

    /// Keeps the first `most` crossings of each path and section with their states; if this is not called, they are counted only
    /// ([`Crossings`]).
    pub fn keep_crossings(mut self, most: u64) -> Self {
        self.setup.wanted.most_crossings = most;
        self
    }

    /// Ends the run when the standard error of the mean of an observable at the end of the paths is `target` (units of the
    /// observable) or less; [`Ensemble::paths`] are then a limit, and [`Statistics::met_targets`] says whether they were
    /// enough. Asked more than once, all errors must be that small.
    ///
    /// That is looked at after each 512 paths, in the order of their numbers, from 1024 on: the result is the same for any
    /// number of threads. An error that is itself estimated is now and then too small by chance, and that would end the run: compared
    /// is an upper estimate ([`StatisticsNode::error_bound`]), and an observable that has been the same number on all paths is not done before
    /// the limit ([`TargetStatus::Constant`]). The mean is then within 1.96 targets of the true one in 95 % of the runs or more, also for
    /// events of probability 0.001 and for the heavy tail of `exp(2 W)`, which `docs/guide/ensembles.md` shows.
    pub fn until_error(mut self, observable: impl Into<String>, target: f64) -> Self {
        self.setup.control.targets.push((observable.into(), target));
        self
    }

    /// The same run, of other types.
    fn marked<M, S, Q>(self) -> Ensemble<'a, H, E, M, S, Q> {
        Ensemble { setup: self.setup, types: PhantomData }
    }
}

impl<H, E, N, R, P> Ensemble<'_, H, E, N, R, P>
where
    H: Discretized<E> + Sync,
    N: Noise,
    P: Systems,
{
    /// Runs all paths.
    ///
    /// # Errors
    /// [`Error::Config`] if a setting is missing or makes no sense, [`Error::Noise`] if a noise that was given has no increments,
    /// [`Error::Step`] if all paths fail: the first failure, [`Error::Losses`] if more fail than are allowed. Fewer failures are in the
    /// [`Statistics`]. `Error::Checkpoint` if there is a checkpoint that cannot be
    /// written or gone on from.
    pub fn run(self) -> Result<Statistics, Error>
    where
        N: Serves<R>,
    {
        self.run_in::<0>()
    }

    /// [`Ensemble::run`] with `WIDTH` paths beside each other, with 0 as many as suit the instructions; the result is the
    /// same.
    #[doc(hidden)]
    pub fn run_in<const WIDTH: usize>(mut self) -> Result<Statistics, Error>
    where
        N: Serves<R>,
    {
        let execution = std::mem::take(&mut self.setup.execution);
        let (control, keeping) =
            (std::mem::take(&mut self.setup.control), std::mem::take(&mut self.setup.keeping));
        let (threads, instructions, interrupt) =
            (execution.threads()?, execution.instructions, Interrupt::watch());
        let stop = || execution.is_stopped(&interrupt);
        let job = self.job(&stop)?;
        if job.wanted.has_pairs && WIDTH % 2 == 1 {
            return Err(
                ConfigError::Setting(format!("antithetic pairs in {WIDTH} lanes: take 2 or more")).into()
            );
        }
        let mut account = Account::open(&job, &control, keeping, execution.progress("paths"), threads)?;
        let size = account.size();
        let work = |number| {
            let block = Block::<H, E, P, WIDTH>::new(&job, number, size);
            block.instructions(instructions).run(block)
        };
        in_order(account.pieces(), threads, work, |_, piece| account.take(piece));
        account.close()
    }
}
