//! What a correction of the fixed point changes of the numbers that the equations are evaluated at, against the rounding of
//! these numbers.
//!
//! After `x' = φ(x)` the equations leave the residual `x' - φ(x') = φ(x) - φ(x')`. The map `φ` reads its unknowns through
//! `Q_s = q_i + c_s u` and `P = p_i + v` only, of which running error analysis ([`Rounded`](crate::scalar::Rounded)) knows the
//! roundings `ε (|Q| + 2 |c u|)` and `ε (|P| + |v|)`, at least. Where the correction changes each by a quarter of that,
//!
//! ```text
//! |c Δu| ≤ ε (|Q| + 2 |c u|) / 4,   |Δv| ≤ ε (|P| + |v|) / 4,
//! ```
//!
//! it moves the numbers that `φ` is evaluated at, which are rounded, by no more than their rounding (by one unit in the last place, or
//! where `c u` is larger than `Q / 2` by `ε (5 |Q| / 4 + |c u| / 2)`), and the residual is below the rounding of its own terms by the same analysis, to
//! first order, without a pass that follows the rounding of every term. Each number is compared with its own rounding, so that no
//! unit and no other site counts.

use std::ops::Range;

use super::memory::Lists;
use super::passes::{Block, in_blocks, load};
use super::step::Step;
use super::{Elements, Stage, Unknowns};
use crate::scalar::Scalar;

/// The part of a rounding that a change may be. A fixed point contracts at least by [`CONTRACTS`](super::CONTRACTS), so that a
/// twentieth is left.
const UNSEEN: f64 = 0.25;

/// What a correction changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Change {
    /// No more than [`UNSEEN`] of a rounding.
    Unseen,
    /// More than that.
    Seen,
    /// To what is not finite.
    Unknown,
}

/// Counts the changes that are more than [`UNSEEN`] of a rounding, in lanes, so that none waits for the one before; NaN if any is not
/// finite.
#[derive(Clone, Copy)]
pub(super) struct Seen<const L: usize>([f64; L]);

impl<const L: usize> Seen<L> {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self([0.0; L])
    }

    /// Changes of numbers whose rounding is `ε rounded`.
    #[inline(always)]
    fn take<const N: usize>(&mut self, change: [f64; N], rounded: [f64; N]) {
        for i in 0..N.min(L) {
            let bound = UNSEEN * f64::EPSILON * rounded[i];
            self.0[i] += if change[i] <= bound { 0.0 } else { 1.0 + change[i] * 0.0 };
        }
    }

    #[inline(always)]
    pub(super) fn finish(self) -> Change {
        let seen = self.0.iter().sum::<f64>();
        match seen == 0.0 {
            true => Change::Unseen,
            false if seen.is_nan() => Change::Unknown,
            false => Change::Seen,
        }
    }
}

/// Unknowns that are looked at before it is asked whether one of them was changed.
const AT_ONCE: usize = 32;

impl<H: Elements, S: Scalar> Step<'_, H, S> {
    /// Whether the last correction of the fixed point changed no more than [`UNSEEN`] of a rounding, after [`Step::refresh`]; not known of
    /// numbers of several parts.
    #[inline(always)]
    pub(super) fn changes_nothing(&self, lists: &Lists<'_, S>) -> bool {
        let mut spans = (0..self.degrees()).step_by(AT_ONCE);
        size_of::<S>() == size_of::<f64>()
            && spans.all(|first| {
                let places = first..self.degrees().min(first + AT_ONCE);
                self.change::<4>(lists, places) == Change::Unseen
            })
    }

    /// What the last correction changed at some places.
    #[inline(always)]
    fn change<const L: usize>(&self, lists: &Lists<'_, S>, places: Range<usize>) -> Change {
        let mut seen = Seen::<L>::new();
        if self.scheme.unknowns == Unknowns::Both {
            self.change_of_both(lists, places, &mut seen);
            return seen.finish();
        }
        let Lists { x, correction, u, by_p: before, momentum, .. } = lists;
        for &Stage { point, .. } in self.scheme.stages.iter().filter(|stage| stage.point != 0.0) {
            let (q, u, before) = (&self.q[places.clone()], &u[places.clone()], &before[places.clone()]);
            in_blocks::<L>(places.len(), &mut Moved { q, u, before, point, seen: &mut seen });
        }
        if self.scheme.stages.iter().any(|stage| stage.point == 0.0) {
            // Elements at the node may read momenta.
            let (x, correction) = (&x[places.clone()], &correction[places.clone()]);
            let momentum = &momentum[places.clone()];
            in_blocks::<L>(places.len(), &mut Kicked { x, correction, momentum, seen: &mut seen });
        }
        seen.finish()
    }

    /// The same where both halves are unknown.
    #[inline(always)]
    fn change_of_both<const L: usize>(&self, lists: &Lists<'_, S>, places: Range<usize>, seen: &mut Seen<L>) {
        let Lists { x, correction, momentum, .. } = lists;
        let (x, correction) =
            (&x.as_chunks::<2>().0[places.clone()], &correction.as_chunks::<2>().0[places.clone()]);
        let state = self.q[places.clone()].iter().zip(&momentum[places]);
        for ((&[u, v], &[change_u, change_v]), (&q, momentum)) in x.iter().zip(correction).zip(state) {
            for &Stage { point, .. } in self.scheme.stages.iter().filter(|stage| stage.point != 0.0) {
                seen.take([(change_u * point).magnitude()], [moved(q, u, point)]);
            }
            seen.take([change_v.magnitude()], [momentum.magnitude() + v.magnitude()]);
        }
    }
}

/// `|q + c u| + 2 |c u|`
#[inline(always)]
fn moved<S: Scalar>(q: S, u: S, point: f64) -> f64 {
    let way = u * point;
    (q + way).magnitude() + 2.0 * way.magnitude()
}

/// Coordinates, and increments after and before.
pub(super) struct Moved<'a, S, const L: usize> {
    pub(super) q: &'a [S],
    pub(super) u: &'a [S],
    pub(super) before: &'a [S],
    pub(super) point: f64,
    pub(super) seen: &'a mut Seen<L>,
}

impl<S: Scalar, const L: usize> Block for Moved<'_, S, L> {
    #[inline(always)]
    fn take<const N: usize>(&mut self, first: usize) {
        let (q, u) = (load::<_, N>(self.q, first), load::<_, N>(self.u, first));
        let before = load::<_, N>(self.before, first);
        let (mut change, mut rounded) = ([0.0; N], [0.0; N]);
        for i in 0..N {
            change[i] = ((u[i] - before[i]) * self.point).magnitude();
            rounded[i] = moved(q[i], u[i], self.point);
        }
        self.seen.take(change, rounded);
    }
}

/// Unknowns, their corrections, and momenta.
struct Kicked<'a, S, const L: usize> {
    x: &'a [S],
    correction: &'a [S],
    momentum: &'a [S],
    seen: &'a mut Seen<L>,
}

impl<S: Scalar, const L: usize> Block for Kicked<'_, S, L> {
    #[inline(always)]
    fn take<const N: usize>(&mut self, first: usize) {
        let (x, momentum) = (load::<_, N>(self.x, first), load::<_, N>(self.momentum, first));
        let correction = load::<_, N>(self.correction, first);
        let (mut change, mut rounded) = ([0.0; N], [0.0; N]);
        for i in 0..N {
            change[i] = correction[i].magnitude();
            rounded[i] = momentum[i].magnitude() + x[i].magnitude();
        }
        self.seen.take(change, rounded);
    }
}
