//! From the analysed system to code: discretise, describe, emit.

use crate::describe::{Texts, derived};
use crate::diagnostics::Located;
use crate::discretise::facts::Facts;
use crate::elements::plan::Step;
use crate::embedding::Embedding;
use crate::emit::{Expansion, emit};
use crate::model::System;
use crate::passes::unroll::written_out;

/// The struct with everything that the compiler gives it: terms and steps as straight lines, or in loops.
pub(crate) fn generate(system: &mut System, facts: &Facts) -> Expansion {
    let line = written_out(system);
    let (line, listed) = (line.as_ref(), values(&system.embeddings));
    let steps: Vec<Step<'_>> =
        derived(&listed).iter().map(|embedding| Step::of(system, line, facts, embedding)).collect();
    let texts = Texts::new(system, line, facts, &listed, &steps);
    emit(system, line, facts, &steps, &texts)
}

/// The schemes, and those inside of thermostats.
fn values(embeddings: &[Located<Embedding>]) -> Vec<Embedding> {
    let mut values = Vec::new();
    for Located { value, .. } in embeddings {
        if let Embedding::Thermostat(inner) = value {
            values.push(Embedding::Isolated(inner.clone()));
        }
        values.push(value.clone());
    }
    values
}
