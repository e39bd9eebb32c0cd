//! Sign analysis: whether an expression is nonnegative or positive on its real domain. It decides which
//! powers may be merged without changing the domain. Computed once, when a node is created. Tests:
//! `symbolic/tests/random.rs`.

use super::{Expr, Function, Graph, Node, Rational};

/// The known sign of an expression on its domain.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum Sign {
    Unknown,
    Nonnegative,
    Positive,
}

impl Graph {
    /// The sign of a node whose operands are in the graph.
    pub(super) fn sign_of(&self, node: &Node) -> Sign {
        match node {
            Node::Number(value) => number_sign(*value),
            Node::Float(bits) => match f64::from_bits(*bits) {
                value if value > 0.0 => Sign::Positive,
                _ => Sign::Unknown,
            },
            Node::Sum { terms, constant } => self.sum_sign(terms, *constant),
            Node::Product(factors) => {
                let signs = factors.iter().map(|&(base, exponent)| self.power_sign(base, exponent));
                signs.min().unwrap_or(Sign::Unknown)
            }
            Node::Apply(function, arguments) => match function {
                Function::Exp | Function::Exp2 | Function::Cosh => Sign::Positive,
                Function::Sqrt | Function::Abs | Function::Hypot | Function::Acosh | Function::Acos => {
                    Sign::Nonnegative
                }
                Function::Special(special) if special.is_positive() => Sign::Positive,
                Function::Powf => self.sign(arguments[0]).min(Sign::Nonnegative),
                Function::Max => self.sign(arguments[0]).max(self.sign(arguments[1])),
                Function::Min => self.sign(arguments[0]).min(self.sign(arguments[1])),
                _ => Sign::Unknown,
            },
            Node::Select { then, otherwise, .. } => self.sign(*then).min(self.sign(*otherwise)),
            _ => Sign::Unknown,
        }
    }

    /// Whether the expression is 1 plus a nonnegative expression.
    pub(crate) fn exceeds_one(&self, expr: Expr) -> bool {
        let Node::Sum { terms, constant } = self.node(expr) else { return false };
        let rest = constant.add(Rational::MINUS_ONE);
        let is_nonnegative = |&(term, coefficient): &(Expr, Rational)| match coefficient.is_negative() {
            false => self.sign(term) >= Sign::Nonnegative,
            true => self.is_negated_square(term),
        };
        rest.is_some_and(|rest| !rest.is_negative()) && terms.iter().all(is_nonnegative)
    }

    /// `a · (-a)` for a sum `a`: the two are different nodes.
    fn is_negated_square(&self, expr: Expr) -> bool {
        let Node::Product(factors) = self.node(expr) else { return false };
        let &[(a, Rational::ONE), (b, Rational::ONE)] = factors.as_ref() else { return false };
        match (self.node(a), self.node(b)) {
            (Node::Sum { terms: a, constant: x }, Node::Sum { terms: b, constant: y }) => {
                *x == y.negate()
                    && a.len() == b.len()
                    && a.iter().zip(b).all(|(a, b)| a.0 == b.0 && a.1 == b.1.negate())
            }
            _ => false,
        }
    }

    fn sum_sign(&self, terms: &[(Expr, Rational)], constant: Rational) -> Sign {
        let mut strongest = number_sign(constant);
        if constant.is_negative() {
            return Sign::Unknown;
        }
        for &(term, coefficient) in terms {
            match (coefficient.is_negative(), self.sign(term)) {
                (true, _) | (_, Sign::Unknown) => return Sign::Unknown,
                (false, sign) => strongest = strongest.max(sign),
            }
        }
        strongest
    }

    fn power_sign(&self, base: Expr, exponent: Rational) -> Sign {
        let of_base = self.sign(base);
        // A defined negative power has a nonzero base, but its value may underflow to zero.
        match of_base {
            Sign::Unknown if exponent.is_integer() && exponent.numerator() % 2 == 0 => Sign::Nonnegative,
            Sign::Positive if !exponent.is_negative() => Sign::Positive,
            Sign::Unknown => Sign::Unknown,
            _ => Sign::Nonnegative,
        }
    }
}

fn number_sign(value: Rational) -> Sign {
    match value {
        value if value.is_negative() => Sign::Unknown,
        value if value.is_zero() => Sign::Nonnegative,
        _ => Sign::Positive,
    }
}
