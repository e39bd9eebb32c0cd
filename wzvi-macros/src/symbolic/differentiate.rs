//! Derivatives by the chain rule, one pass over the shared graph.

use std::collections::HashMap;

use super::{Expr, Function, Graph, Node, Rational, Relation, Symbol};

/// What every symbol contributes: `dx/ds` for a derivative in the direction `s`. Symbols that are not listed are
/// constant. A list of several symbols gives a total derivative: for `Q = (1-l) q_i + l q_{i+1}`, `dQ/dq_i = 1-l`.
pub(crate) type Direction = HashMap<Symbol, Rational>;

impl Graph {
    /// `∂expr/∂symbol`
    pub(crate) fn derivative(&mut self, expr: Expr, symbol: Symbol) -> Expr {
        self.differentiate(expr, &HashMap::from([(symbol, Rational::ONE)]))
    }

    /// The derivative of `expr` in `direction`.
    pub(crate) fn differentiate(&mut self, expr: Expr, direction: &Direction) -> Expr {
        let mut slopes: HashMap<Expr, Expr> = HashMap::new();
        let zero = self.integer(0);
        for part in self.reachable(&[expr]) {
            let node = self.node(part).clone();
            let varies = node.operands().iter().any(|operand| slopes[operand] != zero);
            let slope = match &node {
                Node::Symbol(symbol) => {
                    let speed = direction.get(symbol).copied().unwrap_or(Rational::ZERO);
                    self.number(speed)
                }
                _ if !varies => zero,
                Node::Compare(..) | Node::Not(_) | Node::And(..) | Node::Or(..) => zero,
                _ => self.slope(part, &node, &slopes),
            };
            slopes.insert(part, slope);
        }
        slopes[&expr]
    }

    fn slope(&mut self, expr: Expr, node: &Node, slopes: &HashMap<Expr, Expr>) -> Expr {
        match node {
            Node::Sum { terms, .. } => {
                let terms: Vec<_> = terms.iter().map(|&(term, c)| (slopes[&term], c)).collect();
                self.linear_combination(&terms)
            }
            Node::Product(factors) => {
                let mut terms = Vec::new();
                for (i, &(base, exponent)) in factors.iter().enumerate() {
                    if self.is_zero(slopes[&base]) {
                        continue;
                    }
                    let mut operands = vec![slopes[&base]];
                    for (j, &(other, power)) in factors.iter().enumerate() {
                        let power =
                            if i == j { power.add(Rational::MINUS_ONE).unwrap_or(power) } else { power };
                        operands.push(self.power(other, power));
                    }
                    terms.push((self.product(&operands), exponent));
                }
                self.linear_combination(&terms)
            }
            Node::Apply(function, arguments) => {
                let terms: Vec<_> = (0..arguments.len())
                    .filter(|&i| !self.is_zero(slopes[&arguments[i]]))
                    .collect::<Vec<_>>()
                    .into_iter()
                    .map(|i| {
                        let partial = self.partial(expr, *function, arguments, i);
                        self.multiply(partial, slopes[&arguments[i]])
                    })
                    .collect();
                self.sum(&terms)
            }
            &Node::Select { condition, then, otherwise } => {
                self.select(condition, slopes[&then], slopes[&otherwise])
            }
            _ => self.integer(0),
        }
    }

    /// `∂function/∂argument_i` at `arguments`; `value` is the node of the function itself.
    ///
    /// Forms are chosen to keep digits: `1/cosh²` rather than `1 - tanh²`, `(1-x)(1+x)` rather than `1 - x²`.
    fn partial(&mut self, value: Expr, function: Function, arguments: &[Expr], i: usize) -> Expr {
        let x = arguments[0];
        let one = self.integer(1);
        match function {
            Function::Sqrt => {
                let inverse = self.power(value, Rational::MINUS_ONE);
                self.scale(inverse, Rational::HALF)
            }
            Function::Cbrt => {
                let inverse = self.power(value, Rational::integer(-2));
                Rational::new(1, 3).map_or(inverse, |third| self.scale(inverse, third))
            }
            Function::Exp => value,
            Function::Exp2 => {
                let ln_2 = self.float(std::f64::consts::LN_2);
                self.multiply(ln_2, value)
            }
            Function::ExpM1 => self.apply(Function::Exp, &[x]),
            Function::Ln => self.power(x, Rational::MINUS_ONE),
            Function::Ln1p => {
                let shifted = self.add(one, x);
                self.power(shifted, Rational::MINUS_ONE)
            }
            Function::Log2 => self.inverse_of_multiple(x, std::f64::consts::LN_2),
            Function::Log10 => self.inverse_of_multiple(x, std::f64::consts::LN_10),
            Function::Sin => self.apply(Function::Cos, &[x]),
            Function::Cos => {
                let sine = self.apply(Function::Sin, &[x]);
                self.negate(sine)
            }
            Function::Tan => {
                let square = self.power(value, Rational::integer(2));
                self.add(one, square)
            }
            Function::Asin => self.inverse_root_of_complement(x),
            Function::Acos => {
                let slope = self.inverse_root_of_complement(x);
                self.negate(slope)
            }
            Function::Atan => {
                let square = self.power(x, Rational::integer(2));
                let sum = self.add(one, square);
                self.power(sum, Rational::MINUS_ONE)
            }
            Function::Sinh => self.apply(Function::Cosh, &[x]),
            Function::Cosh => self.apply(Function::Sinh, &[x]),
            Function::Tanh => {
                let cosine = self.apply(Function::Cosh, &[x]);
                self.power(cosine, Rational::integer(-2))
            }
            Function::Asinh => {
                let square = self.power(x, Rational::integer(2));
                let sum = self.add(one, square);
                let minus_half = Rational::HALF.negate();
                self.power(sum, minus_half)
            }
            Function::Acosh => {
                let (below, above) = (self.subtract(x, one), self.add(x, one));
                let minus_half = Rational::HALF.negate();
                let (below, above) = (self.power(below, minus_half), self.power(above, minus_half));
                self.multiply(below, above)
            }
            Function::Atanh => {
                let complement = self.complement_of_square(x);
                self.power(complement, Rational::MINUS_ONE)
            }
            Function::Abs => self.apply(Function::Signum, &[x]),
            Function::Signum => self.integer(0),
            Function::Powf => self.powf_partial(value, x, arguments[1], i),
            Function::Atan2 => {
                let (y, x) = (arguments[0], arguments[1]);
                let radius = self.sum_of_squares(x, y);
                let numerator = if i == 0 { x } else { self.negate(y) };
                self.divide(numerator, radius)
            }
            Function::Hypot => self.divide(arguments[i], value),
            Function::Min | Function::Max => {
                let first_is_less = self.compare(Relation::Less, x, arguments[1]);
                let picks_first =
                    if function == Function::Min { first_is_less } else { self.not(first_is_less) };
                let zero = self.integer(0);
                if i == 0 { self.select(picks_first, one, zero) } else { self.select(picks_first, zero, one) }
            }
        }
    }

    fn powf_partial(&mut self, value: Expr, base: Expr, exponent: Expr, i: usize) -> Expr {
        let one = self.integer(1);
        if i == 0 {
            let lower = self.subtract(exponent, one);
            let power = self.apply(Function::Powf, &[base, lower]);
            self.multiply(exponent, power)
        } else {
            let logarithm = self.apply(Function::Ln, &[base]);
            self.multiply(logarithm, value)
        }
    }

    fn inverse_of_multiple(&mut self, x: Expr, factor: f64) -> Expr {
        let factor = self.float(factor);
        let product = self.multiply(factor, x);
        self.power(product, Rational::MINUS_ONE)
    }

    /// `1 - x²` as `(1 - x)(1 + x)`
    fn complement_of_square(&mut self, x: Expr) -> Expr {
        let one = self.integer(1);
        let (below, above) = (self.subtract(one, x), self.add(one, x));
        self.multiply(below, above)
    }

    fn inverse_root_of_complement(&mut self, x: Expr) -> Expr {
        let complement = self.complement_of_square(x);
        self.power(complement, Rational::HALF.negate())
    }

    fn sum_of_squares(&mut self, x: Expr, y: Expr) -> Expr {
        let (x, y) = (self.power(x, Rational::integer(2)), self.power(y, Rational::integer(2)));
        self.add(x, y)
    }
}
