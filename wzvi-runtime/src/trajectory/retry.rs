//! Steps that fail are halved.
//!
//! A step of size `h` becomes `2^m` steps of size `h / 2^m`, with the increments that the same Wiener path
//! has there, so that the retry converges to the same solution. Only the step that failed is subdivided,
//! unless the energy has changed (below).
//!
//! Without noise, `2^m` parts are accepted when they agree with `2^(m-1)` parts. A solution alone is not
//! enough, since a step that skips a pericentre often has one. The difference of the two is weighted by the
//! slopes of the energy, and compared with the mean of `p · dq/dt` (`AGREEMENT` in `watch.rs`). With noise,
//! no step is closer to the exact path than its strong order allows, and any parts that have a solution are
//! accepted.
//!
//! A run whose energy has changed ([`StepFailure::Unresolved`]) cannot be repaired at that point. It starts
//! again with all its steps subdivided once more, so that they stay uniform.

use std::ops::Range;

use crate::algebra::memory::Threads;
use crate::algebra::state::{State, Vector};
use crate::algebra::state_sum::StateSum;
use crate::error::{ConfigError, InternalError, StepError, StepFailure, wrong};
use crate::increments::{Interval, Noise, NoiseError};
use crate::scheme::plan::NoiseClass;
use crate::scheme::system::{Discretized, Hamiltonian, MemoryOf, SumOf};
use crate::trajectory::Error;
use crate::trajectory::following::Following;
use crate::trajectory::span::NodeGrid;
use crate::trajectory::step::{StepInfo, Stepper};
use crate::trajectory::steps::{SinglePath, StepToTake};
use crate::trajectory::watch::{AGREEMENT, EnergyMonitor, disagreement};

/// How often steps may be halved. The default is never, because the long-time behaviour of a symplectic
/// scheme depends on uniform steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Retry {
    most: u32,
}

impl Retry {
    /// No step is halved: the default.
    pub const fn never() -> Self {
        Self { most: 0 }
    }

    /// Halves a step at most `most` times, into `2^most` parts; `most` is 30 at most.
    pub const fn halving(most: u32) -> Self {
        Self { most: if most < 30 { most } else { 30 } }
    }

    /// The most halvings.
    pub const fn most(self) -> u32 {
        self.most
    }
}

/// How the steps of a run are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StepDivision {
    /// As they are, and in halves only where they fail.
    Whole,
    /// All in `2^halvings` parts at least.
    Halved(u32),
    /// The last one, which is shorter, in `2^halvings` parts at least.
    Last(u32),
    /// As they are, of a path in whose steps something may happen.
    Followed,
}

fn stepper<'a, H: Discretized<E>, E, C: StateSum<f64>>(
    system: &'a H,
    h: f64,
    threads: Threads,
) -> Result<Stepper<'a, H, E, C>, ConfigError> {
    Ok(Stepper::new(system, h)?.carrying().sharing(threads))
}

/// Takes the steps of a run, subdividing those that it has to and may.
pub(crate) struct Subdivision<'a, H: Discretized<E>, E, C = SumOf<H, E>> {
    system: &'a H,
    /// The step size of the run, and that of its present steps: the last one may be shorter.
    h: f64,
    size: f64,
    retry: Retry,
    is_watched: bool,
    threads: Threads,
    way: StepDivision,
    /// Monitors the energy of the steps of that way.
    pub(crate) watch: EnergyMonitor<H::Vector>,
    /// Takes the steps of that way.
    pub(crate) stepper: Stepper<'a, H, E, C>,
    /// Increments of a part of a step.
    part: Vec<f64>,
    /// The events in steps, and the end of a run by a clock, where there are any.
    pub(crate) following: Option<Box<Following<'a, H, E>>>,
}

/// Sees a part of a step: its stepper, its nodes, and its increments.
type PartObserver<'s, 'a, H, E, C> =
    &'s mut dyn FnMut(&Stepper<'a, H, E, C>, [&State<<H as Hamiltonian>::Vector>; 2], &[f64]);

impl<'a, H: Discretized<E>, E, C: StateSum<f64>> Subdivision<'a, H, E, C> {
    pub(crate) fn new(
        system: &'a H,
        h: f64,
        retry: Retry,
        is_watched: bool,
        threads: Threads,
    ) -> Result<Self, ConfigError> {
        let stepper = stepper(system, h, threads)?;
        let (way, watch) = (StepDivision::Whole, EnergyMonitor::of::<H, E>(is_watched, retry.most > 0));
        Ok(Self {
            system,
            h,
            size: h,
            retry,
            is_watched,
            threads,
            way,
            watch,
            stepper,
            part: Vec::new(),
            following: None,
        })
    }

    /// Takes steps in which something may happen.
    pub(crate) fn following(mut self, following: Following<'a, H, E>) -> Self {
        (self.way, self.following) = (StepDivision::Followed, Some(Box::new(following)));
        self
    }

    /// The subdivision of another run with the same settings.
    pub(crate) fn anew(&self) -> Result<Self, ConfigError> {
        Self::new(self.system, self.h, self.retry, self.is_watched, self.threads)
    }

    /// Takes steps of another size.
    fn stepper(&self, h: f64) -> Result<Stepper<'a, H, E, C>, ConfigError> {
        stepper(self.system, h, self.threads)
    }

    /// Subdivides every step of the run once more, if that may help against `error` and is allowed.
    pub(crate) fn refine(&mut self, error: &Error) -> Result<bool, ConfigError> {
        // A divided step whose halves do not agree is shorter than the steps of the run, and has been halved
        // as often as it may be.
        let own = self.stepper.step_size();
        let is_unresolved = match error {
            Error::Step(StepError {
                cause: StepFailure::Unresolved { .. } | StepFailure::UndefinedEnergy,
                h,
                ..
            }) => *h == own,
            _ => false,
        };
        let base = self.base();
        let may = is_unresolved && base < self.retry.most;
        if may {
            (self.way, self.size) = (StepDivision::Halved(base + 1), self.h);
            self.watch = EnergyMonitor::of::<H, E>(self.is_watched, self.retry.most > 0);
            self.stepper = self.stepper(part_of(self.h, base + 1))?;
        }
        Ok(may)
    }

    /// Whether the run has come to its end in the last step, before that of its steps.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn is_over(&self) -> bool {
        self.following.as_ref().is_some_and(|following| following.is_over)
    }

    /// Halvings of every step of this run.
    fn base(&self) -> u32 {
        match self.way {
            StepDivision::Halved(halvings) | StepDivision::Last(halvings) => halvings,
            StepDivision::Whole | StepDivision::Followed => 0,
        }
    }

    /// The size of its steps, without their halves.
    pub(crate) fn size(&self) -> f64 {
        self.size
    }

    /// Goes on with steps of this size: that of the run, or of a last step that is shorter.
    pub(crate) fn resize(&mut self, size: f64) -> Result<(), ConfigError> {
        if size != self.size {
            let (exchanged, base) = (self.stepper.account().clone(), self.base());
            let is_followed = self.way == StepDivision::Followed;
            let way = if is_followed { StepDivision::Followed } else { StepDivision::Last(base) };
            (self.stepper, self.way, self.size) = (self.stepper(part_of(size, base))?, way, size);
            self.stepper.set_exchanged(exchanged);
        }
        Ok(())
    }

    /// The memory of the scheme after the last step, if that was taken as a whole.
    pub(crate) fn memory(&self, taken: StepInfo) -> Option<&MemoryOf<H, E, f64>> {
        (self.way == StepDivision::Whole && taken.halvings == 0).then(|| self.stepper.memory())
    }

    /// The parts of a step that was halved so often, once more.
    #[cold]
    pub(crate) fn revisit<N: Noise>(
        &self,
        before: &State<H::Vector>,
        interval: Interval,
        noise: &mut Option<N>,
        halvings: u32,
        see: PartObserver<'_, 'a, H, E, C>,
    ) -> Result<(), Error> {
        let mut stepper = self.stepper(part_of(self.size, halvings))?;
        let (mut before, mut state) = (before.clone(), before.clone());
        let mut dw = vec![0.0; self.system.increments(before.q.components().len())];
        let (first, numbers) = parts(interval, self.size, halvings)?;
        let mut noise = PartNoise::of(noise, interval, self.size);
        let mut path =
            SinglePath { stepper: &mut stepper, state: &mut state, noise: &mut noise, dw: &mut dw, first };
        for part in numbers {
            let (stepper, step) = path.step(part);
            stepper.take_step(step)?;
            see(path.stepper, [&before, path.state], path.dw);
            before.clone_from(path.state);
        }
        Ok(())
    }

    /// A step in `2^from` parts, or as many more as it takes; `motion` is the mean of `p · dq/dt` along the
    /// path so far.
    #[cold]
    pub(crate) fn subdivide<N: Noise>(
        &mut self,
        step: StepToTake<'_, H::Vector, N>,
        from: u32,
        motion: Option<f64>,
    ) -> Result<StepInfo, Error> {
        let StepToTake { state, interval, noise, dw } = step;
        let (mut level, size) = (from, self.size);
        let mut coarse: Option<State<H::Vector>> = None;
        loop {
            let (mut end, before) = (state.clone(), self.stepper.account().clone());
            let step = StepToTake { state: &mut end, interval, noise: &mut *noise, dw: &mut *dw };
            let is_own = self.way == StepDivision::Halved(level) || self.way == StepDivision::Last(level);
            let outcome = if is_own {
                let Self { stepper, watch, part, .. } = self;
                // A last step that is shorter is none of the steps that the watch compares.
                let watch =
                    if self.way == StepDivision::Last(level) { &mut EnergyMonitor::default() } else { watch };
                take_parts(stepper, step, size, level, part, |stepper, step| watched(stepper, watch, step))
            } else {
                let mut finer = self.stepper(part_of(size, level))?;
                finer.set_exchanged(before.clone());
                let room = &mut self.part;
                let outcome =
                    take_parts(&mut finer, step, size, level, room, |stepper, step| stepper.take_step(step));
                self.stepper.set_exchanged(finer.account().clone());
                outcome
            };
            let error = match outcome {
                Ok(taken) => match self.unsettled(state, [coarse.as_ref().unwrap_or(state), &end], motion) {
                    Some(cause) if !is_own => {
                        coarse = Some(end);
                        StepError { step: interval.step, t: state.t, h: part_of(size, level), cause }
                    }
                    _ => {
                        end.t = if size == interval.h { interval.end() } else { interval.begin() + size };
                        *state = end;
                        return Ok(taken);
                    }
                },
                Err(Error::Step(error)) if is_curable(error.cause) => {
                    coarse = None;
                    StepError { step: interval.step, ..error }
                }
                Err(Error::Step(error)) => return Err(StepError { step: interval.step, ..error }.into()),
                Err(error) => return Err(error),
            };
            self.stepper.set_exchanged(before);
            if level >= self.retry.most {
                return Err(error.into());
            }
            level += 1;
        }
    }

    /// The reason why the second of two ends of a step from this state is refused: it differs from the first
    /// by more than is allowed.
    fn unsettled(
        &self,
        start: &State<H::Vector>,
        ends: [&State<H::Vector>; 2],
        motion: Option<f64>,
    ) -> Option<StepFailure> {
        if !matches!(H::PLAN.noise, NoiseClass::None) {
            return None;
        }
        let (energy_error, of_step) = disagreement(self.system, start, ends);
        let scale = motion.unwrap_or(of_step);
        // Also where one of them is no number.
        let is_settled = energy_error <= AGREEMENT * scale;
        (!is_settled).then_some(StepFailure::Unresolved { energy_error, scale, may_jump: false })
    }

    /// At the end of a run: its energy is a number, if it is monitored.
    ///
    /// # Errors
    /// [`StepFailure::UndefinedEnergy`] of the last step.
    pub(crate) fn arrive(&self, state: &State<H::Vector>, grid: &NodeGrid) -> Result<(), StepError> {
        let (step, h) = (grid.steps.saturating_sub(1), self.stepper.length());
        let arrived = self.watch.arrive::<H, E>(self.system, state);
        let t = if H::PROPERTIES.is_clocked { state.t - h } else { grid.time(step) };
        arrived.map_err(|cause| StepError { step, t, h, cause })
    }

    /// The last step, which is shorter, in halves where it fails.
    #[cold]
    fn last<N: Noise>(&mut self, step: StepToTake<'_, H::Vector, N>) -> Result<StepInfo, Error> {
        let StepToTake { state, interval, noise, dw } = step;
        if let Some(noise) = noise {
            noise.increments_of_part(&interval, self.size, dw)?;
        }
        match self.stepper.step(state, dw) {
            Ok(info) => Ok(info),
            Err(error) => self.try_halves(StepToTake { state, interval, noise, dw }, error),
        }
    }

    /// A step that failed, in halves if they may help and are allowed.
    #[cold]
    fn try_halves<N: Noise>(
        &mut self,
        step: StepToTake<'_, H::Vector, N>,
        error: StepError,
    ) -> Result<StepInfo, Error> {
        if self.retry.most == 0 || !is_curable(error.cause) {
            return Err(StepError { step: step.interval.step, ..error }.into());
        }
        self.subdivide(step, 1, self.watch.mean_motion())
    }

    /// A step of the size of the run, in halves where it fails.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn whole<N: Noise>(&mut self, step: StepToTake<'_, H::Vector, N>) -> Result<StepInfo, Error> {
        let StepToTake { state, interval, noise, dw } = step;
        if let Some(noise) = noise {
            noise.increments(&interval, dw)?;
        }
        match self.stepper.step(state, dw) {
            Ok(info) => Ok(info),
            Err(error) => self.try_halves(StepToTake { state, interval, noise, dw }, error),
        }
    }

    /// Takes a whole step, and tests the energy at both of its ends.
    #[cold]
    fn watched<N: Noise>(&mut self, step: StepToTake<'_, H::Vector, N>) -> Result<StepInfo, Error> {
        let StepToTake { state, interval, noise, dw } = step;
        let room = self.watch.begin::<H, E>(self.system, self.h, state);
        let info = self.whole(StepToTake { state, interval, noise, dw })?;
        self.watch.end::<H, E>(room, self.system, self.h, state, interval.step)?;
        Ok(info)
    }

    /// Takes a step in which something may happen.
    #[cold]
    fn followed<N: Noise>(&mut self, step: StepToTake<'_, H::Vector, N>) -> Result<StepInfo, Error> {
        let StepToTake { state, interval, noise, dw } = step;
        let Self { system, h, size, watch, stepper, following: Some(following), .. } = self else {
            return Err(InternalError::new("followed steps have what follows them", 0).into());
        };
        let (system, number, before) = (*system, interval.step, state.t);
        let room = watch.looks_at(number).then(|| watch.begin::<H, E>(system, *h, state));
        let step = StepToTake { state: &mut *state, interval, noise, dw };
        let info = following.take(stepper, step, *size)?;
        match room {
            // The energy may have changed.
            _ if !following.happened.is_empty() => watch.begin_anew(number),
            Some(room) => watch.end::<H, E>(room, system, state.t - before, state, number)?,
            None => {}
        }
        Ok(info)
    }

    /// Takes a step, in parts where it has to be.
    ///
    /// # Errors
    /// [`Error::Noise`] or [`Error::Step`]; the state is then what it was.
    #[inline]
    pub(crate) fn take_step<N: Noise>(
        &mut self,
        step: StepToTake<'_, H::Vector, N>,
    ) -> Result<StepInfo, Error> {
        match self.way {
            StepDivision::Whole if self.watch.looks_at(step.interval.step) => self.watched(step),
            StepDivision::Whole => self.whole(step),
            StepDivision::Followed => self.followed(step),
            StepDivision::Last(0) => self.last(step),
            StepDivision::Halved(halvings) | StepDivision::Last(halvings) => {
                self.subdivide(step, halvings, self.watch.mean_motion())
            }
        }
    }
}

/// A step of a stepper, which may be looked at.
fn watched<H: Discretized<E>, E, C: StateSum<f64>, N: Noise>(
    stepper: &mut Stepper<'_, H, E, C>,
    watch: &mut EnergyMonitor<H::Vector>,
    step: StepToTake<'_, H::Vector, N>,
) -> Result<StepInfo, Error> {
    if !watch.looks_at(step.interval.step) {
        return stepper.take_step(step);
    }
    let (system, h) = (stepper.system(), stepper.step_size());
    let StepToTake { state, interval, noise, dw } = step;
    let room = watch.begin::<H, E>(system, h, state);
    let info = stepper.take_step(StepToTake { state, interval, noise, dw })?;
    watch.end::<H, E>(room, system, h, state, interval.step)?;
    Ok(info)
}

/// The first of the `2^level` parts of a step of this size, and the numbers of all of them: among those of
/// the run, or from 0 in a last step that is shorter.
///
/// # Errors
/// [`ConfigError::Setting`] if they cannot be counted.
fn parts(of: Interval, size: f64, level: u32) -> Result<(Interval, Range<u64>), ConfigError> {
    let h = part_of(size, level);
    Ok(if size == of.h {
        (Interval { start: of.start, h, step: 0 }, numbers_of_parts(of.step, level)?)
    } else {
        (Interval { start: of.begin(), h, step: 0 }, 0..1 << level)
    })
}

/// The noise of a step that is taken in parts.
struct PartNoise<'n, N> {
    noise: &'n mut N,
    of: Interval,
    /// The size of the step, which is less than that of `of` in a last step that is shorter.
    size: f64,
}

impl<'n, N> PartNoise<'n, N> {
    fn of(noise: &'n mut Option<N>, of: Interval, size: f64) -> Option<Self> {
        noise.as_mut().map(|noise| Self { noise, of, size })
    }
}

impl<N: Noise> Noise for PartNoise<'_, N> {
    fn increments(&mut self, part: &Interval, dw: &mut [f64]) -> Result<(), NoiseError> {
        if self.size == self.of.h {
            return self.noise.increments(part, dw);
        }
        // A power of two.
        let share = part.h / self.size;
        let from = part.step as f64 * share;
        self.noise.increments_within(&self.of, self.size, [from, from + share], dw)
    }
}

/// The numbers of the `2^level` parts of a step among those of all steps.
///
/// # Errors
/// [`ConfigError::Setting`] if they cannot be counted.
fn numbers_of_parts(step: u64, level: u32) -> Result<Range<u64>, ConfigError> {
    let Some(numbers) = parts_of(step, level) else {
        let parts = 1_u64 << level;
        return wrong(format!(
            "step {step} in {parts} parts: more than can be counted; allow fewer halvings"
        ));
    };
    Ok(numbers)
}

/// Takes the `2^level` parts of a step of this size, and counts them as one. The increments of the step
/// become the sums of theirs, for which there is room.
fn take_parts<V, T, N: Noise>(
    stepper: &mut T,
    step: StepToTake<'_, V, N>,
    size: f64,
    level: u32,
    room: &mut Vec<f64>,
    mut take: impl FnMut(&mut T, StepToTake<'_, V, PartNoise<'_, N>>) -> Result<StepInfo, Error>,
) -> Result<StepInfo, Error> {
    let StepToTake { state, interval, noise, dw } = step;
    dw.fill(0.0);
    room.resize(dw.len(), 0.0);
    let (first, numbers) = parts(interval, size, level)?;
    let mut noise = PartNoise::of(noise, interval, size);
    let mut path = SinglePath { stepper, state, noise: &mut noise, dw: room, first };
    // Hard and doubtful where one of the parts is.
    let mut taken = StepInfo { halvings: level, ..StepInfo::default() };
    for part in numbers {
        let (stepper, step) = path.step(part);
        let StepInfo { iterations, halvings: _, is_hard, is_doubtful } = take(stepper, step)?;
        add(path.dw, dw);
        taken.iterations = taken.iterations.saturating_add(iterations);
        taken.is_hard |= is_hard;
        taken.is_doubtful |= is_doubtful;
    }
    Ok(taken)
}

fn add(dw: &[f64], sum: &mut [f64]) {
    sum.iter_mut().zip(dw).for_each(|(sum, dw)| *sum += dw);
}

/// The numbers of the `2^level` parts of a step among those of all steps; `None` if they cannot be counted.
fn parts_of(step: u64, level: u32) -> Option<Range<u64>> {
    let counted = |step: u64| step.checked_mul(1_u64.checked_shl(level)?);
    Some(counted(step)?..counted(step.checked_add(1)?)?)
}

/// `h / 2^level`, exactly.
fn part_of(h: f64, level: u32) -> f64 {
    h / (1_u64 << level) as f64
}

/// Whether halving this step can help. Not for `Unresolved`, which concerns the whole run.
pub(crate) fn is_curable(cause: StepFailure) -> bool {
    match cause {
        StepFailure::NotConverged { .. }
        | StepFailure::Singular { .. }
        | StepFailure::NoSolution { .. }
        | StepFailure::TooManyUnknowns { .. }
        | StepFailure::BeyondCurvature { .. }
        | StepFailure::Dependent { .. }
        | StepFailure::NonFinite
        | StepFailure::Infinite { .. } => true,
        StepFailure::Unresolved { .. }
        | StepFailure::UndefinedEnergy
        | StepFailure::ClockNotPositive { .. }
        | StepFailure::ClockTooCoarse { .. }
        | StepFailure::TooManyEvents { .. }
        | StepFailure::OffManifold { .. }
        | StepFailure::NoProjection { .. }
        | StepFailure::Collision { .. }
        | StepFailure::Increments { .. }
        | StepFailure::Dimension { .. }
        | StepFailure::Index(_)
        | StepFailure::Bath(_)
        | StepFailure::Lanes(_)
        | StepFailure::OtherSolution { .. }
        | StepFailure::Internal(_)
        | StepFailure::NonFiniteInput => false,
    }
}

#[cfg(test)]
mod tests {
    use super::parts_of;

    #[test]
    fn parts_are_numbered_among_those_of_all_steps() {
        assert_eq!(parts_of(0, 0), Some(0..1));
        assert_eq!(parts_of(5, 3), Some(40..48));
        assert_eq!(parts_of((1 << 34) - 2, 30), Some(u64::MAX - (1 << 31) + 1..u64::MAX - (1 << 30) + 1));
        // The end of the last would be 2^64.
        assert_eq!(parts_of((1 << 34) - 1, 30), None);
        assert_eq!(parts_of(1 << 40, 30), None);
    }
}
