//! Replaces symbols by expressions.

use std::collections::HashMap;

use super::graph::Support;
use super::{Expr, Graph, Node, Symbol};

impl Graph {
    /// `roots` with every symbol in `by` replaced; shared subexpressions are rebuilt once.
    pub(crate) fn substitute(&mut self, roots: &[Expr], by: &HashMap<Symbol, Expr>) -> Vec<Expr> {
        let replaced = Support::of(by.keys().copied());
        let mut parts = self.reachable_where(roots, |part| self.support(part).intersects(replaced));
        parts.sort_unstable();
        let mut images: HashMap<Expr, Expr> = HashMap::with_capacity(parts.len());
        for expr in parts {
            let node = self.node(expr).clone();
            let image = match &node {
                Node::Symbol(symbol) => by.get(symbol).copied().unwrap_or(expr),
                node => self.rebuild(node, &|operand| images.get(&operand).copied().unwrap_or(operand)),
            };
            images.insert(expr, image);
        }
        roots.iter().map(|root| images.get(root).copied().unwrap_or(*root)).collect()
    }

    /// The canonical form of `node` with its operands mapped.
    pub(crate) fn rebuild(&mut self, node: &Node, image: &dyn Fn(Expr) -> Expr) -> Expr {
        match node {
            Node::Number(_) | Node::Float(_) | Node::Symbol(_) => self.intern(node.clone()),
            Node::Sum { terms, constant } => {
                let mut operands: Vec<_> = terms.iter().map(|&(term, c)| (image(term), c)).collect();
                let one = self.integer(1);
                operands.push((one, *constant));
                self.linear_combination(&operands)
            }
            Node::Product(factors) => {
                let powers: Vec<_> =
                    factors.iter().map(|&(base, exponent)| self.power(image(base), exponent)).collect();
                self.product(&powers)
            }
            Node::Apply(function, arguments) => {
                let arguments: Vec<_> = arguments.iter().map(|&argument| image(argument)).collect();
                self.apply(*function, &arguments)
            }
            Node::Select { condition, then, otherwise } => {
                self.select(image(*condition), image(*then), image(*otherwise))
            }
            Node::Compare(relation, a, b) => self.compare(*relation, image(*a), image(*b)),
            Node::Not(a) => self.not(image(*a)),
            Node::And(a, b) => self.and(image(*a), image(*b)),
            Node::Or(a, b) => self.or(image(*a), image(*b)),
        }
    }
}
