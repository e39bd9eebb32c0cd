//! Multilevel Monte Carlo: the mean of an observable at the cost of coarse steps.
//!
//! M. B. Giles, "Multilevel Monte Carlo path simulation", Oper. Res. 56 (2008) 607; "Multilevel Monte Carlo
//! methods", Acta Numerica 24 (2015) 259, whose letters these are. With `P_l` the observable at the end in
//! steps of `h_l = h / 2^l`,
//!
//! ```text
//! E P_L = E P_0 + Σ_{l=1..L} E[P_l - P_{l-1}]
//! ```
//!
//! and both terms of a difference run on the same Brownian path, so that its variance `V_l` falls with `l`
//! like `h_l²` for a scheme of strong order one. With `C_l` steps per path, the variance `Σ V_l / N_l` is
//! kept below its part of the error at the least cost by
//!
//! ```text
//! N_l = ⌈ √(V_l / C_l) Σ_k √(V_k C_k) / ((1 - θ) ε²) ⌉
//! ```
//!
//! Levels are added until the remaining bias, estimated from the last differences, is below `√θ ε`. The cost
//! of an error `ε` is then of order `ε^-2`, where one step size alone takes `ε^-3` with weak order one.
//!
//! The two paths of a difference have the normals `ξ_1, ξ_2` and `(ξ_1 + ξ_2)/√2`, each truncated with the
//! bound of its own step size: `P_{l-1}` has the same law on both levels where it occurs, and the sum
//! telescopes exactly.

mod estimate;
mod levels;

use std::marker::PhantomData;

pub use crate::trajectory::error::{LevelError, LevelFailure};
pub use estimate::{Level, MultilevelEstimate};
use levels::{LEAST_LEVELS, MultilevelRun, RunLimits};

use super::job::EnsembleJob;
use super::made_settings::made_of;
use super::source::NoiseSource;
use super::starts::Paired;
use super::{Ensemble, EnsembleSetup};
use crate::algebra::state::State;
use crate::error::{ConfigError, above_zero, wrong};
use crate::ground::digits::ShortestDecimal;
use crate::noise::{StepNormals, Truncation};
use crate::scheme::plan::NoiseClass;
use crate::scheme::system::Discretized;
use crate::trajectory::Error;
use crate::trajectory::checkpoint::{Checkpoint, CheckpointSetting};
use crate::trajectory::exclusive_setting::ExclusiveSetting;
use crate::trajectory::made_settings::MadeSetting;
use crate::trajectory::options::options;
use crate::trajectory::span::{NodeGrid, RunEnd, whole_steps};

/// The default of the finest level: steps a million times shorter than the coarsest.
const MOST_LEVELS: u32 = 20;
/// The default of the largest number of paths of a level.
const MOST_PATHS: u64 = 1 << 50;
/// Paths of the coarsest level after which an observable with one value throughout is given up, unless the
/// user sets the number.
const MOST_CONSTANT: u64 = 1 << 20;

/// Nothing is observed yet.
#[derive(Clone, Copy, Debug)]
pub enum Nothing {}

/// One observable, whose mean is wanted.
#[derive(Clone, Copy, Debug)]
pub enum Observed {}

/// A multilevel run: the mean of one observable at the end, to a root mean square error, from coupled paths
/// in steps of `h, h/2, h/4, ...`. [`Integrate::multilevel`](crate::integrate::Integrate::multilevel) begins
/// it, [`Multilevel::run`] runs it.
///
/// A run needs a start, an end, a seed, one observable and a target. `O` says whether there is an observable.
/// Other settings of an [`Ensemble`], such as quantiles, have no meaning here.
#[must_use = "nothing happens before `run`"]
pub struct Multilevel<'a, H: Discretized<E>, E, O = Nothing> {
    setup: EnsembleSetup<'a, H>,
    levels: LevelSettings,
    types: PhantomData<fn() -> (E, O)>,
}

/// Settings of levels only.
#[derive(Clone)]
struct LevelSettings {
    target: ExclusiveSetting<f64>,
    /// The weak order that the user sets; `None` means that of the scheme.
    weak_order: Option<f64>,
    finest: u32,
}

impl<'a, H: Discretized<E>, E> Ensemble<'a, H, E> {
    /// The mean of the one observable at the end, to a root mean square error of `target` (units of the
    /// observable), from coupled paths: [`Integrate::multilevel`](crate::integrate::Integrate::multilevel)
    /// with the start, end, seed, observable, paths and threads of the ensemble. Its other settings have no
    /// meaning there, and are an error of the run.
    pub fn multilevel(self, target: f64) -> Multilevel<'a, H, E, Observed> {
        let mut run = Multilevel::begun(self.setup);
        run.levels.target.set("multilevel", ShortestDecimal(target), target);
        run
    }
}

impl<'a, H: Discretized<E>, E> Multilevel<'a, H, E> {
    /// A run of `system` whose coarsest steps have size `h`: the largest step with which a path is still
    /// meaningful.
    pub fn new(system: &'a H, h: f64) -> Self {
        Self::begun(EnsembleSetup::new(system, h))
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

    fn begun(setup: EnsembleSetup<'a, H>) -> Self {
        let levels =
            LevelSettings { target: ExclusiveSetting::default(), weak_order: None, finest: MOST_LEVELS };
        Self { setup, levels, types: PhantomData }
    }

    /// The seed of its normals: level 0 has those of an ensemble with this seed and step size, finer levels
    /// have their own. Noise belongs to the time at which it acts: from another start time it is another.
    pub fn seed(mut self, seed: u64) -> Self {
        self.setup.more.source.set("seed", seed, NoiseSource::new(StepNormals::seed(seed)));
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
        self.levels.target.set("target", ShortestDecimal(error), error);
        self
    }

    /// How many paths of each level, at most, rounded up to what a level takes at once: 1024 on the coarsest,
    /// 64 from the fifth on.
    pub fn paths(mut self, paths: u64) -> Self {
        self.setup.more.paths = Some(paths);
        self
    }

    /// Sets the weak order from which the remaining bias is estimated. The default is the one that
    /// [`Plan::weak_order`](crate::scheme::plan::Plan::weak_order) proves for the scheme. Set a lower one for
    /// an observable that is not smooth, such as an indicator. A higher one is an error of the run: with a
    /// wrong order the remaining bias is underestimated, and the target is missed without a sign of it.
    pub fn weak_order(mut self, order: f64) -> Self {
        self.levels.weak_order = Some(order);
        self
    }

    /// Resumes from the checkpoint if its file exists and belongs to this run, and writes checkpoints during
    /// the run and at its end, as [`Ensemble::checkpoint`] does. The target, the weak order and the largest
    /// numbers of levels and paths are part of what makes two runs the same.
    pub fn checkpoint(mut self, checkpoint: Checkpoint) -> Self {
        self.setup.keeping = CheckpointSetting::to(checkpoint);
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
    /// Runs as many paths on as many levels as it takes. The result is the same, bit for bit, for any number
    /// of threads.
    ///
    /// # Errors
    /// [`Error::Config`] if a setting is missing or invalid, or if a level has no step. [`Error::Level`] if a
    /// path fails or its observable is not finite, since the mean without it would be biased.
    /// [`Error::Checkpoint`] if the file is not a checkpoint of this run.
    pub fn run(self) -> Result<MultilevelEstimate, Error> {
        self.run_in::<0>()
    }

    /// [`Multilevel::run`] with `WIDTH` paths beside each other, with 0 as many as suit the instructions; the
    /// result is the same.
    #[doc(hidden)]
    pub fn run_in<const WIDTH: usize>(mut self) -> Result<MultilevelEstimate, Error> {
        let (target, weak_order) = self.checked()?;
        let finest = self.levels.finest;
        let execution = std::mem::take(&mut self.setup.execution);
        let stop = || execution.is_stopped();
        let (span, paths) = (&mut self.setup.span, self.setup.more.paths);
        // Steps of all levels end at the nodes of the coarsest: beyond the requested end only where the user
        // says so.
        let end = if span.is_whole { None } else { span.end.value().copied() };
        span.is_whole = true;
        self.setup.more.paths = Some(paths.unwrap_or(MOST_PATHS));
        let keeping = std::mem::take(&mut self.setup.keeping);
        let job =
            Ensemble::<H, E, StepNormals, Paired> { setup: self.setup, types: PhantomData }.job(&stop)?;
        check_end(end, &job)?;
        let [most_paths, most_constant] = [MOST_PATHS, MOST_CONSTANT].map(|most| paths.unwrap_or(most));
        let limits = RunLimits { target, weak_order, finest, most_paths, most_constant };
        let hands = (execution.threads()?, execution.instructions());
        MultilevelRun::begun(job, limits, keeping, hands, execution.progress("steps"))?.run::<WIDTH>()
    }

    /// The target and the weak order, of a run that makes sense.
    fn checked(&self) -> Result<(f64, f64), ConfigError> {
        let (setup, LevelSettings { target, weak_order, finest }) = (&self.setup, self.levels.clone());
        MadeSetting::refuse("multilevel", made_of(setup), USED)?;
        let target = target
            .checked("a run has one target")?
            .ok_or(ConfigError::Missing("an error to reach: add `.target(error)`"))?;
        if setup.observables.is_empty() {
            return Err(ConfigError::Missing(OBSERVABLE));
        }
        if !H::PLAN.consistent {
            return wrong(
                "a multilevel run of a scheme that does not converge to the system: its levels add up to another limit; take `Corrected<...>` \
                 or `Midpoint`",
            );
        }
        if matches!(H::PLAN.noise, NoiseClass::None) {
            return wrong("a multilevel run of a system without noise: one path says it all");
        }
        above_zero(target, |target| format!("a target of {target}"))?;
        let known = H::PLAN.weak_order().unwrap_or(1.0);
        let weak_order = weak_order.unwrap_or(known);
        above_zero(weak_order, |order| format!("a weak order of {order}"))?;
        if weak_order > known {
            return wrong(format!(
                "a weak order of {weak_order}, where {known} is proven for this scheme and system (`PLAN.weak_order()`): leave `.weak_order(...)` out"
            ));
        }
        if !(LEAST_LEVELS as u32 - 1..=40).contains(&finest) {
            return wrong(format!("level {finest} as the finest: take 2 to 40"));
        }
        Ok((target, weak_order))
    }
}

/// The settings of an ensemble that a multilevel run takes.
const USED: &[MadeSetting] =
    &[MadeSetting::Observe, MadeSetting::Checkpoint, MadeSetting::Handle, MadeSetting::StopWhen];

const OBSERVABLE: &str = "an observable: add `.observe(name, function)`";

/// Whether the coarsest steps end where the run shall: all levels end there.
fn check_end<H: Discretized<E>, E>(
    end: Option<RunEnd>,
    job: &EnsembleJob<'_, H, E>,
) -> Result<(), ConfigError> {
    let NodeGrid { start, h, steps, .. } = job.grid;
    match end {
        Some(RunEnd::Time(end)) => whole_steps(start, end, h).map(drop),
        _ if steps == 0 => wrong("a multilevel run without a step: take a later end"),
        _ => Ok(()),
    }
}
