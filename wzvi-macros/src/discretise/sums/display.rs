//! Sums as text, in indices.

use std::fmt::Write;

use super::locality::is_condition;
use super::{Space, Sum};
use crate::diagnostics::internal::Promised;
use crate::elements::describe::index as index_text;
use crate::model::index::{Index, Loop};
use crate::model::{Element, Slot};
use crate::symbolic::{Expr, Graph, Rational};

const LETTERS: [&str; 6] = ["i", "j", "k", "l", "m", "n"];

impl Space {
    /// Where loop variables of depth 0, 1, ... are `i`, `j`, ...
    pub(crate) fn index(&self, index: &Index) -> String {
        let letter = |variable: u32| {
            let depth = variable.saturating_sub(self.first) as usize;
            LETTERS[depth.min(LETTERS.len() - 1)]
        };
        let table = |id: u32| self.tables.get(id as usize).map_or("?", |(name, _)| name.as_str());
        index_text(index, &table, &letter)
    }

    pub(super) fn slot_name(&self, slot: &Slot) -> String {
        let [q, p] = &self.names;
        match slot {
            Slot::Coordinate(index) => format!("{q}{}", self.component(index)),
            Slot::Momentum(index) => format!("{p}{}", self.component(index)),
            Slot::Displacement(index) => format!("δ{q}{}", self.component(index)),
            Slot::Number(index) if index.terms.len() == 1 && index.constant == 0 => self.index(index),
            Slot::Number(index) => format!("({})", self.index(index)),
            Slot::Entry(table, indices) => {
                let name = self.tables.get(*table as usize).map_or("?", |(name, _)| name.as_str());
                let indices: Vec<String> =
                    indices.iter().map(|index| format!("[{}]", self.index(index))).collect();
                format!("{name}{}", indices.concat())
            }
        }
    }

    /// `[point]`, or `[point][component]` for points of several components.
    fn component(&self, index: &Index) -> String {
        match index.divided(self.components) {
            Some((point, component)) if self.components > 1 => {
                format!("[{}][{component}]", self.index(&point))
            }
            _ => format!("[{}]", self.index(index)),
        }
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
                text.push_str(&self.range(known));
            }
            let value = graph.scale(weighted.element.value, factor);
            let _ = write!(text, "[{}]", graph.display(value));
            parts.push(text);
        }
        parts.join(" + ")
    }

    pub(super) fn range(&self, known: &Loop) -> String {
        if is_condition(known) {
            return format!("(where {} > 0) ", self.index(&known.end));
        }
        let last = known.end.shifted(-1).promised("ends of loops are integers");
        let letter = self.index(&super::variable(known.variable));
        format!("Σ_({letter}={}..{}) ", self.index(&known.start), self.index(&last))
    }
}
