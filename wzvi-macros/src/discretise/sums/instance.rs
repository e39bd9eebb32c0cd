//! A sum at a given size, with every placement written out: one expression in one symbol for each slot.
//! Tests: `discretise/sums/tests.rs`.

use std::collections::HashMap;

use super::{Increments, Space, Sum, Weighted, unweighted};
use crate::model::{Atom, CollectiveSlot, Index, Loop, Slot};
use crate::symbolic::{Expr, Graph, Rational, Symbol, SymbolKind};

/// The most nodes of an expression that is written out.
const MOST_NODES: usize = 20_000;

/// The multiplier of a hash: an arbitrary table of integers has hashed indices as entries.
const ENTRY_HASH: i128 = 2_654_435_761;

/// Why a sum is not written out.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum NotWritten {
    /// An index is out of range: no system has this size.
    OutOfRange,
    TooLarge,
}

/// Whether numbers made of loop variables have their values or are arbitrary.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum NumberValues {
    Known,
    Free,
}

#[derive(Clone, PartialEq, Eq, Hash)]
enum InstanceVariable {
    /// A slot with constant indices, of one of two states.
    Slot(Slot, bool),
    /// The increment of a noise, of one of two paths.
    Increment(usize, i128),
}

/// The symbols of a system of one size.
pub(super) struct Instance<'s> {
    space: &'s Space,
    size: i128,
    numbers: NumberValues,
    increments: Increments,
    symbols: HashMap<InstanceVariable, Symbol>,
    /// Collective variables, written out for a state or for another one.
    collectives: HashMap<(CollectiveSlot, bool), Expr>,
}

type Values = Vec<(u32, i128)>;

impl<'s> Instance<'s> {
    pub(super) fn new(space: &'s Space, size: i128, numbers: NumberValues, increments: Increments) -> Self {
        Self { space, size, numbers, increments, symbols: HashMap::new(), collectives: HashMap::new() }
    }

    /// The sum in the symbols of a state, or of another one.
    pub(super) fn value(&mut self, graph: &mut Graph, sum: &Sum, is_other: bool) -> Result<Expr, NotWritten> {
        let mut terms = Vec::new();
        let mut nodes = 0;
        for weighted in sum {
            let each = graph.reachable(&[weighted.element.value]).len();
            let placements = self.placements(&weighted.element.loops, (MOST_NODES - nodes) / each);
            let placements = placements.ok_or(NotWritten::TooLarge)?;
            nodes += each * placements.len();
            if nodes > MOST_NODES {
                return Err(NotWritten::TooLarge);
            }
            for values in &placements {
                let value = self.at(graph, weighted, values, is_other).ok_or(NotWritten::OutOfRange)?;
                terms.push((value, Rational::ONE));
            }
        }
        Ok(graph.linear_combination(&terms))
    }

    /// All values of the loop variables; `None` if there are more than `most`.
    fn placements(&self, loops: &[Loop], most: usize) -> Option<Vec<Values>> {
        let mut all = vec![Values::new()];
        for known in loops {
            let mut longer = Vec::new();
            for values in all {
                let (start, end) = (self.integer(&known.start, &values)?, self.integer(&known.end, &values)?);
                for value in start..end {
                    let mut values = values.clone();
                    values.push((known.variable, value));
                    longer.push(values);
                    if longer.len() > most {
                        return None;
                    }
                }
            }
            all = longer;
        }
        Some(all)
    }

    /// The value of one placement; `None` if an index is out of range.
    fn at(
        &mut self,
        graph: &mut Graph,
        weighted: &Weighted,
        values: &Values,
        is_other: bool,
    ) -> Option<Expr> {
        let Weighted { element, increments } = weighted;
        let mut images = HashMap::new();
        for local in &element.locals {
            let constant = |index: &Index| self.integer(index, values).map(Index::integer);
            let slot = local.slot.map(constant)?;
            let image = self.variable(graph, slot, is_other)?;
            images.insert(local.symbol, image);
        }
        let mut factors = graph.substitute(&[element.value], &images);
        let mut numbers =
            increments.iter().map(|index| self.integer(index, values)).collect::<Option<Vec<_>>>()?;
        if self.increments == Increments::Together {
            numbers.sort_unstable();
        }
        for (position, number) in numbers.into_iter().enumerate() {
            let symbol = self
                .symbol(graph, InstanceVariable::Increment(position, number), || format!("ΔW{}", number + 1));
            factors.push(graph.symbol(symbol));
        }
        Some(graph.product(&factors))
    }

    fn variable(&mut self, graph: &mut Graph, slot: Slot, is_other: bool) -> Option<Expr> {
        let (mut is_of_state, mut known) = (false, self.space.symbols.get(&slot).copied());
        match &slot {
            Slot::State(_, index) => {
                let components = self.size.checked_mul(self.space.components)?;
                if !(0..components).contains(&index.constant) {
                    return None;
                }
                is_of_state = true;
            }
            Slot::Entry(_, indices) => {
                if indices.iter().any(|index| index.constant < 0) {
                    return None;
                }
            }
            Slot::Number(index) if self.numbers == NumberValues::Known => {
                return Some(graph.number(Rational::new(index.constant, 1)?));
            }
            Slot::Number(_) => known = None,
            Slot::Collective(own) if self.numbers == NumberValues::Known => {
                return self.collective(graph, *own, is_other);
            }
            // A number of its own.
            Slot::Collective(own) => is_of_state = own.moves(),
        }
        let is_other = is_other && is_of_state;
        if let Some(known) = known.filter(|_| !is_other) {
            return Some(graph.symbol(known));
        }
        let name = self.space.slot_name(&slot);
        let symbol = self.symbol(graph, InstanceVariable::Slot(slot, is_other), || name);
        Some(graph.symbol(symbol))
    }

    /// A collective variable, written out; `None` if an index is out of range, or if it is too large.
    fn collective(&mut self, graph: &mut Graph, slot: CollectiveSlot, is_other: bool) -> Option<Expr> {
        if let Some(&known) = self.collectives.get(&(slot, is_other)) {
            return Some(known);
        }
        let space = self.space;
        let sum = unweighted(&space.collectives.of(slot).elements);
        let value = self.value(graph, &sum, is_other).ok()?;
        self.collectives.insert((slot, is_other), value);
        Some(value)
    }

    fn symbol(
        &mut self,
        graph: &mut Graph,
        place: InstanceVariable,
        name: impl FnOnce() -> String,
    ) -> Symbol {
        let kind = match &place {
            InstanceVariable::Slot(slot, _) => slot.kind(),
            InstanceVariable::Increment(..) => SymbolKind::Increment,
        };
        *self.symbols.entry(place).or_insert_with(|| graph.new_symbol(kind, name()))
    }

    /// The index at these values of the loop variables; sizes and counts in fields equal those of the phase
    /// space, tables are arbitrary.
    fn integer(&self, index: &Index, values: &Values) -> Option<i128> {
        index.value(&|atom| match atom {
            Atom::Loop(own) => Some(values.iter().find(|(known, _)| known == own)?.1),
            Atom::Given(table, indices) if !indices.is_empty() => {
                let mut entry = i128::from(*table) + 1;
                for index in indices {
                    entry = (entry * ENTRY_HASH + self.integer(index, values)?) % (ENTRY_HASH - 1);
                }
                entry.checked_rem_euclid(self.size)
            }
            _ => Some(self.size),
        })
    }
}
