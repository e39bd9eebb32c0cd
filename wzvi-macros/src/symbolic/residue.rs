//! Exact values of expressions at random points of finite fields.
//!
//! With every function of one argument node replaced by an independent random number (or a rational function
//! of one, so that `sin² + cos² = 1`, addition theorems and `2 sin²(x/2) = 1 - cos x` hold; `hypot(x, y)` is
//! `√(x² + y²)`, `x^y` maps sums of exponents to products, `2^x` is such a power of 2, `log2`, `log10` and
//! `ln(1 + x)` are logarithms `ln`, and the binary64 numbers next to `ln 2`, `ln 10` and their quotients
//! stand for these), an expression is a rational function of degree `d` in random numbers of the field with
//! `p` elements. A nonzero one vanishes at a random point with probability at most `d / p` (Schwartz,
//! Zippel), below 1e-15 for `d < 1000`. A rational function that is nonzero over the rationals could still
//! vanish modulo one prime (`2^61 x - x` modulo `2^61 - 1`); two primes, one without structure, exclude that.
//!
//! Square roots take a random sign per value and point: an expression such as `√(x²) - x` vanishes for only
//! half of them, so that with roots [`POINTS_WITH_ROOTS`] points are tried. A base that is not a square has
//! its root in the quadratic extension by `i = √-1` (both primes are 3 modulo 4), so that hardly any point is
//! lost.
//!
//! Tests: `symbolic/tests/mod.rs`, `lower/tests/identities.rs`.

use std::f64::consts::{LN_2, LN_10, LOG2_10, LOG2_E, LOG10_2, LOG10_E};

use super::rational::power;
use super::{Expr, Function, Graph, Node, Rational, Relation, Special};

const PRIMES: [u64; 2] = [(1 << 61) - 1, 2_718_281_828_459_045_287];
const POINTS: usize = 4;
const POINTS_WITH_ROOTS: usize = 52;
/// Attempts per successful point: nested roots and divisions by zero fail at some.
const ATTEMPTS: usize = 4;

/// Whether `expr` is zero at every one of enough random points; `false` also if too few points have a value.
pub(super) fn vanishes_modulo_primes(graph: &Graph, expr: Expr) -> bool {
    let has_roots = graph.reachable(&[expr]).iter().any(|&part| match graph.node(part) {
        Node::Product(factors) => factors.iter().any(|&(_, exponent)| exponent.denominator() == 2),
        Node::Apply(function, _) => matches!(function, Function::Sqrt | Function::Hypot),
        _ => false,
    });
    let parts = common_parts(graph, expr);
    let wanted = if has_roots { POINTS_WITH_ROOTS } else { POINTS };
    let mut found = 0;
    for attempt in 0..wanted * ATTEMPTS {
        let point =
            Point { graph, field: QuadraticExtension(PRIMES[attempt % 2]), seed: attempt as u64, parts };
        match graph.fold(&[expr], None, |part, node, value| point.node(part, node, value))[0] {
            Some(value) if value == Residue::ZERO => found += 1,
            Some(_) => return false,
            None => {}
        }
        if found == wanted {
            return true;
        }
    }
    false
}

/// The common denominator of the coefficients in arguments of circular and exponential functions: `x/2` and
/// `x/3` are 3 and 2 of 6 parts of `x`. 1 if it is large: then `x/2` and `x` are unrelated.
fn common_parts(graph: &Graph, expr: Expr) -> i64 {
    const MOST: i64 = 1 << 12;
    let mut parts: i64 = 1;
    for part in graph.reachable(&[expr]) {
        let Node::Apply(function, arguments) = graph.node(part) else { continue };
        let multiplied = match function {
            Function::Powf => arguments[1],
            Function::Sqrt | Function::Cbrt | Function::Abs => continue,
            _ if function.arity() > 1 => continue,
            _ => arguments[0],
        };
        for (_, coefficient) in linear_terms(graph, multiplied) {
            let denominator = coefficient.denominator();
            let (mut a, mut b) = (parts, denominator);
            while b != 0 {
                (a, b) = (b, a % b);
            }
            match (denominator / a).checked_mul(parts) {
                Some(common) if common <= MOST => parts = common,
                _ => return 1,
            }
        }
    }
    parts
}

/// An argument as `Σ coefficient · term`, with the coefficient of 1 for `None`. Sums below a common factor,
/// as `x + y` in `(x + y)/2`, are opened, if each coefficient is an exact fraction.
fn linear_terms(graph: &Graph, argument: Expr) -> Vec<(Option<Expr>, Rational)> {
    let whole = |expr: Expr| match graph.node(expr) {
        Node::Sum { terms, constant } => {
            let constant = (!constant.is_zero()).then_some((None, *constant));
            terms.iter().map(|&(term, c)| (Some(term), c)).chain(constant).collect()
        }
        &Node::Number(value) => vec![(None, value)],
        _ => vec![(Some(expr), Rational::ONE)],
    };
    let mut open: Vec<(Option<Expr>, Rational)> = Vec::new();
    for (term, coefficient) in whole(argument) {
        let inner = term.map(whole).unwrap_or_default();
        let scaled: Option<Vec<_>> =
            inner.into_iter().map(|(of, c)| Some((of, c.multiply(coefficient)?))).collect();
        match scaled {
            Some(scaled) if !scaled.is_empty() => open.extend(scaled),
            _ => open.push((term, coefficient)),
        }
    }
    open
}

/// A small deterministic generator (Steele, Lea, Flood: "Fast splittable pseudorandom number generators").
pub(super) struct SplitMix(u64);

impl SplitMix {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// `re + im · i` modulo the prime.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Residue {
    re: u64,
    im: u64,
}

impl Residue {
    const ZERO: Self = Self { re: 0, im: 0 };
    const ONE: Self = Self { re: 1, im: 0 };
}

/// The field with `p²` elements, for a prime `p` that is 3 modulo 4.
#[derive(Clone, Copy)]
struct QuadraticExtension(u64);

impl QuadraticExtension {
    fn add_modulo(self, a: u64, b: u64) -> u64 {
        (a + b) % self.0
    }

    fn negate_modulo(self, a: u64) -> u64 {
        (self.0 - a) % self.0
    }

    fn multiply_modulo(self, a: u64, b: u64) -> u64 {
        (u128::from(a) * u128::from(b) % u128::from(self.0)) as u64
    }

    fn power_modulo(self, base: u64, exponent: u64) -> u64 {
        self.power(Residue { re: base, im: 0 }, exponent).re
    }

    fn integer(self, value: i64) -> Residue {
        let magnitude = value.unsigned_abs() % self.0;
        Residue { re: if value < 0 { self.negate_modulo(magnitude) } else { magnitude }, im: 0 }
    }

    fn rational(self, value: Rational) -> Option<Residue> {
        self.divide(self.integer(value.numerator()), self.integer(value.denominator()))
    }

    /// The exact value `m · 2^e` of a binary64 number.
    fn float(self, value: f64) -> Option<Residue> {
        let bits = value.abs().to_bits();
        let (exponent, fraction) = ((bits >> 52) as i64, bits & ((1 << 52) - 1));
        let significand = if exponent == 0 { fraction } else { fraction | (1 << 52) };
        let magnitude = self.multiply(
            self.integer(significand as i64),
            self.power_signed(self.integer(2), exponent.max(1) - 1075)?,
        );
        value.is_finite().then(|| if value < 0.0 { self.negate(magnitude) } else { magnitude })
    }

    fn add(self, a: Residue, b: Residue) -> Residue {
        Residue { re: self.add_modulo(a.re, b.re), im: self.add_modulo(a.im, b.im) }
    }

    fn negate(self, a: Residue) -> Residue {
        Residue { re: self.negate_modulo(a.re), im: self.negate_modulo(a.im) }
    }

    fn subtract(self, a: Residue, b: Residue) -> Residue {
        self.add(a, self.negate(b))
    }

    fn multiply(self, a: Residue, b: Residue) -> Residue {
        if a.im == 0 && b.im == 0 {
            return Residue { re: self.multiply_modulo(a.re, b.re), im: 0 };
        }
        let (rr, ii) = (self.multiply_modulo(a.re, b.re), self.multiply_modulo(a.im, b.im));
        let (ri, ir) = (self.multiply_modulo(a.re, b.im), self.multiply_modulo(a.im, b.re));
        Residue { re: self.add_modulo(rr, self.negate_modulo(ii)), im: self.add_modulo(ri, ir) }
    }

    fn power(self, base: Residue, exponent: u64) -> Residue {
        let power = power(Residue::ONE, base, exponent, |a, b| Some(self.multiply(a, b)));
        power.unwrap_or(Residue::ZERO)
    }

    fn recip(self, a: Residue) -> Option<Residue> {
        let (re, im) = (self.multiply_modulo(a.re, a.re), self.multiply_modulo(a.im, a.im));
        let norm = self.add_modulo(re, im);
        // Fermat: a^(p-2) is the inverse of a.
        let inverse = self.power_modulo(norm, self.0 - 2);
        let conjugate = Residue { re: a.re, im: self.negate_modulo(a.im) };
        (norm != 0).then(|| self.multiply(conjugate, Residue { re: inverse, im: 0 }))
    }

    fn divide(self, a: Residue, b: Residue) -> Option<Residue> {
        if b == Residue::ONE { Some(a) } else { Some(self.multiply(a, self.recip(b)?)) }
    }

    fn power_signed(self, base: Residue, exponent: i64) -> Option<Residue> {
        let power = self.power(base, exponent.unsigned_abs());
        if exponent < 0 { self.recip(power) } else { Some(power) }
    }

    /// A square root of an element of the prime field.
    fn root(self, a: Residue) -> Option<Residue> {
        if a.im != 0 {
            return None;
        }
        let root_if_square = |a: u64| {
            let root = self.power_modulo(a, self.0.div_ceil(4));
            (self.multiply_modulo(root, root) == a).then_some(root)
        };
        match root_if_square(a.re) {
            Some(root) => Some(Residue { re: root, im: 0 }),
            None => root_if_square(self.negate_modulo(a.re)).map(|root| Residue { re: 0, im: root }),
        }
    }
}

/// The kind of a random number: equal keys give equal numbers at one point.
#[derive(Clone, Copy)]
enum RandomKind {
    Node = 1,
    Symbol,
    RootSign,
    Exponential,
    Angle,
    ErrorFunction,
    Bessel,
    Logarithm,
    Power,
}

/// One random point: every atom has a value that only depends on the seed.
struct Point<'a> {
    graph: &'a Graph,
    field: QuadraticExtension,
    seed: u64,
    /// Angles and exponents are multiples of this part of their summands.
    parts: i64,
}

impl Point<'_> {
    fn random(&self, atom: RandomKind, key: u64) -> u64 {
        let mut generator = SplitMix::new(self.seed.wrapping_mul(0xd134_2543_de82_ef95) ^ atom as u64);
        let mixed = generator.next() ^ key.wrapping_mul(0xa076_1d64_78bd_642f);
        SplitMix::new(mixed).next()
    }

    fn atom(&self, atom: RandomKind, key: u64) -> Residue {
        Residue { re: self.random(atom, key) % self.field.0, im: 0 }
    }

    /// The value of a node; conditions have none, since only opaque selections use them.
    fn node(&self, expr: Expr, node: &Node, value: &dyn Fn(Expr) -> Option<Residue>) -> Option<Residue> {
        let field = self.field;
        match node {
            Node::Number(number) => field.rational(*number),
            Node::Float(bits) => self.constant(f64::from_bits(*bits)),
            Node::Symbol(symbol) => Some(self.atom(RandomKind::Symbol, symbol.index() as u64)),
            Node::Sum { terms, constant } => {
                let mut sum = field.rational(*constant)?;
                for &(term, coefficient) in terms {
                    sum = field.add(sum, field.multiply(field.rational(coefficient)?, value(term)?));
                }
                Some(sum)
            }
            Node::Product(factors) => {
                let mut product = Residue::ONE;
                for &(base, exponent) in factors {
                    let power = match exponent.denominator() {
                        1 => field.power_signed(value(base)?, exponent.numerator())?,
                        _ => self.rational_power(PowerBase::Value(value(base)?), exponent)?,
                    };
                    product = field.multiply(product, power);
                }
                Some(product)
            }
            Node::Apply(Function::Sqrt, arguments) => self.root(value(arguments[0])?),
            Node::Apply(Function::Hypot, arguments) => {
                let [x, y] = [value(arguments[0])?, value(arguments[1])?].map(|x| field.multiply(x, x));
                self.root(field.add(x, y))
            }
            Node::Apply(Function::Special(special), arguments) => {
                self.special(*special, arguments[0], value(arguments[0])?)
            }
            Node::Apply(Function::Powf, arguments) => {
                let base = PowerBase::Value(value(arguments[0])?);
                self.power(base, &[(arguments[1], Rational::ONE)], Rational::ONE, value)
            }
            Node::Apply(Function::Exp2, arguments) => {
                let base = PowerBase::Value(field.integer(2));
                self.power(base, &[(arguments[0], Rational::ONE)], Rational::ONE, value)
            }
            Node::Apply(Function::Ln, arguments) => self.logarithm(value(arguments[0])?),
            Node::Apply(Function::Ln1p, arguments) => {
                self.logarithm(field.add(value(arguments[0])?, Residue::ONE))
            }
            Node::Apply(function @ (Function::Log2 | Function::Log10), arguments) => {
                let base = if *function == Function::Log2 { 2 } else { 10 };
                field.divide(self.logarithm(value(arguments[0])?)?, self.logarithm(field.integer(base))?)
            }
            Node::Apply(function, arguments) => self.function(expr, *function, arguments[0], value),
            Node::Select { .. } => match self.slope_of_power(node) {
                Some(slope) => value(slope),
                None => Some(self.atom(RandomKind::Node, expr.index() as u64)),
            },
            Node::Compare(..) | Node::Not(_) | Node::Join(..) => Some(Residue::ZERO),
        }
    }

    /// A constant. Logarithms of 2 and 10 to other bases are quotients of `ln 2` and `ln 10`, which have the
    /// roundings that derivatives have.
    fn constant(&self, value: f64) -> Option<Residue> {
        let field = self.field;
        let [ln_2, ln_10] = [field.float(LN_2)?, field.float(LN_10)?];
        match value {
            LOG2_E => field.recip(ln_2),
            LOG10_E => field.recip(ln_10),
            LOG2_10 => field.divide(ln_10, ln_2),
            LOG10_2 => field.divide(ln_2, ln_10),
            _ => field.float(value),
        }
    }

    /// The square root of a value, with a random sign: the same for equal values.
    fn root(&self, value: Residue) -> Option<Residue> {
        let root = self.field.root(value)?;
        let flips = self.random(RandomKind::RootSign, mix(value.re, value.im)) & (1 << 32) != 0;
        Some(if flips { self.field.negate(root) } else { root })
    }

    /// The second branch of `if y == 0 { 0 } else { y f }`, which has this value everywhere: the derivative
    /// of `x^y` by `x`.
    fn slope_of_power(&self, node: &Node) -> Option<Expr> {
        let &Node::Select { condition, then, otherwise } = node else { return None };
        let &Node::Compare(Relation::Equal, a, b) = self.graph.node(condition) else { return None };
        let exponent = if self.graph.is_zero(a) { b } else { a };
        let (_, exponent) = self.graph.as_multiple(exponent);
        let (_, slope) = self.graph.as_multiple(otherwise);
        let Node::Product(factors) = self.graph.node(slope) else { return None };
        let is_of_zero = [a, b].iter().any(|side| self.graph.is_zero(*side)) && self.graph.is_zero(then);
        (is_of_zero && factors.contains(&(exponent, Rational::ONE))).then_some(otherwise)
    }

    fn function(
        &self,
        expr: Expr,
        function: Function,
        argument: Expr,
        value: &dyn Fn(Expr) -> Option<Residue>,
    ) -> Option<Residue> {
        let field = self.field;
        let real = |re: u64| Residue { re, im: 0 };
        match function {
            Function::Sin => Some(real(self.rotation(argument)?.im)),
            Function::Cos => Some(real(self.rotation(argument)?.re)),
            Function::Tan => self.rotation(argument).and_then(|z| field.divide(real(z.im), real(z.re))),
            Function::Exp => self.exponential(argument, value),
            Function::ExpM1 => Some(field.subtract(self.exponential(argument, value)?, Residue::ONE)),
            Function::Sinh | Function::Cosh | Function::Tanh => {
                let growing = self.exponential(argument, value)?;
                let decaying = field.recip(growing)?;
                let (twice_sinh, twice_cosh) =
                    (field.subtract(growing, decaying), field.add(growing, decaying));
                match function {
                    Function::Sinh => field.divide(twice_sinh, field.integer(2)),
                    Function::Cosh => field.divide(twice_cosh, field.integer(2)),
                    _ => field.divide(twice_sinh, twice_cosh),
                }
            }
            _ => Some(self.atom(RandomKind::Node, expr.index() as u64)),
        }
    }

    /// A special function of `argument`, whose value is `x`: by `erf(-x) = -erf(x)`, `erfc = 1 - erf`, and by
    /// the recurrences `f_n = (2ν f_(n-1) - f_(n-2))/x²` of the families, down to sine and cosine, `j0` and
    /// `j1`.
    fn special(&self, special: Special, argument: Expr, x: Residue) -> Option<Residue> {
        let field = self.field;
        let opposite = field.negate(x);
        let is_below = (x.re, x.im) <= (opposite.re, opposite.im);
        let of_size = |size: Residue| mix(size.re, size.im);
        let size = of_size(if is_below { x } else { opposite });
        let square = field.multiply(x, x);
        let climb = |mut pair: [Residue; 2], from: u32, to: u32, twice: &dyn Fn(u32) -> u32| {
            for k in from..to {
                let leading = field.multiply(field.integer(twice(k).into()), pair[1]);
                pair = [pair[1], field.divide(field.subtract(leading, pair[0]), square)?];
            }
            Some(pair[1])
        };
        match special {
            Special::Erf | Special::Erfc => {
                let positive = self.atom(RandomKind::ErrorFunction, size);
                let erf = if is_below { positive } else { field.negate(positive) };
                Some(if special == Special::Erf { erf } else { field.subtract(Residue::ONE, erf) })
            }
            Special::Sinc(n) => {
                let turn = self.rotation(argument)?;
                let [sine, cosine] = [turn.im, turn.re].map(|re| Residue { re, im: 0 });
                // `f_(-1)` is the cosine.
                climb([cosine, field.divide(sine, x)?], 0, n, &|k| 2 * k + 1)
            }
            Special::Bessel(0) => Some(self.atom(RandomKind::Bessel, mix(size, 0))),
            Special::Bessel(n) => {
                let pair = [0, 1].map(|order| self.atom(RandomKind::Bessel, mix(size, order)));
                climb(pair, 1, n, &|k| 2 * k)
            }
        }
    }

    /// `ln` of a value: the same for equal values; ln 2 and ln 10 with the roundings that derivatives have.
    fn logarithm(&self, value: Residue) -> Option<Residue> {
        let rounded = [(2, LN_2), (10, LN_10)].into_iter().find(|(x, _)| self.field.integer(*x) == value);
        match rounded {
            Some((_, logarithm)) => self.field.float(logarithm),
            None => Some(self.atom(RandomKind::Logarithm, mix(value.re, value.im))),
        }
    }

    /// `exp(argument)`
    fn exponential(&self, argument: Expr, value: &dyn Fn(Expr) -> Option<Residue>) -> Option<Residue> {
        self.power(PowerBase::E, &[(argument, Rational::ONE)], Rational::ONE, value)
    }

    /// `base^(coefficient · Π factor)`: sums of exponents give products of powers.
    fn power(
        &self,
        base: PowerBase,
        factors: &[(Expr, Rational)],
        coefficient: Rational,
        value: &dyn Fn(Expr) -> Option<Residue>,
    ) -> Option<Residue> {
        for (at, &(factor, exponent)) in factors.iter().enumerate() {
            if exponent.is_one()
                && let Some(other) = self.base_of_logarithm(base, factor, value)
            {
                let rest = [&factors[..at], &factors[at + 1..]].concat();
                return self.power(other?, &rest, coefficient, value);
            }
        }
        match (factors, factors.first().map(|&(first, exponent)| (self.graph.node(first), exponent))) {
            ([], _) => self.rational_power(base, coefficient),
            ([_], Some((Node::Product(inner), Rational::ONE))) => self.power(base, inner, coefficient, value),
            ([(sum, _)], Some((Node::Sum { .. } | Node::Number(_), Rational::ONE))) => {
                let mut product = Residue::ONE;
                for (term, inner) in linear_terms(self.graph, *sum) {
                    let factors: Vec<_> = term.map(|term| (term, Rational::ONE)).into_iter().collect();
                    let power = self.power(base, &factors, inner.multiply(coefficient)?, value)?;
                    product = self.field.multiply(product, power);
                }
                Some(product)
            }
            _ => {
                let (key, count) = self.summand(key_of(factors), coefficient);
                let part = match base {
                    PowerBase::E => self.atom(RandomKind::Exponential, key),
                    PowerBase::Value(Residue { re, im }) => {
                        self.atom(RandomKind::Power, mix(mix(re, im), mix(key, 1)))
                    }
                };
                self.field.power_signed(part, count)
            }
        }
    }

    /// `x`, if `factor` is the logarithm of `x` to this base: `base^(y factor)` is `x^y`. The inner option is
    /// empty where `x` has no value.
    fn base_of_logarithm(
        &self,
        base: PowerBase,
        factor: Expr,
        value: &dyn Fn(Expr) -> Option<Residue>,
    ) -> Option<Option<PowerBase>> {
        let number = |value: i64| PowerBase::Value(self.field.integer(value));
        let (own, constants) = match base {
            PowerBase::E => (Function::Ln, [(LN_2, number(2)), (LN_10, number(10))]),
            _ if base == number(2) => (Function::Log2, [(LOG2_E, PowerBase::E), (LOG2_10, number(10))]),
            _ if base == number(10) => (Function::Log10, [(LOG10_E, PowerBase::E), (LOG10_2, number(2))]),
            PowerBase::Value(_) => return None,
        };
        match self.graph.node(factor) {
            Node::Apply(function, arguments) if *function == own => {
                Some(value(arguments[0]).map(PowerBase::Value))
            }
            Node::Float(bits) => {
                let known = constants.iter().find(|(constant, _)| *constant == f64::from_bits(*bits));
                known.map(|&(_, base)| Some(base))
            }
            _ => None,
        }
    }

    /// `base^(n/d)`, as an integer power of the base and one of its root of order `d`.
    fn rational_power(&self, base: PowerBase, exponent: Rational) -> Option<Residue> {
        let PowerBase::Value(base) = base else {
            let (key, count) = self.summand(u64::MAX, exponent);
            return self.field.power_signed(self.atom(RandomKind::Exponential, key), count);
        };
        let (field, n, d) = (self.field, exponent.numerator(), exponent.denominator());
        let root = match d {
            1 => Residue::ONE,
            2 => self.root(base)?,
            _ => self.atom(RandomKind::Power, mix(mix(base.re, base.im), mix(d as u64, 0))),
        };
        let whole = field.power_signed(base, n.div_euclid(d))?;
        Some(field.multiply(whole, field.power_signed(root, n.rem_euclid(d))?))
    }

    /// `cos + i sin` of the argument: `(1 + i τ) / (1 - i τ)`, a rational point of the circle, for each
    /// angle. A sum of angles is a product of rotations, so that addition theorems hold.
    fn rotation(&self, argument: Expr) -> Option<Residue> {
        linear_terms(self.graph, argument).into_iter().try_fold(
            Residue::ONE,
            |product, (term, coefficient)| {
                let key = term.map_or(u64::MAX, |term| term.index() as u64);
                let (key, count) = self.summand(key, coefficient);
                let tau = self.atom(RandomKind::Angle, key).re;
                let [above, below] = [tau, self.field.negate_modulo(tau)].map(|im| Residue { re: 1, im });
                let rotation = self.field.divide(above, below)?;
                Some(self.field.multiply(product, self.field.power_signed(rotation, count)?))
            },
        )
    }

    /// `coefficient · term` as a count of parts of the term, `f(n x / d) = f(x / parts)^count`. The key tells
    /// the term, and the denominator where it is no divisor of the number of parts.
    fn summand(&self, key: u64, coefficient: Rational) -> (u64, i64) {
        let (n, d) = (coefficient.numerator(), coefficient.denominator());
        let whole = (self.parts % d == 0).then(|| n.checked_mul(self.parts / d)).flatten();
        match whole {
            Some(count) => (mix(key, 0), count),
            None => (mix(key, d as u64), n),
        }
    }
}

/// The base of a power.
#[derive(Clone, Copy, PartialEq)]
enum PowerBase {
    /// `exp(1)`, which has no value of its own.
    E,
    Value(Residue),
}

/// A number for a product of powers.
fn key_of(factors: &[(Expr, Rational)]) -> u64 {
    factors.iter().fold(0, |key, &(base, exponent)| {
        let power = mix(exponent.numerator() as u64, exponent.denominator() as u64);
        mix(key, mix(base.index() as u64, power))
    })
}

/// A hash of a pair of numbers.
fn mix(a: u64, b: u64) -> u64 {
    let mixed = SplitMix::new(a).next();
    SplitMix::new(mixed ^ b.wrapping_mul(0xe703_7ed1_a0b4_28db)).next()
}
