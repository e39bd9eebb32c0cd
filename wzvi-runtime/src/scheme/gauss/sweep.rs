//! Sweeps over all stages at once, `Y ← φ(Y)`, until nothing but rounding changes.

use super::Field;
use super::equations::{Placement, Step};
use super::kept::{ExactLists, ExactOf, LeftOf, Lists, Room};
use super::stages::{Observer, Part, Stages};
use super::stiff::Modal;
use crate::algebra::scalar::{Constant, Mask, Over, Parameters, Rounded, Scalar};
use crate::algebra::solve::Effort;
use crate::error::StepFailure;

/// Sweeps that are tried.
const MOST_SWEEPS: u32 = 60;
/// A sweep that changes more than this fraction of the stages, and more than half of what the one before did, may lead to another solution.
const WILD: f64 = 1.0 / 16.0;
/// With care, more than this fraction and a quarter of it: a map that takes a quarter of all distances has one fixed point, a third of the first change
/// around.
const DOUBTFUL: f64 = 1.0 / 4096.0;
/// Sweeps before their contraction is judged: the first ones need not contract.
const PATIENCE: u32 = 6;
/// Two sweeps that leave more of the change than this are slower than Newton's method.
const SLOW: f64 = 0.36;
/// Changes below this fraction of an unknown change nothing.
const ROUNDING: f64 = f64::EPSILON;
/// Nor does the sweep after one that changes no more than this, whatever it leaves of it.
const SMALL: f64 = 0.0005 * ROUNDING;

/// What the next sweep would change, in units of rounding: not random as rounding is, so that over many steps it adds up. (With a fiftieth the energy of
/// a Kepler orbit drifts by as much in each step; with this it walks at random.)
pub(super) const UNSEEN: f64 = 1e-6;

/// How a step was solved.
pub(super) struct Solved<S: Scalar> {
    pub(super) effort: Effort,
    /// Where sweeps did not contract.
    pub(super) prefers_newton: S::Mask,
}

/// What sweeps came to.
pub(super) struct Swept<S: Scalar> {
    /// Where nothing but rounding changes any more.
    pub(super) are_settled: S::Mask,
    /// Where they may have left the solution that continues the state; only a careful step settles there.
    pub(super) are_wild: S::Mask,
    /// How many there were.
    pub(super) sweeps: u32,
    /// Why they ended where they did not settle.
    pub(super) failure: StepFailure,
}

/// How far a sweep moves the stages.
struct Relative<'a, S: Scalar, const N: usize> {
    start: [&'a [S]; 2],
    changes: Part<S, N>,
}

impl<S: Scalar, const N: usize> Observer<Part<S, N>> for Relative<'_, S, N> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn see(&mut self, half: usize, d: usize, old: Part<S, N>, new: Part<S, N>) {
        let start = S::Stages::<N>::same(self.start[half][d]);
        let relative = (new - old).nearly_over(new.abs() + start.abs());
        self.changes = Scalar::select(relative.less(self.changes), self.changes, relative);
    }
}

impl<F: Field, K: Constant, S: Over<K>, const N: usize> Step<'_, F, K, S, N> {
    /// The stages that follow from the slopes at those that are there.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn follow(
        &self,
        lists: &mut Lists<S, F::Shape, N>,
        room: &mut Room<F, S, N>,
        observer: &mut impl Observer<Part<S, N>>,
    ) {
        let Lists { at: [q, p], slopes: [by_p, by_q], .. } = lists;
        let into = Placement { at: [q.as_mut(), p.as_mut()], by_p: by_p.as_mut(), by_q: Some(by_q.as_ref()) };
        self.place(into, [&self.common.table().mu, &self.common.table().eta], room, observer);
    }

    /// Sweeps from the stages that are there, until those of all paths that are wanted have ended. Slopes are then those of the sweep that
    /// was the last of each path.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn sweeps<const CAREFUL: bool>(
        &self,
        wanted: S::Mask,
        lists: &mut Lists<S, F::Shape, N>,
        left: &mut LeftOf<F, S, N>,
    ) -> Swept<S> {
        let LeftOf::<F, S, N> { scratch, modal, exact, .. } = left;
        let none = S::Mask::from_bool(false);
        // Nothing is known of the contraction before the second sweep.
        let (mut last, mut before_last) = (S::from_f64(0.0), S::from_f64(0.0));
        let (mut going, mut are_settled, mut are_wild) = (wanted, none, none);
        let (mut sweeps, mut failure) = (0, StepFailure::NonFinite);
        loop {
            sweeps += 1;
            let mut relative = Relative { start: self.start, changes: Scalar::from_f64(0.0) };
            self.sweep(are_settled, lists, scratch, modal, &mut relative);
            // Stored stage beside stage, they are found in lanes.
            lists.changes = relative.changes;
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
            let contracts = change.less(last * 0.5);
            if sweeps > 1 {
                let (far, ratio) = if CAREFUL { (DOUBTFUL, 0.25) } else { (WILD, 0.5) };
                let grows = S::from_f64(far).less(change) & !change.less(last * ratio);
                are_wild = are_wild | (going & grows);
                if !CAREFUL {
                    going = going & !grows;
                }
            }
            let is_small = change.less_equal(S::from_f64(SMALL))
                | (contracts & (change * change).less_equal(last * (UNSEEN * ROUNDING)));
            let mut settle = going & is_small;
            let is_unclear = going & !is_small & !contracts;
            if sweeps > 2 && is_unclear.any() {
                settle = settle | self.are_rounding(is_unclear, lists, exact);
            }
            if settle.any() {
                // Derivatives that a number carries converge as fast as it does, but later.
                if !S::IS_BESIDE && size_of::<S>() != size_of::<f64>() {
                    (0..sweeps + 2).for_each(|_| self.sweep(none, lists, scratch, modal, &mut ()));
                }
                if F::IS_STIFF && self.common.modes().is_some() {
                    // The slopes are those before the last change, by which a stiff force differs more than the stages do.
                    self.field(lists, scratch, are_settled);
                }
                (are_settled, going) = (are_settled | settle, going & !settle);
            }
            // False for NaN, which no other sweep makes finite.
            let is_fast = change.less_equal(before_last * SLOW);
            if sweeps == MOST_SWEEPS {
                going = none;
            } else if sweeps >= PATIENCE {
                going = going & is_fast;
            }
            if !going.any() {
                failure = StepFailure::NotConverged { iterations: sweeps, correction: change.magnitude() };
                break;
            }
            (before_last, last) = (last, change);
        }
        Swept { are_settled, are_wild, sweeps, failure }
    }

    /// One sweep: new slopes, except of paths whose slopes are to stay, and the stages that follow from them.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sweep(
        &self,
        stay: S::Mask,
        lists: &mut Lists<S, F::Shape, N>,
        room: &mut Room<F, S, N>,
        modal: &mut Modal<S::Stages<N>>,
        observer: &mut impl Observer<Part<S, N>>,
    ) {
        self.field(lists, room, stay);
        match self.common.modes() {
            Some(modes) if F::IS_STIFF => {
                modal.remember(lists.at[0].as_ref());
                self.follow(lists, room, &mut ());
                modes.filter::<S>(lists.at[0].as_mut(), modal);
                for (d, (old, new)) in modal.before().iter().zip(lists.at[0].as_ref()).enumerate() {
                    (0..S::Stages::<N>::PARTS)
                        .for_each(|part| observer.see(0, d, old.part(part), new.part(part)));
                }
            }
            _ => self.follow(lists, room, observer),
        }
    }

    /// Which of these paths have stages that solve their equations to the rounding of the terms of these.
    #[cold]
    #[inline(never)]
    fn are_rounding(
        &self,
        asked: S::Mask,
        lists: &Lists<S, F::Shape, N>,
        exact: &mut ExactOf<F, N>,
    ) -> S::Mask {
        let mut found = S::Mask::from_bool(false);
        for lane in (0..S::LANES).filter(|&lane| asked.lane(lane)) {
            let mut all = true;
            self.residuals(lane, lists, exact, |_, _, _, residual| all &= residual.is_below(1.0));
            if all {
                found = found | S::Mask::of_lane(lane);
            }
        }
        found
    }

    /// `Y - φ(Y)` of the stages of one path, with the rounding of its terms: half of the phase space, degree of freedom, stage.
    pub(super) fn residuals(
        &self,
        lane: usize,
        lists: &Lists<S, F::Shape, N>,
        exact: &mut ExactOf<F, N>,
        mut seen: impl FnMut(usize, usize, usize, Rounded),
    ) {
        let ExactLists { given, lists: exact, scratch } = exact.lists(self.start[0].len(), self.dw.len());
        for (exact, start) in given.start.iter_mut().zip(self.start) {
            for (exact, start) in exact.as_mut().iter_mut().zip(start) {
                *exact = Rounded::exact(start.lane(lane));
            }
        }
        read_nearest::<S, N>(given.dw.as_mut(), self.dw, lane);
        for (exact, stages) in exact.at.iter_mut().zip(&lists.at) {
            read_nearest::<S, N>(exact.as_mut(), stages.as_ref(), lane);
        }
        let parameters = &F::Parameters::lane(self.parameters, lane);
        let step = given.step(self.system, (parameters, self.common), [self.t, self.h].map(|x| x.lane(lane)));
        step.field(exact, scratch, false);
        step.follow(exact, scratch, &mut ());
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

/// Infinite where it is the largest number, at which [`Scalar::nearly_over`] ends.
#[cfg_attr(not(debug_assertions), inline(always))]
fn unbounded<S: Scalar>(change: S) -> S {
    S::select(change.less(S::from_f64(f64::MAX)), change, S::from_f64(f64::INFINITY))
}

/// Numbers of all stages of one path, each as near as it can be.
fn read_nearest<S: Scalar, const N: usize>(exact: &mut [[Rounded; N]], stages: &[S::Stages<N>], lane: usize) {
    for (exact, stages) in exact.iter_mut().zip(stages) {
        *exact = std::array::from_fn(|i| Rounded::nearest(stages.get(i).lane(lane)));
    }
}
