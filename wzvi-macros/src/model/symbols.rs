//! The meanings of the symbols of a system: local variables, with their slots, and sums.

use std::collections::HashMap;

use super::display::{IndexNames, letter_at};
use super::index::{Index, Loop};
use super::{CollectiveSlot, Element, Half, Local, Slot, Table, Variables};
use crate::symbolic::{Expr, Graph, Symbol, SymbolKind};

/// The meaning of a sum symbol: `Σ_(range) body`.
#[derive(Clone)]
pub(crate) struct IndexedSum {
    pub(crate) range: Loop,
    pub(crate) body: Expr,
    /// How many sums are inside of each other in it, with itself.
    depth: usize,
}

/// The symbols of a graph that are neither time nor parameters.
#[derive(Clone, Default)]
pub(crate) struct Symbols {
    /// Names of coordinates and momenta.
    pub(crate) names: [String; 2],
    locals: Vec<Local>,
    of_slot: HashMap<Slot, Symbol>,
    /// Position among the locals.
    of_symbol: HashMap<Symbol, usize>,
    sums: HashMap<Symbol, IndexedSum>,
    /// The coordinates and momenta in the order of the state vector, where each is a variable from the start.
    phase: [Vec<Symbol>; 2],
    letters: Vec<&'static str>,
    /// The loop variables of [`Symbols::variable_at`].
    by_depth: Vec<u32>,
}

impl Symbols {
    pub(crate) fn new(names: [String; 2]) -> Self {
        Self { names, ..Self::default() }
    }

    /// Makes every degree of freedom a variable, by the names of coordinates and momenta.
    pub(crate) fn declare_phase(&mut self, graph: &mut Graph, q: &[String], p: &[String]) {
        for (own, (half, names)) in [(Half::Coordinates, q), (Half::Momenta, p)].into_iter().enumerate() {
            for (i, name) in names.iter().enumerate() {
                let slot = Slot::State(half, Index::integer(i as i128));
                let symbol = self.declare(graph, slot, name.clone());
                self.phase[own].push(symbol);
            }
        }
    }

    /// The coordinates and the momenta, where each is a variable.
    pub(crate) fn phase(&self) -> [Vec<Symbol>; 2] {
        self.phase.clone()
    }

    /// A new loop variable inside of `depth` loops.
    pub(crate) fn variable(&mut self, depth: usize) -> u32 {
        self.letters.push(letter_at(depth));
        (self.letters.len() - 1) as u32
    }

    /// The variable of loops inside of `depth` loops in sums that do not read what is around them.
    pub(crate) fn variable_at(&mut self, depth: usize) -> u32 {
        while self.by_depth.len() <= depth {
            let variable = self.variable(self.by_depth.len());
            self.by_depth.push(variable);
        }
        self.by_depth[depth]
    }

    /// The variable at `slot`, the same wherever it is named.
    pub(crate) fn local(&mut self, graph: &mut Graph, slot: Slot, tables: &[Table]) -> Symbol {
        match self.of_slot.get(&slot) {
            Some(&known) => known,
            None => {
                let name = match self.named_coordinate(&slot) {
                    Some(coordinate) => format!("δ{}", graph.symbol_name(coordinate)),
                    None => self.reader(tables, |names| names.slot(&slot, &self.names, 1)),
                };
                let is_nonzero = slot.is_nonzero(tables);
                let symbol = self.declare(graph, slot, name);
                if is_nonzero {
                    let entry = graph.symbol(symbol);
                    graph.assume_nonzero(entry);
                }
                symbol
            }
        }
    }

    /// Makes it known that the entries of a list are not zero.
    pub(crate) fn assume_nonzero_entries(&self, graph: &mut Graph, list: u32) {
        for local in &self.locals {
            if matches!(local.slot, Slot::Entry(own, _) if own == list) {
                let entry = graph.symbol(local.symbol);
                graph.assume_nonzero(entry);
            }
        }
    }

    /// Brings the bodies of all sums to the form that they have by what is known now.
    pub(crate) fn rebuild_sums(&mut self, graph: &mut Graph) {
        for IndexedSum { body, .. } in self.sums.values_mut() {
            *body = graph.rebuilt(*body);
        }
    }

    /// The coordinate that is displaced, where it is a variable from the start.
    fn named_coordinate(&self, slot: &Slot) -> Option<Symbol> {
        let Slot::State(Half::Displacements, index) = slot else { return None };
        let place = usize::try_from(index.as_integer()?).ok()?;
        self.phase[0].get(place).copied()
    }

    /// The displacement of each coordinate, where these are variables.
    pub(crate) fn displacements(&mut self, graph: &mut Graph) -> Vec<Symbol> {
        let degrees = self.phase[0].len();
        (0..degrees)
            .map(|i| self.local(graph, Slot::State(Half::Displacements, Index::integer(i as i128)), &[]))
            .collect()
    }

    /// A new variable for a slot that has none.
    pub(crate) fn declare(&mut self, graph: &mut Graph, slot: Slot, name: String) -> Symbol {
        let symbol = graph.new_symbol(slot.kind(), name);
        self.of_slot.insert(slot.clone(), symbol);
        self.of_symbol.insert(symbol, self.locals.len());
        self.locals.push(Local { symbol, slot });
        symbol
    }

    /// The symbol of `Σ_(range) body`.
    pub(crate) fn sum(&mut self, graph: &mut Graph, range: Loop, body: Expr) -> Symbol {
        let symbol = graph.new_symbol(SymbolKind::Auxiliary, "Σ");
        let depth = 1 + self.depth(graph, body);
        self.sums.insert(symbol, IndexedSum { range, body, depth });
        symbol
    }

    /// Sums inside of each other in an expression, at most.
    pub(crate) fn depth(&self, graph: &Graph, of: Expr) -> usize {
        let sums = graph.symbols_in(of).into_iter().filter_map(|symbol| self.sums.get(&symbol));
        sums.map(|sum| sum.depth).max().unwrap_or(0)
    }

    pub(crate) fn sum_of(&self, symbol: Symbol) -> Option<&IndexedSum> {
        self.sums.get(&symbol)
    }

    pub(crate) fn local_of(&self, symbol: Symbol) -> Option<&Local> {
        self.of_symbol.get(&symbol).map(|&position| &self.locals[position])
    }

    /// The locals among `symbols`, in order of creation.
    pub(crate) fn locals_among(&self, symbols: impl Iterator<Item = Symbol>) -> Vec<Local> {
        let mut positions: Vec<usize> =
            symbols.filter_map(|symbol| self.of_symbol.get(&symbol).copied()).collect();
        positions.sort_unstable();
        positions.into_iter().map(|position| self.locals[position].clone()).collect()
    }

    /// Calls `read` with the names of the parts of indices.
    pub(crate) fn reader<T>(&self, tables: &[Table], read: impl FnOnce(&IndexNames<'_>) -> T) -> T {
        let letter = |variable: u32| self.letters.get(variable as usize).copied().unwrap_or("i");
        read(&IndexNames { tables, letter: &letter })
    }
}

impl Variables for Symbols {
    fn declare_collective(&mut self, graph: &mut Graph, slot: CollectiveSlot, name: String) -> Symbol {
        self.declare(graph, Slot::Collective(slot), name)
    }

    fn element_in(&self, graph: &Graph, loops: Vec<Loop>, value: Expr) -> Element {
        let locals = self.locals_among(graph.symbols_in(value).into_iter());
        Element { loops, value, locals }
    }
}

impl Slot {
    /// The slot with every index in it mapped; `None` on overflow.
    pub(crate) fn map(&self, f: impl Fn(&Index) -> Option<Index>) -> Option<Self> {
        Some(match self {
            Self::State(half, index) => Self::State(*half, f(index)?),
            Self::Number(index) => Self::Number(f(index)?),
            Self::Entry(table, indices) => Self::Entry(*table, indices.iter().map(f).collect::<Option<_>>()?),
            Self::Collective(slot) => Self::Collective(*slot),
        })
    }

    /// Whether it is an entry of a list whose entries are not zero.
    pub(crate) fn is_nonzero(&self, tables: &[Table]) -> bool {
        let Self::Entry(table, _) = self else { return false };
        tables.get(*table as usize).is_some_and(|table| table.is_nonzero)
    }

    /// The kind of its variable.
    pub(crate) fn kind(&self) -> SymbolKind {
        match self {
            Self::State(Half::Coordinates, _) => SymbolKind::Coordinate,
            Self::State(Half::Momenta, _) => SymbolKind::Momentum,
            Self::State(Half::Displacements, _) => SymbolKind::Displacement,
            Self::Number(_) | Self::Entry(..) => SymbolKind::Parameter,
            Self::Collective(_) => SymbolKind::Auxiliary,
        }
    }

    /// The indices in it.
    pub(crate) fn indices(&self) -> &[Index] {
        match self {
            Self::State(_, index) | Self::Number(index) => std::slice::from_ref(index),
            Self::Entry(_, indices) => indices,
            Self::Collective(_) => &[],
        }
    }
}
