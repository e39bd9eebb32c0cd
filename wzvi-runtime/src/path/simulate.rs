//! One path: a builder, and the loop that it starts.

mod tangent;

pub use tangent::Tangent;

use std::marker::PhantomData;
use std::time::Duration;

use crate::algebra::memory::Threads;
use crate::algebra::state::{State, Vector};
use crate::algebra::sum::Sums;
use crate::error::{ConfigError, StoppedError};
use crate::ground::due::Due;
use crate::ground::handle::Handle;
use crate::ground::numbers::Tape;
use crate::ground::progress::StepsShown;
use crate::increments::{Interval, NoNoise, Noise};
use crate::path::Error;
use crate::path::between::{Between, Part};
use crate::path::checkpoint::{Keeper, Keeping};
use crate::path::options::{Execution, Setup, options};
use crate::path::recording::Request;
use crate::path::retry::{Halved, Retry, Serves, Subdivision, Whole};
use crate::path::series::Averaged;
use crate::path::span::Grid;
use crate::path::step::StepInfo;
use crate::path::steps::{Advance, Single, take_steps};
use crate::path::trajectory::{Recorder, Trajectory};
use crate::path::watch::Watch;
use crate::scheme::dense::DenseOutput;
use crate::scheme::system::{Discretized, Hamiltonian};

/// What an observer sees of a node besides the state.
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

    /// Of a path that is not kept, the next node that it sees after this one.
    #[doc(hidden)]
    fn next(&self, node: u64) -> u64 {
        node + 1
    }

    /// Whether it has seen enough.
    #[doc(hidden)]
    fn has_enough(&self) -> bool {
        false
    }

    /// What distinguishes it from others, for a checkpoint.
    #[doc(hidden)]
    fn described(&self, _start: &State<V>) -> Vec<(String, String)> {
        Vec::new()
    }

    /// What it has seen, for a checkpoint.
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

/// The result of a partial run: the trajectory up to the last good state and, if that is not the end, the error that stopped it.
pub type Partial<V, E> = (Trajectory<V, E>, Option<Error>);

/// One path to run: [`Integrate::simulate`](crate::integrate::Integrate::simulate) begins it, [`Simulation::run`]
/// runs it.
///
/// A run needs a start and an end, and a noise if the system has noise. A later setting replaces an earlier one.
#[derive(Clone, Debug)]
#[must_use = "nothing happens before `run`"]
pub struct Simulation<'a, H: Hamiltonian, E, N = NoNoise, O = Unobserved, R = Whole> {
    setup: Setup<'a, H>,
    noise: Option<N>,
    observer: O,
    types: PhantomData<fn() -> (E, R)>,
}

impl<'a, H: Discretized<E>, E> Simulation<'a, H, E> {
    /// A path of `system` in steps of size `h`.
    pub fn new(system: &'a H, h: f64) -> Self {
        let setup = Setup::new(system, h);
        Self { setup, noise: None, observer: Unobserved, types: PhantomData }
    }
}

impl<'a, H: Hamiltonian, E, N, O, R> Simulation<'a, H, E, N, O, R> {
    options!(start, end, exact, record, observe, temperatures, section, watch, progress);

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

    /// Sets the source of the increments; [`Increments`](crate::increments::Increments) holds given ones. With a `&mut` the caller keeps the
    /// source and can continue with it. A system without noise accepts any source and does not use it.
    pub fn noise<M: Noise>(self, noise: M) -> Simulation<'a, H, E, M, O, R> {
        Simulation { setup: self.setup, noise: Some(noise), observer: self.observer, types: PhantomData }
    }

    /// Halves steps that fail ([`crate::path::retry`]): `Retry::halving(8)` allows 256 parts. The default is not to.
    ///
    /// The noise must know its path between the nodes ([`Divisible`](crate::increments::Divisible)), as all but `Increments` do. A run that
    /// restarts with shorter steps shows its observer all nodes again, from step 0. A run with checkpoints does not restart.
    pub fn retry(mut self, retry: Retry) -> Simulation<'a, H, E, N, O, Halved> {
        self.setup.retry = retry;
        Simulation { setup: self.setup, noise: self.noise, observer: self.observer, types: PhantomData }
    }

    /// Sets the number of threads for the steps of large systems, as far as these have enough windows. The default is all cores, from a size
    /// on where that pays; 1 switches threads off. The result is the same, bit for bit.
    pub fn threads(mut self, threads: usize) -> Self {
        self.setup.execution.threads = Some(threads);
        self
    }

    /// Lets this handle stop the run and report its progress ([`crate::ground::handle`]). A path that is stopped ends at a node with
    /// [`Error::Stopped`]; [`Simulation::run_partial`] returns it up to there.
    pub fn handle(mut self, handle: &Handle) -> Self {
        self.setup.execution.handle = Some(handle.clone());
        self
    }

    /// Calls `observer(state, node)` at each recorded node as the run reaches it, start and end included. With `record_every(0)` or
    /// [`Simulation::record_at`] alone it is called at each node. Use it to see increments and iterations, or to act during the run. States
    /// recorded between nodes are not shown.
    pub fn inspect<F>(self, observer: F) -> Simulation<'a, H, E, N, F, R>
    where
        F: FnMut(&State<H::Vector>, &Node<'_>),
    {
        self.observed_by(observer)
    }

    pub(crate) fn observed_by<Q>(self, observer: Q) -> Simulation<'a, H, E, N, Q, R> {
        Simulation { setup: self.setup, noise: self.noise, observer, types: PhantomData }
    }

    /// The same run, keeping only its ends and its averages.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] for what has no use then.
    pub(crate) fn without_path(mut self) -> Result<(Self, Averaged<'a, H::Vector>), ConfigError>
    where
        O: Observer<H::Vector>,
    {
        let Request { every, times } = std::mem::take(&mut self.setup.recorded);
        let asked = [
            (!times.is_empty(), "`record_at`"),
            (!self.setup.sections.is_empty(), "`section`"),
            (O::LOOKS, "`inspect`"),
            (self.setup.span.is_exact, "`exactly`"),
        ];
        if let Some((_, what)) = asked.iter().find(|(is_asked, _)| *is_asked) {
            let wrong = format!("{what} in a run that keeps no path: leave it out");
            return Err(ConfigError::Setting(wrong));
        }
        self.setup.recorded.every = Some(0);
        let (names, functions) = std::mem::take(&mut self.setup.observables).checked("observables")?;
        let start = self.setup.span.start.as_ref().map_or(f64::NAN, |start| start.t);
        let (h, stride) = (self.setup.h, every.unwrap_or(1).max(1));
        Ok((self, Averaged { names, functions, start, h, stride }))
    }

    /// Continues from a checkpoint, and saves to it.
    pub(crate) fn keeping(mut self, keeping: Keeping) -> Self {
        self.setup.keeping = keeping;
        self
    }
}

impl<H, E, N, O, R> Simulation<'_, H, E, N, O, R>
where
    H: Discretized<E>,
    N: Noise,
    O: Observer<H::Vector>,
{
    /// Runs the path.
    ///
    /// # Errors
    /// [`Error::Config`] if a setting is missing or invalid, [`Error::Noise`] if the source has no increments, [`Error::Step`] if a step
    /// fails. [`Simulation::run_partial`] keeps what was computed before.
    pub fn run(self) -> Result<Trajectory<H::Vector, E>, Error>
    where
        N: Serves<R>,
    {
        match self.run_partial()? {
            (trajectory, None) => Ok(trajectory),
            (_, Some(error)) => Err(error),
        }
    }

    /// Runs the path as far as possible. It returns the trajectory up to the last good state, and the error that ended it early, if there
    /// was one ([`Error::Step`], [`Error::Noise`] or [`Error::Stopped`]).
    ///
    /// # Errors
    /// [`Error::Config`], [`Error::Noise`] or [`Error::Checkpoint`] if the run could not start, so that there is no
    /// trajectory.
    pub fn run_partial(self) -> Result<Partial<H::Vector, E>, Error>
    where
        N: Serves<R>,
    {
        self.run_until(None).map(|(path, _)| path)
    }

    /// [`Simulation::run_partial`] until the observer or `stop` ends the run. Both are asked about ten times a second.
    pub(crate) fn run_until(
        self,
        stop: Option<&dyn Fn() -> bool>,
    ) -> Result<(Partial<H::Vector, E>, O), Error>
    where
        N: Serves<R>,
    {
        let Self { setup, noise, mut observer, .. } = self;
        let Setup {
            system,
            h,
            span,
            recorded,
            observables,
            sections,
            retry,
            is_watched,
            execution,
            keeping,
            more: (),
        } = setup;
        let Execution { threads, is_quiet, handle, stop: asked, .. } = execution;
        let (names, functions) = observables.checked("observables")?;
        let mut stepper = Subdivision::<H, E>::new(system, h, retry, is_watched, Threads::asked(threads)?)?;
        let (start, grid) = span.checked::<H, E>(system, h)?;
        let recording = recorded.checked(1, &grid)?;
        let processes = system.increments(start.q.components().len());
        let mut noise = grid.prepared(noise, &H::PLAN, processes)?;
        let looks_inside = !sections.is_empty() || !recording.between.is_empty();
        let between = || looks_inside.then(|| Box::new(Between::new(&sections, &start)));
        let records = || Recorder::new(&start, h, processes, &recording, grid.steps);
        let is_shown = O::LOOKS && !O::AVERAGES;
        let mut account = Records::new(records()?, processes, is_shown || keeping.is_set() || looks_inside);
        let (mut state, mut dw) = (start.clone(), vec![0.0; processes]);
        let mut looks = between();
        let keeper = keeping.open_path(
            &mut stepper.stepper,
            &mut Run::new(&mut state, &mut account, &mut looks, &mut stepper.watch, &mut observer),
            noise.as_ref(),
            (&grid, retry, &sections),
        )?;
        let mut first = keeper.first();
        if let Some(looks) = &mut looks {
            looks.arrive(first, &state);
        }
        let shown = StepsShown::new(is_quiet, handle, first, grid.steps);
        let stop = stop.or(asked.as_deref().map(|stop| stop as _));
        let stop = stop.map(|stop| (stop, Due::new(None, Some(PAUSE), first, grid.steps)));
        let dense = looks_inside.then(|| Box::new(DenseOutput::of(&start)));
        let mut nodes = Nodes { observer, account, keeper, shown, stop, due: 0, grid, looks, dense };
        nodes.due = nodes.next_due();
        let error = loop {
            if O::AVERAGES && nodes.observer.has_enough() {
                break None;
            }
            if first == 0 {
                nodes.show(&state, 0, &dw);
            }
            let mut path = Single {
                stepper: &mut stepper,
                state: &mut state,
                noise: &mut noise,
                dw: &mut dw,
                first: grid.first(),
            };
            match take_all(&mut path, first, &mut nodes) {
                Ok(()) => break None,
                Err(Error::Stopped(_)) if nodes.observer.has_enough() => break None,
                // A run that is kept does not start again: its file says that it went this far. Nor do averages, which have seen its nodes.
                Err(error) if O::AVERAGES || nodes.keeper.keeps() || !stepper.refine(&error)? => {
                    break Some(error);
                }
                Err(_) => {
                    (first, state) = (0, start.clone());
                    nodes.account = Records::new(records()?, processes, nodes.account.has_sums);
                    nodes.looks = between();
                    dw.fill(0.0);
                }
            }
        };
        let Nodes { observer, account, keeper, .. } = nodes;
        let exchanged = stepper.stepper.exchanged();
        let trajectory = account.recorder.finish(state).observing(names, &functions);
        let trajectory =
            trajectory.accounted(system, &start, exchanged).suspecting(stepper.watch.suspected());
        let trajectory = trajectory.named(system.variables()).saved_but_for(keeper.unsaved());
        Ok(((trajectory, error), observer))
    }
}

/// Between two questions whether to stop.
const PAUSE: Duration = Duration::from_millis(100);

/// Takes all steps from this one on, the last one of another size if it is shorter.
fn take_all<'s, H, E, N, O>(
    path: &mut OnePath<'_, 's, H, E, N>,
    first: u64,
    nodes: &mut Nodes<'_, '_, '_, O, H::Vector>,
) -> Result<(), Error>
where
    H: Discretized<E>,
    N: Noise,
    O: Observer<H::Vector>,
{
    let grid = nodes.grid;
    take_steps(&mut (&mut *path, &mut *nodes), first..grid.whole())?;
    match grid.shorter {
        Some(h) if first < grid.steps => {
            path.stepper.finish_with(h)?;
            take_steps(&mut (path, nodes), grid.whole()..grid.steps)
        }
        _ => Ok(()),
    }
}

/// What a run writes down of its steps.
struct Records<V> {
    recorder: Recorder<V>,
    /// Sums of all increments, for an observer and a checkpoint.
    wiener: Sums,
    /// Whether anybody asks for them.
    has_sums: bool,
    /// Newton iterations and halvings of the last step.
    last: [u32; 2],
}

impl<V: Vector> Records<V> {
    fn new(recorder: Recorder<V>, processes: usize, has_sums: bool) -> Self {
        Self { recorder, wiener: Sums::new(processes), has_sums, last: [0; 2] }
    }

    /// A step with these increments was taken.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn count(&mut self, dw: &[f64], info: &StepInfo) {
        self.recorder.step(dw, info);
        if self.has_sums {
            self.wiener.add(dw);
            self.last = [info.iterations, info.halvings];
        }
    }
}

/// What a run is, beside its stepper: all that a checkpoint keeps and brings back.
pub(crate) struct Run<'r, 's, 'a, V, O> {
    pub(crate) state: &'r mut State<V>,
    pub(crate) recorder: &'r mut Recorder<V>,
    pub(crate) wiener: &'r mut Sums,
    pub(crate) looks: Option<&'r mut Between<'s, 'a, V>>,
    pub(crate) watch: &'r mut Watch<V>,
    pub(crate) observer: &'r mut O,
}

impl<'r, 's, 'a, V, O> Run<'r, 's, 'a, V, O> {
    fn new(
        state: &'r mut State<V>,
        account: &'r mut Records<V>,
        looks: &'r mut Option<Box<Between<'s, 'a, V>>>,
        watch: &'r mut Watch<V>,
        observer: &'r mut O,
    ) -> Self {
        let Records { recorder, wiener, .. } = account;
        Self { state, recorder, wiener, looks: looks.as_deref_mut(), watch, observer }
    }
}

/// Shows nodes to the observer, records them and what is between them, and saves the run.
struct Nodes<'k, 's, 'a, O, V> {
    observer: O,
    account: Records<V>,
    keeper: Keeper,
    shown: StepsShown,
    /// Whether to stop, and when to ask.
    stop: Option<(&'k dyn Fn() -> bool, Due)>,
    /// [`Nodes::next_due`]
    due: u64,
    grid: Grid,
    /// Looks between the nodes, if something is to be found there.
    looks: Option<Box<Between<'s, 'a, V>>>,
    dense: Option<Box<DenseOutput<V>>>,
}

impl<V: Vector, O: Observer<V>> Nodes<'_, '_, '_, O, V> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn show(&mut self, state: &State<V>, step: u64, dw: &[f64]) {
        let [iterations, halvings] = self.account.last;
        let node = Node { step, wiener: self.account.wiener.totals(), increments: dw, iterations, halvings };
        self.observer.observe(state, &node);
    }

    /// The next node at which it may be time to save, to show how far the run is, or to ask whether to stop.
    fn next_due(&self) -> u64 {
        let asked = self.stop.as_ref().map_or(u64::MAX, |(_, due)| due.next());
        self.keeper.next().min(self.shown.next()).min(asked)
    }

    /// Whether the run is to stop at a node.
    fn is_stopped(&mut self, node: u64) -> bool {
        let asked = self.stop.as_mut().is_some_and(|(stop, due)| {
            let is_due = due.is_due(node);
            if is_due {
                due.done();
            }
            is_due && node < self.grid.steps && stop()
        });
        self.shown.look(node) || asked
    }

    /// Looks into the step that ended at a node.
    #[inline(never)]
    fn look_inside<H, E, N>(&mut self, path: &mut OnePath<'_, '_, H, E, N>, node: u64) -> Result<(), Error>
    where
        H: Discretized<E, Vector = V>,
        N: Noise,
    {
        let Self { looks: Some(looks), dense: Some(dense), account, .. } = self else { return Ok(()) };
        let Single { stepper, state, noise, dw, first } = path;
        let (step, [_, halvings], recorder) = (node - 1, account.last, &mut account.recorder);
        if looks.wants(node, recorder.next_inside()) {
            if halvings == 0 {
                stepper.stepper.fill([&looks.before, state], dw, dense);
                looks.look(dense, &Part { step, dw, later: &[], is_last: true }, recorder);
            } else {
                let (before, mut later, mut parts) = (looks.before.clone(), dw.to_vec(), 1_u64 << halvings);
                let interval = Interval { step, ..*first };
                stepper.revisit(&before, interval, noise, halvings, |stepper, nodes, dw| {
                    later.iter_mut().zip(dw).for_each(|(later, dw)| *later -= dw);
                    parts -= 1;
                    stepper.fill(nodes, dw, dense);
                    looks.look(dense, &Part { step, dw, later: &later, is_last: parts == 0 }, recorder);
                })?;
            }
        }
        looks.arrive(node, state);
        Ok(())
    }
}

impl<H, E, N, O> Advance for (&mut OnePath<'_, '_, H, E, N>, &mut Nodes<'_, '_, '_, O, H::Vector>)
where
    H: Discretized<E>,
    N: Noise,
    O: Observer<H::Vector>,
{
    type Error = Error;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance(&mut self, step: u64) -> Result<(), Error> {
        let (path, nodes) = self;
        let (stepper, step) = path.step(step);
        let info = stepper.take_step(step)?;
        nodes.account.count(path.dw, &info);
        Ok(())
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn next(&self, node: u64) -> u64 {
        let Nodes { observer, account: Records { recorder, .. }, looks, due, .. } = &*self.1;
        let shown = if O::LOOKS && recorder.shows_all() { observer.next(node) } else { recorder.next() };
        let inside = looks.as_ref().map_or(u64::MAX, |looks| looks.next(node, recorder.next_inside()));
        shown.min(*due).min(inside)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn look(&mut self, node: u64) -> Result<(), Error> {
        let (path, nodes) = self;
        let all = nodes.grid.steps;
        if node == all {
            path.state.t = nodes.grid.end.unwrap_or(path.state.t);
        }
        if nodes.looks.is_some() {
            nodes.look_inside(path, node)?;
        }
        let recorder = &mut nodes.account.recorder;
        let is_recorded = recorder.reach(path.state);
        if O::LOOKS && (is_recorded || recorder.shows_all() || node == all) {
            nodes.show(path.state, node, path.dw);
        }
        let is_enough = O::AVERAGES && nodes.observer.has_enough();
        if node >= nodes.due || is_enough {
            let is_over = nodes.is_stopped(node) || is_enough;
            if nodes.keeper.is_due(node) || (is_over && nodes.keeper.keeps()) {
                let Nodes { account, looks, observer, keeper, .. } = &mut **nodes;
                let Subdivision { stepper, watch, .. } = &mut *path.stepper;
                keeper.save_path(
                    stepper,
                    &mut Run::new(path.state, account, looks, watch, observer),
                    node,
                )?;
            }
            if is_over {
                return Err(StoppedError { done: node, all }.into());
            }
            nodes.due = nodes.next_due();
        }
        Ok(())
    }
}

/// The path of a run.
type OnePath<'r, 's, H, E, N> = Single<'r, Subdivision<'s, H, E>, <H as Hamiltonian>::Vector, N>;
