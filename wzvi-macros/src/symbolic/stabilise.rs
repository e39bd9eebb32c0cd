//! Rewrites forms that lose digits by cancellation.
//!
//! | written | computed | loses digits near |
//! |---|---|---|
//! | `a - a cos x` | `2 a sin²(x/2)` | `x = 0` |
//! | `a + a cos x` | `2 a cos²(x/2)` | `x = π` |
//! | `a cosh x - a` | `2 a sinh²(x/2)` | `x = 0` |
//! | `a exp x - a` | `a expm1 x` | `x = 0` |
//! | `a exp x - a exp(-x)` | `2 a sinh x` | `x = 0` |
//! | `a exp x + a exp(-x) - 2 a` | `4 a sinh²(x/2)` | `x = 0` |
//! | `a exp(m x) - a exp(n x)`, `n/m > 1` | `-a exp(m x) expm1((n - m) x)` | `x = 0` |
//! | `ln(1 + x)` | `ln1p x` | `x = 0` |
//! | `a √s - a y`, with `y > 0` | `a (s - y²) / (√s + y)`, where `s - y²` cancels symbolically | `s = y²` |
//! | `a x² - a y²` | `a (x - y) (x + y)` | `x = ±y` |
//! | `a - a f²`, `f = cos x` or `sin x` | `a sin²x`, `a cos²x` | `f = ±1` |
//! | `a - a f²`, `f = cosh x` or `tanh x` | `-a sinh²x`, `a / cosh²x` | `f = ±1` |
//!
//! Each replaces terms by one whose size is at most their sum, so that the error bound of no expression
//! grows, and no intermediate value overflows where the terms do not. Other forms remain, because rewriting
//! would increase the bound: `cos x - cos y` as a product of sines halves `x + y`, whose rounding is
//! absolute; `exp x - exp y` as a product multiplies 0 by infinity where one of them underflows; squares of
//! sums with more than two terms in total would be added in another order.
//!
//! One limit: a product merges with the product around it, so that powers of one factor are combined. Above
//! 1e100 such a power may overflow although the difference does not.
//!
//! This runs after differentiation, on emitted expressions: derivatives are taken of the forms that the user
//! wrote.
//!
//! Tests: `symbolic/stabilise/tests.rs`, `symbolic/tests/accuracy.rs`.

use std::collections::HashMap;

use super::{Expr, Function, Graph, Node, Rational, Relation};

mod pairs;
#[cfg(test)]
mod tests;

/// `Σ coefficient · term` during rewriting; the constant is a term of the number one, and replaced terms have
/// no coefficient.
type PendingTerms = Vec<(Expr, Option<Rational>)>;

impl Graph {
    /// The values of `roots` in stable forms.
    pub(crate) fn stabilise(&mut self, roots: &[Expr]) -> Vec<Expr> {
        let mut images: HashMap<Expr, Expr> = HashMap::new();
        for expr in self.reachable(roots) {
            let node = self.node(expr).clone();
            let rebuilt = if node.operands().iter().all(|operand| images[operand] == *operand) {
                expr
            } else {
                self.rebuild(&node, &|operand| images[&operand])
            };
            let image = match node {
                Node::Apply(Function::Ln, arguments) => {
                    self.logarithm_of_one_plus(arguments[0], images[&arguments[0]]).unwrap_or(rebuilt)
                }
                _ => self.stable_form(rebuilt),
            };
            images.insert(expr, image);
        }
        roots.iter().map(|root| images[root]).collect()
    }

    fn stable_form(&mut self, expr: Expr) -> Expr {
        match self.node(expr).clone() {
            Node::Sum { terms, constant } => self.stable_sum(expr, &terms, constant),
            _ => expr,
        }
    }

    /// `ln(1 + x)` as `ln1p x`; if `1 + x` has a stable form, that is used near its zero.
    fn logarithm_of_one_plus(&mut self, written: Expr, stable: Expr) -> Option<Expr> {
        let is_one_plus = |node: &Node| matches!(node, Node::Sum { constant: Rational::ONE, .. });
        let one = self.integer(1);
        if is_one_plus(self.node(stable)) {
            let rest = self.subtract(stable, one);
            return Some(self.apply(Function::Ln1p, &[rest]));
        }
        if !is_one_plus(self.node(written)) {
            return None;
        }
        let rest = self.subtract(written, one);
        let rest = self.stabilise(&[rest])[0];
        let (near_one, near_zero) =
            (self.apply(Function::Ln1p, &[rest]), self.apply(Function::Ln, &[stable]));
        let half = self.number(Rational::HALF);
        let is_small = self.compare(Relation::Less, stable, half);
        Some(self.select(is_small, near_zero, near_one))
    }

    fn stable_sum(&mut self, expr: Expr, terms: &[(Expr, Rational)], constant: Rational) -> Expr {
        let one = self.integer(1);
        let mut pool: PendingTerms = terms.iter().map(|&(term, c)| (term, Some(c))).collect();
        if !constant.is_zero() {
            pool.push((one, Some(constant)));
        }
        let mut replacements = self.pair_functions(&mut pool);
        replacements.extend(self.share_constant(&mut pool, one));
        replacements.extend(self.pair_terms(&mut pool));
        if replacements.is_empty()
            && let Some(product) = self.difference_of_squares(&pool)
        {
            return product;
        }
        if replacements.is_empty() {
            return expr;
        }
        replacements.extend(pool.iter().filter_map(|&(term, c)| Some((term, c?))));
        self.linear_combination(&replacements)
    }

    /// `a f(x)` with `±a`, and `a exp x + a exp(-x)` with `-2 a`, for every such group in the sum.
    fn pair_functions(&mut self, pool: &mut PendingTerms) -> Vec<(Expr, Rational)> {
        let places: HashMap<Expr, usize> = pool.iter().enumerate().map(|(i, &(term, _))| (term, i)).collect();
        let mut replacements = Vec::new();
        for i in 0..pool.len() {
            for (function, x, rest) in self.functions_in(pool[i].0) {
                let Some(&j) = places.get(&rest) else { continue };
                let (Some(coefficient), Some(partner)) = (pool[i].1, pool[j].1) else { continue };
                let opposite = coefficient == partner.negate();
                if function == Function::Exp && coefficient.multiply(Rational::integer(-2)) == Some(partner) {
                    let mirrored = self.negate(x);
                    let mirrored = self.apply(Function::Exp, &[mirrored]);
                    let mirrored = self.multiply(mirrored, rest);
                    if let Some(&k) = places.get(&mirrored)
                        && pool[k].1 == Some(coefficient)
                        && let Some(replacement) = self.joined(Function::Cosh, x, rest, true)
                    {
                        replacements.extend([(replacement, coefficient), (replacement, coefficient)]);
                        (pool[i].1, pool[j].1, pool[k].1) = (None, None, None);
                    }
                } else if (opposite || coefficient == partner)
                    && let Some(replacement) = self.joined(function, x, rest, opposite)
                {
                    replacements.push((replacement, coefficient));
                    (pool[i].1, pool[j].1) = (None, None);
                }
            }
        }
        replacements
    }

    /// `n - cos x_1 - ... - cos x_n`: the constants of a sum of many `1 - cos x` have been added.
    fn share_constant(&mut self, pool: &mut PendingTerms, one: Expr) -> Vec<(Expr, Rational)> {
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

    /// `rest · (f(x) - 1)` if `opposite`, else `rest · (f(x) + 1)`, if there is a better form.
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

    /// Every `f(x)` that `term` has as a factor, with its argument and the other factors.
    fn functions_in(&mut self, term: Expr) -> Vec<(Function, Expr, Expr)> {
        let factors = self.factors_of(term);
        let mut found = Vec::new();
        for (i, &(base, exponent)) in factors.iter().enumerate() {
            let Node::Apply(function, arguments) = self.node(base) else { continue };
            let (function, x) = (*function, arguments[0]);
            if exponent.is_integer()
                && !exponent.is_negative()
                && let Some(lower) = exponent.add(Rational::MINUS_ONE)
            {
                let mut rest = factors.clone();
                rest[i].1 = lower;
                found.push((function, x, self.product_of_powers(&rest)));
            }
        }
        found
    }

    /// `term` as a product of powers; the number one has none.
    fn factors_of(&self, term: Expr) -> Vec<(Expr, Rational)> {
        match self.node(term) {
            Node::Product(factors) => factors.to_vec(),
            Node::Number(Rational::ONE) => Vec::new(),
            _ => vec![(term, Rational::ONE)],
        }
    }
}
