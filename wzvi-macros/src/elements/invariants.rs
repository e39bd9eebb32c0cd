//! First integrals that are sums over all sites, `F = Σ_i f(q_i, p_i)`, proven element by element.
//!
//! With an element `H_e` in the local variables `x` at the sites `s(x)`, its part of the bracket is
//!
//! ```text
//! {H_e, F} = Σ_(momenta x) ∂H_e/∂x ∂f/∂q(s(x)) - Σ_(coordinates x) ∂H_e/∂x ∂f/∂p(s(x))
//! ```
//!
//! which reads nothing but `H_e` and `f` at a few sites. If it vanishes identically for every element, or for the sum of
//! those that stand in the same loops, `F` is a first integral at any size. Sums that cancel only between neighbours, or
//! between different loops, are not found.

use std::collections::HashMap;

use crate::discretise::facts::Knowledge;
use crate::model::index::{Atom, Index, Loop};
use crate::model::{Element, Local, Slot, System};
use crate::symbolic::zero::ZeroTest;
use crate::symbolic::{Expr, Graph, Symbol};

/// What stands in the way of a proof.
pub(crate) enum Failure {
    /// It is not a sum over all sites of functions of one site.
    NotLocal,
    /// It reads the time.
    ReadsTime,
    /// The part of `{H_term, F}` that does not vanish by itself.
    Rate { term: usize, rate: String, knowledge: Knowledge },
}

/// The first reason for which the declared `number` is not proven; `None` if it is.
pub(crate) fn failure(model: &mut System, number: usize) -> Option<Failure> {
    let integral = model.invariants.get(number)?.elements.clone();
    let (t, size, components) = (model.t, model.size.clone(), model.components);
    let graph = &mut model.graph;
    if integral.iter().any(|element| graph.depends_on(element.value, &[t])) {
        return Some(Failure::ReadsTime);
    }
    let Some(density) = Density::of(&integral, &size, components) else { return Some(Failure::NotLocal) };
    let terms = [&model.drift].into_iter().chain(model.noise.iter().map(|noise| &noise.term));
    for (term, hamiltonian) in terms.enumerate() {
        // What stands in the same loops is one function of one placement.
        let mut groups: Vec<(Vec<Loop>, Expr)> = Vec::new();
        let mut places = Places { graph, known: Vec::new() };
        for element in &hamiltonian.elements {
            let Some(rate) = density.rate(element, &mut places) else { return Some(Failure::NotLocal) };
            match groups.iter_mut().find(|(loops, _)| *loops == element.loops) {
                Some((_, sum)) => *sum = places.graph.add(*sum, rate),
                None => groups.push((element.loops.clone(), rate)),
            }
        }
        for (_, rate) in groups {
            let knowledge = match graph.test_zero(rate) {
                ZeroTest::Zero => continue,
                ZeroTest::Nonzero(witness) => Knowledge::Refuted(witness),
                ZeroTest::Unknown => Knowledge::Unknown,
            };
            return Some(Failure::Rate { term, rate: graph.display(rate), knowledge });
        }
    }
    None
}

/// One symbol for each place that elements read.
struct Places<'g> {
    graph: &'g mut Graph,
    known: Vec<Local>,
}

impl Places<'_> {
    fn symbol(&mut self, slot: &Slot, symbol: Symbol) -> Symbol {
        if let Some(known) = self.known.iter().find(|known| known.slot == *slot) {
            return known.symbol;
        }
        let is_taken = self.known.iter().any(|known| known.symbol == symbol);
        let symbol = if is_taken {
            let name = self.graph.symbol_name(symbol).to_owned();
            self.graph.new_symbol(name)
        } else {
            symbol
        };
        self.known.push(Local { symbol, slot: slot.clone() });
        symbol
    }
}

/// `f`, as the elements of `F` and the variable of the site.
struct Density<'e> {
    elements: &'e [Element],
    components: i128,
}

impl<'e> Density<'e> {
    fn of(elements: &'e [Element], size: &Index, components: i128) -> Option<Self> {
        let is_over_all_sites = |element: &Element| {
            let [site] = element.loops.as_slice() else { return false };
            let point = Index::atom(Atom::Loop(site.variable));
            let is_here = |index: &Index| {
                let component = index.plus(&point, -components).and_then(|rest| rest.as_integer());
                component.is_some_and(|component| (0..components).contains(&component))
            };
            let reads_here = element.locals.iter().all(|local| match &local.slot {
                Slot::Coordinate(index) | Slot::Momentum(index) => is_here(index),
                Slot::Entry(..) | Slot::Number(_) => true,
            });
            site.start == Index::default() && site.end == *size && reads_here
        };
        elements.iter().all(is_over_all_sites).then_some(Self { elements, components })
    }

    /// `{H_e, F}` of one placement; `None` if an index is beyond this arithmetic.
    fn rate(&self, element: &Element, places: &mut Places<'_>) -> Option<Expr> {
        let mut same = HashMap::new();
        for local in &element.locals {
            let symbol = places.symbol(&local.slot, local.symbol);
            same.insert(local.symbol, places.graph.symbol(symbol));
        }
        let value = *places.graph.substitute(&[element.value], &same).first()?;
        let mut terms = Vec::new();
        for local in &element.locals {
            let (index, is_momentum) = match &local.slot {
                Slot::Coordinate(index) => (index, false),
                Slot::Momentum(index) => (index, true),
                _ => continue,
            };
            let symbol = places.symbol(&local.slot, local.symbol);
            let slope = places.graph.derivative(value, symbol);
            let of_density = self.slope_at(index, is_momentum, places)?;
            let product = places.graph.multiply(slope, of_density);
            terms.push(if is_momentum { product } else { places.graph.negate(product) });
        }
        Some(places.graph.sum(&terms))
    }

    /// `∂f/∂q` (for a momentum of the element) or `∂f/∂p` with respect to the component at `index`, at its site.
    fn slope_at(&self, index: &Index, by_coordinate: bool, places: &mut Places<'_>) -> Option<Expr> {
        let (site, component) = index.divided(self.components)?;
        let mut slopes = Vec::new();
        for element in self.elements {
            let [Loop { variable, .. }] = element.loops.as_slice() else { return None };
            let mut same = HashMap::new();
            let mut by = None;
            for local in &element.locals {
                let moved = |index: &Index| index.with(*variable, &site);
                let slot = match &local.slot {
                    Slot::Coordinate(index) => Slot::Coordinate(moved(index)?),
                    Slot::Momentum(index) => Slot::Momentum(moved(index)?),
                    Slot::Number(index) => Slot::Number(moved(index)?),
                    Slot::Entry(table, indices) => {
                        Slot::Entry(*table, indices.iter().map(moved).collect::<Option<_>>()?)
                    }
                };
                let symbol = places.symbol(&slot, local.symbol);
                same.insert(local.symbol, places.graph.symbol(symbol));
                let own = Index::atom(Atom::Loop(*variable));
                let is_wanted = match &local.slot {
                    Slot::Coordinate(index) if by_coordinate => {
                        index.plus(&own, -self.components)?.as_integer() == Some(component)
                    }
                    Slot::Momentum(index) if !by_coordinate => {
                        index.plus(&own, -self.components)?.as_integer() == Some(component)
                    }
                    _ => false,
                };
                by = if is_wanted { Some(symbol) } else { by };
            }
            if let Some(by) = by {
                let value = *places.graph.substitute(&[element.value], &same).first()?;
                slopes.push(places.graph.derivative(value, by));
            }
        }
        Some(places.graph.sum(&slopes))
    }
}
