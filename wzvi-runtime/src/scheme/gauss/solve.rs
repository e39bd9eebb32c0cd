//! Solution of the equations of a step: for one path, and for paths in lanes.
//!
//! Paths in lanes are swept together until each has ended by its own criterion, and a path keeps the result
//! of its own last sweep. A path whose sweeps do not contract is solved alone, as by a
//! [`Stepper`](crate::trajectory::step::Stepper). So the bits of a path do not depend on its neighbours.

use super::Field;
use super::advance::advance;
use super::choice::NewtonBackoff;
use super::equations::StepEquations;
use super::memory::{GaussHistoryOf, GaussMemory, KnownDerivatives, OfStages, StageLists};
use super::stages::Stages;
use super::sweep::{StepOutcome, SweepOutcome};
use crate::algebra::memory::Iteration;
use crate::algebra::scalar::{ComputesWith, Constant, Mask, Parameters, Scalar};
use crate::algebra::shape::Shape;
use crate::algebra::solve::{Doubt, Effort};
use crate::algebra::state_sum::{PlainSum, StateSum};
use crate::error::StepFailure;
use crate::ground::numbers::numbers;
use crate::scheme::system::StepArguments;

/// Parts in which a solution that is followed is reached: where these take fewer sweeps than Newton's method,
/// they check a solution.
const PARTS: f64 = 64.0;

/// One path of several, with the memory of its past steps.
#[derive(Debug, Default)]
pub(super) struct ScalarPath<H: Shape, W: Shape, const N: usize> {
    memory: GaussMemory<f64, H, W, N>,
    q: Vec<f64>,
    p: Vec<f64>,
    dw: Vec<f64>,
}

impl<H: Shape, W: Shape, const N: usize> ScalarPath<H, W, N> {
    /// Reads the start of one path, and its increments.
    fn read<S: Scalar>(&mut self, lane: usize, [q, p]: [&[S]; 2], dw: &[S]) {
        for (own, all) in [(&mut self.q, q), (&mut self.p, p), (&mut self.dw, dw)] {
            own.clear();
            own.extend(all.iter().map(|number| number.lane(lane)));
        }
        self.memory.fit(q.len(), dw.len());
    }

    /// Takes over the derivatives of a step of this path, and how the next one starts.
    pub(super) fn read_slopes(&mut self, slopes: &[OfStages<f64, H, N>; 2], waits: NewtonBackoff<f64>) {
        self.memory.fit(slopes[0].as_ref().len(), self.dw.len());
        self.memory.left.past.clone_from(slopes);
        (self.memory.left.is_known, self.memory.left.waits) = (true, waits);
    }

    /// Whether its sweeps were given up in favour of Newton's method.
    pub(super) fn prefers_newton(&self) -> bool {
        self.memory.left.waits.prefer_newton()
    }
}

numbers! {
    impl[H: Shape, W: Shape, const N: usize] Numbers for ScalarPath<H, W, N> { kept: memory; scratch: q, p, dw }
}

impl<F: Field, K: Constant, S: ComputesWith<K>, const N: usize> StepEquations<'_, F, K, S, N> {
    /// Solves for the stages, and for the new state.
    ///
    /// # Errors
    /// [`StepFailure::NonFinite`], and those of Newton's method.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn solve_stages<C: StateSum<S>, const CAREFUL: bool>(
        &self,
        state: [&[S]; 2],
        dw: &[S],
        lists: &mut StageLists<S, F::Shape, N>,
        left: &mut GaussHistoryOf<F, S, N>,
        carry: &C,
    ) -> Result<StepOutcome<S>, StepFailure> {
        let solved = if const { S::IS_PLAIN_DUAL } && self.factors_once(left) {
            self.differentiate::<CAREFUL>(state, dw, lists, left)?
        } else {
            self.solve::<CAREFUL>(lists, left)?
        };
        if !self.finish(state, dw, lists, carry).all() {
            return Err(StepFailure::NonFinite);
        }
        self.change_momentum(lists);
        Ok(solved)
    }

    /// Solves for the stages.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn solve<const CAREFUL: bool>(
        &self,
        lists: &mut StageLists<S, F::Shape, N>,
        left: &mut GaussHistoryOf<F, S, N>,
    ) -> Result<StepOutcome<S>, StepFailure> {
        self.begin::<CAREFUL>(lists, left);
        let mut given_up = None;
        if !self.prefers_newton(left).any() {
            let swept = self.sweeps::<CAREFUL>(S::Mask::from_bool(true), lists, left);
            // With care, sweeps that do not contract from the start are checked by Newton's method, or by
            // following the solution in parts.
            let is_wild = CAREFUL && swept.are_wild.any();
            let is_followed = || self.newton_in_sweeps() > f64::from(swept.sweeps) * PARTS;
            let is_settled = swept.are_settled.all();
            if is_settled && (!is_wild || is_followed()) {
                let doubt = if is_wild { Doubt::Straying } else { Doubt::None };
                let effort = Effort { doubt, is_far: is_wild, ..Effort::fast(swept.sweeps) };
                return Ok(StepOutcome { effort, waits: NewtonBackoff::none() });
            }
            if !is_settled && swept.failure == StepFailure::NonFinite
                || left.iteration == Iteration::FixedPoint
            {
                return Err(swept.failure);
            }
            given_up = (!is_settled).then_some(swept.sweeps);
            self.begin::<CAREFUL>(lists, left);
        }
        let solved = self.newton::<CAREFUL>(lists, left)?;
        Ok(match given_up {
            Some(sweeps) => {
                StepOutcome { waits: left.waits.after_giving_up(sweeps, self.newton_in_sweeps()), ..solved }
            }
            None => solved,
        })
    }

    /// The starting stages: from the derivatives of a part of the same step, by extrapolation of the last
    /// step (without noise only), or those of the state.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn begin<const CAREFUL: bool>(
        &self,
        lists: &mut StageLists<S, F::Shape, N>,
        left: &mut GaussHistoryOf<F, S, N>,
    ) {
        if CAREFUL && left.is_held {
            lists.slopes.clone_from(&left.past);
            if F::FACTS.kind.is_conformal {
                // They are stored in the momentum of the next step.
                let back = [(1.0 + self.friction.decay.lane(0)).recip(); N];
                lists.slopes[1].as_mut().iter_mut().for_each(|slopes| *slopes = slopes.times(&back));
            }
            return self.follow(lists, &mut left.scratch, None);
        }
        let from_past = self.dw.is_empty() && left.is_known && !CAREFUL;
        self.guess(lists, &mut left.past, &mut left.scratch, from_past);
    }

    /// The paths for which Newton's method is tried first.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn prefers_newton(&self, left: &GaussHistoryOf<F, S, N>) -> S::Mask {
        match left.iteration {
            Iteration::Automatic => left.waits.prefer_newton(),
            Iteration::Newton => S::Mask::from_bool(true),
            Iteration::FixedPoint => S::Mask::from_bool(false),
        }
    }

    /// With friction, converts the derivatives to the momentum of the next step.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn change_momentum(&self, lists: &mut StageLists<S, F::Shape, N>) {
        if F::FACTS.kind.is_conformal {
            let left = [1.0 + self.friction.decay.lane(0); N];
            lists.slopes[1].as_mut().iter_mut().for_each(|slopes| *slopes = slopes.times(&left));
        }
    }

    /// Solves for the stages and the new states of paths in lanes.
    ///
    /// # Errors
    /// The error of a path that is solved alone.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn solve_lanes(
        &self,
        state: [&[S]; 2],
        dw: &[S],
        lists: &mut StageLists<S, F::Shape, N>,
        left: &mut GaussHistoryOf<F, S, N>,
    ) -> Result<StepOutcome<S>, StepFailure> {
        let none = S::Mask::from_bool(false);
        // A single path is faster with its stages in lanes.
        let together = if S::LANES > 1 { !self.prefers_newton(left) } else { none };
        let mut solved = StepOutcome { effort: Effort::fast(0), waits: NewtonBackoff::none() };
        let mut are_solved = none;
        if together.any() {
            let from_past = self.dw.is_empty() && left.is_known;
            self.guess(lists, &mut left.past, &mut left.scratch, from_past);
            let SweepOutcome { are_settled, sweeps, .. } = self.sweeps::<false>(together, lists, left);
            are_solved = are_settled & self.finish(state, dw, lists, &PlainSum);
            self.change_momentum(lists);
            solved.effort = Effort::fast(sweeps);
        }
        if !are_solved.all() {
            for lane in (0..S::LANES).filter(|&lane| !are_solved.lane(lane)) {
                let alone = self.solve_scalar_path(lane, state, dw, lists, left)?;
                solved.effort = solved.effort + alone.effort;
                solved.waits = solved.waits.with(S::Mask::of_lanes(|other| other == lane), alone.waits);
            }
        }
        Ok(solved)
    }

    /// Solves for the stages of one path, and for the derivatives that its numbers carry: first for the
    /// values alone, then by one factorisation.
    ///
    /// # Errors
    /// The errors of the step, and of [`StepEquations::differentiate_stages`].
    #[inline(never)]
    fn differentiate<const CAREFUL: bool>(
        &self,
        [q, p]: [&[S]; 2],
        dw: &[S],
        lists: &mut StageLists<S, F::Shape, N>,
        left: &mut GaussHistoryOf<F, S, N>,
    ) -> Result<StepOutcome<S>, StepFailure> {
        let mut room = left.scalar_path.take().unwrap_or_default();
        let known = std::mem::replace(&mut left.known, KnownDerivatives::Nothing);
        let solved = match known {
            KnownDerivatives::Nothing => self.take_values::<CAREFUL>([q, p], dw, left, &mut room),
            KnownDerivatives::Slopes | KnownDerivatives::Factors => Ok(Effort::fast(0)),
        };
        let back = (1.0 + self.friction.decay.lane(0)).recip();
        let own = &room.memory.left.past;
        for (own, slopes) in own.iter().zip(&mut lists.slopes) {
            for (own, all) in own.as_ref().iter().zip(slopes.as_mut()) {
                (0..N).for_each(|i| all.set(i, S::from_f64(Stages::get(own, i))));
            }
        }
        if F::FACTS.kind.is_conformal {
            // They are stored in the momentum of the next step.
            lists.slopes[1].as_mut().iter_mut().for_each(|slopes| *slopes = slopes.times(&[back; N]));
        }
        left.scalar_path = Some(room);
        let effort = solved?;
        self.differentiate_stages(lists, left, known == KnownDerivatives::Factors)?;
        Ok(StepOutcome { effort, waits: left.waits })
    }

    /// Takes the step without derivatives.
    fn take_values<const CAREFUL: bool>(
        &self,
        state: [&[S]; 2],
        dw: &[S],
        left: &GaussHistoryOf<F, S, N>,
        room: &mut ScalarPath<F::Shape, F::Noises, N>,
    ) -> Result<Effort, StepFailure> {
        room.read(0, state, dw);
        let ScalarPath { memory: own, q, p, dw } = room;
        own.left.is_known &= left.is_known;
        own.left.is_held = left.is_held;
        own.left.iteration = left.iteration;
        let prepared = (&F::Parameters::lane(self.parameters, 0), &self.friction.lane(0), self.common);
        let [t, h] = [self.t, self.h].map(|constant| constant.lane(0));
        let at = StepArguments { t, h, q: &mut q[..], p: &mut p[..], dw };
        advance::<_, f64, f64, PlainSum, N, CAREFUL>(self.system, prepared, at, own, &mut PlainSum)
    }

    /// One path, with its stages in lanes.
    ///
    /// # Errors
    /// The errors of its step.
    #[cold]
    #[inline(never)]
    fn solve_scalar_path(
        &self,
        lane: usize,
        [q, p]: [&[S]; 2],
        dw: &[S],
        lists: &mut StageLists<S, F::Shape, N>,
        left: &mut GaussHistoryOf<F, S, N>,
    ) -> Result<StepOutcome<f64>, StepFailure> {
        let is_lane = S::Mask::of_lanes(|other| other == lane);
        let room = left.scalar_path.get_or_insert_default();
        room.read(lane, [q, p], dw);
        let ScalarPath { memory: own, q: own_q, p: own_p, dw: own_dw } = &mut **room;
        own.left.is_known = left.is_known;
        own.left.waits = left.waits.lane(lane);
        own.left.iteration = left.iteration;
        for (own, all) in own.left.past.iter_mut().zip(&left.past) {
            for (own, all) in own.as_mut().iter_mut().zip(all.as_ref()) {
                (0..N).for_each(|i| own.set(i, all.get(i).lane(lane)));
            }
        }
        let friction = &self.friction.lane(lane);
        let prepared = (&F::Parameters::lane(self.parameters, lane), friction, self.common);
        let at = StepArguments {
            t: self.t.lane(lane),
            h: self.h.lane(lane),
            q: &mut own_q[..],
            p: &mut own_p[..],
            dw: own_dw,
        };
        let effort =
            advance::<_, f64, f64, PlainSum, N, false>(self.system, prepared, at, own, &mut PlainSum)?;
        for (all, own) in lists.next.iter_mut().zip([&*own_q, own_p]) {
            for (all, own) in all.as_mut().iter_mut().zip(own) {
                *all = S::select(is_lane, S::from_f64(*own), *all);
            }
        }
        for (all, own) in lists.slopes.iter_mut().zip(&own.left.past) {
            for (all, own) in all.as_mut().iter_mut().zip(own.as_ref()) {
                (0..N).for_each(|i| {
                    all.set(i, S::select(is_lane, S::from_f64(Stages::get(own, i)), all.get(i)));
                });
            }
        }
        Ok(StepOutcome { effort, waits: own.left.waits })
    }
}
