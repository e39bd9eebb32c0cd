//! The residual of a step in numbers that track their rounding error: whether a residual exceeds its
//! rounding.
//!
//! Each unknown is judged by the terms of its own equation, independently of other sites. The pass costs
//! several times as much as an iteration, and is made only when the iteration makes no further progress.

use super::Elements;
use super::memory::{StepLists, StepScratch};
use super::passes::largest;
use super::step::LoopStep;
use crate::algebra::scalar::{Rounded, Scalar, larger};
use crate::algebra::solve::relative_to;

/// The state and the scratch of the step; allocated at the first use.
#[derive(Debug, Default)]
pub(super) struct Rounding {
    q: Vec<Rounded>,
    p: Vec<Rounded>,
    dw: Vec<Rounded>,
    increment: Vec<Rounded>,
    work: StepScratch<Rounded>,
}

pub(super) fn lift<S: Scalar>(from: &[S], into: &mut Vec<Rounded>, as_what: fn(f64) -> Rounded) {
    into.clear();
    into.extend(from.iter().map(|number| as_what(number.lane(0))));
}

impl<H: Elements, S: Scalar> LoopStep<'_, H, S> {
    /// The residuals at all numbers that round to `x`, with error bounds.
    #[cold]
    #[inline(never)]
    pub(super) fn round<'r>(self, x: &[S], rounding: &'r mut Option<Box<Rounding>>) -> &'r [Rounded] {
        let rounding = rounding.get_or_insert_default();
        let Rounding { q, p, dw, increment, work } = &mut **rounding;
        lift(self.q, q, Rounded::exact);
        lift(self.p, p, Rounded::exact);
        lift(self.dw, dw, Rounded::exact);
        if !work.fits(self.scheme, self.degrees()) {
            *work = StepScratch::new(self.scheme, self.degrees());
        }
        let mut lists = work.lists(self.scheme, self.degrees());
        read_nearest(x, lists.x);
        let increment = self.increment.map(|known| {
            lift(known, increment, Rounded::nearest);
            &**increment
        });
        let Self { system, scheme, .. } = self;
        let ([t, h], parameters) = ([self.t, self.h].map(|constant| constant.lane(0)), &[][..]);
        let step = LoopStep { system, scheme, t, h, parameters, q: &*q, p: &*p, dw: &*dw, increment };
        step.residual(&mut lists);
        lists.correction
    }

    /// The largest correction, relative to the largest unknown of its kind, of the unknowns whose equations
    /// are still not at rounding; 0 if all are. An equation that had no correction but has crossed a
    /// condition counts with its residual.
    #[cold]
    #[inline(never)]
    pub(super) fn beyond_rounding(
        self,
        lists: StepLists<'_, S>,
        rounding: &mut Option<Box<Rounding>>,
    ) -> f64 {
        let rounding = self.round(lists.x, rounding);
        beyond(largest(self.scheme.unknowns, lists.x), lists.correction, rounding)
    }
}

fn read_nearest<S: Scalar>(from: &[S], into: &mut [Rounded]) {
    into.iter_mut().zip(from).for_each(|(into, number)| *into = Rounded::nearest(number.lane(0)));
}

/// The largest correction relative to the size of its kind, of those whose residual is more than its
/// rounding.
fn beyond<S: Scalar>(sizes: [f64; 2], correction: &[S], residual: &[Rounded]) -> f64 {
    let left =
        correction.iter().zip(residual).enumerate().filter(|(_, (_, residual))| !residual.is_below(1.0));
    left.fold(0.0, |most, (k, (correction, residual))| {
        let taken = correction.magnitude();
        let size = if taken == 0.0 { residual.magnitude() } else { taken };
        larger(most, relative_to(size, sizes[k % 2]))
    })
}

/// The largest correction of a derivative relative to that of its unknown.
#[cold]
#[inline(never)]
pub(super) fn variation<S: Scalar>(x: &[S], correction: &[S]) -> f64 {
    let derivative = |number: S| number - S::from_f64(number.lane(0));
    correction
        .iter()
        .zip(x)
        .fold(0.0, |most, (&c, &x)| larger(most, relative_to(derivative(c), derivative(x))))
}
