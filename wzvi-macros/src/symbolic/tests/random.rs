//! Random expressions against independent evaluations: of the raw, uncanonical tree, and of dual numbers.
#![allow(clippy::unwrap_used)]

use std::collections::HashMap;

use crate::symbolic::evaluate::{Bounded, bound_function, bound_node, bound_power, multiply};
use crate::symbolic::residue::SplitMix;
use crate::symbolic::zero::ZeroTest;
use crate::symbolic::{
    Expr, Function, Graph, Junction, NAMES, Node, Rational, Relation, Special, Symbol, SymbolKind,
};

const COEFFICIENTS: [(i128, i128); 8] = [(1, 1), (-1, 1), (2, 1), (1, 2), (-3, 4), (1, 3), (5, 7), (-2, 1)];
const EXPONENTS: [(i128, i128); 8] = [(1, 1), (2, 1), (-1, 1), (3, 1), (-2, 1), (1, 2), (-1, 2), (1, 3)];

fn rational((numerator, denominator): (i128, i128)) -> Rational {
    Rational::new(numerator, denominator).unwrap()
}

/// One expression in two forms: its nodes as requested, and as returned by the constructors.
#[derive(Clone, Copy)]
struct Pair {
    raw: Expr,
    canonical: Expr,
}

struct Generator {
    graph: Graph,
    symbols: Vec<Symbol>,
    random: SplitMix,
    reals: Vec<Pair>,
    conditions: Vec<Pair>,
}

impl Generator {
    fn new(seed: u64) -> Self {
        let mut graph = Graph::new();
        let symbols: Vec<Symbol> =
            ["x", "y", "z"].map(|name| graph.new_symbol(SymbolKind::Coordinate, name)).into();
        let mut reals = Vec::new();
        for &symbol in &symbols {
            let leaf = graph.symbol(symbol);
            reals.push(Pair { raw: leaf, canonical: leaf });
        }
        for leaf in [graph.number(rational((3, 2))), graph.float(-std::f64::consts::PI), graph.integer(-1)] {
            reals.push(Pair { raw: leaf, canonical: leaf });
        }
        Self { graph, symbols, random: SplitMix::new(seed), reals, conditions: Vec::new() }
    }

    fn below(&mut self, bound: usize) -> usize {
        (self.random.next() % bound as u64) as usize
    }

    /// An operand, with a preference for recent ones.
    fn real(&mut self) -> Pair {
        let count = self.reals.len();
        let i = if self.below(2) == 0 { self.below(count) } else { count - 1 - self.below(count.min(4)) };
        self.reals[i]
    }

    fn weighted(&mut self, weights: &[(i128, i128)]) -> Vec<(Pair, Rational)> {
        (0..1 + self.below(3)).map(|_| (self.real(), rational(weights[self.below(weights.len())]))).collect()
    }

    fn sum(&mut self, operands: &[(Pair, Rational)], constant: Rational) -> Pair {
        let g = &mut self.graph;
        let terms = operands.iter().map(|&(pair, c)| (pair.raw, c)).collect();
        let raw = g.intern(Node::Sum { terms, constant });
        let mut terms: Vec<_> = operands.iter().map(|&(pair, c)| (pair.canonical, c)).collect();
        terms.push((g.integer(1), constant));
        Pair { raw, canonical: g.linear_combination(&terms) }
    }

    fn product(&mut self, operands: &[(Pair, Rational)]) -> Pair {
        let g = &mut self.graph;
        let raw = g.intern(Node::Product(operands.iter().map(|&(pair, e)| (pair.raw, e)).collect()));
        let factors: Vec<_> = operands.iter().map(|&(pair, e)| g.power(pair.canonical, e)).collect();
        Pair { raw, canonical: g.product(&factors) }
    }

    fn apply(&mut self, function: Function, arguments: &[Pair]) -> Pair {
        let g = &mut self.graph;
        let raw = g.intern(Node::Apply(function, arguments.iter().map(|pair| pair.raw).collect()));
        let arguments: Vec<_> = arguments.iter().map(|pair| pair.canonical).collect();
        Pair { raw, canonical: g.apply(function, &arguments) }
    }

    /// An argument inside the domain of `function`.
    fn friendly(&mut self, function: Function, x: Pair) -> Pair {
        let two = Rational::integer(2);
        match function {
            Function::Asin | Function::Acos | Function::Atanh => {
                let wave = self.apply(Function::Sin, &[x]);
                self.sum(&[(wave, rational((3, 4)))], Rational::ZERO)
            }
            Function::Sqrt
            | Function::Ln
            | Function::Log2
            | Function::Log10
            | Function::Acosh
            | Function::Powf => {
                let square = self.product(&[(x, two)]);
                self.sum(&[(square, Rational::ONE)], rational((9, 8)))
            }
            Function::Exp | Function::Exp2 | Function::ExpM1 | Function::Sinh | Function::Cosh => {
                self.apply(Function::Atan, &[x])
            }
            Function::Ln1p => self.apply(Function::Abs, &[x]),
            _ => x,
        }
    }

    fn step(&mut self) {
        let (a, b) = (self.real(), self.real());
        let pair = match self.below(16) {
            0..5 => {
                let operands = self.weighted(&COEFFICIENTS);
                let constant = [Rational::ZERO, Rational::ONE, rational((-2, 3))][self.below(3)];
                self.sum(&operands, constant)
            }
            5..9 => {
                let operands = self.weighted(&EXPONENTS);
                self.product(&operands)
            }
            9..14 => {
                let known = all_functions();
                let function = known[self.below(known.len())];
                let a = if self.below(8) == 0 { a } else { self.friendly(function, a) };
                if function.arity() == 1 { self.apply(function, &[a]) } else { self.apply(function, &[a, b]) }
            }
            14 => return self.condition(a, b),
            _ => {
                let Some(count) = self.conditions.len().checked_sub(1) else { return };
                let chosen = self.below(count + 1);
                let condition = self.conditions[chosen];
                let g = &mut self.graph;
                let raw = g.intern(Node::Select { condition: condition.raw, then: a.raw, otherwise: b.raw });
                Pair { raw, canonical: g.select(condition.canonical, a.canonical, b.canonical) }
            }
        };
        self.reals.push(pair);
    }

    fn condition(&mut self, a: Pair, b: Pair) {
        let relation = [Relation::Less, Relation::LessEqual, Relation::Equal][self.below(3)];
        let kind = self.below(4);
        let last = self.conditions.last().copied();
        let g = &mut self.graph;
        let pair = match (kind, last) {
            (1, Some(c)) => Pair { raw: g.intern(Node::Not(c.raw)), canonical: g.not(c.canonical) },
            (2 | 3, Some(c)) => {
                let junction = if kind == 2 { Junction::And } else { Junction::Or };
                let first = self.conditions[0];
                Pair {
                    raw: g.intern(Node::Join(junction, first.raw, c.raw)),
                    canonical: g.join(junction, first.canonical, c.canonical),
                }
            }
            _ => Pair {
                raw: g.intern(Node::Compare(relation, a.raw, b.raw)),
                canonical: g.compare(relation, a.canonical, b.canonical),
            },
        };
        self.conditions.push(pair);
    }

    /// Dyadic, so that sums of a few of them are exact.
    fn point(&mut self) -> Vec<f64> {
        self.symbols.clone().iter().map(|_| (self.below(4097) as f64 - 2048.0) / 1024.0).collect()
    }
}

fn agree(a: Bounded, b: Bounded) -> bool {
    !a.is_defined() || !b.is_defined() || (a.value - b.value).abs() <= a.error + b.error
}

#[test]
fn constructors_keep_values_and_invariants() {
    let mut compared = 0;
    for seed in 0..60 {
        let mut generator = Generator::new(seed);
        (0..40).for_each(|_| generator.step());
        let points: Vec<_> = (0..3).map(|_| generator.point()).collect();
        for Pair { raw, canonical } in generator.reals.iter().chain(&generator.conditions) {
            let g = &generator.graph;
            assert_eq!(g.validate(*canonical), Ok(()), "seed {seed}: {}", g.display(*raw));
            for point in &points {
                let values = g.evaluate_bounded(&[*raw, *canonical], &|symbol| point[symbol.index()]);
                let plain = g.evaluate(&[*raw, *canonical], &|symbol| point[symbol.index()]);
                let (from, to) = (g.display(*raw), g.display(*canonical));
                assert!(agree(values[0], values[1]), "seed {seed}: {from} -> {to}: {values:?}");
                if values[0].is_defined() {
                    assert!(!plain[1].is_nan(), "seed {seed} {point:?}: lost domain: {from} -> {to}");
                    assert_eq!(plain[0], values[0].value, "{from}");
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 2_000, "only {compared} comparisons");
}

#[derive(Clone, Copy)]
struct Dual {
    value: Bounded,
    slope: Bounded,
}

fn add(a: Bounded, b: Bounded) -> Bounded {
    Bounded::rounded(a.value + b.value, a.error + b.error, 1.0)
}

fn scale(a: Bounded, factor: f64) -> Bounded {
    multiply(a, Bounded::exact(factor))
}

fn power(a: Bounded, exponent: (i128, i128)) -> Bounded {
    bound_power(a, rational(exponent))
}

/// The functions of `f64`, and some of each kind that it does not have.
fn all_functions() -> Vec<Function> {
    let special = NAMES.iter().map(|&(.., special)| special);
    let special = special.chain([1, 2, 5].map(Special::Sinc)).chain([2, 6].map(Special::Bessel));
    Function::ALL.iter().copied().chain(special.map(Function::Special)).collect()
}

/// `(below(x) - factor value)/x`
fn lowered(below: Special, factor: f64, value: Bounded, x: Bounded) -> Bounded {
    let below = bound_function(Function::Special(below), &[x]);
    multiply(add(below, scale(value, -factor)), power(x, (-1, 1)))
}

/// Derivatives from tables, if possible in other forms than the compiler's.
fn function_slope(function: Function, value: Bounded, x: &[Dual]) -> Bounded {
    let one = Bounded::exact(1.0);
    let apply = |function, x| bound_function(function, &[x]);
    let Dual { value: u, slope: du } = x[0];
    let square = power(u, (2, 1));
    let complement = add(one, scale(square, -1.0));
    if let Some(&Dual { value: v, slope: dv }) = x.get(1) {
        let less = crate::symbolic::evaluate::bound_comparison(Relation::Less, u, v).decided();
        return match function {
            Function::Powf => {
                let relative = add(
                    multiply(multiply(v, power(u, (-1, 1))), du),
                    if dv.value == 0.0 { dv } else { multiply(apply(Function::Ln, u), dv) },
                );
                multiply(value, relative)
            }
            Function::Atan2 => {
                let radius = power(add(square, power(v, (2, 1))), (-1, 1));
                multiply(add(multiply(v, du), scale(multiply(u, dv), -1.0)), radius)
            }
            Function::Hypot => multiply(add(multiply(u, du), multiply(v, dv)), power(value, (-1, 1))),
            _ => match less {
                Some(less) if less == (function == Function::Min) => du,
                Some(_) => dv,
                None => Bounded::UNDEFINED,
            },
        };
    }
    let slope = match function {
        Function::Sqrt => scale(power(u, (-1, 2)), 0.5),
        Function::Cbrt => multiply(value, power(scale(u, 3.0), (-1, 1))),
        Function::Exp => apply(Function::Exp, u),
        Function::Exp2 => scale(value, std::f64::consts::LN_2),
        Function::ExpM1 => add(value, one),
        Function::Ln => power(u, (-1, 1)),
        Function::Ln1p => power(add(one, u), (-1, 1)),
        Function::Log2 => power(scale(u, std::f64::consts::LN_2), (-1, 1)),
        Function::Log10 => power(scale(u, std::f64::consts::LN_10), (-1, 1)),
        Function::Sin => apply(Function::Cos, u),
        Function::Cos => scale(apply(Function::Sin, u), -1.0),
        Function::Tan => power(apply(Function::Cos, u), (-2, 1)),
        Function::Asin => power(complement, (-1, 2)),
        Function::Acos => scale(power(complement, (-1, 2)), -1.0),
        Function::Atan => power(add(one, square), (-1, 1)),
        Function::Sinh => apply(Function::Cosh, u),
        Function::Cosh => apply(Function::Sinh, u),
        Function::Tanh => add(one, scale(power(value, (2, 1)), -1.0)),
        Function::Asinh => power(add(one, square), (-1, 2)),
        Function::Acosh => power(scale(complement, -1.0), (-1, 2)),
        Function::Atanh => power(complement, (-1, 1)),
        Function::Abs => apply(Function::Signum, u),
        Function::Special(special) => match special {
            Special::Erf | Special::Erfc => {
                let sign = if special == Special::Erf { 2.0 } else { -2.0 };
                let exponent = scale(power(u, (2, 1)), -1.0);
                scale(apply(Function::Exp, exponent), sign / std::f64::consts::PI.sqrt())
            }
            // (f_(n-1) - 2ν f_n)/x, in place of -x f_(n+1).
            Special::Sinc(0) => multiply(add(apply(Function::Cos, u), scale(value, -1.0)), power(u, (-1, 1))),
            Special::Sinc(n) => lowered(Special::Sinc(n - 1), f64::from(2 * n + 1), value, u),
            Special::Bessel(0) => scale(multiply(u, apply(Function::Special(Special::Bessel(1)), u)), -1.0),
            Special::Bessel(n) => lowered(Special::Bessel(n - 1), f64::from(2 * n), value, u),
        },
        _ => Bounded::exact(0.0),
    };
    multiply(slope, du)
}

/// The value and the derivative with respect to `along`, both with bounds.
fn dual(g: &Graph, expr: Expr, along: Symbol, values: &dyn Fn(Symbol) -> f64) -> Dual {
    let placeholder = Dual { value: Bounded::UNDEFINED, slope: Bounded::UNDEFINED };
    let rule = |_: Expr, node: &Node, of: &dyn Fn(Expr) -> Dual| {
        let value = bound_node(node, values, &|operand| of(operand).value);
        let zero = Bounded::exact(0.0);
        let slope = match node {
            Node::Symbol(symbol) if *symbol == along => Bounded::exact(1.0),
            Node::Sum { terms, .. } => terms.iter().fold(zero, |sum, &(term, c)| {
                add(sum, multiply(of(term).slope, crate::symbolic::evaluate::bound_number(c)))
            }),
            Node::Product(factors) => factors.iter().enumerate().fold(zero, |sum, (i, &(base, e))| {
                let others = factors.iter().enumerate().filter(|&(j, _)| j != i);
                let lower = e.add(Rational::MINUS_ONE).unwrap();
                let inner =
                    if lower.is_zero() { Bounded::exact(1.0) } else { bound_power(of(base).value, lower) };
                let own =
                    multiply(multiply(crate::symbolic::evaluate::bound_number(e), inner), of(base).slope);
                add(sum, others.fold(own, |p, (_, &(other, e))| multiply(p, bound_power(of(other).value, e))))
            }),
            Node::Apply(function, arguments) => {
                let arguments: Vec<_> = arguments.iter().map(|&argument| of(argument)).collect();
                function_slope(*function, value, &arguments)
            }
            Node::Select { condition, then, otherwise } => match of(*condition).value.decided() {
                Some(true) => of(*then).slope,
                Some(false) => of(*otherwise).slope,
                None => Bounded::UNDEFINED,
            },
            _ => zero,
        };
        Dual { value, slope }
    };
    g.fold(&[expr], placeholder, rule)[0]
}

#[test]
fn derivatives_agree_with_dual_numbers() {
    let mut compared = 0;
    for seed in 1000..1160 {
        let mut generator = Generator::new(seed);
        (0..25).for_each(|_| generator.step());
        let point = generator.point();
        let values = |symbol: Symbol| point[symbol.index()];
        let along = generator.symbols[0];
        for Pair { raw, canonical } in generator.reals.clone() {
            let g = &mut generator.graph;
            let derivative = g.derivative(canonical, along);
            assert_eq!(g.validate(derivative), Ok(()), "seed {seed}");
            let oracle = dual(g, raw, along, &values);
            let ours = g.evaluate_bounded(&[derivative], &values)[0];
            let (text, slope) = (g.display(canonical), g.display(derivative));
            assert!(
                agree(ours, oracle.slope),
                "seed {seed}: d/dx {text} = {slope}: {ours:?} {:?}",
                oracle.slope
            );
            compared +=
                usize::from(ours.is_defined() && oracle.slope.is_defined() && oracle.slope.value != 0.0);
        }
    }
    assert!(compared > 500, "only {compared} comparisons");
}

#[test]
fn every_function_has_its_derivative() {
    for function in all_functions() {
        let mut generator = Generator::new(7);
        let [x, y] = [generator.reals[0], generator.reals[1]];
        let friendly = generator.friendly(function, x);
        let arguments = if function.arity() == 1 { vec![friendly] } else { vec![friendly, y] };
        let Pair { raw, canonical } = generator.apply(function, &arguments);
        for along in generator.symbols.clone().into_iter().take(function.arity()) {
            for _ in 0..20 {
                let point = generator.point();
                let values = |symbol: Symbol| point[symbol.index()];
                let derivative = generator.graph.derivative(canonical, along);
                let ours = generator.graph.evaluate_bounded(&[derivative], &values)[0];
                let oracle = dual(&generator.graph, raw, along, &values).slope;
                assert!(ours.is_defined() && oracle.is_defined(), "{function:?} at {point:?}");
                assert!(agree(ours, oracle), "{function:?} at {point:?}: {ours:?} {oracle:?}");
                let tolerance = 1e-12 * ours.value.abs().max(1.0);
                assert!(ours.error < tolerance && oracle.error < tolerance, "{function:?}: a useless bound");
            }
        }
    }
}

#[test]
fn substitution_is_evaluation() {
    for seed in 2000..2060 {
        let mut generator = Generator::new(seed);
        (0..25).for_each(|_| generator.step());
        let point = generator.point();
        let [x, y] = [generator.symbols[0], generator.symbols[1]];
        let image = generator.sum(&[(generator.reals[1], Rational::integer(2))], rational((-1, 2))).canonical;
        let roots: Vec<_> = generator.reals.iter().map(|pair| pair.canonical).collect();
        let g = &mut generator.graph;
        let images = g.substitute(&roots, &HashMap::from([(x, image)]));
        let moved = 2.0 * point[y.index()] - 0.5;
        let before = g.evaluate_bounded(&roots, &|s| if s == x { moved } else { point[s.index()] });
        let after = g.evaluate_bounded(&images, &|s| point[s.index()]);
        for (i, root) in roots.iter().enumerate() {
            assert_eq!(g.validate(images[i]), Ok(()));
            assert!(!g.depends_on(images[i], &[x]), "{}", g.display(images[i]));
            assert!(
                agree(before[i], after[i]),
                "seed {seed}: {}: {:?} {:?}",
                g.display(*root),
                before[i],
                after[i]
            );
        }
    }
}

#[test]
fn raw_and_canonical_forms_differ_by_zero() {
    let mut decided = 0;
    for seed in 3000..3040 {
        let mut generator = Generator::new(seed);
        (0..15).for_each(|_| generator.step());
        for Pair { raw, canonical } in generator.reals.clone() {
            let terms = Box::from([(raw, Rational::ONE), (canonical, Rational::MINUS_ONE)]);
            let g = &mut generator.graph;
            let difference = g.intern(Node::Sum { terms, constant: Rational::ZERO });
            let answer = g.test_zero(difference);
            assert!(
                !matches!(answer, ZeroTest::Nonzero(_)),
                "seed {seed}: {} {answer:?}",
                g.display(difference)
            );
            decided += usize::from(answer == ZeroTest::Zero);
        }
    }
    assert!(decided > 300, "only {decided} decided");
}
