//! The parts of `drift = [H_A, H_B]`, and whether their flows are known.

use crate::diagnostics::{Diagnostics, facts as messages};
use crate::discretise::facts::is_quadratic;
use crate::model::index::{Atom, Index};
use crate::model::{Reads, System, Term};
use crate::symbolic::{Graph, Symbol};

/// The form of a part of the drift, by which its flow is known.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Form {
    Coordinates,
    Momenta,
    Quadratic,
}

/// The forms of both parts; `None` if the drift has no parts, or one whose flow is not known.
pub(crate) fn forms(system: &mut System) -> Option<[Form; 2]> {
    let mut forms = Vec::new();
    for part in 0..system.parts.len() {
        forms.push(form(system, part).ok()?);
    }
    forms.try_into().ok()
}

/// Reports every part whose flow is not known.
pub(crate) fn check(system: &mut System, diagnostics: &mut Diagnostics) {
    for part in 0..system.parts.len() {
        if let Err(reason) = form(system, part) {
            diagnostics.report(messages::part_without_flow(system.parts[part].extent, reason));
        }
    }
}

fn form(system: &mut System, part: usize) -> Result<Form, &'static str> {
    let System { graph, parts, t, size, noise, force, conformal, .. } = system;
    if part > 0 && (force.is_some() || conformal.is_some()) {
        return Err("the forces and the friction of the system belong to neither part");
    }
    let (term, others) = (&parts[part], &parts[..part]);
    if part > 0 && !noise.is_empty() {
        return Err("the noises of the system belong to neither part");
    }
    let is_timed = reads_time(graph, term, *t);
    if is_timed && others.iter().any(|other| reads_time(graph, other, *t)) {
        return Err("it reads the time, which the flow of the other part moves, and so does that one");
    }
    let reads: Vec<Reads> = term.elements.iter().map(|element| element.reads()).collect();
    let reads_any = |those: &[Reads]| reads.iter().any(|read| those.contains(read));
    if !reads_any(&[Reads::Momenta, Reads::Both]) {
        return Ok(Form::Coordinates);
    }
    if !reads_any(&[Reads::Coordinates, Reads::Both]) {
        return Ok(Form::Momenta);
    }
    if is_timed || !term.elements.iter().all(|element| is_quadratic(graph, element)) {
        return Err("it reads coordinates and momenta, and is no such polynomial");
    }
    if *size == Index::atom(Atom::Size) {
        return Err(
            "it reads coordinates and momenta, and the size of the system is known to the state only",
        );
    }
    Ok(Form::Quadratic)
}

fn reads_time(graph: &Graph, term: &Term, t: Symbol) -> bool {
    term.elements.iter().any(|element| graph.depends_on(element.value, &[t]))
}
