//! The parts of a step on the manifold of the constraints: kicks, drifts, friction, projections.

use super::memory::ConstraintScratch;
use super::past::PastImpulses;
use super::{Constrained, ConstraintLayout, MOST_ITERATIONS, ROUNDINGS};
use crate::algebra::scalar::{Mask, Rounded, Scalar};
use crate::algebra::shape::Shape;
use crate::algebra::state_sum::StateSum;
use crate::scheme::compose::lists::add;
use crate::scheme::elements::{EvaluationPoint, field};

/// A system with the constants of a step.
pub(crate) struct ConstrainedFlows<'a, F, S: Scalar> {
    pub(super) system: &'a F,
    pub(super) parameters: &'a [S::Constant],
}

/// The outcome of a part of a step.
#[derive(Clone, Copy)]
pub(super) struct Outcome<S: Scalar> {
    /// The paths that have taken it.
    pub(super) taken: S::Mask,
    /// Iterations.
    pub(super) iterations: u32,
    /// The largest residual of a constraint relative to its terms, before the last correction.
    pub(super) residual: S,
}

impl<F: Constrained, S: Scalar> ConstrainedFlows<'_, F, S> {
    /// How far the coordinates are from the manifold: the largest `|g_k| / Σ_i |G_ki q_i|`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn distance(&self, scratch: &mut ConstraintScratch<S, F::Layout, F::Shape>) -> S {
        let ConstraintScratch { pattern, here, q, bounds, .. } = scratch;
        let bounds = bounds.as_mut();
        F::Layout::absolute_product(pattern, &here.jacobian, q.as_ref(), bounds);
        largest_ratio(here.values.as_ref(), bounds)
    }

    /// The constraints at the state.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn evaluate_here(
        &self,
        scratch: &mut ConstraintScratch<S, F::Layout, F::Shape>,
        t: S::Constant,
    ) {
        let ConstraintScratch { pattern, here, q, .. } = scratch;
        here.evaluate(self.system, self.parameters, pattern, q.as_ref(), t);
    }

    /// `W = ∂²H/∂p²`, the velocities of momenta of one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn weigh(&self, scratch: &mut ConstraintScratch<S, F::Layout, F::Shape>) {
        let ConstraintScratch { q, w, velocity, columns, .. } = scratch;
        let ones = velocity.as_mut();
        ones.fill(S::from_f64(1.0));
        let (zero, one) = (S::from_f64(0.0), S::from_f64(1.0));
        let at = ([zero, one], [q.as_ref(), &*ones], &[][..]);
        field::<F, S, false, true>((self.system, self.parameters), at, [&mut [], w.as_mut()], columns);
    }

    /// `p ← p - h ∂H/∂q` with the noises of this fraction of the step. `may_reuse`: the last kick was at
    /// these coordinates.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn kick<C: StateSum<S>>(
        &self,
        scratch: &mut ConstraintScratch<S, F::Layout, F::Shape>,
        t: S::Constant,
        h: S::Constant,
        dw: &[S],
        weight: f64,
        may_reuse: bool,
    ) {
        let ConstraintScratch { q, p, lost_p, kick, kick_time, dw: scaled, columns, .. } = scratch;
        let h = -S::of_constant(h);
        if !(may_reuse && kick_time.is_identical(h)) {
            for (scaled, dw) in scaled.iter_mut().zip(dw) {
                *scaled = *dw * -weight;
            }
            let at = ([S::of_constant(t), h], [q.as_ref(), p.as_ref()], &scaled[..]);
            let into = [kick.as_mut(), &mut []];
            field::<F, S, true, false>((self.system, self.parameters), at, into, columns);
            *kick_time = h;
        }
        add::<S, C>(p.as_mut(), kick.as_ref(), lost_p.as_mut());
    }

    /// A drift over the time `h` to the time `t`: `P = p - G(q)ᵀ ν`, `q_1 = q + h W P`, `g(q_1) = 0`, by
    /// Newton's method with the matrix `h G(q_1) W G(q)ᵀ`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn drift<C: StateSum<S>, const USES_PAST: bool>(
        &self,
        scratch: &mut ConstraintScratch<S, F::Layout, F::Shape>,
        past: &mut PastImpulses<S, <F::Layout as ConstraintLayout>::Multipliers>,
        t: S::Constant,
        h: S::Constant,
    ) -> Outcome<S> {
        let zero = S::from_f64(0.0);
        if USES_PAST {
            past.guess(scratch.impulses.as_mut());
        } else {
            scratch.impulses.as_mut().fill(zero);
        }
        let h = S::of_constant(h);
        let mut outcome =
            Outcome { taken: S::Mask::from_bool(true), iterations: 0, residual: S::from_f64(f64::INFINITY) };
        let mut done = S::Mask::from_bool(false);
        loop {
            self.move_by_impulses::<C>(scratch, h, t);
            let residual = residual(scratch);
            let is_solved = residual.less_equal(S::from_f64(ROUNDINGS));
            let stagnates = !(residual * 2.0).less(outcome.residual) & !is_solved;
            done = done | is_solved;
            outcome.residual = S::select(is_solved | stagnates, outcome.residual, residual);
            let lost = stagnates & !done & outcome.taken;
            if lost.any() {
                // The terms of a constraint may be larger than its slopes tell.
                let is_rounding = self.is_rounding(scratch, t, lost);
                done = done | (lost & is_rounding);
                outcome.taken = outcome.taken & (!lost | is_rounding);
            }
            if (done | !outcome.taken).all() {
                break;
            }
            if outcome.iterations == MOST_ITERATIONS {
                outcome.taken = outcome.taken & done;
                break;
            }
            outcome.iterations += 1;
            self.correct(scratch, h, &mut outcome, done);
        }
        if const { S::DERIVATIVES > 0 } {
            self.correct_derivatives(scratch, h);
            self.move_by_impulses::<C>(scratch, h, t);
        }
        if USES_PAST {
            past.record(outcome.taken, scratch.impulses.as_ref());
        }
        let ConstraintScratch { here, there, q, p, lost_q, lost_p, end, lost_end, force, .. } = scratch;
        std::mem::swap(here, there);
        std::mem::swap(q, end);
        std::mem::swap(lost_q, lost_end);
        add::<S, C>(p.as_mut(), force.as_ref(), lost_p.as_mut());
        outcome
    }

    /// The end of a drift with the impulses so far, and the constraints there. `-Gᵀ ν` is left in `force`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn move_by_impulses<C: StateSum<S>>(
        &self,
        scratch: &mut ConstraintScratch<S, F::Layout, F::Shape>,
        h: S,
        t: S::Constant,
    ) {
        let ConstraintScratch {
            pattern,
            here,
            there,
            q,
            p,
            lost_q,
            w,
            end,
            lost_end,
            way,
            force,
            impulses,
            ..
        } = scratch;
        let (q, p, w, lost_q) = (q.as_ref(), p.as_ref(), w.as_ref(), lost_q.as_ref());
        let (end, lost_end, way, force) = (end.as_mut(), lost_end.as_mut(), way.as_mut(), force.as_mut());
        F::Layout::transposed_product(pattern, &here.jacobian, impulses.as_ref(), force);
        for i in 0..q.len() {
            force[i] = -force[i];
            way[i] = h * (w[i] * (p[i] + force[i]));
            (end[i], lost_end[i]) = C::add(q[i], way[i], lost_q[i]);
        }
        there.evaluate(self.system, self.parameters, pattern, end, t);
    }

    /// Newton's correction of the impulses of paths that are not `done`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn correct(
        &self,
        scratch: &mut ConstraintScratch<S, F::Layout, F::Shape>,
        h: S,
        outcome: &mut Outcome<S>,
        done: S::Mask,
    ) {
        let ConstraintScratch { pattern, here, there, factors, w, impulses, corrections, .. } = scratch;
        let is_regular = F::Layout::factor(pattern, &there.jacobian, w.as_ref(), &here.jacobian, factors);
        outcome.taken = outcome.taken & (done | is_regular);
        let corrections = corrections.as_mut();
        for (correction, &value) in corrections.iter_mut().zip(there.values.as_ref()) {
            *correction = value / h;
        }
        F::Layout::solve(pattern, factors, corrections);
        for (impulse, &correction) in impulses.as_mut().iter_mut().zip(&*corrections) {
            *impulse = S::select(done, *impulse, *impulse + correction);
        }
    }

    /// Newton's correction of the derivatives of solved impulses.
    #[cold]
    fn correct_derivatives(&self, scratch: &mut ConstraintScratch<S, F::Layout, F::Shape>, h: S) {
        let ConstraintScratch { pattern, here, there, factors, w, impulses, corrections, .. } = scratch;
        F::Layout::factor(pattern, &there.jacobian, w.as_ref(), &here.jacobian, factors);
        let corrections = corrections.as_mut();
        for (correction, &value) in corrections.iter_mut().zip(there.values.as_ref()) {
            *correction = value.infinitesimal() / h;
        }
        F::Layout::solve(pattern, factors, corrections);
        for (impulse, &correction) in impulses.as_mut().iter_mut().zip(&*corrections) {
            *impulse = *impulse + correction.infinitesimal();
        }
    }

    /// Where the constraints at the end of a drift are no more than the rounding of their terms, among the
    /// paths in `asked`.
    #[cold]
    #[inline(never)]
    fn is_rounding(
        &self,
        scratch: &mut ConstraintScratch<S, F::Layout, F::Shape>,
        t: S::Constant,
        asked: S::Mask,
    ) -> S::Mask {
        let ConstraintScratch { end, rounded, .. } = scratch;
        let RoundedConstraints { end: rounded, values } = &mut **rounded.get_or_insert_default();
        values.resize(self.system.constraints(), Rounded::exact(0.0));
        S::Mask::of_lanes(|lane| {
            asked.lane(lane) && {
                rounded.clear();
                rounded.extend(end.as_ref().iter().map(|q| Rounded::nearest(q.lane(lane))));
                values.fill(Rounded::exact(0.0));
                let at = EvaluationPoint::new([&rounded[..], &[][..]], t.lane(0), &[], &[]);
                self.system.constrain(&at, &mut Values(values));
                values.iter().all(|value| value.is_below(1.0))
            }
        })
    }

    /// Projects the momenta: `p ← p - Gᵀ ν` with `G W p + ∂g/∂t = 0`. Returns where `G W Gᵀ` is regular.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn project<C: StateSum<S>>(
        &self,
        scratch: &mut ConstraintScratch<S, F::Layout, F::Shape>,
    ) -> S::Mask {
        let ConstraintScratch { pattern, here, factors, p, lost_p, w, force, velocity, impulses, .. } =
            scratch;
        let is_regular = F::Layout::factor(pattern, &here.jacobian, w.as_ref(), &here.jacobian, factors);
        let (velocity, impulses, force) = (velocity.as_mut(), impulses.as_mut(), force.as_mut());
        for ((velocity, &p), &w) in velocity.iter_mut().zip(p.as_ref()).zip(w.as_ref()) {
            *velocity = w * p;
        }
        F::Layout::product(pattern, &here.jacobian, velocity, impulses);
        if F::READ_TIME {
            for (impulse, &rate) in impulses.iter_mut().zip(here.rates.as_ref()) {
                *impulse = *impulse + rate;
            }
        }
        F::Layout::solve(pattern, factors, impulses);
        F::Layout::transposed_product(pattern, &here.jacobian, impulses, force);
        for force in &mut *force {
            *force = -*force;
        }
        add::<S, C>(p.as_mut(), force, lost_p.as_mut());
        is_regular
    }

    /// `p · W p / 2`
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn kinetic_energy(&self, scratch: &ConstraintScratch<S, F::Layout, F::Shape>) -> S {
        let mut sum = S::from_f64(0.0);
        for (&p, &w) in scratch.p.as_ref().iter().zip(scratch.w.as_ref()) {
            sum = sum + w * p * p;
        }
        sum * 0.5
    }
}

/// The constraints at the end of a drift, with bounds on their rounding errors.
#[derive(Debug, Default)]
pub(super) struct RoundedConstraints {
    end: Vec<Rounded>,
    values: Vec<Rounded>,
}

/// Takes the values of constraints alone.
struct Values<'a>(&'a mut [Rounded]);

impl super::ConstraintRows<Rounded> for Values<'_> {
    fn value(&mut self, constraint: usize, value: Rounded) {
        self.0[constraint] = self.0[constraint] + value;
    }

    fn slope(&mut self, _: usize, _: usize, _: Rounded) {}

    fn rate(&mut self, _: usize, _: Rounded) {}
}

/// The largest `|g_k|` at the end of a drift relative to `Σ_i |G_ki| (|q_i| + |q_1i|)`, by which the
/// rounding of the coordinates changes `g_k`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn residual<S: Scalar, L: ConstraintLayout, H: Shape>(scratch: &mut ConstraintScratch<S, L, H>) -> S {
    let ConstraintScratch { pattern, there, q, end, velocity, bounds, .. } = scratch;
    let (sizes, bounds) = (velocity.as_mut(), bounds.as_mut());
    for ((size, &q), &end) in sizes.iter_mut().zip(q.as_ref()).zip(end.as_ref()) {
        *size = q.abs() + end.abs();
    }
    L::absolute_product(pattern, &there.jacobian, sizes, bounds);
    largest_ratio(there.values.as_ref(), bounds)
}

/// The largest ratio of a number to its terms; one of no terms counts as it is.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn largest_ratio<S: Scalar>(values: &[S], terms: &[S]) -> S {
    let (mut largest, zero) = (S::from_f64(0.0), S::from_f64(0.0));
    for (&value, &terms) in values.iter().zip(terms) {
        let terms = S::select(terms.equal(zero), S::from_f64(1.0), terms);
        largest = largest.larger(value.abs() / terms);
    }
    largest
}
