//! A run of which only the steps are of interest.

use super::{Simulation, Summation, Unobserved};
use crate::algebra::memory::Threads;
use crate::algebra::state::{State, Vector};
use crate::algebra::state_sum::StateSum;
use crate::error::{ConfigError, StoppedError};
use crate::ground::progress::StepsShown;
use crate::increments::Noise;
use crate::scheme::poles;
use crate::scheme::system::Discretized;
use crate::trajectory::Error;
use crate::trajectory::made_settings::MadeSetting::{self, Handle, StopWhen, Unwatched};
use crate::trajectory::options::{Execution, RunSetup};
use crate::trajectory::retry::{Retry, Subdivision};
use crate::trajectory::span::NodeGrid;
use crate::trajectory::steps::{SinglePath, StepToTake};

/// A run of steps alone: its stepper and its start, without records.
pub(crate) struct StepsOnly<'a, H: Discretized<E>, E, N, C> {
    pub(crate) system: &'a H,
    pub(crate) h: f64,
    pub(crate) start: State<H::Vector>,
    pub(crate) grid: NodeGrid,
    whole: Subdivision<'a, H, E, C>,
    noise: Option<N>,
    /// The settings that show the progress of the run, and stop it.
    execution: Execution<'a>,
    /// The number of its runs in all, and the steps of those before the present one.
    pub(crate) runs: u64,
    done: u64,
}

impl<'a, H, E, N, S> Simulation<'a, H, E, N, Unobserved, S>
where
    H: Discretized<E>,
    N: Noise,
    S: Summation<H, E>,
{
    /// The steps of the run, for the method `what`; whether a handle or a function `may_stop` it.
    ///
    /// # Errors
    /// [`ConfigError::Setting`](crate::error::ConfigError::Setting) for settings that the method has no use
    /// for.
    pub(crate) fn bare(self, what: &str, may_stop: bool) -> Result<StepsOnly<'a, H, E, N, S::Sum>, Error> {
        let Self { setup, noise, observer: Unobserved, .. } = self;
        if H::PROPERTIES.is_clocked {
            return Err(by_clock(what).into());
        }
        let used: &[_] = if may_stop { &[Unwatched, Handle, StopWhen] } else { &[Unwatched] };
        MadeSetting::refuse(what, setup.made(), used)?;
        let RunSetup { system, h, span, retry, is_watched, execution, .. } = setup;
        let mut whole = Subdivision::new(system, h, retry, is_watched, Threads::asked(execution.threads)?)?;
        let (start, grid) = span.checked::<H, E>(system, h)?;
        whole.watch.ends_after(grid.whole());
        let processes = system.increments(start.q.components().len());
        let noise = grid.prepared(noise, &H::PLAN, processes, retry)?;
        if let Some(noise) = &noise {
            poles::check::<H, E>(system, &start, h, &|h| noise.largest_increment(h))?;
        }
        let execution = Execution { is_quiet: execution.is_quiet || !may_stop, ..execution };
        Ok(StepsOnly { system, h, start, whole, grid, noise, execution, runs: 1, done: 0 })
    }
}

/// The refusal of a method that takes constant steps.
fn by_clock(what: &str) -> ConfigError {
    ConfigError::Setting(format!(
        "`{what}` of a scheme with a clock: it takes constant steps; run the scheme inside of `Clocked` in steps of a size, \
         with `retry` where they are long"
    ))
}

impl<'a, H: Discretized<E>, E, N: Noise, C: StateSum<f64>> StepsOnly<'a, H, E, N, C> {
    /// Takes all steps by `take`, which finds the size of each in [`Subdivision::size`]; returns the end.
    ///
    /// # Errors
    /// The first one of a step.
    pub(super) fn run(
        mut self,
        take: impl FnMut(&mut Subdivision<'a, H, E, C>, StepToTake<'_, H::Vector, N>) -> Result<(), Error>,
    ) -> Result<State<H::Vector>, Error> {
        let start = self.start.clone();
        self.run_from(start, take)
    }

    /// The run from another state, at the time of the start.
    ///
    /// # Errors
    /// The first one of a step; [`Error::Stopped`].
    pub(crate) fn run_from(
        &mut self,
        mut state: State<H::Vector>,
        mut take: impl FnMut(&mut Subdivision<'a, H, E, C>, StepToTake<'_, H::Vector, N>) -> Result<(), Error>,
    ) -> Result<State<H::Vector>, Error> {
        let Self { system, whole, grid, noise, execution, runs, done, .. } = self;
        let all = grid.steps.saturating_mul(*runs);
        let stop = execution.stop.clone();
        let stop = stop.as_deref().map(|stop| stop as &dyn Fn() -> bool);
        let Execution { is_quiet, handle, .. } = &*execution;
        let mut shown = StepsShown::new(*is_quiet, handle.clone(), stop, [*done, all]).with_those_before();
        let mut due = shown.next_node();
        let mut dw = vec![0.0; system.increments(state.q.components().len())];
        let mut path =
            SinglePath { stepper: &mut *whole, state: &mut state, noise, dw: &mut dw, first: grid.first() };
        for (numbers, size) in grid.from(0) {
            path.stepper.resize(size)?;
            for step in numbers {
                let (whole, step) = path.step(step);
                let node = *done + step.interval.step + 1;
                take(whole, step)?;
                if node >= due {
                    if shown.at_node(node) {
                        return Err(StoppedError { done: node, all }.into());
                    }
                    due = shown.next_node();
                }
            }
        }
        path.state.t = grid.end.unwrap_or(path.state.t);
        whole.arrive(&state, grid)?;
        *done += grid.steps;
        Ok(state)
    }

    /// Prepares one more run: its steps know nothing of those before.
    ///
    /// # Errors
    /// The errors of the first run.
    pub(crate) fn begin_again(&mut self) -> Result<(), Error> {
        self.whole = self.whole.anew()?;
        Ok(())
    }

    /// Whether increments drive the steps.
    pub(crate) fn is_driven(&self) -> bool {
        self.noise.is_some()
    }

    /// Goes to another path of the noise, so many further on; false where it has one path only.
    ///
    /// # Errors
    /// The errors of a noise that cannot serve the run.
    pub(crate) fn skip_paths(&mut self, paths: u64) -> Result<bool, Error> {
        if !self.noise.as_mut().is_some_and(|noise| noise.skip_paths(paths)) {
            return Ok(false);
        }
        let processes = self.system.increments(self.start.q.components().len());
        self.noise = self.grid.prepared(self.noise.take(), &H::PLAN, processes, Retry::never())?;
        Ok(true)
    }
}
