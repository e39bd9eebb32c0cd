//! The derivation as text: sums and indices instead of components.

mod sweep;

use super::plan::Strategy;
use crate::discretise::describe::{hamiltonians, properties};
use crate::discretise::facts::Facts;
use crate::embedding::Embedding;
use crate::model::System;

/// The text of one scheme.
pub(crate) fn describe(
    model: &mut System,
    facts: &Facts,
    embedding: &Embedding,
    strategy: Strategy,
) -> String {
    let mut text = format!("{embedding}\n{}", hamiltonians(model, None, facts));
    sweep::sweep(model, facts, embedding, strategy, &mut text);
    properties(&mut model.graph, facts, embedding, &mut text);
    text
}
