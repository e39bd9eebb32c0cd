//! Multilevel Monte Carlo: the mean of an observable at the cost of coarse steps.
//!
//! M. B. Giles, "Multilevel Monte Carlo path simulation", Oper. Res. 56 (2008) 607; "Multilevel Monte Carlo methods", Acta
//! Numerica 24 (2015) 259, whose letters these are. With `P_l` the observable at the end in steps of `h_l = h / 2^l`,
//!
//! ```text
//! E P_L = E P_0 + Σ_{l=1..L} E[P_l - P_{l-1}]
//! ```
//!
//! and both terms of a difference run on the same Brownian path, so that its variance `V_l` falls with `l` like `h_l²` for
//! a scheme of strong order one. With `C_l` steps per path, the variance `Σ V_l / N_l` is kept below its part of the error at the
//! least cost by
//!
//! ```text
//! N_l = ⌈ √(V_l / C_l) Σ_k √(V_k C_k) / ((1 - θ) ε²) ⌉
//! ```
//!
//! Levels are added until the bias that is left, estimated from the last differences, is below `√θ ε`. The cost of an error
//! `ε` is then of order `ε^-2`, where one step size alone takes `ε^-3` with weak order one.
//!
//! The two paths of a difference have the normals `ξ_1, ξ_2` and `(ξ_1 + ξ_2)/√2`, each truncated with the bound of its own
//! step size: `P_{l-1}` has the same law on both levels where it occurs, and the sum telescopes exactly.

mod begin;
mod estimate;
mod pairs;

use std::marker::PhantomData;
use std::ops::ControlFlow;

pub use crate::error::{LevelError, LevelFailure};
pub use estimate::{Level, MultilevelEstimate};
use estimate::{Samples, bias, variance_bounds, variance_slope};
use pairs::{Pairs, block_size};

use super::halt::Halt;
use super::job::{Job, Stop};
use super::source::Source;
use crate::algebra::lanes::instructions::InstructionSet;
use crate::algebra::state::{State, Vector};
use crate::ensemble::execution::Execution;
use crate::ensemble::schedule::in_order;
use crate::error::{ConfigError, InternalError};
use crate::ground::progress::ProgressLine;
use crate::increments::Noise as _;
use crate::noise::{Paths as _, StepNormals, Truncation};
use crate::path::Error;
use crate::path::options::{Observable, Observables, options};
use crate::path::retry::Retry;
use crate::path::section::Sections;
use crate::path::span::{End, Grid, MOST_STEPS, Span};
use crate::scheme::plan::NoiseClass;
use crate::scheme::system::{Discretized, Hamiltonian};
use crate::statistics::{Nodes, Statistics};

/// The part `θ` of the squared error that is left to the bias.
const BIAS_PART: f64 = 0.25;
/// Paths of a new level at least, to learn its variance from.
const FIRST_PATHS: u64 = 256;
/// A bias is not estimated from fewer levels.
const LEAST_LEVELS: usize = 3;
/// Finest level unless the user says so: steps a million times shorter than the coarsest.
const MOST_LEVELS: u32 = 20;
/// Paths of a level, at most, unless the user says how many.
const MOST_PATHS: u64 = 1 << 50;
/// Paths of the coarsest level on which an observable may be the same number, unless the user says how many.
const MOST_CONSTANT: u64 = 1 << 20;
/// Numbers of paths this close to the best ones are good enough.
const TOLERANCE: f64 = 0.01;

/// Nothing is observed yet.
#[derive(Clone, Copy, Debug)]
pub enum Nothing {}

/// One observable, whose mean is wanted.
#[derive(Clone, Copy, Debug)]
pub enum Observed {}

/// A multilevel run: the mean of one observable at the end, to a root mean square error, from coupled paths in steps of
/// `h, h/2, h/4, ...`. [`Integrate::multilevel`](crate::integrate::Integrate::multilevel) begins it, [`Multilevel::run`] runs it.
///
/// A run needs a start, an end, a seed, one observable and a target. `O` says whether there is an observable. Other settings of an
/// [`Ensemble`](super::Ensemble), such as quantiles or checkpoints, have no meaning here.
#[must_use = "nothing happens before `run`"]
pub struct Multilevel<'a, H: Discretized<E>, E, O = Nothing> {
    setup: Setup<'a, H>,
    types: PhantomData<fn() -> (E, O)>,
}

/// What was said so far.
struct Setup<'a, H: Hamiltonian> {
    system: &'a H,
    h: f64,
    span: Span<H::Vector>,
    seed: Option<u64>,
    truncation: Truncation,
    observables: Observables<'a, H::Vector>,
    paths: Option<u64>,
    target: Option<f64>,
    weak_order: f64,
    finest: u32,
    execution: Execution<'a>,
    /// What an ensemble was told that means nothing here.
    refused: Option<&'static str>,
}

impl<'a, H: Discretized<E>, E> Multilevel<'a, H, E> {
    /// A run of `system` whose coarsest steps have size `h`: the largest step with which a path is still meaningful.
    pub fn new(system: &'a H, h: f64) -> Self {
        let setup = Setup {
            system,
            h,
            span: Span::default(),
            seed: None,
            truncation: Truncation::Unset,
            observables: Observables::default(),
            paths: None,
            target: None,
            weak_order: 1.0,
            finest: MOST_LEVELS,
            execution: Execution::default(),
            refused: None,
        };
        Self { setup, types: PhantomData }
    }

    /// The observable whose mean at the end of the paths is wanted, a function of the state. There is one.
    pub fn observe(
        mut self,
        name: impl Into<String>,
        observable: impl Fn(&State<H::Vector>) -> f64 + Send + Sync + 'a,
    ) -> Multilevel<'a, H, E, Observed> {
        self.setup.observables.push(name.into(), observable);
        Multilevel { setup: self.setup, types: PhantomData }
    }
}

impl<'a, H: Discretized<E>, E, O> Multilevel<'a, H, E, O> {
    options!(start, end, execution, instructions);

    /// The seed of its normals: level 0 has those of an ensemble with this seed and step size, finer levels have their own.
    pub fn seed(mut self, seed: u64) -> Self {
        self.setup.seed = Some(seed);
        self
    }

    /// Sets whether increments are truncated. The default is `k = 4` where
    /// [`Plan::truncates_increments`](crate::scheme::plan::Plan::truncates_increments) holds.
    pub fn truncation(mut self, truncation: Truncation) -> Self {
        self.setup.truncation = truncation;
        self
    }

    /// The root mean square error that is wanted, in units of the observable.
    pub fn target(mut self, error: f64) -> Self {
        self.setup.target = Some(error);
        self
    }

    /// How many paths of each level, at most.
    pub fn paths(mut self, paths: u64) -> Self {
        self.setup.paths = Some(paths);
        self
    }

    /// Sets the weak order of the scheme, from which the remaining bias is estimated. The default is 1, which every consistent scheme has at
    /// least.
    pub fn weak_order(mut self, order: f64) -> Self {
        self.setup.weak_order = order;
        self
    }

    /// Sets the finest level, 20 by default. Its steps are `2^-level` times the coarsest.
    pub fn finest(mut self, level: u32) -> Self {
        self.setup.finest = level;
        self
    }
}

impl<H, E> Multilevel<'_, H, E, Observed>
where
    H: Discretized<E> + Sync,
{
    /// Runs as many paths on as many levels as it takes. The result is the same, bit for bit, for any number of threads.
    ///
    /// # Errors
    /// [`Error::Config`] if a setting is missing or invalid, or if a level has no step. [`Error::Level`] if a path fails or its observable
    /// is not finite, since the mean without it would be biased.
    pub fn run(self) -> Result<MultilevelEstimate, Error> {
        self.run_in::<0>()
    }

    /// [`Multilevel::run`] with `WIDTH` paths beside each other, with 0 as many as suit the instructions; the result is the same.
    #[doc(hidden)]
    pub fn run_in<const WIDTH: usize>(self) -> Result<MultilevelEstimate, Error> {
        let target = self.checked()?;
        let setup = self.setup;
        let Setup { system, h, span, execution, .. } = setup;
        let stop = || execution.is_stopped();
        if !h.is_finite() || h == 0.0 {
            return Err(ConfigError::StepSize(h).into());
        }
        let end = span.end;
        let (start, grid) = span.checked::<H, E>(system, h)?;
        let steps = grid.steps;
        check_end(end, start.t, h, steps)?;
        let seed = setup.seed.ok_or(ConfigError::Missing("a seed for its noise: add `.seed(number)`"))?;
        let (_, functions) = setup.observables.checked("observables")?;
        let observable = functions.first().ok_or(ConfigError::Missing(OBSERVABLE))?;
        Run {
            coarsest: Coarsest { system, h, start, steps, stop: &stop },
            observable,
            levels: Vec::new(),
            normals: StepNormals::seed(seed).with_truncation(setup.truncation),
            instructions: execution.instructions,
            threads: execution.threads()?,
            most_paths: setup.paths.unwrap_or(MOST_PATHS),
            most_constant: setup.paths.unwrap_or(MOST_CONSTANT),
            target,
            weak_order: setup.weak_order,
            finest: setup.finest as usize,
            progress: execution.progress("steps"),
        }
        .run::<WIDTH>()
    }

    /// The target, of a run that makes sense.
    fn checked(&self) -> Result<f64, ConfigError> {
        let Setup { target, weak_order, finest, paths, refused, .. } = &self.setup;
        if let Some(what) = refused {
            return Err(wrong(format!("{what} in a multilevel run, where it has no meaning: leave it out")));
        }
        let target = target.ok_or(ConfigError::Missing("an error to reach: add `.target(error)`"))?;
        let wrong = |what: String| Err(wrong(what));
        if !H::PLAN.consistent {
            return wrong(
                "a multilevel run of a scheme that does not converge to the system: its levels add up to another limit; take `Corrected<...>` \
                 or `Midpoint`"
                    .into(),
            );
        }
        if matches!(H::PLAN.noise, NoiseClass::None) {
            return wrong("a multilevel run of a system without noise: one path says it all".into());
        }
        if !(target.is_finite() && target > 0.0) {
            return wrong(format!("a target of {target}: take a finite number above 0"));
        }
        if !(weak_order.is_finite() && *weak_order > 0.0) {
            return wrong(format!("a weak order of {weak_order}: take a finite number above 0"));
        }
        if !(LEAST_LEVELS as u32 - 1..=40).contains(finest) {
            return wrong(format!("level {finest} as the finest: take 2 to 40"));
        }
        if *paths == Some(0) {
            return wrong("0 paths: take at least 1".into());
        }
        Ok(target)
    }
}

const OBSERVABLE: &str = "an observable: add `.observe(name, function)`";

fn wrong(what: String) -> ConfigError {
    ConfigError::Setting(what)
}

/// Whether the coarsest steps end where the run shall: all levels end there.
fn check_end(end: Option<End>, start: f64, h: f64, steps: u64) -> Result<(), ConfigError> {
    if steps == 0 {
        return Err(wrong("a multilevel run without a step: take a later end".into()));
    }
    let Some(End::Time(end)) = end else { return Ok(()) };
    let (reached, span) = (start + steps as f64 * h, end - start);
    // The roundings that counting the steps allows for, and those of the product.
    let allowed = 4.0 * f64::EPSILON * (span.abs() + start.abs() + end.abs());
    if (reached - end).abs() <= allowed {
        return Ok(());
    }
    Err(wrong(format!(
        "steps of {h} do not end at t = {end}, but at {reached}: take a coarsest step that fits a whole number of times, {} for one",
        span / steps as f64
    )))
}

/// The paths of the coarsest level.
struct Coarsest<'a, H: Hamiltonian> {
    system: &'a H,
    h: f64,
    start: State<H::Vector>,
    steps: u64,
    stop: Stop<'a>,
}

/// A checked run.
struct Run<'a, 'o, H: Discretized<E>, E> {
    coarsest: Coarsest<'a, H>,
    observable: &'a Observable<'o, H::Vector>,
    levels: Vec<Stage<'a, H, E>>,
    normals: StepNormals,
    instructions: InstructionSet,
    threads: usize,
    most_paths: u64,
    /// Paths of the first level, at most, as long as the observable is the same on all.
    most_constant: u64,
    target: f64,
    weak_order: f64,
    finest: usize,
    progress: ProgressLine,
}

/// One level, with what is known of it.
struct Stage<'a, H: Discretized<E>, E> {
    job: Job<'a, H, E>,
    blocks: u64,
    samples: Samples,
}

impl<H, E> Run<'_, '_, H, E>
where
    H: Discretized<E> + Sync,
{
    fn run<const WIDTH: usize>(mut self) -> Result<MultilevelEstimate, Error> {
        for _ in 0..LEAST_LEVELS {
            self.add_level()?;
        }
        let mut wanted = vec![FIRST_PATHS; LEAST_LEVELS];
        loop {
            if self.sample::<WIDTH>(&wanted)?.is_break() {
                return Ok(self.estimate(true));
            }
            if let Some(base) = self.levels.first()
                && base.samples.is_constant()
            {
                // Nothing says how far others may be from it: look for them.
                let count = base.samples.count();
                if count >= self.most_constant {
                    return Ok(self.estimate(false));
                }
                wanted = vec![0; self.levels.len()];
                wanted[0] = count.saturating_mul(2).min(self.most_constant);
                continue;
            }
            let best = self.best_numbers();
            let is_enough = best.iter().zip(&self.levels).all(|(best, level)| {
                let count = level.samples.count();
                count >= self.most_paths || *best as f64 <= count as f64 * (1.0 + TOLERANCE)
            });
            // The bound of what has not been seen falls with the number of paths: no level more than doubles before the next look, or a first look that
            // saw nothing would ask for far too many.
            let doubled = best.iter().zip(&self.levels);
            wanted =
                doubled.map(|(best, level)| level.samples.count().saturating_mul(2).min(*best)).collect();
            if is_enough {
                if self.bias() <= BIAS_PART.sqrt() * self.target || self.levels.len() > self.finest {
                    return Ok(self.estimate(false));
                }
                self.add_level()?;
                wanted.push(FIRST_PATHS);
            }
        }
    }

    fn add_level(&mut self) -> Result<(), Error> {
        let (Coarsest { system, h, start, steps, stop }, level) = (&self.coarsest, self.levels.len() as u32);
        let end = start.t + *steps as f64 * h;
        let h = h / 2f64.powi(level as i32);
        let steps = steps.checked_mul(1 << level).filter(|&steps| steps <= MOST_STEPS && end.is_finite());
        let steps = steps.ok_or(ConfigError::End { start: start.t, end, h })?;
        let mut normals = self.normals.clone().on_level(level);
        normals.prepare(&H::PLAN, h, system.increments(start.q.components().len()), start.t)?;
        let job = Job {
            system: *system,
            prepared: crate::path::step::prepared(*system, h)?,
            h,
            start: start.clone(),
            starts: None,
            systems: Vec::new(),
            own: Vec::new(),
            own_work: None,
            seed: normals.seed_number().unwrap_or(0),
            grid: Grid::of(start.t, h, steps),
            paths: u64::MAX,
            steps,
            recorded: Vec::new(),
            source: Source::Normals(normals),
            retry: Retry::never(),
            // There is noise.
            is_watched: false,
            observables: Vec::new(),
            events: Vec::new(),
            sections: Sections::default(),
            inspector: None,
            empty: Statistics::new(Vec::new(), Nodes::default()),
            stop: *stop,
        };
        self.levels.push(Stage { job, blocks: 0, samples: Samples::default() });
        Ok(())
    }

    /// Runs paths of each level until there are so many, in whole blocks; breaks if the run was stopped.
    fn sample<const WIDTH: usize>(&mut self, wanted: &[u64]) -> Result<ControlFlow<()>, Error> {
        let Self { coarsest: Coarsest { steps, .. }, observable, levels, progress, .. } = self;
        let (instructions, threads, most_paths) = (self.instructions, self.threads, self.most_paths);
        let cost = |count: u64, level: usize| count.saturating_mul(levels_steps(*steps, level));
        let all = wanted.iter().zip(0..).fold(0u64, |all, (n, level)| all.saturating_add(cost(*n, level)));
        let mut before = 0u64;
        for (level, &wanted) in wanted.iter().enumerate() {
            let (coarser, finer) = levels.split_at_mut(level);
            let missing = || InternalError::new("a level that has paths is there", level);
            let stage = finer.first_mut().ok_or_else(missing)?;
            let coarse = coarser.last().map(|stage| &stage.job);
            let Stage { job: fine, blocks, samples } = stage;
            let place = level as u32;
            let range = *blocks..wanted.min(most_paths).div_ceil(block_size(place)).max(*blocks);
            let work = |number| {
                instructions.run(Pairs::<H, E, WIDTH> { fine, coarse, level: place, observable, number })
            };
            let mut end = Ok(ControlFlow::Continue(()));
            in_order(range, threads, work, |_, outcome| {
                match outcome {
                    Ok(block) => {
                        samples.merge(&block);
                        *blocks += 1;
                        progress.show(before.saturating_add(cost(samples.count(), level)), all);
                        return ControlFlow::Continue(());
                    }
                    Err(Halt::Stopped) => end = Ok(ControlFlow::Break(())),
                    Err(Halt::Failed(error)) => end = Err(error),
                }
                ControlFlow::Break(())
            });
            if end?.is_break() {
                return Ok(ControlFlow::Break(()));
            }
            before = before.saturating_add(cost(samples.count(), level));
        }
        Ok(ControlFlow::Continue(()))
    }

    /// The numbers of paths that reach the target at the least cost, as far as the variances are known.
    fn best_numbers(&self) -> Vec<u64> {
        let samples = self.samples();
        let slope = variance_slope(&samples).unwrap_or(1.0).clamp(0.5, 4.0);
        let bounds = variance_bounds(&samples);
        let mut variances: Vec<f64> = Vec::new();
        for (level, mut variance) in bounds.into_iter().enumerate() {
            if let Some(coarser) = variances.last().filter(|_| level >= 2) {
                // A few paths may miss what is rare.
                variance = variance.max(0.5 * coarser / 2f64.powf(slope));
            }
            variances.push(variance);
        }
        let costs: Vec<f64> =
            (0..variances.len()).map(|level| levels_steps(self.coarsest.steps, level) as f64).collect();
        let sum: f64 = variances.iter().zip(&costs).map(|(variance, cost)| (variance * cost).sqrt()).sum();
        let scale = sum / ((1.0 - BIAS_PART) * self.target * self.target);
        let number = |(variance, cost): (&f64, &f64)| {
            // Infinite numbers become the largest integer.
            let best = ((variance / cost).sqrt() * scale).ceil() as u64;
            best.max(FIRST_PATHS).min(self.most_paths)
        };
        variances.iter().zip(&costs).map(number).collect()
    }

    fn samples(&self) -> Vec<Samples> {
        self.levels.iter().map(|stage| stage.samples).collect()
    }

    fn bias(&self) -> f64 {
        bias(&self.samples(), self.weak_order)
    }

    fn estimate(self, is_partial: bool) -> MultilevelEstimate {
        let steps = |level| levels_steps(self.coarsest.steps, level);
        let is_constant = self.levels.first().is_none_or(|level| level.samples.is_constant());
        let levels = self.levels.iter().enumerate();
        let levels = levels
            .filter(|(_, stage)| stage.samples.count() > 0)
            .map(|(level, stage)| Level::new(stage.job.h, steps(level), stage.samples))
            .collect();
        let met = |error: f64, bias: f64| {
            !is_partial
                && !is_constant
                // What the tolerance on the numbers of paths may add.
                && error * error <= (1.0 + TOLERANCE) * (1.0 - BIAS_PART) * self.target * self.target
                && bias <= BIAS_PART.sqrt() * self.target
        };
        MultilevelEstimate::new(levels, self.weak_order, is_partial, is_constant, met)
    }
}

/// Steps of a path of a level: of a fine one, and of the coarse one beside it.
fn levels_steps(coarsest: u64, level: usize) -> u64 {
    let fine = coarsest << level;
    if level == 0 { fine } else { fine + fine / 2 }
}
