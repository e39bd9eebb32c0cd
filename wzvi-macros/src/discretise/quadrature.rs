//! The points at which the discrete Lagrangian evaluates each part: the common source of the straight-line
//! step, the sweep over elements and the text.
//!
//! ```text
//! L_d = P · u - Σ_s Σ_m w_m F_m(P, Q_s, T_s),   u = q_{i+1} - q_i
//! Q_s = q_i + l u,   ∂Q_s/∂q_i = 1 - l,   ∂Q_s/∂q_{i+1} = l,   T_s = t_i + l h
//! ```
//!
//! The parts `F_m` of the step Hamiltonian differ in their increments, and are evaluated at one point or
//! [several](crate::embedding::Points). A force is not part of `L_d` but does virtual work at its stage: by
//! the Lagrange-d'Alembert principle `∂F/∂q - f` replaces `∂F/∂q` (J. E. Marsden, M. West, "Discrete
//! mechanics and variational integrators", Acta Numerica 2001, section 3.2). `Corrected` adds the increment
//! form of the counter-term, at the quadrature points of the noise.
//!
//! Tests: `tests/steps/quadrature.rs`.

use super::facts::{Facts, NoiseClass};
use crate::diagnostics::promised;
use crate::embedding::{Correction, Embedding};
use crate::symbolic::Rational;

const EXACT: &str = "what follows from quadrature points was looked at where they were read";

/// A part of the step Hamiltonian.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Part {
    /// `h H_0`
    Drift,
    /// `Σ_k ΔW_k H_k`
    Noise,
    /// `Σ_jk ΔW_j ΔW_k ∂H_j/∂q · ∂H_k/∂p`
    CounterTerm,
    /// `h f`, in place of `-∂F/∂q`
    Force,
}

/// A quadrature point `l`, and the parts evaluated there with their weights.
#[derive(Clone, Debug)]
pub(crate) struct Stage {
    pub(crate) l: Rational,
    pub(crate) parts: Vec<(Part, Rational)>,
}

impl Stage {
    /// The weight of slopes in `D_1 L_d`: `1 - l`, exact, because `l` is a fraction of small integers.
    pub(crate) fn start(&self) -> Rational {
        promised(Rational::ONE.add(self.l.negate()), "quadrature points are fractions of 32 bits")
    }

    /// The weight of slopes in `D_2 L_d`.
    pub(crate) fn end(&self) -> Rational {
        self.l
    }
}

/// The distinct quadrature points of a scheme, that of the drift first.
#[derive(Clone, Debug)]
pub(crate) struct Quadrature {
    pub(crate) stages: Vec<Stage>,
}

impl Quadrature {
    pub(crate) fn new(facts: &Facts, embedding: &Embedding) -> Self {
        let ([drift, noise], [_, mean]) = (embedding.points(), embedding.means());
        let corrects = embedding.correction() == Correction::Corrected && facts.counter_term_acts(mean);
        let mut of_drift = vec![(Part::Drift, Rational::ONE)];
        if facts.has_force {
            of_drift.push((Part::Force, Rational::ONE));
        }
        let mut of_noise = Vec::new();
        if facts.noise != NoiseClass::None {
            of_noise.push((Part::Noise, Rational::ONE));
        }
        if corrects {
            of_noise.push((Part::CounterTerm, promised(Rational::HALF.add(mean.negate()), EXACT)));
        }
        let mut stages: Vec<Stage> = Vec::new();
        for (points, parts) in [(drift, of_drift), (noise, of_noise)] {
            if parts.is_empty() {
                continue;
            }
            for (l, share) in points.iter() {
                let weighted =
                    parts.iter().map(|&(part, weight)| (part, promised(weight.multiply(share), EXACT)));
                match stages.iter_mut().find(|stage| stage.l == l) {
                    Some(stage) => stage.parts.extend(weighted),
                    None => stages.push(Stage { l, parts: weighted.collect() }),
                }
            }
        }
        Self { stages }
    }

    /// The weights of a part at all its points.
    pub(crate) fn weights_of(&self, part: Part) -> impl Iterator<Item = Rational> {
        let parts = self.stages.iter().flat_map(|stage| &stage.parts);
        parts.filter(move |(known, _)| *known == part).map(|&(_, weight)| weight)
    }

    /// Whether `P` follows explicitly from the momenta at both ends: `v` is a multiple of their difference,
    /// or zero.
    pub(crate) fn gives_momentum(&self) -> bool {
        self.momentum_update().is_some() || self.stages.iter().all(|stage| stage.l.is_one())
    }

    /// `p_{i+1} - p_i` as a multiple of `v = P - p_i`: with one quadrature point, `v = -(1 - l) F_q` and
    /// `p_{i+1} - P = -l F_q`.
    pub(crate) fn momentum_update(&self) -> Option<Rational> {
        match self.stages.as_slice() {
            [only] => only.start().recip(),
            _ => None,
        }
    }
}
