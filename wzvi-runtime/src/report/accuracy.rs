//! Errors over paths, on all threads: blocks of paths, whose results are taken in the order of their numbers.

use std::ops::{ControlFlow, Range};

use super::data::{Cell, Weak};
use super::measure::{Reference, WorkPrecision};
use super::run::{Run, Settings, TIMED_STEPS, Work, draw};
use super::scheme::{Given, Outcome, Scheme};
use super::statistics::{Estimate, Trend};
use crate::error::{Error, InternalError};
use crate::increments::Noise as _;
use crate::noise::Paths;
use crate::schedule::in_order;
use crate::state::{State, Vector};
use crate::system::Hamiltonian;

/// Nodes of a path at which the energy is looked at, about.
const LOOKS: usize = 256;

/// What became of the paths of one scheme and step size.
#[derive(Default)]
struct Found {
    good: Vec<u64>,
    steps: u64,
    iterations: u64,
    largest: u32,
    errors: Vec<f64>,
    trends: Vec<f64>,
    oscillations: Vec<f64>,
    /// For each observable, what each path has.
    weak: Vec<Vec<f64>>,
    failures: usize,
    failure: Option<String>,
}

impl Found {
    fn new(observables: usize) -> Self {
        Self { weak: vec![vec![]; observables], ..Self::default() }
    }

    fn fail(&mut self, error: String) {
        self.failures += 1;
        self.failure.get_or_insert(error);
    }

    /// The paths of both, which follow each other in number.
    fn append(&mut self, other: Self) {
        self.good.extend(other.good);
        self.steps += other.steps;
        self.iterations += other.iterations;
        self.largest = self.largest.max(other.largest);
        self.errors.extend(other.errors);
        self.trends.extend(other.trends);
        self.oscillations.extend(other.oscillations);
        for (ours, theirs) in self.weak.iter_mut().zip(other.weak) {
            ours.extend(theirs);
        }
        self.failures += other.failures;
        self.failure = self.failure.take().or(other.failure);
    }
}

/// The states of a path at which the energy is looked at.
struct Energies {
    stride: usize,
    steps: usize,
    node: usize,
    start: f64,
    first: f64,
    /// Times since the start and energies against it.
    points: Vec<(f64, f64)>,
}

impl Energies {
    fn see<H: Hamiltonian>(&mut self, system: &H, state: &State<H::Vector>) {
        if self.node.is_multiple_of(self.stride) || self.node == self.steps {
            self.points.push((state.t - self.start, system.energy(state) - self.first));
        }
        self.node += 1;
    }
}

impl<'a, H> WorkPrecision<'a, H>
where
    H: Hamiltonian + Sync,
    H::Vector: Send + Sync,
{
    /// Where the paths end.
    pub(super) fn references(
        &self,
        plan: &Settings<H::Vector>,
        work: &mut Work,
        stopped: &(dyn Fn() -> bool + Sync),
    ) -> Result<Vec<State<H::Vector>>, Error> {
        let mut states = Vec::with_capacity(plan.paths);
        let no_reference = || InternalError::new("a measurement has a reference", &self.title);
        let reference = self.reference.as_ref().ok_or_else(no_reference)?;
        let block = |paths| self.ends(plan, reference, paths);
        self.in_blocks(plan, plan.reference_steps, stopped, block, |block| {
            work.advance(plan.reference_steps * block.len());
            states.extend(block);
        })?;
        Ok(states)
    }

    /// Does `block` for blocks of paths of so many steps, which are taken in order, until it is stopped.
    fn in_blocks<T: Send>(
        &self,
        plan: &Settings<H::Vector>,
        steps: usize,
        stopped: &(dyn Fn() -> bool + Sync),
        block: impl Fn(Range<u64>) -> Result<T, Error> + Sync,
        mut take: impl FnMut(T) + Send,
    ) -> Result<(), Error> {
        let (paths, size) = (plan.paths as u64, TIMED_STEPS.div_ceil(steps.max(1)) as u64);
        let mut failed = Ok(());
        in_order(
            0..paths.div_ceil(size),
            plan.threads,
            |number| (!stopped()).then(|| block(number * size..paths.min((number + 1) * size))),
            |_, result| match result {
                Some(Ok(result)) => {
                    take(result);
                    ControlFlow::Continue(())
                }
                Some(Err(error)) => {
                    failed = Err(error);
                    ControlFlow::Break(())
                }
                None => ControlFlow::Break(()),
            },
        );
        failed
    }

    fn ends(
        &self,
        plan: &Settings<H::Vector>,
        reference: &Reference<'a, H>,
        paths: Range<u64>,
    ) -> Result<Vec<State<H::Vector>>, Error> {
        let (start, processes) = (&plan.start, self.system.noises());
        let mut increments = vec![0.0; plan.reference_steps * processes];
        let mut wiener = self.wiener(0);
        let end = |path: u64| -> Result<State<H::Vector>, Error> {
            wiener.set_path(path);
            Ok(match reference {
                Reference::Exact(exact) => {
                    let ends: Result<Vec<f64>, _> =
                        (0..processes).map(|k| wiener.increment(k, start.t, plan.end)).collect();
                    exact(plan.end, &ends?)
                }
                Reference::OnPath(exact) => exact(plan.end, &mut wiener)?,
                Reference::Finer(scheme, h) => {
                    let mut noise = self.wiener(path);
                    noise.prepare(&scheme.plan(), *h, processes, start.t)?;
                    draw(&mut noise, processes, start.t, *h, &mut increments)?;
                    let given = Given { start, h: *h, steps: plan.reference_steps, increments: &increments };
                    let outcome = scheme.run(self.system, &given, &mut |_| {})?;
                    match outcome.failure {
                        Some(error) => return Err(error),
                        None => outcome.last,
                    }
                }
                Reference::Value(state) => state.clone(),
            })
        };
        paths.map(end).collect()
    }

    /// Errors of one scheme and step size over the paths; `None` if there was time for no path at all.
    pub(super) fn accuracy(
        &self,
        plan: &Settings<H::Vector>,
        run: &Run,
        references: &[State<H::Vector>],
        work: &mut Work,
        stopped: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Cell>, Error> {
        let scheme = self.scheme_of(run)?;
        let mut found = Found::new(self.observables.len());
        let block = |paths| self.block(plan, run, scheme, references, paths);
        self.in_blocks(plan, run.steps, stopped, block, |block: Found| {
            work.advance(run.steps * (block.good.len() + block.failures));
            found.append(block);
        })?;
        if found.good.is_empty() && found.failures == 0 {
            return Ok(None);
        }
        let weak = self.observables.iter().zip(&found.weak).map(|(observable, values)| Weak {
            observable: observable.name.clone(),
            bias: Estimate::mean(values),
        });
        Ok(Some(Cell {
            scheme: scheme.name(),
            h: run.h,
            steps: run.steps,
            paths: found.good.len(),
            failures: found.failures,
            strong: Estimate::root_mean_square(&found.errors),
            weak: weak.collect(),
            energy_trend: Estimate::root_mean_square(&found.trends),
            energy_oscillation: Estimate::root_mean_square(&found.oscillations),
            iterations: found.iterations as f64 / found.steps.max(1) as f64,
            largest_iterations: found.largest,
            failure: found.failure,
            time: None,
            noise_time: None,
            path_numbers: found.good,
            errors: found.errors,
            times: vec![],
            noise_times: vec![],
        }))
    }

    /// Paths, one after the other, that have a reference.
    fn block(
        &self,
        plan: &Settings<H::Vector>,
        run: &Run,
        scheme: &dyn Scheme<H>,
        references: &[State<H::Vector>],
        paths: Range<u64>,
    ) -> Result<Found, Error> {
        let (system, processes, h, start) = (self.system, self.system.noises(), run.h, &plan.start);
        let mut noise = self.driver(scheme, h, start.t)?;
        let mut increments = vec![0.0; run.steps * processes];
        let mut found = Found::new(self.observables.len());
        let exact = |path: u64| Some((path, references.get(usize::try_from(path).ok()?)?));
        // A run that was stopped has fewer references than paths.
        for (path, exact) in paths.map_while(exact) {
            noise.set_path(path);
            draw(noise.as_mut(), processes, start.t, h, &mut increments)?;
            let mut energies = Energies {
                stride: run.steps.div_ceil(LOOKS),
                steps: run.steps,
                node: 0,
                start: start.t,
                first: system.energy(start),
                points: Vec::new(),
            };
            let given = Given { start, h, steps: run.steps, increments: &increments };
            match scheme.run(system, &given, &mut |state| energies.see(system, state)) {
                Err(error) => found.fail(error.to_string()),
                Ok(Outcome { failure: Some(error), .. }) => found.fail(error.to_string()),
                Ok(Outcome { last, iterations, largest, failure: None }) => {
                    found.good.push(path);
                    found.steps += run.steps as u64;
                    found.iterations += iterations;
                    found.largest = found.largest.max(largest);
                    found.errors.push(distance(&last, exact));
                    let trend = Trend::of(&energies.points);
                    found.trends.push(trend.slope * (plan.end - start.t));
                    found.oscillations.push(trend.oscillation);
                    for (observable, values) in self.observables.iter().zip(&mut found.weak) {
                        let f = &observable.value;
                        values.push(f(&last) - observable.expectation.unwrap_or_else(|| f(exact)));
                    }
                }
            }
        }
        Ok(found)
    }
}

/// Euclidean distance in (q, p).
fn distance<V: Vector>(a: &State<V>, b: &State<V>) -> f64 {
    let parts = [(&a.q, &b.q), (&a.p, &b.p)];
    let pairs = parts.iter().flat_map(|(a, b)| a.components().iter().zip(b.components()));
    pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}
