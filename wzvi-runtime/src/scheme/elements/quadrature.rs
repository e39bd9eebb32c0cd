//! The quadrature of a scheme, as the compiler derived it.

use super::role::{Role, WeightedRole};
use crate::algebra::scalar::Scalar;
use crate::scheme::plan::{Facts, KeptEnergy, Plan, Solver};
use crate::scheme::poles::Poles;

/// The unknowns of the iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknowns {
    /// None: `v` and then `u` are assigned. No element reads both halves of the phase space, and those whose
    /// forces depend on coordinates stand at the nodes.
    None,
    /// `v`, from which `u` follows.
    Momenta,
    /// `u` and `v`.
    Both,
}

/// How the unknowns enter the equations of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Linearity {
    /// Not linearly: the Jacobian reads them.
    Nonlinear,
    /// Linearly, with a Jacobian of the state at the start, the time and the increments.
    Affine,
    /// Linearly, with a Jacobian of the step size and parameters only: factors serve all steps.
    Constant,
}

impl Linearity {
    pub(super) const fn is_constant(self) -> bool {
        matches!(self, Self::Constant)
    }

    pub(super) const fn is_affine(self) -> bool {
        !matches!(self, Self::Nonlinear)
    }
}

impl Unknowns {
    /// Number of unknowns.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) const fn count(self, degrees: usize) -> usize {
        match self {
            Self::None => 0,
            Self::Momenta => degrees,
            Self::Both => degrees.saturating_mul(2),
        }
    }

    /// Number of entries of `∂u/∂v`, which is diagonal where `u` follows from `v`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn diagonals(self, degrees: usize) -> usize {
        match self {
            Self::Momenta => degrees,
            Self::None | Self::Both => 0,
        }
    }
}

/// A quadrature point of the discrete Lagrangian, and what is evaluated there of the step Hamiltonian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraturePoint {
    /// `c` in `Q = q_i + c u`, `T = t_i + c h`.
    pub point: f64,
    /// `∂Q/∂q_i`, the weight of the derivatives in `D_1 L_d`.
    pub start: f64,
    /// `∂Q/∂q_{i+1}`, the weight of the derivatives in `D_2 L_d`.
    pub end: f64,
    /// The roles of the terms that are evaluated here, with their weights.
    pub roles: &'static [WeightedRole],
}

impl QuadraturePoint {
    /// The point, `∂Q/∂q_i` and `∂Q/∂q_{i+1}`, and the roles there.
    pub const fn new([point, start, end]: [f64; 3], roles: &'static [WeightedRole]) -> Self {
        Self { point, start, end, roles }
    }
}

/// How `p_{i+1} - p_i` follows from the solved unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MomentumUpdate {
    /// A multiple of `v`: if `D_2 L_d - P` is a multiple of `D_1 L_d + P`, no derivatives are evaluated
    /// again.
    Multiple(f64),
    /// `v` and the derivatives of `D_2 L_d`.
    Slopes,
}

/// The quadrature of a scheme, as the compiler derived it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quadrature {
    /// The quadrature points of the discrete Lagrangian, at least one.
    pub stages: &'static [QuadraturePoint],
    /// How the new momentum follows.
    pub update: MomentumUpdate,
    /// The unknowns of the iteration.
    pub unknowns: Unknowns,
    /// Whether the iteration starts from past steps; not in systems with noise.
    pub remembers: bool,
    /// How the unknowns enter the equations.
    pub linearity: Linearity,
}

impl Quadrature {
    /// Whether implicit steps in numbers with derivatives are solved for the values first. Equations with a
    /// constant Jacobian are solved with kept factors in any numbers.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) const fn takes_values_first<S: Scalar>(&self) -> bool {
        S::IS_PLAIN_DUAL && !self.linearity.is_constant() && !matches!(self.unknowns, Unknowns::None)
    }

    /// For steps in straight-line code: only the momentum between two states, if anything, is solved with it.
    pub const fn new(stages: &'static [QuadraturePoint], update: MomentumUpdate) -> Self {
        let (unknowns, linearity) = (Unknowns::Momenta, Linearity::Nonlinear);
        Self { stages, update, unknowns, remembers: false, linearity }
    }

    /// The ratio of the change of the momenta to `v`, if it is constant; infinite if `D_1 L_d` has no
    /// derivatives, so that `v` is zero.
    #[doc(hidden)]
    pub const fn factor(&self) -> Option<f64> {
        if let MomentumUpdate::Multiple(factor) = self.update {
            return Some(factor);
        }
        let mut stages = self.stages;
        while let [stage, rest @ ..] = stages {
            if stage.start != 0.0 {
                return None;
            }
            stages = rest;
        }
        Some(f64::INFINITY)
    }

    /// The energy of a linear system that steps of this order conserve, by where the drift is evaluated.
    pub(crate) const fn kept_energy(&self, order: u32) -> KeptEnergy {
        let (mut stages, mut point, mut count) = (self.stages, 0.5, 0);
        while let [stage, rest @ ..] = stages {
            let mut roles = stage.roles;
            while let [weighted, others @ ..] = roles {
                if matches!(weighted.role, Role::Drift) {
                    (point, count) = (stage.point, count + 1);
                }
                roles = others;
            }
            stages = rest;
        }
        match (count, order) {
            (2.., _) => KeptEnergy::Nearly,
            (_, 1) => KeptEnergy::Point(point),
            _ => KeptEnergy::Hamiltonian,
        }
    }

    /// The poles of the steps, if drift and noise are taken at the same points.
    pub(crate) const fn poles(&self) -> Option<Poles> {
        let (mut stages, mut means) = (self.stages, [0.0, 0.0]);
        while let [stage, rest @ ..] = stages {
            let mut roles = stage.roles;
            while let [WeightedRole { role, weight }, others @ ..] = roles {
                match role {
                    Role::Drift => means[0] += *weight * stage.point,
                    Role::Noise => means[1] += *weight * stage.point,
                    // A counter-term has products of increments, and forces beside the drift have the points
                    // of the drift.
                    Role::CounterTerm => return None,
                    _ => {}
                }
                roles = others;
            }
            stages = rest;
        }
        if (means[0] - means[1]).abs() < 1e-12 { Some(Poles::at(means[0])) } else { None }
    }

    /// The plan of steps in loops.
    pub(super) const fn plan(&self, facts: Facts, order: u32, consistent: bool) -> Plan {
        let coupled = match facts.coupled_degrees {
            Some(degrees) => degrees,
            None => facts.degrees,
        };
        let unknowns = match (self.unknowns, self.factor()) {
            // `v` is zero.
            (Unknowns::Both, Some(f64::INFINITY)) => coupled,
            (unknowns, _) => unknowns.count(coupled),
        };
        // One elimination solves uncoupled blocks; others are iterated unless their factors are kept.
        let is_solved_at_once = match self.linearity {
            Linearity::Constant => true,
            Linearity::Affine => facts.coupled_degrees.is_some(),
            Linearity::Nonlinear => false,
        };
        let solver = match (self.unknowns, is_solved_at_once) {
            (Unknowns::None, _) => Solver::Explicit,
            (_, true) => Solver::Linear,
            (_, false) => Solver::Newton,
        };
        let has_weak_order_two = facts.has_weak_order_two && self.has_centred_noise();
        Plan { has_weak_order_two, ..facts.plan(solver, unknowns, order, consistent) }
    }

    /// Whether what acts beside the drift is taken in the middle of the step, on average.
    const fn has_centred_noise(&self) -> bool {
        let (mut stages, mut lever) = (self.stages, 0.0);
        while let [stage, rest @ ..] = stages {
            let mut roles = stage.roles;
            while let [WeightedRole { role, weight }, others @ ..] = roles {
                if !matches!(role, Role::Drift) {
                    lever += *weight * (stage.point - 0.5);
                }
                roles = others;
            }
            stages = rest;
        }
        // The points are fractions, rounded.
        lever.abs() < 1e-12
    }

    /// Whether no role is evaluated at two stages.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn takes_roles_once(&self) -> bool {
        let roles = |stage: &'static QuadraturePoint| stage.roles.iter().map(|weighted| weighted.role);
        let stages = self.stages.iter().enumerate();
        let mut earlier =
            stages.flat_map(|(s, stage)| self.stages[..s].iter().map(move |other| (stage, other)));
        earlier.all(|(stage, other)| roles(stage).all(|role| roles(other).all(|known| known != role)))
    }
}
