//! Unrolling of loops of literal length. Sums are symbols until here; a sum is unrolled by its body at each value of the
//! loop variable. The choice is by cost, and all its thresholds are here:
//!
//! * a system of few points is written out as a whole, so that each degree of freedom is a variable of its own,
//! * in a larger one, short sums: components of points, stencils, corners,
//! * and, anywhere, sums that cannot be loops: arguments of nonlinear functions.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use quote::quote;

use crate::indices::Indices;
use crate::model::symbols::{Sum, Symbols};
use crate::model::{
    Family, Index, Local, Loop, Noise, Parameter, Phase, Slot, StraightLine, System, Table, Term,
};
use crate::symbolic::{Expr, Graph, Rational, Symbol};

/// The most turns of a loop, and points of a system, that are unrolled: there, straight-line code with dense
/// elimination is as fast as a sweep.
const TURNS: i128 = 16;

/// The most turns of an outermost loop of a larger system that is unrolled. Longer ones run vectorised over neighbours, which
/// pays for their setup.
const OUTERMOST: i128 = 8;

/// The most operations of an unrolled Hamiltonian: more code takes minutes to compile.
const OPERATIONS: usize = 20_000;

/// Unrolls loops if that costs less.
pub(crate) fn unroll(system: &mut System) {
    if is_small(system) && unroll_all(system) {
        return;
    }
    let (mut writer, before, noise, after) = parts(system);
    let noise = noise.iter_mut().map(|noise| &mut noise.term);
    for term in before.into_iter().chain(noise).chain(after) {
        writer.spent = 0;
        term.expression = writer.without_short_sums(term.expression, OUTERMOST);
    }
}

/// A writer, and the terms: those before the noises, the noises, and those after them.
pub(super) fn parts(system: &mut System) -> (Writer<'_>, Vec<&mut Term>, &mut Vec<Noise>, Vec<&mut Term>) {
    let System {
        graph, symbols, tables, drift, parts, noise, force, friction, temperature, invariants, ..
    } = system;
    let friction = friction.iter_mut().map(|friction| &mut friction.term);
    let temperature = temperature.iter_mut().map(|temperature| &mut temperature.term);
    let after = invariants.iter_mut().chain(force).chain(friction).chain(temperature);
    (Writer::new(graph, symbols, tables), [drift].into_iter().chain(parts).collect(), noise, after.collect())
}

/// Whether each degree of freedom becomes a separate variable.
fn is_small(system: &System) -> bool {
    system.size.as_integer().is_some_and(|points| points <= TURNS)
}

/// Unrolls every loop and family; `false`, without changes, if that is impossible.
fn unroll_all(system: &mut System) -> bool {
    let (mut writer, before, noise, after) = parts(system);
    let Some(first) = writer.expressions(&before) else { return false };
    let mut members = Vec::with_capacity(noise.len());
    for Noise { term, family, is_force } in &*noise {
        let range = match family {
            None => 0..1,
            Some(Family { count, .. }) => match count.as_integer() {
                Some(count) if count <= OPERATIONS as i128 => 0..count,
                _ => return false,
            },
        };
        writer.spent = 0;
        for member in range {
            let values = family.iter().map(|family| (family.variable, member)).collect();
            let Some(expression) = writer.at(term.expression, &values) else { return false };
            let term = Term { expression, ..term.clone() };
            members.push(Noise { term, family: None, is_force: *is_force });
        }
    }
    let Some(last) = writer.expressions(&after) else { return false };
    *noise = members;
    for (term, expression) in before.into_iter().chain(after).zip([first, last].concat()) {
        term.expression = expression;
    }
    true
}

/// Replaces sums by their bodies. Fails if this takes more than [`OPERATIONS`], or if a bound is known at run time only.
pub(super) struct Writer<'a> {
    pub(super) graph: &'a mut Graph,
    pub(super) symbols: &'a mut Symbols,
    tables: &'a [Table],
    spent: usize,
}

impl<'a> Writer<'a> {
    fn new(graph: &'a mut Graph, symbols: &'a mut Symbols, tables: &'a [Table]) -> Self {
        Self { graph, symbols, tables, spent: 0 }
    }

    fn expressions(&mut self, terms: &[&mut Term]) -> Option<Vec<Expr>> {
        let written = terms.iter().map(|term| {
            self.spent = 0;
            self.at(term.expression, &BTreeMap::new())
        });
        written.collect()
    }

    /// `expr` with sums of at most `turns` turns unrolled, and short ones in the bodies of the others, too.
    fn without_short_sums(&mut self, expr: Expr, turns: i128) -> Expr {
        let mut images = HashMap::new();
        for symbol in self.graph.symbols_in(expr) {
            let Some(Sum { range, body, .. }) = self.symbols.sum_of(symbol).cloned() else { continue };
            let body = self.without_short_sums(body, TURNS);
            let is_short = range.length().is_some_and(|length| length <= turns);
            let written = if is_short { self.turns(&range, body, &BTreeMap::new()) } else { None };
            let image = match written {
                // Unrolling may have made inner loops short.
                Some(sum) => self.without_short_sums(sum, turns),
                None => {
                    let symbol = self.symbols.sum(self.graph, range, body);
                    self.graph.symbol(symbol)
                }
            };
            images.insert(symbol, image);
        }
        self.substituted(expr, &images)
    }

    /// One sum, written out.
    pub(super) fn written_out(&mut self, sum: &Sum) -> Option<Expr> {
        self.spent = 0;
        self.turns(&sum.range, sum.body, &BTreeMap::new())
    }

    /// `expr` with `values` of loop variables; inner sums whose ranges are then known are unrolled, too.
    fn at(&mut self, expr: Expr, values: &BTreeMap<u32, i128>) -> Option<Expr> {
        let parts = self.graph.reachable(&[expr]);
        self.spent = self.spent.saturating_add(parts.len());
        if self.spent > OPERATIONS {
            return None;
        }
        let symbols: Vec<Symbol> = parts.into_iter().filter_map(|part| self.graph.as_symbol(part)).collect();
        let mut images = HashMap::new();
        for symbol in symbols {
            if let Some(Sum { range, body, .. }) = self.symbols.sum_of(symbol).cloned() {
                images.insert(symbol, self.turns(&range, body, values)?);
            } else if let Some(local) = self.symbols.local_of(symbol) {
                let slot = local.slot.clone();
                let moved = slot.map(|index| index.at(values))?;
                if moved != slot {
                    images.insert(symbol, self.slot(moved));
                }
            }
        }
        Some(self.substituted(expr, &images))
    }

    /// `Σ_(range) body` where outer loop variables have `values`.
    fn turns(&mut self, range: &Loop, body: Expr, values: &BTreeMap<u32, i128>) -> Option<Expr> {
        let known = |index: &Index| index.at(values).and_then(|index| index.as_integer());
        let (start, end) = (known(&range.start)?, known(&range.end)?);
        if end.saturating_sub(start) > OPERATIONS as i128 {
            return None;
        }
        let mut terms = Vec::new();
        let mut values = values.clone();
        for turn in start..end {
            values.insert(range.variable, turn);
            terms.push((self.at(body, &values)?, Rational::ONE));
        }
        Some(self.graph.linear_combination(&terms))
    }

    fn slot(&mut self, slot: Slot) -> Expr {
        if let Slot::Number(index) = &slot
            && let Some(number) = index.as_integer()
        {
            return self.graph.whole(number);
        }
        let symbol = self.symbols.local(self.graph, slot, self.tables);
        self.graph.symbol(symbol)
    }

    fn substituted(&mut self, expr: Expr, images: &HashMap<Symbol, Expr>) -> Expr {
        if images.is_empty() {
            return expr;
        }
        self.graph.substitute(&[expr], images).first().copied().unwrap_or(expr)
    }
}

/// The system with a variable for each degree of freedom; `None` if it has many points, remaining loops, or indices known at run time
/// only.
pub(crate) fn written_out(system: &mut System) -> Option<StraightLine> {
    let locals = if is_small(system) { known_locals(system) } else { None };
    let locals = locals?;
    let has_covectors = system.has_forces() || system.friction.is_some();
    let System { graph, symbols, tables, parameters, t, drift, noise, force, conformal, .. } = system;
    let displacements = if has_covectors { symbols.displacements(graph) } else { Vec::new() };
    let indices = Indices { tables, checked: true, lists: &[] };
    let mut parameters = parameters.clone();
    for Local { symbol, slot } in locals {
        let tokens = match &slot {
            Slot::State(_, _) => continue,
            Slot::Number(index) => {
                let value = indices.value(index);
                indices.or_nan(&quote!(#value as ::core::primitive::f64))
            }
            Slot::Entry(table, entries) => indices.constant_entry(*table, entries),
        };
        parameters.push(Parameter { symbol, tokens, is_integer: matches!(slot, Slot::Number(_)) });
    }
    // In order of first use.
    parameters.sort_by_key(|parameter| parameter.symbol.index());
    let [q, p] = symbols.phase();
    let phase = Phase { q, p, displacements, t: *t };
    let mut value = |term: &Term| {
        let values: Vec<Expr> = term.values.iter().map(|element| element.value).collect();
        graph.sum(&values)
    };
    let work = force.as_ref().map(&mut value);
    let (forces, noise): (Vec<&Noise>, Vec<&Noise>) = noise.iter().partition(|noise| noise.is_force);
    let forces: Vec<Expr> = forces.into_iter().map(|noise| value(&noise.term)).collect();
    let drift = value(drift);
    let noise = noise.into_iter().map(|noise| value(&noise.term)).collect();
    let force = work.map(|work| phase.components(graph, work));
    let noise_forces = forces.into_iter().map(|work| phase.components(graph, work)).collect();
    Some(StraightLine { phase, parameters, drift, noise, force, noise_forces, conformal: *conformal })
}

/// The local variables of a system in straight-line form: no element has loops, and no index reads the size of the state.
fn known_locals(system: &System) -> Option<Vec<Local>> {
    let is_single = |noise: &Noise| noise.family.is_none();
    let elements = || system.terms().flat_map(|term| &term.values);
    if !system.noise.iter().all(is_single) || elements().any(|element| !element.loops.is_empty()) {
        return None;
    }
    let read: BTreeSet<Symbol> = elements().flat_map(|e| &e.locals).map(|local| local.symbol).collect();
    let locals = system.symbols.locals_among(read.into_iter());
    let has_phase = !system.symbols.phase()[0].is_empty();
    let is_known = |local: &Local| match &local.slot {
        Slot::State(_, index) => has_phase && index.as_integer().is_some(),
        slot => !slot.indices().iter().any(Index::reads_size),
    };
    locals.iter().all(is_known).then_some(locals)
}

impl Loop {
    /// Its number of turns, if that is known.
    fn length(&self) -> Option<i128> {
        self.end.subtract(&self.start)?.as_integer()
    }
}
