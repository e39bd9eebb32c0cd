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

/// Multiplications of a dense elimination up to which a step is written in straight lines, if there is no noise: seven sites. For chains, rings and pairs with
/// the mid-point a path in straight lines takes 0.6 to 0.95 of the time of loops at five sites, about as long at six, and 1.2 to 2.0 at eight; in
/// ensembles, whose paths run in lanes only in straight lines, 0.3 to 0.4, 0.4 to 0.55 and 0.65 to 0.7. The largest loss is then about 1.6 for either.
/// (`cargo bench --bench seam` has literal sizes beside const generics, which are always loops.)
const SWEPT: usize = 114;

/// The same with noise: straight-line code runs paths in lanes, loops do not.
const SWEPT_IN_LANES: usize = 256;

impl Scheme {
    /// Whether Newton's method with dense elimination, which takes `n³/3` multiplications, costs more than iterations
    /// with no elimination, or a banded one.
    pub(crate) fn is_cheaper_swept(&self, noise: NoiseClass) -> bool {
        let most = if noise == NoiseClass::None { SWEPT } else { SWEPT_IN_LANES };
        self.structure.blocks.iter().any(|block| match block.solution {
            Solution::Newton { .. } => block.iterates.len().pow(3) / 3 > most,
            _ => false,
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
