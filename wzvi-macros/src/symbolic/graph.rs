//! The hash-consing arena. Handles are small copies; a node is immutable and stored once.

use std::collections::HashMap;

use super::sign::Sign;
use super::{Function, Rational};

/// A handle to a canonical expression in one [`Graph`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(crate) struct Expr(u32);

impl Expr {
    /// Position in the arena: operands always come before the nodes that use them.
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// A free variable. What it stands for (a coordinate, a parameter, an increment) is known to whoever made it.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(crate) struct Symbol(u32);

impl Symbol {
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// Comparisons of two real expressions.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Relation {
    Less,
    LessEqual,
    Equal,
}

/// One node. Real-valued unless it is a `Compare`, `Not`, `And` or `Or`.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Node {
    /// An exact number.
    Number(Rational),
    /// The bits of a binary64 number that is no small rational (`6.674e-11`, π).
    Float(u64),
    Symbol(Symbol),
    /// `constant + Σ coefficient · term`. Terms are sorted by handle, are no numbers, and are no sums when their
    /// coefficient is ±1. Not a bare term: a lone term has a coefficient other than one.
    Sum {
        terms: Box<[(Expr, Rational)]>,
        constant: Rational,
    },
    /// `Π base^exponent`, sorted by (base, exponent). Exponents of opposite sign on one base stay apart unless the
    /// base is proven positive, and fractional exponents only stand on bases proven nonnegative: no domain is lost.
    Product(Box<[(Expr, Rational)]>),
    Apply(Function, Box<[Expr]>),
    /// `if condition { then } else { otherwise }`.
    Select {
        condition: Expr,
        then: Expr,
        otherwise: Expr,
    },
    Compare(Relation, Expr, Expr),
    Not(Expr),
    And(Expr, Expr),
    Or(Expr, Expr),
}

impl Node {
    /// The operands, in order.
    pub(crate) fn operands(&self) -> Vec<Expr> {
        match self {
            Node::Number(_) | Node::Float(_) | Node::Symbol(_) => Vec::new(),
            Node::Sum { terms, .. } => terms.iter().map(|&(term, _)| term).collect(),
            Node::Product(factors) => factors.iter().map(|&(base, _)| base).collect(),
            Node::Apply(_, arguments) => arguments.to_vec(),
            &Node::Select { condition, then, otherwise } => vec![condition, then, otherwise],
            &Node::Compare(_, a, b) | &Node::And(a, b) | &Node::Or(a, b) => vec![a, b],
            &Node::Not(a) => vec![a],
        }
    }
}

/// The arena. See [`super::build`] for the constructors.
#[derive(Default)]
pub(crate) struct Graph {
    nodes: Vec<Node>,
    signs: Vec<Sign>,
    handles: HashMap<Node, Expr>,
    names: Vec<String>,
}

impl Graph {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    pub(crate) fn node(&self, expr: Expr) -> &Node {
        &self.nodes[expr.index()]
    }

    /// What is known of the sign of `expr` wherever it is defined.
    pub(crate) fn sign(&self, expr: Expr) -> Sign {
        self.signs[expr.index()]
    }

    /// Number of distinct nodes.
    pub(crate) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// A new free variable; two variables of one name are different.
    pub(crate) fn new_symbol(&mut self, name: impl Into<String>) -> Symbol {
        self.names.push(name.into());
        Symbol((self.names.len() - 1) as u32)
    }

    pub(crate) fn symbol_name(&self, symbol: Symbol) -> &str {
        &self.names[symbol.index()]
    }

    pub(crate) fn symbol_count(&self) -> usize {
        self.names.len()
    }

    pub(crate) fn as_symbol(&self, expr: Expr) -> Option<Symbol> {
        match *self.node(expr) {
            Node::Symbol(symbol) => Some(symbol),
            _ => None,
        }
    }

    pub(crate) fn as_number(&self, expr: Expr) -> Option<Rational> {
        match *self.node(expr) {
            Node::Number(value) => Some(value),
            _ => None,
        }
    }

    pub(crate) fn is_zero(&self, expr: Expr) -> bool {
        self.as_number(expr).is_some_and(Rational::is_zero)
    }

    pub(crate) fn is_one(&self, expr: Expr) -> bool {
        self.as_number(expr).is_some_and(Rational::is_one)
    }

    /// The handle of a node that is already in canonical form: only the constructors of `build` call this.
    pub(super) fn intern(&mut self, node: Node) -> Expr {
        if let Some(&known) = self.handles.get(&node) {
            return known;
        }
        let handle = Expr(self.nodes.len() as u32);
        self.signs.push(self.sign_of(&node));
        self.nodes.push(node.clone());
        self.handles.insert(node, handle);
        handle
    }

    /// All nodes that `roots` reach, operands first, each once.
    pub(crate) fn reachable(&self, roots: &[Expr]) -> Vec<Expr> {
        let mut marked = vec![false; self.nodes.len()];
        let mut pending = roots.to_vec();
        while let Some(expr) = pending.pop() {
            if !std::mem::replace(&mut marked[expr.index()], true) {
                pending.extend(self.node(expr).operands());
            }
        }
        (0..self.nodes.len()).filter(|&i| marked[i]).map(|i| Expr(i as u32)).collect()
    }

    /// Whether `expr` contains any of `symbols`.
    pub(crate) fn depends_on(&self, expr: Expr, symbols: &[Symbol]) -> bool {
        self.reachable(&[expr]).iter().any(|&e| self.as_symbol(e).is_some_and(|s| symbols.contains(&s)))
    }
}
