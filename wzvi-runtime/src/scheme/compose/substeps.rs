//! The parts of a step, of two kinds, each with its fraction of the step.

use std::marker::PhantomData;

use super::{Composes, Structure};
use crate::scheme::plan::{KeptEnergy, Plan, Solver};

/// The kind of a part of a step: a scheme of a pair, or a flow of a splitting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// The first scheme; the drift, which is the flow of `T(p)`.
    First,
    /// The second scheme; the kick, which is the flow of `V(q)`.
    Second,
}

/// A part of a step: its kind, and its fraction of the step.
pub type Substep = (Half, f64);

/// The parts of a step, one after the other.
pub trait Substeps {
    /// The order of the step.
    const ORDER: u32;
    /// The factors of the squares of forces, one for each part, where there are some.
    const GRADIENT: &'static [f64] = &[];
    /// All of them.
    fn list() -> Vec<Substep>;
}

/// Those of one step of `E`, for the structure `K`.
#[derive(Clone, Copy, Debug)]
pub struct One<E, K>(PhantomData<(E, K)>);

impl<E, K: Structure<E>> Substeps for One<E, K> {
    const ORDER: u32 = 2;

    fn list() -> Vec<Substep> {
        let mut substeps = Vec::new();
        K::step(1.0, &mut substeps);
        substeps
    }
}

/// Those of steps of `E` with the weights `W`.
#[derive(Clone, Copy, Debug)]
pub struct Many<E, K, W>(PhantomData<(E, K, W)>);

impl<E, K: Structure<E>, W: Composes<E, K>> Substeps for Many<E, K, W> {
    const ORDER: u32 = W::ORDER;
    const GRADIENT: &'static [f64] = W::GRADIENT;

    fn list() -> Vec<Substep> {
        W::substeps()
    }
}

/// The plan of a symmetric composition of this order; `of_step` is that of a step of order two at most.
pub(crate) const fn plan(of_step: Plan, order: u32) -> Plan {
    let order = if order > of_step.order { order } else { of_step.order };
    Plan { order, consistent: true, ..of_step }
}

/// The energy that a composition of this order conserves, from that of a step of order two.
pub(super) const fn kept_energy(of_step: KeptEnergy, order: u32) -> KeptEnergy {
    match of_step {
        KeptEnergy::KickDriftKick if order > 2 => KeptEnergy::Nearly,
        _ => of_step,
    }
}

/// The plan of steps that are composed of steps with two plans.
pub(super) const fn joint_plan(first: Plan, second: Plan) -> Plan {
    let solver = match (first.solver, second.solver) {
        (Solver::Newton, _) | (_, Solver::Newton) => Solver::Newton,
        (Solver::Linear, _) | (_, Solver::Linear) => Solver::Linear,
        _ => Solver::Explicit,
    };
    let unknowns = if first.unknowns > second.unknowns { first.unknowns } else { second.unknowns };
    Plan { solver, unknowns, ..first }
}
