//! Whether the step Hamiltonian is `T(p) + V(q, t)`, whose two flows are known: drift and kick.

use super::Facts;
use super::kinetic::Kinetic;
use crate::embedding::Embedding;
use crate::model::{Element, System};

/// Properties of `T(p) + V(q, t)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flows {
    /// Whether `T` is a quadratic form with constant coefficients.
    pub(crate) is_nystrom: bool,
    pub(crate) force_reads_time: bool,
}

impl Flows {
    /// `None` if `Verlet` is not listed, or must be computed as its two halves. Flows require that no term
    /// has a momentum together with a coordinate or with the time, which is constant during a drift.
    pub(crate) fn of(system: &mut System, facts: &Facts, listed: &[Embedding]) -> Option<Self> {
        let is_wanted = listed.iter().any(Embedding::takes_flows);
        if !facts.is_separable || !is_wanted || system.conformal.is_some() {
            return None;
        }
        let timed = system.acting().filter(|element| system.graph.depends_on(element.value, &[system.t]));
        let timed: Vec<&Element> = timed.collect();
        if timed.iter().any(|element| element.reads().p) {
            return None;
        }
        // A force of time alone acts on the momenta like one that reads coordinates.
        let force_reads_time = timed.iter().any(|element| element.reads().q || element.is_covector());
        Some(Self { is_nystrom: is_nystrom(system, facts), force_reads_time })
    }
}

/// Whether the step Hamiltonian is a constant quadratic form of the momenta plus a function of coordinates
/// and time, and forces read no more.
pub(crate) fn is_nystrom(model: &mut System, facts: &Facts) -> bool {
    let is_noisy = model.noise.iter().flat_map(|noise| &noise.term.elements).any(|e| e.reads().p);
    facts.is_separable && !is_noisy && model.conformal.is_none() && Kinetic::of(model).is_some()
}
