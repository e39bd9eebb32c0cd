//! The measurement itself: references, errors over paths, times.

use std::time::{Duration, Instant};

use super::data::{Cell, Report, Weak};
use super::machine::Machine;
use super::measure::{Reference, WorkPrecision};
use super::number;
use super::progress::Progress;
use super::scheme::{Given, Scheme};
use super::statistics::{Estimate, Spread, Trend};
use crate::error::{ConfigError, Error, StepFailure};
use crate::increments::{Interval, Noise as _};
use crate::interrupt::Interrupt;
use crate::noise::{Paths, Wiener};
use crate::simulate::steps_between;
use crate::state::{State, Vector};
use crate::system::Hamiltonian;

/// Nodes of a path at which the energy is looked at, about.
const LOOKS: usize = 256;
/// Steps that one timing takes at least, if there are paths enough.
const TIMED_STEPS: usize = 20_000;
/// Time that one timing of steps takes at least.
const TIMED: Duration = Duration::from_millis(1);

impl<'a, H: Hamiltonian> WorkPrecision<'a, H> {
    /// Measures. Ctrl-C, or [`WorkPrecision::stop_when`], ends it early: the report then holds what was measured until then.
    /// On a terminal, progress and the time that remains are shown.
    ///
    /// A step that fails ends its path and is counted, no more.
    ///
    /// # Errors
    /// [`Error::Config`] for settings that are missing or make no sense, [`Error::Noise`] if there are no increments,
    /// [`Error::Step`] if the reference fails, [`Error::Report`] for an unusable overlay.
    pub fn run(mut self) -> Result<Report, Error> {
        if let Some(error) = self.failed.take() {
            return Err(error);
        }
        let plan = self.checked()?;
        let interrupt = Interrupt::watch();
        let stopped = || interrupt.requested() || (self.stop)();
        let work: usize = plan.runs.iter().map(|run| run.steps * plan.paths).sum();
        let timing: usize = plan.runs.iter().map(|run| run.batch_steps() * (self.repetitions + 1)).sum();
        let reference = plan.reference_steps * plan.paths;
        let progress = Progress::new(&self.title, work + timing + reference);

        let references = self.references(&plan, &progress, &stopped)?;
        let mut cells = vec![];
        for run in &plan.runs {
            if stopped() {
                break;
            }
            cells.extend(self.accuracy(&plan, run, &references, &progress, &stopped)?);
        }
        self.times(&plan, &mut cells, &progress, &stopped)?;
        progress.finish();

        let order = |cell: &Cell| self.schemes.iter().position(|scheme| scheme.name() == cell.scheme);
        let interrupted = stopped() && !plan.complete(&cells, self.repetitions);
        cells.sort_by(|a, b| order(a).cmp(&order(b)).then(b.h.total_cmp(&a.h)));
        Ok(Report {
            title: self.title.clone(),
            machine: Machine::here(),
            span: plan.end - plan.start.t,
            noises: self.system.noises(),
            seed: self.seed,
            reference: self.reference_in_words(),
            conserves_energy: self
                .schemes
                .first()
                .map_or_else(String::new, |scheme| format!("{:?}", scheme.plan().conserves_energy)),
            interrupted,
            cells,
            overlay: std::mem::take(&mut self.overlay),
        })
    }

    fn reference_in_words(&self) -> String {
        match &self.reference {
            Some(Reference::Exact(_) | Reference::OnPath(_)) => {
                "exact solution on the same Wiener path".into()
            }
            Some(Reference::Finer(scheme, h)) => {
                format!("{} with h = {} on the same Wiener path", scheme.name(), number(*h))
            }
            Some(Reference::Value(_)) => "given state".into(),
            None => "none".into(),
        }
    }

    fn checked(&self) -> Result<Settings<H::Vector>, ConfigError> {
        let missing = ConfigError::Missing;
        let start = self.start.clone().ok_or(missing("a start: add `.start(State::new(q, p))`"))?;
        let end = self.end.ok_or(missing("an end: add `.until(time)`"))?;
        let reference = self.reference.as_ref().ok_or(missing(
            "something to compare with: add `.exact(...)`, `.reference::<Scheme>(h)` or `.value(state)`",
        ))?;
        for got in [start.q.components().len(), start.p.components().len()] {
            let expected = self.system.degrees();
            if got != expected {
                return Err(ConfigError::Start(StepFailure::Dimension { expected, got }));
            }
        }
        if self.schemes.is_empty() {
            return Err(missing("a scheme: add `.scheme::<Midpoint>()`"));
        }
        if self.steps.is_empty() {
            return Err(missing("step sizes: add `.step_sizes([...])`"));
        }
        if self.paths == 0 {
            return Err(ConfigError::Setting("no paths: `.paths(0)` leaves nothing to measure".into()));
        }
        let whole = |h: f64| {
            let steps = steps_between(start.t, end, h).ok_or(ConfigError::End { start: start.t, end, h })?;
            let gap = (steps as f64 * h - (end - start.t)).abs();
            if steps == 0 || gap > 1e-9 * h.abs() {
                let span = end - start.t;
                return Err(ConfigError::Setting(format!(
                    "steps of {h} do not fit a whole number of times into a run of {span}; take {span} over an integer"
                )));
            }
            usize::try_from(steps).map_err(|_| ConfigError::End { start: start.t, end, h })
        };
        let paths = if self.system.noises() == 0 { 1 } else { self.paths };
        let mut sizes = self.steps.clone();
        sizes.sort_by(|a, b| b.abs().total_cmp(&a.abs()));
        sizes.dedup();
        let mut runs = vec![];
        for h in sizes {
            let steps = whole(h)?;
            let batch = TIMED_STEPS.div_ceil(steps).clamp(1, paths);
            runs.extend((0..self.schemes.len()).map(|scheme| Run { scheme, h, steps, batch }));
        }
        let reference_steps = match reference {
            Reference::Finer(_, h) => whole(*h)?,
            _ => 0,
        };
        Ok(Settings { start, end, paths, runs, reference_steps })
    }

    /// The path with a number, and its driver for a scheme.
    fn wiener(&self, path: u64) -> Wiener {
        Wiener::seed(self.seed).path(path)
    }

    fn driver(&self, scheme: &dyn Scheme<H>, h: f64, start: f64) -> Result<Box<dyn Paths + 'a>, Error> {
        let mut noise = (self.driver)(self.wiener(0));
        if self.system.noises() > 0 {
            noise.prepare(&scheme.plan(), h, self.system.noises(), start)?;
        }
        Ok(noise)
    }

    fn references(
        &self,
        plan: &Settings<H::Vector>,
        progress: &Progress,
        stopped: &dyn Fn() -> bool,
    ) -> Result<Vec<State<H::Vector>>, Error> {
        let (start, processes) = (&plan.start, self.system.noises());
        let mut states = Vec::with_capacity(plan.paths);
        let mut increments = vec![0.0; plan.reference_steps * processes];
        let mut wiener = self.wiener(0);
        for path in 0..plan.paths as u64 {
            wiener.set_path(path);
            states.push(match &self.reference {
                Some(Reference::Exact(exact)) => {
                    let ends: Result<Vec<f64>, _> =
                        (0..processes).map(|k| wiener.increment(k, start.t, plan.end)).collect();
                    exact(plan.end, &ends?)
                }
                Some(Reference::OnPath(exact)) => exact(plan.end, &mut wiener)?,
                Some(Reference::Finer(scheme, h)) => {
                    if stopped() {
                        break;
                    }
                    let mut noise = self.wiener(path);
                    noise.prepare(&scheme.plan(), *h, processes, start.t)?;
                    draw(&mut noise, processes, start.t, *h, &mut increments)?;
                    let given = Given { start, h: *h, steps: plan.reference_steps, increments: &increments };
                    let outcome = scheme.run(self.system, &given, &mut |_| {})?;
                    progress.advance(plan.reference_steps);
                    match outcome.failure {
                        Some(error) => return Err(error),
                        None => outcome.last,
                    }
                }
                Some(Reference::Value(state)) => state.clone(),
                None => break,
            });
        }
        Ok(states)
    }

    /// Errors of one scheme and step size over the paths; `None` if there was time for no path at all.
    fn accuracy(
        &self,
        plan: &Settings<H::Vector>,
        run: &Run,
        references: &[State<H::Vector>],
        progress: &Progress,
        stopped: &dyn Fn() -> bool,
    ) -> Result<Option<Cell>, Error> {
        let Some(scheme) = self.schemes.get(run.scheme) else { return Ok(None) };
        let (system, processes, h) = (self.system, self.system.noises(), run.h);
        let mut noise = self.driver(scheme.as_ref(), h, plan.start.t)?;
        let mut increments = vec![0.0; run.steps * processes];
        let mut found = Found::default();
        let mut weak = vec![vec![]; self.observables.len()];
        let stride = run.steps.div_ceil(LOOKS);
        for (path, exact) in (0u64..).zip(references) {
            if stopped() {
                break;
            }
            noise.set_path(path);
            draw(noise.as_mut(), processes, plan.start.t, h, &mut increments)?;
            let (mut energies, mut node) = (vec![], 0);
            let first = system.energy(&plan.start);
            let given = Given { start: &plan.start, h, steps: run.steps, increments: &increments };
            let outcome = scheme.run(system, &given, &mut |state| {
                if node % stride == 0 || node == run.steps {
                    energies.push((state.t - plan.start.t, system.energy(state) - first));
                }
                node += 1;
            });
            progress.advance(run.steps);
            let failure = match outcome {
                Ok(outcome) => match outcome.failure {
                    None => {
                        found.good.push(path);
                        found.steps += run.steps as u64;
                        found.iterations += outcome.iterations;
                        found.largest = found.largest.max(outcome.largest);
                        found.errors.push(distance(&outcome.last, exact));
                        let trend = Trend::of(&energies);
                        found.trends.push(trend.slope * (plan.end - plan.start.t));
                        found.oscillations.push(trend.oscillation);
                        for (observable, values) in self.observables.iter().zip(&mut weak) {
                            let f = &observable.value;
                            let expected = observable.expectation.unwrap_or_else(|| f(exact));
                            values.push(f(&outcome.last) - expected);
                        }
                        continue;
                    }
                    Some(error) => error.to_string(),
                },
                Err(error) => error.to_string(),
            };
            found.failures += 1;
            found.failure.get_or_insert(failure);
        }
        if found.good.is_empty() && found.failures == 0 {
            return Ok(None);
        }
        let weak = self.observables.iter().zip(&weak).map(|(observable, values)| Weak {
            observable: observable.name.clone(),
            bias: Estimate::mean(values),
        });
        Ok(Some(Cell {
            scheme: scheme.name(),
            h,
            steps: run.steps,
            paths: found.good.len(),
            failures: found.failures,
            failure: found.failure,
            strong: Estimate::root_mean_square(&found.errors),
            weak: weak.collect(),
            energy_trend: Estimate::root_mean_square(&found.trends),
            energy_oscillation: Estimate::root_mean_square(&found.oscillations),
            iterations: found.iterations as f64 / found.steps.max(1) as f64,
            largest_iterations: found.largest,
            time: None,
            noise_time: None,
            path_numbers: found.good,
            errors: found.errors,
            times: vec![],
            noise_times: vec![],
        }))
    }

    /// Times of all cells: one warm-up, then the repetitions, each through all cells, to and fro.
    fn times(
        &self,
        plan: &Settings<H::Vector>,
        cells: &mut [Cell],
        progress: &Progress,
        stopped: &dyn Fn() -> bool,
    ) -> Result<(), Error> {
        let mut passes = vec![1; cells.len()];
        for round in 0..=self.repetitions {
            if self.repetitions == 0 {
                break;
            }
            for index in 0..cells.len() {
                let index = if round % 2 == 0 { index } else { cells.len() - 1 - index };
                let (Some(cell), Some(passes)) = (cells.get_mut(index), passes.get_mut(index)) else {
                    continue;
                };
                // Without a single path that reaches the end there is nothing to time.
                let Some(run) = plan.runs.iter().find(|run| self.is(run, cell)) else { continue };
                if cell.paths == 0 {
                    continue;
                }
                if stopped() {
                    return Ok(());
                }
                let numbers = cell.path_numbers.get(..run.batch).unwrap_or(&cell.path_numbers);
                let paths = numbers.len() as f64;
                let (steps, drawing) = self.time(plan, run, numbers, *passes)?;
                progress.advance(run.batch_steps());
                if round == 0 {
                    let once = steps.as_secs_f64().max(1e-7);
                    *passes = (TIMED.as_secs_f64() / once).ceil().clamp(1.0, 10_000.0) as u32;
                    continue;
                }
                cell.times.push(steps.as_secs_f64() / (paths * f64::from(*passes)));
                cell.noise_times.push(drawing.as_secs_f64() / paths);
                cell.time = Some(Spread::of(&cell.times));
                if self.system.noises() > 0 {
                    cell.noise_time = Some(Spread::of(&cell.noise_times));
                }
            }
        }
        Ok(())
    }

    fn is(&self, run: &Run, cell: &Cell) -> bool {
        let name = self.schemes.get(run.scheme).map(|scheme| scheme.name());
        run.h == cell.h && name.as_ref() == Some(&cell.scheme)
    }

    /// One timing: first the noise of the batch into a buffer, then the steps alone.
    fn time(
        &self,
        plan: &Settings<H::Vector>,
        run: &Run,
        numbers: &[u64],
        passes: u32,
    ) -> Result<(Duration, Duration), Error> {
        let Some(scheme) = self.schemes.get(run.scheme) else { return Ok(Default::default()) };
        let row = run.steps * self.system.noises();
        let mut increments = vec![0.0; row * numbers.len()];
        let mut noise = self.driver(scheme.as_ref(), run.h, plan.start.t)?;
        let begin = Instant::now();
        if row > 0 {
            for (path, increments) in numbers.iter().zip(increments.chunks_mut(row)) {
                noise.set_path(*path);
                draw(noise.as_mut(), self.system.noises(), plan.start.t, run.h, increments)?;
            }
        }
        let drawing = begin.elapsed();
        let given = |path: usize| Given {
            start: &plan.start,
            h: run.h,
            steps: run.steps,
            increments: increments.get(path * row..(path + 1) * row).unwrap_or(&[]),
        };
        let paths: Vec<_> = (0..numbers.len()).map(given).collect();
        Ok((scheme.time(self.system, &paths, passes)?, drawing))
    }
}

/// Settings that fit together.
struct Settings<V> {
    start: State<V>,
    end: f64,
    paths: usize,
    runs: Vec<Run>,
    reference_steps: usize,
}

impl<V> Settings<V> {
    fn complete(&self, cells: &[Cell], repetitions: usize) -> bool {
        cells.len() == self.runs.len()
            && cells.iter().all(|cell| {
                cell.paths + cell.failures == self.paths
                    && (cell.times.len() == repetitions || cell.paths == 0)
            })
    }
}

/// One scheme at one step size.
struct Run {
    scheme: usize,
    h: f64,
    steps: usize,
    /// Paths in one timing.
    batch: usize,
}

impl Run {
    fn batch_steps(&self) -> usize {
        self.steps * self.batch
    }
}

#[derive(Default)]
struct Found {
    good: Vec<u64>,
    steps: u64,
    iterations: u64,
    largest: u32,
    errors: Vec<f64>,
    trends: Vec<f64>,
    oscillations: Vec<f64>,
    failures: usize,
    failure: Option<String>,
}

/// The increments of one path, rows of one per process.
fn draw(noise: &mut dyn Paths, processes: usize, start: f64, h: f64, rows: &mut [f64]) -> Result<(), Error> {
    if processes > 0 {
        for (step, row) in (0u64..).zip(rows.chunks_mut(processes)) {
            noise.increments(&Interval { start, h, step }, row)?;
        }
    }
    Ok(())
}

/// Euclidean distance in (q, p).
fn distance<V: Vector>(a: &State<V>, b: &State<V>) -> f64 {
    let parts = [(&a.q, &b.q), (&a.p, &b.p)];
    let pairs = parts.iter().flat_map(|(a, b)| a.components().iter().zip(b.components()));
    pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}
