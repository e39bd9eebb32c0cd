//! One path: a builder, and the loop that it starts.

use std::fmt;
use std::marker::PhantomData;
use std::sync::Arc;

use crate::checkpoint::Keeping;
use crate::error::{ConfigError, Error, StepFailure};
use crate::increments::{Interval, NoNoise, Noise};
use crate::retry::{Retry, Walker};
use crate::state::{State, Vector};
use crate::step::StepInfo;
use crate::sum::Sums;
use crate::system::Discretized;
use crate::trajectory::{Recorder, Recording, Trajectory};

/// Step numbers are exact as `f64` up to here; time is `t_0 + n h`.
pub(crate) const MOST_STEPS: u64 = 1 << 53;

/// What an observer is told of a node besides the state.
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
    /// Whether it looks at all; a run without observer does not prepare what it would be told.
    const LOOKS: bool = true;

    /// Called at the start and then at each recorded node.
    fn observe(&mut self, state: &State<V>, node: &Node<'_>);
}

impl<V, F: FnMut(&State<V>, &Node<'_>)> Observer<V> for F {
    #[inline(always)]
    fn observe(&mut self, state: &State<V>, node: &Node<'_>) {
        self(state, node);
    }
}

/// Nobody looks.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unobserved;

impl<V> Observer<V> for Unobserved {
    const LOOKS: bool = false;

    #[inline(always)]
    fn observe(&mut self, _state: &State<V>, _node: &Node<'_>) {}
}

/// As far as a run went: the trajectory up to the last good state and, if that is not the end, what stopped it.
pub type Partial<V, E> = (Trajectory<V, E>, Option<Error>);

#[derive(Clone, Copy, Debug)]
pub(crate) enum End {
    Time(f64),
    Steps(u64),
}

/// A function of the state.
type Observable<'a, V> = Arc<dyn Fn(&State<V>) -> f64 + Send + Sync + 'a>;

/// Functions of the state, by name.
struct Observables<'a, V>(Vec<(String, Observable<'a, V>)>);

impl<V> Clone for Observables<'_, V> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<V> fmt::Debug for Observables<'_, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.0.iter().map(|(name, _)| name)).finish()
    }
}

/// One path to run: [`Integrate::simulate`](crate::integrate::Integrate::simulate) begins it, [`Simulation::run`]
/// runs it.
///
/// A start and an end are needed, and a noise if the system has any. A later setting replaces an earlier one.
#[derive(Clone, Debug)]
#[must_use = "nothing happens before `run`"]
pub struct Simulation<'a, H: Discretized<E>, E, N = NoNoise, O = Unobserved> {
    system: &'a H,
    h: f64,
    start: Option<State<H::Vector>>,
    noise: Option<N>,
    end: Option<End>,
    every: Option<u64>,
    chosen: Vec<f64>,
    observables: Observables<'a, H::Vector>,
    observer: O,
    retry: Retry,
    is_watched: bool,
    pub(crate) keeping: Keeping,
    scheme: PhantomData<fn() -> E>,
}

impl<'a, H: Discretized<E>, E> Simulation<'a, H, E> {
    /// A path of `system` in steps of size `h`.
    pub fn new(system: &'a H, h: f64) -> Self {
        Self {
            system,
            h,
            start: None,
            noise: None,
            end: None,
            every: None,
            chosen: Vec::new(),
            observables: Observables(Vec::new()),
            observer: Unobserved,
            retry: Retry::never(),
            is_watched: true,
            keeping: Default::default(),
            scheme: PhantomData,
        }
    }
}

impl<'a, H: Discretized<E>, E, N, O> Simulation<'a, H, E, N, O> {
    /// The first state, at its own time.
    pub fn start(mut self, start: State<H::Vector>) -> Self {
        self.start = Some(start);
        self
    }

    /// Where the increments come from; [`Increments`](crate::increments::Increments) for given ones. A `&mut` to a
    /// source leaves it with the caller, to continue with. A system without noise takes any source and asks it
    /// for nothing.
    pub fn noise<M: Noise>(self, noise: M) -> Simulation<'a, H, E, M, O> {
        Simulation {
            noise: Some(noise),
            system: self.system,
            h: self.h,
            start: self.start,
            end: self.end,
            every: self.every,
            chosen: self.chosen,
            observables: self.observables,
            observer: self.observer,
            retry: self.retry,
            is_watched: self.is_watched,
            keeping: self.keeping,
            scheme: self.scheme,
        }
    }

    /// Runs to time `end` (time units of the Hamiltonian): the first node at or beyond it.
    ///
    /// That is `⌈(end - t_0)/h⌉` steps, with an allowance for rounding: `until(20.0)` with `h = 0.02` takes 1000.
    pub fn until(mut self, end: f64) -> Self {
        self.end = Some(End::Time(end));
        self
    }

    /// Runs `steps` steps.
    pub fn steps(mut self, steps: u64) -> Self {
        self.end = Some(End::Steps(steps));
        self
    }

    /// Keeps every `stride`-th node, the start and the last; 1 (all of them) if neither this nor [`Simulation::record_at`] is called.
    ///
    /// With 0, only the start and the last node are kept and an observer sees every node: the memory of the run
    /// does not grow.
    pub fn record_every(mut self, stride: u64) -> Self {
        self.every = Some(stride);
        self
    }

    /// Keeps the nodes at these times, too: each the first node at or beyond it. Without [`Simulation::record_every`], only these, the start
    /// and the last.
    pub fn record_at(mut self, times: impl IntoIterator<Item = f64>) -> Self {
        self.chosen.extend(times);
        self
    }

    /// One more observable, a function of the state: [`Trajectory::observed`] has its values at the recorded nodes.
    pub fn observe(
        mut self,
        name: impl Into<String>,
        observable: impl Fn(&State<H::Vector>) -> f64 + Send + Sync + 'a,
    ) -> Self {
        self.observables.0.push((name.into(), Arc::new(observable)));
        self
    }

    /// Halves steps that fail ([`crate::retry`]): `Retry::halving(8)` allows 256 parts. Not done unless asked for.
    ///
    /// A stochastic system needs a noise that knows its path between the nodes, such as `Wiener` or `WongZakai`. A run
    /// that starts again in shorter steps shows its observer the nodes again, from step 0; one with checkpoints does not
    /// start again.
    pub fn retry(mut self, retry: Retry) -> Self {
        self.retry = retry;
        self
    }

    /// Lets steps pass that do not resolve the fastest motion and spoil the energy
    /// ([`StepFailure::Unresolved`]): for whoever looks at the energy himself.
    pub fn unwatched(mut self) -> Self {
        self.is_watched = false;
        self
    }

    /// Calls `observer(state, node)` at each recorded node (each node with `record_every(0)` or [`Simulation::record_at`] alone), start and
    /// end included, as the run gets there: for whoever wants to see increments and iterations, or to act on the way.
    pub fn inspect<F>(self, observer: F) -> Simulation<'a, H, E, N, F>
    where
        F: FnMut(&State<H::Vector>, &Node<'_>),
    {
        Simulation {
            observer,
            system: self.system,
            h: self.h,
            start: self.start,
            noise: self.noise,
            end: self.end,
            every: self.every,
            chosen: self.chosen,
            observables: self.observables,
            retry: self.retry,
            is_watched: self.is_watched,
            keeping: self.keeping,
            scheme: self.scheme,
        }
    }
}

impl<H: Discretized<E>, E, N: Noise, O: Observer<H::Vector>> Simulation<'_, H, E, N, O> {
    /// Runs the path.
    ///
    /// # Errors
    /// [`Error::Config`] if a setting is missing or makes no sense, [`Error::Noise`] if the source has no increments,
    /// [`Error::Step`] if a step fails. To keep what was computed before, use [`Simulation::run_partial`].
    pub fn run(self) -> Result<Trajectory<H::Vector, E>, Error> {
        match self.run_partial()? {
            (trajectory, None) => Ok(trajectory),
            (_, Some(error)) => Err(error),
        }
    }

    /// Runs the path as far as it goes: the trajectory up to the last good state, and what ended it early, if
    /// anything did ([`Error::Step`] or [`Error::Noise`]).
    ///
    /// # Errors
    /// [`Error::Config`] or [`Error::Noise`] (`Error::Checkpoint` with the feature `serde`) if the run could not start:
    /// then there is no trajectory.
    pub fn run_partial(self) -> Result<Partial<H::Vector, E>, Error> {
        let Self { system, h, start, noise, end, every, chosen, observables, mut observer, .. } = self;
        let (retry, is_watched, keeping) = (self.retry, self.is_watched, self.keeping);
        let names = observables.0.iter().map(|(name, _)| name).enumerate();
        if let Some((_, twice)) =
            names.clone().find(|&(i, name)| names.clone().take(i).any(|(_, known)| known == name))
        {
            return Err(ConfigError::Setting(format!("two observables have the name `{twice}`")).into());
        }
        let finish = |recorder: Recorder<H::Vector>, state: State<H::Vector>| -> Trajectory<H::Vector, E> {
            recorder.finish(state).observing(observables.0.iter().map(|(name, f)| (name, &**f)))
        };
        let mut walker = Walker::<H, E>::new(system, h, retry, is_watched)?;
        let mut state = checked(system, start)?;
        let start = state.clone();
        let origin = start.t;
        let steps = count(end, origin, h)?;
        let every = every.unwrap_or(if chosen.is_empty() { 1 } else { 0 });
        let recording = Recording { every, chosen: chosen_steps(&chosen, origin, h, steps)? };
        let processes = system.noises();
        // A deterministic system asks its noise for nothing.
        let mut noise = noise.filter(|_| processes > 0);
        match &mut noise {
            Some(noise) => noise.prepare(&H::PLAN, h, processes, origin)?,
            None if processes > 0 => return Err(ConfigError::Missing(NOISE).into()),
            None => {}
        }
        if retry.most() > 0 && noise.as_ref().is_some_and(|noise| !noise.is_path()) {
            return Err(ConfigError::Setting(GIVEN.to_owned()).into());
        }
        let mut dw = vec![0.0; processes];
        let mut path = Sums::new(processes);
        let mut recorder = Recorder::new(&state, h, processes, &recording, steps)?;
        let mut keeper = keeping.open(
            &mut walker.stepper,
            &mut state,
            &mut recorder,
            &mut path,
            noise.as_ref(),
            (steps, retry),
        )?;
        let mut begin = keeper.first();
        'run: loop {
            let first = begin;
            if first == 0 {
                let node =
                    Node { step: 0, wiener: path.totals(), increments: &dw, iterations: 0, halvings: 0 };
                observer.observe(&state, &node);
            }
            for step in first..steps {
                let interval = Interval { start: origin, h, step };
                let info = match walker.step(&mut state, &interval, &mut noise, &mut dw) {
                    Ok(info) => info,
                    // A run that is kept does not start again: its file says that it went this far.
                    Err(error) if !keeper.keeps() && walker.refine(&error)? => {
                        state = start.clone();
                        dw.fill(0.0);
                        path = Sums::new(processes);
                        recorder = Recorder::new(&state, h, processes, &recording, steps)?;
                        begin = 0;
                        continue 'run;
                    }
                    Err(error) => return Ok((finish(recorder, state), Some(error))),
                };
                recorder.step(&dw, &info);
                let node = step + 1;
                let seen = recorder.reach(&state) || node == steps;
                if O::LOOKS || keeper.keeps() {
                    path.add(&dw);
                    if O::LOOKS && seen {
                        let StepInfo { iterations, halvings, .. } = info;
                        let wiener = path.totals();
                        let node = Node { step: node, wiener, increments: &dw, iterations, halvings };
                        observer.observe(&state, &node);
                    }
                }
                if keeper.is_due(node)
                    && let Err(error) =
                        keeper.save(&mut walker.stepper, &mut state, &mut recorder, &mut path, node)
                {
                    return Ok((finish(recorder, state), Some(error)));
                }
            }
            return Ok((finish(recorder, state), None));
        }
    }
}

const START: &str = "a start: add `.start(State::new(q, p))`";
const END: &str = "an end: add `.until(time)` or `.steps(number)`";
const NOISE: &str = "increments for the noises of the system: add `.noise(...)` with a seeded source or \
                     `Increments::from(...)`";

const GIVEN: &str = "`.retry(...)` needs increments between the nodes, which these do not have: use `Wiener` or \
                     `WongZakai`, or leave `.retry(...)` out";

pub(crate) fn checked<H: Discretized<E>, E>(
    system: &H,
    start: Option<State<H::Vector>>,
) -> Result<State<H::Vector>, ConfigError> {
    let state = start.ok_or(ConfigError::Missing(START))?;
    let (q, p) = (state.q.components(), state.p.components());
    // Where only the state knows the size, the momenta have to match the coordinates.
    let expected = if system.fits(q.len()) { q.len() } else { system.degrees() };
    for got in [q.len(), p.len()] {
        if !system.fits(got) || got != q.len() {
            return Err(ConfigError::Start(StepFailure::Dimension { expected, got }));
        }
    }
    system.check(q.len()).map_err(ConfigError::Start)?;
    if q.iter().chain(p).chain([&state.t]).all(|x| x.is_finite()) {
        Ok(state)
    } else {
        Err(ConfigError::Start(StepFailure::NonFiniteInput))
    }
}

pub(crate) fn count(end: Option<End>, start: f64, h: f64) -> Result<u64, ConfigError> {
    match end.ok_or(ConfigError::Missing(END))? {
        End::Time(end) => steps_between(start, end, h).ok_or(ConfigError::End { start, end, h }),
        End::Steps(steps) if steps <= MOST_STEPS => Ok(steps),
        End::Steps(steps) => Err(ConfigError::End { start, end: start + steps as f64 * h, h }),
    }
}

/// The steps before the nodes at these times, in order: each the first at or beyond it.
pub(crate) fn chosen_steps(times: &[f64], start: f64, h: f64, steps: u64) -> Result<Vec<u64>, ConfigError> {
    let step = |&time: &f64| match steps_between(start, time, h) {
        Some(step) if step <= steps => Ok(step),
        _ => {
            let end = start + steps as f64 * h;
            let wrong = format!("recorded at t = {time}, which is not between {start} and {end}");
            Err(ConfigError::Setting(wrong))
        }
    };
    let mut chosen: Vec<u64> = times.iter().map(step).collect::<Result<_, _>>()?;
    chosen.sort_unstable();
    chosen.dedup();
    Ok(chosen)
}

/// `⌈(end - start)/h⌉`, or the integer that the quotient would be but for rounding; `None` if it is negative, NaN or
/// more than can be counted.
pub(crate) fn steps_between(start: f64, end: f64, h: f64) -> Option<u64> {
    let quotient = (end - start) / h;
    // One rounding each in start, end, their difference, h and the quotient, and one to spare.
    let allowance = 2.0 * f64::EPSILON * (quotient + (start.abs() + end.abs()) / h.abs());
    let nearest = quotient.round();
    let steps = if (quotient - nearest).abs() <= allowance { nearest } else { quotient.ceil() };
    // Also false for NaN.
    (quotient >= 0.0 && steps <= MOST_STEPS as f64).then_some(steps as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_counted_despite_rounding() {
        assert_eq!(steps_between(0.0, 20.0, 0.02), Some(1000));
        assert_eq!(steps_between(0.0, 0.3, 0.1), Some(3)); // 2.9999999999999996
        assert_eq!(steps_between(0.1, 0.7, 0.1), Some(6)); // 5.999999999999999
        assert_eq!(steps_between(0.1 + 0.2, 0.9, 0.3), Some(2));
        assert_eq!(steps_between(0.0, 1.0, 0.3), Some(4));
        assert_eq!(steps_between(0.0, 1.0 + 1e-12, 0.25), Some(5));
        assert_eq!(steps_between(0.0, 1e-17, 1.0), Some(1));
        assert_eq!(steps_between(2.0, 2.0, 0.1), Some(0));
        assert_eq!(steps_between(1.0, -1.0, -0.5), Some(4));
        for n in 1..2000_u32 {
            for h in [0.1, 0.02, 1e-3, 1.0 / 3.0, 0.7] {
                for t0 in [0.0, 0.1, -17.3, 1e3] {
                    assert_eq!(
                        steps_between(t0, t0 + f64::from(n) * h, h),
                        Some(u64::from(n)),
                        "{t0} {n} {h}"
                    );
                }
            }
        }
    }

    #[test]
    fn ends_that_cannot_be_reached_are_refused() {
        let (nan, inf) = (f64::NAN, f64::INFINITY);
        for (start, end, h) in
            [(0.0, -1.0, 0.1), (0.0, 1.0, -0.1), (0.0, nan, 0.1), (0.0, inf, 0.1), (0.0, 1e300, 1e-300)]
        {
            assert_eq!(steps_between(start, end, h), None, "{start} {end} {h}");
        }
        assert_eq!(steps_between(0.0, 9_007_199_254_740_994.0, 1.0), None);
    }
}
