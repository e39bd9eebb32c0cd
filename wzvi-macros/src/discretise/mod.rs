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
pub(crate) mod parts;
pub(crate) mod plan;
pub(crate) mod quadrature;
pub(crate) mod structure;
pub(crate) mod sums;

pub(crate) use self::equations::Equations;
pub(crate) use self::facts::flows::{Flows, is_nystrom};
pub(crate) use self::facts::kinetic::Kinetic;
pub(crate) use self::facts::{Facts, Failure, Invariant, NoiseClass, is_quadratic, split, summed};
pub(crate) use self::gauss::StepSlopes;
pub(crate) use self::lagrangian::{DiscreteLagrangian, StepSymbols};
pub(crate) use self::parts::{PartElements, family_of, parts_of, scale_momenta};
pub(crate) use self::plan::{Step, Strategy, Unknowns};
pub(crate) use self::quadrature::{Part, Quadrature, Stage};
pub(crate) use self::structure::{Block, Pivot, Solution, Unknown, increment};
pub(crate) use self::sums::{Calculus, Increments, Judged, Space, Sum, Weighted, unweighted};

use self::structure::Structure;
use crate::embedding::Embedding;
use crate::model::StraightLine;
use crate::symbolic::Graph;

/// One scheme of one system, ready to be emitted.
pub(crate) struct Scheme {
    pub(crate) embedding: Embedding,
    pub(crate) lagrangian: DiscreteLagrangian,
    pub(crate) equations: Equations,
    pub(crate) structure: Structure,
    /// Whether the limit is the Stratonovich system.
    pub(crate) consistent: bool,
}

/// Multiplications of a dense elimination up to which a step is written in straight lines, if one half of the phase space is unknown: five sites. For chains
/// without and with noise, rings and pairs with the mid-point a path in straight lines takes 0.4 of the instructions of loops at five sites and 0.9 to
/// 1.5 at six; in ensembles, whose paths run in lanes either way, 1.1 to 1.3 and 0.9 to 1.7.
/// (`cargo bench --bench seam` forces both ways beside the chosen one.)
const SWEPT: usize = 41;

/// The same where both halves are: three sites. There straight lines take 0.9 to 1.2 of the time of loops, at four sites 1.4 to 1.7; in ensembles 0.7 to 0.9,
/// and 1.1 to 1.4.
const SWEPT_IN_BOTH: usize = 114;

impl Scheme {
    /// Whether Newton's method with dense elimination, which takes `n³/3` multiplications, costs more than iterations
    /// with no elimination, or a banded one.
    pub(crate) fn is_cheaper_swept(&self) -> bool {
        let degrees = self.lagrangian.symbols.degrees();
        self.structure.blocks.iter().any(|Block { iterates, solution, .. }| {
            let coordinates = iterates.iter().filter(|&&unknown| unknown < degrees).count();
            let is_half = coordinates == 0 || coordinates == iterates.len();
            let most = if is_half { SWEPT } else { SWEPT_IN_BOTH };
            matches!(solution, Solution::Newton { .. }) && iterates.len().pow(3) / 3 > most
        })
    }
}

/// Discretises `line` by `embedding`: from Hamiltonians to a step in straight-line code.
pub(crate) fn discretise(
    graph: &mut Graph,
    line: &StraightLine,
    facts: &Facts,
    embedding: &Embedding,
) -> Scheme {
    let lagrangian = DiscreteLagrangian::new(graph, line, &Quadrature::new(facts, embedding));
    let equations = Equations::new(graph, &lagrangian);
    let structure = Structure::new(graph, &lagrangian, &equations);
    let embedding = embedding.clone();
    Scheme { lagrangian, equations, structure, consistent: facts.converges(&embedding), embedding }
}
