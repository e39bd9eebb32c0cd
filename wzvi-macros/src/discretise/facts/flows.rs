//! Whether the step Hamiltonian is `T(p) + V(q, t)`, whose two flows are known: drift and kick.

use super::kinetic::Kinetic;
use crate::model::{Element, System};

/// Properties of `T(p) + V(q, t)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flows {
    /// Whether `T` is a quadratic form with constant coefficients.
    pub(crate) is_nystrom: bool,
    pub(crate) force_reads_time: bool,
}

impl Flows {
    /// `None` if kicks and drifts are not flows: a term has a momentum together with a coordinate or with the
    /// time, which is constant during a drift, or friction is part of the step. `Verlet` is then computed as
    /// its two halves.
    pub(super) fn of(system: &System, is_separable: bool, is_nystrom: bool) -> Option<Self> {
        if !is_separable || system.conformal.is_some() {
            return None;
        }
        let timed = system.acting().filter(|element| element.reads_time(&system.graph, system.t));
        let timed: Vec<&Element> = timed.collect();
        if timed.iter().any(|element| element.reads().p) {
            return None;
        }
        // A force of time alone acts on the momenta like one that reads coordinates.
        let force_reads_time = timed.iter().any(|element| element.reads().q || element.is_covector());
        Some(Self { is_nystrom, force_reads_time })
    }
}

/// Whether the step Hamiltonian is a constant quadratic form of the momenta plus a function of coordinates
/// and time, and forces read no more.
pub(super) fn is_nystrom(system: &System, is_separable: bool, kinetic: Option<Kinetic>) -> bool {
    let is_noisy = system.noise.iter().flat_map(|noise| &noise.term.elements).any(|e| e.reads().p);
    is_separable && !is_noisy && system.conformal.is_none() && kinetic.is_some()
}
