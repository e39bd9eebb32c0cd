//! The memory of steps with constraints: the impulses of past steps, and scratch.

use super::evaluation::{ConstraintsAt, Multipliers};
use super::flows::RoundedConstraints;
use super::past::PastImpulses;
use super::{Constrained, ConstraintLayout};
use crate::algebra::memory::{MemoryRequest, StepMemory, step_memory};
use crate::algebra::scalar::{Mask as _, Scalar};
use crate::algebra::shape::Shape;
use crate::algebra::state_sum::StateSum;
use crate::ground::numbers::{Numbers, Tape};
use crate::scheme::elements::PairColumns;

/// The memory of steps with constraints.
#[derive(Debug)]
pub struct ConstraintMemory<S: Scalar, L: ConstraintLayout, H: Shape> {
    /// The impulses of past steps, for each drift of the step.
    past: Vec<PastImpulses<S, L::Multipliers>>,
    reached: ReachedNode,
    scratch: Option<Box<ConstraintScratch<S, L, H>>>,
}

/// Whether the scratch has the constraints and the last kick at the end of the step before. They are
/// evaluated again where it has not, with the same bits.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ReachedNode(pub(super) bool);

impl StepMemory for ReachedNode {
    fn tell(&mut self, request: &MemoryRequest) {
        if let MemoryRequest::Forget = request {
            self.0 = false;
        }
    }

    fn adopt(&mut self, _: Self) {
        self.0 = false;
    }

    fn copy(&mut self, _: &Self) {
        self.0 = false;
    }
}

/// Stores nothing.
impl Numbers for ReachedNode {
    fn pass(&mut self, _: &mut Tape) {
        self.0 = false;
    }
}

/// The parts of a memory that a step uses.
pub(crate) struct StepRoom<'m, S: Scalar, L: ConstraintLayout, H: Shape> {
    pub(super) past: &'m mut [PastImpulses<S, L::Multipliers>],
    pub(super) reached: &'m mut ReachedNode,
    pub(super) scratch: &'m mut ConstraintScratch<S, L, H>,
}

impl<S: Scalar, L: ConstraintLayout, H: Shape> ConstraintMemory<S, L, H> {
    /// Room for a step with so many drifts, and whether it was there.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn fits(&self, degrees: usize, drifts: usize, noises: usize) -> bool {
        self.past.len() == drifts
            && self.scratch.as_ref().is_some_and(|scratch| scratch.fits(degrees, noises))
    }

    /// Room for a step with so many drifts.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn room<F: Constrained<Layout = L>>(
        &mut self,
        system: &F,
        degrees: usize,
        drifts: usize,
        noises: usize,
    ) -> StepRoom<'_, S, L, H> {
        if !self.fits(degrees, drifts, noises) {
            self.allocate(system, degrees, drifts, noises);
        }
        let Self { past, reached, scratch } = self;
        let scratch =
            scratch.get_or_insert_with(|| Box::new(ConstraintScratch::new(system, degrees, noises)));
        StepRoom { past, reached, scratch }
    }

    #[cold]
    fn allocate<F: Constrained<Layout = L>>(
        &mut self,
        system: &F,
        degrees: usize,
        drifts: usize,
        noises: usize,
    ) {
        self.reached = ReachedNode(false);
        self.scratch = Some(Box::new(ConstraintScratch::new(system, degrees, noises)));
        self.past.resize_with(drifts, Default::default);
        self.past.iter_mut().for_each(|past| past.fit(Constrained::constraints(system)));
    }
}

impl<S: Scalar, L: ConstraintLayout, H: Shape> Default for ConstraintMemory<S, L, H> {
    fn default() -> Self {
        Self { past: Vec::new(), reached: ReachedNode(false), scratch: None }
    }
}

step_memory! {
    impl[S: Scalar, L: ConstraintLayout, H: Shape] StepMemory for ConstraintMemory<S, L, H> {
        kept: past, reached; scratch: scratch
    }
}

/// The lists of a step.
#[derive(Debug)]
pub(crate) struct ConstraintScratch<S: Scalar, L: ConstraintLayout, H: Shape> {
    pub(super) pattern: L::Pattern,
    /// The constraints at the state, and at the end of a drift.
    pub(super) here: ConstraintsAt<S, L>,
    pub(super) there: ConstraintsAt<S, L>,
    pub(super) factors: L::Factors<S>,
    /// The state during the step, and its rounding errors.
    pub(super) q: H::List<S>,
    pub(super) p: H::List<S>,
    pub(super) lost_q: H::List<S>,
    pub(super) lost_p: H::List<S>,
    /// The diagonal matrix `W = ∂²H/∂p²`, of inverse masses.
    pub(super) w: H::List<S>,
    /// The coordinates at the end of a drift, and the way there.
    pub(super) end: H::List<S>,
    pub(super) lost_end: H::List<S>,
    pub(super) way: H::List<S>,
    /// The increments of the momenta by the last kick, and its time.
    pub(super) kick: H::List<S>,
    pub(super) kick_time: S,
    /// The increments of the momenta by an impulse.
    pub(super) force: H::List<S>,
    /// The velocities.
    pub(super) velocity: H::List<S>,
    /// The impulses `ν`, their corrections, and bounds on the rounding errors of the constraints.
    pub(super) impulses: Multipliers<S, L>,
    pub(super) corrections: Multipliers<S, L>,
    pub(super) bounds: Multipliers<S, L>,
    /// The noise increments of a part.
    pub(super) dw: Vec<S>,
    pub(super) columns: PairColumns,
    /// Where the terms of a constraint are larger than its slopes tell.
    pub(super) rounded: Option<Box<RoundedConstraints>>,
}

impl<S: Scalar, L: ConstraintLayout, H: Shape> ConstraintScratch<S, L, H> {
    /// Scratch for a system with so many degrees of freedom and noises.
    pub(super) fn new<F: Constrained<Layout = L>>(system: &F, degrees: usize, noises: usize) -> Self {
        let (pattern, constraints) = (L::pattern(system, degrees), system.constraints());
        let list = || H::list(degrees, S::from_f64(0.0));
        let multipliers = || L::Multipliers::list(constraints, S::from_f64(0.0));
        Self {
            here: ConstraintsAt::new(&pattern, constraints),
            there: ConstraintsAt::new(&pattern, constraints),
            factors: L::factors(&pattern),
            pattern,
            q: list(),
            p: list(),
            lost_q: list(),
            lost_p: list(),
            w: list(),
            end: list(),
            lost_end: list(),
            way: list(),
            kick: list(),
            kick_time: S::from_f64(f64::NAN),
            force: list(),
            velocity: list(),
            impulses: multipliers(),
            corrections: multipliers(),
            bounds: multipliers(),
            dw: vec![S::from_f64(0.0); noises],
            columns: PairColumns::default(),
            rounded: None,
        }
    }

    /// Coordinates, momenta, and the rounding errors of these.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn momenta(&mut self) -> [&mut [S]; 3] {
        [self.q.as_mut(), self.p.as_mut(), self.lost_p.as_mut()]
    }

    /// Copies the state; returns whether the coordinates are those that are there.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn begin<C: StateSum<S>>(&mut self, q: &[S], p: &[S], carry: &C) -> bool {
        let mut is_same = true;
        for (own, &q) in self.q.as_mut().iter_mut().zip(q) {
            is_same &= own.is_identical(q);
            *own = q;
        }
        self.p.as_mut().copy_from_slice(p);
        let lost = self.lost_q.as_mut().iter_mut().zip(self.lost_p.as_mut());
        for (i, (lost_q, lost_p)) in lost.enumerate() {
            (*lost_q, *lost_p) = (carry.of_coordinate(i), carry.of_momentum(i));
        }
        is_same
    }

    /// Moves the state of the paths that have `taken` the step, and are finite; returns these.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn arrive<C: StateSum<S>>(
        &mut self,
        mut taken: S::Mask,
        q: &mut [S],
        p: &mut [S],
        carry: &mut C,
    ) -> S::Mask {
        for (&q, &p) in self.q.as_ref().iter().zip(self.p.as_ref()) {
            taken = taken & q.is_finite() & p.is_finite();
        }
        if !taken.any() {
            return taken;
        }
        let lost = self.lost_q.as_mut().iter_mut().zip(self.lost_p.as_mut());
        for (i, (lost_q, lost_p)) in lost.enumerate() {
            q[i] = S::select(taken, self.q.as_ref()[i], q[i]);
            p[i] = S::select(taken, self.p.as_ref()[i], p[i]);
            *lost_q = S::select(taken, *lost_q, carry.of_coordinate(i));
            *lost_p = S::select(taken, *lost_p, carry.of_momentum(i));
        }
        carry.keep(self.lost_q.as_ref(), self.lost_p.as_ref());
        taken
    }

    /// Whether the lists have these lengths.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn fits(&self, degrees: usize, noises: usize) -> bool {
        self.q.as_ref().len() == degrees && self.dw.len() == noises
    }
}
