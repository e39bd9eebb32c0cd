//! The residual of a step on numbers that know their rounding: whether what is left of an equation is more than that.
//!
//! Judged for each unknown by the terms of its own equation, so that no site counts for another. It takes a pass that costs
//! several times as much as one of the iteration, and is done only where that does not get any further.

use super::memory::Work;
use super::passes::relative_to_largest;
use super::step::Step;
use super::{Elements, Memory};
use crate::scalar::{Rounded, Scalar};
use crate::solve::larger;

/// The state and the scratch of the step; allocated when it is needed for the first time.
#[derive(Debug, Default)]
pub(super) struct Rounding {
    q: Vec<Rounded>,
    p: Vec<Rounded>,
    dw: Vec<Rounded>,
    increment: Vec<Rounded>,
    work: Work<Rounded>,
}

impl Rounding {
    /// Whether the residual of unknown `k` is at most so many times its rounding, at the point that was last looked at.
    pub(super) fn is_settled(&self, k: usize, roundings: f64) -> bool {
        self.work.correction[k].is_below(roundings)
    }
}

fn lift<S: Scalar>(from: &[S], into: &mut Vec<Rounded>, as_what: fn(f64) -> Rounded) {
    into.clear();
    into.extend(from.iter().map(|number| as_what(number.lane(0))));
}

impl<H: Elements, S: Scalar> Step<'_, H, S> {
    /// Evaluates the equations at all numbers that round to `x`.
    #[cold]
    #[inline(never)]
    pub(super) fn round<'r>(&self, x: &[S], rounding: &'r mut Option<Box<Rounding>>) -> &'r Rounding {
        let rounding = rounding.get_or_insert_default();
        let Rounding { q, p, dw, increment, work } = &mut **rounding;
        lift(self.q, q, Rounded::exact);
        lift(self.p, p, Rounded::exact);
        lift(self.dw, dw, Rounded::exact);
        if work.x.len() != x.len() {
            *work = Work::of_equations(self.scheme, self.q.len());
        }
        lift(x, &mut work.x, Rounded::nearest);
        let increment = self.increment.map(|known| {
            lift(known, increment, Rounded::nearest);
            &**increment
        });
        let Self { system, scheme, t, h, .. } = *self;
        Step { system, scheme, t, h, q: &*q, p: &*p, dw: &*dw, increment }.residual(work);
        rounding
    }

    /// The largest correction, relative to the largest unknown, of those unknowns whose equations are not at rounding after
    /// it; 0 if all are.
    #[cold]
    #[inline(never)]
    pub(super) fn beyond_rounding(&self, memory: &mut Memory<S>) -> f64 {
        let Memory { work, rounding, .. } = memory;
        let rounding = self.round(&work.x, rounding);
        let sizes = work.correction.iter().enumerate().filter(|&(k, _)| !rounding.is_settled(k, 1.0));
        let change = sizes.fold(0.0, |most, (_, correction)| larger(most, correction.magnitude()));
        relative_to_largest(change, &work.x)
    }

    /// The largest correction of a derivative relative to that of its unknown.
    #[cold]
    #[inline(never)]
    pub(super) fn variation(&self, work: &Work<S>) -> f64 {
        let derivative = |number: S| number - S::from_f64(number.lane(0));
        let sizes = work.correction.iter().zip(&work.x);
        sizes.fold(0.0, |most, (&c, &x)| larger(most, derivative(c).relative_to(derivative(x))))
    }
}
