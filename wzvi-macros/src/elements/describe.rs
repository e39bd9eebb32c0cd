//! The derivation as text: sums and indices instead of components.

mod sweep;

use std::fmt::Write;

use super::plan::Strategy;
use crate::diagnostics::internal::Promised;
use crate::discretise::describe::properties;
use crate::discretise::facts::Facts;
use crate::embedding::Embedding;
use crate::model::display::{Names, letter_at};
use crate::model::index::Index;
use crate::model::{Element, Noise, System};

/// The name of a loop variable of `element`, by its nesting.
fn letter(element: &Element, variable: u32) -> &'static str {
    let depth = element.loops.iter().position(|known| known.variable == variable);
    depth.map_or("k", letter_at)
}

/// An index in the loops of `element`.
pub(crate) fn index_in(system: &System, element: &Element, index: &Index) -> String {
    Names { tables: &system.tables, letter: &|variable| letter(element, variable) }.index(index)
}

/// `Σ_{i=0}^{n-1} (...)`
fn element(model: &System, element: &Element) -> String {
    let mut text = String::new();
    for known in &element.loops {
        let last = known.end.shifted(-1).promised("ends of loops are integers");
        let (start, last) = (index_in(model, element, &known.start), index_in(model, element, &last));
        let _ = write!(text, "Σ_({}={start}..{last}) ", letter(element, known.variable));
    }
    let _ = write!(text, "[{}]", model.graph.display(element.value));
    text
}

fn term(model: &System, elements: &[Element]) -> String {
    let parts: Vec<String> = elements.iter().map(|part| element(model, part)).collect();
    if parts.is_empty() { "0".to_owned() } else { parts.join(" + ") }
}

/// Every Hamiltonian.
pub(crate) fn hamiltonians(model: &System) -> String {
    let mut text = "Hamiltonians, as sums of elements\n".to_owned();
    let _ = writeln!(text, "  H0 = {}", term(model, &model.drift.elements));
    for (name, part) in ["H_A", "H_B"].iter().zip(&model.parts) {
        let _ = writeln!(text, "  {name} = {}, a part of H0", term(model, &part.elements));
    }
    let is_listed = |noise: &&(String, &Noise)| !noise.1.is_force;
    let noise: Vec<(String, &Noise)> = model.noise_numbers().into_iter().zip(&model.noise).collect();
    for (number, noise) in noise.iter().filter(is_listed) {
        let _ = writeln!(text, "  H{number} = {}", term(model, &noise.term.elements));
    }
    let forces = noise.iter().filter(|noise| !is_listed(noise));
    let forces = forces.map(|(number, noise)| (format!("F{number} · δ{}", model.names[0]), &noise.term));
    let force = model.force.iter().map(|force| (format!("F0 · δ{}", model.names[0]), force));
    let forces: Vec<_> = force.chain(forces).collect();
    if !forces.is_empty() {
        text.push_str("Forces, as virtual work\n");
    }
    for (name, force) in forces {
        let _ = writeln!(text, "  {name} = {}", term(model, &force.elements));
    }
    if let Some(rate) = model.conformal {
        let _ = writeln!(text, "Friction\n  γ = {}", model.graph.display(rate));
    }
    text
}

/// The text of one scheme.
pub(crate) fn describe(
    model: &mut System,
    facts: &Facts,
    embedding: &Embedding,
    strategy: Strategy,
) -> String {
    let mut text = format!("{embedding}\n\n{}", hamiltonians(model));
    sweep::sweep(model, facts, embedding, strategy, &mut text);
    properties(&mut model.graph, facts, embedding, &mut text);
    text
}
