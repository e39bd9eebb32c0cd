//! Differences of two terms: common factors are extracted, and the remaining difference may have a better
//! form. Tests: `symbolic/stabilise/tests.rs`, `symbolic/tests/accuracy.rs`.

use super::PendingTerms;
use crate::symbolic::sign::Sign;
use crate::symbolic::{Expr, Function, Graph, Node, Rational, Relation};

/// Sums with more terms than this are not searched for pairs.
const MOST_TERMS: usize = 32;
/// Sums in which more terms than this have a root or an exponential are not searched either.
const MOST_CANDIDATES: usize = 8;

/// `coefficient · common · (first - second)`.
struct Difference {
    coefficient: Rational,
    common: Expr,
    first: Expr,
    second: Expr,
}

impl Graph {
    /// Rewrites pairs with opposite coefficients that are roots or exponentials up to common factors.
    pub(super) fn pair_terms(&mut self, pool: &mut PendingTerms) -> Vec<(Expr, Rational)> {
        let mut replacements = Vec::new();
        if pool.len() > MOST_TERMS {
            return replacements;
        }
        let candidates: Vec<usize> =
            (0..pool.len()).filter(|&i| self.has_root_or_exponential(pool[i].0)).collect();
        if candidates.len() > MOST_CANDIDATES {
            return replacements;
        }
        for &i in &candidates {
            for j in (0..pool.len()).filter(|&j| j != i) {
                let (Some(coefficient), Some(partner)) = (pool[i].1, pool[j].1) else { continue };
                if let Some(difference) = self.split(pool[i].0, coefficient, pool[j].0, partner)
                    && let Some(better) = self.better_difference(&difference)
                {
                    replacements.push((self.multiply(difference.common, better), difference.coefficient));
                    (pool[i].1, pool[j].1) = (None, None);
                }
            }
        }
        replacements
    }

    fn has_root_or_exponential(&self, term: Expr) -> bool {
        self.factors_of(term).into_iter().any(|(base, exponent)| {
            exponent == Rational::HALF
                || matches!(self.node(base), Node::Apply(Function::Sqrt | Function::Exp, _))
        })
    }

    /// `c t + d u` as a difference with a factor, if `d = -c`, or if one of the two is a number up to common
    /// factors.
    fn split(&mut self, t: Expr, c: Rational, u: Expr, d: Rational) -> Option<Difference> {
        let (mut left, mut right) = (self.factors_of(t), self.factors_of(u));
        let has_twice = |factors: &[(Expr, Rational)]| factors.windows(2).any(|pair| pair[0].0 == pair[1].0);
        if has_twice(&left) || has_twice(&right) {
            return None;
        }
        let mut common = Vec::new();
        for (base, exponent) in &mut left {
            let Some((_, other)) = right.iter_mut().find(|(factor, _)| factor == base) else { continue };
            let is_count = |e: Rational| e.is_integer() && !e.is_negative();
            let shared = match *exponent == *other {
                true => *exponent,
                false if is_count(*exponent) && is_count(*other) => (*exponent).min(*other),
                false => continue,
            };
            (*exponent, *other) = (exponent.add(shared.negate())?, other.add(shared.negate())?);
            common.push((*base, shared));
        }
        let common = self.product_of_powers(&common);
        let mut first = self.product_of_powers(&left);
        let mut second = self.product_of_powers(&right);
        let mut coefficient = c;
        if c != d.negate() {
            let is_one = |expr| self.as_number(expr) == Some(Rational::ONE);
            let (from, to, number) = match (is_one(first), is_one(second)) {
                (false, true) => (c, d.negate(), &mut second),
                (true, false) => (d.negate(), c, &mut first),
                _ => return None,
            };
            coefficient = from;
            let ratio = to.multiply(from.recip()?)?;
            if ratio.is_negative() {
                return None;
            }
            *number = self.number(ratio);
        }
        Some(Difference { coefficient, common, first, second })
    }

    fn better_difference(&mut self, difference: &Difference) -> Option<Expr> {
        let &Difference { first, second, .. } = difference;
        if let (&Node::Apply(Function::Exp, ref u), &Node::Apply(Function::Exp, ref v)) =
            (self.node(first), self.node(second))
        {
            let (u, v) = (u[0], v[0]);
            return self.difference_of_exponentials(u, v);
        }
        self.difference_of_roots(first, second)
    }

    /// `exp u - exp v` where one argument is a multiple of the other.
    fn difference_of_exponentials(&mut self, u: Expr, v: Expr) -> Option<Expr> {
        if self.negate(u) == v {
            let sine = self.apply(Function::Sinh, &[u]);
            return Some(self.scale(sine, Rational::integer(2)));
        }
        let ((m, x), (n, y)) = (self.as_multiple(u), self.as_multiple(v));
        if x != y || m.is_negative() != n.is_negative() {
            return None;
        }
        // The exponential of the smaller argument is the outer factor: it and the other factor are at most
        // their difference, or one.
        let is_first_smaller = if m.is_negative() { n < m } else { m < n };
        let (smaller, larger) = if is_first_smaller { (u, v) } else { (v, u) };
        let outside = self.apply(Function::Exp, &[smaller]);
        let gap = self.subtract(larger, smaller);
        let inside = self.apply(Function::ExpM1, &[gap]);
        let product = self.multiply(outside, inside);
        Some(if is_first_smaller { self.negate(product) } else { product })
    }

    /// `√s - y` as `(s - y²) / (√s + y)`, if `s - y²` is shorter than both together: something cancelled.
    fn difference_of_roots(&mut self, root: Expr, y: Expr) -> Option<Expr> {
        let s = self.radicand(root)?;
        let square = match self.radicand(y) {
            Some(radicand) => radicand,
            None => self.power(y, Rational::integer(2)),
        };
        let numerator = self.subtract(s, square);
        if self.length(numerator) + 1 >= self.length(s) + self.length(square) {
            return None;
        }
        let numerator = self.stable_form(numerator);
        let sum = self.add(root, y);
        let quotient = self.divide(numerator, sum);
        let zero = self.integer(0);
        match (self.sign(root).max(self.sign(y)), self.sign(y)) {
            (_, Sign::Unknown) => {
                // For negative `y` the difference does not cancel, but `√s + y` would.
                let difference = self.subtract(root, y);
                let is_positive = self.compare(Relation::Less, zero, y);
                Some(self.select(is_positive, quotient, difference))
            }
            (Sign::Positive, _) => Some(quotient),
            _ => {
                // If both are zero, so is their difference, but the quotient is undefined.
                let both_vanish = self.compare(Relation::Equal, sum, zero);
                Some(self.select(both_vanish, zero, quotient))
            }
        }
    }

    /// `s` with `expr = √s`.
    fn radicand(&self, expr: Expr) -> Option<Expr> {
        match self.node(expr) {
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

    /// The whole sum `c (a x² - a y²)` as `c a (x - y) (x + y)`, or as one square if `y` is a function and
    /// `x` is one.
    pub(super) fn difference_of_squares(&mut self, pool: &PendingTerms) -> Option<Expr> {
        let &[(first, Some(c)), (second, Some(d))] = pool.as_slice() else { return None };
        let difference = self.split(first, c, second, d)?;
        let (x, y) = (self.square_root(difference.first)?, self.square_root(difference.second)?);
        let inner = match self.one_minus_square(y, x).or_else(|| {
            let opposite = self.one_minus_square(x, y)?;
            Some(self.negate(opposite))
        }) {
            Some(square) => square,
            None => {
                let (less, more) = (self.subtract(x, y), self.add(x, y));
                // With more terms the order of addition differs from that in `x` and `y`, and the rounding
                // may be larger.
                if self.length(less) > 2 || self.length(more) > 2 {
                    return None;
                }
                let (less, more) = (self.stable_form(less), self.stable_form(more));
                self.multiply(less, more)
            }
        };
        let product = self.multiply(difference.common, inner);
        Some(self.scale(product, difference.coefficient))
    }

    /// `1 - f(x)²` as a square; `one` must be the number one.
    fn one_minus_square(&mut self, f: Expr, one: Expr) -> Option<Expr> {
        let &Node::Apply(function, ref arguments) = self.node(f) else { return None };
        let x = arguments[0];
        if self.as_number(one) != Some(Rational::ONE) {
            return None;
        }
        let (partner, exponent, factor) = match function {
            Function::Cos => (Function::Sin, 2, Rational::ONE),
            Function::Sin => (Function::Cos, 2, Rational::ONE),
            Function::Tanh => (Function::Cosh, -2, Rational::ONE),
            Function::Cosh => (Function::Sinh, 2, Rational::MINUS_ONE),
            _ => return None,
        };
        let partner = self.apply(partner, &[x]);
        let square = self.power(partner, Rational::integer(exponent));
        Some(self.scale(square, factor))
    }

    /// `x` with `expr = x²`: a product of even powers, or the square of a number.
    fn square_root(&mut self, expr: Expr) -> Option<Expr> {
        match self.node(expr).clone() {
            Node::Number(_) => {
                let root = self.power(expr, Rational::HALF);
                self.as_number(root).map(|_| root)
            }
            Node::Product(factors) => {
                let halved = factors.iter().map(|&(base, exponent)| {
                    let half = exponent.multiply(Rational::HALF).filter(|half| half.is_integer())?;
                    Some((base, half))
                });
                let halved: Option<Vec<(Expr, Rational)>> = halved.collect();
                let powers: Vec<Expr> =
                    halved?.into_iter().map(|(base, half)| self.power(base, half)).collect();
                Some(self.product(&powers))
            }
            _ => None,
        }
    }
}
