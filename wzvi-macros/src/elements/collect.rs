//! From expressions with symbols for sums to elements: `f + Σ_i g_i` is the element `f` and what `g_i` is made of, with
//! one loop more. A factor in front of a sum goes inside.
//!
//! Derivatives are taken of elements that are parted by what of the state they read, values of those that are not: taken
//! apart, `k (1 - cos d)` would be the difference of two sums of large numbers.

use std::collections::HashMap;

use crate::lower::Sum;
use crate::model::index::Loop;
use crate::model::{Element, Extent, Local, Reads, Term};
use crate::symbolic::{Expr, Graph, Node, Rational, Symbol};

/// The sum is an argument of a nonlinear function.
#[derive(Debug)]
pub(crate) struct Nonlinear;

/// What expressions are made of besides parameters.
pub(crate) struct Parts {
    sums: HashMap<Symbol, (Loop, Expr)>,
    locals: Vec<Local>,
}

impl Parts {
    pub(crate) fn new(sums: Vec<Sum>, locals: Vec<Local>) -> Self {
        Self { sums: sums.into_iter().map(|sum| (sum.symbol, (sum.range, sum.body))).collect(), locals }
    }

    /// The Hamiltonian `expr` inside of `loops`.
    pub(crate) fn term(
        &self,
        graph: &mut Graph,
        expr: Expr,
        loops: &[Loop],
        extent: Extent,
    ) -> Result<Term, Nonlinear> {
        let mut values = Vec::new();
        self.decompose(graph, expr, loops, &mut values)?;
        let elements = values.iter().flat_map(|element| self.parted(graph, element)).collect();
        Ok(Term { elements, values, extent })
    }

    fn decompose(
        &self,
        graph: &mut Graph,
        expr: Expr,
        loops: &[Loop],
        into: &mut Vec<Element>,
    ) -> Result<(), Nonlinear> {
        let present: Vec<Symbol> = self.symbols(graph, expr).filter(|s| self.sums.contains_key(s)).collect();
        if present.is_empty() {
            self.place(graph, expr, loops, into);
            return Ok(());
        }
        for &symbol in &present {
            let factor = graph.derivative(expr, symbol);
            if graph.depends_on(factor, &present) {
                return Err(Nonlinear);
            }
            let Some((range, body)) = self.sums.get(&symbol) else { continue };
            let body = graph.multiply(factor, *body);
            let mut inner = loops.to_vec();
            inner.push(range.clone());
            self.decompose(graph, body, &inner, into)?;
        }
        let zero = graph.integer(0);
        let rest = present.iter().map(|&symbol| (symbol, zero)).collect();
        let rest = graph.substitute(&[expr], &rest)[0];
        self.place(graph, rest, loops, into);
        Ok(())
    }

    fn place(&self, graph: &Graph, value: Expr, loops: &[Loop], into: &mut Vec<Element>) {
        if !graph.is_zero(value) {
            into.push(self.element(graph, value, loops));
        }
    }

    fn symbols(&self, graph: &Graph, expr: Expr) -> impl Iterator<Item = Symbol> {
        let parts = graph.reachable(&[expr]);
        let symbols: Vec<Symbol> = parts.into_iter().filter_map(|part| graph.as_symbol(part)).collect();
        symbols.into_iter()
    }

    /// One element for the terms that read coordinates, one for those that read momenta, one for those that read both.
    fn parted(&self, graph: &mut Graph, element: &Element) -> Vec<Element> {
        let mut groups: Vec<(Reads, Vec<(Expr, Rational)>)> = Vec::new();
        for (term, coefficient) in self.split(graph, element.value) {
            let reads = self.element(graph, term, &[]).reads();
            match groups.iter_mut().find(|(known, _)| *known == reads) {
                Some((_, terms)) => terms.push((term, coefficient)),
                None => groups.push((reads, vec![(term, coefficient)])),
            }
        }
        let values = groups.iter().map(|(_, terms)| graph.linear_combination(terms));
        let values: Vec<Expr> = values.collect();
        let parts = values.into_iter().filter(|&value| !graph.is_zero(value));
        parts.map(|value| self.element(graph, value, &element.loops)).collect()
    }

    fn element(&self, graph: &Graph, value: Expr, loops: &[Loop]) -> Element {
        let present: Vec<Symbol> = self.symbols(graph, value).collect();
        let locals = self.locals.iter().filter(|local| present.contains(&local.symbol)).cloned().collect();
        Element { loops: loops.to_vec(), value, locals }
    }

    /// The terms of a sum; a factor that reads no state is multiplied out.
    fn split(&self, graph: &mut Graph, expr: Expr) -> Vec<(Expr, Rational)> {
        match graph.node(expr).clone() {
            Node::Sum { terms, constant } => {
                let mut all = Vec::new();
                for (term, coefficient) in terms {
                    for (inner, weight) in self.split(graph, term) {
                        match weight.multiply(coefficient) {
                            Some(weight) => all.push((inner, weight)),
                            None => all.push((graph.scale(inner, weight), coefficient)),
                        }
                    }
                }
                if !constant.is_zero() {
                    all.push((graph.integer(1), constant));
                }
                all
            }
            Node::Product(factors) => self.multiply_out(graph, expr, &factors),
            _ => vec![(expr, Rational::ONE)],
        }
    }

    fn multiply_out(
        &self,
        graph: &mut Graph,
        expr: Expr,
        factors: &[(Expr, Rational)],
    ) -> Vec<(Expr, Rational)> {
        let reads_state =
            |graph: &Graph, part: Expr| self.element(graph, part, &[]).reads() != Reads::Nothing;
        let moving: Vec<usize> = (0..factors.len()).filter(|&i| reads_state(graph, factors[i].0)).collect();
        let &[only] = moving.as_slice() else { return vec![(expr, Rational::ONE)] };
        let (base, exponent) = factors[only];
        if !exponent.is_one() || !matches!(graph.node(base), Node::Sum { .. }) {
            return vec![(expr, Rational::ONE)];
        }
        let others: Vec<Expr> = factors
            .iter()
            .enumerate()
            .filter(|&(i, _)| i != only)
            .map(|(_, &(base, exponent))| graph.power(base, exponent))
            .collect();
        let factor = graph.product(&others);
        let terms = self.split(graph, base);
        terms.into_iter().map(|(term, weight)| (graph.multiply(factor, term), weight)).collect()
    }
}
