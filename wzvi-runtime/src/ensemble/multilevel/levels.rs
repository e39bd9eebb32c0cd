//! The levels of a multilevel run, and how many paths each is to have.

use std::ops::ControlFlow;

use super::estimate::{FINE, MultilevelEstimate, bias, variance_bounds, variance_slope};
use crate::algebra::lanes::instructions::InstructionSet;
use crate::algebra::scalar::Scalar;
use crate::ensemble::chunk::{PATHS, in_chunks};
use crate::ensemble::job::EnsembleJob;
use crate::ensemble::run_identity::described;
use crate::ensemble::starts::Paired;
use crate::error::InternalError;
use crate::ground::numbers::{Numbers, Tape};
use crate::ground::progress::ProgressLine;
use crate::scheme::system::Discretized;
use crate::statistics::{RecordedNodes, Statistics, StatisticsNode};
use crate::trajectory::Error;
use crate::trajectory::checkpoint::{CheckpointKeeper, CheckpointKind, CheckpointSetting, RunExtent};

/// The part `θ` of the squared error that is allowed for the bias.
const BIAS_PART: f64 = 0.25;
/// Paths of a new level at least, to learn its variance from.
const FIRST_PATHS: u64 = 256;
/// A bias is not estimated from fewer levels.
pub(super) const LEAST_LEVELS: usize = 3;
/// Numbers of paths this close to the best ones are good enough.
const TOLERANCE: f64 = 0.01;

/// A checked run.
pub(super) struct MultilevelRun<'a, H: Discretized<E>, E> {
    /// The ensembles of pairs, by level.
    jobs: Vec<EnsembleJob<'a, H, E>>,
    reached: LevelProgress,
    limits: RunLimits,
    keeper: CheckpointKeeper,
    hands: (usize, InstructionSet),
    progress: ProgressLine,
}

/// How far a run may go.
pub(super) struct RunLimits {
    pub(super) target: f64,
    pub(super) weak_order: f64,
    pub(super) finest: u32,
    pub(super) most_paths: u64,
    /// Paths of the first level, at most, as long as the observable is the same on all.
    pub(super) most_constant: u64,
}

/// How far a run has come, by level.
struct LevelProgress {
    /// How many paths there shall be before the next look.
    wanted: Vec<u64>,
    found: Vec<Statistics>,
}

/// Levels that a checkpoint has are added to those that nothing is known of.
impl Numbers for LevelProgress {
    fn pass(&mut self, tape: &mut Tape) {
        let Self { wanted, found } = self;
        let levels = tape.length(found.len());
        if let Some(unknown) = found.first().filter(|_| tape.is_reading()).cloned() {
            found.resize(levels, unknown);
        }
        wanted.pass(tape);
        found.iter_mut().for_each(|level| level.pass(tape));
        if wanted.len() != found.len() {
            tape.refuse();
        }
    }
}

impl LevelProgress {
    fn count(&self, level: usize) -> u64 {
        self.found.get(level).map_or(0, Statistics::begun)
    }

    /// Chunks of all levels.
    fn chunks(&self) -> u64 {
        self.found.iter().map(|level| level.begun() / PATHS).sum()
    }

    /// Whether the observable is the same number on all paths.
    fn is_constant(&self) -> bool {
        self.found.first().and_then(Statistics::last).is_none_or(|end| end.is_constant(FINE))
    }

    /// The statistics of each level at the end of its paths.
    fn ends(&self) -> Vec<&StatisticsNode> {
        self.found.iter().filter_map(Statistics::last).collect()
    }
}

/// The statistics of a level, of no path yet.
fn known<H: Discretized<E>, E>(job: &EnsembleJob<'_, H, E>) -> Statistics {
    let node = StatisticsNode::new(2, false, (false, false), Vec::new());
    let nodes = RecordedNodes::new(&[job.grid.time(job.grid.steps)], &node, Vec::new());
    Statistics::new(["fine", "difference"].map(str::to_owned).into(), nodes)
}

/// The coarsest level, from the ensemble in its steps, of which the end counts.
fn coarsest<'a, H: Discretized<E>, E>(mut job: EnsembleJob<'a, H, E>) -> EnsembleJob<'a, H, E> {
    job.observed.recorded.drain(..job.observed.recorded.len().saturating_sub(1));
    // All chunks are whole: a level goes on after its last one.
    (job.paths, job.chunk) = (u64::MAX, PATHS);
    job.observed.empty = known(&job);
    job
}

/// Steps of a path: of a fine one, and of the coarse one beside it.
fn steps<H: Discretized<E>, E>(job: &EnsembleJob<'_, H, E>) -> u64 {
    if job.level == 0 { job.grid.steps } else { job.grid.steps + job.grid.steps / 2 }
}

/// The least number of paths of a level. Coarse levels get more, so that all levels take about as many steps.
fn least_paths(level: u32) -> u64 {
    PATHS << 4u32.saturating_sub(level)
}

impl<'a, H, E> MultilevelRun<'a, H, E>
where
    H: Discretized<E> + Sync,
{
    /// The run whose coarsest level is `job`, as far as its checkpoint says.
    pub(super) fn begun(
        job: EnsembleJob<'a, H, E>,
        limits: RunLimits,
        keeping: CheckpointSetting,
        hands: (usize, InstructionSet),
        progress: ProgressLine,
    ) -> Result<Self, Error> {
        let found = vec![known(&job); LEAST_LEVELS];
        let mut reached = LevelProgress { wanted: vec![FIRST_PATHS; LEAST_LEVELS], found };
        let mut keeper = CheckpointKeeper::default();
        if keeping.is_set() {
            let RunLimits { target, weak_order, finest, most_paths, most_constant } = limits;
            let settings = vec![
                ("the target", format!("{target:?}")),
                ("the weak order", format!("{weak_order:?}")),
                ("the finest level", finest.to_string()),
                ("the most paths of a level", most_paths.to_string()),
                ("the most paths of an observable with one value", most_constant.to_string()),
            ];
            let extent = RunExtent { kind: CheckpointKind::Multilevel, all: u64::MAX, unit: PATHS };
            keeper = keeping.open(extent, described(&job, settings)?, &mut |tape| reached.pass(tape))?;
        }
        let mut jobs = vec![coarsest(job)];
        while let Some(finest) = jobs.last().filter(|_| jobs.len() < reached.found.len()) {
            jobs.push(finest.finer()?);
        }
        Ok(Self { jobs, reached, limits, keeper, hands, progress })
    }

    /// Runs until the target is met, a limit reached or the run stopped.
    pub(super) fn run<const WIDTH: usize>(mut self) -> Result<MultilevelEstimate, Error> {
        let is_partial = loop {
            if self.sample::<WIDTH>()?.is_break() {
                break true;
            }
            match self.paths_needed() {
                Some(wanted) => self.reached.wanted = wanted,
                None => break false,
            }
            if self.reached.wanted.len() > self.jobs.len() {
                self.add_level()?;
            }
        };
        let Self { keeper, reached, .. } = &mut self;
        keeper.close(reached.chunks(), &mut |tape| reached.pass(tape))?;
        Ok(self.estimate(is_partial))
    }

    /// How many paths of each level there shall be, of one more level than before if these are not enough;
    /// `None` if they are.
    fn paths_needed(&self) -> Option<Vec<u64>> {
        let Self { reached, limits, .. } = self;
        if reached.is_constant() {
            // Nothing says how far others may be from it: look for them.
            let (count, mut wanted) = (reached.count(0), vec![0; self.jobs.len()]);
            *wanted.first_mut()? = count.saturating_mul(2).min(limits.most_constant);
            return (count < limits.most_constant).then_some(wanted);
        }
        let best = self.best_numbers();
        let counts = || reached.found.iter().map(Statistics::begun);
        let is_enough = best.iter().zip(counts()).all(|(best, count)| {
            count >= limits.most_paths || *best as f64 <= count as f64 * (1.0 + TOLERANCE)
        });
        // The bound of what has not been seen falls with the number of paths: no level more than doubles
        // before the next look, or a first look that saw nothing would ask for far too many.
        let mut wanted: Vec<u64> =
            best.iter().zip(counts()).map(|(best, count)| count.saturating_mul(2).min(*best)).collect();
        if is_enough {
            let left = bias(&reached.ends(), limits.weak_order);
            if left <= BIAS_PART.sqrt() * limits.target || self.jobs.len() > limits.finest as usize {
                return None;
            }
            wanted.push(FIRST_PATHS);
        }
        Some(wanted)
    }

    fn add_level(&mut self) -> Result<(), Error> {
        if let Some(finest) = self.jobs.last() {
            let job = finest.finer()?;
            self.reached.found.push(job.observed.empty.clone());
            self.jobs.push(job);
        }
        Ok(())
    }

    /// Runs paths of each level until there are as many as wanted; breaks if the run was stopped.
    fn sample<const WIDTH: usize>(&mut self) -> Result<ControlFlow<()>, Error> {
        let Self { jobs, reached, limits, keeper, hands, progress } = self;
        let cost = |(job, paths): (&EnsembleJob<'_, H, E>, &u64)| paths.saturating_mul(steps(job));
        let all = jobs.iter().zip(&reached.wanted).map(cost).fold(0, u64::saturating_add);
        let (mut before, mut coarse) = (0u64, None);
        for (level, job) in jobs.iter().enumerate() {
            let missing = || InternalError::new("a level that has paths is there", level);
            let wanted = *reached.wanted.get(level).ok_or_else(missing)?;
            let first = reached.count(level) / PATHS;
            let end = wanted.min(limits.most_paths).next_multiple_of(least_paths(job.level)) / PATHS;
            let mut outcome = Ok(ControlFlow::Continue(()));
            in_chunks::<H, E, Paired, WIDTH>(job, coarse, first..end.max(first), *hands, |chunk| {
                let take = || {
                    let found = reached.found.get_mut(level).ok_or_else(missing)?;
                    found.merge(&chunk?)?;
                    progress.show(before.saturating_add(cost((job, &found.begun()))), all);
                    if keeper.is_due(reached.chunks()) {
                        keeper.save(reached.chunks(), &mut |tape| reached.pass(tape))?;
                    }
                    Ok(())
                };
                outcome = match take() {
                    Ok(()) => return ControlFlow::Continue(()),
                    Err(Error::Stopped(_)) => Ok(ControlFlow::Break(())),
                    Err(error) => Err(error),
                };
                ControlFlow::Break(())
            });
            if outcome?.is_break() {
                return Ok(ControlFlow::Break(()));
            }
            before = before.saturating_add(cost((job, &reached.count(level))));
            coarse = Some(job);
        }
        Ok(ControlFlow::Continue(()))
    }

    /// The numbers of paths that reach the target at the least cost, as far as the variances are known.
    fn best_numbers(&self) -> Vec<u64> {
        let ends = self.reached.ends();
        let slope = variance_slope(&ends).unwrap_or(1.0).clamp(0.5, 4.0);
        let mut variances: Vec<f64> = Vec::new();
        for (level, mut variance) in variance_bounds(&ends).into_iter().enumerate() {
            if let Some(coarser) = variances.last().filter(|_| level >= 2) {
                // A few paths may miss rare events.
                variance = variance.max(0.5 * coarser / Scalar::exp2(slope));
            }
            variances.push(variance);
        }
        let costs: Vec<f64> = self.jobs.iter().map(|job| steps(job) as f64).collect();
        let sum: f64 = variances.iter().zip(&costs).map(|(variance, cost)| (variance * cost).sqrt()).sum();
        let scale = sum / ((1.0 - BIAS_PART) * Scalar::powi(self.limits.target, 2));
        let number = |(variance, cost): (&f64, &f64)| {
            // Infinite numbers become the largest integer.
            let best = ((variance / cost).sqrt() * scale).ceil() as u64;
            best.max(FIRST_PATHS).min(self.limits.most_paths)
        };
        variances.iter().zip(&costs).map(number).collect()
    }

    fn estimate(&self, is_partial: bool) -> MultilevelEstimate {
        let is_constant = self.reached.is_constant();
        let known = self.jobs.iter().zip(&self.reached.found).filter(|(_, found)| found.begun() > 0);
        let known = known.filter_map(|(job, found)| Some((job.grid.h, steps(job), found.last()?)));
        let met = |error: f64, bias: f64| {
            !is_partial
                && !is_constant
                // The tolerance on the numbers of paths may add this much.
                && error * error <= (1.0 + TOLERANCE) * (1.0 - BIAS_PART) * self.limits.target * self.limits.target
                && bias <= BIAS_PART.sqrt() * self.limits.target
        };
        let mut estimate =
            MultilevelEstimate::new(known, self.limits.weak_order, is_partial, is_constant, met);
        estimate.unsaved = self.keeper.unsaved();
        estimate
    }
}
