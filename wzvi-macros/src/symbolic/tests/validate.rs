//! Checks the invariants documented in [`Node`]; for tests only.

use crate::symbolic::build::OPEN_LIMIT;
use crate::symbolic::sign::Sign;
use crate::symbolic::{Expr, Graph, Node, Rational};

impl Graph {
    /// The first broken invariant in `expr`, if any.
    pub(super) fn validate(&self, expr: Expr) -> Result<(), String> {
        for part in self.reachable(&[expr]) {
            let node = self.node(part);
            if node.operands().iter().any(|&operand| operand >= part) {
                return Err(format!("operand after its node: {node:?}"));
            }
            let broken = match node {
                Node::Sum { terms, constant } => self.broken_sum(terms, *constant),
                Node::Product(factors) => self.broken_product(factors),
                Node::Float(bits) if f64::from_bits(*bits) < 0.0 => Some("a negative Float"),
                Node::Apply(function, arguments) if function.arity() != arguments.len() => Some("arity"),
                Node::Not(a) if matches!(self.node(*a), Node::Not(_)) => Some("a double negation"),
                Node::Select { then, otherwise, .. } if then == otherwise => Some("no choice"),
                _ => None,
            };
            if let Some(broken) = broken {
                return Err(format!("{broken}: {}", self.display(part)));
            }
        }
        Ok(())
    }

    fn broken_sum(&self, terms: &[(Expr, Rational)], constant: Rational) -> Option<&'static str> {
        if terms.is_empty() || (terms.len() == 1 && constant.is_zero() && terms[0].1.is_one()) {
            return Some("not a sum");
        }
        if terms.iter().any(|(_, coefficient)| coefficient.is_zero()) {
            return Some("a zero coefficient");
        }
        if terms.windows(2).any(|pair| self.order(pair[0].0, pair[1].0).is_gt()) {
            return Some("unsorted terms");
        }
        if terms.windows(2).any(|pair| pair[0].0 == pair[1].0 && pair[0].1.add(pair[1].1).is_some()) {
            return Some("like terms");
        }
        terms.iter().find_map(|&(term, coefficient)| match self.node(term) {
            Node::Number(value) => {
                let fits = coefficient.multiply(*value).and_then(|product| product.add(constant));
                fits.map(|_| "a number as a term")
            }
            Node::Sum { terms, .. } if terms.len() <= OPEN_LIMIT => {
                let unit = coefficient.is_one() || coefficient == Rational::MINUS_ONE;
                unit.then_some("a sum in a sum")
            }
            _ => None,
        })
    }

    fn broken_product(&self, factors: &[(Expr, Rational)]) -> Option<&'static str> {
        if factors.is_empty() || (factors.len() == 1 && factors[0].1.is_one()) {
            return Some("not a product");
        }
        if factors.iter().any(|(_, exponent)| exponent.is_zero()) {
            return Some("a zero exponent");
        }
        if factors.windows(2).any(|pair| self.order(pair[0].0, pair[1].0).is_gt()) {
            return Some("unsorted factors");
        }
        let mergeable = |pair: &[(Expr, Rational)]| {
            let same_sign = pair[0].1.is_negative() == pair[1].1.is_negative();
            let allowed = same_sign || self.is_nonzero(pair[0].0);
            pair[0].0 == pair[1].0 && allowed && pair[0].1.add(pair[1].1).is_some()
        };
        if factors.windows(2).any(mergeable) {
            return Some("like factors");
        }
        factors.iter().find_map(|&(base, exponent)| {
            if !exponent.is_integer() && self.sign(base) < Sign::Nonnegative {
                return Some("a fractional power of a base of unknown sign");
            }
            // Numbers and multiples may exceed the exact range when combined with others.
            let is_multiple = match self.node(base) {
                Node::Number(_) => true,
                Node::Sum { terms, constant } => terms.len() == 1 && constant.is_zero(),
                _ => false,
            };
            (!is_multiple && self.opens(base, exponent)).then_some("an open factor")
        })
    }
}
