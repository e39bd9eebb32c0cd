//! Constructors. Each returns the canonical form, so that equal handles mean equal expressions.
//!
//! Sums and products are n-ary and sorted, like terms are collected with exact rational coefficients, and nothing is
//! expanded. Rewrites change a value by no more than rounding and keep the domain: `x / x` stays, because it is
//! undefined at 0; `x - x` is 0 wherever `x` is defined.

use super::sign::Sign;
use super::{Expr, Function, Graph, Node, Rational, Relation, Symbol};

impl Graph {
    pub(crate) fn number(&mut self, value: Rational) -> Expr {
        self.intern(Node::Number(value))
    }

    pub(crate) fn integer(&mut self, value: i32) -> Expr {
        self.number(Rational::integer(value))
    }

    /// A binary64 constant: exact as a rational where that is small, else opaque.
    pub(crate) fn float(&mut self, value: f64) -> Expr {
        match Rational::from_f64(value) {
            Some(rational) => self.number(rational),
            None => self.intern(Node::Float(value.to_bits())),
        }
    }

    pub(crate) fn symbol(&mut self, symbol: Symbol) -> Expr {
        self.intern(Node::Symbol(symbol))
    }

    /// `Σ operand`
    pub(crate) fn sum(&mut self, operands: &[Expr]) -> Expr {
        let weighted: Vec<_> = operands.iter().map(|&operand| (operand, Rational::ONE)).collect();
        self.linear_combination(&weighted)
    }

    pub(crate) fn add(&mut self, a: Expr, b: Expr) -> Expr {
        self.sum(&[a, b])
    }

    pub(crate) fn subtract(&mut self, a: Expr, b: Expr) -> Expr {
        self.linear_combination(&[(a, Rational::ONE), (b, Rational::MINUS_ONE)])
    }

    pub(crate) fn negate(&mut self, a: Expr) -> Expr {
        self.scale(a, Rational::MINUS_ONE)
    }

    pub(crate) fn scale(&mut self, a: Expr, factor: Rational) -> Expr {
        self.linear_combination(&[(a, factor)])
    }

    /// `Σ coefficient · operand`
    pub(crate) fn linear_combination(&mut self, operands: &[(Expr, Rational)]) -> Expr {
        let mut collected = Collected::default();
        for &(operand, coefficient) in operands {
            self.collect(&mut collected, operand, coefficient);
        }
        let Collected { mut terms, constant, inexact } = collected;
        for (operand, coefficient) in inexact {
            let factor = self.intern(Node::Float(coefficient.to_f64().to_bits()));
            let term = self.multiply(factor, operand);
            terms.push((term, Rational::ONE));
        }
        terms.sort_unstable();
        let mut merged: Vec<(Expr, Rational)> = Vec::with_capacity(terms.len());
        for (term, coefficient) in terms {
            match merged.last_mut() {
                Some((last, total)) if *last == term => match total.add(coefficient) {
                    Some(sum) => *total = sum,
                    None => merged.push((term, coefficient)),
                },
                _ => merged.push((term, coefficient)),
            }
        }
        merged.retain(|&(_, coefficient)| !coefficient.is_zero());
        match merged.as_slice() {
            [] => self.number(constant),
            &[(term, coefficient)] if coefficient.is_one() && constant.is_zero() => term,
            _ => self.intern(Node::Sum { terms: merged.into(), constant }),
        }
    }

    /// Adds `coefficient · operand` to `into`, opening sums where that costs no multiplication.
    fn collect(&self, into: &mut Collected, operand: Expr, coefficient: Rational) {
        let exact = match self.node(operand) {
            Node::Number(value) => coefficient
                .multiply(*value)
                .and_then(|product| into.constant.add(product))
                .map(|sum| into.constant = sum),
            Node::Sum { terms, constant }
                if is_unit(coefficient) || (terms.len() == 1 && constant.is_zero()) =>
            {
                self.collect_sum(into, terms, *constant, coefficient)
            }
            _ => {
                into.terms.push((operand, coefficient));
                Some(())
            }
        };
        if exact.is_none() {
            into.inexact.push((operand, coefficient));
        }
    }

    fn collect_sum(
        &self,
        into: &mut Collected,
        terms: &[(Expr, Rational)],
        constant: Rational,
        coefficient: Rational,
    ) -> Option<()> {
        let scaled: Option<Vec<_>> =
            terms.iter().map(|&(term, inner)| Some((term, inner.multiply(coefficient)?))).collect();
        let total = into.constant.add(constant.multiply(coefficient)?)?;
        into.terms.extend(scaled?);
        into.constant = total;
        Some(())
    }

    pub(crate) fn multiply(&mut self, a: Expr, b: Expr) -> Expr {
        self.product(&[a, b])
    }

    pub(crate) fn divide(&mut self, a: Expr, b: Expr) -> Expr {
        let inverse = self.power(b, Rational::MINUS_ONE);
        self.multiply(a, inverse)
    }

    /// `Π operand`
    pub(crate) fn product(&mut self, operands: &[Expr]) -> Expr {
        let powers: Vec<_> = operands.iter().map(|&operand| (operand, Rational::ONE)).collect();
        self.product_of_powers(&powers)
    }

    /// `base^exponent` for an exact exponent.
    ///
    /// A fractional power of a base that is not proven nonnegative becomes `sqrt` or `powf`, which keep their domain.
    pub(crate) fn power(&mut self, base: Expr, exponent: Rational) -> Expr {
        if exponent.is_integer() || self.sign(base) >= Sign::Nonnegative {
            return self.product_of_powers(&[(base, exponent)]);
        }
        match exponent.multiply(Rational::integer(2)) {
            Some(twice) if twice.is_integer() => {
                let root = self.intern(Node::Apply(Function::Sqrt, Box::new([base])));
                self.power(root, twice)
            }
            _ => {
                let exponent = self.number(exponent);
                self.intern(Node::Apply(Function::Powf, Box::new([base, exponent])))
            }
        }
    }

    fn product_of_powers(&mut self, operands: &[(Expr, Rational)]) -> Expr {
        let mut coefficient = Rational::ONE;
        let mut factors = Vec::with_capacity(operands.len());
        for &(operand, exponent) in operands {
            self.collect_factor(&mut coefficient, &mut factors, operand, exponent);
        }
        if coefficient.is_zero() {
            return self.number(Rational::ZERO);
        }
        factors.sort_unstable();
        let mut merged: Vec<(Expr, Rational)> = Vec::with_capacity(factors.len());
        for (base, exponent) in factors {
            let total = merged.last().filter(|&&(last, _)| last == base).and_then(|&(_, total)| {
                let same_sign = total.is_negative() == exponent.is_negative();
                if same_sign || self.sign(base) == Sign::Positive { total.add(exponent) } else { None }
            });
            match (total, merged.last_mut()) {
                (Some(total), Some((_, last))) => *last = total,
                _ => merged.push((base, exponent)),
            }
        }
        merged.retain(|&(_, exponent)| !exponent.is_zero());
        let product = match merged.as_slice() {
            [] => return self.number(coefficient),
            &[(base, exponent)] if exponent.is_one() => base,
            _ => self.intern(Node::Product(merged.into())),
        };
        self.scale(product, coefficient)
    }

    /// Splits `operand^exponent` into a number and canonical factors.
    fn collect_factor(
        &mut self,
        coefficient: &mut Rational,
        factors: &mut Vec<(Expr, Rational)>,
        operand: Expr,
        exponent: Rational,
    ) {
        let scaled = match self.node(operand) {
            Node::Number(value) => Some((*value, None)),
            Node::Sum { terms, constant } if terms.len() == 1 && constant.is_zero() => {
                Some((terms[0].1, Some(terms[0].0)))
            }
            _ => None,
        };
        if let Some((number, rest)) = scaled
            && (exponent.is_integer() || rest.is_none() || !number.is_negative())
            && let Some(value) = exact_power(number, exponent)
            && let Some(total) = coefficient.multiply(value)
        {
            *coefficient = total;
            if let Some(rest) = rest {
                self.collect_factor(coefficient, factors, rest, exponent);
            }
            return;
        }
        if let Node::Product(inner) = self.node(operand)
            && exponent.is_integer()
            && (!exponent.is_negative() || inner.iter().all(|&(_, e)| !e.is_negative()))
        {
            let powers: Option<Vec<_>> =
                inner.iter().map(|&(base, e)| Some((base, e.multiply(exponent)?))).collect();
            if let Some(powers) = powers {
                factors.extend(powers);
                return;
            }
        }
        factors.push((operand, exponent));
    }

    /// `function(arguments)`, with exact values, parity and roots brought to their canonical form.
    pub(crate) fn apply(&mut self, function: Function, arguments: &[Expr]) -> Expr {
        let x = arguments[0];
        if let Some(value) = self.as_number(x).and_then(|x| exact_value(function, x)) {
            return self.number(value);
        }
        match function {
            Function::Sqrt => return self.power(x, Rational::HALF),
            Function::Abs if self.sign(x) >= Sign::Nonnegative => return x,
            Function::Powf => {
                if let Some(exponent) = self.as_number(arguments[1]) {
                    return self.power(x, exponent);
                }
            }
            Function::Min | Function::Max if x == arguments[1] => return x,
            _ => {}
        }
        match (parity(function), self.negated(x)) {
            (Some(Parity::Even), Some(positive)) => self.apply(function, &[positive]),
            (Some(Parity::Odd), Some(positive)) => {
                let value = self.apply(function, &[positive]);
                self.negate(value)
            }
            _ => self.intern(Node::Apply(function, arguments.into())),
        }
    }

    /// `-x` if `x` is a sum whose first coefficient (or, without terms, constant) is negative.
    fn negated(&mut self, x: Expr) -> Option<Expr> {
        match self.node(x) {
            Node::Sum { terms, .. } if terms[0].1.is_negative() => Some(self.negate(x)),
            Node::Number(value) if value.is_negative() => Some(self.negate(x)),
            _ => None,
        }
    }

    pub(crate) fn compare(&mut self, relation: Relation, a: Expr, b: Expr) -> Expr {
        self.intern(Node::Compare(relation, a, b))
    }

    pub(crate) fn not(&mut self, a: Expr) -> Expr {
        match *self.node(a) {
            Node::Not(inner) => inner,
            _ => self.intern(Node::Not(a)),
        }
    }

    pub(crate) fn and(&mut self, a: Expr, b: Expr) -> Expr {
        self.intern(Node::And(a, b))
    }

    pub(crate) fn or(&mut self, a: Expr, b: Expr) -> Expr {
        self.intern(Node::Or(a, b))
    }

    pub(crate) fn select(&mut self, condition: Expr, then: Expr, otherwise: Expr) -> Expr {
        if then == otherwise { then } else { self.intern(Node::Select { condition, then, otherwise }) }
    }
}

#[derive(Default)]
struct Collected {
    terms: Vec<(Expr, Rational)>,
    constant: Rational,
    /// Terms whose coefficient left the exact range: multiplied as binary64 instead.
    inexact: Vec<(Expr, Rational)>,
}

impl Default for Rational {
    fn default() -> Self {
        Self::ZERO
    }
}

enum Parity {
    Even,
    Odd,
}

fn parity(function: Function) -> Option<Parity> {
    match function {
        Function::Cos | Function::Cosh | Function::Abs => Some(Parity::Even),
        Function::Sin
        | Function::Tan
        | Function::Asin
        | Function::Atan
        | Function::Sinh
        | Function::Tanh
        | Function::Asinh
        | Function::Atanh
        | Function::Cbrt => Some(Parity::Odd),
        _ => None,
    }
}

fn is_unit(value: Rational) -> bool {
    value.is_one() || value == Rational::MINUS_ONE
}

/// `number^exponent` where it is rational; `None` keeps it symbolic (`2^(1/2)`, `0^-1`).
fn exact_power(number: Rational, exponent: Rational) -> Option<Rational> {
    if exponent.is_integer() {
        return number.power(exponent.numerator());
    }
    let root = |value: i64| {
        let root = (value as f64).sqrt() as i64;
        (root * root == value).then_some(i128::from(root))
    };
    let twice = exponent.multiply(Rational::integer(2)).filter(|twice| twice.is_integer())?;
    Rational::new(root(number.numerator())?, root(number.denominator())?)?.power(twice.numerator())
}

/// The values that are exact: nothing else is folded, so that rounding stays where the user put it.
fn exact_value(function: Function, x: Rational) -> Option<Rational> {
    match function {
        Function::Exp | Function::Exp2 | Function::Cos | Function::Cosh if x.is_zero() => Some(Rational::ONE),
        Function::ExpM1
        | Function::Ln1p
        | Function::Sin
        | Function::Tan
        | Function::Asin
        | Function::Atan
        | Function::Sinh
        | Function::Tanh
        | Function::Asinh
        | Function::Atanh
        | Function::Cbrt
            if x.is_zero() =>
        {
            Some(Rational::ZERO)
        }
        Function::Ln | Function::Log2 | Function::Log10 if x.is_one() => Some(Rational::ZERO),
        Function::Abs => Some(if x.is_negative() { x.negate() } else { x }),
        _ => None,
    }
}
