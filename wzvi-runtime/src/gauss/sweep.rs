//! Sweeps over all stages at once, `Y ← φ(Y)`, until nothing but rounding changes.

use super::Field;
use super::advance::{Placement, Step};
use super::kept::{Exact, ExactLists, Lists};
use super::stages::{Changes, Observer, Scratch, Stages};
use super::stiff::Modal;
use crate::error::StepFailure;
use crate::scalar::{Rounded, Scalar};
use crate::solve::Effort;

/// Sweeps that are tried.
const MOST_SWEEPS: u32 = 60;
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
pub(super) struct Solved {
    pub(super) effort: Effort,
    pub(super) prefers_newton: bool,
}

/// How far a sweep moves the stages.
struct Relative<'a, S, const N: usize> {
    start: [&'a [S]; 2],
    changes: Changes<N>,
}

impl<S: Scalar, const N: usize> Observer<S::Stages<N>> for Relative<'_, S, N> {
    #[inline(always)]
    fn see(&mut self, half: usize, d: usize, old: S::Stages<N>, new: S::Stages<N>) {
        self.changes = new.changes(old, self.start[half][d], self.changes);
    }
}

impl<F: Field, S: Scalar, const N: usize> Step<'_, F, S, N> {
    /// The stages that follow from the slopes at those that are there.
    #[inline(always)]
    pub(super) fn follow(
        &self,
        lists: &mut Lists<S, F::Shape, N>,
        scratch: &mut Scratch<S>,
        observer: &mut impl Observer<S::Stages<N>>,
    ) {
        let Lists { at: [q, p], slopes: [by_p, by_q], spare, .. } = lists;
        let into = Placement {
            at: [q.as_mut(), p.as_mut()],
            by_p: by_p.as_mut(),
            by_q: Some(by_q.as_ref()),
            spare: spare.as_mut(),
        };
        self.place(into, [&self.prepared.table().mu, &self.prepared.table().eta], scratch, observer);
    }

    /// Sweeps from the stages that are there.
    ///
    /// # Errors
    /// [`StepFailure::NonFinite`] if the first stages have no finite slopes, else [`StepFailure::NotConverged`].
    #[inline(always)]
    pub(super) fn sweeps(
        &self,
        lists: &mut Lists<S, F::Shape, N>,
        scratch: &mut Scratch<S>,
        modal: &mut Modal<S::Stages<N>>,
        exact: &mut Exact<F::Shape, F::Noises, N>,
    ) -> Result<Solved, StepFailure> {
        // Nothing is known of the contraction before the second sweep.
        let (mut last, mut before_last) = (0.0, 0.0);
        let mut sweeps = 0;
        loop {
            sweeps += 1;
            let mut relative = Relative { start: self.start, changes: Changes::default() };
            self.sweep(lists, scratch, modal, &mut relative);
            // Stored stage beside stage, they are found in lanes.
            lists.changes = relative.changes;
            let (change, is_tiny) = lists.changes.largest(SMALL);
            if sweeps == 1 && !(change < f64::INFINITY || lists.is_finite()) {
                return Err(StepFailure::NonFinite);
            }
            let contracts = change < 0.5 * last;
            let is_small = is_tiny || (contracts && change * change <= UNSEEN * ROUNDING * last);
            let is_settled = is_small || (!contracts && sweeps > 2 && self.is_rounding(lists, exact));
            if is_settled {
                // Derivatives that a number carries converge as fast as it does, but later.
                if size_of::<S>() != size_of::<f64>() {
                    (0..sweeps + 2).for_each(|_| self.sweep(lists, scratch, modal, &mut ()));
                }
                if F::IS_STIFF && self.prepared.modes().is_some() {
                    // The slopes are those before the last change, by which a stiff force differs more than the stages do.
                    self.field(lists, scratch);
                }
                return Ok(Solved { effort: Effort::fast(sweeps), prefers_newton: false });
            }
            // False for NaN, which no other sweep makes finite.
            let is_fast = change <= SLOW * before_last;
            if sweeps == MOST_SWEEPS || (sweeps >= PATIENCE && !is_fast) {
                return Err(StepFailure::NotConverged { iterations: sweeps, correction: change });
            }
            (before_last, last) = (last, change);
        }
    }

    /// One sweep: new slopes, and the stages that follow from them.
    #[inline(always)]
    fn sweep(
        &self,
        lists: &mut Lists<S, F::Shape, N>,
        scratch: &mut Scratch<S>,
        modal: &mut Modal<S::Stages<N>>,
        observer: &mut impl Observer<S::Stages<N>>,
    ) {
        self.field(lists, scratch);
        match self.prepared.modes() {
            Some(modes) if F::IS_STIFF => {
                modal.remember(lists.at[0].as_ref());
                self.follow(lists, scratch, &mut ());
                modes.filter::<S>(lists.at[0].as_mut(), modal);
                for (d, (old, new)) in modal.before().iter().zip(lists.at[0].as_ref()).enumerate() {
                    observer.see(0, d, *old, *new);
                }
            }
            _ => self.follow(lists, scratch, observer),
        }
    }

    /// Whether the stages solve their equations to the rounding of the terms of these.
    #[cold]
    #[inline(never)]
    fn is_rounding(&self, lists: &Lists<S, F::Shape, N>, exact: &mut Exact<F::Shape, F::Noises, N>) -> bool {
        let mut all = true;
        self.residuals(lists, exact, |_, _, residual| {
            all &= residual.iter().all(|residual| residual.is_below(1.0));
        });
        all
    }

    /// `Y - φ(Y)` of the stages that are there, with the rounding of its terms: half of the phase space, degree of freedom,
    /// all stages.
    pub(super) fn residuals(
        &self,
        lists: &Lists<S, F::Shape, N>,
        exact: &mut Exact<F::Shape, F::Noises, N>,
        mut seen: impl FnMut(usize, usize, [Rounded; N]),
    ) {
        let ExactLists { given, lists: exact, scratch } = exact.lists(self.start[0].len(), self.at.dw.len());
        for (exact, start) in given.start.iter_mut().zip(self.start) {
            for (exact, start) in exact.as_mut().iter_mut().zip(start) {
                *exact = Rounded::exact(start.lane(0));
            }
        }
        read_nearest::<S, N>(given.dw.as_mut(), self.at.dw);
        for (exact, stages) in exact.at.iter_mut().zip(&lists.at) {
            read_nearest::<S, N>(exact.as_mut(), stages.as_ref());
        }
        let step = given.step(self.system, self.prepared, self.t, self.h);
        step.field(exact, scratch);
        let mut observer = (|half, d, old: [Rounded; N], new| seen(half, d, old.minus(new)),);
        step.follow(exact, scratch, &mut observer);
    }
}

/// Numbers of all stages, each as near as it can be.
fn read_nearest<S: Scalar, const N: usize>(exact: &mut [[Rounded; N]], stages: &[S::Stages<N>]) {
    for (exact, stages) in exact.iter_mut().zip(stages) {
        *exact = std::array::from_fn(|i| Rounded::nearest(stages.get(i).lane(0)));
    }
}
