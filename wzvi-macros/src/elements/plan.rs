//! Which unknowns a scheme iterates on. With `u = Δq`, `v = P - p_i`, the discrete Euler-Lagrange equations are
//!
//! ```text
//! u = Σ_m c_m ∂H_m/∂p(P, Q_m),   v = -Σ_m (1 - l_m) c_m ∂H_m/∂q(P, Q_m),   Q_m = q_i + l_m u,   P = p_i + v
//! ```
//!
//! | structure | unknowns |
//! |---|---|
//! | `H = T(p) + V(q)`, every `l_m` of a term with `V` is 0 or 1 | none |
//! | `H = T(p) + V(q)`, `T''` diagonal | `v`: `u` follows from it |
//! | every `l_m` is 0 | `v`: it is read nowhere else |
//! | otherwise | `u` and `v` |

use crate::discretise::embedding::Embedding;
use crate::discretise::facts::Facts;
use crate::model::{Element, Reads, System};
use crate::symbolic::Rational;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Unknowns {
    None,
    Momenta,
    Both,
}

pub(crate) fn unknowns(model: &System, facts: &Facts, embedding: &Embedding) -> Unknowns {
    let (drift_l, noise_l) = embedding.quadrature();
    let reads_q = |elements: &[Element]| {
        elements.iter().any(|element| matches!(element.reads(), Reads::Coordinates | Reads::Both))
    };
    let at_node = |l: Rational| l.is_zero() || l.is_one();
    let drift_at_node = at_node(drift_l) || !reads_q(&model.drift.elements);
    let noise_at_node = at_node(noise_l) || model.noise.iter().all(|noise| !reads_q(&noise.term.elements));
    let all_at_start = drift_l.is_zero() && (noise_l.is_zero() || model.noise.is_empty());
    // The counter-term reads coordinates and momenta.
    let is_separable = facts.is_separable && facts.counter_of(embedding).is_empty();
    if is_separable && drift_at_node && noise_at_node {
        Unknowns::None
    } else if (is_separable && facts.has_diagonal_kinetic_energy) || all_at_start {
        Unknowns::Momenta
    } else {
        Unknowns::Both
    }
}
