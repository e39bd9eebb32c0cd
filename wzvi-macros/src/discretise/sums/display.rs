//! Sums as text, in indices. Tests: `discretise/sums/tests.rs`.

use std::collections::HashMap;
use std::fmt::Write;

use super::locality::is_condition;
use super::{Space, Sum};
use crate::diagnostics::promised;
use crate::model::display::{IndexNames, letter_at};
use crate::model::{Element, Index, Local, Loop, Slot};
use crate::symbolic::{Expr, Graph, Rational, Symbol};

impl Space {
    /// The names of indices, with `i`, `j`, ... for the variables of `loops`, which sums made here number
    /// likewise.
    fn reader<T>(&self, loops: &[Loop], read: impl FnOnce(&IndexNames<'_>) -> T) -> T {
        let letter = |variable: u32| {
            let depth = loops.iter().position(|known| known.variable == variable);
            letter_at(depth.unwrap_or(variable.saturating_sub(self.first) as usize))
        };
        read(&IndexNames { tables: &self.tables, letter: &letter })
    }

    pub(crate) fn index(&self, loops: &[Loop], index: &Index) -> String {
        self.reader(loops, |names| names.index(index))
    }

    pub(super) fn slot_name(&self, slot: &Slot) -> String {
        self.reader(&[], |names| names.slot(slot, &self.names, self.components))
    }

    /// `factor Σ_(i=0..n-1) [...] + ...`
    pub(crate) fn display(&self, graph: &mut Graph, sum: &Sum, factor: Rational) -> String {
        if sum.is_empty() {
            return "0".to_owned();
        }
        let mut parts = Vec::new();
        let is_flat = |element: &Element| element.loops.is_empty();
        let flat: Vec<(Expr, Rational)> =
            sum.iter().filter(|w| is_flat(&w.element)).map(|w| (w.element.value, factor)).collect();
        if !flat.is_empty() {
            let value = graph.linear_combination(&flat);
            parts.push(graph.display(value));
        }
        for weighted in sum.iter().filter(|w| !is_flat(&w.element)) {
            let mut text = String::new();
            for known in &weighted.element.loops {
                let range = self.range(&weighted.element.loops, known);
                let _ = if is_condition(known) {
                    write!(text, "({range}) ")
                } else {
                    write!(text, "Σ_({range}) ")
                };
            }
            let value = graph.scale(weighted.element.value, factor);
            let _ = write!(text, "[{}]", graph.display(value));
            parts.push(text);
        }
        parts.join(" + ")
    }

    /// `   for i=0..n - 1, j=0..i - 1`
    pub(crate) fn placements(&self, loops: &[Loop]) -> String {
        let ranges: Vec<String> = loops.iter().map(|known| self.range(loops, known)).collect();
        if ranges.is_empty() { String::new() } else { format!("   for {}", ranges.join(", ")) }
    }

    /// The local variables of an element by the names of points and components.
    pub(crate) fn spelled(&self, graph: &mut Graph, element: &Element) -> HashMap<Symbol, Symbol> {
        let spelled = element.locals.iter().map(|Local { symbol, slot }| {
            let name = match slot {
                Slot::Collective(_) => graph.symbol_name(*symbol).to_owned(),
                _ => self.reader(&element.loops, |names| names.slot(slot, &self.names, self.components)),
            };
            (*symbol, graph.new_symbol_like(*symbol, name))
        });
        spelled.collect()
    }

    /// The range of one loop as text.
    fn range(&self, loops: &[Loop], known: &Loop) -> String {
        if is_condition(known) {
            return format!("where {} > 0", self.index(loops, &known.end));
        }
        let last = promised(known.end.shifted(-1), "ends of loops are integers");
        let letter = self.index(loops, &super::variable(known.variable));
        format!("{letter}={}..{}", self.index(loops, &known.start), self.index(loops, &last))
    }
}
