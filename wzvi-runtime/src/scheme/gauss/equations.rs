//! The equations of a step, `Y = φ(Y)`, and the state that follows from their solution.

use super::Field;
use super::advance::{FrictionScaling, SharedConstants};
use super::memory::{GaussInput, OfStages, StageLists, SweepScratchOf};
use super::stages::{PackedStages, StagePack, Stages};
use super::sweep::RelativeChange;
use crate::algebra::scalar::{ComputesWith, Constant, ConstantsIn, Scalar};
use crate::algebra::shape::Shape;
use crate::algebra::state_sum::StateSum;
use crate::scheme::elements::PairColumns;

/// The equations of a step.
pub(super) struct StepEquations<'a, F: Field, K: Constant, S: Scalar, const N: usize> {
    pub(super) system: &'a F,
    pub(super) parameters: &'a ConstantsIn<F::Parameters, K>,
    pub(super) friction: &'a FrictionScaling<N, K>,
    pub(super) common: &'a SharedConstants<N>,
    pub(super) t: K,
    pub(super) h: K,
    /// `b_i ΔW_k`
    pub(super) dw: &'a [S::Stages<N>],
    /// `q` and `p` with their compensation.
    pub(super) start: [&'a [S]; 2],
}

impl<S: Scalar, H: Shape, W: Shape, const N: usize> GaussInput<S, H, W, N> {
    /// Reads the data of a step.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn read<C: StateSum<S>>(
        &mut self,
        common: &SharedConstants<N>,
        q: &[S],
        p: &[S],
        dw: &[S],
        carry: &C,
    ) {
        let Self { start: [start_q, start_p], dw: weighted } = self;
        for (d, (start, q)) in start_q.as_mut().iter_mut().zip(q).enumerate() {
            *start = *q + carry.of_coordinate(d);
        }
        for (d, (start, p)) in start_p.as_mut().iter_mut().zip(p).enumerate() {
            *start = *p + carry.of_momentum(d);
        }
        for (weighted, dw) in weighted.as_mut().iter_mut().zip(dw) {
            *weighted = S::Stages::splat(*dw).times(&common.table().b);
        }
    }

    /// Its equations.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn step<'a, F: Field, K: Constant>(
        &'a self,
        system: &'a F,
        (parameters, friction, common): (
            &'a ConstantsIn<F::Parameters, K>,
            &'a FrictionScaling<N, K>,
            &'a SharedConstants<N>,
        ),
        [t, h]: [K; 2],
    ) -> StepEquations<'a, F, K, S, N> {
        let start = [self.start[0].as_ref(), self.start[1].as_ref()];
        StepEquations { system, parameters, friction, common, t, h, dw: self.dw.as_ref(), start }
    }
}

/// The stages to compute, and the derivatives that determine them.
pub(super) struct Placement<'a, T> {
    /// `q` and `p` of the stages.
    pub(super) at: [&'a mut [T]; 2],
    /// `b_i ∂F/∂p`; in Nyström form `∂F/∂p` of the stages that are placed, where they are one part.
    pub(super) by_p: &'a mut [T],
    /// `b_i ∂F/∂q`; `None` for stages with the momentum at the start.
    pub(super) by_q: Option<&'a [T]>,
}

impl<F: Field, K: Constant, S: ComputesWith<K>, const N: usize> StepEquations<'_, F, K, S, N> {
    /// A part times a constant for each stage. Where constants are not `f64`, a part is one stage.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn weighted(numbers: StagePack<S, N>, weights: &[K; N], part: usize) -> StagePack<S, N> {
        match K::as_f64s(weights).and_then(<[f64]>::first_chunk) {
            Some(weights) => S::Stages::weighted(numbers, weights, part),
            None => numbers * S::Stages::<N>::same(S::constant(weights[part])),
        }
    }

    /// `t + c_i h` for the stages of a part.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn times(&self, part: usize) -> StagePack<S, N> {
        let (t, h) = (S::constant(self.t), S::constant(self.h));
        let (t, h) = (S::Stages::<N>::same(t), S::Stages::<N>::same(h));
        S::Stages::weighted(h, &self.common.table().c, part) + t
    }

    /// `h b_i` for the stages of a part.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn weights(&self, part: usize) -> StagePack<S, N> {
        let h = S::Stages::<N>::same(S::constant(self.h));
        S::Stages::weighted(h, &self.common.table().b, part)
    }

    /// Computes stages from derivatives at the same or other stages, by the columns of `once` (integrals of
    /// the derivatives) or, in Nyström form, `twice` (double integrals). `seen` sees each replacement.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn place(
        &self,
        into: Placement<'_, S::Stages<N>>,
        [once, twice]: [&[[f64; N]; N]; 2],
        room: &mut SweepScratchOf<F, S, N>,
        mut seen: Option<&mut RelativeChange<'_, S, N>>,
    ) {
        if F::IS_NYSTROM {
            self.place_coordinates(into, twice, room, seen);
            return;
        }
        let Placement { at: [q, p], by_p, by_q } = into;
        for part in 0..S::Stages::<N>::PARTS {
            for d in 0..q.len() {
                let [start_q, start_p] = self.start;
                let (start_q, start_p) = (S::Stages::<N>::same(start_q[d]), S::Stages::<N>::same(start_p[d]));
                let [next_q, next_p] = match by_q {
                    Some(by_q) => {
                        [start_q + by_p[d].product(once, part), start_p - by_q[d].product(once, part)]
                    }
                    None => [start_q, start_p],
                };
                if let Some(seen) = &mut seen {
                    seen.include(0, d, q[d].part(part), next_q);
                    seen.include(1, d, p[d].part(part), next_p);
                }
                q[d].set_part(part, next_q);
                p[d].set_part(part, next_p);
            }
        }
    }

    /// Places the coordinates in Nyström form, where `∂F/∂p` does not read the coordinates and `∂F/∂q` does
    /// not read the momenta.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn place_coordinates(
        &self,
        into: Placement<'_, S::Stages<N>>,
        twice: &[[f64; N]; N],
        room: &mut SweepScratchOf<F, S, N>,
        mut seen: Option<&mut RelativeChange<'_, S, N>>,
    ) {
        let Placement { at: [q, p], by_p, by_q } = into;
        let mut rooms = F::Shape::lend(&mut room.parts, PackedStages::of_length(0, 0));
        let h = S::Stages::<N>::same(S::constant(self.h));
        for part in 0..S::Stages::<N>::PARTS {
            let momenta = S::Stages::parts_mut(p, rooms.p.as_mut());
            for (d, momentum) in momenta.iter_mut().enumerate() {
                let start = S::Stages::<N>::same(self.start[1][d]);
                let unforced = S::Stages::weighted(start, &self.common.table().c, part);
                *momentum = match by_q {
                    Some(by_q) => unforced - by_q[d].product(twice, part),
                    None => unforced,
                };
            }
            let dw = S::Stages::parts(self.dw, part, rooms.dw.as_mut());
            let velocities = S::Stages::parts_mut(by_p, rooms.by_p.as_mut());
            let (t, one) = (self.times(part), &mut room.one);
            self.gradient::<false, true>(([t, h], [momenta, momenta], dw), [&mut [], velocities], one);
            for (d, (stages, velocity)) in q.iter_mut().zip(&*velocities).enumerate() {
                let next = S::Stages::<N>::same(self.start[0][d]) + *velocity;
                if let Some(seen) = &mut seen {
                    seen.include(0, d, stages.part(part), next);
                }
                stages.set_part(part, next);
            }
        }
        F::Shape::give_back(&mut room.parts, rooms);
    }

    /// The starting stages: extrapolated from the derivatives of the last step, or those of the state.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn guess(
        &self,
        lists: &mut StageLists<S, F::Shape, N>,
        past: &mut [OfStages<S, F::Shape, N>; 2],
        room: &mut SweepScratchOf<F, S, N>,
        from_past: bool,
    ) {
        let StageLists { at: [q, p], slopes: [velocity, _], .. } = lists;
        let [by_p, by_q] = past;
        let by_p = if F::IS_NYSTROM { velocity } else { by_p };
        let into = Placement {
            at: [q.as_mut(), p.as_mut()],
            by_p: by_p.as_mut(),
            by_q: if from_past { Some(by_q.as_ref()) } else { None },
        };
        self.place(into, [&self.common.table().nu, &self.common.table().kappa], room, None);
    }

    /// `b_i ∂F/∂p` and `b_i ∂F/∂q` at the stages, except for paths that keep their derivatives.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn field(
        &self,
        lists: &mut StageLists<S, F::Shape, N>,
        room: &mut SweepScratchOf<F, S, N>,
        stay: S::Mask,
    ) {
        let StageLists { at: [q, p], slopes: [by_p, by_q], spare, .. } = lists;
        let (q, p, by_p, by_q) = (q.as_ref(), p.as_ref(), by_p.as_mut(), by_q.as_mut());
        let mut rooms = F::Shape::lend(&mut room.parts, PackedStages::of_length(0, 0));
        for part in 0..S::Stages::<N>::PARTS {
            let (t, h) = (self.times(part), self.weights(part));
            let q = S::Stages::parts(q, part, rooms.q.as_mut());
            let dw = S::Stages::parts(self.dw, part, rooms.dw.as_mut());
            let forces = S::Stages::parts_mut(by_q, rooms.by_q.as_mut());
            if F::IS_NYSTROM {
                let one = &mut room.one;
                self.gradient::<true, false>(([t, h], [q, q], dw), [forces, &mut []], one);
            } else {
                let velocities = S::Stages::parts_mut(by_p, rooms.by_p.as_mut());
                let one = &mut room.one;
                if F::FACTS.kind.is_conformal {
                    let own = S::Stages::parts_mut(spare.as_mut(), rooms.p.as_mut());
                    for (own, p) in own.iter_mut().zip(p) {
                        *own = Self::weighted(p.part(part), &self.friction.inverse, part);
                    }
                    self.gradient::<true, true>(([t, h], [q, own], dw), [forces, velocities], one);
                    for force in &mut *forces {
                        *force = Self::weighted(*force, &self.friction.scale, part);
                    }
                } else {
                    let p = S::Stages::parts(p, part, rooms.p.as_mut());
                    self.gradient::<true, true>(([t, h], [q, p], dw), [forces, velocities], one);
                }
                S::Stages::store(by_p, part, rooms.by_p.as_ref(), stay);
            }
            S::Stages::store(by_q, part, rooms.by_q.as_ref(), stay);
        }
        F::Shape::give_back(&mut room.parts, rooms);
    }

    /// Computes the new state from the derivatives at the stages; returns the paths for which it is finite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn finish<C: StateSum<S>>(
        &self,
        [q, p]: [&[S]; 2],
        dw: &[S],
        lists: &mut StageLists<S, F::Shape, N>,
        carry: &C,
    ) -> S::Mask {
        let StageLists { slopes: [by_p, by_q], next: [next_q, next_p], lost: [lost_q, lost_p], .. } = lists;
        let (by_p, by_q) = (by_p.as_ref(), by_q.as_ref());
        let (next_q, next_p) = (next_q.as_mut(), next_p.as_mut());
        let (lost_q, lost_p) = (lost_q.as_mut(), lost_p.as_mut());
        if F::IS_NYSTROM {
            let mut rest = [0.0; N];
            for (rest, c) in rest.iter_mut().zip(&self.common.table().c) {
                *rest = 1.0 - c;
            }
            for (d, momentum) in next_p.iter_mut().enumerate() {
                *momentum = self.start[1][d] - by_q[d].times(&rest).total();
            }
            let (t, h, system) = (S::constant(self.t), S::constant(self.h), self.system);
            let parameters = self.parameters;
            // No pairs add to the velocities.
            let columns = &mut PairColumns::default();
            let (at, into) = (([t, h], [q, &*next_p], dw), [&mut *lost_q, &mut *next_q]);
            system.step_gradient::<K, S, false, true>(parameters, at, into, columns);
        } else {
            for (increment, slopes) in next_q.iter_mut().zip(by_p) {
                *increment = slopes.total();
            }
        }
        let zero = S::from_f64(0.0);
        let mut zeros = zero;
        for d in 0..q.len() {
            (next_q[d], lost_q[d]) = C::add(q[d], next_q[d], carry.of_coordinate(d));
            let mut change = zero - by_q[d].total();
            if F::FACTS.kind.is_conformal {
                change = change + (self.start[1][d] + change) * self.friction.decay;
            }
            (next_p[d], lost_p[d]) = C::add(p[d], change, carry.of_momentum(d));
            zeros = zeros + next_q[d] * 0.0 + next_p[d] * 0.0;
        }
        zeros.is_finite()
    }
}
