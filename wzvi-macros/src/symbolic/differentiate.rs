//! Derivatives by the chain rule, one pass over the shared graph.
//!
//! The chain rule multiplies 0 by infinity where the derivative has a limit. Three rules take that limit:
//!
//! * a slope that is exactly zero on a piece makes the whole term zero there: `√u u'` with `u = max(x, 0)`,
//! * powers of one base are differentiated together: `u ∛u`, `(u²)^(3/4)`, `hypot(x, y)²`,
//! * `f(r)` with `r² = x² + y² + …` and `f'(0) = 0` has the slope `(f'(r)/r) (x x' + y y' + …)`, where the
//!   first factor is `f''(0)` at `r = 0` ([`super::radial`]).
//!
//! Tests: `symbolic/tests/random.rs`, and for the limits `tests/steps/limits.rs`.

use std::collections::HashMap;

use super::graph::Support;
use super::sign::Sign;
use super::{Expr, Function, Graph, Node, Rational, Relation, Symbol};

/// Products of more factors are differentiated by halves.
const LONG_PRODUCT: usize = 8;

/// Slopes by node, zero unless `known`.
struct NodeDerivatives {
    known: HashMap<Expr, Expr>,
    zero: Expr,
    /// Whether the infinite slope of a root at zero counts as zero.
    is_bounded: bool,
}

impl NodeDerivatives {
    fn of(&self, expr: Expr) -> Expr {
        self.known.get(&expr).copied().unwrap_or(self.zero)
    }
}

impl Graph {
    /// `∂expr/∂symbol`
    pub(crate) fn derivative(&mut self, expr: Expr, symbol: Symbol) -> Expr {
        let one = self.integer(1);
        self.differentiated(expr, Support::of([symbol]), &|other| (other == symbol).then_some(one), false)
    }

    /// `∂expr/∂symbol` for the matrices of Newton's method: 0 where only a root in `expr` has an infinite
    /// slope. There is no better matrix, and the solution does not depend on it.
    pub(crate) fn hessian_entry(&mut self, expr: Expr, symbol: Symbol) -> Expr {
        let one = self.integer(1);
        self.differentiated(expr, Support::of([symbol]), &|other| (other == symbol).then_some(one), true)
    }

    /// `Σ ∂expr/∂x · velocity`, in one pass for all variables `x` with a velocity.
    pub(crate) fn rate(&mut self, expr: Expr, velocities: &HashMap<Symbol, Expr>) -> Expr {
        let support = Support::of(velocities.keys().copied());
        self.differentiated(expr, support, &|symbol| velocities.get(&symbol).copied(), false)
    }

    /// The slope of an expression whose variables have the slopes `of_symbol`, none outside of `support`.
    fn differentiated(
        &mut self,
        expr: Expr,
        support: Support,
        of_symbol: &dyn Fn(Symbol) -> Option<Expr>,
        is_bounded: bool,
    ) -> Expr {
        // Only nodes that may contain one of them are visited: the others have no slope.
        let mut parts = self.reachable_where(&[expr], |part| self.support(part).intersects(support));
        parts.sort_unstable();
        let mut slopes =
            NodeDerivatives { known: HashMap::with_capacity(parts.len()), zero: self.integer(0), is_bounded };
        for part in parts {
            let node = self.node(part).clone();
            let slope = match &node {
                Node::Symbol(symbol) => of_symbol(*symbol).unwrap_or(slopes.zero),
                _ => self.slope(part, &node, &slopes),
            };
            if slope != slopes.zero {
                slopes.known.insert(part, slope);
            }
        }
        let slope = slopes.of(expr);
        self.radial_limits(slope)
    }

    fn slope(&mut self, expr: Expr, node: &Node, slopes: &NodeDerivatives) -> Expr {
        match node {
            Node::Sum { terms, .. } => {
                let terms: Vec<_> = terms.iter().map(|&(term, c)| (slopes.of(term), c)).collect();
                self.linear_combination(&terms)
            }
            Node::Product(factors) => self.product_slope(factors, slopes),
            &Node::Apply(function @ (Function::Min | Function::Max), ref arguments) => {
                let (mut a, mut b) = (arguments[0], arguments[1]);
                // If both are equal, the second argument gives the slope. It is the constant, if there is
                // one.
                if slopes.of(a) == slopes.zero {
                    (a, b) = (b, a);
                }
                let (left, right) = if function == Function::Min { (a, b) } else { (b, a) };
                let is_first = self.compare(Relation::Less, left, right);
                self.select(is_first, slopes.of(a), slopes.of(b))
            }
            Node::Apply(function, arguments) => {
                let mut terms = Vec::new();
                for (i, &argument) in arguments.iter().enumerate() {
                    let slope = slopes.of(argument);
                    if slope != slopes.zero {
                        if *function == Function::Hypot {
                            return self.radial_slope(expr, Rational::ONE, slopes);
                        }
                        let mut partial = self.partial(expr, *function, arguments, i);
                        if slopes.is_bounded && matches!(function, Function::Sqrt | Function::Cbrt) {
                            partial = self.zero_at(arguments[0], partial);
                        }
                        let is_power = *function == Function::Powf && i == 0;
                        if is_power && slopes.is_bounded && self.sign(argument) != Sign::Positive {
                            partial = self.zero_at_root(argument, arguments[1], partial);
                        }
                        let mut term = self.beside_slope(&[(partial, Rational::ONE)], slope);
                        if is_power && self.has_even_zeros(argument) {
                            term = self.zero_at(argument, term);
                        }
                        terms.push(term);
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
    fn product_slope(&mut self, factors: &[(Expr, Rational)], slopes: &NodeDerivatives) -> Expr {
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
            let mut others = factors.to_vec();
            others.remove(i);
            if let Some((x, root)) = self.root_of(base, exponent) {
                let beside = others.iter().position(|&(other, e)| other == x && is_natural(e));
                // The first root of `x` is differentiated together with `x`.
                if beside.is_some() && self.root_beside(factors, x) != Some(i) {
                    continue;
                }
                if root != Function::Abs || beside.is_some() {
                    let m = beside.map_or(Rational::ZERO, |at| others.remove(at).1);
                    if slopes.of(x) != slopes.zero
                        && let Some((total, lower)) = lowered(root, base, exponent, x, m)
                        && let Some(total) = self.with_roots(total, beside.and(Some(others.as_slice())), x)
                    {
                        others.extend(lower);
                        terms.push((self.times(&others, x, total, slopes), total));
                    }
                    continue;
                }
            }
            // The base is differentiated together with a root of it.
            if is_natural(exponent) && self.root_beside(factors, base).is_some() {
                continue;
            }
            if let Node::Apply(Function::Hypot, _) = self.node(base) {
                let slope = self.radial_slope(base, exponent, slopes);
                others.push((slope, Rational::ONE));
                terms.push((self.product_of_powers(&others), Rational::ONE));
                continue;
            }
            if let Some((x, power, factor)) = self.even_power(base, exponent) {
                if slopes.of(x) != slopes.zero {
                    // The slope of |x|^n is n |x|^(n-2) x, or n |x|^(n-1) with the sign of x.
                    let (size, sign) = (self.apply(Function::Abs, &[x]), self.apply(Function::Signum, &[x]));
                    let (below, other) = if power < Rational::integer(2) { (-1, sign) } else { (-2, x) };
                    if let Some(below) = power.add(Rational::integer(below)) {
                        let factor = self.power(factor, exponent);
                        others.extend([(factor, Rational::ONE), (size, below), (other, Rational::ONE)]);
                        terms.push((self.times(&others, x, power, slopes), power));
                    }
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
                let mut term = self.times(&operands, base, exponent, slopes);
                // The slope of a sum of squares vanishes as its square root does.
                if is_root(exponent) && Rational::HALF < exponent && self.is_sum_of_squares(base) {
                    term = self.zero_at(base, term);
                }
                terms.push((term, exponent));
            }
        }
        self.linear_combination(&terms)
    }

    /// `Π operand · x'`, zero where `x'` is zero on a piece: for the slope of `x^exponent`.
    fn times(
        &mut self,
        operands: &[(Expr, Rational)],
        x: Expr,
        exponent: Rational,
        slopes: &NodeDerivatives,
    ) -> Expr {
        let term = self.beside_slope(operands, slopes.of(x));
        let is_bounded = slopes.is_bounded && is_root(exponent) && self.sign(x) != Sign::Positive;
        if is_bounded { self.zero_at(x, term) } else { term }
    }

    /// `Π operand · slope`, as one selection with zero if the slope is one.
    fn beside_slope(&mut self, operands: &[(Expr, Rational)], slope: Expr) -> Expr {
        let mut operands = operands.to_vec();
        let (coefficient, inner) = self.as_multiple(slope);
        let (condition, then, otherwise) = match *self.node(inner) {
            Node::Select { condition, then, otherwise } if self.is_zero(then) || self.is_zero(otherwise) => {
                (condition, then, otherwise)
            }
            _ => {
                operands.push((slope, Rational::ONE));
                return self.product_of_powers(&operands);
            }
        };
        let is_below = self.is_zero(otherwise);
        operands.push((if is_below { then } else { otherwise }, Rational::ONE));
        let product = self.product_of_powers(&operands);
        let product = match is_below {
            true => self.select(condition, product, otherwise),
            false => self.select(condition, then, product),
        };
        self.scale(product, coefficient)
    }

    /// `term`, and 0 where `x = 0`.
    fn zero_at(&mut self, x: Expr, term: Expr) -> Expr {
        let zero = self.integer(0);
        let vanishes = self.compare(Relation::Equal, x, zero);
        self.select(vanishes, zero, term)
    }

    /// `term`, and 0 where `x = 0` if the exponent is below 1.
    fn zero_at_root(&mut self, x: Expr, exponent: Expr, term: Expr) -> Expr {
        let (zero, one) = (self.integer(0), self.integer(1));
        let is_root = self.compare(Relation::Less, exponent, one);
        let at_zero = self.select(is_root, zero, term);
        let vanishes = self.compare(Relation::Equal, x, zero);
        self.select(vanishes, at_zero, term)
    }

    /// Whether the slope of `x` vanishes where `x` does, so that powers above 1/2 have the slope 0 there:
    /// squares, sums of them. A distance has none there, and its powers above 1 have the slope 0.
    fn has_even_zeros(&self, x: Expr) -> bool {
        let is_distance = matches!(self.node(x), Node::Apply(Function::Hypot, _));
        is_distance || self.is_square(x) || self.is_sum_of_squares(x)
    }

    /// The argument of a root or an absolute value with such an exponent, which is a power of it.
    fn root_of(&self, base: Expr, exponent: Rational) -> Option<(Expr, Function)> {
        match self.node(base) {
            &Node::Apply(function @ (Function::Sqrt | Function::Cbrt | Function::Abs), ref arguments) => {
                let is_power = exponent.is_integer() || function == Function::Abs;
                (is_power && !exponent.is_negative()).then_some((arguments[0], function))
            }
            _ => None,
        }
    }

    /// The first root of `x` among the factors.
    fn root_beside(&self, factors: &[(Expr, Rational)], x: Expr) -> Option<usize> {
        factors
            .iter()
            .position(|&(base, exponent)| self.root_of(base, exponent).is_some_and(|(of, _)| of == x))
    }

    /// `total`, and the exponents of `x` in the roots of it among `others`.
    fn with_roots(&self, total: Rational, others: Option<&[(Expr, Rational)]>, x: Expr) -> Option<Rational> {
        others.unwrap_or_default().iter().try_fold(total, |total, &(base, exponent)| {
            match self.root_of(base, exponent) {
                Some((of, root)) if of == x => total.add(exponent.multiply(exponent_of(root))?),
                _ => Some(total),
            }
        })
    }

    /// `x`, `k e` and `c`, if `base^e` is `(c x^k)^e` with even `k` and a fraction `e`.
    fn even_power(&mut self, base: Expr, exponent: Rational) -> Option<(Expr, Rational, Expr)> {
        let (factor, inner) = self.as_multiple(base);
        let Node::Product(powers) = self.node(inner) else { return None };
        let &[(x, power)] = powers.as_ref() else { return None };
        let is_even = is_natural(power) && power.numerator() % 2 == 0;
        let total = power.multiply(exponent).filter(|total| !total.is_negative())?;
        let is_open = is_even && !exponent.is_integer() && !factor.is_negative();
        is_open.then(|| (x, total, self.number(factor)))
    }

    /// The slope of `r^n` with `r² = x² + y² + …`: `n r^(n-2) (x x' + y y' + …)`.
    fn radial_slope(&mut self, r: Expr, n: Rational, slopes: &NodeDerivatives) -> Expr {
        let half = self.half_slope_of_square(r, slopes);
        let Some(lower) = n.add(Rational::integer(-2)) else { return half };
        let slope = self.product_of_powers(&[(r, lower), (half, Rational::ONE)]);
        let slope = self.scale(slope, n);
        // It vanishes as r^(n-1) does.
        let has_limit = Rational::ONE < n && n < Rational::integer(2);
        if has_limit && slope != slopes.zero { self.zero_at(r, slope) } else { slope }
    }

    /// `x x' + y y'` of `hypot(x, y)`, `x x'` of other `x`.
    fn half_slope_of_square(&mut self, x: Expr, slopes: &NodeDerivatives) -> Expr {
        match self.node(x).clone() {
            Node::Apply(Function::Hypot, arguments) => {
                let halves: Vec<Expr> =
                    arguments.iter().map(|&argument| self.half_slope_of_square(argument, slopes)).collect();
                self.sum(&halves)
            }
            _ => self.beside_slope(&[(x, Rational::ONE)], slopes.of(x)),
        }
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
            Function::Special(special) => return special.slope(self, x),
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

/// Whether it is 1, 2, ...
fn is_natural(exponent: Rational) -> bool {
    exponent.is_integer() && exponent.numerator() > 0
}

/// Whether powers with this exponent have an infinite slope at zero.
fn is_root(exponent: Rational) -> bool {
    Rational::ZERO < exponent && exponent < Rational::ONE
}

/// The exponent of `x` in its root or absolute value.
fn exponent_of(root: Function) -> Rational {
    match root {
        Function::Sqrt => Rational::HALF,
        Function::Cbrt => Rational::THIRD,
        _ => Rational::ONE,
    }
}

/// `(root of x)^n x^m / x` as powers, and the exponent of `x` in the product before the division.
fn lowered(
    root: Function,
    base: Expr,
    n: Rational,
    x: Expr,
    m: Rational,
) -> Option<(Rational, Vec<(Expr, Rational)>)> {
    let degree = match root {
        Function::Sqrt => 2,
        Function::Cbrt => 3,
        _ => return Some((m.add(n)?, vec![(base, n), (x, m.add(Rational::MINUS_ONE)?)])),
    };
    let left = degree * m.numerator() + n.numerator() - degree;
    let total = Rational::new((left + degree).into(), degree.into())?;
    let [whole, rest] = if m.is_zero() || left < 0 { [0, left] } else { [left / degree, left % degree] };
    let powers = [(x, whole), (base, rest)];
    let powers = powers.map(|(base, exponent)| Some((base, Rational::new(exponent.into(), 1)?)));
    Some((total, powers.into_iter().collect::<Option<_>>()?))
}
