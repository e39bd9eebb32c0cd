//! Errors over paths, on all threads: blocks of paths, whose results are taken in the order of their numbers.
//!
//! Tested by `tests/paths/report/estimators.rs`.

use std::ops::{ControlFlow, Range};
use std::sync::{Mutex, PoisonError};

use super::data::{Cell, Weak};
use super::measure::{Reference, WorkPrecision};
use super::measurement::{MeasurementProgress, MeasurementSettings, SchemeRun, TIMED_STEPS};
use super::method::{MeasuredScheme, PathBatch};
use super::statistics::{Estimate, Trend};
use crate::algebra::state::{State, Vector};
use crate::ensemble::schedule::in_order;
use crate::error::InternalError;
use crate::noise::{Driver as _, Paths as _};
use crate::scheme::system::Hamiltonian;
use crate::trajectory::Error;

/// Approximate number of nodes of a path at which the energy is evaluated.
const LOOKS: u64 = 256;

/// Paths in a block at least, if there are as many for each thread.
const LANES: u64 = 8;

/// The outcomes of the paths of one scheme and step size.
#[derive(Default)]
struct PathOutcomes {
    good: Vec<FinishedPath>,
    failures: usize,
    failure: Option<String>,
}

/// A path that reached the end.
struct FinishedPath {
    number: u64,
    error: f64,
    trend: Trend,
    /// For each observable.
    weak: Vec<f64>,
}

impl PathOutcomes {
    /// The paths of both, which follow each other in number.
    fn append(&mut self, other: Self) {
        self.good.extend(other.good);
        self.failures += other.failures;
        self.failure = self.failure.take().or(other.failure);
    }

    /// A number of each path.
    fn each(&self, of: impl Fn(&FinishedPath) -> f64) -> Vec<f64> {
        self.good.iter().map(of).collect()
    }
}

/// The energies and the end of one path.
struct PathObservation<V> {
    /// Times since the start and energies against it.
    energies: Vec<(f64, f64)>,
    /// The last node.
    last: Option<State<V>>,
}

impl<V> Default for PathObservation<V> {
    fn default() -> Self {
        Self { energies: Vec::new(), last: None }
    }
}

/// Observations of paths from several threads.
struct PathObservations<V>(Vec<Mutex<PathObservation<V>>>);

impl<V: Vector> PathObservations<V> {
    fn new(paths: u64) -> Self {
        Self((0..paths).map(|_| Mutex::default()).collect())
    }

    /// A path at a node, with its energy.
    fn observe(&self, path: u64, state: &State<V>, point: Option<(f64, f64)>) {
        let seen = usize::try_from(path).ok().and_then(|path| self.0.get(path));
        debug_assert!(seen.is_some(), "path {path} of {}", self.0.len());
        if let Some(seen) = seen {
            let mut seen = seen.lock().unwrap_or_else(PoisonError::into_inner);
            seen.energies.extend(point);
            match &mut seen.last {
                Some(last) => last.clone_from(state),
                none => *none = Some(state.clone()),
            }
        }
    }

    /// The paths, in order.
    fn paths(self) -> impl Iterator<Item = PathObservation<V>> {
        self.0.into_iter().map(|seen| seen.into_inner().unwrap_or_else(PoisonError::into_inner))
    }
}

impl<'a, H> WorkPrecision<'a, H>
where
    H: Hamiltonian + Sync,
{
    /// The states of the reference at the end of all paths.
    pub(super) fn references(
        &self,
        plan: &MeasurementSettings<H::Vector>,
        work: &mut MeasurementProgress,
        stopped: &(dyn Fn() -> bool + Sync),
    ) -> Result<Vec<State<H::Vector>>, Error> {
        let mut states = Vec::with_capacity(plan.paths);
        let no_reference = || InternalError::new("a measurement has a reference", &self.title);
        let reference = self.reference.value().ok_or_else(no_reference)?;
        let block = |paths| self.ends(plan, reference, paths);
        self.in_blocks(plan, plan.reference_steps, stopped, block, |block| {
            work.add_steps(plan.reference_steps * block.len());
            states.extend(block);
        })?;
        Ok(states)
    }

    /// Does `block` for blocks of paths of so many steps, which are taken in order, until it is stopped.
    fn in_blocks<T: Send>(
        &self,
        plan: &MeasurementSettings<H::Vector>,
        steps: usize,
        stopped: &(dyn Fn() -> bool + Sync),
        block: impl Fn(Range<u64>) -> Result<Option<T>, Error> + Sync,
        mut take: impl FnMut(T) + Send,
    ) -> Result<(), Error> {
        let paths = plan.paths as u64;
        // As many paths as fill the lanes, if that leaves some for each thread.
        let beside = LANES.min(paths.div_ceil(plan.threads as u64));
        let size = (TIMED_STEPS.div_ceil(steps.max(1)) as u64).max(beside);
        let mut failed = Ok(());
        in_order(
            0..paths.div_ceil(size),
            plan.threads,
            |number| (!stopped()).then(|| block(number * size..paths.min((number + 1) * size))),
            |_, result| match result {
                Some(Ok(Some(result))) => {
                    take(result);
                    ControlFlow::Continue(())
                }
                Some(Err(error)) => {
                    failed = Err(error);
                    ControlFlow::Break(())
                }
                None | Some(Ok(None)) => ControlFlow::Break(()),
            },
        );
        failed
    }

    /// The ends of the paths of the reference; `None` if it was stopped.
    fn ends(
        &self,
        plan: &MeasurementSettings<H::Vector>,
        reference: &Reference<'a, H>,
        paths: Range<u64>,
    ) -> Result<Option<Vec<State<H::Vector>>>, Error> {
        // A thermostat has one increment for each degree of freedom.
        let degrees = plan.start.q.components().len();
        let mut drawn = self.methods.iter().map(|method| (method.increments)(self.system, degrees));
        let of_bath = if drawn.any(|drawn| drawn > self.system.noises()) { degrees } else { 0 };
        let (start, processes) = (&plan.start, self.system.noises() + of_bath);
        let mut wiener = self.wiener(0);
        let ends: Result<Vec<_>, Error> = match reference {
            Reference::Exact(exact) => paths
                .map(|path| {
                    wiener.set_path(path);
                    let ends = (0..processes).map(|k| wiener.increment(k, start.t, plan.end));
                    Ok(exact(plan.end, &ends.collect::<Result<Vec<f64>, _>>()?))
                })
                .collect(),
            Reference::OnPath(exact) => paths
                .map(|path| {
                    wiener.set_path(path);
                    exact(plan.end, &mut wiener)
                })
                .collect(),
            Reference::Finer(method, h) => {
                let (seen, number) =
                    (PathObservations::new(paths.end - paths.start), paths.end - paths.start);
                let noise = self.shifted(wiener.copy(), paths.start, start);
                let run =
                    PathBatch { start, h: *h, steps: plan.reference_steps as u64, stride: 0, number, noise };
                let see = |path, state: &State<H::Vector>| seen.observe(path, state, None);
                match (method.run)(self.system, run, &see)? {
                    None => return Ok(None),
                    Some(Some(failure)) => return Err(failure),
                    Some(None) => {}
                }
                let missing = || InternalError::new("a path that did not fail has an end", &self.title);
                seen.paths().map(|seen| Ok(seen.last.ok_or_else(missing)?)).collect()
            }
            Reference::Value(state) => Ok(paths.map(|_| state.clone()).collect()),
        };
        ends.map(Some)
    }

    /// Errors of one scheme and step size over the paths; `None` if there was time for no path at all.
    pub(super) fn accuracy(
        &self,
        plan: &MeasurementSettings<H::Vector>,
        run: &SchemeRun,
        references: &[State<H::Vector>],
        work: &mut MeasurementProgress,
        stopped: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Cell>, Error> {
        let method = self.method_of(run)?;
        let mut found = PathOutcomes::default();
        let block = |paths| self.block(plan, run, method, references, paths);
        self.in_blocks(plan, run.steps, stopped, block, |block: PathOutcomes| {
            work.add_steps(run.steps * (block.good.len() + block.failures));
            found.append(block);
        })?;
        if found.good.is_empty() && found.failures == 0 {
            return Ok(None);
        }
        let weak = self.observables.0.iter().enumerate().map(|(place, ((name, _), _))| Weak {
            observable: name.clone(),
            bias: Estimate::mean(&found.each(|path| path.weak[place])),
        });
        let (errors, span) = (found.each(|path| path.error), plan.end - plan.start.t);
        Ok(Some(Cell {
            scheme: method.name.clone(),
            h: run.h,
            steps: run.steps,
            paths: found.good.len(),
            failures: found.failures,
            strong: Estimate::root_mean_square(&errors),
            weak: weak.collect(),
            energy_trend: Estimate::root_mean_square(&found.each(|path| path.trend.slope * span)),
            energy_oscillation: Estimate::root_mean_square(&found.each(|path| path.trend.oscillation)),
            iterations: 0.0,
            largest_iterations: 0,
            path_numbers: found.good.iter().map(|path| path.number).collect(),
            failure: found.failure,
            time: None,
            noise_time: None,
            errors,
            times: vec![],
            noise_times: vec![],
        }))
    }

    /// Paths that have a reference, beside each other; `None` if they were stopped.
    fn block(
        &self,
        plan: &MeasurementSettings<H::Vector>,
        run: &SchemeRun,
        method: &MeasuredScheme<H>,
        references: &[State<H::Vector>],
        paths: Range<u64>,
    ) -> Result<Option<PathOutcomes>, Error> {
        let (system, start) = (self.system, &plan.start);
        let mut found = PathOutcomes::default();
        // A run that was stopped has fewer references than paths.
        let place = |path: u64| usize::try_from(path).unwrap_or(usize::MAX).min(references.len());
        let exact = references.get(place(paths.start)..place(paths.end)).unwrap_or_default();
        let (number, steps) = (exact.len() as u64, run.steps as u64);
        if number == 0 {
            return Ok(Some(found));
        }
        let seen = PathObservations::new(number);
        let first = system.energy(start);
        let see = |path, state: &State<H::Vector>| {
            seen.observe(path, state, Some((state.t - start.t, system.energy(state) - first)));
        };
        let noise = self.shifted((self.driver)(self.wiener(0)), paths.start, start);
        let stride = steps.div_ceil(LOOKS);
        let end = start.t + steps as f64 * run.h;
        let outcome = (method.run)(system, PathBatch { start, h: run.h, steps, stride, number, noise }, &see);
        found.failure = match outcome {
            Ok(None) => return Ok(None),
            Ok(Some(failure)) => failure.map(|error| error.to_string()),
            // A step size that cannot be prepared.
            Err(error @ Error::Config(_)) => Some(error.to_string()),
            Err(error) => return Err(error),
        };
        for ((path, seen), exact) in (paths.start..).zip(seen.paths()).zip(exact) {
            let Some(last) = seen.last.filter(|last| last.t == end) else {
                found.failures += 1;
                continue;
            };
            let weak = self.observables.0.iter();
            let weak = weak.map(|((_, expectation), f)| f(&last) - expectation.unwrap_or_else(|| f(exact)));
            found.good.push(FinishedPath {
                number: path,
                error: distance(&last, exact),
                trend: Trend::of(&seen.energies),
                weak: weak.collect(),
            });
        }
        Ok(Some(found))
    }
}

/// Euclidean distance in (q, p).
fn distance<V: Vector>(a: &State<V>, b: &State<V>) -> f64 {
    let parts = [(&a.q, &b.q), (&a.p, &b.p)];
    let pairs = parts.iter().flat_map(|(a, b)| a.components().iter().zip(b.components()));
    pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}
