//! From expressions with symbols for sums to elements: `f + Σ_i g_i` is the element `f` and the elements of
//! `g_i`, with one more loop. A factor in front of a sum moves inside.
//!
//! Derivatives are taken of elements that are split by the part of the state that they read. Values are
//! computed from the unsplit elements: split, `k (1 - cos d)` would be the difference of two sums of large
//! numbers.
//!
//! A sum over sites in the argument of a nonlinear function, `f(Σ_i g_i)`, becomes a collective variable
//! ([`crate::model::collective`]) that an element reads. One that reads the variable of a loop around it is
//! written out.
//!
//! Tests: `tests/loops/spellings.rs`, `tests/loops/collective.rs`.

use std::collections::HashMap;

use super::unroll::{Terms, Unroller, unroller_and_terms};
use crate::diagnostics::{Diagnostics, expressions};
use crate::distinct::Distinct;
use crate::model::symbols::IndexedSum;
use crate::model::{
    Atom, CollectiveRole, Element, Family, Half, Index, Loop, Reads, Slot, System, Term, Variables as _,
};
use crate::symbolic::{Expr, Graph, Node, Rational, Symbol};

/// Makes the elements of every term; reports terms that are not sums of elements.
pub(crate) fn collect(system: &mut System, diagnostics: &mut Diagnostics) {
    let degrees = degrees_of(system);
    let (mut writer, Terms { drift, noise, constraints, others, clock, .. }) = unroller_and_terms(system);
    let singles = drift.into_iter().chain(others).map(|term| (term, Vec::new()));
    let noise = noise.iter_mut().map(|noise| {
        let loops = members(noise.family.as_ref()).into_iter().collect();
        (&mut noise.term, loops)
    });
    let constraints = constraints.iter_mut().map(|constraint| {
        let loops = members(constraint.family.as_ref()).into_iter().collect();
        (&mut constraint.term, loops)
    });
    for (term, loops) in singles.chain(noise).chain(constraints) {
        if writer.collect(term, &loops).is_none() {
            diagnostics.report(expressions::nonlinear_sum(term.extent));
        }
        if let Some(degrees) = degrees
            && let Some(index) = term.values.iter().find_map(|element| outside(element, degrees))
        {
            diagnostics.report(expressions::index_outside(term.extent, index, degrees));
        }
    }
    if let Some(term) = clock {
        // The pass on clocks takes the derivatives that are needed.
        writer.collect_values(term, degrees, diagnostics);
    }
    let is_collective = |term: &&Term| term.values.iter().any(Element::is_collective);
    let noises = system.noise.iter().filter(|_| system.ito.is_some()).map(|noise| &noise.term);
    for term in noises.filter(is_collective) {
        diagnostics.report(expressions::collective_noise(term.extent));
    }
    let friction = system.friction.iter().map(|friction| &friction.term);
    let temperature = system.temperature.iter().map(|temperature| &temperature.term);
    for term in friction.chain(temperature).filter(is_collective) {
        diagnostics.report(expressions::collective_friction(term.extent));
    }
}

/// Makes the elements of the observables, for their values; reports those that are not sums of elements. It
/// runs when the facts of the system are known, which thus depend on no observable.
pub(crate) fn collect_observables(system: &mut System, diagnostics: &mut Diagnostics) {
    let known = system.collectives.all().len();
    let degrees = degrees_of(system);
    let (mut writer, Terms { observables, .. }) = unroller_and_terms(system);
    for term in observables {
        writer.collect_values(term, degrees, diagnostics);
    }
    system.first_observed = system.collectives.all().get(known).map(|first| first.slot.number);
}

/// The degrees of freedom, if they are known.
fn degrees_of(system: &System) -> Option<i128> {
    system.size.multiply(&Index::integer(system.components))?.as_integer()
}

/// The elements of the drift with what acts beside it, and those of the noises, without changes to the
/// system; `None` if a term is not a sum of elements. Nonlinear functions of sums of at most `most_written`
/// terms are written out.
pub(crate) fn sketched(system: &mut System, most_written: i128) -> Option<[Vec<Element>; 2]> {
    // Friction is a flow of its own in a thermostat.
    let friction = system.friction.iter().filter(|_| !system.has_thermostat());
    let beside = system.force.iter().chain(friction.map(|friction| &friction.term));
    let drift: Vec<Expr> = [&system.drift].into_iter().chain(beside).map(|term| term.expression).collect();
    let noise: Vec<(Expr, Vec<Loop>)> = system
        .noise
        .iter()
        .map(|noise| (noise.term.expression, members(noise.family.as_ref()).into_iter().collect()))
        .collect();
    let (mut writer, ..) = unroller_and_terms(system);
    (writer.collectives, writer.most_written) = (None, most_written);
    let mut elements = <[Vec<Element>; 2]>::default();
    for expression in drift {
        writer.decompose(expression, &[], &mut elements[0])?;
    }
    for (expression, loops) in noise {
        writer.decompose(expression, &loops, &mut elements[1])?;
    }
    Some(elements)
}

/// The loop over the members of a family.
fn members(family: Option<&Family>) -> Option<Loop> {
    let Family { variable, count } = family?;
    Some(Loop { variable: *variable, start: Default::default(), end: count.clone() })
}

/// Elements as derivatives need them: each reads only coordinates, only momenta, or what cannot be parted.
pub(crate) fn parted(system: &mut System, elements: &[Element]) -> Vec<Element> {
    let (mut writer, ..) = unroller_and_terms(system);
    elements.iter().flat_map(|element| writer.parted(element)).collect()
}

/// A place that an element reads, known and outside of the state.
fn outside(element: &Element, degrees: i128) -> Option<i128> {
    element.locals.iter().find_map(|local| match &local.slot {
        Slot::State(_, index) => index.as_integer().filter(|index| !(0..degrees).contains(index)),
        _ => None,
    })
}

impl Unroller<'_> {
    /// The elements of a term that needs no derivatives.
    fn collect_values(&mut self, term: &mut Term, degrees: Option<i128>, diagnostics: &mut Diagnostics) {
        if self.decompose(term.expression, &[], &mut term.values).is_none() {
            diagnostics.report(expressions::nonlinear_sum(term.extent));
        } else if let Some(degrees) = degrees
            && let Some(index) = term.values.iter().find_map(|element| outside(element, degrees))
        {
            diagnostics.report(expressions::index_outside(term.extent, index, degrees));
        }
    }

    /// The elements of a Hamiltonian inside of `loops`.
    fn collect(&mut self, term: &mut Term, loops: &[Loop]) -> Option<()> {
        let mut values = Vec::new();
        // Each member of a family has its own increment, by which slopes would differ.
        let collectives = if loops.is_empty() { None } else { self.collectives.take() };
        let decomposed = self.decompose(term.expression, loops, &mut values);
        self.collectives = self.collectives.take().or(collectives);
        decomposed?;
        let mut elements = Vec::new();
        for element in self.with_slopes(&values) {
            elements.extend(self.parted(&element));
        }
        term.elements = elements;
        term.values = values;
        Some(())
    }

    /// The elements with the first derivatives of `values` where collective variables count as constants.
    fn with_slopes(&mut self, values: &[Element]) -> Vec<Element> {
        match &mut self.collectives {
            Some(all) if !all.is_empty() => all.with_slopes(self.graph, self.t, values, self.symbols),
            _ => values.to_vec(),
        }
    }

    fn decompose(&mut self, expr: Expr, loops: &[Loop], into: &mut Vec<Element>) -> Option<()> {
        let (expr, present) = self.linear_in_sums(expr, !loops.is_empty())?;
        for (symbol, IndexedSum { range, body, .. }) in &present {
            let factor = self.graph.derivative(expr, *symbol);
            let body = self.graph.multiply(factor, *body);
            let mut inner = loops.to_vec();
            inner.push(range.clone());
            self.decompose(body, &inner, into)?;
        }
        let zero = self.graph.integer(0);
        let rest = present.iter().map(|(symbol, _)| (*symbol, zero)).collect();
        let rest = self.graph.substitute(&[expr], &rest)[0];
        if !self.graph.is_zero(rest) {
            let element = self.element(rest, loops);
            into.push(element);
        }
        Some(())
    }

    /// The collective variable of a sum that reads no displacement and no variable of a loop around it;
    /// `Some(None)` for another sum, `None` if its body is no sum of elements.
    fn collective(&mut self, symbol: Symbol, sum: &IndexedSum) -> Option<Option<Expr>> {
        let own = self.graph.symbol(symbol);
        if self.collectives.is_none() || !self.is_closed(own, &mut Vec::new()) {
            return Some(None);
        }
        let mut elements = Vec::new();
        self.decompose(sum.body, std::slice::from_ref(&sum.range), &mut elements)?;
        let elements: Vec<Element> =
            elements.iter().map(|element| self.renumbered(element)).collect::<Option<_>>()?;
        let Self { graph, symbols, t, collectives: Some(all), .. } = self else { return Some(None) };
        let variable = all.variable(graph, *t, CollectiveRole::Sum, elements, &mut **symbols);
        Some(Some(graph.symbol(variable)))
    }

    /// Whether an expression reads no displacement, and no variable of a loop but those of its own sums and
    /// those in `inside`.
    fn is_closed(&self, expr: Expr, inside: &mut Vec<u32>) -> bool {
        let is_known = |index: &Index, inside: &[u32]| index.loops().iter().all(|own| inside.contains(own));
        self.graph.symbols_in(expr).into_iter().all(|symbol| {
            if let Some(IndexedSum { range, body, .. }) = self.symbols.sum_of(symbol) {
                if ![&range.start, &range.end].into_iter().all(|index| is_known(index, inside)) {
                    return false;
                }
                inside.push(range.variable);
                let is_closed = self.is_closed(*body, inside);
                inside.pop();
                return is_closed;
            }
            self.symbols.local_of(symbol).is_none_or(|local| {
                !matches!(local.slot, Slot::State(Half::Displacements, _))
                    && local.slot.indices().iter().all(|index| is_known(index, inside))
            })
        })
    }

    /// An element whose loop variables are numbered by depth, so that equal sums are one, and sums over the
    /// same sites are in the same loops.
    fn renumbered(&mut self, element: &Element) -> Option<Element> {
        let mut loops = element.loops.clone();
        let mut by: Vec<(u32, Index)> = Vec::new();
        let moved = |index: &Index, by: &[(u32, Index)]| {
            by.iter().try_fold(index.clone(), |index, (own, by)| index.with(*own, by))
        };
        for (depth, known) in loops.iter_mut().enumerate() {
            let variable = self.symbols.variable_at(depth);
            known.start = moved(&known.start, &by)?;
            known.end = moved(&known.end, &by)?;
            by.push((std::mem::replace(&mut known.variable, variable), Index::atom(Atom::Loop(variable))));
        }
        let mut images = HashMap::new();
        for local in &element.locals {
            let slot = local.slot.map(|index| moved(index, &by))?;
            if slot != local.slot {
                let symbol = self.symbols.local(self.graph, slot, self.tables);
                images.insert(local.symbol, self.graph.symbol(symbol));
            }
        }
        let value = self.graph.substitute(&[element.value], &images)[0];
        Some(self.symbols.element_in(self.graph, loops, value))
    }

    /// `expr` with collective variables for the sums in arguments of nonlinear functions, or with these
    /// written out, and its other sums. Inside of loops a sum that reads none of their variables is a
    /// collective variable, too, so that it is evaluated once.
    fn linear_in_sums(
        &mut self,
        mut expr: Expr,
        is_inside: bool,
    ) -> Option<(Expr, Vec<(Symbol, IndexedSum)>)> {
        loop {
            let symbols = self.graph.symbols_in(expr).into_iter();
            let present: Vec<(Symbol, IndexedSum)> =
                symbols.filter_map(|symbol| Some((symbol, self.symbols.sum_of(symbol)?.clone()))).collect();
            let names: Vec<Symbol> = present.iter().map(|(symbol, _)| *symbol).collect();
            let is_nonlinear = present.iter().map(|(symbol, _)| {
                let factor = self.graph.derivative(expr, *symbol);
                self.graph.depends_on(factor, &names) || self.graph.has_pieces(expr, &[*symbol])
            });
            let is_nonlinear: Vec<bool> = is_nonlinear.collect();
            let mut images = HashMap::new();
            for ((symbol, sum), is_nonlinear) in present.iter().zip(&is_nonlinear) {
                if (*is_nonlinear || is_inside)
                    && let Some(variable) = self.collective(*symbol, sum)?
                {
                    images.insert(*symbol, variable);
                }
            }
            // The others may be linear now: the displacement in `δq_j f(S)`.
            if images.is_empty() {
                for ((symbol, sum), _) in present.iter().zip(&is_nonlinear).filter(|(_, known)| **known) {
                    let written = self.written_out(sum)?;
                    images.insert(*symbol, written);
                }
            }
            if images.is_empty() {
                return Some((expr, present));
            }
            expr = self.graph.substitute(&[expr], &images)[0];
        }
    }

    /// One element for the terms that read coordinates, one for those that read momenta, one for those that
    /// read both.
    fn parted(&mut self, element: &Element) -> Vec<Element> {
        let mut groups: Vec<(Reads, Vec<(Expr, Rational)>)> = Vec::new();
        let mut opened = Opened { terms: HashMap::new(), most: self.graph.reachable(&[element.value]).len() };
        for (term, coefficient) in self.split(element.value, &mut opened) {
            let reads = self.reads(term);
            match groups.iter_mut().find(|(known, _)| *known == reads) {
                Some((_, terms)) => terms.push((term, coefficient)),
                None => groups.push((reads, vec![(term, coefficient)])),
            }
        }
        let values = groups.iter().map(|(_, terms)| self.graph.linear_combination(terms));
        let values: Vec<Expr> = values.collect();
        let parts = values.into_iter().filter(|&value| !self.graph.is_zero(value));
        parts.map(|value| self.element(value, &element.loops)).collect()
    }

    fn element(&self, value: Expr, loops: &[Loop]) -> Element {
        let locals = self.symbols.locals_among(self.graph.symbols_in(value).into_iter());
        Element { loops: loops.to_vec(), value, locals }
    }

    fn reads(&self, value: Expr) -> Reads {
        self.element(value, &[]).reads()
    }

    /// The terms of a sum, each once; a factor that reads no state is multiplied out.
    fn split(&mut self, expr: Expr, opened: &mut Opened) -> Vec<(Expr, Rational)> {
        if let Some(terms) = opened.terms.get(&expr) {
            return terms.clone();
        }
        let all = match self.graph.node(expr).clone() {
            Node::Sum { terms, constant } => {
                let mut all = Merged::default();
                for (term, coefficient) in terms {
                    for (inner, weight) in self.split(term, opened) {
                        match weight.multiply(coefficient) {
                            Some(weight) => all.add(self.graph, inner, weight),
                            None => {
                                let inner = self.graph.scale(inner, weight);
                                all.add(self.graph, inner, coefficient);
                            }
                        }
                    }
                }
                if !constant.is_zero() {
                    let one = self.graph.integer(1);
                    all.add(self.graph, one, constant);
                }
                all.0.values
            }
            Node::Product(factors) => self.multiply_out(expr, &factors, opened),
            Node::Select { condition, then, otherwise } if self.reads(condition) == NOTHING => {
                self.split_branches(condition, [then, otherwise], opened)
            }
            _ => vec![(expr, Rational::ONE)],
        };
        opened.terms.insert(expr, all.clone());
        all
    }

    /// The terms of both branches under a condition that reads no state: one for each part of the state that
    /// terms read.
    fn split_branches(
        &mut self,
        condition: Expr,
        branches: [Expr; 2],
        opened: &mut Opened,
    ) -> Vec<(Expr, Rational)> {
        // Terms that read the same part of the state, branch by branch.
        let mut groups: Vec<(Reads, [SplitTerms; 2])> = Vec::new();
        for (side, branch) in branches.into_iter().enumerate() {
            for term in self.split(branch, opened) {
                let reads = self.reads(term.0);
                match groups.iter_mut().find(|(known, _)| *known == reads) {
                    Some((_, sides)) => sides[side].push(term),
                    None => {
                        let mut sides: [SplitTerms; 2] = Default::default();
                        sides[side].push(term);
                        groups.push((reads, sides));
                    }
                }
            }
        }
        let selected = groups.into_iter().map(|(_, sides)| {
            let [then, otherwise] = sides.map(|terms| self.graph.linear_combination(&terms));
            (self.graph.select(condition, then, otherwise), Rational::ONE)
        });
        selected.collect()
    }

    fn multiply_out(
        &mut self,
        expr: Expr,
        factors: &[(Expr, Rational)],
        opened: &mut Opened,
    ) -> Vec<(Expr, Rational)> {
        let whole = vec![(expr, Rational::ONE)];
        let reads_state = |part: Expr| self.reads(part) != NOTHING;
        let moving: Vec<usize> = (0..factors.len()).filter(|&i| reads_state(factors[i].0)).collect();
        let &[only] = moving.as_slice() else { return whole };
        let (base, exponent) = factors[only];
        if !exponent.is_one() || !matches!(self.graph.node(base), Node::Sum { .. } | Node::Select { .. }) {
            return whole;
        }
        let terms = self.split(base, opened);
        if terms.len() == 1 || terms.len() > opened.most {
            return whole;
        }
        let others = factors.iter().enumerate().filter(|&(i, _)| i != only);
        let others = others.map(|(_, &(base, exponent))| self.graph.power(base, exponent));
        let others: Vec<Expr> = others.collect();
        let factor = self.graph.product(&others);
        terms.into_iter().map(|(term, weight)| (self.graph.multiply(factor, term), weight)).collect()
    }
}

/// Terms with their coefficients.
type SplitTerms = Vec<(Expr, Rational)>;

/// The reads of a number that does not depend on the state.
const NOTHING: Reads = Reads { q: false, p: false };

/// The state while an expression is split.
struct Opened {
    terms: HashMap<Expr, Vec<(Expr, Rational)>>,
    /// The nodes of the expression. Longer sums are not multiplied out: the terms of nested shared sums
    /// double with each level.
    most: usize,
}

/// Terms and their coefficients, in the order in which they came.
#[derive(Default)]
struct Merged(Distinct<Expr, (Expr, Rational)>);

impl Merged {
    fn add(&mut self, graph: &mut Graph, term: Expr, coefficient: Rational) {
        let place = self.0.place(term, || (term, Rational::ZERO));
        let (_, total) = &mut self.0.values[place];
        match total.add(coefficient) {
            Some(sum) => *total = sum,
            // The coefficient leaves the exact range.
            None => {
                let scaled = graph.scale(term, coefficient);
                self.add(graph, scaled, Rational::ONE);
            }
        }
    }
}
