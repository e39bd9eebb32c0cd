//! Embeddings as values, so that a list can hold several types.
//!
//! Tested by `tests/paths/report/estimators.rs`.

use std::hint::black_box;
use std::time::{Duration, Instant};

use super::noise::Shifted;
use crate::algebra::state::{State, Vector};
use crate::algebra::state_sum::StateSum;
use crate::ensemble::Ensemble;
use crate::error::{ConfigError, NoiseError};
use crate::ground::names::short_name;
use crate::increments::{Interval, Noise};
use crate::scheme::plan::Plan;
use crate::scheme::system::{Discretized, Hamiltonian};
use crate::trajectory::Error;
use crate::trajectory::recorded::Iterations;
use crate::trajectory::simulate::{Node, Simulation};
use crate::trajectory::step::Stepper;
use crate::trajectory::steps::SinglePath;

/// Sees a path, by its number in the run, at a recorded node.
type NodeObserver<'a, V> = &'a (dyn Fn(u64, &State<V>) + Sync);

/// Paths to run, one after the other or in lanes.
pub(super) struct PathBatch<'a, 'n, V> {
    pub(super) start: &'a State<V>,
    pub(super) h: f64,
    pub(super) steps: u64,
    /// Nodes that are seen, besides the start and the end: every so many; 0 for none.
    pub(super) stride: u64,
    /// How many.
    pub(super) number: u64,
    pub(super) noise: Shifted<'n>,
}

/// Runs paths and passes their recorded nodes to the last argument; returns the error of the first path that
/// failed. `None` if Ctrl-C stopped the run. Its own errors are not those of a step.
type RunPaths<H, V> =
    fn(&H, PathBatch<'_, '_, V>, NodeObserver<'_, V>) -> Result<Option<Option<Error>>, Error>;

/// How long several paths take, one after the other, so many times over, and the Newton iterations of one
/// pass; nothing but steps is inside.
type TimePaths<H, V> = fn(&H, &[TimedPath<'_, V>], u32) -> Result<(Duration, Iterations), Error>;

/// One embedding of a system.
pub(super) struct MeasuredScheme<H: Hamiltonian> {
    /// The embedding as it is written, `Corrected<DeltaPlus>`.
    pub(super) name: String,
    /// The facts that the compiler derived.
    pub(super) plan: Plan,
    /// How many numbers drive a step of so many degrees of freedom.
    pub(super) increments: fn(&H, usize) -> usize,
    pub(super) run: RunPaths<H, H::Vector>,
    pub(super) time: TimePaths<H, H::Vector>,
}

impl<H: Hamiltonian> MeasuredScheme<H> {
    /// The embedding `E`.
    pub(super) fn of<E>() -> Self
    where
        H: Discretized<E> + Sync,
    {
        Self {
            name: short_name::<E>(),
            plan: H::PLAN,
            increments: H::increments,
            run: run::<H, E>,
            time: time::<H, E>,
        }
    }
}

/// A path to take: where from, in which steps.
pub(super) struct TimedPath<'a, V> {
    pub(super) start: &'a State<V>,
    pub(super) h: f64,
    pub(super) steps: usize,
    /// Rows of the increments of a step; empty without noise.
    pub(super) increments: &'a [f64],
}

/// Increments that were drawn before, one row per step.
struct DrawnIncrements<'a>(&'a [f64]);

impl Noise for DrawnIncrements<'_> {
    #[inline]
    fn increments(&mut self, interval: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        let first = interval.step as usize * dw.len();
        match self.0.get(first..first + dw.len()) {
            Some(row) => {
                dw.copy_from_slice(row);
                Ok(())
            }
            None => Err(NoiseError::Exhausted {
                step: interval.step,
                available: self.0.len().checked_div(dw.len()).unwrap_or(0),
            }),
        }
    }
}

/// One path without noise as a single run, which adds with care; paths with noise as an ensemble.
fn run<H: Discretized<E> + Sync, E>(
    system: &H,
    paths: PathBatch<'_, '_, H::Vector>,
    see: NodeObserver<'_, H::Vector>,
) -> Result<Option<Option<Error>>, Error> {
    let PathBatch { start, h, steps, stride, number, noise } = paths;
    if system.increments(start.q.components().len()) == 0 {
        let run = Simulation::<H, E>::new(system, h).start(start.clone()).steps(steps);
        let run = run.record_every(if stride == 0 { steps.max(1) } else { stride });
        let run = run.inspect(|state: &State<H::Vector>, _: &Node<'_>| see(0, state));
        let (_, failure) = run.run_partial()?;
        return Ok(Some(failure));
    }
    let run = Ensemble::<H, E>::new(system, h).start(start.clone()).paths(number).noise(noise).steps(steps);
    let run = run.record_every(stride).allow_losses(1.0).covariances(false).threads(1).quiet();
    match run.observe("t", |state| state.t).inspect(see).run() {
        Ok(statistics) if statistics.is_partial() => Ok(None),
        Ok(statistics) => {
            let first = statistics.failures().first();
            Ok(Some(first.map(|failure| failure.error.into())))
        }
        Err(error @ Error::Step(_)) => Ok(Some(Some(error))),
        Err(error) => Err(error),
    }
}

fn time<H: Discretized<E>, E>(
    system: &H,
    paths: &[TimedPath<'_, H::Vector>],
    passes: u32,
) -> Result<(Duration, Iterations), Error> {
    // As they are run for their errors.
    let processes = paths.first().map_or(0, |path| system.increments(path.start.q.components().len()));
    if processes == 0 {
        timed(paths, (0, passes), |h| Stepper::<H, E>::new(system, h))
    } else {
        timed(paths, (processes, passes), |h| Ok(Stepper::<H, E>::new(system, h)?.plain()))
    }
}

/// How long paths of so many processes take, so many times over.
fn timed<'a, H: Discretized<E> + 'a, E, C: StateSum<f64>>(
    paths: &[TimedPath<'_, H::Vector>],
    (processes, passes): (usize, u32),
    stepper: impl Fn(f64) -> Result<Stepper<'a, H, E, C>, ConfigError>,
) -> Result<(Duration, Iterations), Error> {
    let mut steppers = paths.iter().map(|path| stepper(path.h)).collect::<Result<Vec<_>, _>>()?;
    let mut counts = Iterations::default();
    let Some(first) = paths.first() else { return Ok((Duration::ZERO, counts)) };
    let (mut state, mut dw) = (first.start.clone(), vec![0.0; processes]);
    let begin = Instant::now();
    for _ in 0..passes {
        counts = Iterations::default();
        for (path, stepper) in paths.iter().zip(&mut steppers) {
            state.clone_from(path.start);
            let mut rows = (processes > 0).then_some(DrawnIncrements(path.increments));
            let mut single = SinglePath {
                stepper,
                state: &mut state,
                noise: &mut rows,
                dw: &mut dw,
                first: Interval { start: path.start.t, h: path.h, step: 0 },
            };
            // Only paths that were seen to reach the end are timed.
            for step in 0..path.steps as u64 {
                let (stepper, step) = single.step(step);
                counts.count(&stepper.take_step(step)?);
            }
            black_box(&state);
        }
    }
    Ok((begin.elapsed(), counts))
}
