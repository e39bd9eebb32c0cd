//! Sums of elements as functions on phase space: derivatives, contractions, and whether one vanishes.
//!
//! ```text
//! F = Σ_e Σ_(loops of e) f_e(locals of e)
//! Σ_s ∂F/∂p_s ∂G/∂q_s = Σ_(e, e') Σ_(momentum x of e, coordinate y of e')
//!                       Σ_(loops of e and e': slot of x = slot of y) ∂f_e/∂x ∂g_e'/∂y
//! ```
//!
//! The result is a sum of elements again: the equation of the slots is solved for a loop variable
//! ([`solve`]), and terms in the same loops are added up ([`contract`]). Brackets, the defect, the
//! counter-term, energy rates and the rates of first integrals are such sums, at any size. [`vanish`] decides
//! whether one is zero or constant.
//!
//! Tests: `discretise/sums/tests.rs`.

mod collapse;
mod contract;
mod display;
mod instance;
mod locality;
mod solve;
#[cfg(test)]
mod tests;
mod vanish;

use std::collections::HashMap;

use crate::distinct::Distinct;
use crate::model::index::{Atom, Bounds, Index, Loop};
use crate::model::{CollectiveSlot, Collectives, Element, Half, Local, Slot, System, Table, Variables};
use crate::symbolic::{Expr, Graph, Knowledge, Rational, Symbol};

pub(crate) use contract::Increments;

/// Loop variables of sums made here are numbered by depth.
const MOST_LOOPS: u32 = 1 << 10;

/// An element, times the increments of its noises.
#[derive(Clone)]
pub(crate) struct Weighted {
    pub(crate) element: Element,
    /// Numbers of noises. A sum with increments vanishes if it does for all values of the increments.
    pub(crate) increments: Vec<Index>,
}

type IndexMap<'m> = &'m dyn Fn(&Index) -> Option<Index>;

impl Weighted {
    /// Maps every index; `None` on overflow. Indices into the state have a map of their own.
    fn mapped(&self, index: IndexMap<'_>, place: IndexMap<'_>) -> Option<Self> {
        let Self { element: Element { loops, value, locals }, increments } = self;
        let range = |known: &Loop| {
            Some(Loop { start: index(&known.start)?, end: index(&known.end)?, ..known.clone() })
        };
        let local = |Local { symbol, slot }: &Local| {
            let is_place = matches!(slot, Slot::State(..));
            Some(Local { symbol: *symbol, slot: slot.map(if is_place { place } else { index })? })
        };
        Some(Self {
            element: Element {
                loops: loops.iter().map(range).collect::<Option<_>>()?,
                value: *value,
                locals: locals.iter().map(local).collect::<Option<_>>()?,
            },
            increments: increments.iter().map(index).collect::<Option<_>>()?,
        })
    }
}

/// A sum of elements.
pub(crate) type Sum = Vec<Weighted>;

/// Elements without increments as weights.
pub(crate) fn unweighted(elements: &[Element]) -> Sum {
    weighted(elements, &[])
}

/// Elements times the increments of the noises with these numbers.
pub(crate) fn weighted(elements: &[Element], increments: &[Index]) -> Sum {
    let weigh = |element: &Element| Weighted { element: element.clone(), increments: increments.to_vec() };
    elements.iter().map(weigh).collect()
}

/// The size of the phase space and the variables of its slots: one symbol for each slot.
#[derive(Clone)]
pub(crate) struct Space {
    /// The number of points.
    size: Index,
    /// Components of a point.
    components: i128,
    names: [String; 2],
    tables: Vec<Table>,
    t: Symbol,
    /// The number of points as a real number, where it is a parameter.
    size_parameter: Option<Symbol>,
    collectives: Collectives,
    symbols: HashMap<Slot, Symbol>,
    slots: HashMap<Symbol, Slot>,
    /// Loop variables of the user are below it.
    first: u32,
}

impl Space {
    /// The space of a system.
    pub(crate) fn of(system: &System) -> Self {
        let mut space = Self {
            size: system.size.clone(),
            components: system.components,
            names: system.names.clone(),
            tables: system.tables.clone(),
            t: system.t,
            size_parameter: size_parameter(system),
            collectives: system.collectives.clone(),
            symbols: HashMap::new(),
            slots: HashMap::new(),
            first: 0,
        };
        let of_terms = system.terms().flat_map(|term| term.values.iter().chain(&term.elements));
        let of_collectives = system.collectives.all().iter().flat_map(|known| &known.elements);
        for element in of_terms.chain(of_collectives) {
            for Local { symbol, slot } in &element.locals {
                space.symbols.insert(slot.clone(), *symbol);
                space.slots.insert(*symbol, slot.clone());
            }
            for known in &element.loops {
                space.first = space.first.max(known.variable + 1);
            }
        }
        for known in system.collectives.all() {
            space.symbols.insert(Slot::Collective(known.slot), known.symbol);
            space.slots.insert(known.symbol, Slot::Collective(known.slot));
        }
        space
    }

    /// The loop variable at a depth.
    fn variable(&self, depth: usize) -> u32 {
        self.first + depth as u32
    }

    /// A number above every loop variable, from which the variables of a second element are numbered.
    fn first_free_variable(&self) -> u32 {
        self.first + MOST_LOOPS
    }

    /// Whether `index >= 0` throughout the loops, for every size; `false` if that is not known.
    fn is_nonnegative(&self, index: &Index, loops: &[Loop]) -> bool {
        Bounds { loops, tables: &self.tables }.is_nonnegative(index)
    }

    /// The collective variables of the system, and those of sums made here.
    pub(crate) fn collectives(&self) -> &Collectives {
        &self.collectives
    }

    /// The variable of a slot.
    pub(crate) fn symbol(&mut self, graph: &mut Graph, slot: &Slot) -> Symbol {
        if let Some(&known) = self.symbols.get(slot) {
            return known;
        }
        let symbol = graph.new_symbol(slot.kind(), self.slot_name(slot));
        if slot.is_nonzero(&self.tables) {
            let entry = graph.symbol(symbol);
            graph.assume_nonzero(entry);
        }
        self.symbols.insert(slot.clone(), symbol);
        self.slots.insert(symbol, slot.clone());
        symbol
    }

    /// An element without loops.
    pub(crate) fn element_of(&self, graph: &Graph, value: Expr) -> Element {
        self.element(graph, Vec::new(), value)
    }

    /// An element with the locals that its value reads.
    pub(crate) fn element(&self, graph: &Graph, loops: Vec<Loop>, value: Expr) -> Element {
        let symbols = graph.symbols_in(value).into_iter();
        let mut locals: Vec<Local> = symbols
            .filter_map(|symbol| Some(Local { symbol, slot: self.slots.get(&symbol)?.clone() }))
            .collect();
        locals.sort_unstable_by_key(|local| local.symbol);
        Element { loops, value, locals }
    }
}

/// The parameter that is the number of points as a real number.
fn size_parameter(system: &System) -> Option<Symbol> {
    let [(Atom::Given(table, indices), 1)] = system.size.terms.as_slice() else { return None };
    let table = system.tables.get(*table as usize).filter(|_| indices.is_empty())?;
    // Its tokens are those of the integer, cast.
    let written = |tokens: &dyn ToString| tokens.to_string().replace(' ', "");
    let real = format!("({}as::core::primitive::f64)", written(&table.tokens));
    let parameter = system.parameters.iter().find(|parameter| written(&parameter.tokens) == real)?;
    (system.size.constant == 0).then_some(parameter.symbol)
}

impl Variables for Space {
    fn declare_collective(&mut self, graph: &mut Graph, slot: CollectiveSlot, name: String) -> Symbol {
        let slot = Slot::Collective(slot);
        let symbol = graph.new_symbol(slot.kind(), name);
        self.symbols.insert(slot.clone(), symbol);
        self.slots.insert(symbol, slot);
        symbol
    }

    fn element_in(&self, graph: &Graph, loops: Vec<Loop>, value: Expr) -> Element {
        self.element(graph, loops, value)
    }
}

/// Sums of one space, with the graph of their values.
pub(crate) struct Calculus<'c> {
    pub(crate) space: &'c mut Space,
    pub(crate) graph: &'c mut Graph,
}

/// A sum, unless an index exceeded the arithmetic of indices, and what is known of it.
pub(crate) struct KnownSum {
    pub(crate) sum: Option<Sum>,
    pub(crate) known: Knowledge,
}

impl Calculus<'_> {
    /// `∂F/∂t`
    pub(crate) fn partial(&mut self, sum: &Sum, t: Symbol) -> Sum {
        let mut slopes = self.opened(sum);
        for Weighted { element, .. } in &mut slopes {
            element.value = self.graph.derivative(element.value, t);
        }
        self.combine(&[(&slopes, Rational::ONE)])
    }

    /// `{F, G} = F_p · G_q - F_q · G_p`; `None` if an index is beyond this arithmetic.
    pub(crate) fn bracket(&mut self, f: &Sum, g: &Sum) -> Option<Sum> {
        let (p, q) = (Half::Momenta, Half::Coordinates);
        let one = self.contract((f, p), (g, q), Increments::Each);
        let other = self.contract((f, q), (g, p), Increments::Each);
        self.difference(one, other)
    }

    /// `Σ_s ∂F/∂x_s δq_s` over all slots `s` of a half of the phase space.
    pub(crate) fn displaced(&mut self, sum: &Sum, half: Half) -> Sum {
        let mut terms = Sum::new();
        for Weighted { element, increments } in &self.opened(sum) {
            let read: Vec<_> = element.of_half(half).map(|(symbol, index)| (symbol, index.clone())).collect();
            for (symbol, index) in read {
                let slope = self.graph.derivative(element.value, symbol);
                let displacement = self.space.symbol(self.graph, &Slot::State(Half::Displacements, index));
                let displacement = self.graph.symbol(displacement);
                let value = self.graph.multiply(slope, displacement);
                if !self.graph.is_zero(value) {
                    let element = self.space.element(self.graph, element.loops.clone(), value);
                    terms.push(Weighted { element, increments: increments.clone() });
                }
            }
        }
        terms
    }

    /// The difference of two sums; `None` if one of them is unknown.
    pub(crate) fn difference(&mut self, one: Option<Sum>, other: Option<Sum>) -> Option<Sum> {
        Some(self.combine(&[(&one?, Rational::ONE), (&other?, Rational::MINUS_ONE)]))
    }

    /// `Σ factor · sum`, with one element for all terms in the same loops.
    pub(crate) fn combine(&mut self, sums: &[(&Sum, Rational)]) -> Sum {
        let mut groups = Groups::default();
        for (sum, factor) in sums {
            for Weighted { element, increments } in *sum {
                groups.add(element.loops.clone(), increments.clone(), element.value, *factor);
            }
        }
        groups.finish(self)
    }
}

/// Adds up terms in the same loops with the same increments, in the order of their first terms.
#[derive(Default)]
struct Groups(Distinct<(Vec<Loop>, Vec<Index>), Group>);

struct Group {
    loops: Vec<Loop>,
    increments: Vec<Index>,
    values: Vec<(Expr, Rational)>,
}

impl Groups {
    fn add(&mut self, loops: Vec<Loop>, increments: Vec<Index>, value: Expr, factor: Rational) {
        // A loop of a literal size may have no turn.
        let turns = |known: &Loop| known.end.subtract(&known.start)?.as_integer();
        if loops.iter().any(|known| turns(known).is_some_and(|turns| turns <= 0)) {
            return;
        }
        let key = (loops.clone(), increments.clone());
        let place = self.0.place(key, || Group { loops, increments, values: Vec::new() });
        self.0.values[place].values.push((value, factor));
    }

    fn finish(self, Calculus { space, graph }: &mut Calculus<'_>) -> Sum {
        let mut sum = Sum::new();
        for Group { loops, increments, values } in self.0.values {
            let value = graph.linear_combination(&values);
            if !graph.is_zero(value) {
                sum.push(Weighted { element: space.element(graph, loops, value), increments });
            }
        }
        sum
    }
}

/// The loop variable as an index.
fn variable(id: u32) -> Index {
    Index::atom(Atom::Loop(id))
}
