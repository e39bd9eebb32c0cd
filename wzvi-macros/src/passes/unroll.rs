//! Unrolling of loops of literal length. Sums are symbols until here; a sum is unrolled by its body at each
//! value of the loop variable.
//!
//! * A system whose steps are all in straight lines (see `choose`) is written out as a whole, so that each
//!   degree of freedom is a variable of its own,
//! * in another one, short sums: components of points, stencils, corners,
//! * and, anywhere, sums that cannot be loops: arguments of nonlinear functions.
//!
//! Tests: `tests/loops/seam.rs`, `tests/loops/spellings.rs`.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use quote::quote;

use crate::indices::Indices;
use crate::model::symbols::{IndexedSum, Symbols};
use crate::model::{
    CollectiveSlot, Collectives, Family, FamilyTerm, Form, Index, Local, Loop, Noise, Parameter, Phase, Slot,
    StraightLine, System, Table, Term,
};
use crate::symbolic::{Expr, Graph, Rational, Symbol};

/// Bounds of a sum that is unrolled. With more nodes the code of derivatives is larger than that of a loop,
/// and no faster.
#[derive(Clone, Copy)]
struct ShortSum {
    /// The most turns of its loop.
    turns: i128,
    /// The most nodes of the sum that is written out.
    nodes: usize,
}

/// An inner loop that is unrolled.
const INNER: ShortSum = ShortSum { turns: 16, nodes: 200 };

/// An outermost loop of a system in loops that is unrolled. Longer ones run vectorised over neighbours, which
/// pays for their setup.
const OUTERMOST: ShortSum = ShortSum { turns: 8, nodes: 24 };

/// The most points of a system that is written out where its elements are refused in loops.
const POINTS: i128 = 16;

/// The most operations of an unrolled Hamiltonian: more code takes minutes to compile.
const OPERATIONS: usize = 20_000;

/// Whether a system is written out where its elements are refused in loops.
pub(crate) fn may_be_written_out(system: &System) -> bool {
    system.size.as_integer().is_some_and(|points| points <= POINTS)
}

/// Unrolls all loops, or short ones, by the form of the elements.
pub(crate) fn unroll(system: &mut System) {
    if system.form == Form::StraightLines && unroll_all(system) {
        return;
    }
    system.form = Form::Loops;
    let (mut writer, terms) = unroller_and_terms(system);
    for term in terms.all() {
        writer.spent = 0;
        term.expression = writer.without_short_sums(term.expression, OUTERMOST);
    }
}

/// The terms of a system.
pub(super) struct Terms<'s> {
    /// The drift and its parts.
    pub(super) drift: Vec<&'s mut Term>,
    pub(super) noise: &'s mut Vec<Noise>,
    pub(super) constraints: &'s mut Vec<FamilyTerm>,
    /// First integrals, force, friction, temperature.
    pub(super) others: Vec<&'s mut Term>,
    pub(super) observables: &'s mut Vec<Term>,
    /// The clock, or the frequency in it.
    pub(super) clock: Option<&'s mut Term>,
}

impl<'s> Terms<'s> {
    /// All terms, one after the other.
    pub(super) fn all(self) -> impl Iterator<Item = &'s mut Term> {
        let noise = self.noise.iter_mut().map(|noise| &mut noise.term);
        let constraints = self.constraints.iter_mut().map(|constraint| &mut constraint.term);
        let all = self.drift.into_iter().chain(noise).chain(constraints).chain(self.others).chain(self.clock);
        all.chain(self.observables)
    }
}

/// An unroller, and the terms that it works on.
pub(super) fn unroller_and_terms(system: &mut System) -> (Unroller<'_>, Terms<'_>) {
    let System {
        graph,
        symbols,
        t,
        collectives,
        tables,
        drift,
        summands,
        noise,
        force,
        friction,
        temperature,
        invariants,
        observables,
        constraints,
        clock,
        ..
    } = system;
    let friction = friction.iter_mut().map(|friction| &mut friction.term);
    let temperature = temperature.iter_mut().map(|temperature| &mut temperature.term);
    let others = invariants.iter_mut().chain(force).chain(friction).chain(temperature);
    let drift = [drift].into_iter().chain(summands);
    (
        Unroller { collectives: Some(collectives), ..Unroller::new(graph, symbols, *t, tables) },
        Terms {
            drift: drift.collect(),
            noise,
            constraints,
            others: others.collect(),
            observables,
            clock: clock.as_mut().map(|clock| &mut clock.term),
        },
    )
}

/// Unrolls every loop and family; `false`, without changes, if that is impossible. Observables do not decide
/// it: long ones keep their loops.
fn unroll_all(system: &mut System) -> bool {
    let (mut writer, Terms { drift, noise, constraints, others, observables, clock }) =
        unroller_and_terms(system);
    let singles: Vec<&mut Term> = drift.into_iter().chain(others).chain(clock).collect();
    let Some(written) = writer.expressions(&singles) else { return false };
    let mut noises = Vec::with_capacity(noise.len());
    for Noise { term, family, is_force } in &*noise {
        let Some(members) = writer.members(term, family.as_ref()) else { return false };
        noises.extend(members.into_iter().map(|term| Noise { term, family: None, is_force: *is_force }));
    }
    let mut constraining = Vec::with_capacity(constraints.len());
    for FamilyTerm { term, family } in &*constraints {
        let Some(members) = writer.members(term, family.as_ref()) else { return false };
        constraining.extend(members.into_iter().map(|term| FamilyTerm { term, family: None }));
    }
    (*noise, *constraints) = (noises, constraining);
    for (term, expression) in singles.into_iter().zip(written) {
        term.expression = expression;
    }
    for term in observables {
        writer.spent = 0;
        let written = writer.at(term.expression, &BTreeMap::new());
        writer.spent = 0;
        term.expression = written.unwrap_or_else(|| writer.without_short_sums(term.expression, OUTERMOST));
    }
    true
}

/// Replaces sums by their bodies. Fails if this takes more than [`OPERATIONS`], or if a bound is known at run
/// time only.
pub(super) struct Unroller<'a> {
    pub(super) graph: &'a mut Graph,
    pub(super) symbols: &'a mut Symbols,
    pub(super) t: Symbol,
    /// Where sums in nonlinear functions become collective variables; without it they are written out.
    pub(super) collectives: Option<&'a mut Collectives>,
    pub(super) tables: &'a [Table],
    /// The most terms of a sum in a nonlinear function that is written out.
    pub(super) most_written: i128,
    spent: usize,
}

impl<'a> Unroller<'a> {
    fn new(graph: &'a mut Graph, symbols: &'a mut Symbols, t: Symbol, tables: &'a [Table]) -> Self {
        Self { graph, symbols, t, collectives: None, tables, most_written: OPERATIONS as i128, spent: 0 }
    }

    fn expressions(&mut self, terms: &[&mut Term]) -> Option<Vec<Expr>> {
        let written = terms.iter().map(|term| {
            self.spent = 0;
            self.at(term.expression, &BTreeMap::new())
        });
        written.collect()
    }

    /// The members of a family, or the one term, with every loop unrolled.
    fn members(&mut self, term: &Term, family: Option<&Family>) -> Option<Vec<Term>> {
        let range = match family {
            None => 0..1,
            Some(Family { count, .. }) => {
                0..count.as_integer().filter(|&count| count <= OPERATIONS as i128)?
            }
        };
        self.spent = 0;
        let members = range.map(|member| {
            let values = family.iter().map(|family| (family.variable, member)).collect();
            let expression = self.at(term.expression, &values)?;
            Some(Term { expression, ..term.clone() })
        });
        members.collect()
    }

    /// `expr` with short sums unrolled, and short ones in the bodies of the others, too.
    fn without_short_sums(&mut self, expr: Expr, short: ShortSum) -> Expr {
        let mut images = HashMap::new();
        for symbol in self.graph.symbols_in(expr) {
            let Some(IndexedSum { range, body, .. }) = self.symbols.sum_of(symbol).cloned() else { continue };
            let body = self.without_short_sums(body, INNER);
            let is_short = range.length().is_some_and(|length| length <= short.turns);
            let written = if is_short { self.turns(&range, body, &BTreeMap::new()) } else { None };
            let written = written.filter(|&sum| self.graph.reachable(&[sum]).len() <= short.nodes);
            let image = match written {
                // Unrolling may have made inner loops short.
                Some(sum) => self.without_short_sums(sum, short),
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
    pub(super) fn written_out(&mut self, sum: &IndexedSum) -> Option<Expr> {
        self.spent = 0;
        if sum.range.length().is_some_and(|length| length > self.most_written) {
            return None;
        }
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
            if let Some(IndexedSum { range, body, .. }) = self.symbols.sum_of(symbol).cloned() {
                images.insert(symbol, self.turns(&range, body, values)?);
            } else if let Some(Slot::Collective(slot)) =
                self.symbols.local_of(symbol).map(|local| &local.slot)
            {
                let slot = *slot;
                images.insert(symbol, self.written_collective(slot)?);
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

/// The system with a variable for each degree of freedom; `None` if places or bounds are known at run time
/// only.
pub(crate) fn written_out(system: &mut System) -> Option<StraightLine> {
    let line = placed(system)?;
    let is_whole = system.form == Form::StraightLines;
    let mut read: BTreeSet<Symbol> = match is_whole {
        true => {
            system.terms().flat_map(|term| &term.values).flat_map(|e| &e.locals).map(|l| l.symbol).collect()
        }
        false => BTreeSet::new(),
    };
    read.extend(symbols_of(&system.graph, &line));
    let locals = system.symbols.locals_among(read.into_iter());
    if !locals.iter().all(is_known) {
        return None;
    }
    let parameters = parameters_with(system, &locals);
    // Elements in loops have no parameters for entries of lists, which may differ between the lanes of a
    // sweep.
    if !is_whole && parameters.len() > system.parameters.len() {
        return None;
    }
    Some(StraightLine { parameters, ..line })
}

/// The system with a variable for each degree of freedom, and with those of entries of lists beside the
/// parameters; `None` if places or bounds are known at run time only.
pub(crate) fn placed(system: &mut System) -> Option<StraightLine> {
    let [q, p] = system.symbols.phase();
    if q.is_empty() {
        return None;
    }
    let t = system.t;
    let has_covectors = system.has_forces() || system.friction.is_some();
    let displacements = match has_covectors {
        true => system.symbols.displacements(&mut system.graph),
        false => Vec::new(),
    };
    let phase = Phase { q, p, displacements, t };
    let System { graph, symbols, collectives, tables, drift, noise, force, .. } = system;
    let collectives = Some(collectives);
    let mut writer = Unroller { collectives, ..Unroller::new(graph, symbols, t, tables) };
    let drift = writer.placements(drift, &BTreeMap::new())?;
    let force = match force {
        Some(force) => Some(writer.placements(force, &BTreeMap::new())?),
        None => None,
    };
    let (mut hamiltonians, mut forces) = (Vec::new(), Vec::new());
    for Noise { term, family, is_force } in &*noise {
        let of_kind = if *is_force { &mut forces } else { &mut hamiltonians };
        match family {
            None => of_kind.push(writer.placements(term, &BTreeMap::new())?),
            Some(Family { variable, count }) => {
                for member in 0..count.as_integer()? {
                    of_kind.push(writer.placements(term, &BTreeMap::from([(*variable, member)]))?);
                }
            }
        }
    }
    let mut components = |work: &Expr| phase.components(graph, *work);
    let force = force.as_ref().map(&mut components);
    let noise_forces = forces.iter().map(components).collect();
    let (parameters, conformal) = (system.parameters.clone(), system.conformal);
    let line = StraightLine { phase, parameters, drift, noise: hamiltonians, force, noise_forces, conformal };
    let locals = system.symbols.locals_among(symbols_of(&system.graph, &line).into_iter());
    locals.iter().all(is_known).then_some(line)
}

/// The symbols in the expressions of a system.
fn symbols_of(graph: &Graph, line: &StraightLine) -> BTreeSet<Symbol> {
    let forces = line.force.iter().chain(&line.noise_forces).flatten();
    let roots: Vec<Expr> = [line.drift].iter().chain(&line.noise).chain(forces).copied().collect();
    graph.reachable(&roots).into_iter().filter_map(|part| graph.as_symbol(part)).collect()
}

/// Whether a place is known when this compiles.
fn is_known(local: &Local) -> bool {
    match &local.slot {
        Slot::State(_, index) => index.as_integer().is_some(),
        slot => !slot.indices().iter().any(|index| index.reads_size() || !index.loops().is_empty()),
    }
}

/// The parameters of the system, and the entries of lists among `locals`, in order of first use.
fn parameters_with(system: &System, locals: &[Local]) -> Vec<Parameter> {
    let indices = Indices { tables: &system.tables, checked: true, lists: &[] };
    let mut parameters = system.parameters.clone();
    for Local { symbol, slot } in locals {
        let tokens = match slot {
            Slot::State(..) | Slot::Collective(_) => continue,
            Slot::Number(index) => {
                let value = indices.value(index);
                indices.or_nan(&quote!(#value as ::core::primitive::f64))
            }
            Slot::Entry(table, entries) => indices.constant_entry(*table, entries),
        };
        parameters.push(Parameter { symbol: *symbol, tokens, is_integer: matches!(slot, Slot::Number(_)) });
    }
    parameters.sort_by_key(|parameter| parameter.symbol.index());
    parameters
}

impl Unroller<'_> {
    /// The sum of all elements of a term at the turns of their loops, where variables of outer loops have
    /// `values`.
    fn placements(&mut self, term: &Term, values: &BTreeMap<u32, i128>) -> Option<Expr> {
        self.spent = 0;
        let mut terms = Vec::new();
        for element in &term.values {
            let loops: Vec<&Loop> =
                element.loops.iter().filter(|known| !values.contains_key(&known.variable)).collect();
            self.place(element.value, &loops, &mut values.clone(), &mut terms)?;
        }
        Some(self.graph.sum(&terms))
    }

    /// A collective variable, written out.
    fn written_collective(&mut self, slot: CollectiveSlot) -> Option<Expr> {
        let elements = self.collectives.as_ref()?.of(slot).elements.clone();
        let mut terms = Vec::new();
        for element in &elements {
            let loops: Vec<&Loop> = element.loops.iter().collect();
            self.place(element.value, &loops, &mut BTreeMap::new(), &mut terms)?;
        }
        Some(self.graph.sum(&terms))
    }

    fn place(
        &mut self,
        value: Expr,
        loops: &[&Loop],
        values: &mut BTreeMap<u32, i128>,
        terms: &mut Vec<Expr>,
    ) -> Option<()> {
        let Some((outermost, inner)) = loops.split_first() else {
            let is_whole = values.is_empty() && self.collectives.as_ref().is_none_or(|all| all.is_empty());
            terms.push(if is_whole { value } else { self.at(value, values)? });
            return Some(());
        };
        let known = |index: &Index| index.at(values).and_then(|index| index.as_integer());
        for turn in known(&outermost.start)?..known(&outermost.end)? {
            values.insert(outermost.variable, turn);
            self.place(value, inner, values, terms)?;
        }
        values.remove(&outermost.variable);
        Some(())
    }
}

impl Loop {
    /// The number of iterations, if it is known.
    pub(super) fn length(&self) -> Option<i128> {
        self.end.subtract(&self.start)?.as_integer()
    }
}
