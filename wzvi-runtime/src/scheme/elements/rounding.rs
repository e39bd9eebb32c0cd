//! The residual of a step on numbers that know their rounding: whether what is left of an equation is more than that.
//!
//! Judged for each unknown by the terms of its own equation, so that no site counts for another. It takes a pass that costs
//! several times as much as one of the iteration, and is done only where that does not get any further.

use super::Elements;
use super::memory::{Lists, Work};
use super::passes::largest;
use super::step::Step;
use crate::algebra::scalar::{Rounded, Scalar};
use crate::algebra::solve::larger;

/// The state and the scratch of the step; allocated when it is needed for the first time.
#[derive(Debug, Default)]
pub(super) struct Rounding {
    q: Vec<Rounded>,
    p: Vec<Rounded>,
    dw: Vec<Rounded>,
    increment: Vec<Rounded>,
    work: Work<Rounded>,
}

fn lift<S: Scalar>(from: &[S], into: &mut Vec<Rounded>, as_what: fn(f64) -> Rounded) {
    into.clear();
    into.extend(from.iter().map(|number| as_what(number.lane(0))));
}

impl<H: Elements, S: Scalar> Step<'_, H, S> {
    /// The equations at all numbers that round to `x`.
    #[cold]
    #[inline(never)]
    pub(super) fn round<'r>(self, x: &[S], rounding: &'r mut Option<Box<Rounding>>) -> &'r [Rounded] {
        let rounding = rounding.get_or_insert_default();
        let Rounding { q, p, dw, increment, work } = &mut **rounding;
        lift(self.q, q, Rounded::exact);
        lift(self.p, p, Rounded::exact);
        lift(self.dw, dw, Rounded::exact);
        if !work.fits(self.scheme, self.degrees()) {
            *work = Work::new(self.scheme, self.degrees());
        }
        let mut lists = work.lists(self.scheme, self.degrees());
        lists.x.iter_mut().zip(x).for_each(|(rounded, number)| *rounded = Rounded::nearest(number.lane(0)));
        let increment = self.increment.map(|known| {
            lift(known, increment, Rounded::nearest);
            &**increment
        });
        let Self { system, scheme, t, h, .. } = self;
        let step = Step { system, scheme, t, h, q: &*q, p: &*p, dw: &*dw, increment };
        step.residual(&mut lists);
        lists.correction
    }

    /// The largest correction, relative to the largest unknown of its kind, of those unknowns whose equations are not at rounding after
    /// it; 0 if all are. An equation that had none and is on another side of a condition now counts by what it leaves.
    #[cold]
    #[inline(never)]
    pub(super) fn beyond_rounding(self, lists: Lists<'_, S>, rounding: &mut Option<Box<Rounding>>) -> f64 {
        let rounding = self.round(lists.x, rounding);
        let sizes = largest(self.scheme.unknowns, lists.x);
        let left = lists.correction.iter().enumerate().filter(|&(k, _)| !rounding[k].is_below(1.0));
        left.fold(0.0, |most, (k, correction)| {
            let taken = correction.magnitude();
            let size = if taken == 0.0 { rounding[k].magnitude() } else { taken };
            larger(most, size.relative_to(sizes[k % 2]))
        })
    }
}

/// The largest correction of a derivative relative to that of its unknown.
#[cold]
#[inline(never)]
pub(super) fn variation<S: Scalar>(x: &[S], correction: &[S]) -> f64 {
    let derivative = |number: S| number - S::from_f64(number.lane(0));
    correction
        .iter()
        .zip(x)
        .fold(0.0, |most, (&c, &x)| larger(most, derivative(c).relative_to(derivative(x))))
}
