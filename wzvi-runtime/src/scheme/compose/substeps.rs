//! The parts of a step, of two kinds, each with its fraction of the step.

use std::marker::PhantomData;

use super::Weights;
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

/// The parts of a step that composes steps of `E` by `W`, for a system of the structure `K`:
/// [`Composes`](super::Composes) lists them.
#[derive(Clone, Copy, Debug)]
pub struct Substeps<E, K, W>(PhantomData<(E, K, W)>);

/// One step, as a composition.
#[derive(Clone, Copy, Debug)]
pub enum SingleStep {}

#[diagnostic::do_not_recommend]
impl Weights for SingleStep {
    const ORDER: u32 = 2;
    const GAMMA: &'static [f64] = &[1.0];
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
