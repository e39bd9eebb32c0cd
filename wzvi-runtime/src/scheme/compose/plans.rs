//! The plans of compositions.

use crate::scheme::plan::{KeptEnergy, Plan, Solver};

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
