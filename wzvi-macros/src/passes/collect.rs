//! From expressions with symbols for sums to elements: `f + Σ_i g_i` is the element `f` and the elements of
//! `g_i`, with one more loop. A factor in front of a sum moves inside.
//!
//! Derivatives are taken of elements that are split by the part of the state that they read. Values are
//! computed from the unsplit elements: split, `k (1 - cos d)` would be the difference of two sums of large
//! numbers.
//!
//! Tests: `tests/loops/spellings.rs`.

use std::collections::HashMap;

use super::unroll::{Unroller, unroller_and_terms};
use crate::diagnostics::{Diagnostics, expressions};
use crate::distinct::Distinct;
use crate::model::symbols::IndexedSum;
use crate::model::{Element, Family, Index, Loop, Noise, Reads, Slot, System, Term};
use crate::symbolic::{Expr, Graph, Node, Rational, Symbol};

/// Makes the elements of every term; reports terms that are not sums of elements.
pub(crate) fn collect(system: &mut System, diagnostics: &mut Diagnostics) {
    let degrees = system.size.multiply(&Index::integer(system.components)).and_then(|all| all.as_integer());
    let (mut writer, before, noise, after) = unroller_and_terms(system);
    let singles = before.into_iter().chain(after).map(|term| (term, Vec::new()));
    let noise = noise.iter_mut().map(|noise| {
        let loops = members(noise).into_iter().collect();
        (&mut noise.term, loops)
    });
    for (term, loops) in singles.chain(noise) {
        if writer.collect(term, &loops).is_none() {
            diagnostics.report(expressions::nonlinear_sum(term.extent));
        }
        if let Some(degrees) = degrees
            && let Some(index) = term.values.iter().find_map(|element| outside(element, degrees))
        {
            diagnostics.report(expressions::index_outside(term.extent, index, degrees));
        }
    }
}

/// The elements of the drift with what acts beside it, and those of the noises, without changes to the
/// system; `None` if a term is not a sum of elements.
pub(crate) fn sketched(system: &mut System) -> Option<[Vec<Element>; 2]> {
    // Friction is a flow of its own in a thermostat.
    let friction = system.friction.iter().filter(|_| !system.has_thermostat());
    let beside = system.force.iter().chain(friction.map(|friction| &friction.term));
    let drift: Vec<Expr> = [&system.drift].into_iter().chain(beside).map(|term| term.expression).collect();
    let noise: Vec<(Expr, Vec<Loop>)> = system
        .noise
        .iter()
        .map(|noise| (noise.term.expression, members(noise).into_iter().collect()))
        .collect();
    let (mut writer, ..) = unroller_and_terms(system);
    let mut elements = <[Vec<Element>; 2]>::default();
    for expression in drift {
        writer.decompose(expression, &[], &mut elements[0])?;
    }
    for (expression, loops) in noise {
        writer.decompose(expression, &loops, &mut elements[1])?;
    }
    Some(elements)
}

/// The loop over the members of a family of noises.
fn members(noise: &Noise) -> Option<Loop> {
    let Family { variable, count } = noise.family.as_ref()?;
    Some(Loop { variable: *variable, start: Default::default(), end: count.clone() })
}

/// Elements as derivatives need them: each reads only coordinates, only momenta, or what cannot be parted.
pub(super) fn parted(system: &mut System, elements: &[Element]) -> Vec<Element> {
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
    /// The elements of a Hamiltonian inside of `loops`.
    fn collect(&mut self, term: &mut Term, loops: &[Loop]) -> Option<()> {
        let mut values = Vec::new();
        self.decompose(term.expression, loops, &mut values)?;
        term.elements = values.iter().flat_map(|element| self.parted(element)).collect();
        term.values = values;
        Some(())
    }

    fn decompose(&mut self, expr: Expr, loops: &[Loop], into: &mut Vec<Element>) -> Option<()> {
        let (expr, present) = self.linear_in_sums(expr)?;
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

    /// `expr` with the sums in arguments of nonlinear functions written out, and its other sums.
    fn linear_in_sums(&mut self, mut expr: Expr) -> Option<(Expr, Vec<(Symbol, IndexedSum)>)> {
        loop {
            let symbols = self.graph.symbols_in(expr).into_iter();
            let present: Vec<(Symbol, IndexedSum)> =
                symbols.filter_map(|symbol| Some((symbol, self.symbols.sum_of(symbol)?.clone()))).collect();
            let names: Vec<Symbol> = present.iter().map(|(symbol, _)| *symbol).collect();
            let nonlinear = present.iter().filter(|(symbol, _)| {
                let factor = self.graph.derivative(expr, *symbol);
                self.graph.depends_on(factor, &names) || self.graph.has_pieces(expr, &[*symbol])
            });
            let nonlinear: Vec<&(Symbol, IndexedSum)> = nonlinear.collect();
            if nonlinear.is_empty() {
                return Some((expr, present));
            }
            let mut images = HashMap::new();
            for (symbol, sum) in nonlinear {
                let written = self.written_out(sum)?;
                images.insert(*symbol, written);
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
        let mut groups: Vec<(Reads, [Terms; 2])> = Vec::new();
        for (side, branch) in branches.into_iter().enumerate() {
            for term in self.split(branch, opened) {
                let reads = self.reads(term.0);
                match groups.iter_mut().find(|(known, _)| *known == reads) {
                    Some((_, sides)) => sides[side].push(term),
                    None => {
                        let mut sides: [Terms; 2] = Default::default();
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
type Terms = Vec<(Expr, Rational)>;

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
