//! The derivation as text: sums and indices instead of components.

mod sweep;

use std::fmt::Write;

use super::plan::Strategy;
use crate::diagnostics::internal::Promised;
use crate::discretise::Scheme;
use crate::discretise::describe::{derivation, properties};
use crate::discretise::embedding::Embedding;
use crate::discretise::facts::Facts;
use crate::model::index::{Atom, Index};
use crate::model::{Element, Noise, System, Table};

const LETTERS: [&str; 6] = ["i", "j", "k", "l", "m", "n"];

/// An index for a reader.
pub(crate) fn index<'a>(
    index: &Index,
    table: &dyn Fn(u32) -> &'a str,
    letter: &dyn Fn(u32) -> &'a str,
) -> String {
    let mut text = String::new();
    for (atom, coefficient) in &index.terms {
        let inner = |part: &Index| self::index(part, table, letter);
        let operand = |part: &Index| match (part.terms.as_slice(), part.constant) {
            ([(_, 1)], 0) | ([], 0..) => inner(part),
            _ => format!("({})", inner(part)),
        };
        let two =
            |both: &(Index, Index), sign: &str| format!("{}{sign}{}", operand(&both.0), operand(&both.1));
        let two_of =
            |both: &(Index, Index), name: &str| format!("{name}({}, {})", inner(&both.0), inner(&both.1));
        let atom = match atom {
            Atom::Loop(variable) => letter(*variable).to_owned(),
            Atom::Size => "n".to_owned(),
            Atom::Given(id, indices) => {
                let indices: Vec<String> = indices.iter().map(|i| format!("[{}]", inner(i))).collect();
                format!("{}{}", table(*id), indices.concat())
            }
            Atom::Product(both) => two(both, " * "),
            Atom::Quotient(both) => format!("({})", two(both, " / ")),
            Atom::Remainder(both) => format!("({} mod {})", operand(&both.0), operand(&both.1)),
            Atom::Minimum(both) => two_of(both, "min"),
            Atom::Maximum(both) => two_of(both, "max"),
        };
        let sign = match (text.is_empty(), *coefficient < 0) {
            (true, false) => "",
            (true, true) => "-",
            (false, false) => " + ",
            (false, true) => " - ",
        };
        let size = coefficient.unsigned_abs();
        let _ = if size == 1 { write!(text, "{sign}{atom}") } else { write!(text, "{sign}{size} {atom}") };
    }
    let constant = index.constant;
    let _ = match (text.is_empty(), constant) {
        (true, constant) => write!(text, "{constant}"),
        (false, 0) => Ok(()),
        (false, constant) if constant < 0 => write!(text, " - {}", constant.unsigned_abs()),
        (false, constant) => write!(text, " + {constant}"),
    };
    text
}

/// The name of a loop variable of `element`, by its nesting.
fn letter(element: &Element, variable: u32) -> &'static str {
    let depth = element.loops.iter().position(|known| known.variable == variable);
    depth.map_or("k", |depth| LETTERS[depth.min(LETTERS.len() - 1)])
}

/// An index in the loops of `element`.
pub(crate) fn index_in(system: &System, element: &Element, index: &Index) -> String {
    let tables: &[Table] = &system.tables;
    let table = |id: u32| tables.get(id as usize).map_or("?", |table| table.name.as_str());
    self::index(index, &table, &|variable| letter(element, variable))
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

/// The number of each noise as it is written behind `H`: `_k` for the members of a family, after the noises before it.
pub(crate) fn noise_numbers(model: &System) -> Vec<String> {
    let table = |id: u32| model.tables.get(id as usize).map_or("?", |table| table.name.as_str());
    let numbers = model.noise.iter().zip(model.noise_offsets()).map(|(noise, offset)| {
        let first = offset.shifted(1).promised("numbers of noises are integers");
        match (&noise.family, offset.as_integer()) {
            (None, Some(_)) => index(&first, &table, &|_| "k"),
            (None, None) => format!("_({})", index(&first, &table, &|_| "k")),
            (Some(_), Some(0)) => "_k".to_owned(),
            (Some(_), _) => format!("_(k + {})", index(&offset, &table, &|_| "k")),
        }
    });
    numbers.collect()
}

/// Every Hamiltonian.
pub(crate) fn hamiltonians(model: &System) -> String {
    let mut text = "Hamiltonians, as sums of elements\n".to_owned();
    let _ = writeln!(text, "  H0 = {}", term(model, &model.drift.elements));
    for (name, part) in ["H_A", "H_B"].iter().zip(&model.parts) {
        let _ = writeln!(text, "  {name} = {}, a part of H0", term(model, &part.elements));
    }
    let is_listed = |noise: &&(String, &Noise)| !noise.1.is_force;
    let noise: Vec<(String, &Noise)> = noise_numbers(model).into_iter().zip(&model.noise).collect();
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
    strategy: &Strategy,
) -> String {
    let mut text = format!("{embedding}\n\n{}", hamiltonians(model));
    match strategy {
        Strategy::Sweep { unknowns, is_linear } => {
            sweep::sweep(model, facts, embedding, (*unknowns, *is_linear), &mut text);
        }
        Strategy::Sites(_, scheme) => sites(model, scheme, &mut text),
    }
    properties(&mut model.graph, facts, embedding, &mut text);
    text
}

/// The equations of one site, which are those of all.
fn sites(model: &mut System, scheme: &Scheme, text: &mut String) {
    let last = model.size.shifted(-1).promised("sizes are integers");
    let table = |id: u32| model.tables.get(id as usize).map_or("?", |table| table.name.as_str());
    let last = index(&last, &table, &|_| "k");
    let _ = writeln!(text, "\nThe sites k = 0..{last} are not coupled: each is a system of its own");
    derivation(&mut model.graph, scheme, text);
}
