//! The change that a fixed-point correction makes to the points at which the equations are evaluated,
//! compared with the rounding of these points.
//!
//! After `x' = φ(x)` the residual is `x' - φ(x') = φ(x) - φ(x')`. The map `φ` depends on its unknowns only
//! through `Q_s = q_i + c_s u` and `P = p_i + v`. Running error analysis
//! ([`Rounded`](crate::algebra::scalar::Rounded)) gives these roundings of at least `ε (|Q| + 2 |c u|)` and
//! `ε (|P| + |v|)`. If the correction changes each by at most a quarter of that,
//!
//! ```text
//! |c Δu| ≤ ε (|Q| + 2 |c u|) / 4,   |Δv| ≤ ε (|P| + |v|) / 4,
//! ```
//!
//! it moves the rounded arguments of `φ` by no more than their rounding (by one unit in the last place, or by
//! `ε (5 |Q| / 4 + |c u| / 2)` if `c u` is larger than `Q / 2`). To first order the residual is then below
//! the rounding of its own terms by the same analysis, and no pass has to follow the rounding of every term.
//! Each number is compared with its own rounding, so that the result does not depend on units or on other
//! sites.

use std::ops::Range;

use super::memory::StepLists;
use super::passes::{LoopBody, load, poisoned, widened};
use super::step::LoopStep;
use super::{Elements, QuadraturePoint, Unknowns};
use crate::algebra::scalar::{Mask, Scalar};
use crate::algebra::solve::{ROUNDING, UNSEEN};

/// The size of a change, in ascending order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Change {
    /// No more than [`UNSEEN`] of a rounding.
    Unseen,
    /// More than that.
    Seen,
    /// A change to a number that is not finite.
    Unknown,
}

/// The largest excess of the changes over [`UNSEEN`] of a rounding, in independent lanes. A maximum is one
/// instruction, where a choice by comparison may take several for each lane.
#[derive(Clone, Copy)]
pub(super) struct LargestChange<const L: usize> {
    above: [f64; L],
    poison: [u64; L],
}

impl<const L: usize> LargestChange<L> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn new() -> Self {
        Self { above: [0.0; L], poison: [0; L] }
    }

    /// Changes of numbers whose rounding is `ε rounded`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn include<const N: usize>(&mut self, change: [f64; N], rounded: [f64; N]) {
        let mut excess = change;
        for i in 0..N {
            excess[i] = beyond(change[i], rounded[i]);
        }
        let (excess, change): ([f64; L], [f64; L]) = (widened(excess), widened(change));
        let Self { mut above, mut poison } = *self;
        for i in 0..L {
            above[i] = if excess[i] > above[i] { excess[i] } else { above[i] };
        }
        for i in 0..L {
            poison[i] |= poisoned(change[i]);
        }
        *self = Self { above, poison };
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn finish(self) -> Change {
        let Self { above, poison } = self;
        match above.iter().all(|&above| above == 0.0) {
            _ if poison.iter().any(|&poison| poison != 0) => Change::Unknown,
            true => Change::Unseen,
            false => Change::Seen,
        }
    }
}

impl<H: Elements, S: Scalar> LoopStep<'_, H, S> {
    /// Whether the last fixed-point correction changed no more than [`UNSEEN`] of a rounding, after
    /// [`LoopStep::refresh`]: of each path side by side.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn changes_nothing(&self, lists: &StepLists<'_, S>) -> S::Mask {
        // The first one mostly decides.
        let first = self.changes_nothing_at(lists, 0..1);
        if first.any() { first & self.changes_nothing_at(lists, 1..self.degrees()) } else { first }
    }

    /// Whether each next correction is below the rounding of its unknown plus the state that it changes, if
    /// it is smaller than this one by the factor `ratio` or by that of its own unknown, whichever is larger.
    /// Sizes of numbers are those by `size`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn resolves<R: Scalar>(
        self,
        lists: &StepLists<'_, S>,
        ratio: R,
        size: impl Fn(S) -> R + Copy,
    ) -> R::Mask {
        let StepLists { x, correction, previous, .. } = lists;
        let mut all = R::Mask::from_bool(true);
        // Two loops, since one with a choice in it is not vectorised.
        if self.scheme.unknowns == Unknowns::Both {
            let [x, correction, previous] = [&**x, &**correction, &**previous].map(|list| list.as_chunks().0);
            let corrected = x.iter().zip(correction).zip(previous).zip(self.q.iter().zip(self.p));
            for (((&[x_u, x_v], &[u, v]), &[before_u, before_v]), (&q, &p)) in corrected {
                all = all & is_small([q, x_u, u, before_u], ratio, size);
                all = all & is_small([p, x_v, v, before_v], ratio, size);
            }
        } else {
            for (((&x, &v), &before), &p) in x.iter().zip(&**correction).zip(&**previous).zip(self.p) {
                all = all & is_small([p, x, v, before], ratio, size);
            }
        }
        all
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn changes_nothing_at(&self, lists: &StepLists<'_, S>, places: Range<usize>) -> S::Mask {
        let StepLists { x, correction, u, by_p: before, momentum, .. } = lists;
        let (q, momentum) = (&self.q[places.clone()], &momentum[places.clone()]);
        let mut all = S::Mask::from_bool(true);
        if self.scheme.unknowns == Unknowns::Both {
            let (x, corrections) = (x.as_chunks().0, correction.as_chunks().0);
            let unknowns = x[places.clone()].iter().zip(&corrections[places]);
            for ((&[u, v], &[change_u, change_v]), (&q, momentum)) in unknowns.zip(q.iter().zip(momentum)) {
                for &QuadraturePoint { point, .. } in
                    self.scheme.stages.iter().filter(|stage| stage.point != 0.0)
                {
                    all = all & unseen(change_u * point, moved(q, u, point, S::abs));
                }
                all = all & unseen(change_v, momentum.abs() + v.abs());
            }
            return all;
        }
        for &QuadraturePoint { point, .. } in self.scheme.stages.iter().filter(|stage| stage.point != 0.0) {
            for ((&q, &u), &before) in q.iter().zip(&u[places.clone()]).zip(&before[places.clone()]) {
                all = all & unseen((u - before) * point, moved(q, u, point, S::abs));
            }
        }
        if self.scheme.stages.iter().any(|stage| stage.point == 0.0) {
            // Elements at the node may depend on momenta.
            let changes = x[places.clone()].iter().zip(&correction[places]);
            for ((x, &change), momentum) in changes.zip(momentum) {
                all = all & unseen(change, momentum.abs() + x.abs());
            }
        }
        all
    }
}

/// [`LoopStep::resolves`] of one unknown: from the state, the unknown, its correction and the one before.
#[cfg_attr(not(debug_assertions), inline(always))]
fn is_small<S: Scalar, R: Scalar>(
    [state, x, correction, previous]: [S; 4],
    ratio: R,
    size: impl Fn(S) -> R,
) -> R::Mask {
    let (change, one) = (size(correction), R::from_f64(1.0));
    let own = change / size(previous);
    let factor = R::select(ratio.less(own), own, ratio);
    let factor = R::select(factor.less(one), factor, one);
    !R::from_f64(0.0).less(change * factor - (size(x) + size(state)) * ROUNDING)
}

/// Whether a change of numbers whose rounding is `ε rounded` is finite and negligible.
#[cfg_attr(not(debug_assertions), inline(always))]
fn unseen<S: Scalar>(change: S, rounded: S) -> S::Mask {
    !S::from_f64(0.0).less(beyond(change.abs(), rounded)) & change.is_finite()
}

/// A change above [`UNSEEN`] of the rounding `ε rounded`: rounding does not change the sign of a difference.
#[cfg_attr(not(debug_assertions), inline(always))]
fn beyond<R: Scalar>(change: R, rounded: R) -> R {
    change - rounded * (UNSEEN * ROUNDING)
}

/// `|q + c u| + 2 |c u|`, with the sizes of numbers by `size`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn moved<S: Scalar, R: Scalar>(q: S, u: S, point: f64, size: impl Fn(S) -> R) -> R {
    let way = u * point;
    size(q + way) + size(way) * 2.0
}

/// Coordinates, and increments after and before the correction.
pub(super) struct ComparedCoordinates<'a, S, const L: usize> {
    pub(super) q: &'a [S],
    pub(super) u: &'a [S],
    pub(super) before: &'a [S],
    pub(super) point: f64,
    pub(super) seen: &'a mut LargestChange<L>,
}

impl<S: Scalar, const L: usize> LoopBody for ComparedCoordinates<'_, S, L> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn apply<const N: usize>(&mut self, first: usize) {
        let (q, u) = (load::<_, N>(self.q, first), load::<_, N>(self.u, first));
        let before = load::<_, N>(self.before, first);
        let (mut change, mut rounded) = ([0.0; N], [0.0; N]);
        for i in 0..N {
            change[i] = ((u[i] - before[i]) * self.point).magnitude();
        }
        for i in 0..N {
            rounded[i] = moved(q[i], u[i], self.point, S::magnitude);
        }
        self.seen.include(change, rounded);
    }
}

#[cfg(test)]
mod tests {
    use crate::scheme::plan::Facts;
    use nalgebra::DVector;

    use super::super::memory::LoopMemory;
    use super::super::{
        ElementInput, EvaluationPoint, HessianBlock, Linearity, MomentumUpdate, Partials, Quadrature, Role,
        Sums,
    };
    use super::*;
    use crate::algebra::scalar::Number;
    use crate::scheme::compose::General;
    use crate::scheme::gauss::Dynamic;

    /// `Σ p_i² / 2 m_i + Σ k_i (d_i²/2 + d_i⁴/4)`, `d_i = q_i - q_{i-1}`
    struct Chain {
        mass: Vec<f64>,
        spring: Vec<f64>,
    }

    impl Elements for Chain {
        const FACTS: Facts = Facts { has_one_velocity: true, ..Facts::autonomous(usize::MAX) };
        type Shape = Dynamic;
        type Structure = General;
        type Vector = DVector<f64>;
        type CommonRange = f64;
        fn degrees(&self) -> usize {
            self.mass.len()
        }
        fn value<S: Scalar>(&self, _: Role, _: f64, _: &EvaluationPoint<'_, S>) -> S {
            S::from_f64(f64::NAN)
        }
        fn gradient<S: Scalar, T: Number<S>>(
            &self,
            _: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S, impl ElementInput<S> + ?Sized>,
            wanted: Partials,
            by_q: &mut (impl Sums<S> + ?Sized),
            by_p: &mut (impl Sums<S> + ?Sized),
        ) {
            let scale = T::of_constant(at.h * weight);
            for i in 0..if wanted.by_p { self.mass.len() } else { 0 } {
                by_p.add(i, T::of(at.p[i]) * (scale / self.mass[i]));
            }
            for i in 1..if wanted.by_q { self.mass.len() } else { 0 } {
                let d = T::of(at.q[i]) - T::of(at.q[i - 1]);
                let pull = (d + d * d * d) * (scale * self.spring[i]);
                by_q.add(i, pull);
                by_q.add(i - 1, -pull);
            }
        }
        fn hessian<S: Scalar>(
            &self,
            _: Role,
            _: f64,
            _: &EvaluationPoint<'_, S>,
            _: Partials,
            into: &mut impl FnMut(HessianBlock, [usize; 2], bool, S),
        ) {
            for i in 1..self.mass.len() {
                into(HessianBlock::QQ, [i, i - 1], false, S::from_f64(f64::NAN));
            }
        }
    }

    const STAGE: QuadraturePoint =
        QuadraturePoint { point: 0.5, start: 0.5, end: 0.5, roles: &[Role::Drift.times(1.0)] };
    const MIDPOINT: Quadrature = Quadrature {
        stages: &[STAGE],
        update: MomentumUpdate::Multiple(2.0),
        unknowns: Unknowns::Momenta,
        remembers: true,
        linearity: Linearity::Nonlinear,
    };

    fn random(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    #[test]
    fn a_quarter_of_a_rounding_is_not_seen_and_what_is_not_finite_is_not_known() {
        let after = |changes: [f64; 3]| {
            let mut seen = LargestChange::<4>::new();
            changes.into_iter().for_each(|change| seen.include([change], [1.0]));
            seen.finish()
        };
        let bound = UNSEEN * ROUNDING;
        assert_eq!(after([0.0, bound, 0.0]), Change::Unseen);
        assert_eq!(after([0.0, bound * (1.0 + f64::EPSILON), bound]), Change::Seen);
        for change in [f64::INFINITY, f64::NAN] {
            assert_eq!(after([change, 0.0, 0.0]), Change::Unknown);
            assert_eq!(after([1.0, change, 0.0]), Change::Unknown);
        }
    }

    /// Chains with random masses, springs and states, each site with its own scale. The fixed point iterates
    /// until the change is negligible by this bound. Running error analysis, which follows the rounding of
    /// every term, then finds each equation at rounding.
    #[test]
    fn equations_are_at_their_rounding_where_nothing_changes() {
        let mut seed = 5;
        for unknowns in [Unknowns::Momenta, Unknowns::Both] {
            let scheme = &Quadrature { unknowns, ..MIDPOINT };
            for n in (2..40).chain([95, 96, 97, 200]) {
                let mut list = |from: f64, spread: f64| -> Vec<f64> {
                    (0..n).map(|_| from + spread * random(&mut seed)).collect()
                };
                let system = Chain { mass: list(1.0, 1.0), spring: list(1.0, 1.0) };
                let size: Vec<f64> =
                    list(-3.0, 6.0).into_iter().map(|exponent| 10.0_f64.powf(exponent)).collect();
                let scaled =
                    |list: Vec<f64>| list.iter().zip(&size).map(|(x, size)| x * size).collect::<Vec<_>>();
                let (q, p) = (scaled(list(0.0, 1.0)), scaled(list(0.0, 2.0)));
                // Forces grow with the cube of the largest stretch, which is a thousand at most.
                let h = 1e-4;
                let step = LoopStep {
                    system: &system,
                    scheme,
                    t: 0.0,
                    h,
                    parameters: &[],
                    q: &q,
                    p: &p,
                    dw: &[],
                    increment: None,
                };
                let mut memory = LoopMemory::new(&system, scheme);
                let mut scratch = memory.scratch(scheme, n);
                step.start(&mut scratch, 0);
                let mut sweeps = 0;
                loop {
                    step.sweep(&mut scratch, false);
                    sweeps += 1;
                    if step.changes_nothing(&scratch.lists) {
                        break;
                    }
                    assert!(sweeps < 50, "{n} sites");
                }
                assert!(sweeps > 1);
                let x = scratch.lists.x.to_vec();
                for (k, residual) in step.round(&x, &mut scratch.solver.rounding).iter().enumerate() {
                    assert!(residual.is_below(1.0), "unknown {k} of {n} sites: {residual:?}");
                }
            }
        }
    }
}
