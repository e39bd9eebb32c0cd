//! Replaces symbols by expressions. Tests: `symbolic/tests/random.rs`.

use std::collections::HashMap;

use super::graph::Support;
use super::{Expr, Graph, Node, Symbol};

impl Graph {
    /// `roots` with every symbol in `by` replaced; shared subexpressions are rebuilt once.
    pub(crate) fn substitute(&mut self, roots: &[Expr], by: &HashMap<Symbol, Expr>) -> Vec<Expr> {
        let replaced = Support::of(by.keys().copied());
        let parts = self.reachable_where(roots, |part| self.support(part).intersects(replaced));
        self.rewritten(roots, parts, |graph, part| by.get(&graph.as_symbol(part)?).copied())
    }

    /// `expr` in the form that its constructors give it now.
    pub(crate) fn rebuilt(&mut self, expr: Expr) -> Expr {
        let parts = self.reachable(&[expr]);
        self.rewritten(&[expr], parts, |_, _| None)[0]
    }

    /// `roots` with each of `parts` replaced by its image, or else rebuilt from the images of its operands.
    pub(crate) fn rewritten(
        &mut self,
        roots: &[Expr],
        mut parts: Vec<Expr>,
        image: impl Fn(&Self, Expr) -> Option<Expr>,
    ) -> Vec<Expr> {
        parts.sort_unstable();
        let mut images: HashMap<Expr, Expr> = HashMap::with_capacity(parts.len());
        let of = |images: &HashMap<Expr, Expr>, expr| images.get(&expr).copied().unwrap_or(expr);
        for part in parts {
            let image = image(self, part).unwrap_or_else(|| {
                let node = self.node(part).clone();
                self.rebuild(&node, &|operand| of(&images, operand))
            });
            images.insert(part, image);
        }
        roots.iter().map(|&root| of(&images, root)).collect()
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
            Node::Join(junction, a, b) => self.join(*junction, image(*a), image(*b)),
        }
    }
}
