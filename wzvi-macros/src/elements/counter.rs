//! The counter-term of `Corrected`, `(1/2 - l) (Σ_j ΔW_j ∂H_j/∂q) · (Σ_k ΔW_k ∂H_k/∂p)`, as a sum of elements.
//!
//! It is one where the noises are local to a site: each of their elements stands in one loop, or in none, and reads the
//! state at the site of that loop only. Then the slopes of two elements meet where their loops do.

use std::collections::HashMap;

use crate::model::index::{Atom, Index, Loop};
use crate::model::{Element, Local, Slot, System};
use crate::symbolic::{Expr, Graph, Symbol};

/// An element of the counter-term and the noises whose increments weigh it.
#[derive(Clone)]
pub(crate) struct Counter {
    pub(crate) element: Element,
    pub(crate) weight: Weight,
}

#[derive(Clone, Copy)]
pub(crate) enum Weight {
    /// `ΔW_j ΔW_k`
    Pair(usize, usize),
    /// `ΔW_k²` of the member of the family that the loop is at.
    Member,
}

/// The elements of the counter-term without its factor; `None` if noises are not local.
pub(crate) fn counter_term(model: &mut System) -> Option<Vec<Counter>> {
    let System { graph, noise, components, .. } = model;
    let elements: Vec<(usize, Element)> = noise
        .iter()
        .enumerate()
        .flat_map(|(k, noise)| noise.term.elements.iter().map(move |element| (k, element.clone())))
        .collect();
    let is_family = noise.iter().any(|noise| noise.family.is_some());
    if is_family && noise.len() > 1 {
        return None;
    }
    let mut counters = Vec::new();
    for (j, force) in &elements {
        for (k, velocity) in &elements {
            if force.coordinates().next().is_none() || velocity.momenta().next().is_none() {
                continue;
            }
            let force = localised(force, *components)?;
            let velocity = beside(&force, &localised(velocity, *components)?)?;
            let element = product(graph, &force, velocity)?;
            let weight = if is_family { Weight::Member } else { Weight::Pair(*j, *k) };
            if !graph.is_zero(element.value) {
                counters.push(Counter { element, weight });
            }
        }
    }
    Some(counters)
}

/// The element with its loop moved so that the site it reads is the variable of the loop; an element without loops as it
/// is, if it reads fixed places. `None` if it reads more than one site.
fn localised(element: &Element, components: i128) -> Option<Element> {
    let places = || {
        element.locals.iter().filter_map(|local| match &local.slot {
            Slot::Coordinate(index) | Slot::Momentum(index) => Some(index),
            _ => None,
        })
    };
    let known = match element.loops.as_slice() {
        [] => return places().all(|index| index.as_integer().is_some()).then(|| element.clone()),
        [known] => known,
        _ => return None,
    };
    let own = Index::atom(Atom::Loop(known.variable));
    let mut sites = places().map(|index| {
        let rest = index.plus(&own, -components)?.as_integer()?;
        Some(rest.div_euclid(components))
    });
    let shift = sites.next().unwrap_or(Some(0))?;
    if !sites.all(|site| site == Some(shift)) {
        return None;
    }
    let range =
        Loop { variable: known.variable, start: known.start.shifted(shift)?, end: known.end.shifted(shift)? };
    moved(element, range, &own.shifted(-shift)?)
}

/// The element with `by` for the variable of its only loop, which becomes `range`.
fn moved(element: &Element, range: Loop, by: &Index) -> Option<Element> {
    let [Loop { variable, .. }] = element.loops.as_slice() else { return None };
    let place = |index: &Index| index.with(*variable, by);
    let locals = element.locals.iter().map(|Local { symbol, slot }| {
        let slot = match slot {
            Slot::Coordinate(index) => Slot::Coordinate(place(index)?),
            Slot::Momentum(index) => Slot::Momentum(place(index)?),
            Slot::Number(index) => Slot::Number(place(index)?),
            Slot::Entry(table, indices) => {
                Slot::Entry(*table, indices.iter().map(place).collect::<Option<_>>()?)
            }
        };
        Some(Local { symbol: *symbol, slot })
    });
    Some(Element { locals: locals.collect::<Option<_>>()?, loops: vec![range], value: element.value })
}

/// `other` in the loop of `element`; `None` where the two are not of one kind.
fn beside(element: &Element, other: &Element) -> Option<Element> {
    match (element.loops.as_slice(), other.loops.as_slice()) {
        ([], []) => Some(other.clone()),
        ([own], [known]) => {
            let (start, end) = (own.start.maximum(&known.start), own.end.minimum(&known.end));
            let range = Loop { variable: own.variable, start, end };
            moved(other, range, &Index::atom(Atom::Loop(own.variable)))
        }
        _ => None,
    }
}

/// `Σ ∂force/∂q · ∂velocity/∂p` over the places that both read, in the loop of `velocity`.
fn product(graph: &mut Graph, force: &Element, velocity: Element) -> Option<Element> {
    // One symbol for each place.
    let mut locals = force.locals.clone();
    let mut same: HashMap<Symbol, Expr> = HashMap::new();
    for local in &velocity.locals {
        match locals.iter().find(|known| known.slot == local.slot) {
            Some(known) => {
                let known = graph.symbol(known.symbol);
                same.insert(local.symbol, known);
            }
            None => {
                // A name that stands for another place already needs a new one.
                let symbol = match locals.iter().any(|known| known.symbol == local.symbol) {
                    true => {
                        let name = graph.symbol_name(local.symbol).to_owned();
                        let fresh = graph.new_symbol(name);
                        let fresh_value = graph.symbol(fresh);
                        same.insert(local.symbol, fresh_value);
                        fresh
                    }
                    false => local.symbol,
                };
                locals.push(Local { symbol, slot: local.slot.clone() });
            }
        }
    }
    let other = *graph.substitute(&[velocity.value], &same).first()?;
    let mut terms = Vec::new();
    for q in &locals {
        let Slot::Coordinate(place) = &q.slot else { continue };
        let p = locals.iter().find(|local| matches!(&local.slot, Slot::Momentum(at) if at == place));
        if let Some(p) = p {
            let (slope, speed) = (graph.derivative(force.value, q.symbol), graph.derivative(other, p.symbol));
            terms.push(graph.multiply(slope, speed));
        }
    }
    let value = graph.sum(&terms);
    let parts = graph.reachable(&[value]);
    let read: Vec<Symbol> = parts.into_iter().filter_map(|part| graph.as_symbol(part)).collect();
    locals.retain(|local| read.contains(&local.symbol));
    Some(Element { loops: velocity.loops, value, locals })
}
