//! Derivatives by the chain rule, one pass over the shared graph.

use std::collections::HashMap;

use super::graph::Support;
use super::{Expr, Function, Graph, Node, Rational, Relation, Symbol};

/// Products of more factors are differentiated by halves.
const LONG_PRODUCT: usize = 8;

/// The derivative `dx/ds` of every symbol `x` in the direction `s`. Symbols not listed are constant. A list of
/// several symbols gives a total derivative: for `Q = (1-l) q_i + l q_{i+1}`, `dQ/dq_i = 1-l`.
pub(crate) type Direction = HashMap<Symbol, Rational>;

/// Slopes by node, zero unless `known`.
struct Slopes {
    known: HashMap<Expr, Expr>,
    zero: Expr,
}

impl Slopes {
    fn of(&self, expr: Expr) -> Expr {
        self.known.get(&expr).copied().unwrap_or(self.zero)
    }
}

impl Graph {
    /// `∂expr/∂symbol`
    pub(crate) fn derivative(&mut self, expr: Expr, symbol: Symbol) -> Expr {
        self.differentiate(expr, &HashMap::from([(symbol, Rational::ONE)]))
    }

    /// The derivative of `expr` in `direction`.
    pub(crate) fn differentiate(&mut self, expr: Expr, direction: &Direction) -> Expr {
        let support = Support::of(direction.keys().copied());
        // Only nodes that may contain a moving symbol are visited: the others have no slope.
        let mut parts = self.reachable_where(&[expr], |part| self.support(part).intersects(support));
        parts.sort_unstable();
        let mut slopes = Slopes { known: HashMap::with_capacity(parts.len()), zero: self.integer(0) };
        for part in parts {
            let node = self.node(part).clone();
            let slope = match &node {
                Node::Symbol(symbol) => {
                    let speed = direction.get(symbol).copied().unwrap_or(Rational::ZERO);
                    self.number(speed)
                }
                _ => self.slope(part, &node, &slopes),
            };
            if slope != slopes.zero {
                slopes.known.insert(part, slope);
            }
        }
        slopes.of(expr)
    }

    fn slope(&mut self, expr: Expr, node: &Node, slopes: &Slopes) -> Expr {
        match node {
            Node::Sum { terms, .. } => {
                let terms: Vec<_> = terms.iter().map(|&(term, c)| (slopes.of(term), c)).collect();
                self.linear_combination(&terms)
            }
            Node::Product(factors) => self.product_slope(factors, slopes),
            &Node::Apply(function @ (Function::Min | Function::Max), ref arguments) => {
                let (a, b) = (arguments[0], arguments[1]);
                let less = self.compare(Relation::Less, a, b);
                let (smaller, larger) = (slopes.of(a), slopes.of(b));
                match function {
                    Function::Min => self.select(less, smaller, larger),
                    _ => self.select(less, larger, smaller),
                }
            }
            Node::Apply(function, arguments) => {
                let mut terms = Vec::new();
                for (i, &argument) in arguments.iter().enumerate() {
                    let slope = slopes.of(argument);
                    if slope != slopes.zero {
                        let partial = self.partial(expr, *function, arguments, i);
                        terms.push(self.multiply(partial, slope));
                    }
                }
                self.sum(&terms)
            }
            &Node::Select { condition, then, otherwise } => {
                self.select(condition, slopes.of(then), slopes.of(otherwise))
            }
            _ => slopes.zero,
        }
    }

    /// `(Π f_i)' = Σ f_i' Π_{j≠i} f_j`. Long products are halved, which keeps the cost near linear.
    fn product_slope(&mut self, factors: &[(Expr, Rational)], slopes: &Slopes) -> Expr {
        if factors.len() > LONG_PRODUCT {
            let (left, right) = factors.split_at(factors.len() / 2);
            let (left_slope, right_slope) =
                (self.product_slope(left, slopes), self.product_slope(right, slopes));
            let (left, right) = (self.product_of_powers(left), self.product_of_powers(right));
            let (first, second) = (self.multiply(left_slope, right), self.multiply(left, right_slope));
            return self.add(first, second);
        }
        let mut terms = Vec::new();
        for (i, &(base, exponent)) in factors.iter().enumerate() {
            // `(√x)^n` is differentiated as `x^(n/2)`: `(√x)^(n-1) / √x` would be undefined at zero.
            if let &Node::Apply(Function::Sqrt, ref arguments) = self.node(base)
                && let Some(lower) = exponent.add(Rational::integer(-2)).filter(|lower| !lower.is_negative())
                && let Some(half) = exponent.multiply(Rational::HALF)
            {
                let slope = slopes.of(arguments[0]);
                if slope != slopes.zero {
                    let mut operands = factors.to_vec();
                    operands[i].1 = lower;
                    operands.push((slope, Rational::ONE));
                    terms.push((self.product_of_powers(&operands), half));
                }
                continue;
            }
            let slope = slopes.of(base);
            if slope != slopes.zero {
                let mut operands = factors.to_vec();
                match exponent.add(Rational::MINUS_ONE) {
                    Some(lower) => operands[i].1 = lower,
                    None => operands.push((base, Rational::MINUS_ONE)),
                }
                operands.push((slope, Rational::ONE));
                terms.push((self.product_of_powers(&operands), exponent));
            }
        }
        self.linear_combination(&terms)
    }

    /// `∂function/∂argument_i` at `arguments`; `value` is the node of the function itself.
    ///
    /// Forms are chosen to avoid cancellation: `1/cosh²` rather than `1 - tanh²`, `(1-x)(1+x)` rather than
    /// `1 - x²`.
    fn partial(&mut self, value: Expr, function: Function, arguments: &[Expr], i: usize) -> Expr {
        const MINUS_HALF: Rational = Rational::HALF.negate();
        let x = arguments[0];
        let one = self.integer(1);
        let (base, exponent, factor) = match function {
            Function::Sqrt => (value, Rational::MINUS_ONE, Rational::HALF),
            Function::Cbrt => (value, Rational::integer(-2), Rational::THIRD),
            Function::Exp => return value,
            Function::Exp2 => {
                let ln_2 = self.float(std::f64::consts::LN_2);
                return self.multiply(ln_2, value);
            }
            Function::ExpM1 => return self.apply(Function::Exp, &[x]),
            Function::Ln => (x, Rational::MINUS_ONE, Rational::ONE),
            Function::Ln1p => (self.add(one, x), Rational::MINUS_ONE, Rational::ONE),
            Function::Log2 | Function::Log10 => {
                let is_binary = function == Function::Log2;
                let ln = self.float(if is_binary { std::f64::consts::LN_2 } else { std::f64::consts::LN_10 });
                (self.multiply(ln, x), Rational::MINUS_ONE, Rational::ONE)
            }
            Function::Sin => return self.apply(Function::Cos, &[x]),
            Function::Cos => (self.apply(Function::Sin, &[x]), Rational::ONE, Rational::MINUS_ONE),
            Function::Tan => return self.sum_of_squares(one, value),
            Function::Asin => (self.complement_of_square(x), MINUS_HALF, Rational::ONE),
            Function::Acos => (self.complement_of_square(x), MINUS_HALF, Rational::MINUS_ONE),
            Function::Atan => (self.sum_of_squares(one, x), Rational::MINUS_ONE, Rational::ONE),
            Function::Sinh => return self.apply(Function::Cosh, &[x]),
            Function::Cosh => return self.apply(Function::Sinh, &[x]),
            Function::Tanh => (self.apply(Function::Cosh, &[x]), Rational::integer(-2), Rational::ONE),
            Function::Asinh => (self.sum_of_squares(one, x), MINUS_HALF, Rational::ONE),
            Function::Acosh => {
                let (below, above) = (self.subtract(x, one), self.add(x, one));
                let (below, above) = (self.power(below, MINUS_HALF), self.power(above, MINUS_HALF));
                return self.multiply(below, above);
            }
            Function::Atanh => (self.complement_of_square(x), Rational::MINUS_ONE, Rational::ONE),
            Function::Abs => return self.apply(Function::Signum, &[x]),
            Function::Powf => return self.powf_partial(value, x, arguments[1], i),
            Function::Atan2 => {
                let (y, x) = (arguments[0], arguments[1]);
                let radius = self.sum_of_squares(x, y);
                let numerator = if i == 0 { x } else { self.negate(y) };
                return self.divide(numerator, radius);
            }
            Function::Hypot => return self.divide(arguments[i], value),
            // The slope of `min` or `max` is a selection between slopes, made by the caller.
            Function::Signum | Function::Min | Function::Max => return self.integer(0),
        };
        let power = self.power(base, exponent);
        self.scale(power, factor)
    }

    fn powf_partial(&mut self, value: Expr, base: Expr, exponent: Expr, i: usize) -> Expr {
        let one = self.integer(1);
        if i == 0 {
            let lower = self.subtract(exponent, one);
            let power = self.apply(Function::Powf, &[base, lower]);
            let slope = self.multiply(exponent, power);
            // `x^0` is 1 also at zero, where `0 x^-1` is NaN.
            let zero = self.integer(0);
            let is_constant = self.compare(Relation::Equal, exponent, zero);
            self.select(is_constant, zero, slope)
        } else {
            let logarithm = self.apply(Function::Ln, &[base]);
            self.multiply(logarithm, value)
        }
    }

    /// `1 - x²` as `(1 - x)(1 + x)`
    fn complement_of_square(&mut self, x: Expr) -> Expr {
        let one = self.integer(1);
        let (below, above) = (self.subtract(one, x), self.add(one, x));
        self.multiply(below, above)
    }

    fn sum_of_squares(&mut self, x: Expr, y: Expr) -> Expr {
        let (x, y) = (self.power(x, Rational::integer(2)), self.power(y, Rational::integer(2)));
        self.add(x, y)
    }
}
