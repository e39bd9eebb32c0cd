//! The accuracy of the stable forms: errors before and after, in units in the last place of the exact value.
#![allow(clippy::unwrap_used, clippy::panic)]

use super::real::error_in_ulps;
use crate::symbolic::residue::SplitMix;
use crate::symbolic::{Expr, Function, Graph, Rational, SymbolKind};

/// Numbers of every size that a parameter or a state may have.
struct Inputs(SplitMix);

impl Inputs {
    fn below(&mut self, bound: u64) -> u64 {
        self.0.next() % bound
    }

    /// Uniform in [0, 1).
    fn fraction(&mut self) -> f64 {
        (self.0.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn sign(&mut self) -> f64 {
        if self.below(2) == 0 { 1.0 } else { -1.0 }
    }

    /// A number between `10^low` and `10^high`, uniform in its logarithm.
    fn sized(&mut self, low: f64, high: f64) -> f64 {
        self.sign() * 10.0_f64.powf(low + (high - low) * self.fraction())
    }

    /// Within a few units in the last place of `x`, or farther off by a random power of two.
    fn near(&mut self, x: f64) -> f64 {
        match self.below(3) {
            0 => f64::from_bits(x.to_bits().wrapping_add(self.below(9)).wrapping_sub(4)),
            _ => x * (1.0 + self.sign() * 2.0_f64.powi(-(self.below(52) as i32))),
        }
    }

    /// Ordinary, tiny, or close to a multiple of π/2, where trigonometric functions vanish.
    fn angle(&mut self) -> f64 {
        match self.below(4) {
            0 => self.sized(-150.0, 0.0),
            1 => self.sized(-12.0, 0.0),
            2 => 10.0 * self.sign() * self.fraction(),
            _ => {
                let multiple = self.below(9) as f64 * std::f64::consts::FRAC_PI_2;
                self.near(multiple)
            }
        }
    }
}

/// `text` of `x`, `y` and `a`, as operations of a graph.
fn expression(graph: &mut Graph, text: &syn::Expr, symbols: [Expr; 3]) -> Expr {
    let mut of = |text: &syn::Expr| expression(graph, text, symbols);
    match text {
        syn::Expr::Paren(inner) => of(&inner.expr),
        syn::Expr::Path(name) => {
            symbols[["x", "y", "a"].iter().position(|known| name.path.is_ident(known)).unwrap()]
        }
        syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Int(number), .. }) => {
            graph.integer(number.base10_parse().unwrap())
        }
        syn::Expr::Unary(minus) => {
            let inner = of(&minus.expr);
            graph.negate(inner)
        }
        syn::Expr::Binary(both) => {
            let (left, right) = (of(&both.left), of(&both.right));
            match both.op {
                syn::BinOp::Add(_) => graph.add(left, right),
                syn::BinOp::Sub(_) => graph.subtract(left, right),
                _ => graph.multiply(left, right),
            }
        }
        syn::Expr::MethodCall(call) => {
            let of_what = of(&call.receiver);
            match Function::ALL.iter().find(|function| call.method == function.method()) {
                Some(&function) => graph.apply(function, &[of_what]),
                None => power(graph, of_what, &call.args[0]),
            }
        }
        other => panic!("{}", quote::quote!(#other)),
    }
}

fn power(graph: &mut Graph, base: Expr, exponent: &syn::Expr) -> Expr {
    let syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Int(exponent), .. }) = exponent else {
        panic!("{}", quote::quote!(#exponent))
    };
    graph.power(base, Rational::integer(exponent.base10_parse().unwrap()))
}

/// One rewritten form: its original expression and the test points.
struct Form {
    text: &'static str,
    /// `x`, `y` and `a`.
    inputs: fn(&mut Inputs) -> [f64; 3],
    /// The largest error of the stable form in units in the last place: the roundings of its operations and
    /// calls, counted in the comment beside it.
    bound: f64,
}

impl Form {
    const fn new(text: &'static str, bound: f64, inputs: fn(&mut Inputs) -> [f64; 3]) -> Self {
        Self { text, inputs, bound }
    }

    fn written(&self, graph: &mut Graph, symbols: [Expr; 3]) -> Expr {
        expression(graph, &syn::parse_str(self.text).unwrap(), symbols)
    }
}

/// Squares of numbers below 1e-154 lose digits to gradual underflow in any form, so these are not tested.
///
/// Each call counts as one unit in the last place, which is two roundings; a square doubles the error of its
/// argument.
const FORMS: [Form; 20] = [
    Form::new("a - a * x.cos()", 6.0, |random| [random.angle(), 0.0, random.sized(-3.0, 3.0)]),
    Form::new("a + a * x.cos()", 6.0, |random| [random.angle(), 0.0, random.sized(-3.0, 3.0)]),
    Form::new("3 - x.cos() - 2 * y.cos()", 7.0, |random| [random.angle(), random.angle(), 0.0]),
    Form::new("a * x.cosh() - a", 6.0, |random| [random.sized(-150.0, 2.8), 0.0, random.sized(-3.0, 3.0)]),
    Form::new("a * x.exp() - a", 3.0, |random| [random.sized(-300.0, 2.8), 0.0, random.sized(-3.0, 3.0)]),
    Form::new("a * x.exp() - a * (-x).exp()", 3.0, |random| {
        [random.sized(-300.0, 2.8), 0.0, random.sized(-3.0, 3.0)]
    }),
    Form::new("a * x.exp() + a * (-x).exp() - 2 * a", 6.0, |random| {
        [random.sized(-150.0, 2.8), 0.0, random.sized(-3.0, 3.0)]
    }),
    Form::new("a * (-x).exp() - a * (-2 * x).exp()", 6.0, |random| {
        [random.sized(-300.0, 2.5), 0.0, random.sized(-3.0, 3.0)]
    }),
    Form::new("(1 + x).ln()", 1.5, |random| {
        let x = random.sized(-300.0, 300.0);
        [if x < -1.0 { 1.0 / x } else { x }, 0.0, 0.0]
    }),
    // Rounding x² = 1/2 moves the logarithm by as much as x² / ((1 - x²) ln(1 - x²)) = 1.44 of it.
    Form::new("(1 - x.powi(2)).ln()", 4.0, |random| {
        let x = if random.below(2) == 0 { random.sized(-150.0, 0.0) } else { random.near(1.0) };
        [if x.abs() >= 1.0 { 0.75 } else { x }, 0.0, 0.0]
    }),
    Form::new("(x + y).sqrt() - x.sqrt()", 4.0, |random| {
        let x = random.sized(-200.0, 200.0).abs();
        [x, x * random.sized(-20.0, 5.0).abs(), 0.0]
    }),
    Form::new("(1 + x).sqrt() - 1", 4.0, |random| {
        let x = random.sized(-300.0, 300.0);
        [if x < -1.0 { 1.0 / x } else { x }, 0.0, 0.0]
    }),
    Form::new("(x.powi(2) + a.powi(2)).sqrt() - a", 5.0, |random| {
        let a = random.sized(-50.0, 50.0);
        [a * random.sized(-20.0, 5.0), 0.0, a]
    }),
    Form::new("a * (1 + x.powi(2)).sqrt() - a", 6.0, |random| {
        [random.sized(-150.0, 150.0), 0.0, random.sized(-3.0, 3.0)]
    }),
    Form::new("a * x.powi(2) - a * y.powi(2)", 4.0, |random| {
        let x = random.sized(-140.0, 140.0);
        [x, random.near(x), random.sized(-3.0, 3.0)]
    }),
    Form::new("x.powi(4) - y.powi(4)", 7.0, |random| {
        let x = random.sized(-70.0, 70.0);
        [x, random.near(x), 0.0]
    }),
    Form::new("x.powi(2) - 1", 3.0, |random| [random.near(1.0), 0.0, 0.0]),
    Form::new("x.powi(3) - 4 * x", 4.0, |random| [random.near(2.0), 0.0, 0.0]),
    Form::new("a - a * x.cos().powi(2)", 6.0, |random| [random.angle(), 0.0, random.sized(-3.0, 3.0)]),
    Form::new("a - a * x.tanh().powi(2)", 8.0, |random| {
        [random.sized(-3.0, 2.5), 0.0, random.sized(-3.0, 3.0)]
    }),
];

/// Tries every form at this many points.
const TRIES: usize = 150;

/// Errors of the form as it is written and of the stable one, at every point where the exact value is one of
/// binary64.
fn measure(form: &Form) -> Vec<([f64; 3], f64, f64)> {
    let mut graph = Graph::new();
    let symbols = ["x", "y", "a"].map(|name| graph.new_symbol(SymbolKind::Coordinate, name));
    let leaves = symbols.map(|symbol| graph.symbol(symbol));
    let written = form.written(&mut graph, leaves);
    let stable = graph.stabilise(&[written])[0];
    assert_ne!(written, stable, "{} is left alone", form.text);
    let mut random = Inputs(SplitMix::new(7));
    let mut errors = Vec::new();
    for _ in 0..TRIES {
        let point = (form.inputs)(&mut random);
        let values = |symbol| point[symbols.iter().position(|&s| s == symbol).unwrap()];
        let Some(exact) = graph.evaluate_exactly(written, &values) else { continue };
        if exact.to_f64().is_finite() {
            let computed = graph.evaluate(&[written, stable], &values);
            errors.push((point, error_in_ulps(computed[0], &exact), error_in_ulps(computed[1], &exact)));
        }
    }
    errors
}

fn percentile(errors: impl Iterator<Item = f64>, percent: usize) -> f64 {
    let mut errors: Vec<f64> = errors.collect();
    errors.sort_by(f64::total_cmp);
    errors[(errors.len() - 1) * percent / 100]
}

/// Accurate to a few units in the last place at all test points, and nowhere worse than the original form by
/// more than that.
#[test]
fn stable_forms_are_right_to_a_few_units_in_the_last_place() {
    println!("{:36} {:>9} {:>9} {:>9} | {:>6} {:>6}", "", "typical", "90 %", "largest", "median", "largest");
    let mut failures = Vec::new();
    for form in &FORMS {
        let errors = measure(form);
        assert!(errors.len() > TRIES * 9 / 10, "{}: only {} points", form.text, errors.len());
        let before = |percent| percentile(errors.iter().map(|e| e.1), percent);
        let after = |percent| percentile(errors.iter().map(|e| e.2), percent);
        println!(
            "{:36} {:9.2e} {:9.2e} {:9.2e} | {:6.2} {:6.2}",
            form.text,
            before(50),
            before(90),
            before(100),
            after(50),
            after(100)
        );
        assert!(before(100) > 1000.0, "{}: no point where it matters", form.text);
        for &(point, before, after) in &errors {
            if after > form.bound {
                failures.push(format!("{} at {point:?}: {before} -> {after}", form.text));
            }
        }
    }
    assert!(
        failures.is_empty(),
        "{} points\n{}",
        failures.len(),
        failures[..failures.len().min(30)].join("\n")
    );
}

/// Random expressions around the forms of the table: their arguments, their surroundings and their
/// derivatives.
struct Expressions {
    graph: Graph,
    leaves: [Expr; 3],
    random: Inputs,
}

impl Expressions {
    fn new(seed: u64) -> (Self, [crate::symbolic::Symbol; 3]) {
        let mut graph = Graph::new();
        let symbols = ["x", "y", "a"].map(|name| graph.new_symbol(SymbolKind::Coordinate, name));
        let leaves = symbols.map(|symbol| graph.symbol(symbol));
        (Self { graph, leaves, random: Inputs(SplitMix::new(seed)) }, symbols)
    }

    fn leaf(&mut self) -> Expr {
        self.leaves[self.random.below(3) as usize]
    }

    /// An argument of a form.
    fn argument(&mut self) -> Expr {
        let (a, b) = (self.leaf(), self.leaf());
        let coefficient = [(1, 2), (2, 1), (-3, 1), (1, 3)][self.random.below(4) as usize];
        let g = &mut self.graph;
        match self.random.below(9) {
            0..3 => a,
            3 => g.add(a, b),
            4 => g.subtract(a, b),
            5 => g.multiply(a, b),
            6 => g.scale(a, Rational::new(coefficient.0, coefficient.1).unwrap()),
            7 => g.apply(Function::Sin, &[a]),
            _ => {
                let square = g.power(a, Rational::integer(2));
                let one = g.integer(1);
                g.add(one, square)
            }
        }
    }

    fn form(&mut self) -> Expr {
        let arguments = [self.argument(), self.argument(), self.argument()];
        let form = &FORMS[self.random.below(FORMS.len() as u64) as usize];
        form.written(&mut self.graph, arguments)
    }

    /// A form in a typical context.
    fn expression(&mut self, along: crate::symbolic::Symbol) -> Expr {
        let (form, other) = (self.form(), self.argument());
        let kind = self.random.below(8);
        let second = if kind == 3 { self.form() } else { other };
        let g = &mut self.graph;
        match kind {
            0 => form,
            1 => g.multiply(form, other),
            2 | 3 => g.add(form, second),
            4 => {
                let product = g.multiply(form, other);
                let tenth = Rational::new(1, 10).unwrap();
                g.linear_combination(&[(product, tenth), (other, Rational::ONE)])
            }
            5 => {
                let two = g.integer(2);
                let square = g.power(form, Rational::integer(2));
                let sum = g.add(two, square);
                g.apply(Function::Sqrt, &[sum])
            }
            _ => g.derivative(form, along),
        }
    }

    /// Numbers of all sizes, including neighbours.
    fn point(&mut self) -> [f64; 3] {
        let random = &mut self.random;
        let x = match random.below(6) {
            0 => [1e-9, 1e-160, 1e-300, 1e20, 1e75, -1.0, std::f64::consts::PI][random.below(7) as usize],
            1 => random.angle(),
            _ => random.sized(-10.0, 1.5),
        };
        let y = if random.below(2) == 0 { random.near(x) } else { random.sized(-10.0, 1.5) };
        let a = if random.below(3) == 0 { random.near(x) } else { random.sized(-3.0, 1.5) };
        [x, y, a]
    }
}

/// Points within a few units in the last place: one computed value may be accurate by chance, several are
/// not.
fn cluster(random: &mut Inputs, point: [f64; 3]) -> Vec<[f64; 3]> {
    (0..6).map(|_| point.map(|x| f64::from_bits((x.to_bits() & !7) | random.below(8)))).collect()
}

/// In a cluster of points, the largest error of the stable form is at most four times that of the form as it
/// is written, and `FEW` units in the last place: a difference of squares of inexact numbers doubles the
/// inherited error, the largest of six samples of a rounding error is at least half of its bound, and one
/// operation is replaced by a few.
#[test]
fn no_stable_form_is_worse_than_what_is_written() {
    const FEW: f64 = 8.0;
    let (mut compared, mut rewritten, mut better, mut failures) = (0, 0, 0, Vec::new());
    for seed in 0..300 {
        let (mut expressions, symbols) = Expressions::new(seed);
        let written = expressions.expression(symbols[0]);
        let stable = expressions.graph.stabilise(&[written])[0];
        if stable == written {
            continue;
        }
        rewritten += 1;
        for _ in 0..3 {
            let point = expressions.point();
            let (mut before, mut after) = (0.0_f64, 0.0_f64);
            for point in cluster(&mut expressions.random, point) {
                let values = |symbol| point[symbols.iter().position(|&s| s == symbol).unwrap()];
                let graph = &expressions.graph;
                let Some(exact) = graph.evaluate_exactly(written, &values) else { continue };
                let computed = graph.evaluate(&[written, stable], &values);
                if exact.to_f64().is_finite() {
                    before = before.max(error_in_ulps(computed[0], &exact));
                    after = after.max(error_in_ulps(computed[1], &exact));
                    compared += 1;
                }
            }
            better += usize::from(after < 0.5 * before);
            if after > 4.0 * before + FEW {
                let graph = &expressions.graph;
                failures.push(format!(
                    "seed {seed} at {point:?}: {before:.1} -> {after:.1}\n  {}\n  {}",
                    graph.display(written),
                    graph.display(stable)
                ));
            }
        }
    }
    println!(
        "{rewritten} expressions, {compared} points; at least twice as good in {better} of {} clusters",
        3 * rewritten
    );
    assert!(
        failures.is_empty(),
        "{} clusters\n{}",
        failures.len(),
        failures[..failures.len().min(12)].join("\n")
    );
    assert!(compared > 2000 && better > 85, "{compared} {better}");
}
