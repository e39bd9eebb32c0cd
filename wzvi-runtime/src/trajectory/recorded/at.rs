//! The state of a recorded path at any time, by a step of the scheme from the node before.
//!
//! The step from the node at `t_n` to a time `t < t_{n+1}` has the size `t - t_n`, and the error of one step.
//! With noise its increments are `W(t) - W(t_n)` of the path that drove the run: the Brownian bridge of the
//! step ([`Noise::increments_within`]). The state is then another than that of [dense
//! output](crate::scheme::dense), which follows the straight line from node to node of each `W_k`.

use super::Trajectory;
use crate::algebra::memory::Threads;
use crate::algebra::state::{State, Vector};
use crate::error::{StepError, wrong};
use crate::increments::{Interval, NoNoise, Noise, NoiseError};
use crate::scheme::clock::SideStepper;
use crate::scheme::system::{Discretized, Scheme, SchemeOf, SumOf, fits};
use crate::trajectory::Error;
use crate::trajectory::recorded::{ClockInterval, PathError};
use crate::trajectory::retry::{Retry, Subdivision};
use crate::trajectory::span::{NodeGrid, NodeOrInside};
use crate::trajectory::steps::StepToTake;

/// The message where the source of the increments is missing.
const SOURCE: &str = "a state between two nodes of a path with noise needs the source of its increments again: \
                      `path.at(&system).noise(source).state(t)`";

/// The scheme of side steps.
type Unclocked<H, E> = <SchemeOf<H, E> as Scheme<H>>::Unclocked;

/// A step of a path, with the size that it has.
struct StepOfPath {
    interval: Interval,
    h: f64,
    /// Whether it follows a clock.
    is_own: bool,
}

/// Asks a recorded path for its states: [`Trajectory::at`] begins it.
#[derive(Debug)]
#[must_use = "no state is computed before `state`"]
pub struct States<'p, H: Discretized<E>, E, N = NoNoise> {
    path: &'p Trajectory<H::Vector, E>,
    system: &'p H,
    noise: Option<N>,
}

impl<V: Vector, E> Trajectory<V, E> {
    /// The state at time `t` (time units of the Hamiltonian), between the first and the last node, without
    /// noise: that of a node, or that of a step of the scheme from the node or event before to `t`. Its error
    /// is of the order of the scheme. At the time of an event it is the state after it.
    ///
    /// ```ignore
    /// let path = pendulum.simulate::<Verlet>(0.01).start(start).until(10.0).run()?;
    /// let state = path.state_at(&pendulum, 3.456)?;
    /// ```
    ///
    /// # Errors
    /// The errors of [`States::state`].
    pub fn state_at<H: Discretized<E, Vector = V>>(&self, system: &H, t: f64) -> Result<State<V>, Error> {
        self.at(system).state(t)
    }

    /// Asks for states of the path at any time; `system` is the one of the run. With noise, its source is
    /// needed again:
    ///
    /// ```ignore
    /// let path = kubo.simulate::<Midpoint>(0.02).start(start).noise(Wiener::seed(7)).until(10.0).run()?;
    /// let state = path.at(&kubo).noise(Wiener::seed(7)).state(3.456)?;
    /// ```
    pub fn at<'p, H: Discretized<E, Vector = V>>(&'p self, system: &'p H) -> States<'p, H, E> {
        States { path: self, system, noise: None }
    }

    /// The state from which the path goes on to the time `t` without an event: that of a node, or that after
    /// the last event between.
    fn after_events<'p>(&'p self, node: &'p State<V>, t: f64) -> &'p State<V> {
        let sign = self.step_size().signum();
        // An event at a node is the first of what happens in the step after it.
        let is_between = |at: f64| sign * (at - node.t) >= 0.0 && sign * (at - t) <= 0.0;
        let last = self.events().iter().rev().find(|event| is_between(event.after.t));
        last.map_or(node, |event| &event.after)
    }

    /// The nodes of the run, recorded or not.
    fn grid(&self) -> NodeGrid {
        let path = &self.path;
        let start = path.states.first().map_or(f64::NAN, |state| state.t);
        NodeGrid {
            start,
            h: path.h,
            steps: path.steps,
            end: Some(path.last.t),
            shorter: path.shorter,
            is_clocked: false,
        }
    }

    /// The index of a node among the recorded states.
    fn index(&self, grid: &NodeGrid, node: u64) -> Option<usize> {
        let (sign, t) = (grid.h.signum(), grid.time(node));
        // The first one that is no more than half a step earlier.
        let near = self.states().partition_point(|state| sign * (state.t - t) < -0.5 * grid.h.abs());
        let found = self.states().iter().enumerate().skip(near);
        found
            .take_while(|(_, state)| sign * (state.t - t) < 0.5 * grid.h.abs())
            .find(|(_, state)| grid.place(state.t) == Some(NodeOrInside::Node(node)))
            .map(|(index, _)| index)
    }
}

impl<'p, H: Discretized<E>, E, N: Noise> States<'p, H, E, N> {
    /// The source of the increments of the run. It is asked for the path of each noise inside of a step,
    /// which [`Wiener`](crate::noise::Wiener), [`WongZakai`](crate::noise::WongZakai) and
    /// [`StepNormals`](crate::noise::StepNormals) know. States at several times are on one path.
    pub fn noise<M: Noise>(self, noise: M) -> States<'p, H, E, M> {
        States { path: self.path, system: self.system, noise: Some(noise) }
    }

    /// The state at time `t`.
    ///
    /// A step that was halved in the run ([`Retry`]) is halved here where it fails, as often as steps of the
    /// run were.
    ///
    /// # Errors
    /// * [`PathError::Outside`] for a time outside of the path, [`PathError::Unrecorded`] where the node
    ///   before it was not recorded, [`PathError::System`] if the path is not one of the system.
    /// * [`Error::Config`] where the system has noise and none was given.
    /// * [`Error::Noise`] of a source that has no increments inside of a step, and of one that did not drive
    ///   the run.
    /// * [`Error::Step`] if the step fails.
    pub fn state(&mut self, t: f64) -> Result<State<H::Vector>, Error> {
        let (path, system) = (self.path, self.system);
        let degrees = path.last().q.components().len();
        let processes = system.increments(degrees);
        if !fits(system, degrees) || path.processes() != processes {
            let [path, system] = [(degrees, path.processes()), (system.degrees(), processes)];
            return Err(PathError::System { path, system }.into());
        }
        if H::PROPERTIES.is_clocked {
            return self.state_by_clock(t);
        }
        let grid = path.grid();
        let place = grid.place(t);
        let outside = PathError::Outside { t, start: grid.start, end: path.last().t };
        let (NodeOrInside::Node(node) | NodeOrInside::Inside(node)) = place.ok_or(outside)?;
        let unrecorded = PathError::Unrecorded { t, every: path.stride() };
        let index = path.index(&grid, node).ok_or(unrecorded)?;
        let mut state = path.states()[index].clone();
        if place == Some(NodeOrInside::Node(node)) {
            return Ok(path.after_events(&state, state.t).clone());
        }
        let (interval, size) = (Interval { step: node, ..grid.first() }, grid.size(node));
        let from = path.after_events(&state, t);
        let uncut = path.path.uncut.filter(|_| node + 1 == grid.steps);
        if uncut.is_some() || !std::ptr::eq(from, &raw const state) {
            let h = uncut.unwrap_or(size);
            return self.side_step(from, StepOfPath { interval, h, is_own: false }, t);
        }
        let mut noise = self.inside(index, &interval, size)?;
        let halvings = Retry::halving(path.iterations().halvings);
        let mut step =
            Subdivision::<H, E, SumOf<H, E>>::new(system, grid.h, halvings, false, Threads::Caller)?;
        step.resize(t - state.t)?;
        let mut dw = vec![0.0; processes];
        step.take_step(StepToTake { state: &mut state, interval, noise: &mut noise, dw: &mut dw })?;
        state.t = t;
        Ok(state)
    }
}

impl<H: Discretized<E>, E, N: Noise> States<'_, H, E, N> {
    /// The state at time `t` of a path by a clock: by a side step from the node before.
    fn state_by_clock(&mut self, t: f64) -> Result<State<H::Vector>, Error> {
        let path = self.path;
        let (states, intervals, sign) = (path.states(), path.intervals(), path.step_size().signum());
        let [start, end] = [states.first().map_or(f64::NAN, |state| state.t), path.last().t];
        if !(sign * (t - start) >= 0.0 && sign * (end - t) >= 0.0) {
            return Err(PathError::Outside { t, start, end }.into());
        }
        let unrecorded = || PathError::Unrecorded { t, every: path.stride() };
        if intervals.len() as u64 != path.steps() {
            return Err(unrecorded().into());
        }
        let step = intervals.partition_point(|interval| sign * (interval.t - t) <= 0.0).saturating_sub(1);
        let Some(&ClockInterval { t: begin, h, .. }) = intervals.get(step) else {
            return Ok(path.last().clone());
        };
        let node = states.iter().find(|state| state.t == begin).ok_or_else(unrecorded)?;
        let h = path.path.uncut.filter(|_| step + 1 == intervals.len()).unwrap_or(h);
        let interval = Interval { start: begin, h, step: step as u64 };
        self.side_step(path.after_events(node, t), StepOfPath { interval, h, is_own: true }, t)
    }

    /// The state at time `t` by a side step from another state in the same step.
    fn side_step(
        &mut self,
        from: &State<H::Vector>,
        StepOfPath { interval, h, is_own }: StepOfPath,
        t: f64,
    ) -> Result<State<H::Vector>, Error> {
        let (path, system) = (self.path, self.system);
        let (mut at, mut dw) = (from.clone(), vec![0.0; path.processes()]);
        if from.t == t {
            return Ok(at);
        }
        if !dw.is_empty() {
            let Some(noise) = &mut self.noise else { return wrong(SOURCE) };
            let begin = if is_own { interval.start } else { interval.begin() };
            let part = [from.t, t].map(|t| (t - begin) / h);
            if is_own {
                noise.prepare(&H::PLAN, path.step_size(), dw.len(), path.states()[0].t)?;
                noise.increments_of_own_size(&interval, h, part, &mut dw)?;
            } else {
                noise.prepare(&H::PLAN, interval.h, dw.len(), interval.start)?;
                noise.increments_within(&interval, h, part, &mut dw)?;
            }
        }
        let (mut side, size) = (SideStepper::<H, Unclocked<H, E>>::default(), t - from.t);
        let step = side.step(system, from, size, &dw, &mut at);
        step.map_err(|cause| StepError { step: interval.step, t: from.t, h: size, cause })?;
        at.t = t;
        Ok(at)
    }

    /// The noise inside of a step of this size from the recorded state `index` on; none of a system without
    /// noise.
    ///
    /// # Errors
    /// The errors of [`States::state`].
    fn inside(
        &mut self,
        index: usize,
        interval: &Interval,
        size: f64,
    ) -> Result<Option<PartialNoise<'_, N>>, Error> {
        let path = self.path;
        let mut dw = vec![0.0; path.processes()];
        if dw.is_empty() {
            return Ok(None);
        }
        let Some(noise) = &mut self.noise else {
            return wrong(SOURCE);
        };
        noise.prepare(&H::PLAN, interval.h, dw.len(), interval.start)?;
        if size == interval.h {
            noise.increments(interval, &mut dw)?;
        } else {
            noise.increments_of_part(interval, size, &mut dw)?;
        }
        // Parts of a halved step may have velocities of their own.
        let next = path.index(&path.grid(), interval.step + 1).filter(|_| path.iterations().halved == 0);
        for (process, own) in dw.iter().enumerate().filter(|_| next.is_some()) {
            let rows = index..next.unwrap_or(index);
            let recorded: f64 = rows.map(|row| path.row(row)[process]).sum();
            // Roundings are far below, and another noise is off by √h.
            if (own - recorded).abs() > 1e-9 * size.abs().sqrt() {
                let step = interval.step;
                return Err(NoiseError::Setting(format!(
                    "this source did not drive the path: its increment of step {step} and noise {process} is {own}, that of the path {recorded}; \
                     give the source of the run, with its seed and path"
                ))
                .into());
            }
        }
        Ok(Some(PartialNoise { noise, size }))
    }
}

/// The noise of the first part of a step, as that of a last step that is shorter.
struct PartialNoise<'n, N> {
    noise: &'n mut N,
    /// The size of the whole step.
    size: f64,
}

impl<N: Noise> Noise for PartialNoise<'_, N> {
    fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        self.noise.increments(interval, dw)
    }

    fn increments_of_part(&mut self, interval: &Interval, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        self.increments_within(interval, h, [0.0, 1.0], dw)
    }

    fn increments_within(
        &mut self,
        interval: &Interval,
        h: f64,
        part: [f64; 2],
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        let share = h / self.size;
        self.noise.increments_within(interval, self.size, part.map(|fraction| fraction * share), dw)
    }
}
