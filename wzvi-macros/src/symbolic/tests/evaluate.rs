//! Values in plain binary64.

use crate::symbolic::evaluate::power;
use crate::symbolic::{Expr, Graph, Junction, Node, Relation, Symbol};

impl Graph {
    /// The values of `roots`; conditions are 1 or 0.
    pub(crate) fn evaluate(&self, roots: &[Expr], values: &dyn Fn(Symbol) -> f64) -> Vec<f64> {
        self.fold(roots, f64::NAN, |_, node, value| evaluate_node(node, values, value))
    }
}

fn evaluate_node(node: &Node, values: &dyn Fn(Symbol) -> f64, value: &dyn Fn(Expr) -> f64) -> f64 {
    let truth = |condition: bool| f64::from(u8::from(condition));
    match node {
        Node::Number(number) => number.to_f64(),
        Node::Float(bits) => f64::from_bits(*bits),
        Node::Symbol(symbol) => values(*symbol),
        Node::Sum { terms, constant } => {
            terms.iter().fold(constant.to_f64(), |sum, &(term, c)| sum + c.to_f64() * value(term))
        }
        Node::Product(factors) => {
            factors.iter().map(|&(base, exponent)| power(value(base), exponent)).product()
        }
        Node::Apply(function, arguments) => {
            let arguments: Vec<f64> = arguments.iter().map(|&argument| value(argument)).collect();
            function.evaluate(&arguments)
        }
        Node::Select { condition, then, otherwise } => {
            if value(*condition) != 0.0 {
                value(*then)
            } else {
                value(*otherwise)
            }
        }
        Node::Compare(Relation::Less, a, b) => truth(value(*a) < value(*b)),
        Node::Compare(Relation::LessEqual, a, b) => truth(value(*a) <= value(*b)),
        Node::Compare(Relation::Equal, a, b) => truth(value(*a) == value(*b)),
        Node::Not(a) => truth(value(*a) == 0.0),
        Node::Join(Junction::And, a, b) => truth(value(*a) != 0.0 && value(*b) != 0.0),
        Node::Join(Junction::Or, a, b) => truth(value(*a) != 0.0 || value(*b) != 0.0),
    }
}
