//! Sums as text, in indices. Tests: `discretise/sums/tests.rs`.

use std::collections::HashMap;
use std::fmt::Write;

use super::locality::is_condition;
use super::{Space, Sum, Weighted, unweighted};
use crate::diagnostics::promised;
use crate::model::display::{IndexNames, letter_at};
use crate::model::{Element, Family, Index, Local, Loop, Slot};
use crate::symbolic::{Expr, Graph, Rational, Symbol};

/// The letters of loop variables: `i`, `j`, ... by their nesting, and `k` for the number of a member of a
/// family.
#[derive(Clone, Copy)]
struct LoopLetters<'l> {
    loops: &'l [Loop],
    /// The loop variable that numbers the members.
    family: Option<u32>,
}

impl LoopLetters<'_> {
    fn letter(self, variable: u32, first: u32) -> &'static str {
        if self.family == Some(variable) {
            return "k";
        }
        let mut others = self.loops.iter().filter(|known| self.family != Some(known.variable));
        let depth = others.position(|known| known.variable == variable);
        let depth = depth.unwrap_or(variable.saturating_sub(first) as usize);
        // The letter of the members is not used twice.
        letter_at(depth + usize::from(self.family.is_some() && depth >= 2))
    }
}

impl Space {
    /// The names of indices. Variables that are in no loop are numbered as sums made here number them.
    fn reader<T>(&self, letters: LoopLetters<'_>, read: impl FnOnce(&IndexNames<'_>) -> T) -> T {
        let letter = |variable: u32| letters.letter(variable, self.first);
        read(&IndexNames { tables: &self.tables, letter: &letter })
    }

    pub(crate) fn index(&self, loops: &[Loop], index: &Index) -> String {
        self.reader(LoopLetters { loops, family: None }, |names| names.index(index))
    }

    pub(super) fn slot_name(&self, slot: &Slot) -> String {
        let letters = LoopLetters { loops: &[], family: None };
        self.reader(letters, |names| names.slot(slot, &self.names, self.components))
    }

    /// `factor Σ_(i=0..n-1) [...] + ...`
    pub(crate) fn display(&self, graph: &mut Graph, sum: &Sum, factor: Rational) -> String {
        let term = |weighted: &Weighted| (weighted.element.loops.clone(), weighted.element.value);
        let terms: Vec<(Vec<Loop>, Expr)> = sum.iter().map(term).collect();
        self.display_terms(graph, terms, factor, None)
    }

    /// A function as written; for a family one member, `Σ_(i=0..n-1) [...]   for k=0..m-1`.
    pub(crate) fn display_member(
        &self,
        graph: &mut Graph,
        elements: &[Element],
        family: Option<&Family>,
    ) -> String {
        let Some(Family { variable, count }) = family else {
            return self.display(graph, &unweighted(elements), Rational::ONE);
        };
        let mut terms: Vec<(Vec<Loop>, Expr)> = Vec::new();
        for element in elements {
            let spelled = self.spelled_in(graph, element, Some(*variable)).into_iter();
            let images = spelled.map(|(symbol, name)| (symbol, graph.symbol(name))).collect();
            terms.push((element.loops.clone(), graph.substitute(&[element.value], &images)[0]));
        }
        let member = self.display_terms(graph, terms, Rational::ONE, Some(*variable));
        let last = promised(count.shifted(-1), "ends of loops are integers");
        format!("{member}   for k=0..{}", self.index(&[], &last))
    }

    /// The terms of a sum in their loops, over all of which it sums but that of a family.
    fn display_terms(
        &self,
        graph: &mut Graph,
        terms: Vec<(Vec<Loop>, Expr)>,
        factor: Rational,
        family: Option<u32>,
    ) -> String {
        if terms.is_empty() {
            return "0".to_owned();
        }
        let is_summed = |known: &Loop| family != Some(known.variable);
        let (looped, flat): (Vec<_>, Vec<_>) =
            terms.into_iter().partition(|(loops, _)| loops.iter().any(is_summed));
        let mut parts = Vec::new();
        if !flat.is_empty() {
            let flat: Vec<(Expr, Rational)> = flat.into_iter().map(|(_, value)| (value, factor)).collect();
            let value = graph.linear_combination(&flat);
            parts.push(graph.display(value));
        }
        for (loops, value) in looped {
            let mut text = String::new();
            for known in loops.iter().filter(|known| is_summed(known)) {
                let range = self.range(LoopLetters { loops: &loops, family }, known);
                let _ = if is_condition(known) {
                    write!(text, "({range}) ")
                } else {
                    write!(text, "Σ_({range}) ")
                };
            }
            let value = graph.scale(value, factor);
            let _ = write!(text, "[{}]", graph.display(value));
            parts.push(text);
        }
        parts.join(" + ")
    }

    /// `   for i=0..n - 1, j=0..i - 1`
    pub(crate) fn placements(&self, loops: &[Loop]) -> String {
        let letters = LoopLetters { loops, family: None };
        let ranges: Vec<String> = loops.iter().map(|known| self.range(letters, known)).collect();
        if ranges.is_empty() { String::new() } else { format!("   for {}", ranges.join(", ")) }
    }

    /// The local variables of an element by the names of points and components.
    pub(crate) fn spelled(&self, graph: &mut Graph, element: &Element) -> HashMap<Symbol, Symbol> {
        self.spelled_in(graph, element, None)
    }

    /// The local variables of an element, in a family of functions those of one member.
    fn spelled_in(
        &self,
        graph: &mut Graph,
        element: &Element,
        family: Option<u32>,
    ) -> HashMap<Symbol, Symbol> {
        let letters = LoopLetters { loops: &element.loops, family };
        let spelled = element.locals.iter().map(|Local { symbol, slot }| {
            let name = match slot {
                Slot::Collective(_) => graph.symbol_name(*symbol).to_owned(),
                _ => self.reader(letters, |names| names.slot(slot, &self.names, self.components)),
            };
            (*symbol, graph.new_symbol_like(*symbol, name))
        });
        spelled.collect()
    }

    /// The range of one loop as text.
    fn range(&self, letters: LoopLetters<'_>, known: &Loop) -> String {
        let text = |index: &Index| self.reader(letters, |names| names.index(index));
        if is_condition(known) {
            return format!("where {} > 0", text(&known.end));
        }
        let last = promised(known.end.shifted(-1), "ends of loops are integers");
        format!("{}={}..{}", text(&super::variable(known.variable)), text(&known.start), text(&last))
    }
}
