//! The points at which the discrete Lagrangian evaluates each role: the common source of the straight-line
//! step, the sweep over elements and the text.
//!
//! ```text
//! L_d = P · u - Σ_s Σ_m w_m F_m(P, Q_s, T_s),   u = q_{i+1} - q_i
//! Q_s = q_i + l u,   ∂Q_s/∂q_i = 1 - l,   ∂Q_s/∂q_{i+1} = l,   T_s = t_i + l h
//! ```
//!
//! The terms `F_m` of the step Hamiltonian differ in their [roles](Role) and increments, and are evaluated at
//! one point or [several](crate::embedding::Points). A force is not part of `L_d` but does virtual work at
//! its stage: by the Lagrange-d'Alembert principle `∂F/∂q - f` replaces `∂F/∂q` (J. E. Marsden, M. West,
//! "Discrete mechanics and variational integrators", Acta Numerica 2001, section 3.2). `Corrected` adds the
//! increment form of the counter-term, at the quadrature points of the noise.
//!
//! Tests: `tests/steps/quadrature.rs`.

use super::facts::{Facts, NoiseClass};
use super::roles::Role;
use crate::diagnostics::promised;
use crate::embedding::{Correction, Embedding};
use crate::symbolic::Rational;

const EXACT: &str = "what follows from quadrature points was looked at where they were read";

/// A quadrature point `l`, and the roles evaluated there with their weights.
#[derive(Clone, Debug)]
pub(crate) struct Stage {
    pub(crate) l: Rational,
    pub(crate) roles: Vec<(Role, Rational)>,
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
        let mut of_drift = vec![(Role::Drift, Rational::ONE)];
        if facts.has_force {
            of_drift.push((Role::Force, Rational::ONE));
        }
        let mut of_noise = Vec::new();
        if facts.noise != NoiseClass::None {
            of_noise.push((Role::Noise, Rational::ONE));
        }
        if corrects {
            of_noise.push((Role::CounterTerm, promised(Rational::HALF.add(mean.negate()), EXACT)));
        }
        let mut stages: Vec<Stage> = Vec::new();
        for (points, roles) in [(drift, of_drift), (noise, of_noise)] {
            if roles.is_empty() {
                continue;
            }
            for (l, share) in points.iter() {
                let weighted =
                    roles.iter().map(|&(role, weight)| (role, promised(weight.multiply(share), EXACT)));
                match stages.iter_mut().find(|stage| stage.l == l) {
                    Some(stage) => stage.roles.extend(weighted),
                    None => stages.push(Stage { l, roles: weighted.collect() }),
                }
            }
        }
        Self { stages }
    }

    /// The weights of a role at all its points.
    pub(crate) fn weights_of(&self, role: Role) -> impl Iterator<Item = Rational> {
        let roles = self.stages.iter().flat_map(|stage| &stage.roles);
        roles.filter(move |(known, _)| *known == role).map(|&(_, weight)| weight)
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
