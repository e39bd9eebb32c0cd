//! Forces: the powers that change the energy, the defect of noise forces, commutators.

use super::{all, is_affine, known};
use crate::discretise::{Increments, Space, Sum, Weighted};
use crate::model::Half;
use crate::symbolic::{Graph, Knowledge, Rational};

/// Covectors, as linear functions of displacements.
pub(super) struct Forces {
    /// Beside the drift.
    pub(super) force: Sum,
    /// The friction that a thermostat applies, not a force of the step: `δq · G p`.
    pub(super) friction: Sum,
    pub(super) is_matrix: bool,
    /// Whether a bath has a temperature.
    pub(super) is_warm: bool,
    /// Noise forces times their increments.
    pub(super) noise: Vec<Sum>,
    /// The suffix of `F` for each noise force.
    pub(super) numbers: Vec<String>,
}

impl Forces {
    pub(super) fn are_absent(&self) -> bool {
        self.force.is_empty() && self.friction.is_empty() && self.noise.is_empty()
    }

    /// All forces, with their names.
    fn named(&self) -> impl Iterator<Item = (String, &Sum)> {
        let force = Some(("F0".to_owned(), &self.force)).filter(|(_, sum)| !sum.is_empty());
        let name = if self.is_matrix { "damping" } else { "friction" };
        let friction = Some((name.to_owned(), &self.friction)).filter(|(_, sum)| !sum.is_empty());
        let noise = self.numbers.iter().zip(&self.noise);
        force.into_iter().chain(friction).chain(noise.map(|(number, sum)| (format!("F{number}"), sum)))
    }

    /// `f · ∂H_0/∂p` of each force.
    pub(super) fn powers(
        &self,
        graph: &mut Graph,
        space: &mut Space,
        drift: &Sum,
    ) -> Vec<(String, Option<Sum>)> {
        self.named().map(|(name, force)| (name, along(graph, space, force, drift))).collect()
    }

    /// `Σ_k (f_k · ∂/∂p) f_k` of noise forces: with `dp = f(p) ∘ dW`, `p' = p + f(p + (1 - l) (p' - p)) ΔW` is
    /// `p + f ΔW + (1 - l) f' f ΔW²` to the relevant order, whereas the Stratonovich system has `1/2` instead
    /// of `1 - l`.
    pub(super) fn defect(&self, graph: &mut Graph, space: &mut Space) -> Option<Sum> {
        let all: Sum = self.noise.concat();
        let (displaced, momenta) = (Half::Displacements, Half::Momenta);
        space.contract(graph, (&all, displaced), (&all, momenta), Increments::Diagonal)
    }
}

/// `f · ∂F/∂p`
pub(super) fn along(graph: &mut Graph, space: &mut Space, force: &Sum, function: &Sum) -> Option<Sum> {
    let (displaced, momenta) = (Half::Displacements, Half::Momenta);
    space.contract(graph, (force, displaced), (function, momenta), Increments::Each)
}

/// The commutators of `X_f = f · ∂/∂p`:
///
/// ```text
/// [X_f, X_g] = (f · ∂g/∂p - g · ∂f/∂p) · ∂/∂p
/// [X_H, X_f] = -(f · H_pp) · ∂/∂q + (H_p · ∂f/∂q - H_q · ∂f/∂p + f · H_pq) · ∂/∂p
/// ```
///
/// The second is known if `H_pp` and `H_pq` vanish.
pub(super) fn commuting_forces(
    graph: &mut Graph,
    space: &mut Space,
    noise: &[Sum],
    forces: &[Sum],
) -> Knowledge {
    let (q, p, displaced) = (Half::Coordinates, Half::Momenta, Half::Displacements);
    let mut statements = Vec::new();
    let mut state = |graph: &mut Graph, space: &mut Space, one: Option<Sum>, other: Option<Sum>| {
        let both = one.zip(other);
        let difference = both.map(|(one, other)| {
            space.combine(graph, &[(&one, Rational::ONE), (&other, Rational::MINUS_ONE)])
        });
        statements.push(known(&difference, |sum| space.vanishes(graph, sum, Increments::Each)));
    };
    for (k, first) in forces.iter().enumerate() {
        for second in &forces[..=k] {
            let one = space.contract(graph, (first, displaced), (second, p), Increments::Each);
            let other = space.contract(graph, (second, displaced), (first, p), Increments::Each);
            state(graph, space, one, other);
        }
    }
    let mut is_undecided = false;
    for hamiltonian in noise {
        let is_flat =
            |weighted: &Weighted| !weighted.element.reads().p || is_affine(graph, &weighted.element);
        is_undecided |= !forces.is_empty() && !hamiltonian.iter().all(is_flat);
        for force in forces {
            let one = space.contract(graph, (hamiltonian, p), (force, q), Increments::Each);
            let other = space.contract(graph, (hamiltonian, q), (force, p), Increments::Each);
            state(graph, space, one, other);
        }
    }
    if is_undecided {
        let reason = "commutators of noise forces with noises that read momenta are not taken".to_owned();
        statements.push(Knowledge::Unknown(reason));
    }
    all(statements)
}
