//! The hash-consing arena. Handles are small copies; a node is immutable and stored once. Tests:
//! `symbolic/tests/mod.rs`, `symbolic/tests/validate.rs`.

use std::cell::RefCell;
use std::cmp::Ordering;
use std::collections::{HashMap, HashSet};
use std::hash::{Hash, Hasher};

use super::order::{OrderKey, SymbolKind};
use super::sign::Sign;
use super::{Function, Rational};

/// A handle to a canonical expression in one [`Graph`]. Handles have the order in which nodes were made;
/// operands have that of [`Graph::order`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(crate) struct Expr(u32);

impl Expr {
    /// Position in the arena: operands always come before the nodes that use them.
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// A free variable. Only its creator knows its meaning (a coordinate, a parameter, an increment).
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(crate) struct Symbol(pub(super) u32);

impl Symbol {
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// Comparisons of two real expressions.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) enum Relation {
    Less,
    LessEqual,
    Equal,
}

impl Relation {
    pub(crate) fn holds<T: PartialOrd>(self, a: &T, b: &T) -> bool {
        match self {
            Self::Less => a < b,
            Self::LessEqual => a <= b,
            Self::Equal => a == b,
        }
    }

    /// The method of `Scalar`, the operator of Rust, the sign for a reader, and the sign of the opposite
    /// relation.
    pub(crate) fn spelled(self) -> [&'static str; 4] {
        match self {
            Self::Less => ["less", "<", "<", "≥"],
            Self::LessEqual => ["less_equal", "<=", "≤", ">"],
            Self::Equal => ["equal", "==", "=", "≠"],
        }
    }
}

/// A connective of two conditions.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) enum Junction {
    And,
    Or,
}

/// One node. Real-valued unless it is a `Compare`, `Not` or `Join`.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Node {
    /// An exact number.
    Number(Rational),
    /// The bits of a binary64 number that is not a small rational (`6.674e-11`, π).
    Float(u64),
    Symbol(Symbol),
    /// `constant + Σ coefficient · term`. Terms are sorted ([`Graph::order`]), are not numbers, and are not
    /// sums if their coefficient is ±1. A single term has a coefficient other than one. Two exceptions remain
    /// separate: numbers that would leave the exact range, and sums of more than [`super::build::OPEN_LIMIT`]
    /// terms.
    Sum {
        terms: Box<[(Expr, Rational)]>,
        constant: Rational,
    },
    /// `Π base^exponent`, sorted by (base, exponent). Exponents of opposite sign of one base stay separate
    /// unless the base is known not to be zero, and fractional exponents occur only with bases proven
    /// nonnegative: the domain is preserved. Bases are neither products nor multiples that could be
    /// flattened (the exceptions are those of sums, and products with exponents beyond those of `powi`).
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
    Join(Junction, Expr, Expr),
}

impl Node {
    /// The operands, in order.
    pub(crate) fn operands(&self) -> Vec<Expr> {
        let mut operands = Vec::new();
        self.for_each_operand(|operand| operands.push(operand));
        operands
    }

    /// Calls `visit` with every operand, in order.
    pub(crate) fn for_each_operand(&self, mut visit: impl FnMut(Expr)) {
        match self {
            Node::Number(_) | Node::Float(_) | Node::Symbol(_) => {}
            Node::Sum { terms: weighted, .. } | Node::Product(weighted) => {
                weighted.iter().for_each(|&(operand, _)| visit(operand));
            }
            Node::Apply(_, arguments) => arguments.iter().for_each(|&argument| visit(argument)),
            &Node::Select { condition, then, otherwise } => {
                [condition, then, otherwise].into_iter().for_each(visit)
            }
            &Node::Compare(_, a, b) | &Node::Join(_, a, b) => [a, b].into_iter().for_each(visit),
            &Node::Not(a) => visit(a),
        }
    }
}

/// The arena. See [`super::build`] for the constructors.
#[derive(Clone, Default)]
pub(crate) struct Graph {
    nodes: Vec<Node>,
    signs: Vec<Sign>,
    supports: Vec<Support>,
    order_keys: Vec<OrderKey>,
    /// The orders of operands that differ only many levels below.
    pub(super) long_comparisons: RefCell<HashMap<(Expr, Expr), Ordering>>,
    /// The node of each hash; a colliding node takes the next free key. So a node is stored once.
    handles: HashMap<u64, Expr>,
    names: Vec<String>,
    kinds: Vec<SymbolKind>,
    /// Expressions that are not zero although their signs are unknown.
    nonzero: HashSet<Expr>,
    marks: RefCell<Marks>,
}

/// Multiply and rotate, one word at a time: macros run unoptimised, and the standard hasher would dominate
/// the time.
struct NodeHasher(u64);

impl Hasher for NodeHasher {
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_u64(byte.into()));
    }

    fn write_u32(&mut self, word: u32) {
        self.write_u64(word.into());
    }

    fn write_u64(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(23) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }

    fn write_usize(&mut self, word: usize) {
        self.write_u64(word as u64);
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

/// The nodes visited by the current traversal carry its number, so that marks need no clearing.
#[derive(Clone, Default)]
struct Marks {
    traversal: u32,
    met_in: Vec<u32>,
}

impl Marks {
    /// No node of so many is met.
    fn next_traversal(&mut self, nodes: usize) -> &mut Self {
        self.met_in.resize(nodes, 0);
        self.traversal = self.traversal.wrapping_add(1);
        if self.traversal == 0 {
            self.met_in.fill(0);
            self.traversal = 1;
        }
        self
    }

    fn is_new(&self, expr: Expr) -> bool {
        self.met_in[expr.index()] != self.traversal
    }

    /// Meets a node; whether that is the first time.
    fn meet(&mut self, expr: Expr) -> bool {
        std::mem::replace(&mut self.met_in[expr.index()], self.traversal) != self.traversal
    }
}

/// A superset of the symbols in an expression, one bit for each residue of their index modulo 64.
#[derive(Clone, Copy, Default)]
pub(super) struct Support(u64);

impl Support {
    pub(super) fn of(symbols: impl IntoIterator<Item = Symbol>) -> Self {
        Self(symbols.into_iter().fold(0, |bits, symbol| bits | 1 << (symbol.index() % 64)))
    }

    pub(super) fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}

impl Graph {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    pub(crate) fn node(&self, expr: Expr) -> &Node {
        #[cfg(test)]
        super::tests::effort::count();
        &self.nodes[expr.index()]
    }

    /// The known sign of `expr` on its domain.
    pub(crate) fn sign(&self, expr: Expr) -> Sign {
        self.signs[expr.index()]
    }

    /// A new free variable; two variables of one name are different.
    pub(crate) fn new_symbol(&mut self, kind: SymbolKind, name: impl Into<String>) -> Symbol {
        self.names.push(name.into());
        self.kinds.push(kind);
        Symbol((self.names.len() - 1) as u32)
    }

    /// A new variable that is positive.
    pub(crate) fn new_positive_symbol(&mut self, kind: SymbolKind, name: impl Into<String>) -> Symbol {
        let symbol = self.new_symbol(kind, name);
        let expr = self.symbol(symbol);
        self.signs[expr.index()] = Sign::Positive;
        symbol
    }

    /// A new variable of the kind of another one.
    pub(crate) fn new_symbol_like(&mut self, other: Symbol, name: impl Into<String>) -> Symbol {
        let symbol = self.new_symbol(self.kind_of(other), name);
        let other = self.symbol(other);
        if self.nonzero.contains(&other) {
            let own = self.symbol(symbol);
            self.nonzero.insert(own);
        }
        symbol
    }

    /// Makes `expr` count as not zero: in new products a power of it cancels with its inverse. This may be
    /// assumed where no value is used unless it holds.
    pub(crate) fn assume_nonzero(&mut self, expr: Expr) {
        self.nonzero.insert(expr);
    }

    /// Whether `expr` is known not to be zero wherever it is defined.
    pub(super) fn is_nonzero(&self, expr: Expr) -> bool {
        self.sign(expr) == Sign::Positive || self.nonzero.contains(&expr)
    }

    /// The meaning of a variable of this graph: each has an entry from its creation on.
    pub(crate) fn kind_of(&self, symbol: Symbol) -> SymbolKind {
        self.kinds[symbol.index()]
    }

    pub(crate) fn symbol_name(&self, symbol: Symbol) -> &str {
        &self.names[symbol.index()]
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

    /// `expr` as a number times an expression that is not such a product itself.
    pub(crate) fn as_multiple(&self, expr: Expr) -> (Rational, Expr) {
        match self.node(expr) {
            Node::Sum { terms, constant } if terms.len() == 1 && constant.is_zero() => {
                (terms[0].1, terms[0].0)
            }
            _ => (Rational::ONE, expr),
        }
    }

    pub(crate) fn is_zero(&self, expr: Expr) -> bool {
        self.as_number(expr).is_some_and(Rational::is_zero)
    }

    pub(crate) fn is_one(&self, expr: Expr) -> bool {
        self.as_number(expr).is_some_and(Rational::is_one)
    }

    /// The handle of a node that is already in canonical form: called only by the constructors of `build`.
    pub(super) fn intern(&mut self, node: Node) -> Expr {
        #[cfg(test)]
        super::tests::effort::count();
        let mut hasher = NodeHasher(0);
        node.hash(&mut hasher);
        let mut key = hasher.finish();
        while let Some(&known) = self.handles.get(&key) {
            if *self.node(known) == node {
                return known;
            }
            key = key.wrapping_add(1);
        }
        let handle = Expr(self.nodes.len() as u32);
        self.signs.push(self.sign_of(&node));
        self.supports.push(self.support_of(&node));
        self.order_keys.push(self.key_of(&node));
        self.nodes.push(node);
        self.handles.insert(key, handle);
        handle
    }

    fn support_of(&self, node: &Node) -> Support {
        let mut support = match *node {
            Node::Symbol(symbol) => Support::of([symbol]),
            _ => Support::default(),
        };
        node.for_each_operand(|operand| support.0 |= self.supports[operand.index()].0);
        support
    }

    /// A superset of the symbols in `expr`.
    pub(super) fn support(&self, expr: Expr) -> Support {
        self.supports[expr.index()]
    }

    /// The key of a node of this graph: each has an entry from its creation on.
    pub(super) fn order_key(&self, expr: Expr) -> OrderKey {
        self.order_keys[expr.index()]
    }

    /// All nodes reachable from `roots`, each once, in the order of a reader: operands first, from the first
    /// to the last.
    pub(crate) fn reachable(&self, roots: &[Expr]) -> Vec<Expr> {
        let mut marks = self.marks.borrow_mut();
        let marks = marks.next_traversal(self.nodes.len());
        let mut met = Vec::new();
        let mut pending: Vec<(Expr, bool)> = roots.iter().rev().map(|&root| (root, false)).collect();
        while let Some((expr, is_complete)) = pending.pop() {
            if is_complete {
                met.push(expr);
            } else if marks.meet(expr) {
                pending.push((expr, true));
                let first = pending.len();
                self.node(expr).for_each_operand(|operand| pending.push((operand, false)));
                pending[first..].reverse();
            }
        }
        met
    }

    /// The symbols in `expr`, in the order of a reader.
    pub(crate) fn symbols_in(&self, expr: Expr) -> Vec<Symbol> {
        self.reachable(&[expr]).into_iter().filter_map(|part| self.as_symbol(part)).collect()
    }

    /// The nodes reachable from `roots` through nodes that satisfy `enter`, in no particular order.
    pub(super) fn reachable_where(&self, roots: &[Expr], enter: impl Fn(Expr) -> bool) -> Vec<Expr> {
        let mut marks = self.marks.borrow_mut();
        let marks = marks.next_traversal(self.nodes.len());
        let mut met = Vec::new();
        let mut pending = roots.to_vec();
        while let Some(expr) = pending.pop() {
            if marks.is_new(expr) && enter(expr) {
                marks.meet(expr);
                met.push(expr);
                self.node(expr).for_each_operand(|operand| pending.push(operand));
            }
        }
        met
    }

    /// Whether `expr` contains any of `symbols`.
    pub(crate) fn depends_on(&self, expr: Expr, symbols: &[Symbol]) -> bool {
        let wanted = Support::of(symbols.iter().copied());
        let may_depend = |part: Expr| self.support(part).intersects(wanted);
        if self.names.len() <= 64 {
            return may_depend(expr);
        }
        let parts = self.reachable_where(&[expr], may_depend);
        parts.into_iter().any(|part| self.as_symbol(part).is_some_and(|symbol| symbols.contains(&symbol)))
    }
}
