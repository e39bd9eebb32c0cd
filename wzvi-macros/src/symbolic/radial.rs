//! Slopes of functions of a distance at distance zero.
//!
//! With `r² = x² + y² + …` the slope of `f(r)` is `f'(r) r⁻¹ (x x' + …)`: 0 times infinity times 0 at the
//! origin, even where `f` is smooth there, which is where `f'(0) = 0`. Then `f'(r) / r` has the limit
//! `f''(0)`.
//!
//! Tests: `tests/steps/limits.rs`.

use super::residue::SplitMix;
use super::{Expr, Function, Graph, Node, Rational, Relation, Symbol, SymbolKind};

/// Points at which `f'(0)` must be zero.
const TRIALS: u64 = 3;

/// Terms `φ(r) r⁻¹ rest` of one distance and one rest.
struct Radial {
    distance: Distance,
    rest: Expr,
    /// `Σ φ`
    slope: Vec<(Expr, Rational)>,
}

/// `hypot(x, y)`, or `S^(1/2)` of a sum of squares.
#[derive(Clone, Copy, PartialEq)]
struct Distance {
    r: Expr,
    /// `r`, or `S`: zero where `r` is.
    base: Expr,
}

impl Graph {
    /// A first derivative with the limits of its terms at the origin.
    pub(super) fn radial_limits(&mut self, slope: Expr) -> Expr {
        let terms = match self.node(slope) {
            Node::Sum { terms, .. } => terms.to_vec(),
            Node::Product(_) => vec![(slope, Rational::ONE)],
            _ => return slope,
        };
        let mut groups: Vec<Radial> = Vec::new();
        for &(term, coefficient) in &terms {
            let Some((distance, rest, of_distance)) = self.radial(term) else { continue };
            let found = groups.iter_mut().find(|known| known.distance == distance && known.rest == rest);
            match found {
                Some(known) => known.slope.push((of_distance, coefficient)),
                None => groups.push(Radial { distance, rest, slope: vec![(of_distance, coefficient)] }),
            }
        }
        // `x/r` alone has no limit.
        let one = self.integer(1);
        groups.retain(|group| group.slope.iter().any(|&(of_distance, _)| of_distance != one));
        if groups.is_empty() {
            return slope;
        }
        let mut changed = vec![(slope, Rational::ONE)];
        for Radial { distance, rest, slope } in groups {
            let total = self.linear_combination(&slope);
            let Some(limit) = self.limit_of_quotient(distance, total) else { continue };
            let inverse = self.power(distance.r, Rational::MINUS_ONE);
            for &(part, coefficient) in &slope {
                let written = self.product(&[part, inverse, rest]);
                changed.push((written, coefficient.negate()));
            }
            let (quotient, zero) = (self.multiply(total, inverse), self.integer(0));
            let is_origin = self.compare(Relation::Equal, distance.base, zero);
            let quotient = self.select(is_origin, limit, quotient);
            changed.push((self.multiply(quotient, rest), Rational::ONE));
        }
        self.linear_combination(&changed)
    }

    /// A term as `φ r⁻¹ rest`, where `φ` reads the distance or is 1.
    fn radial(&mut self, term: Expr) -> Option<(Distance, Expr, Expr)> {
        let Node::Product(factors) = self.node(term).clone() else { return None };
        let minus_half = Rational::HALF.negate();
        let at = factors.iter().position(|&(base, exponent)| match self.node(base) {
            Node::Apply(Function::Hypot, _) => exponent == Rational::MINUS_ONE,
            _ => exponent == minus_half && self.is_sum_of_squares(base),
        })?;
        let base = factors[at].0;
        let r = if factors[at].1 == minus_half { self.power(base, Rational::HALF) } else { base };
        let reads = |factor: Expr| self.reachable(&[factor]).contains(&base);
        let others = factors.iter().enumerate().filter(|(i, _)| *i != at).map(|(_, &factor)| factor);
        let (of_distance, rest): (Vec<_>, Vec<_>) = others.partition(|&(factor, _)| reads(factor));
        let (of_distance, rest) = (self.product_of_powers(&of_distance), self.product_of_powers(&rest));
        Some((Distance { r, base }, rest, of_distance))
    }

    /// The limit of `φ(r) / r` at `r = 0`, if `φ(0) = 0`: `φ'(0)`, or 0 where there is none.
    fn limit_of_quotient(&mut self, Distance { r, base }: Distance, slope: Expr) -> Option<Expr> {
        let symbol = self.new_symbol(SymbolKind::Auxiliary, "r");
        let distance = self.symbol(symbol);
        let square = self.power(distance, Rational::integer(2));
        let parts = self.reachable(&[slope]);
        let image = |_: &Self, part: Expr| match part {
            part if part == r => Some(distance),
            part if part == base => Some(square),
            _ => None,
        };
        let slope = self.rewritten(&[slope], parts, image)[0];
        if self.at_origin(slope, symbol).iter().any(|&value| value != 0.0) {
            return None;
        }
        let steepness = self.derivative(slope, symbol);
        let zero = self.integer(0);
        if !self.at_origin(steepness, symbol).iter().all(|value| value.is_finite()) {
            return Some(zero);
        }
        let by = std::collections::HashMap::from([(symbol, zero)]);
        self.substitute(&[steepness], &by).first().copied()
    }

    /// Values where `distance` is zero and the other symbols are anything.
    fn at_origin(&self, expr: Expr, distance: Symbol) -> Vec<f64> {
        let value = |trial: u64, symbol: Symbol| match symbol == distance {
            true => 0.0,
            false => 0.3 + SplitMix::new(trial << 32 | symbol.index() as u64).unit(),
        };
        (0..TRIALS)
            .map(|trial| self.evaluate_bounded(&[expr], &|symbol| value(trial, symbol))[0].value)
            .collect()
    }

    /// Whether `expr` vanishes only where even powers do.
    pub(super) fn is_sum_of_squares(&self, expr: Expr) -> bool {
        let Node::Sum { terms, constant } = self.node(expr) else { return false };
        constant.is_zero() && terms.iter().all(|&(term, c)| !c.is_negative() && self.is_square(term))
    }

    /// Whether it is a product of even powers and of what is positive.
    pub(super) fn is_square(&self, expr: Expr) -> bool {
        let is_even = |&(base, exponent): &(Expr, Rational)| {
            exponent.is_integer() && exponent.numerator() % 2 == 0 && !exponent.is_negative()
                || self.sign(base) == super::sign::Sign::Positive
        };
        matches!(self.node(expr), Node::Product(factors) if factors.iter().all(is_even))
    }
}
