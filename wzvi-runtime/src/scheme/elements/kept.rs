//! Factors that serve more than one step, and where they were made.
//!
//! Newton's method with the factors of an earlier step is the chord method; it contracts by how far the Jacobian has changed since. A step
//! starts with those that are there, and makes new ones where they contract too slowly. They are given up as well when the iterations
//! that they took more than new ones add up to what new ones cost (the rule of who rents skis and does not know for how long: at most
//! twice as much as if that had been known). Where products with the Jacobian solve the equations, the factors are their preconditioner.
//!
//! A checkpoint, or a copy, does not have the factors, but where they were made: the same steps follow, to the last bit.

use super::Elements;
use super::linear::Linear;
use super::memory::{Lists, Scratch, Solver};
use super::step::Step;
use crate::algebra::memory::{Iteration, LinearWork};
use crate::algebra::scalar::Scalar;
use crate::algebra::solve::astray;
use crate::error::StepFailure;
use crate::ground::numbers::{Numbers, Tape};

/// Products with the Jacobian that factors which lack entries may take in vain before they get all: about as many as these cost.
pub(super) const PATIENCE: u32 = 128;
/// Products that take about as long as a solution by factors that lack nothing.
const A_SOLUTION: u32 = 4;

/// The step, and the unknowns in it, that factors were made of.
#[derive(Debug, Default)]
struct Anchor<S> {
    is_known: bool,
    /// Whether they were asked for with all of their entries.
    all: bool,
    t: f64,
    h: f64,
    /// Coordinates, momenta, increments of the noises, unknowns.
    lists: [Vec<S>; 4],
}

impl<S: Copy> Anchor<S> {
    /// Keeps what is allocated.
    fn copy(&mut self, all: bool, t: f64, h: f64, lists: [&[S]; 4]) {
        (self.is_known, self.all, self.t, self.h) = (true, all, t, h);
        for (own, list) in self.lists.iter_mut().zip(lists) {
            own.clear();
            own.extend_from_slice(list);
        }
    }
}

/// What the factors in a memory are of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Made {
    /// There are none, or they are of nothing that comes again.
    #[default]
    Unknown,
    /// All steps of this size.
    Always(f64),
    /// The anchor.
    AtAnchor,
    /// This step, which becomes the anchor if it succeeds.
    Now,
}

/// What is known of the factors in a memory.
#[derive(Debug, Default)]
pub(super) struct Kept<S> {
    made: Made,
    /// Where the factors that the next step starts with were made.
    anchor: Anchor<S>,
    /// Where those of this step were.
    next: Anchor<S>,
    /// Whether this step started with factors of an earlier one.
    has_started: bool,
    /// What this step took: iterations, or products with the Jacobian where these solve the equations.
    taken: u64,
    /// The same of the step that made the factors, and what the steps since took more.
    least: u64,
    excess: u64,
    /// Products more than solutions by factors with all of their entries would have taken.
    vain: u64,
    pub(super) work: LinearWork,
}

/// Where they were made, not the factors.
impl<S: Scalar> Clone for Kept<S> {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    fn clone_from(&mut self, other: &Self) {
        self.made = Made::Unknown;
        (self.least, self.excess, self.vain) = (other.least, other.excess, other.vain);
        self.work = other.work;
        let Anchor { is_known, all, t, h, lists } = &other.anchor;
        self.anchor.is_known = *is_known;
        if *is_known {
            self.anchor.copy(*all, *t, *h, lists.each_ref().map(Vec::as_slice));
        }
    }
}

impl<S: Scalar> Numbers for Kept<S> {
    fn pass(&mut self, tape: &mut Tape) {
        if matches!(tape, Tape::Reading { .. } | Tape::Joining { .. }) {
            self.lose();
        }
        tape.word(&mut self.vain);
        let Anchor { is_known, all, t, h, lists } = &mut self.anchor;
        tape.flag(is_known);
        if !*is_known {
            return;
        }
        tape.flag(all);
        tape.numbers([t, h]);
        lists.pass(tape);
        tape.words([&mut self.least, &mut self.excess]);
    }
}

impl<S: Scalar> Kept<S> {
    /// The next step makes factors of its own.
    pub(super) fn forget(&mut self) {
        (self.anchor.is_known, self.vain) = (false, 0);
        self.lose();
    }

    /// The factors are not in the memory any more.
    pub(super) fn lose(&mut self) {
        self.made = Made::Unknown;
        self.begin();
    }

    /// A step begins. Factors of one that failed are of nothing that comes again.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn begin(&mut self) {
        (self.taken, self.has_started) = (0, false);
        if self.made == Made::Now {
            self.made = Made::Unknown;
        }
    }

    /// Counts what a correction took: products with the Jacobian, or itself.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn count(&mut self, products: Option<u32>) {
        self.taken += products.map_or(1, u64::from);
        self.work.products += products.map_or(0, u64::from);
        if !self.wants_all() {
            self.vain += products.map_or(0, |products| u64::from(products.saturating_sub(A_SOLUTION)));
        }
    }

    /// Whether factors that lack entries have taken as much more as those that do not cost.
    pub(super) fn wants_all(&self) -> bool {
        self.vain >= u64::from(PATIENCE - A_SOLUTION)
    }

    /// A step by Newton's method has succeeded, with factors that cost as much as so many corrections.
    pub(super) fn succeed(&mut self, cost: u64) {
        if self.made == Made::Now {
            std::mem::swap(&mut self.anchor, &mut self.next);
            // What a step takes that started with other factors says little of its own.
            self.anchor.is_known = !self.has_started;
            (self.made, self.least, self.excess) = (Made::AtAnchor, self.taken, 0);
        } else if self.has_started {
            self.excess += self.taken.saturating_sub(self.least);
            self.anchor.is_known &= self.excess < cost;
        }
    }
}

impl<H: Elements, S: Scalar> Step<'_, H, S> {
    /// Whether later steps may start with factors of this one. Where increments decide, the Jacobian of one is not near that of the next,
    /// and a pinned method has that of each iteration; preconditioners need not be near.
    fn leaves_factors(&self, linear: &Linear<S>, pinned: Iteration) -> bool {
        let is_chord = pinned != Iteration::Newton && (self.scheme.remembers || self.scheme.is_linear);
        is_chord || matches!(linear, Linear::Krylov(_))
    }

    /// Whether there are factors to start with; leaves the lists of nothing. (What it takes is lent by value: a reference to all that an iteration works
    /// on would keep its loops from being compiled for vectors.)
    #[inline(never)]
    pub(super) fn starts_with_factors(&self, mut scratch: Scratch<'_, S>, pinned: Iteration) -> bool {
        let Scratch { lists, solver: Solver { kept, linear: Some(linear), .. }, .. } = &scratch else {
            return false;
        };
        if !self.leaves_factors(linear, pinned) {
            return false;
        }
        if self.scheme.is_linear || kept.made == Made::Now {
            return kept.made == Made::Now || kept.made == Made::Always(self.h);
        }
        let [q, _, dw, x] = &kept.anchor.lists;
        let fits = [q.len(), dw.len(), x.len()] == [self.degrees(), self.dw.len(), lists.x.len()];
        let Anchor { is_known, all, h, .. } = kept.anchor;
        let serves = is_known && h == self.h && all == kept.wants_all() && fits;
        if !serves {
            return false;
        }
        let is_there = kept.made == Made::AtAnchor || self.restore(&mut scratch).is_ok();
        scratch.solver.kept.has_started = is_there;
        is_there
    }

    /// The factors of the anchor, once more.
    #[cold]
    fn restore(&self, scratch: &mut Scratch<'_, S>) -> Result<(), StepFailure> {
        let Scratch { lists, solver: Solver { diagonal, kept, linear: Some(linear), .. }, .. } = scratch
        else {
            return Err(StepFailure::NonFinite);
        };
        let anchor = std::mem::take(&mut kept.anchor);
        let [q, p, dw, x] = &anchor.lists;
        let (t, h) = (anchor.t, anchor.h);
        let step = Step { system: self.system, scheme: self.scheme, t, h, q, p, dw, increment: None };
        lists.x.copy_from_slice(x);
        step.residual(lists);
        kept.made = Made::Unknown;
        kept.work.factorisations += 1;
        let made = step.factor(lists, diagonal, linear, anchor.all, |_| false);
        kept.anchor = anchor;
        if made.is_ok() {
            kept.made = Made::AtAnchor;
        }
        made
    }

    /// New factors.
    ///
    /// # Errors
    /// As [`Step::factor`].
    pub(super) fn renew(
        &self,
        lists: &Lists<'_, S>,
        diagonal: &mut [S],
        linear: &mut Linear<S>,
        kept: &mut Kept<S>,
        pinned: Iteration,
    ) -> Result<(), StepFailure> {
        kept.made = Made::Unknown;
        kept.work.factorisations += 1;
        let all = kept.wants_all();
        self.factor(lists, diagonal, linear, all, |_| false)?;
        if !self.scheme.is_linear && linear.is_reversed() {
            // Beyond a fold, as far as this matrix tells: with care.
            return Err(astray(0, f64::INFINITY));
        }
        if self.scheme.is_linear {
            kept.made = Made::Always(self.h);
        } else if self.leaves_factors(linear, pinned) {
            kept.next.copy(all, self.t, self.h, [self.q, self.p, self.dw, &*lists.x]);
            kept.made = Made::Now;
        }
        Ok(())
    }
}
