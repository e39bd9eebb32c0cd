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
//! Levels are added until the remaining bias, estimated from the last differences, is below `√θ ε`. The cost of an error
//! `ε` is then of order `ε^-2`, where one step size alone takes `ε^-3` with weak order one.
//!
//! The two paths of a difference have the normals `ξ_1, ξ_2` and `(ξ_1 + ξ_2)/√2`, each truncated with the bound of its own
//! step size: `P_{l-1}` has the same law on both levels where it occurs, and the sum telescopes exactly.

mod estimate;

use std::marker::PhantomData;
use std::ops::ControlFlow;

pub use crate::error::{LevelError, LevelFailure};
use estimate::{FINE, bias, variance_bounds, variance_slope};
pub use estimate::{Level, MultilevelEstimate};

use super::chunk::{BESIDE, in_chunks};
use super::control::Control;
use super::halt::Halt;
use super::job::Job;
use super::source::{Settings, Source};
use super::starts::Paired;
use super::{Ensemble, Extras, Many, Setup};
use crate::algebra::lanes::instructions::InstructionSet;
use crate::algebra::state::State;
use crate::error::{ConfigError, InternalError};
use crate::ground::digits::Brief;
use crate::ground::progress::ProgressLine;
use crate::increments::Whole;
use crate::noise::{StepNormals, Truncation};
use crate::path::Error;
use crate::path::options::options;
use crate::path::recording::Request;
use crate::path::span::{End, Grid};
use crate::scheme::plan::NoiseClass;
use crate::scheme::system::{Discretized, Hamiltonian};
use crate::statistics::{Nodes, Statistics, StatisticsNode};

/// The part `θ` of the squared error that is allowed for the bias.
const BIAS_PART: f64 = 0.25;
/// Paths of a new level at least, to learn its variance from.
const FIRST_PATHS: u64 = 256;
/// A bias is not estimated from fewer levels.
const LEAST_LEVELS: usize = 3;
/// The default of the finest level: steps a million times shorter than the coarsest.
const MOST_LEVELS: u32 = 20;
/// The default of the largest number of paths of a level.
const MOST_PATHS: u64 = 1 << 50;
/// Paths of the coarsest level after which an observable with one value throughout is given up, unless the user sets the number.
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
/// [`Ensemble`], such as quantiles or checkpoints, have no meaning here.
#[must_use = "nothing happens before `run`"]
pub struct Multilevel<'a, H: Discretized<E>, E, O = Nothing> {
    setup: Setup<'a, H>,
    levels: Levels,
    types: PhantomData<fn() -> (E, O)>,
}

/// Settings of levels only.
#[derive(Clone, Copy)]
struct Levels {
    target: Option<f64>,
    weak_order: f64,
    finest: u32,
}

impl<'a, H: Discretized<E>, E> Ensemble<'a, H, E> {
    /// The mean of the one observable at the end, to a root mean square error of `target` (units of the observable), from
    /// coupled paths: [`Integrate::multilevel`](crate::integrate::Integrate::multilevel) with the start, end, seed,
    /// observable, paths and threads of the ensemble. Its other settings have no meaning there, and are an error of the run.
    pub fn multilevel(self, target: f64) -> Multilevel<'a, H, E, Observed> {
        Multilevel::begun(self.setup).target(target)
    }
}

impl<'a, H: Discretized<E>, E> Multilevel<'a, H, E> {
    /// A run of `system` whose coarsest steps have size `h`: the largest step with which a path is still meaningful.
    pub fn new(system: &'a H, h: f64) -> Self {
        Self::begun(Setup::new(system, h))
    }

    /// The observable whose mean at the end of the paths is wanted, a function of the state. There is one.
    pub fn observe(
        mut self,
        name: impl Into<String>,
        observable: impl Fn(&State<H::Vector>) -> f64 + Send + Sync + 'a,
    ) -> Multilevel<'a, H, E, Observed> {
        self.setup.observables.push(name.into(), observable);
        Multilevel { setup: self.setup, levels: self.levels, types: PhantomData }
    }
}

impl<'a, H: Discretized<E>, E, O> Multilevel<'a, H, E, O> {
    options!(start, end, execution, instructions);

    fn begun(setup: Setup<'a, H>) -> Self {
        let levels = Levels { target: None, weak_order: 1.0, finest: MOST_LEVELS };
        Self { setup, levels, types: PhantomData }
    }

    /// The seed of its normals: level 0 has those of an ensemble with this seed and step size, finer levels have their own.
    pub fn seed(mut self, seed: u64) -> Self {
        self.setup.more.source = Some(Source::new(StepNormals::seed(seed)));
        self
    }

    /// Sets whether increments are truncated. The default is `k = 4` where
    /// [`Plan::truncates_increments`](crate::scheme::plan::Plan::truncates_increments) holds.
    pub fn truncation(mut self, truncation: Truncation) -> Self {
        self.setup.more.settings.truncation = truncation;
        self
    }

    /// The root mean square error that is wanted, in units of the observable.
    pub fn target(mut self, error: f64) -> Self {
        self.levels.target = Some(error);
        self
    }

    /// How many paths of each level, at most.
    pub fn paths(mut self, paths: u64) -> Self {
        self.setup.more.paths = Some(paths);
        self
    }

    /// Sets the weak order of the scheme, from which the remaining bias is estimated. The default is 1, which every consistent scheme has at
    /// least.
    pub fn weak_order(mut self, order: f64) -> Self {
        self.levels.weak_order = order;
        self
    }

    /// Sets the finest level, 20 by default. Its steps are `2^-level` times the coarsest.
    pub fn finest(mut self, level: u32) -> Self {
        self.levels.finest = level;
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
    pub fn run_in<const WIDTH: usize>(mut self) -> Result<MultilevelEstimate, Error> {
        let target = self.checked()?;
        let Levels { weak_order, finest, .. } = self.levels;
        let execution = std::mem::take(&mut self.setup.execution);
        let stop = || execution.is_stopped();
        let (end, paths) = (self.setup.span.end, self.setup.more.paths);
        self.setup.more.paths = Some(paths.unwrap_or(MOST_PATHS));
        let job = Ensemble::<H, E, StepNormals, Whole, Paired> { setup: self.setup, types: PhantomData }
            .job(&stop)?;
        check_end(end, &job)?;
        let progress = execution.progress("steps");
        Run {
            levels: vec![Stage::coarsest(job)],
            hands: (execution.threads()?, execution.instructions()),
            most_paths: paths.unwrap_or(MOST_PATHS),
            most_constant: paths.unwrap_or(MOST_CONSTANT),
            target,
            weak_order,
            finest: finest as usize,
            progress,
        }
        .run::<WIDTH>()
    }

    /// The target, of a run that makes sense.
    fn checked(&self) -> Result<f64, ConfigError> {
        let (setup, Levels { target, weak_order, finest }) = (&self.setup, self.levels);
        let wrong = |what: String| Err(wrong(what));
        if let Some(what) = refused(setup) {
            return wrong(format!("{what} in a multilevel run, where it has no meaning: leave it out"));
        }
        let target = target.ok_or(ConfigError::Missing("an error to reach: add `.target(error)`"))?;
        if setup.observables.is_empty() {
            return Err(ConfigError::Missing(OBSERVABLE));
        }
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
            return wrong(format!("a target of {}: take a finite number above 0", Brief(target)));
        }
        if !(weak_order.is_finite() && weak_order > 0.0) {
            return wrong(format!("a weak order of {}: take a finite number above 0", Brief(weak_order)));
        }
        if !(LEAST_LEVELS as u32 - 1..=40).contains(&finest) {
            return wrong(format!("level {finest} as the finest: take 2 to 40"));
        }
        Ok(target)
    }
}

/// Settings of an ensemble that have no meaning here.
fn refused<H: Hamiltonian>(setup: &Setup<'_, H>) -> Option<&'static str> {
    let Setup {
        system: _,
        h: _,
        span,
        recorded,
        observables: _,
        sections,
        retry,
        is_watched,
        execution: _,
        keeping,
        more,
    } = setup;
    let Many { starts, systems, paths: _, source, settings, own, events, wanted, inspector, control } = more;
    let Extras { quantiles, covariances, histograms, most_bytes, most_crossings, has_work, added } = wanted;
    let (Settings { is_antithetic, truncation: _ }, Control { targets, losses }) = (settings, control);
    let Request { every, times } = recorded;
    let refused = [
        (*is_antithetic || source.as_ref().is_some_and(Source::is_antithetic), "antithetic paths"),
        (
            source.as_ref().is_some_and(|source| source.normals().is_none()),
            "a noise that is not `StepNormals`",
        ),
        (systems.is_some(), "paths that have systems of their own"),
        (starts.is_some() && span.start.is_none(), "paths that start at states of their own"),
        (!own.is_empty(), "observables of each path's own system"),
        (!events.is_empty(), "first passages"),
        (!sections.is_empty(), "sections"),
        (span.is_exact, "an exact end"),
        (*quantiles || !histograms.is_empty(), "quantiles and histograms"),
        (covariances.is_some(), "covariances"),
        (most_bytes.is_some() || *most_crossings > 0, "kept paths and crossings"),
        (every.is_some() || !times.is_empty(), "recorded times"),
        (inspector.is_some(), "`inspect`"),
        (keeping.is_set(), "`checkpoint`"),
        (*has_work, "work and heat"),
        (!added.is_empty(), "statistics of its own"),
        (retry.most() > 0, "`retry`"),
        (!is_watched, "`unwatched`"),
        (!targets.is_empty(), "`until_error`"),
        (losses.is_some(), "`allow_losses`"),
    ];
    refused.into_iter().find_map(|(is_asked, what)| is_asked.then_some(what))
}

const OBSERVABLE: &str = "an observable: add `.observe(name, function)`";

fn wrong(what: impl Into<String>) -> ConfigError {
    ConfigError::Setting(what.into())
}

/// Whether the coarsest steps end where the run shall: all levels end there.
fn check_end<H: Discretized<E>, E>(end: Option<End>, job: &Job<'_, H, E>) -> Result<(), ConfigError> {
    let Grid { start, h, steps, .. } = job.grid;
    if steps == 0 {
        return Err(wrong("a multilevel run without a step: take a later end"));
    }
    let Some(End::Time(end)) = end else { return Ok(()) };
    let (reached, span) = (job.grid.time(steps), end - start);
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
struct Run<'a, H: Discretized<E>, E> {
    levels: Vec<Stage<'a, H, E>>,
    hands: (usize, InstructionSet),
    most_paths: u64,
    /// Paths of the first level, at most, as long as the observable is the same on all.
    most_constant: u64,
    target: f64,
    weak_order: f64,
    finest: usize,
    progress: ProgressLine,
}

/// One level: an ensemble of pairs, with what is known of it.
struct Stage<'a, H: Discretized<E>, E> {
    job: Job<'a, H, E>,
    found: Statistics,
}

impl<'a, H: Discretized<E>, E> Stage<'a, H, E> {
    /// From the ensemble in the coarsest steps, of which the end counts.
    fn coarsest(mut job: Job<'a, H, E>) -> Self {
        job.recorded.drain(..job.recorded.len().saturating_sub(1));
        // All chunks are whole: a level goes on after its last one.
        job.paths = u64::MAX;
        let node = StatisticsNode::new(2, false, (false, false), Vec::new());
        let nodes = Nodes::new(&[job.grid.time(job.steps)], &node, Vec::new());
        job.empty = Statistics::new(["fine", "difference"].map(str::to_owned).into(), nodes);
        Self { found: job.empty.clone(), job }
    }

    fn count(&self) -> u64 {
        self.found.begun()
    }

    /// Whether the observable is the same number on all paths.
    fn is_constant(&self) -> bool {
        self.found.last().is_some_and(|end| end.is_constant(FINE))
    }

    /// Steps of a path: of a fine one, and of the coarse one beside it.
    fn steps(&self) -> u64 {
        let Job { steps, level, .. } = self.job;
        if level == 0 { steps } else { steps + steps / 2 }
    }

    /// Of so many paths.
    fn cost(&self, paths: u64) -> u64 {
        paths.saturating_mul(self.steps())
    }
}

/// Paths after which a level may end: few on the finest, which need few; on the coarsest as many as make the steps about as many.
fn least_paths(level: u32) -> u64 {
    BESIDE << 4u32.saturating_sub(level)
}

impl<H, E> Run<'_, H, E>
where
    H: Discretized<E> + Sync,
{
    fn run<const WIDTH: usize>(mut self) -> Result<MultilevelEstimate, Error> {
        while self.levels.len() < LEAST_LEVELS {
            self.add_level()?;
        }
        let mut wanted = vec![FIRST_PATHS; LEAST_LEVELS];
        loop {
            if self.sample::<WIDTH>(&wanted)?.is_break() {
                return Ok(self.estimate(true));
            }
            if let Some(base) = self.levels.first().filter(|base| base.is_constant()) {
                // Nothing says how far others may be from it: look for them.
                let count = base.count();
                if count >= self.most_constant {
                    return Ok(self.estimate(false));
                }
                wanted = vec![0; self.levels.len()];
                wanted[0] = count.saturating_mul(2).min(self.most_constant);
                continue;
            }
            let best = self.best_numbers();
            let counts = || self.levels.iter().map(Stage::count);
            let is_enough = best.iter().zip(counts()).all(|(best, count)| {
                count >= self.most_paths || *best as f64 <= count as f64 * (1.0 + TOLERANCE)
            });
            // The bound of what has not been seen falls with the number of paths: no level more than doubles before the next look, or a first look that
            // saw nothing would ask for far too many.
            wanted =
                best.iter().zip(counts()).map(|(best, count)| count.saturating_mul(2).min(*best)).collect();
            if is_enough {
                let left = bias(&self.ends(), self.weak_order);
                if left <= BIAS_PART.sqrt() * self.target || self.levels.len() > self.finest {
                    return Ok(self.estimate(false));
                }
                self.add_level()?;
                wanted.push(FIRST_PATHS);
            }
        }
    }

    fn add_level(&mut self) -> Result<(), Error> {
        if let Some(Stage { job, .. }) = self.levels.last() {
            let job = job.finer()?;
            self.levels.push(Stage { found: job.empty.clone(), job });
        }
        Ok(())
    }

    /// Runs paths of each level until there are so many; breaks if the run was stopped.
    fn sample<const WIDTH: usize>(&mut self, wanted: &[u64]) -> Result<ControlFlow<()>, Error> {
        let Self { levels, progress, hands, most_paths, .. } = self;
        let cost = |(stage, paths): (&Stage<'_, H, E>, &u64)| stage.cost(*paths);
        let all = levels.iter().zip(wanted).map(cost).fold(0, u64::saturating_add);
        let mut before = 0u64;
        for (level, wanted) in wanted.iter().enumerate() {
            let (coarser, finer) = levels.split_at_mut(level);
            let missing = || InternalError::new("a level that has paths is there", level);
            let stage = finer.first_mut().ok_or_else(missing)?;
            let coarse = coarser.last().map(|stage| &stage.job);
            let first = stage.count() / BESIDE;
            let end = wanted.min(most_paths).next_multiple_of(least_paths(stage.job.level)) / BESIDE;
            let steps = stage.steps();
            let Stage { job, found } = &mut *stage;
            let mut outcome = Ok(ControlFlow::Continue(()));
            in_chunks::<H, E, Paired, WIDTH>(job, coarse, first..end.max(first), *hands, |chunk| {
                match chunk.and_then(|chunk| Ok(found.merge(&chunk).map_err(Error::from)?)) {
                    Ok(()) => {
                        progress.show(before.saturating_add(found.begun().saturating_mul(steps)), all);
                        return ControlFlow::Continue(());
                    }
                    Err(Halt::Stopped) => outcome = Ok(ControlFlow::Break(())),
                    Err(Halt::Failed(error)) => outcome = Err(error),
                }
                ControlFlow::Break(())
            });
            if outcome?.is_break() {
                return Ok(ControlFlow::Break(()));
            }
            before = before.saturating_add(stage.cost(stage.count()));
        }
        Ok(ControlFlow::Continue(()))
    }

    /// The numbers of paths that reach the target at the least cost, as far as the variances are known.
    fn best_numbers(&self) -> Vec<u64> {
        let ends = self.ends();
        let slope = variance_slope(&ends).unwrap_or(1.0).clamp(0.5, 4.0);
        let mut variances: Vec<f64> = Vec::new();
        for (level, mut variance) in variance_bounds(&ends).into_iter().enumerate() {
            if let Some(coarser) = variances.last().filter(|_| level >= 2) {
                // A few paths may miss rare events.
                variance = variance.max(0.5 * coarser / 2f64.powf(slope));
            }
            variances.push(variance);
        }
        let costs: Vec<f64> = self.levels.iter().map(|stage| stage.steps() as f64).collect();
        let sum: f64 = variances.iter().zip(&costs).map(|(variance, cost)| (variance * cost).sqrt()).sum();
        let scale = sum / ((1.0 - BIAS_PART) * self.target * self.target);
        let number = |(variance, cost): (&f64, &f64)| {
            // Infinite numbers become the largest integer.
            let best = ((variance / cost).sqrt() * scale).ceil() as u64;
            best.max(FIRST_PATHS).min(self.most_paths)
        };
        variances.iter().zip(&costs).map(number).collect()
    }

    /// What is known of each level.
    fn ends(&self) -> Vec<&StatisticsNode> {
        self.levels.iter().filter_map(|stage| stage.found.last()).collect()
    }

    fn estimate(&self, is_partial: bool) -> MultilevelEstimate {
        let is_constant = self.levels.first().is_none_or(Stage::is_constant);
        let known = self.levels.iter().filter(|stage| stage.count() > 0);
        let known = known.filter_map(|stage| Some((stage.job.h, stage.steps(), stage.found.last()?)));
        let met = |error: f64, bias: f64| {
            !is_partial
                && !is_constant
                // What the tolerance on the numbers of paths may add.
                && error * error <= (1.0 + TOLERANCE) * (1.0 - BIAS_PART) * self.target * self.target
                && bias <= BIAS_PART.sqrt() * self.target
        };
        MultilevelEstimate::new(known, self.weak_order, is_partial, is_constant, met)
    }
}
