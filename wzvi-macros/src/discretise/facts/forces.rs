//! Forces: the powers that change the energy, the defect of noise forces, commutators. Tests: `tests/forces`.

use super::{all, is_affine};
use crate::discretise::{Calculus, Increments, KnownSum, Sum, Weighted};
use crate::model::Half;
use crate::symbolic::Knowledge;

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
    /// All forces, with what is said of their powers; nothing of a damping matrix, whose product here is with
    /// momenta, not with velocities.
    fn named(&self) -> impl Iterator<Item = (Option<String>, &Sum)> {
        let powers = |number: &str| Some(format!("F{number} · ∂H0/∂p ="));
        let friction = (!self.is_matrix).then(|| "friction takes from H0 per unit of time:".to_owned());
        let others = [(powers("0"), &self.force), (friction, &self.friction)];
        let others = others.into_iter().filter(|(_, sum)| !sum.is_empty());
        others.chain(self.numbers.iter().map(move |number| powers(number)).zip(&self.noise))
    }

    /// `f · ∂H_0/∂p` of each force.
    pub(super) fn powers(&self, sums: &mut Calculus<'_>, drift: &Sum) -> Vec<(Option<String>, KnownSum)> {
        let powers = self.named().map(|(name, force)| {
            let power = along(sums, force, drift);
            (name, sums.vanishes(power, Increments::Each))
        });
        powers.collect()
    }

    /// `Σ_k (f_k · ∂/∂p) f_k` of noise forces: with `dp = f(p) ∘ dW`, `p' = p + f(p + (1 - l) (p' - p)) ΔW`
    /// is `p + f ΔW + (1 - l) f' f ΔW²` to the relevant order, whereas the Stratonovich system has `1/2`
    /// instead of `1 - l`.
    pub(super) fn defect(&self, sums: &mut Calculus<'_>) -> KnownSum {
        let (all, increments) = (self.noise.concat(), Increments::Diagonal);
        let defect = sums.contract((&all, Half::Displacements), (&all, Half::Momenta), increments);
        sums.vanishes(defect, increments)
    }
}

/// `f · ∂F/∂p`
pub(super) fn along(sums: &mut Calculus<'_>, force: &Sum, function: &Sum) -> Option<Sum> {
    sums.contract((force, Half::Displacements), (function, Half::Momenta), Increments::Each)
}

/// The commutators of `X_f = f · ∂/∂p`:
///
/// ```text
/// [X_f, X_g] = (f · ∂g/∂p - g · ∂f/∂p) · ∂/∂p
/// [X_H, X_f] = -(f · H_pp) · ∂/∂q + (H_p · ∂f/∂q - H_q · ∂f/∂p + f · H_pq) · ∂/∂p
/// ```
///
/// The second is known if `H_pp` and `H_pq` vanish.
pub(super) fn commuting_forces(sums: &mut Calculus<'_>, noise: &[Sum], forces: &[Sum]) -> Knowledge {
    let (q, p, displaced) = (Half::Coordinates, Half::Momenta, Half::Displacements);
    let mut statements = Vec::new();
    let mut state = |sums: &mut Calculus<'_>, (f, by_f, and_g): (&Sum, Half, Half), (g, by_g, and_f)| {
        let one = sums.contract((f, by_f), (g, by_g), Increments::Each);
        let other = sums.contract((f, and_g), (g, and_f), Increments::Each);
        let difference = sums.difference(one, other);
        statements.push(sums.vanishes(difference, Increments::Each).known);
    };
    for (k, first) in forces.iter().enumerate() {
        for second in &forces[..=k] {
            state(sums, (first, displaced, p), (second, p, displaced));
        }
    }
    let mut is_undecided = false;
    for hamiltonian in noise {
        let is_flat =
            |weighted: &Weighted| !weighted.element.reads().p || is_affine(sums.graph, &weighted.element);
        is_undecided |= !forces.is_empty() && !hamiltonian.iter().all(is_flat);
        for force in forces {
            state(sums, (hamiltonian, p, q), (force, q, p));
        }
    }
    if is_undecided {
        let reason = "commutators of noise forces with noises that read momenta are not taken".to_owned();
        statements.push(Knowledge::Unknown(reason));
    }
    all(statements)
}
