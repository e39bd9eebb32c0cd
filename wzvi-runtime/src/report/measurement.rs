//! The measurement itself: references, errors over paths, times.
//!
//! Tested by `tests/paths/report/estimators.rs`.

use std::time::{Duration, Instant};

use super::data::{Cell, Report};
use super::machine::Machine;
use super::measure::{Reference, WorkPrecision};
use super::method::{MeasuredScheme, TimedPath};
use super::noise::Shifted;
use super::number;
use super::statistics::Spread;
use crate::algebra::state::{State, Vector};
use crate::error::{ConfigError, InternalError, wrong};
use crate::ground::progress::ProgressLine;
use crate::increments::{Interval, Noise as _};
use crate::noise::{Driver, Paths as _, Wiener};
use crate::scheme::system::Hamiltonian;
use crate::trajectory::Error;
use crate::trajectory::recorded::Iterations;
use crate::trajectory::span::{RunEnd, sized, whole_steps};

/// Steps that one timing takes at least, if there are paths enough.
pub(super) const TIMED_STEPS: usize = 20_000;
/// Time that one timing of steps takes at least.
const TIMED: Duration = Duration::from_millis(1);

impl<'a, H> WorkPrecision<'a, H>
where
    H: Hamiltonian + Sync,
{
    /// Runs the measurement. Its [handle](WorkPrecision::handle), or [`WorkPrecision::stop_when`], ends it
    /// early: the report then holds what was measured until then. A terminal shows progress and the remaining
    /// time.
    ///
    /// A step that fails ends its path and is counted.
    ///
    /// # Errors
    /// [`Error::Config`] for settings that are missing or invalid, [`Error::Noise`] if there are no
    /// increments, [`Error::Step`] if the reference fails, [`Error::Report`] for an unusable overlay.
    pub fn run(mut self) -> Result<Report, Error> {
        if let Some(error) = self.failed.take() {
            return Err(error);
        }
        let plan = self.checked()?;
        let execution = std::mem::take(&mut self.setup.execution);
        let stopped = &|| execution.is_stopped();
        let work: usize = plan.runs.iter().map(|run| run.steps * plan.paths).sum();
        let timing: usize = plan.runs.iter().map(|run| run.batch_steps() * (self.repetitions + 1)).sum();
        let reference = plan.reference_steps * plan.paths;
        let mut work = MeasurementProgress::new(execution.progress("steps"), work + timing + reference);

        let references = self.references(&plan, &mut work, stopped)?;
        let mut cells = vec![];
        for run in &plan.runs {
            if stopped() {
                break;
            }
            cells.extend(self.accuracy(&plan, run, &references, &mut work, stopped)?);
        }
        self.times(&plan, &mut cells, &mut work, stopped)?;
        drop(work);

        let order = |cell: &Cell| self.methods.iter().position(|method| method.name == cell.scheme);
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
                .methods
                .first()
                .map_or_else(String::new, |method| format!("{:?}", method.plan.conserves_energy)),
            interrupted,
            cells,
            overlay: std::mem::take(&mut self.overlay),
        })
    }

    fn reference_in_words(&self) -> String {
        match self.reference.value() {
            Some(Reference::Exact(_) | Reference::OnPath(_)) => {
                "exact solution on the same Wiener path".into()
            }
            Some(Reference::Finer(method, h)) => {
                format!("{} with h = {} on the same Wiener path", method.name, number(*h))
            }
            Some(Reference::Value(_)) => "given state".into(),
            None => "none".into(),
        }
    }

    fn checked(&self) -> Result<MeasurementSettings<H::Vector>, ConfigError> {
        let missing = ConfigError::Missing;
        let start = self
            .setup
            .span
            .start
            .value()
            .cloned()
            .ok_or(missing("a start: add `.start(State::new(q, p))`"))?;
        let Some(&RunEnd::Time(end)) = self.setup.span.end.value() else {
            return Err(missing("an end: add `.until(time)`"));
        };
        self.reference.check("a measurement has one reference")?;
        let reference = self.reference.value().ok_or(missing(
            "something to compare with: add `.exact(...)`, `.reference::<Scheme>(h)` or `.value(state)`",
        ))?;
        sized(self.system, &start)?;
        if self.methods.is_empty() {
            return Err(missing("a scheme: add `.scheme::<Midpoint>()`"));
        }
        if self.steps.is_empty() {
            return Err(missing("step sizes: add `.step_sizes([...])`"));
        }
        let names = || self.observables.0.iter().map(|((name, _), _)| name);
        if let Some((_, twice)) =
            names().enumerate().find(|(i, name)| names().take(*i).any(|other| other == *name))
        {
            return wrong(format!("two observables have the name `{twice}`"));
        }
        if self.paths == 0 {
            return wrong("no paths: `.paths(0)` leaves nothing to measure");
        }
        let whole = |h: f64| {
            let steps = whole_steps(start.t, end, h)?;
            usize::try_from(steps).map_err(|_| ConfigError::End { start: start.t, end, h })
        };
        let degrees = start.q.components().len();
        let mut processes = self.methods.iter().map(|method| (method.increments)(self.system, degrees));
        let paths = if processes.all(|processes| processes == 0) { 1 } else { self.paths };
        let mut sizes = self.steps.clone();
        sizes.sort_by(|a, b| b.abs().total_cmp(&a.abs()));
        sizes.dedup();
        let mut runs = vec![];
        for h in sizes {
            let steps = whole(h)?;
            let batch = TIMED_STEPS.div_ceil(steps).clamp(1, paths);
            runs.extend((0..self.methods.len()).map(|method| SchemeRun { method, h, steps, batch }));
        }
        let reference_steps = match reference {
            Reference::Finer(_, h) => whole(*h)?,
            _ => 0,
        };
        Ok(MeasurementSettings {
            start,
            end,
            paths,
            threads: self.setup.execution.threads()?,
            runs,
            reference_steps,
        })
    }

    /// The increments of the paths from `first` on, for states of this size, made of their Wiener paths.
    pub(super) fn shifted<'n>(
        &self,
        noise: Box<dyn Driver + 'n>,
        first: u64,
        start: &State<H::Vector>,
    ) -> Shifted<'n> {
        Shifted { noise, first, degrees: start.q.components().len(), noises: self.system.noises() }
    }

    /// The Wiener path with a number.
    pub(super) fn wiener(&self, path: u64) -> Wiener {
        Wiener::seed(self.seed).path(path)
    }

    /// Times of all cells: one warm-up, then the repetitions, each through all cells, to and fro.
    fn times(
        &self,
        plan: &MeasurementSettings<H::Vector>,
        cells: &mut [Cell],
        work: &mut MeasurementProgress,
        stopped: &dyn Fn() -> bool,
    ) -> Result<(), Error> {
        let mut timed = Vec::with_capacity(cells.len());
        // Without a single path that reaches the end there is nothing to time.
        for cell in cells.iter_mut().filter(|cell| cell.paths > 0) {
            let run = plan.runs.iter().find(|run| self.is(run, cell));
            let missing = || InternalError::new("a cell is of a run", format!("{}, {}", cell.scheme, cell.h));
            timed.push((run.ok_or_else(missing)?, cell, 1));
        }
        for round in 0..=self.repetitions {
            if round > 0 {
                timed.reverse();
            }
            for (run, cell, passes) in &mut timed {
                if stopped() {
                    return Ok(());
                }
                let numbers = cell.path_numbers.get(..run.batch).unwrap_or(&cell.path_numbers);
                let paths = numbers.len() as f64;
                let (steps, iterations, drawing) = self.time(plan, run, numbers, *passes)?;
                work.add_steps(run.batch_steps());
                if round == 0 {
                    cell.iterations = iterations.total as f64 / (paths * run.steps as f64).max(1.0);
                    cell.largest_iterations = iterations.largest;
                    let once = steps.as_secs_f64().max(1e-7);
                    *passes = (TIMED.as_secs_f64() / once).ceil().clamp(1.0, 10_000.0) as u32;
                    continue;
                }
                cell.times.push(steps.as_secs_f64() / (paths * f64::from(*passes)));
                cell.noise_times.push(drawing.as_secs_f64() / paths);
                cell.time = Some(Spread::of(&cell.times));
                if drawing > Duration::ZERO {
                    cell.noise_time = Some(Spread::of(&cell.noise_times));
                }
            }
        }
        Ok(())
    }

    pub(super) fn method_of(&self, run: &SchemeRun) -> Result<&MeasuredScheme<H>, InternalError> {
        let none =
            || InternalError::new("a run has a scheme", format!("{} of {}", run.method, self.methods.len()));
        self.methods.get(run.method).ok_or_else(none)
    }

    fn is(&self, run: &SchemeRun, cell: &Cell) -> bool {
        let name = self.methods.get(run.method).map(|method| &method.name);
        run.h == cell.h && name == Some(&cell.scheme)
    }

    /// One timing: first the noise of the batch into a buffer, then the steps alone.
    fn time(
        &self,
        plan: &MeasurementSettings<H::Vector>,
        run: &SchemeRun,
        numbers: &[u64],
        passes: u32,
    ) -> Result<(Duration, Iterations, Duration), Error> {
        let method = self.method_of(run)?;
        let degrees = plan.start.q.components().len();
        let (processes, start) = ((method.increments)(self.system, degrees), plan.start.t);
        let row = run.steps * processes;
        let mut increments = vec![0.0; row * numbers.len()];
        let mut noise = self.shifted((self.driver)(self.wiener(0)), 0, &plan.start);
        if processes > 0 {
            noise.prepare(&method.plan, run.h, processes, start)?;
        }
        let begin = Instant::now();
        if row > 0 {
            for (path, increments) in numbers.iter().zip(increments.chunks_mut(row)) {
                noise.set_path(*path);
                for (step, row) in (0u64..).zip(increments.chunks_mut(processes)) {
                    noise.increments(&Interval { start, h: run.h, step }, row)?;
                }
            }
        }
        let drawing = if row > 0 { begin.elapsed() } else { Duration::ZERO };
        let given = |path: usize| TimedPath {
            start: &plan.start,
            h: run.h,
            steps: run.steps,
            increments: increments.get(path * row..(path + 1) * row).unwrap_or(&[]),
        };
        let paths: Vec<_> = (0..numbers.len()).map(given).collect();
        let (steps, iterations) = (method.time)(self.system, &paths, passes)?;
        Ok((steps, iterations, drawing))
    }
}

/// The steps of all that is measured, and how many are done.
pub(super) struct MeasurementProgress {
    progress: ProgressLine,
    done: u64,
    all: u64,
}

impl MeasurementProgress {
    fn new(progress: ProgressLine, steps: usize) -> Self {
        Self { progress, done: 0, all: steps as u64 }
    }

    pub(super) fn add_steps(&mut self, steps: usize) {
        self.done += steps as u64;
        self.progress.show(self.done, self.all);
    }
}

/// Settings that were checked together.
pub(super) struct MeasurementSettings<V> {
    pub(super) start: State<V>,
    pub(super) end: f64,
    pub(super) paths: usize,
    pub(super) threads: usize,
    runs: Vec<SchemeRun>,
    pub(super) reference_steps: usize,
}

impl<V> MeasurementSettings<V> {
    fn complete(&self, cells: &[Cell], repetitions: usize) -> bool {
        cells.len() == self.runs.len()
            && cells.iter().all(|cell| {
                cell.paths + cell.failures == self.paths
                    && (cell.times.len() == repetitions || cell.paths == 0)
            })
    }
}

/// One scheme at one step size.
pub(super) struct SchemeRun {
    pub(super) method: usize,
    pub(super) h: f64,
    pub(super) steps: usize,
    /// Paths in one timing.
    batch: usize,
}

impl SchemeRun {
    fn batch_steps(&self) -> usize {
        self.steps * self.batch
    }
}
