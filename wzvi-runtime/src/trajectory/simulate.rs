//! One path: a builder, and the run that it starts.

mod adjoint;
mod bare;
mod run;
mod tangent;

pub use adjoint::Adjoint;
pub(crate) use bare::StepsOnly;
pub(crate) use run::{OnePath, RunRecords, RunState};
pub use tangent::Tangent;
pub(crate) use tangent::{COLUMNS, Past, SharedStep, TangentColumns};

use std::marker::PhantomData;

use crate::algebra::state::State;
use crate::algebra::state_sum::{PlainSum, StateSum};
use crate::error::{ConfigError, wrong};
use crate::ground::handle::Handle;
use crate::ground::numbers::Tape;
use crate::increments::{NoNoise, Noise};
use crate::scheme::system::{Discretized, Hamiltonian, SumOf};
use crate::trajectory::Error;
use crate::trajectory::checkpoint::CheckpointSetting;
use crate::trajectory::events::EventRules;
use crate::trajectory::options::{RunSetup, options};
use crate::trajectory::recorded::Trajectory;
use crate::trajectory::recording::RecordingRequest;
use crate::trajectory::retry::Retry;
use crate::trajectory::section::Sections;
use crate::trajectory::series::Averaged;

/// The data of a node besides its state, for an observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node<'a> {
    /// Steps from the start, 0 for the start itself.
    pub step: u64,
    /// `W(t) - W(t_0)`, one per noise: the sum of all increments so far.
    pub wiener: &'a [f64],
    /// Increments of the step that ended here, one per noise; zeros at the start.
    pub increments: &'a [f64],
    /// Newton iterations of that step; 0 at the start.
    pub iterations: u32,
    /// How often that step was halved ([`Retry`]); 0 at the start.
    pub halvings: u32,
}

/// Sees the nodes of a run. Implemented by closures `|state, node| ...`.
pub trait Observer<V> {
    /// Whether it observes anything; a run without observer does not prepare its nodes.
    const LOOKS: bool = true;

    /// Called at the start and then at each recorded node.
    fn observe(&mut self, state: &State<V>, node: &Node<'_>);

    /// Whether it averages over a path that is not kept; a checkpoint then keeps the averages so far.
    #[doc(hidden)]
    const AVERAGES: bool = false;

    /// The next node that it sees after this one, of a path that is not kept.
    #[doc(hidden)]
    fn next(&self, node: u64) -> u64 {
        node + 1
    }

    /// Whether it has seen enough.
    #[doc(hidden)]
    fn has_enough(&self) -> bool {
        false
    }

    /// The settings that distinguish this observer from others, for a checkpoint.
    #[doc(hidden)]
    fn described(&self, _start: &State<V>) -> Vec<(String, String)> {
        Vec::new()
    }

    /// Passes the results of this observer to the tape of a checkpoint, which records or replaces them.
    #[doc(hidden)]
    fn pass(&mut self, _tape: &mut Tape) {}
}

impl<V, F: FnMut(&State<V>, &Node<'_>)> Observer<V> for F {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn observe(&mut self, state: &State<V>, node: &Node<'_>) {
        self(state, node);
    }
}

/// No observer.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unobserved;

impl<V> Observer<V> for Unobserved {
    const LOOKS: bool = false;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn observe(&mut self, _state: &State<V>, _node: &Node<'_>) {}
}

/// The result of a partial run: the trajectory up to the last good state and, if that is not the end, the
/// error that stopped it.
pub type Partial<V, E> = (Trajectory<V, E>, Option<Error>);

/// One path to run: [`Integrate::simulate`](crate::integrate::Integrate::simulate) begins it,
/// [`Simulation::run`] runs it.
///
/// A run needs a start and an end, and a noise if the system has noise. A later call of a method replaces an
/// earlier one, and two methods that set the same (`until` and `steps`) are an error.
#[derive(Clone, Debug)]
#[must_use = "nothing happens before `run`"]
pub struct Simulation<'a, H: Hamiltonian, E, N = NoNoise, O = Unobserved, S = UsualSums> {
    setup: RunSetup<'a, H>,
    noise: Option<N>,
    observer: O,
    types: SimulationTypes<E, S>,
}

/// The scheme, and how increments are added.
type SimulationTypes<E, S> = PhantomData<fn() -> (E, S)>;

/// How a run adds the increments of its state: [`UsualSums`], or [`PlainSums`].
pub trait Summation<H: Discretized<E>, E> {
    /// The rounding errors that a step leaves to the next one.
    type Sum: StateSum<f64>;
}

/// Compensated sums where they cost less than about 5 % of a step
/// ([`Scheme::Sum`](crate::scheme::system::Scheme::Sum)).
#[derive(Clone, Copy, Debug)]
pub enum UsualSums {}

impl<H: Discretized<E>, E> Summation<H, E> for UsualSums {
    type Sum = SumOf<H, E>;
}

/// Plain sums: [`Simulation::plain_sums`].
#[derive(Clone, Copy, Debug)]
pub enum PlainSums {}

impl<H: Discretized<E>, E> Summation<H, E> for PlainSums {
    type Sum = PlainSum;
}

impl<'a, H: Discretized<E>, E> Simulation<'a, H, E> {
    /// A path of `system` in steps of size `h`.
    pub fn new(system: &'a H, h: f64) -> Self {
        let setup = RunSetup::new(system, h);
        Self { setup, noise: None, observer: Unobserved, types: PhantomData }
    }
}

impl<'a, H: Hamiltonian, E, N, O, S> Simulation<'a, H, E, N, O, S> {
    options!(start, end, whole, record, observe, temperatures, section, events, watch, progress);

    /// Observes a function of the system, too.
    fn observe_own(
        self,
        name: impl Into<String>,
        observable: impl Fn(&H, &State<H::Vector>) -> f64 + Send + Sync + 'a,
    ) -> Self
    where
        H: Sync,
    {
        let system = self.setup.system;
        self.observe(name, move |state| observable(system, state))
    }

    /// Sets the source of the increments; [`Increments`](crate::increments::Increments) holds given ones.
    /// With a `&mut` the caller keeps the source and can continue with it. A system without noise accepts any
    /// source and does not use it.
    ///
    /// Noise belongs to the time at which it acts. A run that continues another,
    /// `.start(run.last().clone())`, goes on with the same seed; one that starts at `t = 0` again needs
    /// another seed, since the same one repeats the noise.
    pub fn noise<M: Noise>(self, noise: M) -> Simulation<'a, H, E, M, O, S> {
        Simulation { setup: self.setup, noise: Some(noise), observer: self.observer, types: PhantomData }
    }

    /// Halves steps that fail ([`crate::trajectory::retry`]): `Retry::halving(8)` allows 256 parts. The
    /// default is not to.
    ///
    /// The noise must know its path between the nodes ([`Noise::is_divisible`]), as all but `Increments` do;
    /// the run refuses another one. A run that restarts with shorter steps shows its observer all nodes
    /// again, from step 0. A run with checkpoints does not restart.
    pub fn retry(mut self, retry: Retry) -> Self {
        self.setup.retry = retry;
        self
    }

    /// Adds increments to the state with plain sums, as
    /// [`Stepper::plain`](crate::trajectory::step::Stepper::plain) does: the path then has the bits of one of
    /// an ensemble with the same increments. Derivatives of its end are those of plain sums in any case.
    pub fn plain_sums(self) -> Simulation<'a, H, E, N, O, PlainSums> {
        let Self { setup, noise, observer, .. } = self;
        Simulation { setup, noise, observer, types: PhantomData }
    }

    /// Sets the number of threads for the steps of large systems, as far as these have enough tiles. The
    /// default is all cores, from a size on where that pays; 1 switches threads off. The result is the same,
    /// bit for bit.
    pub fn threads(mut self, threads: usize) -> Self {
        self.setup.execution.threads = Some(threads);
        self
    }

    /// Lets this handle stop the run and report its progress ([`crate::ground::handle`]). A path that is
    /// stopped ends at a node with [`Error::Stopped`]; [`Simulation::run_partial`] returns it up to there.
    pub fn handle(mut self, handle: &Handle) -> Self {
        self.setup.execution.handle = Some(handle.clone());
        self
    }

    /// Calls `observer(state, node)` at each recorded node as the run reaches it, start and end included.
    /// With `record_every(0)` or [`Simulation::record_at`] alone it is called at each node. Use it to see
    /// increments and iterations, or to act during the run. States recorded between nodes are not shown.
    pub fn inspect<F>(self, observer: F) -> Simulation<'a, H, E, N, F, S>
    where
        F: FnMut(&State<H::Vector>, &Node<'_>),
    {
        self.observed_by(observer)
    }

    /// With these events.
    pub(crate) fn acting(mut self, events: &EventRules<'a, H::Vector>) -> Self {
        self.setup.events = events.clone();
        self
    }

    /// With these sections.
    pub(crate) fn crossing(mut self, sections: &Sections<'a, H::Vector>) -> Self {
        self.setup.sections = sections.clone();
        self
    }

    pub(crate) fn observed_by<Q>(self, observer: Q) -> Simulation<'a, H, E, N, Q, S> {
        Simulation { setup: self.setup, noise: self.noise, observer, types: PhantomData }
    }

    /// This run without its path: it keeps its ends and its averages.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] for what has no use then.
    pub(crate) fn without_path(mut self) -> Result<(Self, Averaged<'a, H::Vector>), ConfigError>
    where
        O: Observer<H::Vector>,
    {
        let RecordingRequest { every, times } = std::mem::take(&mut self.setup.recorded);
        let asked = [
            (!times.is_empty(), "`record_at`"),
            (!self.setup.sections.is_empty(), "`section`"),
            (!self.setup.events.is_empty(), "`on` and `on_time`"),
            (O::LOOKS, "`inspect`"),
        ];
        if let Some((_, what)) = asked.iter().find(|(is_asked, _)| *is_asked) {
            return wrong(format!("{what} in a run that keeps no path: leave it out"));
        }
        self.setup.recorded.every = Some(0);
        let (names, functions) = std::mem::take(&mut self.setup.observables).checked("observables")?;
        let start = self.setup.span.start.value().map_or(f64::NAN, |start| start.t);
        let (h, stride) = (self.setup.h, every.unwrap_or(1).max(1));
        Ok((self, Averaged { names, functions, start, h, stride }))
    }

    /// The stride of `record_every`, which is then no request for a path.
    pub(crate) fn take_stride(&mut self) -> Option<u64> {
        self.setup.recorded.every.take()
    }

    /// Continues from a checkpoint, and saves to it.
    pub(crate) fn keeping(mut self, keeping: CheckpointSetting) -> Self {
        self.setup.keeping = keeping;
        self
    }
}

impl<H, E, N, O, S> Simulation<'_, H, E, N, O, S>
where
    H: Discretized<E>,
    N: Noise,
    O: Observer<H::Vector>,
    S: Summation<H, E>,
{
    /// Runs the path.
    ///
    /// # Errors
    /// [`Error::Config`] if a setting is missing or invalid, [`Error::Noise`] if the source has no
    /// increments, [`Error::Step`] if a step fails. [`Simulation::run_partial`] keeps what was computed
    /// before.
    pub fn run(self) -> Result<Trajectory<H::Vector, E>, Error> {
        match self.run_partial()? {
            (trajectory, None) => Ok(trajectory),
            (_, Some(error)) => Err(error),
        }
    }

    /// Runs the path as far as possible. It returns the trajectory up to the last good state, and the error
    /// that ended it early, if there was one ([`Error::Step`], [`Error::Noise`] or [`Error::Stopped`]).
    ///
    /// # Errors
    /// [`Error::Config`], [`Error::Noise`] or [`Error::Checkpoint`] if the run could not start, so that there
    /// is no trajectory.
    pub fn run_partial(self) -> Result<Partial<H::Vector, E>, Error> {
        self.run_until(None).map(|(path, _)| path)
    }
}
