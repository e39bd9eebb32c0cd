//! A run that keeps no path: its nodes are averaged over, until that is enough.

use std::ops::ControlFlow;
use std::time::Duration;

use super::{Observer, OnePath, Records, Run, Simulation, prepared};
use crate::algebra::memory::Threads;
use crate::algebra::state::{State, Vector};
use crate::error::{ConfigError, FileError};
use crate::ground::due::Due;
use crate::ground::progress::StepsShown;
use crate::increments::Noise;
use crate::path::Error;
use crate::path::checkpoint::Keeper;
use crate::path::recording::Recording;
use crate::path::retry::{Serves, Subdivision};
use crate::path::series::{Observed, Tally};
use crate::path::steps::{Monitor, Single, take_steps};
use crate::path::trajectory::Recorder;
use crate::scheme::system::{Discretized, Exchange};

/// Where such a run ended.
pub(crate) struct End<V> {
    pub(crate) last: State<V>,
    pub(crate) steps: u64,
    pub(crate) exchanged: Exchange,
    /// Whether somebody stopped it.
    pub(crate) is_stopped: bool,
    pub(crate) unsaved: Option<FileError>,
}

/// Why it ended before its end.
enum Halt {
    Enough(u64),
    Stopped(u64),
    Failed(Error),
}

impl From<Error> for Halt {
    fn from(error: Error) -> Self {
        Self::Failed(error)
    }
}

/// Between two questions whether to stop.
const PAUSE: Duration = Duration::from_millis(100);

/// Averages over every `stride`-th node, and saves the run.
struct Visitor<'k, 'a, V> {
    start: f64,
    tally: &'k mut Tally<'a, V>,
    keeper: &'k mut Keeper,
    shown: StepsShown,
    stop: &'k dyn Fn() -> bool,
    asks: Due,
}

impl<'s, 'a, H, E, N> Monitor<OnePath<'_, 's, H, E, N>> for Visitor<'_, 'a, H::Vector>
where
    H: Discretized<E>,
    N: Noise,
{
    type Error = Halt;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn next(&self, _: &OnePath<'_, 's, H, E, N>, node: u64) -> u64 {
        let value = (node / self.tally.stride + 1).saturating_mul(self.tally.stride);
        value.min(self.asks.next()).min(self.keeper.next()).min(self.shown.next())
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn look(&mut self, path: &mut OnePath<'_, 's, H, E, N>, node: u64) -> Result<(), Halt> {
        let has_value = node.is_multiple_of(self.tally.stride);
        let verdict = match has_value {
            true => self.tally.see(path.state, path.state.t - self.start),
            false => ControlFlow::Continue(()),
        };
        let is_stopped = self.shown.look(node);
        let halt = match verdict {
            ControlFlow::Break(()) => Some(Halt::Enough(node)),
            ControlFlow::Continue(()) if is_stopped || (self.asks.is_due(node) && self.is_stopped()) => {
                Some(Halt::Stopped(node))
            }
            ControlFlow::Continue(()) => None,
        };
        if self.keeper.is_due(node) || halt.is_some() {
            let Subdivision { stepper, watch, .. } = &mut *path.stepper;
            let mut run = Run::averaging(path.state, path.account, self.tally, watch);
            self.keeper.save_path(stepper, &mut run, node)?;
        }
        halt.map_or(Ok(()), Err)
    }
}

impl<V> Visitor<'_, '_, V> {
    fn is_stopped(&mut self) -> bool {
        self.asks.done();
        (self.stop)()
    }
}

impl<'a, H, E, N, O, R> Simulation<'a, H, E, N, O, R>
where
    H: Discretized<E>,
    N: Noise + Serves<R>,
    O: Observer<H::Vector>,
{
    /// Names and functions of the observables, which the run then has no more.
    pub(crate) fn take_observables(&mut self) -> Result<Observed<'a, H::Vector>, ConfigError> {
        std::mem::take(&mut self.setup.observables).checked("observables")
    }

    /// The step size, and how many steps there are from a node that is seen to the next.
    pub(crate) fn spacing(&self) -> (f64, u64) {
        (self.setup.h, self.setup.recorded.every.unwrap_or(1).max(1))
    }

    /// Runs the path, and shows its nodes to `tally`, until that has enough or `stop` says so.
    pub(crate) fn visit(
        self,
        tally: &mut Tally<'a, H::Vector>,
        stop: &dyn Fn() -> bool,
    ) -> Result<End<H::Vector>, Error> {
        let Self { setup, noise, .. } = self;
        let asked = [
            (!setup.recorded.times.is_empty(), "`record_at`"),
            (!setup.sections.is_empty(), "`section`"),
            (O::LOOKS, "`inspect`"),
            (setup.span.is_exact, "`exactly`"),
        ];
        if let Some((_, what)) = asked.iter().find(|(is_asked, _)| *is_asked) {
            return Err(
                ConfigError::Setting(format!("{what} in a run that keeps no path: leave it out")).into()
            );
        }
        let (system, h, retry, threads) =
            (setup.system, setup.h, setup.retry, Threads::asked(setup.threads)?);
        let mut stepper = Subdivision::<H, E>::new(system, h, retry, setup.is_watched, threads)?;
        let (mut state, grid) = setup.span.checked::<H, E>(system, h)?;
        let processes = system.increments(state.q.components().len());
        let mut noise = prepared::<H, E, N>(noise, &grid, processes)?;
        let recorder = Recorder::new(&state, h, processes, &Recording::default(), grid.steps)?;
        let mut account = Records::new(recorder, processes, setup.keeping.is_set());
        let mut keeper = setup.keeping.open_path(
            &mut stepper.stepper,
            &mut Run::averaging(&mut state, &mut account, tally, &mut stepper.watch),
            noise.as_ref(),
            (&grid, retry, &setup.sections),
        )?;
        let (first, mut dw) = (keeper.first(), vec![0.0; processes]);
        let has_enough = tally.has_enough();
        let mut path = Single {
            stepper: &mut stepper,
            state: &mut state,
            noise: &mut noise,
            dw: &mut dw,
            start: grid.start,
            h,
            account: &mut account,
        };
        let mut monitor = Visitor {
            start: grid.start,
            tally,
            keeper: &mut keeper,
            shown: StepsShown::new(setup.is_quiet, setup.handle, first, grid.steps),
            stop,
            asks: Due::new(None, Some(PAUSE), first, grid.steps),
        };
        let steps = if has_enough { first } else { grid.steps };
        let (steps, is_stopped) = match take_steps(&mut path, first..steps, &mut monitor) {
            Ok(()) => (steps, false),
            Err(Halt::Enough(node)) => (node, false),
            Err(Halt::Stopped(node)) => (node, node < grid.steps),
            Err(Halt::Failed(error)) => return Err(error),
        };
        let (exchanged, unsaved) = (stepper.stepper.exchanged(), keeper.unsaved());
        Ok(End { last: state, steps, exchanged, is_stopped, unsaved })
    }
}
