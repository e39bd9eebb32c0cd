//! The run of a path: its steps, its nodes, and what becomes of them.

use super::{Node, Observer, Partial, Simulation, Summation};
use crate::algebra::compensated::CompensatedTotals;
use crate::algebra::memory::Threads;
use crate::algebra::state::{State, Vector};
use crate::algebra::state_sum::StateSum;
use crate::error::{StoppedError, wrong};
use crate::ground::progress::StepsShown;
use crate::increments::{Interval, Noise};
use crate::scheme::dense::DenseOutput;
use crate::scheme::poles;
use crate::scheme::system::{Discretized, Hamiltonian};
use crate::trajectory::Error;
use crate::trajectory::between::{BetweenNodes, StepPart};
use crate::trajectory::checkpoint::CheckpointKeeper;
use crate::trajectory::following::{Following, StepLook};
use crate::trajectory::options::{Execution, RunSetup};
use crate::trajectory::recorded::{ClockInterval, Recorder};
use crate::trajectory::retry::Subdivision;
use crate::trajectory::span::NodeGrid;
use crate::trajectory::step::StepInfo;
use crate::trajectory::steps::{Advance, NodeOutcome, SinglePath, take_steps};

impl<H, E, N, O, S> Simulation<'_, H, E, N, O, S>
where
    H: Discretized<E>,
    N: Noise,
    O: Observer<H::Vector>,
    S: Summation<H, E>,
{
    /// [`Simulation::run_partial`] until the observer or `stop` ends the run. Both are asked about ten times
    /// a second.
    pub(crate) fn run_until(
        self,
        stop: Option<&dyn Fn() -> bool>,
    ) -> Result<(Partial<H::Vector, E>, O), Error> {
        let Self { setup, noise, observer, .. } = self;
        let RunSetup { system, h, sections, events, retry, keeping, .. } = setup;
        let Execution { threads, is_quiet, handle, stop: asked, .. } = setup.execution;
        let (names, functions) = setup.observables.checked("observables")?;
        let threads = Threads::asked(threads)?;
        let is_followed = H::PROPERTIES.is_clocked || !events.is_empty();
        if is_followed && retry.most() > 0 {
            return wrong(match H::PROPERTIES.is_clocked {
                true => {
                    "`retry` of a scheme with a clock, whose steps follow the motion already: take a smaller `Eps`"
                }
                false => "`retry` with `on` or `on_time`: an event divides its step; take a smaller step",
            });
        }
        let mut stepper = Subdivision::<H, E, S::Sum>::new(system, h, retry, setup.is_watched, threads)?;
        let (start, grid) = setup.span.checked::<H, E>(system, h)?;
        if grid.h != h {
            // A clock runs backwards where its end is before its start.
            stepper = Subdivision::new(system, grid.h, retry, setup.is_watched, threads)?;
        }
        let h = grid.h;
        let described = events.in_words();
        if is_followed {
            stepper = stepper.following(Following::new(system, events, &start, &grid));
        }
        stepper.watch.ends_after(grid.whole());
        let recording = setup.recorded.checked(1, &grid)?;
        let described = described.as_str();
        let processes = system.increments(start.q.components().len());
        let mut noise = grid.prepared(noise, &H::PLAN, processes, retry)?;
        if let Some(noise) = &noise {
            poles::check::<H, E>(system, &start, h, &|h| noise.largest_increment(h))?;
        }
        let looks_inside = !sections.is_empty() || !recording.between.is_empty();
        let between =
            || looks_inside.then(|| Box::new(BetweenNodes::new(&sections, &start, system.manifold())));
        let records = || Recorder::new(&start, h, processes, &recording, grid.expected());
        let is_shown = O::LOOKS && !O::AVERAGES;
        let has_sums = is_shown || keeping.is_set() || looks_inside;
        let account = RunRecords::new(records()?, processes, has_sums);
        let (mut state, mut dw) = (start.clone(), vec![0.0; processes]);
        let mut path = SinglePath {
            stepper: &mut stepper,
            state: &mut state,
            noise: &mut noise,
            dw: &mut dw,
            first: grid.first(),
        };
        let mut run = RunState { observer, account, looks: between() };
        let keeper = keeping.open_path(&mut path, &mut run, &grid, retry, &sections, described)?;
        let mut first = keeper.first();
        if let Some(following) = &path.stepper.following {
            following.check_resumed(first, path.state.t)?;
        }
        if let Some(looks) = &mut run.looks {
            looks.arrive(first, path.state);
        }
        if stop.is_some() && asked.is_some() {
            return wrong(
                "`stop_when(...)` before and after `time_averages`: a run has one such function; leave one of them out",
            );
        }
        let stop = stop.or(asked.as_deref().map(|stop| stop as _));
        let shown = StepsShown::new(is_quiet, handle, stop, [first, grid.steps]);
        let dense = looks_inside.then(|| Box::new(DenseOutput::of(&start)));
        let mut nodes = NodeHandler { run, keeper, shown, due: 0, grid, dense };
        nodes.due = nodes.next_due();
        let error = loop {
            if O::AVERAGES && nodes.run.observer.has_enough() {
                break None;
            }
            if first == 0 {
                nodes.begin(&mut path)?;
                nodes.run.show(path.state, 0, path.dw);
            }
            if path.stepper.is_over() {
                break None;
            }
            let all = take_all(&mut path, first, &mut nodes);
            match all.and_then(|()| Ok(path.stepper.arrive(path.state, &nodes.grid)?)) {
                Ok(()) => break None,
                Err(Error::Stopped(_)) if nodes.run.observer.has_enough() => break None,
                // A run that is kept does not start again: its file says that it went this far. Nor do
                // averages, which have seen its nodes.
                Err(error) if O::AVERAGES || nodes.keeper.keeps() || !path.stepper.refine(&error)? => {
                    break Some(error);
                }
                Err(_) => {
                    (first, *path.state) = (0, start.clone());
                    nodes.run.account = RunRecords::new(records()?, processes, has_sums);
                    nodes.run.looks = between();
                    path.dw.fill(0.0);
                }
            }
        };
        let NodeHandler { run: RunState { observer, account, .. }, keeper, grid, .. } = nodes;
        let exchanged = stepper.stepper.account();
        let trajectory = account.recorder.finish(state, &grid).observing(names, &functions);
        let trajectory =
            trajectory.accounted(system, &start, exchanged).suspecting(stepper.watch.suspected());
        let trajectory = trajectory.named(system.variables()).saved_but_for(keeper.unsaved());
        Ok(((trajectory, error), observer))
    }
}

/// Takes all steps from this one on.
fn take_all<'s, H, E, N, O, C>(
    path: &mut OnePath<'_, 's, H, E, N, C>,
    first: u64,
    nodes: &mut NodeHandler<'_, '_, '_, O, H::Vector>,
) -> Result<(), Error>
where
    H: Discretized<E>,
    N: Noise,
    O: Observer<H::Vector>,
    C: StateSum<f64>,
{
    // One call for steps of all sizes: with two, what they call would not be inlined (4 to 8 % more
    // instructions in steps of small systems).
    let grid = nodes.grid;
    for (numbers, size) in grid.from(first) {
        path.stepper.resize(size)?;
        take_steps(&mut (&mut *path, &mut *nodes), numbers)?;
        if path.stepper.is_over() {
            break;
        }
    }
    Ok(())
}

/// The records that a run makes of its steps.
pub(crate) struct RunRecords<V> {
    pub(crate) recorder: Recorder<V>,
    /// Sums of all increments, for an observer and a checkpoint.
    pub(crate) wiener: CompensatedTotals,
    /// Whether anybody asks for them.
    has_sums: bool,
    /// Newton iterations and halvings of the last step.
    last: [u32; 2],
}

impl<V: Vector> RunRecords<V> {
    fn new(recorder: Recorder<V>, processes: usize, has_sums: bool) -> Self {
        Self { recorder, wiener: CompensatedTotals::new(processes), has_sums, last: [0; 2] }
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

/// The results of a run so far, which a checkpoint keeps beside the path itself.
pub(crate) struct RunState<'s, 'a, O, V> {
    pub(crate) observer: O,
    pub(crate) account: RunRecords<V>,
    /// Looks between the nodes, if something is to be found there.
    pub(crate) looks: Option<Box<BetweenNodes<'s, 'a, V>>>,
}

impl<V: Vector, O: Observer<V>> RunState<'_, '_, O, V> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn show(&mut self, state: &State<V>, step: u64, dw: &[f64]) {
        let [iterations, halvings] = self.account.last;
        let node = Node { step, wiener: self.account.wiener.totals(), increments: dw, iterations, halvings };
        self.observer.observe(state, &node);
    }
}

/// Shows nodes to the observer, records them and what is between them, and saves the run.
struct NodeHandler<'k, 's, 'a, O, V> {
    run: RunState<'s, 'a, O, V>,
    keeper: CheckpointKeeper,
    shown: StepsShown<'k>,
    /// [`NodeHandler::next_due`]
    due: u64,
    grid: NodeGrid,
    dense: Option<Box<DenseOutput<V>>>,
}

impl<V: Vector, O: Observer<V>> NodeHandler<'_, '_, '_, O, V> {
    /// The next node at which it may be time to save, to show how far the run is, or to ask whether to stop.
    fn next_due(&self) -> u64 {
        self.keeper.next_node().min(self.shown.next_node())
    }

    /// Acts on the start, where there are events at its time.
    fn begin<H, E, N, C>(&mut self, path: &mut OnePath<'_, '_, H, E, N, C>) -> Result<(), Error>
    where
        H: Discretized<E, Vector = V>,
        C: StateSum<f64>,
    {
        if let Some(following) = &mut path.stepper.following {
            following.begin(path.state)?;
            let recorder = &mut self.run.account.recorder;
            following.happened.drain(..).for_each(|event| recorder.happen(event));
            if following.is_over {
                (self.grid.steps, self.grid.end, self.grid.shorter) = (0, Some(path.state.t), None);
            }
        }
        Ok(())
    }

    /// Keeps what happened in the step that ended at a node; whether the run is over there.
    #[cold]
    fn follow<H, E, N, C>(&mut self, path: &mut OnePath<'_, '_, H, E, N, C>, node: u64)
    where
        H: Discretized<E, Vector = V>,
        C: StateSum<f64>,
    {
        let Some(following) = &mut path.stepper.following else { return };
        let (recorder, t) = (&mut self.run.account.recorder, path.state.t);
        let length = t - following.before().t;
        if H::PROPERTIES.is_clocked {
            let reading = path.stepper.stepper.reading();
            recorder.keep_interval(ClockInterval {
                t: following.before().t,
                h: length,
                rho: Some(reading.density).filter(|rho| !rho.is_nan()),
            });
        }
        following.happened.drain(..).for_each(|event| recorder.happen(event));
        if following.is_over {
            (self.grid.steps, self.grid.end) = (node, Some(t));
            if following.whole() != length {
                recorder.cut(following.whole());
            }
            let is_shorter = !H::PROPERTIES.is_clocked && length != path.stepper.size();
            self.grid.shorter = self.grid.shorter.filter(|_| !is_shorter).or(is_shorter.then_some(length));
        }
    }

    /// Shows the end of the run to the observer, at its time. Averages see it as any node, since a run may go
    /// on from there, and only where all steps are whole.
    #[cold]
    fn show_end(&mut self, state: &mut State<V>, dw: &[f64]) {
        let NodeGrid { steps, end, shorter, .. } = self.grid;
        if O::LOOKS && !(O::AVERAGES && shorter.is_some()) {
            let t = state.t;
            state.t = end.filter(|_| !O::AVERAGES).unwrap_or(t);
            self.run.show(state, steps, dw);
            state.t = t;
        }
    }

    /// Looks into the step that ended at a node.
    #[inline(never)]
    fn look_inside<H, E, N, C>(
        &mut self,
        path: &mut OnePath<'_, '_, H, E, N, C>,
        node: u64,
    ) -> Result<(), Error>
    where
        H: Discretized<E, Vector = V>,
        N: Noise,
        C: StateSum<f64>,
    {
        let Self { run: RunState { looks: Some(looks), account, .. }, dense: Some(dense), .. } = self else {
            return Ok(());
        };
        let SinglePath { stepper, state, noise, dw, first } = path;
        let (step, [_, halvings], recorder) = (node - 1, account.last, &mut account.recorder);
        let Subdivision { stepper: taken, following, .. } = &mut **stepper;
        if let Some(following) = following {
            following.look(taken, StepLook { number: step, noise, dw, end: state }, looks, recorder)?;
            looks.arrive(node, state);
            return Ok(());
        }
        if looks.wants(node, recorder.next_inside()) {
            if halvings == 0 {
                stepper.stepper.fill([&looks.before, state], dw, dense);
                looks.search(dense, &StepPart { step, dw, later: &[], is_last: true, end: None }, recorder);
            } else {
                let (before, mut later, mut parts) = (looks.before.clone(), dw.to_vec(), 1_u64 << halvings);
                let interval = Interval { step, ..*first };
                stepper.revisit(&before, interval, noise, halvings, &mut |stepper, nodes, dw| {
                    later.iter_mut().zip(dw).for_each(|(later, dw)| *later -= dw);
                    parts -= 1;
                    stepper.fill(nodes, dw, dense);
                    let part = StepPart { step, dw, later: &later, is_last: parts == 0, end: None };
                    looks.search(dense, &part, recorder);
                })?;
            }
        }
        looks.arrive(node, state);
        Ok(())
    }
}

impl<H, E, N, O, C> Advance for (&mut OnePath<'_, '_, H, E, N, C>, &mut NodeHandler<'_, '_, '_, O, H::Vector>)
where
    H: Discretized<E>,
    N: Noise,
    O: Observer<H::Vector>,
    C: StateSum<f64>,
{
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn advance(&mut self, step: u64) -> Result<(), Error> {
        let (path, nodes) = self;
        let (stepper, step) = path.step(step);
        let info = stepper.take_step(step)?;
        nodes.run.account.count(path.dw, &info);
        Ok(())
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn next_node(&self, node: u64) -> u64 {
        let NodeHandler {
            run: RunState { observer, account: RunRecords { recorder, .. }, looks }, due, ..
        } = &*self.1;
        if self.0.stepper.following.is_some() {
            return node + 1;
        }
        let shown = if O::LOOKS && recorder.shows_all() { observer.next(node) } else { recorder.next_node() };
        let inside = looks.as_ref().map_or(u64::MAX, |looks| looks.next_node(node, recorder.next_inside()));
        shown.min(*due).min(inside)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn at_node(&mut self, node: u64) -> Result<NodeOutcome, Error> {
        let (path, nodes) = self;
        if path.stepper.following.is_some() {
            nodes.follow(path, node);
        }
        let NodeGrid { steps: all, end, shorter, .. } = nodes.grid;
        if node == all && shorter.is_some() {
            path.state.t = end.unwrap_or(path.state.t);
        }
        if nodes.run.looks.is_some() {
            nodes.look_inside(path, node)?;
        }
        let recorder = &mut nodes.run.account.recorder;
        let is_recorded = recorder.reach(path.state);
        if node == all {
            nodes.show_end(path.state, path.dw);
        } else if O::LOOKS && (is_recorded || recorder.shows_all()) {
            nodes.run.show(path.state, node, path.dw);
        }
        let is_enough = O::AVERAGES && nodes.run.observer.has_enough();
        if node >= nodes.due || is_enough {
            let is_over = nodes.shown.at_node(node) || is_enough;
            // A run goes on from whole steps.
            let may_save = node <= nodes.grid.whole() && !path.stepper.is_over();
            if may_save && (nodes.keeper.is_due(node) || (is_over && nodes.keeper.keeps())) {
                nodes.keeper.save_path(path, &mut nodes.run, node)?;
            }
            if is_over {
                return Err(StoppedError { done: node, all }.into());
            }
            nodes.due = nodes.next_due();
        }
        Ok(if path.stepper.is_over() { NodeOutcome::Ends } else { NodeOutcome::GoesOn })
    }
}

/// The path of a run.
pub(crate) type OnePath<'r, 's, H, E, N, C> =
    SinglePath<'r, Subdivision<'s, H, E, C>, <H as Hamiltonian>::Vector, N>;
