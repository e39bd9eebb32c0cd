//! From Hamiltonians to discrete Euler-Lagrange equations: mathematics only, no tokens.
//!
//! ```text
//! Hamiltonians --lagrangian--> L_d --equations--> x = φ(x) --structure--> blocks in solving order
//!            \--facts--> consistency, first integrals, class of the noise
//! ```

pub(crate) mod branches;
pub(crate) mod describe;
pub(crate) mod equations;
pub(crate) mod facts;
pub(crate) mod gauss;
pub(crate) mod lagrangian;
pub(crate) mod modified;
pub(crate) mod plan;
pub(crate) mod quadrature;
pub(crate) mod roles;
pub(crate) mod structure;
pub(crate) mod sums;
pub(crate) mod unknown;

pub(crate) use self::equations::Equations;
pub(crate) use self::facts::clock::{DriftFlow, NoiseOfClock};
pub(crate) use self::facts::constraints::{ConstraintMistake, NoiseOffManifold};
pub(crate) use self::facts::flows::Flows;
pub(crate) use self::facts::kinetic::Kinetic;
pub(crate) use self::facts::{
    Facts, Failure, Invariant, NoiseClass, has_constant_forces, is_quadratic, split, summed,
};
pub(crate) use self::gauss::StepGradient;
pub(crate) use self::lagrangian::{DiscreteLagrangian, StepSymbols};
pub(crate) use self::plan::{Linearity, Plans, SchemePlan, Step, Strategy, Unknowns};
pub(crate) use self::quadrature::{Quadrature, Stage};
pub(crate) use self::roles::{Role, RoleElements, elements_by_role, family_of, scale_momenta};
pub(crate) use self::structure::{Block, Dependencies, Pivot, Solution, increment};
pub(crate) use self::sums::{Calculus, Increments, KnownSum, Space, Sum, Weighted, unweighted, weighted};
pub(crate) use self::unknown::{ByUnknown, Unknown};

use std::rc::Rc;

use self::structure::Structure;
use crate::model::StraightLine;
use crate::symbolic::Graph;

/// A step in straight lines, ready to be emitted.
pub(crate) struct Scheme {
    pub(crate) line: Rc<StraightLine>,
    pub(crate) lagrangian: DiscreteLagrangian,
    pub(crate) equations: Equations,
    pub(crate) structure: Structure,
}

/// From the Hamiltonians of `line` to a step in straight-line code.
pub(crate) fn discretise(graph: &mut Graph, line: Rc<StraightLine>, quadrature: &Quadrature) -> Scheme {
    let lagrangian = DiscreteLagrangian::new(graph, &line, quadrature);
    let equations = Equations::new(graph, &lagrangian);
    let structure = Structure::new(graph, &lagrangian, &equations);
    Scheme { line, lagrangian, equations, structure }
}
