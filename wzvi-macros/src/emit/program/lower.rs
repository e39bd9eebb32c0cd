//! From the symbolic graph to a [`Program`]: definitions are followed, common factors taken out, sums and
//! products split by level. Tests: `tests/steps/accuracy.rs`, and the golden expansions
//! (`compile/golden_tests.rs`).

use std::collections::{BTreeMap, HashMap, HashSet};

use super::{Level, Op, Operation, Program};
use crate::symbolic::{Expr, Function, Graph, Node, Rational, Symbol, SymbolKind};

/// The largest integer power that is expanded into products.
const LARGEST_SPELLED_POWER: i64 = 16;

/// Lowers expressions of one graph into one program.
pub(crate) struct Lowering<'a> {
    graph: &'a mut Graph,
    definitions: HashMap<Symbol, Expr>,
    lowered: HashMap<Expr, Op>,
    /// Sums already factored: the result, if factoring was worthwhile.
    factored: HashMap<Expr, Option<Expr>>,
    /// Sums that add an increment to a state, where a common factor would lose digits of the increment.
    kept: HashSet<Expr>,
    pub(crate) program: Program,
}

/// A number times powers.
type Flat = (Rational, Vec<(Expr, Rational)>);

/// A value and its pending sign.
#[derive(Clone, Copy)]
struct Signed {
    negative: bool,
    op: Op,
}

/// Four times a number, if that is an integer.
fn quarters(size: Rational) -> Option<i64> {
    let is_of_quarters = [1, 2, 4].contains(&size.denominator());
    if is_of_quarters { size.numerator().checked_mul(4 / size.denominator()) } else { None }
}

impl<'a> Lowering<'a> {
    /// `definitions` replace symbols; they must not be circular.
    pub(crate) fn new(graph: &'a mut Graph, definitions: HashMap<Symbol, Expr>) -> Self {
        // Sorted, so that the generated code is deterministic.
        let definitions: BTreeMap<Symbol, Expr> = definitions.into_iter().collect();
        let (symbols, expressions): (Vec<Symbol>, Vec<Expr>) = definitions.into_iter().unzip();
        let definitions = symbols.into_iter().zip(graph.stabilise(&expressions)).collect();
        let (lowered, factored, kept) = (HashMap::new(), HashMap::new(), HashSet::new());
        Self { graph, definitions, lowered, factored, kept, program: Program::default() }
    }

    /// The operation that reads `symbol`, which is known at `level`.
    pub(crate) fn input(&mut self, symbol: Symbol, level: Level) -> Op {
        self.program.inputs.insert(symbol, level);
        self.program.input(symbol)
    }

    /// Keeps the terms of `sum` apart.
    pub(crate) fn keep(&mut self, sum: Expr) {
        self.kept.insert(sum);
    }

    pub(crate) fn graph(&mut self) -> &mut Graph {
        self.graph
    }

    /// The operation that computes `root`.
    pub(crate) fn lower(&mut self, root: Expr) -> Op {
        let root = self.graph.stabilise(&[root])[0];
        let mut pending = vec![(root, false)];
        while let Some((expr, is_ready)) = pending.pop() {
            if self.lowered.contains_key(&expr) {
                continue;
            }
            if is_ready {
                let op = self.lower_node(expr);
                self.lowered.insert(expr, op);
                continue;
            }
            pending.push((expr, true));
            let node = self.graph.node(expr).clone();
            if let Some(factored) = self.factored(expr) {
                pending.push((factored, false));
                continue;
            }
            match node {
                Node::Symbol(symbol) => pending.extend(self.definitions.get(&symbol).map(|&e| (e, false))),
                node => pending.extend(self.dependencies(&node).into_iter().rev().map(|e| (e, false))),
            }
        }
        self.lowered[&root]
    }

    /// The operands; products, and products that are terms of a sum, are flattened.
    fn dependencies(&mut self, node: &Node) -> Vec<Expr> {
        match node {
            Node::Sum { terms, .. } => {
                terms.iter().flat_map(|&(term, c)| self.flat_term(term, c).1).map(|(base, _)| base).collect()
            }
            Node::Product(factors) => {
                self.flat_product(factors, Rational::ONE).1.into_iter().map(|(base, _)| base).collect()
            }
            other => other.operands(),
        }
    }

    fn flat_term(&mut self, term: Expr, coefficient: Rational) -> Flat {
        match self.graph.node(term).clone() {
            Node::Product(factors) => self.flat_product(&factors, coefficient),
            _ => self.flat_product(&[(term, Rational::ONE)], coefficient),
        }
    }

    /// A product with the factors of its sums taken out: `h (a x + a y)` is the product of `h`, `a` and
    /// `x + y`, so that `h a` is one constant.
    fn flat_product(&mut self, factors: &[(Expr, Rational)], coefficient: Rational) -> Flat {
        let mut flat: Flat = (coefficient, Vec::new());
        let mut pending: Vec<(Expr, Rational)> = factors.iter().rev().copied().collect();
        while let Some((base, exponent)) = pending.pop() {
            let opened = if exponent.is_one() { self.opened(base) } else { None };
            let total = opened.as_ref().and_then(|(size, _)| flat.0.multiply(*size));
            match (opened, total) {
                (Some((_, inner)), Some(total)) => {
                    flat.0 = total;
                    pending.extend(inner.into_iter().rev());
                }
                _ => flat.1.push((base, exponent)),
            }
        }
        flat
    }

    /// A sum as a number times factors, if it has a common factor.
    fn opened(&mut self, base: Expr) -> Option<Flat> {
        let (coefficient, product) = match self.factored(base) {
            Some(factored) => self.graph.as_multiple(factored),
            None => {
                let Node::Sum { terms, constant } = self.graph.node(base).clone() else { return None };
                let size = common_size(&terms, constant)?;
                let inverse = size.recip()?;
                let scaled: Option<Vec<_>> =
                    terms.iter().map(|&(term, c)| Some((term, c.multiply(inverse)?))).collect();
                (size, self.graph.linear_combination(&scaled?))
            }
        };
        match self.graph.node(product) {
            Node::Product(factors) => Some((coefficient, factors.to_vec())),
            _ if product == base => None,
            _ => Some((coefficient, vec![(product, Rational::ONE)])),
        }
    }

    /// `a x + b x` as `(a + b) x`, by the factor that most terms share.
    fn factored(&mut self, expr: Expr) -> Option<Expr> {
        if let Some(&known) = self.factored.get(&expr) {
            return known;
        }
        let factored = match self.graph.node(expr).clone() {
            Node::Sum { terms, constant } if !self.kept.contains(&expr) => {
                self.factor_out(expr, &terms, constant)
            }
            _ => None,
        };
        self.factored.insert(expr, factored);
        factored
    }

    fn factor_out(&mut self, expr: Expr, terms: &[(Expr, Rational)], constant: Rational) -> Option<Expr> {
        // For each factor, the number of terms with it and their common power, which is taken out as a whole.
        let mut counts: HashMap<Expr, (usize, Rational)> = HashMap::new();
        for &(term, _) in terms {
            for (base, exponent) in self.positive_factors(term) {
                let (count, shared) = counts.entry(base).or_insert((0, exponent));
                *count += 1;
                *shared = exponent.min(*shared);
            }
        }
        let (&factor, &(_, shared)) = counts
            .iter()
            .filter(|(_, (count, _))| *count > 1)
            .max_by(|(a, (x, _)), (b, (y, _))| x.cmp(y).then_with(|| self.graph.order(**a, **b)))?;
        let (mut inside, mut outside) = (Vec::new(), Vec::new());
        for &(term, coefficient) in terms {
            match self.without_factor(term, factor, shared) {
                Some(quotient) => inside.push((quotient, coefficient)),
                None => outside.push((term, coefficient)),
            }
        }
        let inside = self.graph.linear_combination(&inside);
        let factor = self.graph.power(factor, shared);
        let product = self.graph.multiply(inside, factor);
        if outside.is_empty() && constant.is_zero() {
            return (product != expr).then_some(product);
        }
        // The product is hidden behind a symbol, as the canonical form would expand it again.
        let hidden = self.graph.new_symbol(SymbolKind::Auxiliary, "");
        self.definitions.insert(hidden, product);
        let one = self.graph.integer(1);
        outside.push((self.graph.symbol(hidden), Rational::ONE));
        outside.push((one, constant));
        Some(self.graph.linear_combination(&outside))
    }

    /// Factors with a positive integer exponent.
    fn positive_factors(&self, term: Expr) -> Vec<(Expr, Rational)> {
        match self.graph.node(term) {
            Node::Product(factors) => {
                factors.iter().copied().filter(|(_, e)| e.is_integer() && !e.is_negative()).collect()
            }
            Node::Number(_) => Vec::new(),
            _ => vec![(term, Rational::ONE)],
        }
    }

    /// `term / factor^shared`, if the term has that power.
    fn without_factor(&mut self, term: Expr, factor: Expr, shared: Rational) -> Option<Expr> {
        if term == factor && shared.is_one() {
            return Some(self.graph.integer(1));
        }
        let Node::Product(factors) = self.graph.node(term).clone() else { return None };
        let mut removed = false;
        let mut rest = Vec::new();
        for (base, exponent) in factors {
            let exponent = if base == factor && exponent.is_integer() && !exponent.is_negative() {
                removed = true;
                exponent.add(shared.negate())?
            } else {
                exponent
            };
            rest.push(self.graph.power(base, exponent));
        }
        removed.then(|| self.graph.product(&rest))
    }

    fn lower_node(&mut self, expr: Expr) -> Op {
        if let Some(factored) = self.factored(expr) {
            return self.lowered[&factored];
        }
        let at = |operand: Expr| self.lowered[&operand];
        match self.graph.node(expr).clone() {
            Node::Number(value) => self.program.constant(value.to_f64()),
            Node::Float(bits) => self.program.constant(f64::from_bits(bits)),
            Node::Symbol(symbol) => match self.definitions.get(&symbol) {
                Some(definition) => self.lowered[definition],
                None => self.program.input(symbol),
            },
            Node::Sum { terms, constant } => self.lower_sum(&terms, constant),
            Node::Product(factors) => {
                let (coefficient, factors) = self.flat_product(&factors, Rational::ONE);
                let signed = self.lower_product(&factors, coefficient);
                self.with_sign(signed)
            }
            Node::Apply(function, arguments) => {
                let arguments = arguments.iter().map(|&argument| at(argument)).collect();
                self.program.push(Operation::Call(function, arguments))
            }
            Node::Select { condition, then, otherwise } => {
                self.program.push(Operation::Select(at(condition), at(then), at(otherwise)))
            }
            Node::Compare(relation, a, b) => self.program.push(Operation::Compare(relation, at(a), at(b))),
            Node::Join(junction, a, b) => self.program.push(Operation::Join(junction, at(a), at(b))),
            Node::Not(a) => self.program.push(Operation::Not(at(a))),
        }
    }

    fn with_sign(&mut self, signed: Signed) -> Op {
        if signed.negative { self.program.push(Operation::Negate(signed.op)) } else { signed.op }
    }

    /// Terms are added level by level, so that the constant part is one number.
    fn lower_sum(&mut self, terms: &[(Expr, Rational)], constant: Rational) -> Op {
        let common = common_size(terms, constant);
        let divide = |coefficient: Rational| match common {
            Some(_) if coefficient.is_negative() => Rational::MINUS_ONE,
            Some(_) => Rational::ONE,
            None => coefficient,
        };
        let mut values = Vec::with_capacity(terms.len() + 1);
        for &(term, coefficient) in terms {
            let (coefficient, factors) = self.flat_term(term, divide(coefficient));
            values.push(self.lower_product(&factors, coefficient));
        }
        if !constant.is_zero() {
            let op = self.program.constant(constant.to_f64().abs());
            values.push(Signed { negative: constant.is_negative(), op });
        }
        values.sort_by_key(|value| self.program.level(value.op));
        let mut total: Option<Signed> = None;
        for level in [Level::Prepared, Level::Time, Level::Increments, Level::State] {
            let group: Vec<Signed> =
                values.iter().copied().filter(|value| self.program.level(value.op) == level).collect();
            let Some(part) = self.add_up(&group) else { continue };
            total = match total {
                None => Some(part),
                Some(before) => self.add_up(&[part, before]),
            };
        }
        let total = match total {
            Some(total) => self.with_sign(total),
            None => self.program.constant(0.0),
        };
        match common {
            Some(size) => {
                let size = self.program.constant(size.to_f64());
                self.program.push(Operation::Multiply(size, total))
            }
            None => total,
        }
    }

    /// The sum of `values`, starting with a positive one if there is any.
    fn add_up(&mut self, values: &[Signed]) -> Option<Signed> {
        let first = values.iter().position(|value| !value.negative).unwrap_or(0);
        let &start = values.get(first)?;
        let mut op = start.op;
        for (i, value) in values.iter().enumerate() {
            if i != first {
                let operation = if value.negative == start.negative {
                    Operation::Add(op, value.op)
                } else {
                    Operation::Subtract(op, value.op)
                };
                op = self.program.push(operation);
            }
        }
        Some(Signed { negative: start.negative, op })
    }

    /// `coefficient · Π base^exponent`: per level one product over one quotient; the coefficient joins the
    /// earliest.
    fn lower_product(&mut self, factors: &[(Expr, Rational)], coefficient: Rational) -> Signed {
        let mut total: Option<Op> = None;
        let size = if coefficient.is_negative() { coefficient.negate() } else { coefficient };
        if !size.is_one() {
            total = Some(self.program.constant(size.to_f64()));
        }
        let mut negative = coefficient.is_negative();
        for level in [Level::Prepared, Level::Time, Level::Increments, Level::State] {
            let (mut numerator, mut denominator): (Option<Op>, Option<Op>) = (None, None);
            if level == Level::Prepared {
                numerator = total.take();
            }
            for &(base, exponent) in factors {
                let base = self.lowered[&base];
                if self.program.level(base) != level {
                    continue;
                }
                let (power, divides) = match exponent {
                    exponent if !exponent.is_negative() => (self.lower_power(base, exponent), false),
                    Rational::MINUS_ONE if self.program.find(&Operation::Reciprocal(base)).is_none() => {
                        (base, true)
                    }
                    exponent => (self.lower_inverse_power(base, exponent.negate()), false),
                };
                let into = if divides { &mut denominator } else { &mut numerator };
                *into = Some(match *into {
                    None => power,
                    Some(product) => self.program.push(Operation::Multiply(product, power)),
                });
            }
            let part = match (numerator, denominator) {
                (None, None) => continue,
                (Some(numerator), None) => numerator,
                (None, Some(denominator)) => self.program.push(Operation::Reciprocal(denominator)),
                (Some(numerator), Some(denominator)) => {
                    self.program.push(Operation::Divide(numerator, denominator))
                }
            };
            total = Some(match total {
                None => part,
                Some(before) => self.program.push(Operation::Multiply(before, part)),
            });
        }
        let mut op = total.unwrap_or_else(|| self.program.constant(1.0));
        if let Operation::Negate(inner) = *self.program.operation(op) {
            (op, negative) = (inner, !negative);
        }
        Signed { negative, op }
    }

    /// `base^(quarters/4)` for one to three quarters, by shared square roots; `None` for other fractions.
    fn lower_root(&mut self, base: Op, quarters: i64) -> Option<Op> {
        let root = |program: &mut Program, of: Op| program.push(Operation::Call(Function::Sqrt, vec![of]));
        let half = root(&mut self.program, base);
        match quarters {
            1 => Some(root(&mut self.program, half)),
            2 => Some(half),
            3 => {
                let quarter = root(&mut self.program, half);
                Some(self.program.push(Operation::Multiply(half, quarter)))
            }
            _ => None,
        }
    }

    /// `1 / base^size` through the one reciprocal that all inverse powers of the base share; powers of halves
    /// and quarters as `(root / base) · base^-k`, in an order that neither overflows nor underflows before
    /// the result does.
    fn lower_inverse_power(&mut self, base: Op, size: Rational) -> Op {
        let inverse = self.program.push(Operation::Reciprocal(base));
        let whole = size.numerator() / size.denominator();
        if size.is_integer() {
            return self.lower_integer_power(inverse, whole);
        }
        let quarters = quarters(size).filter(|_| whole <= LARGEST_SPELLED_POWER);
        let Some(root) = quarters.and_then(|quarters| self.lower_root(base, 4 - quarters % 4)) else {
            let exponent = self.program.constant(-size.to_f64());
            return self.program.push(Operation::Call(Function::Powf, vec![base, exponent]));
        };
        let mut power = self.program.push(Operation::Multiply(root, inverse));
        for _ in 0..whole {
            power = self.program.push(Operation::Multiply(power, inverse));
        }
        power
    }

    /// `base^size`, by shared squares and square roots.
    fn lower_power(&mut self, base: Op, size: Rational) -> Op {
        let whole = size.numerator() / size.denominator();
        let integer_part = (whole > 0).then(|| self.lower_integer_power(base, whole));
        let root = match quarters(size) {
            Some(quarters) if quarters % 4 == 0 => None,
            Some(quarters) => self.lower_root(base, quarters % 4),
            None => {
                let exponent = self.program.constant(size.to_f64());
                return self.program.push(Operation::Call(Function::Powf, vec![base, exponent]));
            }
        };
        match (integer_part, root) {
            (Some(power), Some(root)) => self.program.push(Operation::Multiply(power, root)),
            (Some(only), None) | (None, Some(only)) => only,
            (None, None) => self.program.constant(1.0),
        }
    }

    fn lower_integer_power(&mut self, base: Op, exponent: i64) -> Op {
        match i32::try_from(exponent) {
            Ok(1) => base,
            Ok(exponent) if i64::from(exponent) > LARGEST_SPELLED_POWER => {
                self.program.push(Operation::Power(base, exponent))
            }
            // Expanded, or too large for `powi`.
            _ => {
                let half = self.lower_integer_power(base, exponent / 2);
                let square = self.program.push(Operation::Multiply(half, half));
                if exponent % 2 == 0 { square } else { self.program.push(Operation::Multiply(square, base)) }
            }
        }
    }
}

/// The coefficient that all terms share up to sign, if taking it out saves products.
fn common_size(terms: &[(Expr, Rational)], constant: Rational) -> Option<Rational> {
    let size = |value: Rational| if value.is_negative() { value.negate() } else { value };
    let first = size(terms.first()?.1);
    let shared = terms.len() > 1 && constant.is_zero() && terms.iter().all(|&(_, c)| size(c) == first);
    (shared && !first.is_one()).then_some(first)
}
