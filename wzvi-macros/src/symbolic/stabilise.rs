//! Rewrites forms that lose digits where two nearly equal numbers are subtracted.
//!
//! | written | computed | loses digits near |
//! |---|---|---|
//! | `a - a cos x` | `2 a sin²(x/2)` | `x = 0` |
//! | `a + a cos x` | `2 a cos²(x/2)` | `x = π` |
//! | `a cosh x - a` | `2 a sinh²(x/2)` | `x = 0` |
//! | `a exp x - a` | `a expm1 x` | `x = 0` |
//! | `ln(1 + x)` | `ln1p x` | `x = 0` |
//! | `√s - √t` | `(s - t) / (√s + √t)`, where `s - t` cancels symbolically | `s = t` |
//! | `x² - y²` | `(x - y) (x + y)` | `x = ±y` |
//!
//! Each replaces terms by one whose size is at most their sum, so that the error bound of no expression grows. This
//! runs after differentiation, on what is emitted: derivatives are taken of the forms that the user wrote.

use std::collections::HashMap;

use super::sign::Sign;
use super::{Expr, Function, Graph, Node, Rational, Relation};

/// `Σ coefficient · term` being rewritten; the constant is a term of the number one, and what was replaced has no
/// coefficient.
type Terms = Vec<(Expr, Option<Rational>)>;

/// Sums with more roots than this are not searched for pairs of them.
const MOST_ROOTS: usize = 8;

impl Graph {
    /// The same values as `roots`, in forms that keep their digits.
    pub(crate) fn stabilise(&mut self, roots: &[Expr]) -> Vec<Expr> {
        let mut images: HashMap<Expr, Expr> = HashMap::new();
        for expr in self.reachable(roots) {
            let node = self.node(expr).clone();
            let rebuilt = if node.operands().iter().all(|operand| images[operand] == *operand) {
                expr
            } else {
                self.rebuild(&node, &|operand| images[&operand])
            };
            let image = self.stable_form(rebuilt);
            images.insert(expr, image);
        }
        roots.iter().map(|root| images[root]).collect()
    }

    fn stable_form(&mut self, expr: Expr) -> Expr {
        match self.node(expr).clone() {
            Node::Sum { terms, constant } => self.stable_sum(expr, &terms, constant),
            Node::Apply(Function::Ln, arguments) => self.logarithm_of_one_plus(arguments[0]).unwrap_or(expr),
            _ => expr,
        }
    }

    /// `ln(1 + x)` as `ln1p x`.
    fn logarithm_of_one_plus(&mut self, argument: Expr) -> Option<Expr> {
        let Node::Sum { constant: Rational::ONE, .. } = self.node(argument) else { return None };
        let one = self.integer(1);
        let rest = self.subtract(argument, one);
        Some(self.apply(Function::Ln1p, &[rest]))
    }

    fn stable_sum(&mut self, expr: Expr, terms: &[(Expr, Rational)], constant: Rational) -> Expr {
        let one = self.integer(1);
        let mut pool: Terms = terms.iter().map(|&(term, c)| (term, Some(c))).collect();
        if !constant.is_zero() {
            pool.push((one, Some(constant)));
        }
        let mut replacements = self.pair_functions(&mut pool);
        replacements.extend(self.share_constant(&mut pool, one));
        replacements.extend(self.pair_roots(&mut pool));
        if replacements.is_empty()
            && let &[(first, Some(c)), (second, Some(d))] = pool.as_slice()
            && c == d.negate()
            && let Some(product) = self.difference_of_squares(first, second)
        {
            return self.scale(product, c);
        }
        if replacements.is_empty() {
            return expr;
        }
        replacements.extend(pool.iter().filter_map(|&(term, c)| Some((term, c?))));
        self.linear_combination(&replacements)
    }

    /// `a f(x)` with `±a`, for every such pair in the sum.
    fn pair_functions(&mut self, pool: &mut Terms) -> Vec<(Expr, Rational)> {
        let places: HashMap<Expr, usize> = pool.iter().enumerate().map(|(i, &(term, _))| (term, i)).collect();
        let mut replacements = Vec::new();
        for i in 0..pool.len() {
            for (function, x, rest) in self.functions_in(pool[i].0) {
                let Some(&j) = places.get(&rest) else { continue };
                let (Some(coefficient), Some(partner)) = (pool[i].1, pool[j].1) else { continue };
                let opposite = coefficient == partner.negate();
                if (opposite || coefficient == partner)
                    && let Some(replacement) = self.joined(function, x, rest, opposite)
                {
                    replacements.push((replacement, coefficient));
                    (pool[i].1, pool[j].1) = (None, None);
                }
            }
        }
        replacements
    }

    /// `n - cos x_1 - ... - cos x_n`: the constant of a sum of many `1 - cos x` was added up.
    fn share_constant(&mut self, pool: &mut Terms, one: Expr) -> Vec<(Expr, Rational)> {
        let Some((_, Some(constant))) = pool.iter().rev().find(|(term, _)| *term == one).copied() else {
            return Vec::new();
        };
        let mut sharing: Vec<(usize, Expr, Rational)> = Vec::new();
        let mut left = Some(constant);
        for (i, &(term, coefficient)) in pool.iter().enumerate() {
            let Some(coefficient) = coefficient.filter(|c| c.is_negative() != constant.is_negative()) else {
                continue;
            };
            if let Node::Apply(function, arguments) = self.node(term)
                && let (function, x) = (*function, arguments[0])
                && let Some(replacement) = self.joined(function, x, one, true)
            {
                sharing.push((i, replacement, coefficient));
                left = left.and_then(|left| left.add(coefficient));
            }
        }
        if sharing.is_empty() || !left.is_some_and(Rational::is_zero) {
            return Vec::new();
        }
        for &(i, ..) in &sharing {
            pool[i].1 = None;
        }
        pool.iter_mut().filter(|(term, _)| *term == one).for_each(|(_, coefficient)| *coefficient = None);
        sharing.into_iter().map(|(_, replacement, coefficient)| (replacement, coefficient)).collect()
    }

    /// `rest · (f(x) - 1)` if `opposite`, else `rest · (f(x) + 1)`, where there is a better form.
    fn joined(&mut self, function: Function, x: Expr, rest: Expr, opposite: bool) -> Option<Expr> {
        let half = self.scale(x, Rational::HALF);
        let two = Rational::integer(2);
        let (inner, factor) = match (function, opposite) {
            (Function::Cos, true) => (self.apply(Function::Sin, &[half]), two.negate()),
            (Function::Cos, false) => (self.apply(Function::Cos, &[half]), two),
            (Function::Cosh, true) => (self.apply(Function::Sinh, &[half]), two),
            (Function::Exp, true) => {
                let value = self.apply(Function::ExpM1, &[x]);
                return Some(self.multiply(rest, value));
            }
            _ => return None,
        };
        let square = self.power(inner, two);
        let product = self.multiply(rest, square);
        Some(self.scale(product, factor))
    }

    /// Pairs of roots whose radicands cancel; more than a few roots in one sum are left alone.
    fn pair_roots(&mut self, pool: &mut Terms) -> Vec<(Expr, Rational)> {
        let roots: Vec<usize> = (0..pool.len()).filter(|&i| self.radicand(pool[i].0).is_some()).collect();
        let mut replacements = Vec::new();
        if roots.len() > MOST_ROOTS {
            return replacements;
        }
        for (k, &i) in roots.iter().enumerate() {
            for &j in &roots[k + 1..] {
                let (Some(coefficient), Some(partner)) = (pool[i].1, pool[j].1) else { continue };
                if coefficient == partner.negate()
                    && let Some(replacement) = self.difference_of_roots(pool[i].0, pool[j].0)
                {
                    replacements.push((replacement, coefficient));
                    (pool[i].1, pool[j].1) = (None, None);
                }
            }
        }
        replacements
    }

    /// The factors `f(x)` of `term` with exponent one, each with its argument and the other factors.
    fn functions_in(&mut self, term: Expr) -> Vec<(Function, Expr, Expr)> {
        let factors: Vec<(Expr, Rational)> = match self.node(term) {
            Node::Product(factors) => factors.to_vec(),
            _ => vec![(term, Rational::ONE)],
        };
        let mut found = Vec::new();
        for (i, &(base, exponent)) in factors.iter().enumerate() {
            let Node::Apply(function, arguments) = self.node(base) else { continue };
            let (function, x) = (*function, arguments[0]);
            if exponent.is_one() {
                let rest: Vec<Expr> = factors
                    .iter()
                    .enumerate()
                    .filter(|&(k, _)| k != i)
                    .map(|(_, &(other, power))| (other, power))
                    .collect::<Vec<_>>()
                    .into_iter()
                    .map(|(other, power)| self.power(other, power))
                    .collect();
                found.push((function, x, self.product(&rest)));
            }
        }
        found
    }

    /// `√s - √t` as `(s - t) / (√s + √t)`, if `s - t` is shorter than both together: something cancelled.
    fn difference_of_roots(&mut self, first: Expr, second: Expr) -> Option<Expr> {
        let s = self.radicand(first)?;
        let t = self.radicand(second)?;
        let difference = self.subtract(s, t);
        if self.length(difference) + 1 >= self.length(s) + self.length(t) {
            return None;
        }
        let sum = self.add(first, second);
        let quotient = self.divide(difference, sum);
        if self.sign(first) == Sign::Positive || self.sign(second) == Sign::Positive {
            return Some(quotient);
        }
        // Both roots may be zero: so is their difference, but not the quotient.
        let zero = self.integer(0);
        let both_vanish = self.compare(Relation::Equal, sum, zero);
        Some(self.select(both_vanish, zero, quotient))
    }

    /// `s` with `expr = √s`: a square root, or the number one.
    fn radicand(&self, expr: Expr) -> Option<Expr> {
        match self.node(expr) {
            Node::Number(Rational::ONE) => Some(expr),
            Node::Apply(Function::Sqrt, arguments) => Some(arguments[0]),
            Node::Product(factors) => match factors.as_ref() {
                &[(base, Rational::HALF)] => Some(base),
                _ => None,
            },
            _ => None,
        }
    }

    fn length(&self, expr: Expr) -> usize {
        match self.node(expr) {
            Node::Sum { terms, constant } => terms.len() + usize::from(!constant.is_zero()),
            Node::Number(value) if value.is_zero() => 0,
            _ => 1,
        }
    }

    /// `x² - y²` as `(x - y) (x + y)`.
    fn difference_of_squares(&mut self, first: Expr, second: Expr) -> Option<Expr> {
        let (x, y) = (self.square_root(first)?, self.square_root(second)?);
        let (difference, sum) = (self.subtract(x, y), self.add(x, y));
        Some(self.multiply(difference, sum))
    }

    /// `x` with `expr = x²`: a product of even powers, or the number one.
    fn square_root(&mut self, expr: Expr) -> Option<Expr> {
        match self.node(expr).clone() {
            Node::Number(Rational::ONE) => Some(expr),
            Node::Product(factors) => {
                let halved: Option<Vec<(Expr, Rational)>> = factors
                    .iter()
                    .map(|&(base, exponent)| {
                        let half = exponent.multiply(Rational::HALF).filter(|half| half.is_integer())?;
                        Some((base, half))
                    })
                    .collect();
                let powers: Vec<Expr> =
                    halved?.into_iter().map(|(base, half)| self.power(base, half)).collect();
                Some(self.product(&powers))
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::symbolic::Symbol;

    fn value(graph: &Graph, expr: Expr, x: Symbol, at: f64) -> f64 {
        graph.evaluate(&[expr], &|symbol| if symbol == x { at } else { 2.0 })[0]
    }

    /// The stable form of `build(x)` has the value `exact` at `at`, to three roundings.
    fn keeps_digits(build: impl Fn(&mut Graph, Expr) -> Expr, at: f64, exact: f64) {
        let mut graph = Graph::new();
        let symbol = graph.new_symbol("x");
        let x = graph.symbol(symbol);
        let written = build(&mut graph, x);
        let stable = graph.stabilise(&[written])[0];
        let got = value(&graph, stable, symbol, at);
        let error = (got - exact).abs() / exact.abs();
        assert!(error <= 3.0 * f64::EPSILON, "{}: {got} instead of {exact}", graph.display(stable));
        let naive = value(&graph, written, symbol, at);
        assert!(
            (naive - exact).abs() > 100.0 * f64::EPSILON * exact.abs(),
            "{} is no test",
            graph.display(written)
        );
    }

    #[test]
    fn small_differences_keep_their_digits() {
        let one = |graph: &mut Graph| graph.integer(1);
        // Taylor series: the next term is below rounding at these points.
        let x = 1e-5_f64;
        keeps_digits(
            |graph, x| {
                let (one, cosine) = (one(graph), graph.apply(Function::Cos, &[x]));
                graph.subtract(one, cosine)
            },
            x,
            x * x / 2.0 * (1.0 - x * x / 12.0),
        );
        keeps_digits(
            |graph, x| {
                let (one, cosine) = (one(graph), graph.apply(Function::Cosh, &[x]));
                graph.subtract(cosine, one)
            },
            x,
            x * x / 2.0 * (1.0 + x * x / 12.0),
        );
        keeps_digits(
            |graph, x| {
                let (one, exponential) = (one(graph), graph.apply(Function::Exp, &[x]));
                graph.subtract(exponential, one)
            },
            x,
            x + x * x / 2.0 + x * x * x / 6.0 + x * x * x * x / 24.0,
        );
        keeps_digits(
            |graph, x| {
                let one = one(graph);
                let sum = graph.add(one, x);
                graph.apply(Function::Ln, &[sum])
            },
            x,
            x - x * x / 2.0 + x * x * x / 3.0 - x * x * x * x / 4.0,
        );
        keeps_digits(
            |graph, x| {
                let one = one(graph);
                let sum = graph.add(one, x);
                let root = graph.apply(Function::Sqrt, &[sum]);
                graph.subtract(root, one)
            },
            x,
            x / 2.0 - x * x / 8.0 + x * x * x / 16.0 - 5.0 / 128.0 * x * x * x * x,
        );
        keeps_digits(
            |graph, x| {
                let (one, square) = (one(graph), graph.power(x, Rational::integer(2)));
                graph.subtract(square, one)
            },
            1.0 + 2.0_f64.powi(-30),
            2.0_f64.powi(-29) + 2.0_f64.powi(-60),
        );
    }

    #[test]
    fn a_common_factor_and_a_shared_constant_are_seen_through() {
        let mut graph = Graph::new();
        let [a, x, y] = ["a", "x", "y"].map(|name| {
            let symbol = graph.new_symbol(name);
            graph.symbol(symbol)
        });
        let [cos_x, cos_y] = [x, y].map(|angle| graph.apply(Function::Cos, &[angle]));
        let product = graph.multiply(a, cos_x);
        let difference = graph.subtract(a, product);
        let stable = graph.stabilise(&[difference])[0];
        assert_eq!(graph.display(stable), "2 a sin(x/2)²");
        let two = graph.integer(2);
        let minus = Rational::MINUS_ONE;
        let both = graph.linear_combination(&[(two, Rational::ONE), (cos_x, minus), (cos_y, minus)]);
        let stable = graph.stabilise(&[both])[0];
        assert_eq!(graph.display(stable), "2 sin(x/2)² + 2 sin(y/2)²");
    }

    #[test]
    fn roots_that_may_both_vanish_do_not_become_zero_over_zero() {
        let mut graph = Graph::new();
        let symbols = ["x", "y"].map(|name| graph.new_symbol(name));
        let [x, y] = symbols.map(|symbol| graph.symbol(symbol));
        let sum = graph.add(x, y);
        let [first, second] = [sum, x].map(|radicand| graph.apply(Function::Sqrt, &[radicand]));
        let difference = graph.subtract(first, second);
        let stable = graph.stabilise(&[difference])[0];
        assert_ne!(stable, difference);
        assert_eq!(graph.evaluate(&[stable], &|_| 0.0), [0.0]);
        let at = |symbol| if symbol == symbols[0] { 1e16 } else { 1.0 };
        assert_eq!(graph.evaluate(&[stable], &at), [1.0 / (1e8 + 1e8)]);
    }
}
