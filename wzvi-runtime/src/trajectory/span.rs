//! From where to where a run goes, and where its nodes are: the same for every builder.

use std::ops::Range;

use crate::algebra::state::{State, Vector};
use crate::error::{ConfigError, StepFailure, wrong};
use crate::ground::digits::{ShortestDecimal, computed};
use crate::increments::{Interval, Noise, NoiseError};
use crate::scheme::constraints::Distance;
use crate::scheme::plan::Plan;
use crate::scheme::system::{Discretized, Hamiltonian, disequilibrium, fits};
use crate::trajectory::Error;
use crate::trajectory::exclusive_setting::ExclusiveSetting;
use crate::trajectory::retry::Retry;

/// Step numbers are exact as `f64` up to here; time is `t_0 + n h`.
pub(crate) const MOST_STEPS: u64 = 1 << 53;

/// The end of a run, as the user sets it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum RunEnd {
    Time(f64),
    Steps(u64),
}

/// The start and the end of a run.
#[derive(Clone, Debug)]
pub(crate) struct RunSpan<V> {
    pub(crate) start: ExclusiveSetting<State<V>>,
    pub(crate) end: ExclusiveSetting<RunEnd>,
    /// Whether all steps have the size of the run: the last one leads beyond an end that is no node.
    pub(crate) is_whole: bool,
    /// Whether something was asked of each degree of freedom before their number was known.
    pub(crate) was_asked_early: bool,
    /// Whether one temperature of all degrees of freedom was asked for.
    pub(crate) asks_one_temperature: bool,
    /// Whether the energy of each degree of freedom was asked for.
    pub(crate) asks_shares: bool,
    /// Whether starts are projected on the manifold of the constraints from any distance.
    pub(crate) is_projected: bool,
}

impl<V> Default for RunSpan<V> {
    fn default() -> Self {
        Self {
            start: ExclusiveSetting::default(),
            end: ExclusiveSetting::default(),
            is_whole: false,
            was_asked_early: false,
            asks_one_temperature: false,
            asks_shares: false,
            is_projected: false,
        }
    }
}

/// The nodes of a run, `start + n h` and the end, and the steps between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NodeGrid {
    pub(crate) start: f64,
    pub(crate) h: f64,
    /// All steps, a shorter last one included.
    pub(crate) steps: u64,
    /// The time of the last node, where the run ends at a time.
    pub(crate) end: Option<f64>,
    /// The size of a last step that is shorter than the others.
    pub(crate) shorter: Option<f64>,
    /// Whether a clock has the times of the nodes: `h` is its `eps`, with the sign of time, and the number of
    /// steps is known at the end of the run.
    pub(crate) is_clocked: bool,
}

/// The place of a time in a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NodeOrInside {
    /// At the node after so many steps, up to rounding.
    Node(u64),
    /// Inside the step with this number.
    Inside(u64),
}

const NOISE: &str = "increments for the noises of the system: add `.noise(...)` with a seeded source or \
                     `Increments::from(...)`";
/// Why a noise does not drive a run that may halve its steps.
const WHOLE_STEPS: &str = "`retry(...)` halves steps, and this noise has no increments inside of a step: take \
                           `Wiener`, `WongZakai` or `StepNormals` (`.seed(number)`), implement `Noise::is_divisible` for a \
                           noise of your own that has them, or leave `retry` out";

impl NodeGrid {
    /// Steps of size `h` without more.
    pub(crate) fn of(start: f64, h: f64, steps: u64) -> Self {
        Self { start, h, steps, end: None, shorter: None, is_clocked: false }
    }

    /// Steps of size `h` up to a time.
    fn until(start: f64, end: f64, h: f64) -> Option<Self> {
        let (steps, is_node) = located(start, end, h)?;
        let rest = end - (start + (steps.saturating_sub(1)) as f64 * h);
        Some(Self { start, h, steps, end: Some(end), shorter: (!is_node).then_some(rest), is_clocked: false })
    }

    /// Steps of a clock, up to a time or so many.
    fn by_clock(start: f64, end: RunEnd, eps: f64) -> Result<Self, ConfigError> {
        // Also false for NaN.
        if !(eps > 0.0 && eps.is_finite()) {
            return Err(ConfigError::Eps(eps));
        }
        let grid = Self { start, h: eps, steps: MOST_STEPS, end: None, shorter: None, is_clocked: true };
        match end {
            RunEnd::Time(end) if end == start => Ok(Self { steps: 0, end: Some(end), ..grid }),
            RunEnd::Time(end) if end.is_finite() => {
                Ok(Self { h: eps.copysign(end - start), end: Some(end), ..grid })
            }
            RunEnd::Time(end) => Err(ConfigError::End { start, end, h: eps }),
            RunEnd::Steps(steps) => Ok(Self { steps: steps.min(MOST_STEPS), ..grid }),
        }
    }

    /// The steps to make room for.
    pub(crate) fn expected(&self) -> u64 {
        if self.is_clocked { 0 } else { self.steps }
    }

    /// The first step.
    pub(crate) fn first(&self) -> Interval {
        Interval { start: self.start, h: self.h, step: 0 }
    }

    /// The steps from one on, in order: the numbers of those of one size, and that size.
    pub(crate) fn from(&self, first: u64) -> impl Iterator<Item = (Range<u64>, f64)> {
        let whole = (first..self.whole(), self.h);
        let shorter = self.shorter.map(|h| (first.max(self.whole())..self.steps, h));
        std::iter::once(whole).chain(shorter).filter(|(numbers, _)| !numbers.is_empty())
    }

    /// The size of a step.
    pub(crate) fn size(&self, step: u64) -> f64 {
        self.shorter.filter(|_| step + 1 == self.steps).unwrap_or(self.h)
    }

    /// A noise, ready for these steps, which may be halved; none for a deterministic system, which asks for
    /// nothing.
    pub(crate) fn prepared<N: Noise>(
        &self,
        noise: Option<N>,
        plan: &Plan,
        processes: usize,
        retry: Retry,
    ) -> Result<Option<N>, Error> {
        if processes == 0 {
            return Ok(None);
        }
        let mut noise = noise.ok_or(ConfigError::Missing(NOISE))?;
        noise.prepare(plan, self.h, processes, self.start)?;
        self.check_parts(&mut noise, processes, retry)?;
        Ok(Some(noise))
    }

    /// Whether a noise has increments for the halves of steps, if these may be halved, and for a last step
    /// that is shorter. One that has none says so before the run.
    pub(crate) fn check_parts(
        &self,
        noise: &mut (impl Noise + ?Sized),
        processes: usize,
        retry: Retry,
    ) -> Result<(), NoiseError> {
        if processes == 0 {
            return Ok(());
        }
        if retry.most() > 0 && !noise.is_divisible() {
            return Err(NoiseError::Setting(WHOLE_STEPS.into()));
        }
        let Some(shorter) = self.shorter else { return Ok(()) };
        let (last, mut dw) = (Interval { step: self.whole(), ..self.first() }, vec![0.0; processes]);
        noise.increments_of_part(&last, shorter, &mut dw)?;
        if retry.most() > 0 {
            noise.increments_within(&last, shorter, [0.0, 0.5], &mut dw)?;
        }
        Ok(())
    }

    /// Whether each node has a time of its own: steps are no shorter than the distance of two numbers at the
    /// later end.
    fn has_times(&self) -> bool {
        let latest = self.start.abs().max(self.time(self.steps).abs());
        self.steps == 0 || latest.next_up() - latest <= self.h.abs()
    }

    /// The time of a node.
    #[inline]
    pub(crate) fn time(&self, node: u64) -> f64 {
        match self.end {
            Some(end) if node == self.steps => end,
            _ => self.start + node as f64 * self.h,
        }
    }

    /// Steps of size `h` from the start to a node: a last one that is shorter is a part of one.
    pub(crate) fn steps_to(&self, node: u64) -> f64 {
        match self.shorter {
            Some(shorter) if node == self.steps => (node - 1) as f64 + shorter / self.h,
            _ => node as f64,
        }
    }

    /// The steps of size `h`.
    pub(crate) fn whole(&self) -> u64 {
        self.steps - u64::from(self.shorter.is_some())
    }

    /// The place of a time; `None` outside of the run, and for NaN.
    pub(crate) fn place(&self, t: f64) -> Option<NodeOrInside> {
        if self.is_clocked {
            return self.place_by_clock(t);
        }
        let (node, is_node) = located(self.start, t, self.h)?;
        if is_node && node <= self.whole() {
            return Some(NodeOrInside::Node(node));
        }
        if node <= self.whole() {
            return Some(NodeOrInside::Inside(node - 1));
        }
        let last = self.time(self.steps);
        // The rest of the run after `t`, in units of the step size: as in `located`, one rounding for each
        // time.
        let rest = (last - t) / self.h;
        let allowance = 2.0 * f64::EPSILON * (last.abs() + t.abs()) / self.h.abs();
        match self.shorter {
            Some(_) if rest.abs() <= allowance => Some(NodeOrInside::Node(self.steps)),
            Some(_) if rest > 0.0 => Some(NodeOrInside::Inside(self.steps - 1)),
            _ => None,
        }
    }
}

impl NodeGrid {
    /// The place of a time in a run whose nodes are not known: the start, the end, or inside of some step.
    fn place_by_clock(&self, t: f64) -> Option<NodeOrInside> {
        let after_start = (t - self.start) * self.h.signum();
        let before_end = self.end.map_or(f64::INFINITY, |end| (end - t) * self.h.signum());
        if after_start == 0.0 {
            Some(NodeOrInside::Node(0))
        } else if before_end == 0.0 {
            Some(NodeOrInside::Node(self.steps))
        } else {
            (after_start > 0.0 && before_end > 0.0).then_some(NodeOrInside::Inside(MOST_STEPS - 1))
        }
    }
}

impl<V: Vector> RunSpan<V> {
    /// The first state, and the nodes from there to the end in steps of size `h`.
    ///
    /// # Errors
    /// [`ConfigError`] where one of them is missing, does not fit the system, or cannot be reached.
    pub(crate) fn checked<H: Discretized<E, Vector = V>, E>(
        self,
        system: &H,
        h: f64,
    ) -> Result<(State<V>, NodeGrid), ConfigError> {
        if self.was_asked_early {
            return Err(ConfigError::Missing(SIZE));
        }
        if self.asks_one_temperature
            && H::PROPERTIES.has_temperatures
            && let Some(why) = disequilibrium(&H::PLAN, &H::PROPERTIES)
        {
            let (asked, instead) = ("observe_temperatures", "`observe_equipartition` has one for each");
            return Err(ConfigError::NoEquilibrium { asked, why, instead });
        }
        if self.asks_shares && system.manifold().is_some() {
            return wrong(
                "`observe_equipartition` of a system with constraints: momenta in a tangent plane do not share the energy one by one; \
                 `observe_temperatures` has the kinetic temperature of all together",
            );
        }
        let start = checked(system, self.start.checked(ONE_START)?, self.is_projected)?;
        let end = self.end.checked("a run has one end")?;
        if H::PROPERTIES.is_clocked {
            if self.is_whole {
                return wrong(
                    "`whole_steps` of a clock: a run by a clock ends at its time by a step of the scheme; leave it out",
                );
            }
            let grid = NodeGrid::by_clock(start.t, end.ok_or(ConfigError::Missing(END))?, h)?;
            return Ok((start, grid));
        }
        let grid = grid(end, self.is_whole, start.t, h)?;
        if !grid.has_times() {
            return Err(ConfigError::End { start: start.t, end: grid.time(grid.steps), h });
        }
        Ok((start, grid))
    }
}

const START: &str = "a start: add `.start(State::new(q, p))`";
pub(crate) const ONE_START: &str = "a path has one start";
const END: &str = "an end: add `.until(time)` or `.steps(number)`";
const SIZE: &str =
    "the number of degrees of freedom for `.observe_equipartition()`: call it after `.start(...)`";

/// Refuses states of another number of degrees of freedom than the system has.
pub(crate) fn sized<H: Hamiltonian>(system: &H, state: &State<H::Vector>) -> Result<(), ConfigError> {
    let [q, p] = [&state.q, &state.p].map(|vector| vector.components().len());
    // If the system has no size of its own, the momenta have to match the coordinates.
    let expected = if fits(system, q) { q } else { system.degrees() };
    match [q, p].into_iter().find(|got| *got != expected) {
        Some(got) => Err(ConfigError::Start(StepFailure::Dimension { expected, got })),
        None => Ok(()),
    }
}

fn checked<H: Discretized<E>, E>(
    system: &H,
    start: Option<State<H::Vector>>,
    is_projected: bool,
) -> Result<State<H::Vector>, ConfigError> {
    let state = start.ok_or(ConfigError::Missing(START))?;
    sized(system, &state)?;
    system.check(state.q.components().len()).map_err(ConfigError::Start)?;
    if !is_finite(&state) {
        return Err(ConfigError::Start(StepFailure::NonFiniteInput));
    }
    projected(system, state, is_projected).map_err(ConfigError::Start)
}

/// The state on the manifold of the constraints, if there are any. `is_projected`: from any distance.
///
/// # Errors
/// [`StepFailure::OffManifold`] if it is far away, and the errors of
/// [`Manifold::project`](crate::scheme::constraints::Manifold::project).
pub(crate) fn projected<H: Hamiltonian>(
    system: &H,
    mut state: State<H::Vector>,
    is_projected: bool,
) -> Result<State<H::Vector>, StepFailure> {
    let Some(manifold) = system.manifold() else { return Ok(state) };
    let State { q, p, t } = &mut state;
    let distance = manifold.project(q.components_mut(), p.components_mut(), *t)?;
    if distance.is_large() && !is_projected {
        let Distance { coordinates, momenta } = distance;
        return Err(StepFailure::OffManifold { coordinates, momenta });
    }
    Ok(state)
}

fn is_finite<V: Vector>(state: &State<V>) -> bool {
    state.q.components().iter().chain(state.p.components()).chain([&state.t]).all(|x| x.is_finite())
}

fn grid(end: Option<RunEnd>, is_whole: bool, start: f64, h: f64) -> Result<NodeGrid, ConfigError> {
    match end.ok_or(ConfigError::Missing(END))? {
        RunEnd::Time(end) if is_whole => {
            let steps = steps_between(start, end, h).ok_or(ConfigError::End { start, end, h })?;
            Ok(NodeGrid::of(start, h, steps))
        }
        RunEnd::Time(end) => NodeGrid::until(start, end, h).ok_or(ConfigError::End { start, end, h }),
        RunEnd::Steps(steps) if steps <= MOST_STEPS => Ok(NodeGrid::of(start, h, steps)),
        RunEnd::Steps(steps) => Err(ConfigError::End { start, end: start + steps as f64 * h, h }),
    }
}

/// The whole steps from one time to another, at least one.
///
/// # Errors
/// [`ConfigError::End`], and [`ConfigError::Setting`] with the two nearest ends where there is no such
/// number.
pub(crate) fn whole_steps(start: f64, end: f64, h: f64) -> Result<u64, ConfigError> {
    let (steps, is_node) = located(start, end, h).ok_or(ConfigError::End { start, end, h })?;
    if is_node && steps > 0 {
        return Ok(steps);
    }
    let [end_asked, step] = [end, h].map(ShortestDecimal);
    let [before, beyond] = [steps.saturating_sub(1), steps.max(1)].map(|n| computed(start + n as f64 * h));
    wrong(if steps == 0 {
        format!(
            "a run without a step, to t = {end_asked}: the first end in whole steps of {step} is t = {beyond}"
        )
    } else if steps == 1 {
        format!(
            "steps of {step} do not end at t = {end_asked}, and this run takes whole steps: end at t = {beyond}, or take shorter steps"
        )
    } else {
        format!(
            "steps of {step} do not end at t = {end_asked}, and this run takes whole steps: end at t = {before} or t = {beyond}"
        )
    })
}

/// `⌈(end - start)/h⌉`, or the integer that the quotient would be but for rounding; `None` if it is negative,
/// NaN or more than can be counted.
pub(crate) fn steps_between(start: f64, end: f64, h: f64) -> Option<u64> {
    located(start, end, h).map(|(steps, _)| steps)
}

/// [`steps_between`], and whether the quotient is that integer.
fn located(start: f64, end: f64, h: f64) -> Option<(u64, bool)> {
    let quotient = (end - start) / h;
    // One rounding each in start, end, their difference, h and the quotient, and one to spare.
    let allowance = 2.0 * f64::EPSILON * (quotient + (start.abs() + end.abs()) / h.abs());
    let nearest = quotient.round();
    let is_node = (quotient - nearest).abs() <= allowance;
    let steps = if is_node { nearest } else { quotient.ceil() };
    // Also false for NaN.
    (quotient >= 0.0 && steps <= MOST_STEPS as f64).then_some((steps as u64, is_node))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_counted_despite_rounding() {
        assert_eq!(steps_between(0.0, 20.0, 0.02), Some(1000));
        assert_eq!(steps_between(0.0, 0.3, 0.1), Some(3)); // 2.9999999999999996
        assert_eq!(steps_between(0.1, 0.7, 0.1), Some(6)); // 5.999999999999999
        assert_eq!(steps_between(0.1 + 0.2, 0.9, 0.3), Some(2));
        assert_eq!(steps_between(0.0, 1.0, 0.3), Some(4));
        assert_eq!(steps_between(0.0, 1.0 + 1e-12, 0.25), Some(5));
        assert_eq!(steps_between(0.0, 1e-17, 1.0), Some(1));
        assert_eq!(steps_between(2.0, 2.0, 0.1), Some(0));
        assert_eq!(steps_between(1.0, -1.0, -0.5), Some(4));
        for n in 1..2000_u32 {
            for h in [0.1, 0.02, 1e-3, 1.0 / 3.0, 0.7] {
                for t0 in [0.0, 0.1, -17.3, 1e3] {
                    assert_eq!(
                        steps_between(t0, t0 + f64::from(n) * h, h),
                        Some(u64::from(n)),
                        "{t0} {n} {h}"
                    );
                }
            }
        }
    }

    #[test]
    fn times_have_their_places() {
        use NodeOrInside::{Inside, Node};
        let grid = NodeGrid::of(0.5, 0.1, 7);
        let places = [
            (0.5, Node(0)),
            (0.55, Inside(0)),
            (0.7999999999999999, Node(3)),
            (0.8 + 1e-12, Inside(3)),
            (1.2, Node(7)),
        ];
        for (t, place) in places {
            assert_eq!(grid.place(t), Some(place), "{t}");
        }
        for t in [0.49, 1.21, f64::NAN, f64::INFINITY] {
            assert_eq!(grid.place(t), None, "{t}");
        }
        let backwards = NodeGrid::of(1.0, -0.25, 4);
        assert_eq!([0.9, 0.5, 1.1].map(|t| backwards.place(t)), [Some(Inside(0)), Some(Node(2)), None]);
    }

    #[test]
    fn steps_are_handed_out_by_their_sizes() {
        let grid = NodeGrid::until(0.0, 1.05, 0.1).unwrap();
        let from = |first| grid.from(first).map(|(numbers, size)| (numbers.start, numbers.end, size));
        let rest = grid.shorter.unwrap();
        assert!(from(0).eq([(0, 10, 0.1), (10, 11, rest)]) && from(10).eq([(10, 11, rest)]));
        assert_eq!(([9, 10].map(|step| grid.size(step)), from(11).count()), ([0.1, rest], 0));
        assert_eq!(whole_steps(0.0, 0.9, 0.3), Ok(3));
        let words = |end| whole_steps(0.0, end, 0.3).unwrap_err().to_string();
        assert!(words(1.0).ends_with("end at t = 0.9 or t = 1.2") && words(0.0).ends_with("t = 0.3"));
    }

    #[test]
    fn an_end_is_a_node() {
        use NodeOrInside::{Inside, Node};
        let grid = NodeGrid::until(0.0, 1.05, 0.1).unwrap();
        assert_eq!((grid.steps, grid.whole(), grid.time(10), grid.time(11)), (11, 10, 1.0, 1.05));
        assert!((grid.shorter.unwrap() - 0.05).abs() < 1e-15);
        let placed = [1.0, 1.02, 1.05, 1.06, 1.1, 1.2].map(|t| grid.place(t));
        assert_eq!(placed, [Some(Node(10)), Some(Inside(10)), Some(Node(11)), None, None, None]);
        // At a node up to rounding, and then at the time that was asked for.
        let grid = NodeGrid::until(0.0, 0.3, 0.1).unwrap();
        assert_eq!((grid.steps, grid.shorter, grid.time(3)), (3, None, 0.3));
        assert_eq!(NodeGrid::until(0.0, 0.0, 0.1).unwrap().steps, 0);
        let grid = NodeGrid::until(0.0, 1e-3, 1.0).unwrap();
        assert_eq!((grid.steps, grid.shorter, grid.place(5e-4)), (1, Some(1e-3), Some(Inside(0))));
        let backwards = NodeGrid::until(1.0, 0.3, -0.25).unwrap();
        assert_eq!((backwards.steps, backwards.place(0.4)), (3, Some(Inside(2))));
    }

    #[test]
    fn ends_that_cannot_be_reached_are_refused() {
        let (nan, inf) = (f64::NAN, f64::INFINITY);
        for (start, end, h) in
            [(0.0, -1.0, 0.1), (0.0, 1.0, -0.1), (0.0, nan, 0.1), (0.0, inf, 0.1), (0.0, 1e300, 1e-300)]
        {
            assert_eq!(steps_between(start, end, h), None, "{start} {end} {h}");
        }
        assert_eq!(steps_between(0.0, 9_007_199_254_740_994.0, 1.0), None);
    }
}
