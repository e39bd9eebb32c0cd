//! What a step of a composition is a sequence of.

use std::fmt::Debug;

use crate::carry::Carry;
use crate::error::{ConfigError, StepFailure};
use crate::lanes::Lanes;
use crate::memory::StepMemory;
use crate::plan::{KeptEnergy, Plan, Solver};
use crate::scalar::Scalar;
use crate::solve::Effort;
use crate::state::Vector;
use crate::system::{Exchange, Hamiltonian, Segment};

/// Which of the two kinds of parts of a step: which scheme of a pair, or which flow of a splitting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// The first scheme; the drift, which is the flow of `T(p)`.
    First,
    /// The second scheme; the kick, which is the flow of `V(q)`.
    Second,
}

/// A part of a step: of which kind, and what fraction of the step.
pub type Substep = (Half, f64);

/// A way to take the parts of a step of `H`, one after the other.
pub trait Sequence<H: Hamiltonian> {
    /// The plan of a step of order two.
    const PLAN: Plan;
    /// As `Discretized::REMEMBERS`.
    const REMEMBERS: bool;
    /// As `Discretized::IN_LANES`.
    const IN_LANES: bool;
    /// As `Discretized::FILLS_REGISTERS_FROM`.
    const FILLS_REGISTERS_FROM: usize = usize::MAX;
    /// Whether steps are symmetric, and so consistent with every Stratonovich system.
    const IS_SYMMETRIC: bool = true;
    /// Whether steps follow from a discrete Lagrangian.
    const IS_VARIATIONAL: bool = true;
    /// As `Discretized::KEPT_ENERGY`, of a step of order two.
    const KEPT_ENERGY: KeptEnergy = KeptEnergy::Hamiltonian;
    /// As `Discretized::EXCHANGES`.
    const EXCHANGES: bool = false;
    /// What is computed once for all steps of one size.
    type Prepared: Clone + Debug + Send + Sync;
    /// What a step leaves for the next.
    type Memory<S: Scalar>: StepMemory;
    /// Compensated sums.
    type Compensated<S: Scalar>: Carry<S>;
    /// How increments are added unless the user chooses.
    type Carry<S: Scalar>: Carry<S>;

    /// As `Discretized::increments`.
    fn increments(system: &H, degrees: usize) -> usize {
        let _ = degrees;
        system.noises()
    }

    /// As `Discretized::exchanged`.
    fn exchanged(system: &H, memory: &Self::Memory<f64>) -> Exchange {
        let _ = (system, memory);
        Exchange::default()
    }

    /// The memory of a new stepper.
    fn memory(system: &H, substeps: &[Substep]) -> Self::Memory<f64>;

    /// Prepares every part of a step of size `h`.
    ///
    /// # Errors
    /// That of the first part that has one.
    fn prepare(system: &H, h: f64, substeps: &[Substep]) -> Result<Self::Prepared, ConfigError>;

    /// All parts of a step, one after the other. On `Err`, `q`, `p`, `memory` and `carry` are as they were.
    ///
    /// # Errors
    /// That of the first part that has one.
    #[expect(clippy::too_many_arguments, reason = "as `Discretized::advance_carrying`")]
    fn advance<S: Scalar, C: Carry<S>, const CAREFUL: bool>(
        system: &H,
        prepared: &Self::Prepared,
        t: f64,
        h: f64,
        q: &mut [S],
        p: &mut [S],
        dw: &[S],
        memory: &mut Self::Memory<S>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure>;

    /// As `Discretized::Beside`.
    type Beside<const L: usize>;

    /// As `Discretized::beside`.
    fn beside<const L: usize>(systems: [&H; L], prepared: [&Self::Prepared; L]) -> Option<Self::Beside<L>>;

    /// As `Discretized::advance_beside`.
    ///
    /// # Errors
    /// Those of `Discretized::advance_carrying`.
    fn advance_beside<const L: usize>(
        beside: &Self::Beside<L>,
        t: f64,
        h: f64,
        q: &mut [Lanes<L>],
        p: &mut [Lanes<L>],
        dw: &[Lanes<L>],
        memory: &mut Self::Memory<Lanes<L>>,
    ) -> Result<Effort, StepFailure>;

    /// [`Sequence::advance`] of vectors that may be exchanged for others with the new numbers.
    ///
    /// # Errors
    /// Those of [`Sequence::advance`].
    #[expect(clippy::too_many_arguments, reason = "as `Discretized::advance_carrying`")]
    #[inline(always)]
    fn advance_vectors<C: Carry<f64>, const CAREFUL: bool>(
        system: &H,
        prepared: &Self::Prepared,
        t: f64,
        h: f64,
        q: &mut H::Vector,
        p: &mut H::Vector,
        dw: &[f64],
        memory: &mut Self::Memory<f64>,
        carry: &mut C,
    ) -> Result<Effort, StepFailure> {
        let (q, p) = (q.components_mut(), p.components_mut());
        Self::advance::<f64, C, CAREFUL>(system, prepared, t, h, q, p, dw, memory, carry)
    }

    /// Where the parts lead to from the start of a segment, and the sum of their discrete Lagrangians; `None` where a part
    /// has no solution.
    fn follow(
        system: &H,
        segment: &Segment<H::Vector>,
        dw: &[f64],
        substeps: &[Substep],
    ) -> Option<Followed<H::Vector>>;
}

/// The end of a sequence of parts.
#[derive(Clone, Debug)]
pub struct Followed<V> {
    /// `Q`
    pub q: V,
    /// `R`
    pub p: V,
    /// `A`
    pub action: f64,
}

/// The plan of a composition of this order; `of_step` is that of a step of order two at most, consistent where it is symmetric.
pub const fn plan(of_step: Plan, order: u32, is_symmetric: bool) -> Plan {
    let order = if order > of_step.order { order } else { of_step.order };
    Plan { order, consistent: is_symmetric || of_step.consistent, ..of_step }
}

/// The energy that a composition of this order keeps, by that of a step of order two.
pub const fn kept_energy(of_step: KeptEnergy, order: u32) -> KeptEnergy {
    match of_step {
        KeptEnergy::KickDriftKick if order > 2 => KeptEnergy::Nearly,
        _ => of_step,
    }
}

/// The plan of steps that are made of those of two plans.
pub(super) const fn joint_plan(first: Plan, second: Plan) -> Plan {
    let solver = match (first.solver, second.solver) {
        (Solver::Newton, _) | (_, Solver::Newton) => Solver::Newton,
        (Solver::Linear, _) | (_, Solver::Linear) => Solver::Linear,
        _ => Solver::Explicit,
    };
    let unknowns = if first.unknowns > second.unknowns { first.unknowns } else { second.unknowns };
    Plan { solver, unknowns, ..first }
}
