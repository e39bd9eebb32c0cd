//! The unknowns on which a scheme iterates. With `u = Δq`, `v = P - p_i`, the discrete Euler-Lagrange
//! equations are
//!
//! ```text
//! u = Σ_m c_m ∂H_m/∂p(P, Q_m),   v = -Σ_m (1 - l_m) c_m ∂H_m/∂q(P, Q_m),   Q_m = q_i + l_m u,   P = p_i + v
//! ```
//!
//! | structure | unknowns |
//! |---|---|
//! | `H = T(p) + V(q)`, every `l_m` of a term whose `V'` reads `q` is 0 or 1 | none |
//! | `H = T(p) + V(q)`, `T''` diagonal | `v`: `u` follows from it |
//! | every `l_m` is 0 | `v`: it is read nowhere else |
//! | otherwise | `u` and `v` |

use std::rc::Rc;

use crate::discretise::{Facts, Part, Quadrature, Scheme, Stage, discretise, has_constant_forces};
use crate::embedding::Embedding;
use crate::model::{Element, Form, StraightLine, System};
use crate::symbolic::Rational;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Unknowns {
    None,
    Momenta,
    Both,
}

/// The solution of steps in loops, for all unknowns at once.
#[derive(Clone, Copy)]
pub(crate) struct Strategy {
    pub(crate) unknowns: Unknowns,
    /// Whether the Jacobian never changes.
    pub(crate) is_linear: bool,
}

/// A scheme with the form of its steps.
pub(crate) enum Step {
    StraightLine(Rc<StraightLine>, Box<Scheme>),
    InLoops(Embedding, Strategy),
}

impl Step {
    /// The step in the form that was chosen.
    pub(crate) fn of(system: &mut System, facts: &Facts, embedding: &Embedding, form: Form) -> Self {
        match system.line.clone().filter(|_| form == Form::StraightLines) {
            Some(line) => {
                let scheme = discretise(&mut system.graph, &line, facts, embedding);
                Self::StraightLine(line, Box::new(scheme))
            }
            None => Self::InLoops(embedding.clone(), Strategy::of(system, facts, embedding)),
        }
    }

    pub(crate) fn embedding(&self) -> &Embedding {
        match self {
            Self::StraightLine(_, scheme) => &scheme.embedding,
            Self::InLoops(embedding, _) => embedding,
        }
    }
}

impl Strategy {
    fn of(system: &mut System, facts: &Facts, embedding: &Embedding) -> Self {
        let unknowns = unknowns(system, facts, embedding);
        let corrects = || Quadrature::new(facts, embedding).weights_of(Part::CounterTerm).next().is_some();
        let is_linear = unknowns != Unknowns::None && !corrects() && facts.has_constant_curvature;
        Self { unknowns, is_linear }
    }
}

fn unknowns(model: &mut System, facts: &Facts, embedding: &Embedding) -> Unknowns {
    let Quadrature { stages } = Quadrature::new(facts, embedding);
    let System { graph, drift, noise, force, .. } = model;
    let mut varies =
        |elements: &[Element]| !elements.iter().all(|element| has_constant_forces(graph, element));
    let varying_drift = varies(&drift.elements);
    let varying_noise = noise.iter().any(|noise| varies(&noise.term.elements));
    let varying_force = force.as_ref().is_some_and(|force| varies(&force.elements));
    let has_varying_forces = |(part, _): &(Part, Rational)| match part {
        Part::Drift => varying_drift,
        Part::Noise => varying_noise,
        Part::Force => varying_force,
        Part::CounterTerm => true,
    };
    // The counter-term reads coordinates and momenta.
    let is_simple = |(part, _): &(Part, Rational)| *part != Part::CounterTerm;
    let is_separable = facts.is_separable && stages.iter().all(|stage| stage.parts.iter().all(is_simple));
    let is_at_node = |stage: &Stage| stage.l.is_zero() || stage.l.is_one();
    let is_assigned = |stage: &Stage| is_at_node(stage) || !stage.parts.iter().any(has_varying_forces);
    if is_separable && stages.iter().all(is_assigned) {
        Unknowns::None
    } else if (is_separable && facts.has_diagonal_kinetic_energy)
        || stages.iter().all(|stage| stage.l.is_zero())
    {
        Unknowns::Momenta
    } else {
        Unknowns::Both
    }
}
