//! Refuses what the mathematics contradicts: inconsistent bare schemes, declared first integrals that are not
//! conserved, drifts and words without flows.
//!
//! Every refusal of the compiler is in `diagnostics`, nearly all as rows of tables: `messages` about
//! declarations, which `input`, `lower` and `functions` report; `expressions` about Rust that `lower` and
//! `collect` cannot make terms of; `ito` about the conversion; and `facts` about the mathematics. The last
//! are reported here, but for those of friction and temperature, which `passes/friction.rs` checks before
//! friction becomes a force. Syntax that is no Rust is refused by syn.

use crate::diagnostics::{Diagnostics, Located, facts as messages};
use crate::discretise::{Facts, Failure, Invariant, KnownSum};
use crate::embedding::{Correction, Embedding};
use crate::model::System;
use crate::symbolic::{Graph, Rational};

/// Every check, in order; all of them report.
pub(crate) fn check(system: &mut System, facts: &Facts, diagnostics: &mut Diagnostics) {
    let System { graph, embeddings, .. } = system;
    check_consistency(graph, embeddings, facts, diagnostics);
    check_invariants(graph, facts, diagnostics);
    check_parts(system, facts, diagnostics);
    check_flows(system, facts, diagnostics);
}

/// A bare scheme must converge to the Stratonovich system, for which `D = (1/2 - l) Σ_k ∂H_k/∂q · ∂H_k/∂p`
/// must be constant; a corrected one needs its counter-term.
fn check_consistency(
    graph: &mut Graph,
    embeddings: &[Located<Embedding>],
    facts: &Facts,
    diagnostics: &mut Diagnostics,
) {
    for Located { value: scheme, extent } in embeddings {
        let [_, noise_l] = scheme.means();
        let error = match scheme.correction() {
            Correction::Bare if !facts.is_consistent(noise_l) => {
                let defect = facts.defect(graph, &facts.noise_contraction, noise_l);
                if facts.force_defect_acts(noise_l) {
                    let force = facts.defect(graph, &facts.force_contraction, noise_l);
                    let hamiltonian = match defect.as_str() {
                        "0" => String::new(),
                        defect => format!(", and drift Hamiltonian H0 - D, D = {defect}"),
                    };
                    messages::inconsistent_forces(*extent, scheme, &hamiltonian, &force)
                } else {
                    messages::inconsistent(*extent, scheme, &defect, &facts.noise_contraction.known)
                }
            }
            Correction::Corrected if facts.force_defect_acts(noise_l) => {
                messages::correction_of_forces(*extent, scheme)
            }
            Correction::Corrected if facts.counter_term_acts(noise_l) && facts.counter_term.sum.is_none() => {
                messages::counter_term_of_elements(*extent, scheme)
            }
            _ => continue,
        };
        diagnostics.report(error);
    }
}

/// `{H_m, F}` must vanish for every term; for the drift, `∂F/∂t` and the rates by forces are added.
fn check_invariants(graph: &mut Graph, facts: &Facts, diagnostics: &mut Diagnostics) {
    for Invariant { extent, failure, .. } in &facts.invariants {
        if let Some(Failure { along, found: KnownSum { sum, known } }) = failure {
            let rate = sum.as_ref().map(|rate| facts.space.display(graph, rate, Rational::ONE));
            diagnostics.report(messages::no_invariant(*extent, along, rate.as_deref(), known, graph));
        }
    }
}

/// Each part of `drift = [H_A, H_B]` has a known flow, and forces and friction belong to one of them.
fn check_parts(system: &System, facts: &Facts, diagnostics: &mut Diagnostics) {
    for (part, form) in system.summands.iter().zip(&facts.summands.forms) {
        if let Err(reason) = form {
            diagnostics.report(messages::part_without_flow(part.extent, reason));
        }
    }
    if let Err((extent, reason)) = facts.summands.assignment {
        diagnostics.report(messages::acts_in_no_part(extent, reason, &system.converted_force()));
    }
}

/// `Baoab` and the like are made of the flows of `T(p)` and `V(q, t)`.
fn check_flows(system: &System, facts: &Facts, diagnostics: &mut Diagnostics) {
    if facts.flows.is_none() {
        let words = system.embeddings.iter().filter(|known| known.value.is_word());
        for Located { value, extent } in words {
            diagnostics.report(messages::word_without_flows(*extent, value, &system.converted_force()));
        }
    }
}
