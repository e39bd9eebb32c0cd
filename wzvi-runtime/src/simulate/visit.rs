//! A run that keeps nothing: its nodes are seen, and may end it.

use std::ops::ControlFlow;

use super::{Observer, Simulation, prepared};
use crate::error::{ConfigError, Error};
use crate::increments::Noise;
use crate::memory::Threads;
use crate::options::Observable;
use crate::retry::{Serves, Subdivision};
use crate::state::{State, Vector};
use crate::steps::{Monitor, Single, take_steps};
use crate::system::{Discretized, Exchange};

/// Where such a run ended.
pub(crate) struct End<V> {
    pub(crate) last: State<V>,
    pub(crate) steps: u64,
    pub(crate) exchanged: Exchange,
}

/// Why it ended before its end.
enum Halt {
    Enough(u64),
    Failed(Error),
}

impl From<Error> for Halt {
    fn from(error: Error) -> Self {
        Self::Failed(error)
    }
}

/// Shows every `stride`-th node.
struct Visitor<F> {
    start: f64,
    stride: u64,
    see: F,
}

impl<T, V, N, F> Monitor<Single<'_, T, V, N, ()>> for Visitor<F>
where
    for<'p> Single<'p, T, V, N, ()>: crate::steps::Advance<Error = Error>,
    F: FnMut(&State<V>, f64) -> ControlFlow<()>,
{
    type Error = Halt;

    #[inline(always)]
    fn next(&self, _: &Single<'_, T, V, N, ()>, node: u64) -> u64 {
        (node / self.stride + 1).saturating_mul(self.stride)
    }

    #[inline(always)]
    fn look(&mut self, path: &mut Single<'_, T, V, N, ()>, node: u64) -> Result<(), Halt> {
        match (self.see)(path.state, path.state.t - self.start) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Halt::Enough(node)),
        }
    }
}

/// Names and functions of the observables of a run.
type Named<'a, V> = (Vec<String>, Vec<Observable<'a, V>>);

impl<'a, H, E, N, O, R> Simulation<'a, H, E, N, O, R>
where
    H: Discretized<E>,
    N: Noise + Serves<R>,
    O: Observer<H::Vector>,
{
    /// Names and functions of the observables, which the run then has no more.
    pub(crate) fn take_observables(&mut self) -> Result<Named<'a, H::Vector>, ConfigError> {
        std::mem::take(&mut self.setup.observables).checked("observables")
    }

    /// The step size, and how many steps there are from a node that is seen to the next.
    pub(crate) fn spacing(&self) -> (f64, u64) {
        (self.setup.h, self.setup.recorded.every.unwrap_or(1).max(1))
    }

    /// Runs the path, and shows `see` the nodes with the time since the start, until it has seen enough.
    pub(crate) fn visit(
        self,
        see: impl FnMut(&State<H::Vector>, f64) -> ControlFlow<()>,
    ) -> Result<End<H::Vector>, Error> {
        let (_, stride) = self.spacing();
        let Self { setup, noise, .. } = self;
        let asked = [
            (!setup.recorded.times.is_empty(), "`record_at`"),
            (!setup.sections.is_empty(), "`section`"),
            (setup.keeping.is_set(), "`checkpoint`"),
            (O::LOOKS, "`inspect`"),
            (setup.span.is_exact, "`exactly`"),
        ];
        if let Some((_, what)) = asked.iter().find(|(is_asked, _)| *is_asked) {
            return Err(
                ConfigError::Setting(format!("{what} in a run that keeps no path: leave it out")).into()
            );
        }
        let (system, h, threads) = (setup.system, setup.h, Threads::asked(setup.threads)?);
        let mut stepper = Subdivision::<H, E>::new(system, h, setup.retry, setup.is_watched, threads)?;
        let (mut state, grid) = setup.span.checked::<H, E>(system, h)?;
        let processes = system.increments(state.q.components().len());
        let mut noise = prepared::<H, E, N>(noise, &grid, processes)?;
        let mut dw = vec![0.0; processes];
        let mut path = Single {
            stepper: &mut stepper,
            state: &mut state,
            noise: &mut noise,
            dw: &mut dw,
            start: grid.start,
            h,
            account: &mut (),
        };
        let mut monitor = Visitor { start: grid.start, stride, see };
        let steps = match take_steps(&mut path, 0..grid.steps, &mut monitor) {
            Ok(()) => grid.steps,
            Err(Halt::Enough(node)) => node,
            Err(Halt::Failed(error)) => return Err(error),
        };
        Ok(End { last: state, steps, exchanged: stepper.stepper.exchanged() })
    }
}
