//! Distances `r = √s` as variables of their own: sums of squares `s` that an expression divides by, or takes
//! roots of, and values of `hypot`.

use std::collections::{HashMap, HashSet};

use crate::model::System;
use crate::symbolic::sign::Sign;
use crate::symbolic::{Expr, Function, Graph, Node, Rational, Symbol, SymbolKind};

/// `r = √s`
#[derive(Clone, Copy)]
pub(super) struct DistanceVariable {
    pub(super) symbol: Symbol,
    /// `s`
    pub(super) square: Expr,
    /// `s`, or `√s` as `hypot`: `r` to a power.
    written: (Expr, Rational),
}

/// The distances in some expressions.
#[derive(Clone, Default)]
pub(super) struct Distances {
    pub(super) all: Vec<DistanceVariable>,
    /// The beginning of their names.
    letter: &'static str,
}

impl Distances {
    /// The distances that depend on variables `moving`.
    pub(super) fn of(system: &mut System, roots: &[Expr], moving: &[Symbol]) -> Self {
        let [q, p] = system.symbols.phase();
        let named = q.into_iter().chain(p).chain(system.parameters.iter().map(|known| known.symbol));
        let named: Vec<Symbol> = named.collect();
        let graph = &mut system.graph;
        let is_taken =
            |letter: &&str| named.iter().any(|&symbol| graph.symbol_name(symbol).starts_with(letter));
        let letter = ["r", "ϱ"].into_iter().find(|letter| !is_taken(letter)).unwrap_or("distance");
        let parts = graph.reachable(roots);
        // A `hypot` inside of another one is a part of its square.
        let is_hypot = |part: &Expr| matches!(graph.node(*part), Node::Apply(Function::Hypot, _));
        let others = parts.iter().filter(|part| !is_hypot(part));
        let read: HashSet<Expr> =
            others.flat_map(|&part| graph.node(part).operands()).chain(roots.iter().copied()).collect();
        let mut bases: Vec<Expr> = Vec::new();
        for part in parts {
            match graph.node(part) {
                Node::Apply(Function::Hypot, _) if read.contains(&part) => bases.push(part),
                Node::Product(factors) => bases.extend(factors.iter().filter_map(|&(base, exponent)| {
                    let is_distance = exponent.is_negative() || !exponent.is_integer();
                    let is_sum = matches!(graph.node(base), Node::Sum { .. });
                    (is_distance && is_sum && graph.sign(base) >= Sign::Nonnegative).then_some(base)
                })),
                _ => {}
            }
        }
        bases.sort_by(|a, b| graph.order(*a, *b));
        bases.dedup();
        bases.retain(|&base| graph.depends_on(base, moving));
        let number = bases.len();
        let variable = |(place, base): (usize, Expr)| {
            let name = numbered(letter, number, place + 1);
            let symbol = graph.new_positive_symbol(SymbolKind::Auxiliary, name);
            let (square, share) = match graph.node(base) {
                Node::Apply(Function::Hypot, _) => (square_of(graph, base), Rational::ONE),
                _ => (base, Rational::HALF),
            };
            DistanceVariable { symbol, square, written: (base, share) }
        };
        Self { all: bases.into_iter().enumerate().map(variable).collect(), letter }
    }

    /// The distances for a text: those that contain no others, and one variable for all that are written in
    /// the same way.
    pub(super) fn in_text(self, graph: &mut Graph) -> Self {
        let bases: Vec<Expr> = self.all.iter().map(|known| known.written.0).collect();
        let is_innermost = |graph: &Graph, base: Expr| {
            graph.reachable(&[base]).into_iter().all(|part| part == base || !bases.contains(&part))
        };
        let mut all: Vec<DistanceVariable> = self.all;
        all.retain(|known| is_innermost(graph, known.written.0));
        let texts = all.iter().map(|known| graph.power(known.written.0, known.written.1));
        let texts: Vec<Expr> = texts.collect();
        let texts: Vec<String> = texts.into_iter().map(|value| graph.display(value)).collect();
        let mut different: Vec<&String> = Vec::new();
        for text in &texts {
            if !different.contains(&text) {
                different.push(text);
            }
        }
        let symbols: Vec<Symbol> = (1..=different.len())
            .map(|number| {
                let name = numbered(self.letter, different.len(), number);
                graph.new_positive_symbol(SymbolKind::Auxiliary, name)
            })
            .collect();
        for (known, text) in all.iter_mut().zip(&texts) {
            if let Some(place) = different.iter().position(|other| *other == text) {
                known.symbol = symbols[place];
            }
        }
        Self { all, ..self }
    }

    /// An expression in distances.
    pub(super) fn within(&self, graph: &mut Graph, expr: Expr) -> Expr {
        let mut bases = HashMap::new();
        for &DistanceVariable { symbol, written: (base, share), .. } in &self.all {
            let power = if share.is_one() { share } else { Rational::integer(2) };
            bases.insert(base, (graph.symbol(symbol), power));
        }
        with_bases(graph, expr, &bases)
    }

    /// An expression with distances written out.
    pub(super) fn written(&self, graph: &mut Graph, expr: Expr) -> Expr {
        let mut bases = HashMap::new();
        for &DistanceVariable { symbol, written, .. } in &self.all {
            bases.insert(graph.symbol(symbol), written);
        }
        with_bases(graph, expr, &bases)
    }

    /// `r = √(x² + y²)`, a line for each.
    pub(super) fn lines(&self, graph: &mut Graph) -> String {
        let (mut text, mut written) = (String::new(), Vec::new());
        for &DistanceVariable { symbol, written: (base, share), .. } in &self.all {
            if written.contains(&symbol) {
                continue;
            }
            written.push(symbol);
            let value = graph.power(base, share);
            text.push_str(&format!("  {} = {}\n", graph.symbol_name(symbol), graph.display(value)));
        }
        text
    }
}

/// `x²`, of a `hypot` the sum of the squares of its arguments.
fn square_of(graph: &mut Graph, x: Expr) -> Expr {
    match graph.node(x).clone() {
        Node::Apply(Function::Hypot, arguments) => {
            let squares: Vec<Expr> = arguments.iter().map(|&argument| square_of(graph, argument)).collect();
            graph.sum(&squares)
        }
        _ => graph.power(x, Rational::integer(2)),
    }
}

/// The name of the variable with this number, from 1, among several.
fn numbered(letter: &str, all: usize, number: usize) -> String {
    if all == 1 { letter.to_owned() } else { format!("{letter}{number}") }
}

/// An expression with powers of other bases: `base^e` becomes `to^(share e)`.
fn with_bases(graph: &mut Graph, root: Expr, bases: &HashMap<Expr, (Expr, Rational)>) -> Expr {
    let mut parts = graph.reachable(&[root]);
    parts.sort_unstable();
    let mut images: HashMap<Expr, Expr> = HashMap::new();
    for part in parts {
        let of = |images: &HashMap<Expr, Expr>, expr| images.get(&expr).copied().unwrap_or(expr);
        let image = match graph.node(part).clone() {
            Node::Product(factors) => {
                let powers = factors.iter().map(|&(base, exponent)| {
                    let replaced =
                        bases.get(&base).and_then(|&(to, share)| Some((to, share.multiply(exponent)?)));
                    replaced.unwrap_or((of(&images, base), exponent))
                });
                let powers: Vec<(Expr, Rational)> = powers.collect();
                let powers: Vec<Expr> = powers.into_iter().map(|(base, e)| graph.power(base, e)).collect();
                graph.product(&powers)
            }
            node => graph.rebuild(&node, &|operand| of(&images, operand)),
        };
        let replaced = bases.get(&part).map(|&(to, share)| graph.power(to, share));
        images.insert(part, replaced.unwrap_or(image));
    }
    images.get(&root).copied().unwrap_or(root)
}
