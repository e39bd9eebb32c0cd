//! Factors that serve more than one step, and where they were made.
//!
//! Newton's method with the factors of an earlier step is the chord method; its contraction is set by the
//! change of the Jacobian since. A step starts with the existing factors and makes new ones if they contract
//! too slowly. It also discards old factors once their extra iterations cost as much as a refactorisation
//! (the ski-rental rule: at most twice the cost of the best choice in hindsight). Krylov's method uses the
//! factors as its preconditioner.
//!
//! A checkpoint or a copy stores where the factors were made instead of the factors: it takes the same steps
//! to the last bit.

use super::Elements;
use super::linear::LinearSolver;
use super::memory::{IterationMemory, LoopScratch, StepLists};
use super::step::LoopStep;
use crate::algebra::memory::{Iteration, LinearWork};
use crate::algebra::scalar::Scalar;
use crate::algebra::solve::astray;
use crate::error::StepFailure;
use crate::ground::numbers::{Numbers, Tape};

/// Excess Jacobian products with incomplete factors before complete ones replace them: about the cost of
/// complete factors.
pub(super) const EXCESS_PRODUCTS: u32 = 128;
/// Cost of a solution with complete factors, in Jacobian products.
const A_SOLUTION: u32 = 4;

/// The step and the unknowns at which factors were made.
#[derive(Debug, Default)]
struct LinearisationPoint<S: Scalar> {
    is_known: bool,
    /// Whether complete factors were requested.
    all: bool,
    t: S::Constant,
    h: S::Constant,
    /// Coordinates, momenta, noise increments, unknowns.
    lists: [Vec<S>; 4],
}

impl<S: Scalar> LinearisationPoint<S> {
    /// Copies without a new allocation where the lists have the capacity.
    fn copy(&mut self, all: bool, [t, h]: [S::Constant; 2], lists: [&[S]; 4]) {
        (self.is_known, self.all, self.t, self.h) = (true, all, t, h);
        for (own, list) in self.lists.iter_mut().zip(lists) {
            own.clear();
            own.extend_from_slice(list);
        }
    }
}

/// The steps that the stored factors belong to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum FactorSource {
    /// None: there are no factors, or no later step can use them.
    #[default]
    Unknown,
    /// All steps of this size `h`.
    Always(f64),
    /// The anchor.
    AtAnchor,
    /// This step, which becomes the anchor if it succeeds.
    Now,
}

/// The stored factors: the place of their linearisation, and their cost so far.
#[derive(Debug, Default)]
pub(super) struct FactorCache<S: Scalar> {
    made: FactorSource,
    /// The linearisation point of the factors for the next step.
    anchor: LinearisationPoint<S>,
    /// The linearisation point of the factors of this step.
    next: LinearisationPoint<S>,
    /// Whether this step started with factors of an earlier one.
    has_started: bool,
    /// Cost of this step: iterations, or Jacobian products with Krylov's method.
    taken: u64,
    /// Cost of the step that made the factors; `excess` sums what later steps cost above it.
    least: u64,
    excess: u64,
    /// Jacobian products beyond those of solutions with complete factors.
    vain: u64,
    pub(super) work: LinearWork,
}

/// Copies where the factors were made, not the factors.
impl<S: Scalar> Clone for FactorCache<S> {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    fn clone_from(&mut self, other: &Self) {
        self.made = FactorSource::Unknown;
        (self.least, self.excess, self.vain) = (other.least, other.excess, other.vain);
        self.work = other.work;
        let LinearisationPoint { is_known, all, t, h, lists } = &other.anchor;
        self.anchor.is_known = *is_known;
        if *is_known {
            self.anchor.copy(*all, [*t, *h], lists.each_ref().map(Vec::as_slice));
        }
    }
}

impl<S: Scalar> Numbers for FactorCache<S> {
    fn pass(&mut self, tape: &mut Tape) {
        if tape.replaces_all() {
            self.lose();
        }
        tape.word(&mut self.vain);
        let LinearisationPoint { is_known, all, t, h, lists } = &mut self.anchor;
        tape.flag(is_known);
        if !*is_known {
            return;
        }
        tape.flag(all);
        t.pass(tape);
        h.pass(tape);
        lists.pass(tape);
        tape.words([&mut self.least, &mut self.excess]);
    }
}

impl<S: Scalar> FactorCache<S> {
    /// Whether a later step may start with factors.
    pub(super) fn may_serve(&self) -> bool {
        self.anchor.is_known || self.vain > 0
    }

    /// Makes the next step compute its own factors.
    pub(super) fn forget(&mut self) {
        (self.anchor.is_known, self.vain) = (false, 0);
        self.lose();
    }

    /// Marks the factors as missing.
    pub(super) fn lose(&mut self) {
        self.made = FactorSource::Unknown;
        self.begin();
    }

    /// Begins a step. Discards the factors of a failed one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn begin(&mut self) {
        (self.taken, self.has_started) = (0, false);
        if self.made == FactorSource::Now {
            self.made = FactorSource::Unknown;
        }
    }

    /// Counts the cost of a correction: its Jacobian products, or 1 without Krylov's method.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn count(&mut self, products: Option<u32>) {
        self.taken += products.map_or(1, u64::from);
        self.work.products += products.map_or(0, u64::from);
        if !self.wants_all() {
            self.vain += products.map_or(0, |products| u64::from(products.saturating_sub(A_SOLUTION)));
        }
    }

    /// Whether the excess products of incomplete factors cost as much as complete factors.
    pub(super) fn wants_all(&self) -> bool {
        self.vain >= u64::from(EXCESS_PRODUCTS - A_SOLUTION)
    }

    /// Records a successful Newton step; `cost` is that of new factors, in the units of `taken`.
    pub(super) fn succeed(&mut self, cost: u64) {
        if self.made == FactorSource::Now {
            std::mem::swap(&mut self.anchor, &mut self.next);
            // The cost of a step that started with other factors does not measure its own.
            self.anchor.is_known = !self.has_started;
            (self.made, self.least, self.excess) = (FactorSource::AtAnchor, self.taken, 0);
        } else if self.has_started {
            self.excess += self.taken.saturating_sub(self.least);
            self.anchor.is_known &= self.excess < cost;
        }
    }
}

impl<H: Elements, S: Scalar> LoopStep<'_, H, S> {
    /// Whether later steps may start with the factors of this one. With noise the Jacobians of successive
    /// steps are not close, and a pinned Newton's method factors in each iteration; a preconditioner need not
    /// be close.
    fn leaves_factors(&self, linear: &LinearSolver<S>, pinned: Iteration) -> bool {
        let is_chord =
            pinned != Iteration::Newton && (self.scheme.remembers || self.scheme.linearity.is_constant());
        is_chord || matches!(linear, LinearSolver::Krylov(_))
    }

    /// Whether the step can start with earlier factors, recomputed if they are missing; the content of the
    /// lists is lost. (`scratch` is passed by value: a reference to all data of the iteration would prevent
    /// the vectorisation of its loops.)
    #[inline(never)]
    pub(super) fn starts_with_factors(&self, mut scratch: LoopScratch<'_, S>, pinned: Iteration) -> bool {
        let LoopScratch { lists, solver: IterationMemory { kept, linear: Some(linear), .. }, .. } = &scratch
        else {
            return false;
        };
        if !self.leaves_factors(linear, pinned) {
            return false;
        }
        if self.scheme.linearity.is_constant() || kept.made == FactorSource::Now {
            return kept.made == FactorSource::Now || kept.made == FactorSource::Always(self.h.lane(0));
        }
        let [q, _, dw, x] = &kept.anchor.lists;
        let fits = [q.len(), dw.len(), x.len()] == [self.degrees(), self.dw.len(), lists.x.len()];
        let LinearisationPoint { is_known, all, h, .. } = kept.anchor;
        let serves = is_known && h.is_identical(self.h) && all == kept.wants_all() && fits;
        if !serves {
            return false;
        }
        let is_there = kept.made == FactorSource::AtAnchor || self.restore(&mut scratch).is_ok();
        scratch.solver.kept.has_started = is_there;
        is_there
    }

    /// Recomputes the factors at the anchor.
    #[cold]
    fn restore(&self, scratch: &mut LoopScratch<'_, S>) -> Result<(), StepFailure> {
        let LoopScratch {
            lists, solver: IterationMemory { diagonal, kept, linear: Some(linear), .. }, ..
        } = scratch
        else {
            return Err(StepFailure::NonFinite);
        };
        let anchor = std::mem::take(&mut kept.anchor);
        let [q, p, dw, x] = &anchor.lists;
        let (t, h) = (anchor.t, anchor.h);
        let step = LoopStep { t, h, q, p, dw, increment: None, ..*self };
        lists.x.copy_from_slice(x);
        step.residual(lists);
        kept.made = FactorSource::Unknown;
        kept.work.factorisations += 1;
        let made = step.factor(lists, diagonal, linear, anchor.all);
        kept.anchor = anchor;
        if made.is_ok() {
            kept.made = FactorSource::AtAnchor;
        }
        made
    }

    /// Computes new factors.
    ///
    /// # Errors
    /// As [`LoopStep::factor`].
    pub(super) fn renew(
        &self,
        lists: &StepLists<'_, S>,
        diagonal: &mut [S],
        linear: &mut LinearSolver<S>,
        kept: &mut FactorCache<S>,
        pinned: Iteration,
    ) -> Result<(), StepFailure> {
        kept.made = FactorSource::Unknown;
        kept.work.factorisations += 1;
        let all = kept.wants_all();
        self.factor(lists, diagonal, linear, all)?;
        if !self.scheme.linearity.is_affine() && linear.is_reversed() {
            // A negative determinant indicates a fold: the careful solver is needed.
            return Err(astray(0, f64::INFINITY));
        }
        if self.scheme.linearity.is_constant() {
            kept.made = FactorSource::Always(self.h.lane(0));
        } else if self.leaves_factors(linear, pinned) {
            kept.next.copy(all, [self.t, self.h], [self.q, self.p, self.dw, &*lists.x]);
            kept.made = FactorSource::Now;
        }
        Ok(())
    }
}
