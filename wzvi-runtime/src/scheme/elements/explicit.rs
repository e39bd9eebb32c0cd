//! One step of an explicit scheme: `v` and then `u` are assigned.

use super::memory::StepLists;
use super::passes::{add, are_finite};
use super::step::{LoopStep, negate, nothing, subtract_multiple};
use super::sums::OntoVector;
use super::tiles::takes_tiles;
use super::{Elements, LoopMemory, MomentumUpdate, Partials, Quadrature, QuadraturePoint, WeightedRole};
use crate::algebra::scalar::Scalar;
use crate::algebra::solve::Effort;
use crate::algebra::state_sum::StateSum;
use crate::error::StepFailure;
use crate::scheme::system::{Movable, StepArguments};

/// One step from `(q, p)` at `t` in place; on `Err` nothing but scratch is changed.
///
/// Inlined into the step of one system by one scheme, where the table of the scheme and often the number of
/// degrees of freedom are constants: loops over stages or roles and checks of lengths disappear. Numbers of
/// several parts take a separate path: the registers hold only one element of them.
///
/// # Errors
/// [`StepFailure`]: sizes that do not fit, a state that is not finite.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn advance_explicit<H: Elements + Sync, S: Scalar, C: StateSum<S>>(
    (system, parameters): (&H, &[S::Constant]),
    scheme: &Quadrature,
    at: StepArguments<'_, S, S::Constant, impl Movable<S> + ?Sized>,
    memory: &mut LoopMemory<S>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    if size_of::<S>() == size_of::<f64>() {
        advance((system, parameters), scheme, at, memory, carry)
    } else {
        advance_outlined((system, parameters), scheme, at.lists(), memory, carry)
    }
}

#[inline(never)]
fn advance_outlined<H: Elements + Sync, S: Scalar, C: StateSum<S>>(
    (system, parameters): (&H, &[S::Constant]),
    scheme: &Quadrature,
    at: StepArguments<'_, S, S::Constant>,
    memory: &mut LoopMemory<S>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    advance((system, parameters), scheme, at, memory, carry)
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn advance<H: Elements + Sync, S: Scalar, C: StateSum<S>>(
    (system, parameters): (&H, &[S::Constant]),
    scheme: &Quadrature,
    StepArguments { t, h, q: to_q, p: to_p, dw }: StepArguments<'_, S, S::Constant, impl Movable<S> + ?Sized>,
    memory: &mut LoopMemory<S>,
    carry: &mut C,
) -> Result<Effort, StepFailure> {
    let (q, p) = (to_q.list(), to_p.list());
    if !memory.fits(system, q.len()) {
        memory.fit(system, scheme, q.len())?;
    }
    let [q, p] = super::sized_mut(system, [q, p])?;
    let dw = super::increments(system, dw)?;
    if const { H::FACTS.has_tiles && S::MAY_BE_F64 }
        && takes_tiles(scheme, q.len())
        && let (Some(known_q), Some(known_p), Some(dw)) =
            (S::as_f64s_mut(q), S::as_f64s_mut(p), S::as_f64s(dw))
    {
        let (q, p, plan) = (known_q, known_p, &mut memory.plan);
        let [t, h] = [t, h].map(|constant| constant.lane(0));
        let lost = carry.lists(q.len()).map(|lost| S::as_f64s(lost).unwrap_or_default());
        let step = LoopStep { system, scheme, t, h, parameters: &[], q, p, dw, increment: None };
        let taken =
            if C::CARRIES { step.advance_compensated(lost, plan) } else { step.advance_in_tiles(plan) };
        taken?.store(to_q, to_p, carry);
        return Ok(Effort::fast(0));
    }
    let step = LoopStep { system, scheme, t, h, parameters, q, p, dw, increment: None };
    let mut lists = memory.work.lists(scheme, step.degrees());
    if !C::CARRIES && !H::FACTS.kind.is_conformal && scheme.update == MomentumUpdate::Multiple(1.0) {
        // `P` is the new momentum.
        if !step.go_on(&mut lists) {
            return Err(StepFailure::NonFinite);
        }
        let StepLists { u, momentum, .. } = lists;
        q.copy_from_slice(u);
        p.copy_from_slice(momentum);
    } else {
        step.assign(&mut lists);
        step.finish(&mut lists);
        lists.store(q, p, carry)?;
    }
    Ok(Effort::fast(0))
}

impl<H: Elements + Sync, S: Scalar> LoopStep<'_, H, S> {
    /// `P` from the derivatives in `D_1 L_d`, all at `q_i` or equal at all `q`, then `u`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn assign(&self, lists: &mut StepLists<'_, S>) {
        self.kick(lists);
        self.drift(lists);
    }

    /// `P`, and `-v` as the derivatives of the first stage.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn kick(&self, lists: &mut StepLists<'_, S>) {
        let is_at_node = |stage: &QuadraturePoint| stage.start == 0.0 || stage.start == 1.0;
        if !self.scheme.stages.iter().all(is_at_node) {
            return self.kick_between_nodes(lists);
        }
        let StepLists { momentum, stages, by_p, columns, .. } = lists;
        let (_, by_q) = stages.at_mut(0);
        by_q.fill(nothing());
        for stage in self.scheme.stages {
            if stage.start != 0.0 {
                self.gradient(stage, [self.q, self.p], Partials::BY_COORDINATES, by_q, by_p, columns);
            }
        }
        for (momentum, (&p, &force)) in momentum.iter_mut().zip(self.p.iter().zip(&*by_q)) {
            *momentum = p - force;
        }
    }

    /// The kick where stages have weights in `D_1 L_d`.
    #[inline(never)]
    fn kick_between_nodes(&self, lists: &mut StepLists<'_, S>) {
        let StepLists { momentum, stages, u: v, by_p, columns, .. } = lists;
        v.fill(nothing());
        for (s, stage) in self.scheme.stages.iter().enumerate() {
            let (_, by_q) = stages.at_mut(s);
            by_q.fill(nothing());
            if stage.start != 0.0 {
                self.gradient(stage, [self.q, self.p], Partials::BY_COORDINATES, by_q, by_p, columns);
                subtract_multiple(v, by_q, stage.start);
            }
        }
        let (_, forces) = stages.at_mut(0);
        negate(forces, v);
        for (momentum, (&p, &v)) in momentum.iter_mut().zip(self.p.iter().zip(&**v)) {
            *momentum = p + v;
        }
    }

    /// `u`
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn drift(&self, lists: &mut StepLists<'_, S>) {
        let StepLists { u, momentum, by_p, columns, .. } = lists;
        u.fill(nothing());
        self.velocities(momentum, by_p, u, columns);
    }

    /// `P` and, in place of `u`, the new coordinates; returns whether both are finite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn go_on(&self, lists: &mut StepLists<'_, S>) -> bool {
        self.kick(lists);
        let has_one_velocity = H::FACTS.has_one_velocity && self.scheme.takes_roles_once();
        if has_one_velocity && size_of::<S>() == size_of::<f64>() {
            let StepLists { u, momentum, .. } = lists;
            self.drift_onto(momentum, OntoVector { base: self.q, next: u });
            return are_finite(u) && are_finite(momentum);
        }
        self.drift(lists);
        let StepLists { u, momentum, .. } = lists;
        add(u, self.q) && are_finite(momentum)
    }

    /// Adds the velocities directly to the coordinates.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn drift_onto(&self, momentum: &[S], mut coordinates: OntoVector<'_, S>) {
        for stage in self.scheme.stages {
            let (at, none) = (self.at(stage, self.q, momentum), &mut [][..]);
            for &WeightedRole { role, weight } in stage.roles {
                self.system.gradient::<S, S>(role, weight, &at, Partials::BY_MOMENTA, none, &mut coordinates);
            }
        }
    }
}
