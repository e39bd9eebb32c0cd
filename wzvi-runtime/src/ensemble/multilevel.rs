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

mod estimate;
mod pairs;

use std::ops::ControlFlow;
use std::sync::OnceLock;

pub use estimate::{Level, LevelError, LevelFailure, MultilevelEstimate};
use estimate::{Samples, bias, variance_bounds, variance_slope};
use pairs::{Pairs, block_size};

use super::Ensemble;
use super::control::Control;
use super::dispatch::InstructionSet;
use super::job::Job;
use super::source::Source;
use crate::error::{ConfigError, Error};
use crate::increments::Noise as _;
use crate::interrupt::Interrupt;
use crate::noise::StepNormals;
use crate::plan::NoiseClass;
use crate::progress::Progress;
use crate::retry::Retry;
use crate::schedule::{in_order, threads};
use crate::simulate::End;
use crate::system::Discretized;

/// The part `θ` of the squared error that is left to the bias.
const BIAS_PART: f64 = 0.25;
/// Paths of a new level at least, to learn its variance from.
const FIRST_PATHS: u64 = 256;
/// A bias is not estimated from fewer levels.
const LEAST_LEVELS: usize = 3;
/// Finest level unless the user says so: steps a million times shorter than the coarsest.
const MOST_LEVELS: u32 = 20;
/// Paths of the coarsest level on which an observable may be the same number, unless the user says how many.
const MOST_CONSTANT: u64 = 1 << 20;
/// Numbers of paths this close to the best ones are good enough.
const TOLERANCE: f64 = 0.01;

/// A multilevel run: [`Ensemble::multilevel`] begins it, [`Multilevel::run`] runs it.
#[must_use = "nothing happens before `run`"]
pub struct Multilevel<'a, H: Discretized<E>, E> {
    ensemble: Ensemble<'a, H, E>,
    target: f64,
    weak_order: f64,
    finest: u32,
}

impl<'a, H: Discretized<E>, E> Ensemble<'a, H, E> {
    /// The mean of the one observable at the end, to a root mean square error of `target` (units of the observable), from
    /// coupled paths in steps of `h, h/2, h/4, ...` ([`Multilevel`]). The step size of the ensemble is the coarsest one: take one
    /// with which a path just makes sense. [`Ensemble::paths`] limits the paths of each level.
    pub fn multilevel(self, target: f64) -> Multilevel<'a, H, E> {
        Multilevel { ensemble: self, target, weak_order: 1.0, finest: MOST_LEVELS }
    }
}

impl<'a, H: Discretized<E>, E> Multilevel<'a, H, E> {
    /// The weak order of the scheme, from which the bias that is left is estimated; 1 if this is not called, which is what
    /// every consistent scheme has at least.
    pub fn weak_order(mut self, order: f64) -> Self {
        self.weak_order = order;
        self
    }

    /// The finest level that may be used: its steps are `2^-level` times the coarsest; 20 if this is not called.
    pub fn finest(mut self, level: u32) -> Self {
        self.finest = level;
        self
    }
}

impl<'a, H, E> Multilevel<'a, H, E>
where
    H: Discretized<E> + Sync,
    H::Vector: Send + Sync,
    H::Prepared: Send + Sync,
{
    /// Runs as many paths on as many levels as it takes. The result is the same, bit for bit, for any number of threads.
    ///
    /// # Errors
    /// [`Error::Config`] if a setting is missing or makes no sense, or if a level has no step; [`Error::Level`] if a path fails or
    /// its observable is not finite: without it, the mean would be that of those that do not.
    pub fn run(self) -> Result<MultilevelEstimate, Error> {
        self.run_in::<0>()
    }

    /// [`Multilevel::run`] with `WIDTH` paths beside each other, with 0 as many as suit the instructions; the result is the same.
    #[doc(hidden)]
    pub fn run_in<const WIDTH: usize>(mut self) -> Result<MultilevelEstimate, Error> {
        self.check()?;
        let control = std::mem::take(&mut self.ensemble.control);
        let interrupt = Interrupt::watch();
        let stop = || interrupt.requested() || control.is_stopped();
        let instructions = self.ensemble.instructions;
        let threads = threads(self.ensemble.threads)?;
        let most_constant = self.ensemble.paths.unwrap_or(MOST_CONSTANT);
        let most_paths = *self.ensemble.paths.get_or_insert(1 << 50);
        let end = self.ensemble.end;
        let truncation = self.ensemble.truncation;
        let base = self.ensemble.job(&stop)?;
        let Source::Normals(normals) = &base.source else { return Err(wrong(NOT_OURS.into()).into()) };
        let normals = normals.clone().with_truncation(truncation);
        check_end(end, &base)?;
        if base.steps == 0 {
            return Err(
                ConfigError::Setting("a multilevel run without a step: take a later end".into()).into()
            );
        }
        Run {
            base: &base,
            levels: Vec::new(),
            normals,
            instructions,
            threads,
            most_paths,
            most_constant,
            target: self.target,
            weak_order: self.weak_order,
            finest: self.finest as usize,
            progress: Progress::new("steps", control.is_quiet),
        }
        .run::<WIDTH>()
    }

    fn check(&self) -> Result<(), ConfigError> {
        let Self { ensemble, target, weak_order, finest } = self;
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
        if !(target.is_finite() && *target > 0.0) {
            return wrong(format!("a target of {target}: take a finite number above 0"));
        }
        if !(weak_order.is_finite() && *weak_order > 0.0) {
            return wrong(format!("a weak order of {weak_order}: take a finite number above 0"));
        }
        if !(LEAST_LEVELS as u32 - 1..=40).contains(finest) {
            return wrong(format!("level {finest} as the finest: take 2 to 40"));
        }
        let Control { targets, .. } = &ensemble.control;
        let meaningless = [
            ("allow_losses", ensemble.control.losses.is_some()),
            ("antithetic", ensemble.is_antithetic),
            ("checkpoint", ensemble.keeping.is_set()),
            ("covariances", !ensemble.covariances),
            ("first_passage", !ensemble.events.is_empty()),
            ("histogram", !ensemble.histograms.is_empty()),
            ("keep_paths", ensemble.most_bytes.is_some()),
            ("quantiles", ensemble.quantiles),
            ("record_at", !ensemble.chosen.is_empty()),
            ("record_every", ensemble.every != 0),
            ("retry", ensemble.retry.most() > 0),
            ("until_error", !targets.is_empty()),
        ];
        if let Some((name, _)) = meaningless.into_iter().find(|(_, is_set)| *is_set) {
            return wrong(format!(
                "`{name}` in a multilevel run, which finds the mean of an observable at the end: leave it out"
            ));
        }
        match ensemble.observables.len() {
            1 => Ok(()),
            n => wrong(format!(
                "{n} observables in a multilevel run: give it one, with `.observe(name, function)`"
            )),
        }
    }
}

fn wrong(what: String) -> ConfigError {
    ConfigError::Setting(what)
}

const NOT_OURS: &str =
    "a multilevel run with a noise that is given: its levels draw normals of their own, with `.seed(number)`";

/// Whether the coarsest steps end where the run shall: all levels end there.
fn check_end<H: Discretized<E>, E>(end: Option<End>, base: &Job<'_, H, E>) -> Result<(), ConfigError> {
    let Some(End::Time(end)) = end else { return Ok(()) };
    let (start, h, steps) = (base.start.t, base.h, base.steps);
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

/// A checked run.
struct Run<'j, 'a, H: Discretized<E>, E> {
    base: &'j Job<'a, H, E>,
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
    progress: Progress,
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
    H::Vector: Send + Sync,
    H::Prepared: Send + Sync,
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
            wanted = best;
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
        let (base, level) = (self.base, self.levels.len() as u32);
        let h = base.h / 2f64.powi(level as i32);
        let steps = base.steps.checked_mul(1 << level).filter(|&steps| steps <= crate::simulate::MOST_STEPS);
        let end = base.start.t + base.steps as f64 * base.h;
        let Some(steps) = steps else {
            return Err(ConfigError::End { start: base.start.t, end, h }.into());
        };
        let mut normals = self.normals.clone().on_level(level);
        normals.prepare(&H::PLAN, h, base.system.noises(), base.start.t)?;
        let job = Job {
            system: base.system,
            prepared: base.system.prepare(h)?,
            h,
            start: base.start.clone(),
            paths: u64::MAX,
            steps,
            recorded: Vec::new(),
            clip: normals.clip(h),
            source: Source::Normals(normals),
            retry: Retry::never(),
            failed_noise: OnceLock::new(),
            observables: Vec::new(),
            events: Vec::new(),
            wanted: Default::default(),
            level,
            is_antithetic: false,
            stop: base.stop,
        };
        self.levels.push(Stage { job, blocks: 0, samples: Samples::default() });
        Ok(())
    }

    /// Runs paths of each level until there are so many, in whole blocks; breaks if the run was stopped.
    fn sample<const WIDTH: usize>(&mut self, wanted: &[u64]) -> Result<ControlFlow<()>, Error> {
        let Self { base, levels, progress, .. } = self;
        let Some(observable) = base.observables.first() else { return Ok(ControlFlow::Continue(())) };
        let cost = |count: u64, level: usize| count.saturating_mul(levels_steps(base.steps, level));
        let all = wanted.iter().zip(0..).fold(0u64, |all, (n, level)| all.saturating_add(cost(*n, level)));
        let mut before = 0u64;
        for (level, &wanted) in wanted.iter().enumerate() {
            let (coarser, finer) = levels.split_at_mut(level);
            let Some(stage) = finer.first_mut() else { break };
            let coarse = coarser.last().map(|stage| &stage.job);
            let Stage { job: fine, blocks, samples } = stage;
            let range = *blocks..wanted.min(self.most_paths).div_ceil(block_size(fine.level)).max(*blocks);
            let work = |number| {
                let pairs = Pairs::<H, E, WIDTH> { fine, coarse, observable, number };
                self.instructions.run(pairs)
            };
            let mut end = Ok(ControlFlow::Continue(()));
            in_order(range, self.threads, work, |_, outcome| {
                match outcome {
                    Ok(Some(block)) => {
                        samples.merge(&block);
                        *blocks += 1;
                        progress.show(before.saturating_add(cost(samples.count(), level)), all);
                        return ControlFlow::Continue(());
                    }
                    Ok(None) => end = Ok(ControlFlow::Break(())),
                    Err(error) => end = Err(Error::Level(error)),
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
            (0..variances.len()).map(|level| levels_steps(self.base.steps, level) as f64).collect();
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
        let steps = |level| levels_steps(self.base.steps, level);
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
