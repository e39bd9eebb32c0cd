//! The order of operands. It follows from an expression alone, and neither from what else is in the graph nor
//! from what was made before: so the text and the code of a formula are the same beside any other.
//!
//! Operands are compared by, one after the other,
//!
//! 1. how often they read increments of noises: drift first,
//! 2. their degree in the variables of the state: `q + q²`, and functions other than polynomials last,
//! 3. whether they read momenta, for all but single variables: the kinetic energy before the potential,
//! 4. their kind: numbers, variables, functions, sums, products, branches,
//! 5. how deeply they are nested,
//! 6. what they are made of. Variables have the order of [`SymbolKind`], and that of their creation within a
//!    kind. Products are compared by their factors of the state, then by their constant factors.
//!
//! Tests: `symbolic/tests/mod.rs`, `compile/order_tests.rs`.

use std::cmp::Ordering;

use super::{Expr, Graph, Node, Rational, Symbol};

/// The meaning of a variable. Factors are written in this order: `h k q p ΔW`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum SymbolKind {
    StepSize,
    Parameter,
    Time,
    Coordinate,
    Momentum,
    /// A displacement of the state, an unknown of a step.
    Displacement,
    /// A symbol that stands for an expression, for some time.
    Auxiliary,
    /// The increment of a noise.
    Increment,
}

/// The largest degree: that of expressions that are no polynomials.
const NO_POLYNOMIAL: u8 = u8::MAX;

/// Comparisons of so many levels are remembered. So the comparisons of two expressions that are nested `n`
/// times cost `n`, not `n²`.
const LONG: usize = 8;

/// The place of a node among others, as far as it is known without a look at operands.
#[derive(Clone, Copy)]
pub(super) struct OrderKey {
    /// The first five criteria, and of variables the sixth, most significant first.
    packed: u64,
    /// How deeply it is nested, at most `u16::MAX`.
    depth: u16,
    /// The degree in increments of noises.
    increments: u8,
    /// The degree in variables of the state.
    degree: u8,
    reads_momenta: bool,
}

/// The comparison of two different nodes with equal keys.
enum Comparison {
    Decided(Ordering),
    /// By these two operands, which differ.
    By(Expr, Expr),
}

impl Graph {
    /// The order of two operands of one node. Different expressions are never equal.
    pub(crate) fn order(&self, a: Expr, b: Expr) -> Ordering {
        let (mut left, mut right, mut levels) = (a, b, 0);
        let order = loop {
            let by_key = self.order_key(left).packed.cmp(&self.order_key(right).packed);
            if left == right || by_key != Ordering::Equal {
                break by_key;
            }
            if levels > 0
                && levels % LONG == 0
                && let Some(&known) = self.long_comparisons.borrow().get(&(left, right))
            {
                break known;
            }
            match self.compared(left, right) {
                Comparison::Decided(order) => break order,
                Comparison::By(x, y) => (left, right, levels) = (x, y, levels + 1),
            }
        };
        if levels >= LONG {
            let mut known = self.long_comparisons.borrow_mut();
            known.extend([((a, b), order), ((b, a), order.reverse())]);
        }
        order
    }

    /// Sorts the terms of a sum, or the factors of a product.
    pub(super) fn sort(&self, operands: &mut [(Expr, Rational)]) {
        operands.sort_unstable_by(|(a, x), (b, y)| self.order(*a, *b).then_with(|| x.cmp(y)));
    }

    fn compared(&self, a: Expr, b: Expr) -> Comparison {
        let operands = |left: &[Expr], right: &[Expr]| {
            let differing = left.iter().zip(right).find(|(x, y)| x != y);
            differing.map(|(&x, &y)| Comparison::By(x, y))
        };
        let found = match (self.node(a), self.node(b)) {
            (Node::Number(a), Node::Number(b)) => Some(Comparison::Decided(a.cmp(b))),
            (Node::Float(a), Node::Float(b)) => Some(Comparison::Decided(a.cmp(b))),
            (Node::Symbol(a), Node::Symbol(b)) => {
                Some(Comparison::Decided(self.place(*a).cmp(&self.place(*b))))
            }
            (Node::Sum { terms: left, constant: a }, Node::Sum { terms: right, constant: b }) => {
                weighted(left, right).or((a != b).then(|| Comparison::Decided(a.cmp(b))))
            }
            (Node::Product(left), Node::Product(right)) => {
                let constants = |factors: &[(Expr, Rational)]| {
                    factors.iter().take_while(|(base, _)| self.is_constant(*base)).count()
                };
                let [(fixed, left), (other_fixed, right)] =
                    [left, right].map(|factors| factors.split_at(constants(factors)));
                weighted(left, right).or_else(|| weighted(fixed, other_fixed))
            }
            (Node::Apply(f, left), Node::Apply(g, right)) => match f.cmp(g) {
                Ordering::Equal => operands(left, right),
                order => Some(Comparison::Decided(order)),
            },
            (Node::Compare(one, ..), Node::Compare(other, ..)) if one != other => {
                Some(Comparison::Decided(one.cmp(other)))
            }
            (Node::Join(one, ..), Node::Join(other, ..)) if one != other => {
                Some(Comparison::Decided(one.cmp(other)))
            }
            (left, right) => operands(&left.operands(), &right.operands()),
        };
        found.unwrap_or_else(|| Comparison::Decided(a.cmp(&b)))
    }

    /// Whether an operand reads neither the state nor increments.
    fn is_constant(&self, expr: Expr) -> bool {
        let key = self.order_key(expr);
        key.degree == 0 && key.increments == 0
    }

    /// The order of a variable among all variables.
    fn place(&self, symbol: Symbol) -> (SymbolKind, Symbol) {
        (self.kind_of(symbol), symbol)
    }

    /// The key of a node whose operands are in the graph.
    pub(super) fn key_of(&self, node: &Node) -> OrderKey {
        let mut key = OrderKey { packed: 0, depth: 0, increments: 0, degree: 0, reads_momenta: false };
        node.for_each_operand(|operand| {
            let of_operand = self.order_key(operand);
            key.increments = key.increments.max(of_operand.increments);
            key.degree = key.degree.max(of_operand.degree);
            key.depth = key.depth.max(of_operand.depth.saturating_add(1));
            key.reads_momenta |= of_operand.reads_momenta;
        });
        let (mut last, mut is_single) = (u32::from(key.depth), false);
        let kind: u8 = match node {
            Node::Number(_) => 0,
            Node::Float(_) => 1,
            Node::Symbol(symbol) => {
                let (kind, Symbol(place)) = self.place(*symbol);
                key.increments = u8::from(kind == SymbolKind::Increment);
                key.degree = u8::from(kind > SymbolKind::Time && kind < SymbolKind::Increment);
                key.reads_momenta = kind == SymbolKind::Momentum;
                (last, is_single) = (u32::from(kind as u8) << 24 | place.min((1 << 24) - 1), true);
                2
            }
            Node::Apply(..) => {
                key.increments = beyond_polynomials(key.increments);
                key.degree = beyond_polynomials(key.degree);
                3
            }
            Node::Sum { .. } => 4,
            Node::Product(factors) => {
                key.increments = self.degree_of(factors, |key| key.increments);
                key.degree = self.degree_of(factors, |key| key.degree);
                5
            }
            Node::Select { .. } | Node::Compare(..) | Node::Not(_) | Node::Join(..) => {
                key.increments = beyond_polynomials(key.increments);
                key.degree = beyond_polynomials(key.degree);
                match node {
                    Node::Select { .. } => 6,
                    Node::Compare(..) => 7,
                    Node::Not(_) => 8,
                    _ => 9,
                }
            }
        };
        let lacks_momenta = u8::from(is_single || !key.reads_momenta);
        let [first, second] = [[key.increments, key.degree], [lacks_momenta, kind]].map(u16::from_be_bytes);
        key.packed = u64::from(first) << 48 | u64::from(second) << 32 | u64::from(last);
        key
    }

    fn degree_of(&self, factors: &[(Expr, Rational)], degree: impl Fn(OrderKey) -> u8) -> u8 {
        let mut total: u8 = 0;
        for &(base, exponent) in factors {
            total = total.saturating_add(match (degree(self.order_key(base)), exponent.numerator()) {
                (0, _) => 0,
                (degree, n) if exponent.is_integer() && n > 0 => {
                    degree.saturating_mul(u8::try_from(n).unwrap_or(NO_POLYNOMIAL))
                }
                _ => NO_POLYNOMIAL,
            });
        }
        total
    }
}

/// The degree of a function of an expression with this degree.
fn beyond_polynomials(degree: u8) -> u8 {
    if degree == 0 { 0 } else { NO_POLYNOMIAL }
}

/// By the first operand that differs, then by higher powers and larger coefficients, then by length.
fn weighted(left: &[(Expr, Rational)], right: &[(Expr, Rational)]) -> Option<Comparison> {
    for (&(a, x), &(b, y)) in left.iter().zip(right) {
        if a != b {
            return Some(Comparison::By(a, b));
        }
        if x != y {
            return Some(Comparison::Decided(y.cmp(&x)));
        }
    }
    (left.len() != right.len()).then(|| Comparison::Decided(left.len().cmp(&right.len())))
}
