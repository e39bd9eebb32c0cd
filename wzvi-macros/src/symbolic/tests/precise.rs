//! High-precision values of expressions.

use std::collections::HashMap;

use super::real::{Real, exact, sufficient_precision};
use crate::symbolic::{Expr, Function, Graph, Junction, Node, Rational, Relation, Special, Symbol};

impl Graph {
    /// The value of `root` to at least 90 bits; `None` if it does not exist or cannot be determined.
    pub(crate) fn evaluate_exactly(&self, root: Expr, values: &dyn Fn(Symbol) -> f64) -> Option<Real> {
        let symbols = self.reachable(&[root]).into_iter().filter_map(|expr| self.as_symbol(expr));
        let bits = sufficient_precision(symbols.map(values));
        exact(bits, || self.evaluate_precisely(root, values))
    }

    fn evaluate_precisely(&self, root: Expr, values: &dyn Fn(Symbol) -> f64) -> Real {
        let mut results: HashMap<Expr, Real> = HashMap::new();
        for expr in self.reachable(&[root]) {
            let value = precise_node(self.node(expr), values, &|operand| &results[&operand]);
            results.insert(expr, value);
        }
        results[&root].clone()
    }
}

fn precise_number(value: Rational) -> Real {
    Real::from(value.numerator() as f64) / Real::from(value.denominator() as f64)
}

fn precise_node<'a>(node: &Node, values: &dyn Fn(Symbol) -> f64, value: &dyn Fn(Expr) -> &'a Real) -> Real {
    let truth = |holds: bool| Real::from(f64::from(u8::from(holds)));
    match node {
        Node::Number(number) => precise_number(*number),
        Node::Float(bits) => Real::from(f64::from_bits(*bits)),
        Node::Symbol(symbol) => Real::from(values(*symbol)),
        Node::Sum { terms, constant } => terms
            .iter()
            .fold(precise_number(*constant), |sum, &(term, c)| sum + precise_number(c) * value(term)),
        Node::Product(factors) => factors.iter().fold(Real::from(1.0), |product, &(base, exponent)| {
            product * precise_power(value(base), exponent)
        }),
        Node::Apply(function, arguments) => {
            let arguments: Vec<&Real> = arguments.iter().map(|&argument| value(argument)).collect();
            precise_function(*function, &arguments)
        }
        Node::Select { condition, then, otherwise } => {
            if value(*condition).is_zero() { value(*otherwise) } else { value(*then) }.clone()
        }
        Node::Compare(Relation::Less, a, b) => truth(value(*a) < value(*b)),
        Node::Compare(Relation::LessEqual, a, b) => truth(value(*a) <= value(*b)),
        Node::Compare(Relation::Equal, a, b) => truth(value(*a) == value(*b)),
        Node::Not(a) => truth(value(*a).is_zero()),
        Node::Join(Junction::And, a, b) => truth(!value(*a).is_zero() && !value(*b).is_zero()),
        Node::Join(Junction::Or, a, b) => truth(!value(*a).is_zero() || !value(*b).is_zero()),
    }
}

fn precise_power(base: &Real, exponent: Rational) -> Real {
    match exponent.denominator() {
        1 => base.powi(exponent.numerator()),
        2 => base.sqrt().powi(exponent.numerator()),
        _ => base.pow(&precise_number(exponent)),
    }
}

fn precise_function(function: Function, arguments: &[&Real]) -> Real {
    let x = arguments[0];
    let one = Real::from(1.0);
    match function {
        Function::Sqrt => x.sqrt(),
        Function::Cbrt => x.cbrt(),
        Function::Exp => x.exp(),
        Function::Exp2 => Real::from(2.0).pow(x),
        Function::ExpM1 => x.exp() - one,
        Function::Ln => x.ln(),
        Function::Ln1p => (one + x).ln(),
        Function::Log2 => x.log2(),
        Function::Log10 => x.log10(),
        Function::Sin => x.sin(),
        Function::Cos => x.cos(),
        Function::Tan => x.tan(),
        Function::Asin => x.asin(),
        Function::Acos => x.acos(),
        Function::Atan => x.atan(),
        Function::Sinh => x.sinh(),
        Function::Cosh => x.cosh(),
        Function::Tanh => x.tanh(),
        Function::Asinh => x.asinh(),
        Function::Acosh => x.acosh(),
        Function::Atanh => x.atanh(),
        Function::Abs => x.abs(),
        Function::Signum if x.is_negative() => -one,
        Function::Signum => one,
        Function::Powf => x.pow(arguments[1]),
        Function::Atan2 => precise_angle(x, arguments[1]),
        Function::Hypot => (x * x + arguments[1] * arguments[1]).sqrt(),
        Function::Min if arguments[1] < x => arguments[1].clone(),
        Function::Max if arguments[1] > x => arguments[1].clone(),
        Function::Min | Function::Max => x.clone(),
        Function::Special(special) => precise_special(special, x),
    }
}

/// Power series at zero: `erf(x) = 2/√π Σ_k x (-x²)^k/(k! (2k + 1))`, and
/// `f_n(x) = Σ_k f_n(0) Π_(j<=k) -x²/(2j (2j + 2ν))` (DLMF 7.6.1, 10.2.2).
fn precise_special(special: Special, x: &Real) -> Real {
    let one = Real::from(1.0);
    let square = x * x;
    let (n, half) = match special {
        Special::Erf => {
            // The terms `x (-x²)^k/k!`, each divided by `2k + 1`.
            let series =
                summed(x.clone(), |term, k| term * &square * -1.0 / Real::from(k), |k| 2.0 * k + 1.0);
            return series * 2.0 / Real::from(-1.0).acos().sqrt();
        }
        Special::Erfc => return one - precise_special(Special::Erf, x),
        Special::Sinc(n) => (f64::from(n), 1.0),
        Special::Bessel(n) => (f64::from(n), 0.0),
    };
    let at_zero = (1..=n as u32).fold(one, |value, k| value / Real::from(2.0 * f64::from(k) + half));
    let next = |term: Real, k: f64| term * &square * -1.0 / Real::from(2.0 * k * (2.0 * k + 2.0 * n + half));
    summed(at_zero, next, |_| 1.0)
}

/// `Σ_k term_k / divisor(k)` until terms are below all digits.
fn summed(first: Real, next: impl Fn(Real, f64) -> Real, divisor: impl Fn(f64) -> f64) -> Real {
    let (mut sum, mut term, mut k) = (Real::from(0.0), first, 0.0);
    loop {
        let added = &term / &Real::from(divisor(k));
        let is_below = match (added.exponent(), sum.exponent()) {
            (None, _) => true,
            (Some(added), Some(sum)) => added < sum - 6000,
            _ => false,
        };
        if is_below {
            return sum;
        }
        sum = sum + added;
        k += 1.0;
        term = next(term, k);
    }
}

/// The angle of the point (x, y), by the half-angle formula away from the negative axis.
fn precise_angle(y: &Real, x: &Real) -> Real {
    let radius = (x * x + y * y).sqrt();
    let pi = Real::from(-1.0).acos();
    match (x.is_negative(), y.is_zero()) {
        (false, true) => Real::from(0.0),
        (true, true) => pi,
        (false, false) => (y / (radius + x)).atan() * 2.0,
        // atan2(y, x) = ±π - atan2(y, -x)
        (true, false) => {
            let mirrored = (y / (radius - x)).atan() * 2.0;
            if y.is_negative() { -pi - mirrored } else { pi - mirrored }
        }
    }
}
