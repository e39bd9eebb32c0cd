//! What the mathematics forbids: inconsistent schemes that were not asked for, first integrals that are none.

use crate::diagnostics::{Diagnostics, facts as messages};
use crate::discretise::embedding::Correction;
use crate::discretise::facts::{Facts, Invariant};
use crate::model::Model;

/// Every check, in order; all of them report.
pub(crate) fn check(model: &mut Model, facts: &Facts, diagnostics: &mut Diagnostics) {
    check_consistency(model, facts, diagnostics);
    check_invariants(model, facts, diagnostics);
}

/// A bare scheme must converge to the Stratonovich system (MATH section 3).
fn check_consistency(model: &mut Model, facts: &Facts, diagnostics: &mut Diagnostics) {
    for embedding in &model.embeddings {
        let noise_l = embedding.value.quadrature().1;
        if embedding.value.correction() == Correction::Bare && !facts.is_consistent(noise_l) {
            let defect = facts.defect(&mut model.graph, noise_l);
            let defect = model.graph.display(defect);
            diagnostics.report(messages::inconsistent(embedding, &defect, &facts.defect_is_constant));
        }
    }
}

/// `{H_m, F}` must vanish for every term, with `∂F/∂t` for the drift.
fn check_invariants(model: &Model, facts: &Facts, diagnostics: &mut Diagnostics) {
    for Invariant { declared, failure, .. } in &facts.invariants {
        if let Some((term, rate, knowledge)) = failure {
            let rate = model.graph.display(*rate);
            diagnostics.report(messages::no_invariant(
                declared.extent,
                *term,
                &rate,
                knowledge,
                &model.graph,
            ));
        }
    }
}
