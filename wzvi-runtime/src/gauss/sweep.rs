//! Sweeps over all stages at once, `Y ← φ(Y)`, until nothing but rounding changes.

use super::Field;
use super::advance::Step;
use super::kept::{Lists, Memory};
use super::stages::{At, Scratch, Stages};
use crate::carry::Carry;
use crate::error::StepFailure;
use crate::scalar::{Rounded, Scalar};
use crate::solve::Effort;

/// Sweeps that are tried.
const MOST_SWEEPS: u32 = 60;
/// Sweeps before their contraction is judged: the first ones need not contract.
const PATIENCE: u32 = 6;
/// A sweep that leaves more of the change than this is slower than Newton's method.
const SLOW: f64 = 0.6;
/// Changes below this fraction of an unknown change nothing.
const ROUNDING: f64 = f64::EPSILON;

/// What the next sweep would change, in units of rounding: not random as rounding is, so that over many steps it adds up.
const UNSEEN: f64 = 0.02;

/// How a step was solved.
pub(super) struct Solved {
    pub(super) effort: Effort,
    pub(super) prefers_newton: bool,
}

impl<F: Field, S: Scalar, const N: usize> Step<'_, F, S, N> {
    /// One sweep: new slopes, and the stages that follow from them. The largest change of a stage relative to its own degree of
    /// freedom; NaN if any is.
    #[inline(always)]
    pub(super) fn sweep<C: Carry<S>>(
        &self,
        lists: &mut Lists<S, F::Shape, N>,
        memory: &mut Memory<S, F::Shape, N>,
        carry: &C,
    ) -> f64 {
        self.field(lists, memory);
        let mut change = 0.0_f64;
        if F::IS_NYSTROM {
            let zero = S::Stages::<N>::splat(S::from_f64(0.0));
            {
                let Lists { at: [_, p], slopes: [_, by_q], .. } = &mut *lists;
                for (d, (p, slopes)) in p.as_mut().iter_mut().zip(by_q.as_ref()).enumerate() {
                    let start = zero.plus_scaled(&self.table.c, self.p[d] + carry.of_momentum(d));
                    *p = start.plus_product(&self.table.eta, *slopes);
                }
            }
            let Lists { at: [q, p], slopes: [velocity, _], spare, .. } = lists;
            let (q, velocity) = (q.as_mut(), velocity.as_mut());
            let (at, scratch) = (&self.at, &mut memory.scratch);
            S::Stages::slopes::<F, false, true>(
                self.system,
                at,
                q,
                p.as_ref(),
                spare.as_mut(),
                velocity,
                scratch,
            );
            for (d, (q, velocity)) in q.iter_mut().zip(velocity).enumerate() {
                let start = self.q[d] + carry.of_coordinate(d);
                change = larger(change, replace(q, start, S::Stages::splat(start).plus(*velocity)));
            }
        } else {
            let Lists { at: [q, p], slopes: [by_p, by_q], .. } = lists;
            let parts = [(q, self.q, by_p), (p, self.p, by_q)];
            for (k, (stages, start, slopes)) in parts.into_iter().enumerate() {
                for (d, (stage, slopes)) in stages.as_mut().iter_mut().zip(slopes.as_ref()).enumerate() {
                    let carried = if k == 0 { carry.of_coordinate(d) } else { carry.of_momentum(d) };
                    let start = start[d] + carried;
                    let next = S::Stages::splat(start).plus_product(&self.table.mu, *slopes);
                    change = larger(change, replace(stage, start, next));
                }
            }
        }
        change
    }

    /// Sweeps from the stages that are there.
    #[inline(always)]
    pub(super) fn sweeps<C: Carry<S>>(
        &self,
        lists: &mut Lists<S, F::Shape, N>,
        memory: &mut Memory<S, F::Shape, N>,
        carry: &C,
    ) -> Result<Solved, StepFailure> {
        let mut last = f64::INFINITY;
        let mut before_last = f64::INFINITY;
        for sweeps in 1..=MOST_SWEEPS {
            let change = self.sweep(lists, memory, carry);
            if change.is_nan() || change == f64::INFINITY {
                return Err(StepFailure::NonFinite);
            }
            // Nothing is known of the contraction before the second one.
            let ratio = if last < f64::INFINITY { change / last } else { 1.0 };
            let is_small = change <= ROUNDING || (ratio < 0.5 && change * ratio <= UNSEEN * ROUNDING);
            if is_small || (ratio > 0.5 && sweeps > 2 && self.is_rounding(lists, carry)) {
                self.follow_derivatives(sweeps, lists, memory, carry);
                return Ok(Solved { effort: Effort::fast(sweeps), prefers_newton: false });
            }
            let is_slow = (change / before_last).sqrt() > SLOW;
            if sweeps >= PATIENCE && is_slow {
                return Err(StepFailure::NotConverged { iterations: sweeps, correction: change });
            }
            (before_last, last) = (last, change);
        }
        Err(StepFailure::NotConverged { iterations: MOST_SWEEPS, correction: last })
    }

    /// Derivatives that a number carries converge as fast as it does, but later.
    #[inline(always)]
    pub(super) fn follow_derivatives<C: Carry<S>>(
        &self,
        sweeps: u32,
        lists: &mut Lists<S, F::Shape, N>,
        memory: &mut Memory<S, F::Shape, N>,
        carry: &C,
    ) {
        if size_of::<S>() != size_of::<f64>() {
            for _ in 0..sweeps + 2 {
                self.sweep(lists, memory, carry);
            }
        }
    }

    /// Whether the stages solve their equations to the rounding of the terms of these.
    #[cold]
    #[inline(never)]
    pub(super) fn is_rounding<C: Carry<S>>(&self, lists: &Lists<S, F::Shape, N>, carry: &C) -> bool {
        let exact = |numbers: &[S]| -> Vec<Rounded> {
            numbers.iter().map(|number| Rounded::exact(number.lane(0))).collect()
        };
        let stages = |list: &[S::Stages<N>]| -> Vec<[Rounded; N]> {
            list.iter().map(|s| std::array::from_fn(|i| Rounded::nearest(s.get(i).lane(0)))).collect()
        };
        let degrees = self.q.len();
        let (dw, c) = (exact(self.at.dw), self.at.c);
        let at = At { t: self.at.t, h: self.at.h, dw: &dw, c };
        let [q, p] = [stages(lists.at[0].as_ref()), stages(lists.at[1].as_ref())];
        let zero = [Rounded::exact(0.0); N];
        let (mut by_q, mut by_p) = (vec![zero; degrees], vec![zero; degrees]);
        let mut scratch = Scratch::default();
        <[Rounded; N]>::slopes::<F, true, true>(self.system, &at, &q, &p, &mut by_q, &mut by_p, &mut scratch);
        let negated = |slope: [Rounded; N]| zero.minus(slope.times(&self.table.b));
        by_q.iter_mut().for_each(|slope| *slope = negated(*slope));
        by_p.iter_mut().for_each(|slope| *slope = slope.times(&self.table.b));
        let start = |numbers: &[S], carried: &dyn Fn(usize) -> S, d: usize| {
            Rounded::exact(numbers[d].lane(0)) + Rounded::exact(carried(d).lane(0))
        };
        let coordinate = |d: usize| carry.of_coordinate(d);
        let momentum = |d: usize| carry.of_momentum(d);
        let holds = |stage: [Rounded; N], next: [Rounded; N]| {
            stage.minus(next).iter().all(|residual| residual.is_below(1.0))
        };
        if F::IS_NYSTROM {
            let moved = (0..degrees)
                .map(|d| {
                    let from = zero.plus_scaled(&self.table.c, start(self.p, &momentum, d));
                    from.plus_product(&self.table.eta, by_q[d])
                })
                .collect::<Vec<_>>();
            let mut velocity = vec![zero; degrees];
            let spare = &mut vec![zero; degrees];
            <[Rounded; N]>::slopes::<F, false, true>(
                self.system,
                &at,
                &q,
                &moved,
                spare,
                &mut velocity,
                &mut scratch,
            );
            (0..degrees).all(|d| {
                let next = <[Rounded; N]>::splat(start(self.q, &coordinate, d)).plus(velocity[d]);
                holds(q[d], next)
            })
        } else {
            (0..degrees).all(|d| {
                let next = <[Rounded; N]>::splat(start(self.q, &coordinate, d));
                let moved = <[Rounded; N]>::splat(start(self.p, &momentum, d));
                holds(q[d], next.plus_product(&self.table.mu, by_p[d]))
                    && holds(p[d], moved.plus_product(&self.table.mu, by_q[d]))
            })
        }
    }
}

/// Replaces the stages of a degree of freedom, and says by how much they changed, in all, relative to the larger of their start
/// and the last of them. Where both are near zero that is too much, and rounding is found out in the other way.
#[inline(always)]
fn replace<S: Scalar, T: Stages<S, N>, const N: usize>(stage: &mut T, start: S, next: T) -> f64 {
    let change = next.minus(*stage).size();
    let size = next.get(N - 1).magnitude().max(start.magnitude());
    *stage = next;
    if change == 0.0 { 0.0 } else { change / size }
}

/// The larger of two; NaN if one is.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}
