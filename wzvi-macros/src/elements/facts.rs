//! What can be said about a system of elements, by its structure: what each element reads decides; where that does not,
//! the answer is "unknown".

use super::counter::{Counter, counter_term};
use super::invariants::{self, Failure};
use crate::diagnostics::facts as messages;
use crate::discretise::embedding::{Correction, Embedding};
use crate::discretise::facts::{Knowledge, NoiseClass};
use crate::model::{Element, Reads, System};
use crate::symbolic::{Graph, Rational, Symbol};

/// Facts about one model, shared by all its schemes.
pub(crate) struct Facts {
    pub(crate) noise: NoiseClass,
    /// Whether no element reads coordinates and momenta.
    pub(crate) is_separable: bool,
    /// Whether no element couples two momenta.
    pub(crate) has_diagonal_kinetic_energy: bool,
    /// Whether `∂H_k/∂q · ∂H_k/∂p` vanishes for every noise: each reads only coordinates or only momenta.
    pub(crate) has_no_defect: bool,
    /// The counter-term of `Corrected`: empty if it does nothing, `None` if it is no sum of elements.
    pub(crate) counter: Option<Vec<Counter>>,
    pub(crate) conserves_energy: Knowledge,
    pub(crate) commuting: Knowledge,
}

impl Facts {
    pub(crate) fn new(model: &mut System) -> Self {
        let counter = counter_term(model);
        let System { graph, drift, noise: noises, t, .. } = model;
        let noises = &*noises;
        let noise_elements = || noises.iter().flat_map(|noise| &noise.term.elements);
        let all = || drift.elements.iter().chain(noise_elements());
        let has_diagonal_kinetic_energy =
            all().filter(|e| e.reads() == Reads::Momenta).all(|element| is_diagonal(graph, element));
        let reads_only =
            |reads: Reads| noise_elements().all(|element| [reads, Reads::Nothing].contains(&element.reads()));
        let (only_q, only_p) = (reads_only(Reads::Coordinates), reads_only(Reads::Momenta));
        let has_no_defect = noises.iter().all(|noise| {
            let reads: Vec<Reads> = noise.term.elements.iter().map(Element::reads).collect();
            let reads_none = |other: Reads| !reads.contains(&other) && !reads.contains(&Reads::Both);
            reads_none(Reads::Coordinates) || reads_none(Reads::Momenta)
        });
        let is_affine = noise_elements().all(|element| is_affine(graph, element));
        let noise = if noises.is_empty() {
            NoiseClass::None
        } else if is_affine {
            NoiseClass::Additive
        } else if only_q {
            NoiseClass::Position
        } else if only_p {
            NoiseClass::Momentum
        } else {
            NoiseClass::Multiplicative
        };
        let reads_time = drift.elements.iter().any(|element| graph.depends_on(element.value, &[*t]));
        let single = noises.len() < 2 && noises.iter().all(|noise| noise.family.is_none());
        let conserves_energy =
            if noises.is_empty() && !reads_time { Knowledge::Proven } else { Knowledge::Unknown };
        let commuting =
            if single || only_q || only_p || is_affine { Knowledge::Proven } else { Knowledge::Unknown };
        Self {
            noise,
            is_separable: all().all(|element| element.reads() != Reads::Both),
            has_diagonal_kinetic_energy,
            has_no_defect: has_no_defect || is_affine,
            counter: if only_q || only_p || is_affine { Some(Vec::new()) } else { counter },
            conserves_energy,
            commuting,
        }
    }

    /// The counter-term that a scheme adds; empty for most.
    pub(crate) fn counter_of(&self, embedding: &Embedding) -> &[Counter] {
        let acts =
            embedding.correction() == Correction::Corrected && embedding.quadrature().1 != Rational::HALF;
        if acts { self.counter.as_deref().unwrap_or_default() } else { &[] }
    }

    /// Whether noises at quadrature point `l` give the Stratonovich limit.
    pub(crate) fn is_consistent(&self, l: Rational) -> bool {
        l == Rational::HALF || self.has_no_defect
    }
}

fn momenta_of(element: &Element) -> Vec<Symbol> {
    element.momenta().map(|(symbol, _)| symbol).collect()
}

fn is_diagonal(graph: &mut Graph, element: &Element) -> bool {
    let momenta = momenta_of(element);
    momenta.iter().all(|&p| {
        let slope = graph.derivative(element.value, p);
        let others: Vec<Symbol> = momenta.iter().copied().filter(|&other| other != p).collect();
        !graph.depends_on(slope, &others)
    })
}

fn is_affine(graph: &mut Graph, element: &Element) -> bool {
    let state: Vec<Symbol> =
        element.coordinates().chain(element.momenta()).map(|(symbol, _)| symbol).collect();
    state.iter().all(|&symbol| {
        let slope = graph.derivative(element.value, symbol);
        !graph.depends_on(slope, &state)
    })
}

/// What the mathematics, or what is supported so far, forbids.
pub(crate) fn check(model: &mut System, facts: &Facts) -> Vec<syn::Error> {
    let mut objections = Vec::new();
    for embedding in &model.embeddings {
        let l = embedding.value.quadrature().1;
        match embedding.value.correction() {
            Correction::Bare if !facts.is_consistent(l) => {
                let defect = "Σ_k (1/2 - l) ∂H_k/∂q · ∂H_k/∂p";
                objections.push(messages::inconsistent(embedding, defect, &Knowledge::Unknown));
            }
            Correction::Corrected if l != Rational::HALF && facts.counter.is_none() => {
                objections.push(messages::counter_term_of_elements(embedding));
            }
            _ => {}
        }
    }
    for number in 0..model.invariants.len() {
        let Some(failure) = invariants::failure(model, number) else { continue };
        let extent = model.invariants[number].extent;
        objections.push(match failure {
            Failure::NotLocal => messages::invariant_not_local(extent),
            Failure::ReadsTime => messages::invariant_reads_time(extent),
            Failure::Rate { term, rate, knowledge } => {
                messages::invariant_of_elements(extent, term, &rate, &knowledge, &model.graph)
            }
        });
    }
    objections
}

/// Whether the limit of the scheme is the Stratonovich system.
pub(crate) fn is_consistent(facts: &Facts, embedding: &Embedding) -> bool {
    embedding.correction() == Correction::Corrected || facts.is_consistent(embedding.quadrature().1)
}
