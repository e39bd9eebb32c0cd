//! Constructors. Each returns the canonical form, so that equal handles mean equal expressions.
//!
//! Sums and products are n-ary and sorted, like terms are collected with exact rational coefficients, and
//! nothing is expanded. Rewrites change a value by no more than rounding and keep the domain: `x / x` stays,
//! because it is undefined at 0, unless `x` is known not to be 0; `x - x` is 0 wherever `x` is defined.
//!
//! Tests: `symbolic/tests/random.rs`.

use super::function::Parity;
use super::sign::Sign;
use super::{Expr, Function, Graph, Node, Rational, Symbol};

/// Longer sums and products remain one operand of a new one: flattening them repeatedly would make a long
/// chain of additions quadratic.
pub(super) const OPEN_LIMIT: usize = 32;

/// Powers of a product are distributed over its factors up to this exponent, the largest of `powi`; beyond it
/// the product stays one operand, since after some squarings exponents would leave the range of exact
/// numbers, and equal factors could not be collected.
const LARGEST_OPEN_EXPONENT: i32 = i32::MAX;

/// A binary64 constant with a larger denominator (π) is not meant as a fraction, and stays one opaque number.
const SMALL_DENOMINATOR: i64 = 1 << 20;

impl Graph {
    pub(crate) fn number(&mut self, value: Rational) -> Expr {
        self.intern(Node::Number(value))
    }

    pub(crate) fn integer(&mut self, value: i32) -> Expr {
        self.number(Rational::integer(value))
    }

    /// An integer of any size, exactly if it fits.
    pub(crate) fn whole(&mut self, value: i128) -> Expr {
        match Rational::new(value, 1) {
            Some(exact) => self.number(exact),
            None => self.float(value as f64),
        }
    }

    /// A binary64 constant: an exact rational if that is small, else opaque. The sign goes to the
    /// coefficient.
    pub(crate) fn float(&mut self, value: f64) -> Expr {
        match Rational::from_f64(value).filter(|rational| rational.denominator() <= SMALL_DENOMINATOR) {
            Some(rational) => self.number(rational),
            None if value < 0.0 => {
                let magnitude = self.intern(Node::Float((-value).to_bits()));
                self.negate(magnitude)
            }
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
        let Collected { mut terms, mut constant, overflow } = collected;
        for (number, coefficient) in overflow {
            terms.push((self.number(number), coefficient));
        }
        self.sort(&mut terms);
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
        // A number that did not fit before may fit now.
        while let Some((i, total)) = merged.iter().enumerate().find_map(|(i, &(term, coefficient))| {
            Some((i, coefficient.multiply(self.as_number(term)?)?.add(constant)?))
        }) {
            merged.remove(i);
            constant = total;
        }
        // `s/2 + s/2` has become `s`, which may be a sum to flatten.
        let is_open = |term| matches!(self.node(term), Node::Sum { terms, .. } if terms.len() <= OPEN_LIMIT);
        if merged.iter().any(|&(term, coefficient)| is_unit(coefficient) && is_open(term)) {
            merged.push((self.number(constant), Rational::ONE));
            return self.linear_combination(&merged);
        }
        match merged.as_slice() {
            [] => self.number(constant),
            &[(term, coefficient)] if coefficient.is_one() && constant.is_zero() => term,
            _ => self.intern(Node::Sum { terms: merged.into(), constant }),
        }
    }

    /// Adds `coefficient · operand` to `into`, flattening sums if that needs no multiplication. A number
    /// outside the exact range becomes a separate term, so that no digit is lost.
    fn collect(&self, into: &mut Collected, operand: Expr, coefficient: Rational) {
        match self.node(operand) {
            _ if coefficient.is_zero() => {}
            Node::Number(value) => {
                match coefficient.multiply(*value).and_then(|product| into.constant.add(product)) {
                    Some(sum) => into.constant = sum,
                    None => into.terms.push((operand, coefficient)),
                }
            }
            Node::Sum { terms, constant } if is_unit(coefficient) && terms.len() <= OPEN_LIMIT => {
                let signed = |value: Rational| if coefficient.is_negative() { value.negate() } else { value };
                into.terms.extend(terms.iter().map(|&(term, inner)| (term, signed(inner))));
                match into.constant.add(signed(*constant)) {
                    Some(sum) => into.constant = sum,
                    None => into.overflow.push((*constant, coefficient)),
                }
            }
            Node::Sum { terms, constant } if terms.len() == 1 && constant.is_zero() => {
                let (term, inner) = terms[0];
                into.terms.push(inner.multiply(coefficient).map_or((operand, coefficient), |c| (term, c)));
            }
            _ => into.terms.push((operand, coefficient)),
        }
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
    /// A fractional power of a base that is not proven nonnegative becomes `sqrt` or `powf`, which keep their
    /// domain.
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

    /// `Π base^exponent`, with fractional exponents only of bases proven nonnegative.
    pub(super) fn product_of_powers(&mut self, operands: &[(Expr, Rational)]) -> Expr {
        let Factors { coefficient, mut factors, .. } = self.collect_factors(operands);
        if coefficient.is_zero() {
            return self.number(Rational::ZERO);
        }
        self.sort(&mut factors);
        let mut merges = 0;
        let mut merged: Vec<(Expr, Rational)> = Vec::with_capacity(factors.len());
        for (base, exponent) in factors {
            let total = merged.last().filter(|&&(last, _)| last == base).and_then(|&(_, total)| {
                let same_sign = total.is_negative() == exponent.is_negative();
                if same_sign || self.is_nonzero(base) { total.add(exponent) } else { None }
            });
            match (total, merged.last_mut()) {
                (Some(total), Some((_, last))) => {
                    *last = total;
                    merges += 1;
                }
                _ => merged.push((base, exponent)),
            }
        }
        merged.retain(|&(_, exponent)| !exponent.is_zero());
        if let Some(product) = self.product_of_selections(&merged) {
            return self.scale(product, coefficient);
        }
        // `√u √u` has become `u`, which may be a product, a multiple or a number to flatten. A number that
        // did not fit with this coefficient would not fit again.
        if merges > 0 && merged.iter().any(|&(base, exponent)| self.opens_beside(coefficient, base, exponent))
        {
            let coefficient = self.number(coefficient);
            merged.insert(0, (coefficient, Rational::ONE));
            return self.product_of_powers(&merged);
        }
        let product = match merged.as_slice() {
            [] => return self.number(coefficient),
            &[(base, exponent)] if exponent.is_one() => base,
            _ => self.intern(Node::Product(merged.into())),
        };
        self.scale(product, coefficient)
    }

    /// A product with two selections by one condition as one selection: they are zero in turn where the
    /// members of a family differ.
    fn product_of_selections(&mut self, factors: &[(Expr, Rational)]) -> Option<Expr> {
        let selection = |&(base, exponent): &(Expr, Rational)| match *self.node(base) {
            Node::Select { condition, then, otherwise } if exponent.is_one() => {
                Some((condition, then, otherwise))
            }
            _ => None,
        };
        let found: Vec<_> = factors.iter().map(selection).collect();
        let second = (1..found.len()).find_map(|j| {
            let condition = found[j]?.0;
            let i = found[..j].iter().position(|one| one.is_some_and(|(of, ..)| of == condition))?;
            Some((i, j))
        });
        let (i, j) = second?;
        let ((condition, a, b), (_, c, d)) = (found[i]?, found[j]?);
        let rest = factors.iter().enumerate().filter(|(k, _)| ![i, j].contains(k)).map(|(_, &factor)| factor);
        let rest: Vec<_> = rest.collect();
        let [then, otherwise] = [[a, c], [b, d]].map(|pair| self.product(&pair));
        let selected = self.select(condition, then, otherwise);
        Some(self.product_of_powers(&[&[(selected, Rational::ONE)], rest.as_slice()].concat()))
    }

    /// Number and canonical factors of a product. If the numbers of the operands do not fit one exact number,
    /// each multiple `c x` stays one factor: extracting only some of the numbers would make equal operands
    /// differ, and their powers could not be collected.
    fn collect_factors(&self, operands: &[(Expr, Rational)]) -> Factors {
        let collect = |keeps_multiples| {
            let mut factors = Factors::new(Rational::ONE, keeps_multiples);
            for &(operand, exponent) in operands {
                self.collect_factor(&mut factors, operand, exponent);
                if factors.overflows && !keeps_multiples {
                    break;
                }
            }
            factors
        };
        let factors = collect(false);
        if factors.overflows { collect(true) } else { factors }
    }

    /// Whether a factor `base^exponent` still has parts that belong to the surrounding product.
    #[cfg(test)]
    pub(super) fn opens(&self, base: Expr, exponent: Rational) -> bool {
        self.opens_beside(Rational::ONE, base, exponent)
    }

    fn opens_beside(&self, coefficient: Rational, base: Expr, exponent: Rational) -> bool {
        let mut factors = Factors::new(coefficient, false);
        self.collect_factor(&mut factors, base, exponent);
        factors.factors != [(base, exponent)]
    }

    /// Splits `operand^exponent` into a number and canonical factors.
    fn collect_factor(&self, into: &mut Factors, operand: Expr, exponent: Rational) {
        if exponent.is_zero() {
            return;
        }
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
            && (rest.is_none() || !into.keeps_multiples)
        {
            match into.coefficient.multiply(value) {
                Some(total) => {
                    into.coefficient = total;
                    if let Some(rest) = rest {
                        self.collect_factor(into, rest, exponent);
                    }
                    return;
                }
                None => into.overflows = true,
            }
            // Collected again with multiples as factors.
            if !into.keeps_multiples {
                into.factors.push((operand, exponent));
                return;
            }
        }
        if let Node::Product(inner) = self.node(operand)
            && inner.len() <= OPEN_LIMIT
            && exponent.is_integer()
            && (!exponent.is_negative() || inner.iter().all(|&(base, e)| self.invertible(base, e)))
            && let Some(powers) = spread(inner, exponent)
        {
            if exponent.is_one() {
                into.factors.extend(powers);
                return;
            }
            for (base, total) in powers {
                if into.overflows && !into.keeps_multiples {
                    return;
                }
                if total.is_integer() {
                    self.collect_factor(into, base, total);
                } else {
                    into.factors.push((base, total));
                }
            }
            return;
        }
        into.factors.push((operand, exponent));
    }

    /// Whether `1 / base^exponent` is `base^-exponent` on the whole domain: not for `1/x`, which excludes 0.
    fn invertible(&self, base: Expr, exponent: Rational) -> bool {
        !exponent.is_negative() || self.is_nonzero(base)
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
        match (function.parity(), self.negated(x)) {
            (Parity::Even, Some(positive)) => self.apply(function, &[positive]),
            (Parity::Odd, Some(positive)) => {
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
}

#[derive(Default)]
struct Collected {
    terms: Vec<(Expr, Rational)>,
    constant: Rational,
    /// Constants that exceed the exact range together with `constant`.
    overflow: Vec<(Rational, Rational)>,
}

impl Default for Rational {
    fn default() -> Self {
        Self::ZERO
    }
}

/// A product during collection.
struct Factors {
    coefficient: Rational,
    factors: Vec<(Expr, Rational)>,
    /// Whether a multiple `c x` is one factor.
    keeps_multiples: bool,
    /// Whether a number did not fit.
    overflows: bool,
}

impl Factors {
    fn new(coefficient: Rational, keeps_multiples: bool) -> Self {
        Self { coefficient, factors: Vec::new(), keeps_multiples, overflows: false }
    }
}

/// `(Π base^e)^exponent` factor by factor, if no exponent becomes too large.
fn spread(factors: &[(Expr, Rational)], exponent: Rational) -> Option<Vec<(Expr, Rational)>> {
    let limit = Rational::integer(LARGEST_OPEN_EXPONENT);
    let spread = |&(base, e): &(Expr, Rational)| {
        let total = e.multiply(exponent)?;
        (total <= limit && limit.negate() <= total).then_some((base, total))
    };
    factors.iter().map(spread).collect()
}

fn is_unit(value: Rational) -> bool {
    value.is_one() || value == Rational::MINUS_ONE
}

/// `number^exponent` where it is rational; `None` keeps it symbolic (`2^(1/2)`, `0^-1`).
fn exact_power(number: Rational, exponent: Rational) -> Option<Rational> {
    if exponent.is_integer() || number.is_one() {
        return number.power(exponent.numerator());
    }
    let root = |value: i64| {
        let root = (value as f64).sqrt() as i64;
        (root * root == value).then_some(i128::from(root))
    };
    let twice = exponent.multiply(Rational::integer(2)).filter(|twice| twice.is_integer())?;
    Rational::new(root(number.numerator())?, root(number.denominator())?)?.power(twice.numerator())
}

/// Exact values of functions: nothing else is folded, so that roundings occur where the user wrote them.
fn exact_value(function: Function, x: Rational) -> Option<Rational> {
    match function {
        Function::Exp | Function::Exp2 | Function::Cos | Function::Cosh if x.is_zero() => Some(Rational::ONE),
        Function::ExpM1 | Function::Ln1p if x.is_zero() => Some(Rational::ZERO),
        Function::Special(special) if x.is_zero() && special.parity() != Parity::Odd => {
            Rational::new(1, special.inverse_at_zero()?.into())
        }
        odd if x.is_zero() && odd.parity() == Parity::Odd => Some(Rational::ZERO),
        Function::Ln | Function::Log2 | Function::Log10 | Function::Acos | Function::Acosh if x.is_one() => {
            Some(Rational::ZERO)
        }
        Function::Signum if x.is_negative() => Some(Rational::MINUS_ONE),
        Function::Signum => Some(Rational::ONE),
        Function::Cbrt if x.is_one() => Some(Rational::ONE),
        Function::Abs => Some(if x.is_negative() { x.negate() } else { x }),
        _ => None,
    }
}
