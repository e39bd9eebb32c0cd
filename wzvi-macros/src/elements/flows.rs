//! Whether the step Hamiltonian is `T(p) + V(q, t)`, whose two flows are known: drift and kick.

use super::staged::is_nystrom;
use crate::discretise::embedding::Embedding;
use crate::discretise::facts::Facts;
use crate::model::{Reads, System};

/// What is known of `T(p) + V(q, t)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flows {
    /// Whether `T` is a quadratic form with constant coefficients.
    pub(crate) is_nystrom: bool,
    pub(crate) force_reads_time: bool,
}

impl Flows {
    /// `None` where `Verlet` is not listed, or has to be taken as its two halves: no momentum may meet a coordinate, or the time, which
    /// stands still while momenta drift.
    pub(crate) fn of(system: &mut System, facts: &Facts, listed: &[Embedding]) -> Option<Self> {
        if !facts.is_separable || !listed.contains(&Embedding::Verlet) {
            return None;
        }
        let noise = system.noise.iter().flat_map(|noise| &noise.term.elements);
        let timed = system
            .drift
            .elements
            .iter()
            .chain(noise)
            .filter(|e| system.graph.depends_on(e.value, &[system.t]));
        let read: Vec<Reads> = timed.map(|element| element.reads()).collect();
        if read.contains(&Reads::Momenta) {
            return None;
        }
        let force_reads_time = read.contains(&Reads::Coordinates);
        Some(Self { is_nystrom: is_nystrom(system, facts), force_reads_time })
    }
}
