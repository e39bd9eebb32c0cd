//! Values in binary64: plain, and with a running bound on the rounding error.
//!
//! The bound is a forward analysis: an operation `f` of operands with errors `e_i` has the error
//! `Σ sup|∂_i f| e_i + (its own rounding)`, the supremum taken over the operands' intervals.
//!
//! Tests: `symbolic/tests/mod.rs`, `symbolic/tests/random.rs`.

use super::{Expr, Function, Graph, Junction, Node, Rational, Relation, Symbol};

/// Twice the unit roundoff, so that one `EPSILON` also covers the rounding of the bound itself.
const EPSILON: f64 = f64::EPSILON;
/// The largest error of an underflow.
const TINY: f64 = f64::MIN_POSITIVE;
/// Assumed error (in `EPSILON`) of one call into the mathematical library.
const LIBRARY: f64 = 8.0;

/// A computed value and a bound on its distance from the exact one.
///
/// Both are NaN if the exact value may not exist or a comparison is undecided.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounded {
    pub(crate) value: f64,
    pub(crate) error: f64,
}

impl Bounded {
    pub(crate) const UNDEFINED: Self = Self { value: f64::NAN, error: f64::NAN };

    pub(crate) const fn exact(value: f64) -> Self {
        Self { value, error: 0.0 }
    }

    /// `value` with an inherited `error` and `roundings` relative roundings of its own.
    pub(super) fn rounded(value: f64, error: f64, roundings: f64) -> Self {
        let error = error * (1.0 + 8.0 * EPSILON) + roundings * EPSILON * value.abs() + TINY;
        if value.is_finite() && error.is_finite() { Self { value, error } } else { Self::UNDEFINED }
    }

    pub(crate) fn is_defined(self) -> bool {
        self.value.is_finite() && self.error.is_finite()
    }

    /// Whether the exact value cannot be zero.
    pub(crate) fn excludes_zero(self) -> bool {
        self.is_defined() && self.value.abs() > self.error
    }

    fn truth(value: bool) -> Self {
        Self::exact(f64::from(u8::from(value)))
    }

    /// A condition: `None` if it is not decided.
    pub(super) fn decided(self) -> Option<bool> {
        self.is_defined().then_some(self.value != 0.0)
    }
}

impl Graph {
    /// The values of `roots` with a bound on the rounding error; conditions are 1 or 0, the values of the
    /// symbols are exact.
    pub(crate) fn evaluate_bounded(&self, roots: &[Expr], values: &dyn Fn(Symbol) -> f64) -> Vec<Bounded> {
        self.fold(roots, Bounded::UNDEFINED, |_, node, value| bound_node(node, values, value))
    }

    /// Applies `rule` to every node reachable from `roots`, operands first, and returns the results of the
    /// roots.
    pub(super) fn fold<T: Copy>(
        &self,
        roots: &[Expr],
        placeholder: T,
        mut rule: impl FnMut(Expr, &Node, &dyn Fn(Expr) -> T) -> T,
    ) -> Vec<T> {
        let size = roots.iter().map(|root| root.index() + 1).max().unwrap_or(0);
        let mut results = vec![placeholder; size];
        for expr in self.reachable(roots) {
            let result = rule(expr, self.node(expr), &|operand| results[operand.index()]);
            results[expr.index()] = result;
        }
        roots.iter().map(|root| results[root.index()]).collect()
    }
}

/// `base^exponent`; half-integer powers go through the square root, as in emitted code.
pub(super) fn power(base: f64, exponent: Rational) -> f64 {
    let numerator = i32::try_from(exponent.numerator());
    match (numerator, exponent.denominator()) {
        (Ok(n), 1) => base.powi(n),
        (Ok(n), 2) => base.sqrt().powi(n),
        _ => base.powf(exponent.to_f64()),
    }
}

pub(super) fn bound_node(
    node: &Node,
    values: &dyn Fn(Symbol) -> f64,
    value: &dyn Fn(Expr) -> Bounded,
) -> Bounded {
    match node {
        Node::Number(number) => bound_number(*number),
        Node::Float(bits) => Bounded::rounded(f64::from_bits(*bits), 0.0, 0.0),
        Node::Symbol(symbol) => match values(*symbol) {
            value if value.is_finite() => Bounded::exact(value),
            _ => Bounded::UNDEFINED,
        },
        Node::Sum { terms, constant } => terms.iter().fold(bound_number(*constant), |sum, &(term, c)| {
            let term = multiply(bound_number(c), value(term));
            Bounded::rounded(sum.value + term.value, sum.error + term.error, 1.0)
        }),
        Node::Product(factors) => factors
            .iter()
            .fold(Bounded::exact(1.0), |product, &(base, e)| multiply(product, bound_power(value(base), e))),
        Node::Apply(function, arguments) => {
            let arguments: Vec<Bounded> = arguments.iter().map(|&argument| value(argument)).collect();
            bound_function(*function, &arguments)
        }
        Node::Select { condition, then, otherwise } => match value(*condition).decided() {
            Some(true) => value(*then),
            Some(false) => value(*otherwise),
            None => Bounded::UNDEFINED,
        },
        Node::Compare(relation, a, b) => bound_comparison(*relation, value(*a), value(*b)),
        Node::Not(a) => value(*a).decided().map_or(Bounded::UNDEFINED, |a| Bounded::truth(!a)),
        Node::Join(junction, a, b) => {
            let (decisive, both) = (*junction == Junction::Or, [value(*a).decided(), value(*b).decided()]);
            match both {
                _ if both.contains(&Some(decisive)) => Bounded::truth(decisive),
                [Some(_), Some(_)] => Bounded::truth(!decisive),
                _ => Bounded::UNDEFINED,
            }
        }
    }
}

pub(super) fn bound_number(number: Rational) -> Bounded {
    let value = number.to_f64();
    if number.denominator().count_ones() == 1 {
        Bounded::exact(value)
    } else {
        Bounded::rounded(value, 0.0, 0.5)
    }
}

pub(super) fn multiply(a: Bounded, b: Bounded) -> Bounded {
    // A factor of exactly ±1 must not lose the exactness of the other.
    if a.error == 0.0 && a.value.abs() == 1.0 {
        return Bounded { value: a.value * b.value, ..b };
    }
    let error = a.value.abs() * b.error + b.value.abs() * a.error + a.error * b.error;
    Bounded::rounded(a.value * b.value, error, 1.0)
}

pub(super) fn bound_power(base: Bounded, exponent: Rational) -> Bounded {
    if exponent.is_one() {
        return base;
    }
    let Bounded { value: x, error } = base;
    let e = exponent.to_f64();
    let value = power(x, exponent);
    let (low, high) = (x.abs() - error, x.abs() + error);
    // `|e| at^(e-1) · error`, ordered so that no power underflows unless the result does.
    let spread = |at: f64| e.abs() * (at.powf(e) * (error / at) + TINY);
    let inherited = if error == 0.0 {
        0.0
    } else if exponent.is_integer() && !exponent.is_negative() {
        spread(high)
    } else if low > 0.0 && (x > 0.0 || exponent.is_integer()) {
        spread(low).max(spread(high))
    } else if !exponent.is_integer() && !exponent.is_negative() && x >= 0.0 {
        // The exact base is nonnegative (the power would not exist), so both powers are in [0, high^e].
        high.powf(e)
    } else {
        return Bounded::UNDEFINED;
    };
    let inexact_exponent = if exponent.denominator() > 2 { (e * x.abs().ln()).abs() } else { 0.0 };
    Bounded::rounded(value, inherited, LIBRARY + 2.0 * e.abs() + inexact_exponent)
}

pub(super) fn bound_comparison(relation: Relation, a: Bounded, b: Bounded) -> Bounded {
    if !a.is_defined() || !b.is_defined() {
        return Bounded::UNDEFINED;
    }
    let error = a.error + b.error;
    let gap = b.value - a.value;
    if error > 0.0 && gap.abs() <= error + EPSILON * gap.abs() + TINY {
        return Bounded::UNDEFINED;
    }
    Bounded::truth(relation.holds(&a.value, &b.value))
}

pub(super) fn bound_function(function: Function, arguments: &[Bounded]) -> Bounded {
    if arguments.iter().any(|argument| !argument.is_defined()) {
        return Bounded::UNDEFINED;
    }
    let values: Vec<f64> = arguments.iter().map(|argument| argument.value).collect();
    let value = function.evaluate(&values);
    let first = arguments[0];
    let propagated = match *arguments {
        [a, b] => propagate_binary(function, value, a, b),
        _ => propagate_unary(function, value, first.value, first.error),
    };
    let Some(error) = propagated else { return Bounded::UNDEFINED };
    match function {
        Function::Abs | Function::Min | Function::Max => Bounded::rounded(value, error, 0.0),
        Function::Signum => Bounded::exact(value),
        // The standard library composes these two from others: an inner rounding is amplified near the end of
        // the domain.
        Function::Acosh => Bounded::rounded(value, error + 4.0 * EPSILON, LIBRARY),
        Function::Atanh => {
            Bounded::rounded(value, error + 4.0 * EPSILON * (1.0 - first.value.abs()).recip(), LIBRARY)
        }
        Function::Special(special) => {
            Bounded::rounded(value, error + special.with_rounding(first.value).1, 0.0)
        }
        _ => Bounded::rounded(value, error, LIBRARY),
    }
}

/// `sup|f'| · error` around `x`; `None` where the interval leaves the domain.
fn propagate_unary(function: Function, value: f64, x: f64, error: f64) -> Option<f64> {
    if error == 0.0 {
        return Some(0.0);
    }
    let (low, high) = (x.abs() - error, x.abs() + error);
    let inside = |bound: f64| (bound > 0.0).then(|| error / bound);
    match function {
        Function::Sqrt if x - error > 0.0 => Some(error / (2.0 * (x - error).sqrt())),
        Function::Sqrt => (x >= 0.0).then(|| high.sqrt()),
        Function::Cbrt if low > 0.0 => Some(error / (3.0 * low.cbrt() * low.cbrt())),
        Function::Cbrt => Some(2.0 * error.cbrt()),
        Function::Exp => Some(value * error.exp_m1()),
        Function::Exp2 => Some(value * (error * std::f64::consts::LN_2).exp_m1()),
        Function::ExpM1 => Some(x.exp() * error.exp_m1()),
        Function::Ln => inside(x - error),
        Function::Ln1p => inside((1.0 + x) * (1.0 - EPSILON) - error),
        Function::Log2 => inside((x - error) * std::f64::consts::LN_2),
        Function::Log10 => inside((x - error) * std::f64::consts::LN_10),
        Function::Tan => {
            let cosine = x.cos().abs() - error;
            inside(cosine).map(|slope| slope / cosine)
        }
        Function::Asin | Function::Acos => inside(((1.0 - high) * (1.0 + high)).max(0.0).sqrt()),
        Function::Sin | Function::Cos | Function::Atan | Function::Tanh | Function::Asinh | Function::Abs => {
            Some(error)
        }
        Function::Sinh => Some(high.cosh() * error),
        Function::Cosh => Some(high.sinh() * error),
        Function::Acosh => inside(((x - error - 1.0).max(0.0) * (x - error + 1.0)).sqrt()),
        Function::Atanh if high < 1.0 => inside((1.0 - high) * (1.0 + high)),
        Function::Special(special) => Some(special.steepest(low, high) * error),
        Function::Signum if low > 0.0 => Some(0.0),
        _ => None,
    }
}

fn propagate_binary(function: Function, value: f64, a: Bounded, b: Bounded) -> Option<f64> {
    if a.error == 0.0 && b.error == 0.0 {
        return Some(0.0);
    }
    let distance = a.error.hypot(b.error);
    match function {
        Function::Powf => {
            let low = a.value - a.error;
            let relative = a.error / low;
            let exponent = b.value.abs() * relative + b.error * (a.value.ln().abs() + relative);
            (low > 0.0).then(|| value * exponent.exp_m1())
        }
        Function::Atan2 => {
            let radius = a.value.hypot(b.value);
            let crosses_the_cut = b.value - b.error <= 0.0 && a.error > 0.0 && a.value.abs() <= a.error;
            // Two directions whose vectors differ by δ < r enclose asin(δ/r) <= (π/2) δ/r.
            (!crosses_the_cut && distance < radius).then(|| 2.0 * distance / radius)
        }
        Function::Hypot => Some(distance),
        Function::Min | Function::Max => Some(a.error.max(b.error)),
        _ => None,
    }
}
