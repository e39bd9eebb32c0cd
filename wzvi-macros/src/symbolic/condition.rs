//! Constructors of conditions and selections, in canonical form like those of numbers. Tests:
//! `symbolic/tests/random.rs`.

use super::{Expr, Function, Graph, Junction, Node, Relation, Symbol};

impl Graph {
    pub(crate) fn compare(&mut self, relation: Relation, a: Expr, b: Expr) -> Expr {
        // Equality is symmetric: operands are sorted.
        let is_swapped = relation == Relation::Equal && self.order(b, a).is_lt();
        let (a, b) = if is_swapped { (b, a) } else { (a, b) };
        self.intern(Node::Compare(relation, a, b))
    }

    pub(crate) fn not(&mut self, a: Expr) -> Expr {
        match *self.node(a) {
            Node::Not(inner) => inner,
            _ => self.intern(Node::Not(a)),
        }
    }

    pub(crate) fn join(&mut self, junction: Junction, a: Expr, b: Expr) -> Expr {
        let is_decisive = |truth| truth == (junction == Junction::Or);
        match [a, b].map(|part| self.truth(part).map(is_decisive)) {
            [Some(true), _] | [_, Some(false)] => a,
            [Some(false), _] | [_, Some(true)] => b,
            _ if a == b => a,
            _ => self.intern(Node::Join(junction, a, b)),
        }
    }

    /// Whether a condition holds, if it compares numbers.
    fn truth(&self, condition: Expr) -> Option<bool> {
        match *self.node(condition) {
            Node::Compare(relation, a, b) => Some(relation.holds(&self.as_number(a)?, &self.as_number(b)?)),
            Node::Not(inner) => self.truth(inner).map(|holds| !holds),
            _ => None,
        }
    }

    pub(crate) fn select(&mut self, condition: Expr, then: Expr, otherwise: Expr) -> Expr {
        match (self.truth(condition), self.node(condition)) {
            _ if then == otherwise => then,
            (Some(true), _) => then,
            (Some(false), _) => otherwise,
            (None, &Node::Not(opposite)) => self.select(opposite, otherwise, then),
            (None, _) => self.intern(Node::Select { condition, then, otherwise }),
        }
    }

    /// Whether `expr` is piecewise with conditions on `symbols`. Its derivatives are then the derivatives of
    /// the pieces, without jumps: the derivative of a step function is zero.
    pub(crate) fn has_pieces(&self, expr: Expr, symbols: &[Symbol]) -> bool {
        let decides = |part: Expr| match self.node(part) {
            Node::Compare(..) => true,
            Node::Apply(function, _) => {
                matches!(function, Function::Abs | Function::Signum | Function::Min | Function::Max)
            }
            _ => false,
        };
        self.reachable(&[expr]).into_iter().any(|part| decides(part) && self.depends_on(part, symbols))
    }
}
