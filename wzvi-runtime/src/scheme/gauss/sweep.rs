//! Sweeps over all stages at once, `Y ← φ(Y)`, until nothing but rounding changes.

use super::Field;
use super::choice::{NewtonBackoff, WINDOW, finish};
use super::equations::{Placement, StepEquations};
use super::memory::{GaussHistoryOf, RoundedLists, RoundedScratchOf, StageLists, SweepScratchOf};
use super::stages::{StagePack, Stages};
use super::stiff::ModalStages;
use crate::algebra::memory::Iteration;
use crate::algebra::scalar::{ComputesWith, Constant, Mask, Parameters, Rounded, Scalar};
use crate::algebra::solve::{
    CAREFUL_CONTRACTION, CONTRACTION, Contraction, DOUBTFUL, Effort, ROUNDING, SETTLED_STAGES,
    UNSEEN_IN_STAGES, WILD, nearly_over,
};
use crate::error::StepFailure;

/// The most sweeps: more than the slowest contraction that goes on takes to rounding, `ln ε / ln 0.81 = 171`.
const MOST_SWEEPS: u32 = 200;
/// Sweeps before their contraction is judged: the first ones need not contract.
const UNJUDGED: u32 = 6;
/// If two sweeps leave at most this fraction of the change, they take fewer operations than Newton's method,
/// whatever the system.
const FAST: f64 = 0.36;
/// A sweep that leaves more than this fraction of the change may show only rounding: sweeps that go on
/// contract faster.
const STALLED: f64 = 0.81;

/// How a step was solved.
pub(super) struct StepOutcome<S: Scalar> {
    pub(super) effort: Effort,
    /// How the next steps start.
    pub(super) waits: NewtonBackoff<S>,
}

/// The outcome of sweeps.
pub(super) struct SweepOutcome<S: Scalar> {
    /// The paths in which only rounding still changes.
    pub(super) are_settled: S::Mask,
    /// The paths that may have left the solution that continues the state; only a careful step settles there.
    pub(super) are_wild: S::Mask,
    /// The number of sweeps.
    pub(super) sweeps: u32,
    /// The failure of paths that did not settle.
    pub(super) failure: StepFailure,
}

/// The relative change of the stages in a sweep.
pub(super) struct RelativeChange<'a, S: Scalar, const N: usize> {
    start: [&'a [S]; 2],
    changes: StagePack<S, N>,
}

impl<S: Scalar, const N: usize> RelativeChange<'_, S, N> {
    /// Half of the phase space, degree of freedom, a part of the old stages and the same part of the new
    /// ones.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn include(&mut self, half: usize, d: usize, old: StagePack<S, N>, new: StagePack<S, N>) {
        let start = S::Stages::<N>::same(self.start[half][d]);
        let relative = nearly_over(new - old, new.abs() + start.abs());
        self.changes = Scalar::select(relative.less(self.changes), self.changes, relative);
    }
}

impl<F: Field, K: Constant, S: ComputesWith<K>, const N: usize> StepEquations<'_, F, K, S, N> {
    /// Computes the stages from the current derivatives.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn follow(
        &self,
        lists: &mut StageLists<S, F::Shape, N>,
        room: &mut SweepScratchOf<F, S, N>,
        seen: Option<&mut RelativeChange<'_, S, N>>,
    ) {
        let StageLists { at: [q, p], slopes: [by_p, by_q], .. } = lists;
        let into = Placement { at: [q.as_mut(), p.as_mut()], by_p: by_p.as_mut(), by_q: Some(by_q.as_ref()) };
        self.place(into, [&self.common.table().mu, &self.common.table().eta], room, seen);
    }

    /// Sweeps from the current stages until all `wanted` paths have ended. The derivatives are then those of
    /// the last sweep of each path.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn sweeps<const CAREFUL: bool>(
        &self,
        wanted: S::Mask,
        lists: &mut StageLists<S, F::Shape, N>,
        left: &mut GaussHistoryOf<F, S, N>,
    ) -> SweepOutcome<S> {
        let GaussHistoryOf::<F, S, N> { scratch, modal, exact, iteration, .. } = left;
        let none = S::Mask::from_bool(false);
        // The latest first. The contraction is unknown before the second sweep.
        let mut past = [S::from_f64(0.0); WINDOW];
        let (mut going, mut are_settled, mut are_wild) = (wanted, none, none);
        let (mut sweeps, mut failure) = (0, StepFailure::NonFinite);
        loop {
            sweeps += 1;
            let mut relative = RelativeChange { start: self.start, changes: Scalar::from_f64(0.0) };
            self.sweep(are_settled, lists, scratch, modal, Some(&mut relative));
            // Stored by stage, so that the maximum is vectorised.
            lists.changes = relative.changes;
            if S::LANES_ARE_PATHS {
                // Opaque, since the compiler else cuts the lanes of the sweep as the decisions below would
                // have them, down to two numbers.
                lists.changes = std::hint::black_box(lists.changes);
            }
            let change = unbounded(S::Stages::largest(lists.changes));
            if sweeps == 1 {
                let is_far = going & !change.less(S::from_f64(f64::INFINITY));
                if is_far.any() {
                    going = going & !(is_far & !lists.are_finite());
                    if !going.any() {
                        break;
                    }
                }
            }
            let [last, before_last, ..] = past;
            if sweeps > 1 {
                let (far, ratio) =
                    if CAREFUL { (DOUBTFUL, CAREFUL_CONTRACTION) } else { (WILD, CONTRACTION) };
                let grows = S::from_f64(far).less(change) & !change.less(last * ratio);
                are_wild = are_wild | (going & grows);
                if !CAREFUL {
                    going = going & !grows;
                }
            }
            let is_small = change.less_equal(S::from_f64(SETTLED_STAGES * ROUNDING))
                | Contraction::new(change, last).leaves_unseen(UNSEEN_IN_STAGES);
            let mut settle = going & is_small;
            let mut is_over = S::Mask::from_bool(sweeps == MOST_SWEEPS);
            if sweeps >= UNJUDGED {
                // False for NaN, which further sweeps cannot make finite.
                let is_fast = change.less_equal(before_last * FAST);
                let is_slow = going & !is_small & !is_fast;
                if is_slow.any() {
                    is_over =
                        is_over | (is_slow & !self.pay(is_slow, *iteration, [past[WINDOW - 1], change]));
                }
            }
            let is_stalled = !change.less(last * STALLED);
            let is_unclear = going & !is_small & (is_stalled | is_over);
            if sweeps > 2 && is_unclear.any() {
                settle = settle | self.are_rounding(is_unclear, lists, exact);
            }
            if settle.any() {
                // The derivatives of a dual number converge as fast as its value, but later.
                if !S::LANES_ARE_PATHS && size_of::<S>() != size_of::<f64>() {
                    (0..sweeps + 2).for_each(|_| self.sweep(none, lists, scratch, modal, None));
                }
                if F::IS_STIFF && self.common.modes().is_some() {
                    // The derivatives precede the last change, which alters a stiff force more than the
                    // stages.
                    self.field(lists, scratch, are_settled);
                }
                (are_settled, going) = (are_settled | settle, going & !settle);
            }
            going = going & !is_over;
            if !going.any() {
                failure = StepFailure::NotConverged { iterations: sweeps, correction: change.magnitude() };
                break;
            }
            past.rotate_right(1);
            past[0] = change;
        }
        SweepOutcome { are_settled, are_wild, sweeps, failure }
    }

    /// The paths that further sweeps finish with fewer operations than Newton's method, by the relative
    /// changes before a window of sweeps and after it.
    #[cold]
    #[inline(never)]
    fn pay(&self, asked: S::Mask, pinned: Iteration, [before, change]: [S; 2]) -> S::Mask {
        let most = if pinned == Iteration::FixedPoint { f64::INFINITY } else { self.newton_in_sweeps() };
        let goal = 0.5 * ROUNDING;
        S::Mask::of_lanes(|lane| {
            asked.lane(lane) && finish(most, [before, change].map(|change| change.lane(lane)), goal)
        })
    }

    /// One sweep: new derivatives, except for paths that keep theirs, and the stages computed from them.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sweep(
        &self,
        stay: S::Mask,
        lists: &mut StageLists<S, F::Shape, N>,
        room: &mut SweepScratchOf<F, S, N>,
        modal: &mut ModalStages<S::Stages<N>>,
        seen: Option<&mut RelativeChange<'_, S, N>>,
    ) {
        self.field(lists, room, stay);
        match self.common.modes() {
            Some(modes) if F::IS_STIFF => {
                modal.remember(lists.at[0].as_ref());
                self.follow(lists, room, None);
                modes.filter::<S>(lists.at[0].as_mut(), modal);
                let Some(seen) = seen else { return };
                for (d, (old, new)) in modal.before().iter().zip(lists.at[0].as_ref()).enumerate() {
                    (0..S::Stages::<N>::PARTS)
                        .for_each(|part| seen.include(0, d, old.part(part), new.part(part)));
                }
            }
            _ => self.follow(lists, room, seen),
        }
    }

    /// The paths whose stages solve the equations to the rounding of their terms.
    #[cold]
    #[inline(never)]
    fn are_rounding(
        &self,
        asked: S::Mask,
        lists: &StageLists<S, F::Shape, N>,
        exact: &mut RoundedScratchOf<F, N>,
    ) -> S::Mask {
        S::Mask::of_lanes(|lane| {
            let mut all = asked.lane(lane);
            if all {
                self.residuals(lane, lists, exact, &mut |_, _, _, residual| all &= residual.is_below(1.0));
            }
            all
        })
    }

    /// `Y - φ(Y)` of the stages of one path, with the rounding of its terms: half of the phase space, degree
    /// of freedom, stage.
    pub(super) fn residuals(
        &self,
        lane: usize,
        lists: &StageLists<S, F::Shape, N>,
        exact: &mut RoundedScratchOf<F, N>,
        seen: &mut dyn FnMut(usize, usize, usize, Rounded),
    ) {
        let RoundedLists { given, lists: exact, scratch } = exact.lists(self.start[0].len(), self.dw.len());
        for (exact, start) in given.start.iter_mut().zip(self.start) {
            for (exact, start) in exact.as_mut().iter_mut().zip(start) {
                *exact = Rounded::exact(start.lane(lane));
            }
        }
        read_nearest::<S, N>(given.dw.as_mut(), self.dw, lane);
        for (exact, stages) in exact.at.iter_mut().zip(&lists.at) {
            read_nearest::<S, N>(exact.as_mut(), stages.as_ref(), lane);
        }
        let (parameters, friction) = (&F::Parameters::lane(self.parameters, lane), &self.friction.lane(lane));
        let times = [self.t, self.h].map(|x| x.lane(lane));
        let step = given.step(self.system, (parameters, friction, self.common), times);
        step.field(exact, scratch, false);
        step.follow(exact, scratch, None);
        let kinds = if F::IS_NYSTROM { 1 } else { 2 };
        for (kind, (exact, stages)) in exact.at.iter().zip(&lists.at).take(kinds).enumerate() {
            for (d, (next, stages)) in exact.as_ref().iter().zip(stages.as_ref()).enumerate() {
                for (i, next) in next.iter().enumerate() {
                    seen(kind, d, i, Rounded::nearest(stages.get(i).lane(lane)) - *next);
                }
            }
        }
    }
}

/// The number, or infinity if it is the largest finite one, at which [`nearly_over`] saturates.
#[cfg_attr(not(debug_assertions), inline(always))]
fn unbounded<S: Scalar>(change: S) -> S {
    S::select(change.less(S::from_f64(f64::MAX)), change, S::from_f64(f64::INFINITY))
}

/// Reads all stages of one path, each to the nearest representable number.
fn read_nearest<S: Scalar, const N: usize>(exact: &mut [[Rounded; N]], stages: &[S::Stages<N>], lane: usize) {
    for (exact, stages) in exact.iter_mut().zip(stages) {
        *exact = std::array::from_fn(|i| Rounded::nearest(stages.get(i).lane(lane)));
    }
}
