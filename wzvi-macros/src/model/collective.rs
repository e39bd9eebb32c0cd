//! Collective variables: numbers that all sites determine together, such as `S = Σ_i cos q_i`.
//!
//! A Hamiltonian `f(S_1, ..., S_k)` is an element that reads collective variables. Its derivatives follow
//! from the chain rule, from the outermost function to the innermost:
//!
//! ```text
//! ∂f/∂x_i = Σ_j λ_j ∂g_j/∂x_i,   S_j = Σ_i g_j(x_i),   λ_j = ∂f/∂S_j
//! ```
//!
//! Each slope `λ_j` is a collective variable, too. So the first derivatives are those of the elements
//! `λ_j g_j`, in which collective variables count as constants, and cost as much as one sum over sites. The
//! variable of a sum may be read by another one, as the mean is by a variance: `λ_j` then has a term
//! `λ_k Σ_i ∂g_k/∂S_j`.
//!
//! Tests: `tests/loops/collective.rs`.

use std::collections::BTreeMap;

use super::{Element, Loop, Reads};
use crate::symbolic::{Expr, Graph, Symbol};

/// A collective variable as a slot: its number, and what it reads.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) struct CollectiveSlot {
    /// Variables read others with lower numbers only.
    pub(crate) number: u32,
    pub(crate) reads: Reads,
    pub(crate) reads_time: bool,
}

impl CollectiveSlot {
    /// Whether it changes along a path: a sum of fields does not.
    pub(crate) fn moves(self) -> bool {
        self.reads.q || self.reads.p || self.reads_time
    }
}

/// The role of a collective variable.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum CollectiveRole {
    /// A sum that the user wrote.
    Sum,
    /// The slope of a Hamiltonian by a sum, with the number of this sum.
    Slope(u32),
}

/// The definition of a collective variable.
#[derive(Clone)]
pub(crate) struct Collective {
    pub(crate) symbol: Symbol,
    pub(crate) slot: CollectiveSlot,
    pub(crate) role: CollectiveRole,
    /// The terms, whose sum is the variable.
    pub(crate) elements: Vec<Element>,
}

/// Makes variables and elements: those of a system, or those of a space of sums.
pub(crate) trait Variables {
    /// A new variable at a slot.
    fn declare_collective(&mut self, graph: &mut Graph, slot: CollectiveSlot, name: String) -> Symbol;

    /// An element with the locals that its value reads.
    fn element_in(&self, graph: &Graph, loops: Vec<Loop>, value: Expr) -> Element;
}

/// All collective variables, by number.
#[derive(Clone, Default)]
pub(crate) struct Collectives(Vec<Collective>);

impl Collectives {
    pub(crate) fn all(&self) -> &[Collective] {
        &self.0
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The terms of all variables.
    pub(crate) fn elements_mut(&mut self) -> impl Iterator<Item = &mut Element> {
        self.0.iter_mut().flat_map(|known| &mut known.elements)
    }

    pub(crate) fn of(&self, slot: CollectiveSlot) -> &Collective {
        self.numbered(slot.number)
    }

    /// The variable with this number. Numbers come from [`Collectives::variable`], which appends to the list,
    /// and nothing is removed from it.
    pub(crate) fn numbered(&self, number: u32) -> &Collective {
        &self.0[number as usize]
    }

    /// The variable with these elements, the same for the same elements.
    pub(crate) fn variable(
        &mut self,
        graph: &mut Graph,
        t: Symbol,
        role: CollectiveRole,
        elements: Vec<Element>,
        variables: &mut dyn Variables,
    ) -> Symbol {
        let is_same = |a: &Element, b: &Element| a.loops == b.loops && a.value == b.value;
        let known = self.0.iter().find(|known| {
            known.elements.len() == elements.len()
                && known.elements.iter().zip(&elements).all(|(a, b)| is_same(a, b))
        });
        if let Some(known) = known {
            return known.symbol;
        }
        let reads = elements.iter().map(Element::reads).fold(Reads { q: false, p: false }, Reads::or);
        let reads_time = elements.iter().any(|element| element.reads_time(graph, t));
        let slot = CollectiveSlot { number: self.0.len() as u32, reads, reads_time };
        let place = 1 + self.0.iter().filter(|known| known.is_sum() == (role == CollectiveRole::Sum)).count();
        let name = if role == CollectiveRole::Sum { format!("S{place}") } else { format!("λ{place}") };
        let symbol = variables.declare_collective(graph, slot, name);
        self.0.push(Collective { symbol, slot, role, elements });
        symbol
    }

    /// Elements with the first derivatives of `elements` by the state and the time, in which collective
    /// variables count as constants. A covector is linear in displacements, which no collective variable
    /// reads, and stays what it is.
    pub(crate) fn with_slopes(
        &mut self,
        graph: &mut Graph,
        t: Symbol,
        elements: &[Element],
        variables: &mut dyn Variables,
    ) -> Vec<Element> {
        let mut all: Vec<Element> = Vec::new();
        let mut slopes: BTreeMap<u32, Vec<Element>> = BTreeMap::new();
        for element in elements {
            if !element.is_collective() {
                all.push(element.clone());
                continue;
            }
            if acts(graph, element, t) {
                all.push(element.clone());
            }
            if !element.is_covector() {
                for (symbol, slot) in element.moving_collectives() {
                    let slope = graph.derivative(element.value, symbol);
                    add(graph, &mut slopes, slot, element.loops.clone(), slope, variables);
                }
            }
        }
        // Variables read others with lower numbers, which thus have all their terms when their turn comes.
        let mut products = Products::default();
        while let Some((number, terms)) = slopes.pop_last() {
            let slope = self.variable(graph, t, CollectiveRole::Slope(number), terms, variables);
            let slope = graph.symbol(slope);
            for element in self.numbered(number).elements.clone() {
                let times = |graph: &mut Graph, value| graph.multiply(slope, value);
                if acts(graph, &element, t) {
                    let value = times(graph, element.value);
                    products.add(graph, element.loops.clone(), value);
                }
                for (symbol, slot) in element.moving_collectives() {
                    let inner = graph.derivative(element.value, symbol);
                    let value = times(graph, inner);
                    add(graph, &mut slopes, slot, element.loops.clone(), value, variables);
                }
            }
        }
        let products = products.0.into_iter().map(|(loops, value)| variables.element_in(graph, loops, value));
        all.extend(products);
        all
    }
}

/// Whether a first derivative of an element is not zero where collective variables are constants.
fn acts(graph: &Graph, element: &Element, t: Symbol) -> bool {
    element.is_covector() || !element.state().is_empty() || graph.depends_on(element.value, &[t])
}

/// Adds a term of the slope by a variable.
fn add(
    graph: &Graph,
    slopes: &mut BTreeMap<u32, Vec<Element>>,
    slot: CollectiveSlot,
    loops: Vec<Loop>,
    value: Expr,
    variables: &mut dyn Variables,
) {
    if !graph.is_zero(value) {
        slopes.entry(slot.number).or_default().push(variables.element_in(graph, loops, value));
    }
}

/// Products of slopes and terms, one for all in the same loops.
#[derive(Default)]
struct Products(Vec<(Vec<Loop>, Expr)>);

impl Products {
    fn add(&mut self, graph: &mut Graph, loops: Vec<Loop>, value: Expr) {
        match self.0.iter_mut().find(|(known, _)| *known == loops) {
            Some((_, sum)) => *sum = graph.add(*sum, value),
            None => self.0.push((loops, value)),
        }
    }
}

impl Collective {
    /// Whether it is a sum that the user wrote.
    pub(crate) fn is_sum(&self) -> bool {
        self.role == CollectiveRole::Sum
    }
}

impl Element {
    /// The collective variables that it reads.
    pub(crate) fn collectives(&self) -> impl Iterator<Item = (Symbol, CollectiveSlot)> {
        self.locals.iter().filter_map(|local| match local.slot {
            super::Slot::Collective(slot) => Some((local.symbol, slot)),
            _ => None,
        })
    }

    /// The collective variables that it reads and that change along a path.
    pub(crate) fn moving_collectives(&self) -> impl Iterator<Item = (Symbol, CollectiveSlot)> {
        self.collectives().filter(|(_, slot)| slot.moves())
    }

    /// Whether it reads collective variables by which the whole state acts on each site.
    pub(crate) fn is_collective(&self) -> bool {
        self.moving_collectives().next().is_some()
    }

    /// The symbols that change with the state: its variables there, and collective variables.
    pub(crate) fn moving(&self) -> Vec<Symbol> {
        let collectives = self.moving_collectives().map(|(symbol, _)| symbol);
        self.state().into_iter().chain(collectives).collect()
    }

    pub(crate) fn reads_time(&self, graph: &Graph, t: Symbol) -> bool {
        graph.depends_on(self.value, &[t]) || self.collectives().any(|(_, slot)| slot.reads_time)
    }
}
