//! Invariants of the symbolic core.
#![allow(clippy::unwrap_used, clippy::panic)]

mod accuracy;
pub(crate) mod effort;
mod evaluate;
mod precise;
mod random;
mod real;
mod validate;

use crate::symbolic::zero::ZeroTest;
use crate::symbolic::{Expr, Function, Graph, Rational, Symbol, SymbolKind};

fn square(graph: &mut Graph, x: Expr) -> Expr {
    graph.power(x, Rational::integer(2))
}

fn symbols<const N: usize>(graph: &mut Graph, names: [&str; N]) -> ([Symbol; N], [Expr; N]) {
    let symbols = names.map(|name| graph.new_symbol(SymbolKind::Coordinate, name));
    (symbols, symbols.map(|symbol| graph.symbol(symbol)))
}

#[test]
fn identities_vanish() {
    let mut g = Graph::new();
    let (_, [a, b]) = symbols(&mut g, ["a", "b"]);
    let one = g.integer(1);
    let pythagoras = |g: &mut Graph, c, s, sign: Rational| {
        let (c, s) = (g.apply(c, &[a]), g.apply(s, &[a]));
        let (c, s) = (square(g, c), square(g, s));
        g.linear_combination(&[(c, Rational::ONE), (s, sign), (one, Rational::MINUS_ONE)])
    };
    let circle = pythagoras(&mut g, Function::Cos, Function::Sin, Rational::ONE);
    let hyperbola = pythagoras(&mut g, Function::Cosh, Function::Sinh, Rational::MINUS_ONE);
    assert_eq!(g.test_zero(circle), ZeroTest::Zero);
    assert_eq!(g.test_zero(hyperbola), ZeroTest::Zero);

    let (sum, product, aa, bb) = (g.add(a, b), g.multiply(a, b), square(&mut g, a), square(&mut g, b));
    let binomial = square(&mut g, sum);
    let minus = Rational::MINUS_ONE;
    let binomial = g.linear_combination(&[
        (binomial, Rational::ONE),
        (aa, minus),
        (bb, minus),
        (product, Rational::integer(-2)),
    ]);
    assert_eq!(g.test_zero(binomial), ZeroTest::Zero);
}

#[test]
fn equal_expressions_have_one_handle() {
    let mut g = Graph::new();
    let (_, [a, b, c]) = symbols(&mut g, ["a", "b", "c"]);
    assert_eq!(g.add(a, b), g.add(b, a));
    let (ab, bc) = (g.add(a, b), g.add(b, c));
    assert_eq!(g.add(ab, c), g.add(a, bc));
    let (ab, bc) = (g.multiply(a, b), g.multiply(b, c));
    assert_eq!(g.multiply(ab, c), g.multiply(a, bc));
    let aa = square(&mut g, a);
    assert_eq!(g.multiply(a, aa), g.power(a, Rational::integer(3)));
    let nothing = g.subtract(a, a);
    assert!(g.is_zero(nothing));
    let quotient = g.divide(a, a);
    assert!(!g.is_one(quotient));

    let root = g.apply(Function::Sqrt, &[a]);
    assert_ne!(square(&mut g, root), a);
    let one = g.integer(1);
    let positive = g.add(one, aa);
    let root = g.apply(Function::Sqrt, &[positive]);
    assert_eq!(square(&mut g, root), positive);
    assert_eq!(g.divide(positive, root), root);

    // `√(a² b²)²` opens into the product around it.
    let bb = square(&mut g, b);
    let product = g.multiply(aa, bb);
    let root = g.power(product, Rational::HALF);
    assert_eq!(g.product(&[c, root, root]), g.product(&[c, a, b, a, b]));
}

#[test]
fn what_leaves_the_exact_range_stays_exact() {
    let mut g = Graph::new();
    let (_, [x]) = symbols(&mut g, ["x"]);
    let large = Rational::new((1 << 53) - 1, 1).unwrap();
    let once = g.scale(x, large);
    let (twice, constant) = (g.scale(once, large), g.number(large));
    let sum = g.sum(&[constant, constant, twice]);
    assert_eq!(g.validate(sum), Ok(()));
    let product = g.product(&[constant, constant, x]);
    let difference = g.linear_combination(&[(sum, Rational::ONE), (product, Rational::MINUS_ONE)]);
    let difference = g.linear_combination(&[(difference, Rational::ONE), (constant, Rational::integer(-2))]);
    assert_eq!(g.validate(difference), Ok(()));
    assert_eq!(g.test_zero(difference), ZeroTest::Zero);
}

/// `{f, h} = f_p · h_q - f_q · h_p`
fn bracket(g: &mut Graph, f: Expr, h: Expr, q: &[Symbol], p: &[Symbol]) -> Expr {
    let mut terms = Vec::new();
    for (&q, &p) in q.iter().zip(p) {
        let [fp, hq, fq, hp] = [(f, p), (h, q), (f, q), (h, p)].map(|(f, s)| g.derivative(f, s));
        terms.extend([(g.multiply(fp, hq), Rational::ONE), (g.multiply(fq, hp), Rational::MINUS_ONE)]);
    }
    g.linear_combination(&terms)
}

#[test]
fn kepler_conserves_the_angular_momentum() {
    let mut g = Graph::new();
    let ([x, y, px, py, ..], [qx, qy, ux, uy, k]) = symbols(&mut g, ["x", "y", "px", "py", "k"]);
    let [xx, yy, uu, vv] = [qx, qy, ux, uy].map(|e| square(&mut g, e));
    let (rr, kinetic) = (g.add(xx, yy), g.add(uu, vv));
    let radius = g.apply(Function::Sqrt, &[rr]);
    let potential = g.divide(k, radius);
    let hamiltonian = g.linear_combination(&[(kinetic, Rational::HALF), (potential, Rational::MINUS_ONE)]);
    let (left, right) = (g.multiply(qx, uy), g.multiply(qy, ux));
    let momentum = g.subtract(left, right);
    let commutator = bracket(&mut g, momentum, hamiltonian, &[x, y], &[px, py]);
    assert_eq!(g.test_zero(commutator), ZeroTest::Zero, "{}", g.display(commutator));

    let wrong = g.add(left, right);
    let commutator = bracket(&mut g, wrong, hamiltonian, &[x, y], &[px, py]);
    let ZeroTest::Nonzero(witness) = g.test_zero(commutator) else { panic!("{}", g.display(commutator)) };
    let value = |s| witness.point.iter().find(|&&(known, _)| known == s).unwrap().1;
    assert_eq!(g.evaluate(&[commutator], &value), [witness.value]);
}

/// `d/dt f(a, b) = ∂f/∂a a' + ∂f/∂b b'`, with velocities that read the variables themselves.
#[test]
fn a_rate_is_the_sum_of_slopes_times_velocities() {
    let mut g = Graph::new();
    let ([a, b], [x, y]) = symbols(&mut g, ["a", "b"]);
    let (xx, yy) = (square(&mut g, x), square(&mut g, y));
    let radius = g.sum(&[xx, yy]);
    let radius = g.apply(Function::Sqrt, &[radius]);
    let product = g.multiply(x, y);
    let wave = g.apply(Function::Sin, &[product]);
    let value = g.divide(wave, radius);
    let velocities = [(a, wave), (b, xx)];
    let rate = g.rate(value, &velocities.into_iter().collect());
    let terms = velocities.map(|(symbol, velocity)| {
        let slope = g.derivative(value, symbol);
        g.multiply(slope, velocity)
    });
    let sum = g.sum(&terms);
    let difference = g.subtract(rate, sum);
    assert_eq!(g.test_zero(difference), ZeroTest::Zero);
    assert!(!g.is_zero(rate));
}

#[test]
fn addition_theorems_vanish() {
    let mut g = Graph::new();
    let (_, [a, b]) = symbols(&mut g, ["a", "b"]);
    let sum = g.linear_combination(&[(a, Rational::integer(2)), (b, Rational::MINUS_ONE)]);
    let double = g.scale(a, Rational::integer(2));
    let [whole, sa, ca] = [(Function::Sin, sum), (Function::Sin, double), (Function::Cos, double)]
        .map(|(f, x)| g.apply(f, &[x]));
    let (sb, cb) = (g.apply(Function::Sin, &[b]), g.apply(Function::Cos, &[b]));
    let (first, second) = (g.multiply(sa, cb), g.multiply(ca, sb));
    let difference = g.linear_combination(&[
        (whole, Rational::ONE),
        (first, Rational::MINUS_ONE),
        (second, Rational::ONE),
    ]);
    assert_eq!(g.test_zero(difference), ZeroTest::Zero);
    let [e, ea, eb] = [sum, double, b].map(|x| g.apply(Function::Exp, &[x]));
    let product = g.multiply(e, eb);
    let difference = g.subtract(product, ea);
    assert_eq!(g.test_zero(difference), ZeroTest::Zero);
}

#[test]
fn roots_vanish_only_on_both_branches() {
    let mut g = Graph::new();
    let (_, [a, b]) = symbols(&mut g, ["a", "b"]);
    let (ra, rb) = (g.apply(Function::Sqrt, &[a]), g.apply(Function::Sqrt, &[b]));
    let (plus, minus) = (g.add(ra, rb), g.subtract(ra, rb));
    let product = g.multiply(plus, minus);
    let difference =
        g.linear_combination(&[(product, Rational::ONE), (a, Rational::MINUS_ONE), (b, Rational::ONE)]);
    assert_eq!(g.test_zero(difference), ZeroTest::Zero);

    // `√(a²) - a` is zero for positive `a` only.
    let aa = square(&mut g, a);
    let magnitude = g.apply(Function::Sqrt, &[aa]);
    let difference = g.subtract(magnitude, a);
    let ZeroTest::Nonzero(witness) = g.test_zero(difference) else { panic!() };
    assert!(witness.point[0].1 < 0.0);
    // So small that rounding hides it: undecided, but never "zero".
    let epsilon = g.float(1e-20);
    let hidden = g.multiply(epsilon, difference);
    let one = g.integer(1);
    let shifted = g.add(one, hidden);
    let shifted = square(&mut g, shifted);
    let hidden = g.subtract(shifted, one);
    assert_ne!(g.test_zero(hidden), ZeroTest::Zero);
}

#[test]
fn small_differences_are_never_zero() {
    let mut g = Graph::new();
    let (_, [x, y]) = symbols(&mut g, ["x", "y"]);
    let tiny = g.float(1e-20);
    let tiny = g.multiply(tiny, y);
    let sum = g.add(x, tiny);
    let difference = g.subtract(sum, x);
    assert!(matches!(g.test_zero(difference), ZeroTest::Nonzero(_)));
    let (left, right) = (square(&mut g, sum), square(&mut g, x));
    let difference = g.subtract(left, right);
    assert_ne!(g.test_zero(difference), ZeroTest::Zero);
    // Zero modulo 2^61 - 1.
    let power = g.float((1u64 << 61) as f64);
    let multiple = g.multiply(power, x);
    let difference = g.subtract(multiple, x);
    assert!(matches!(g.test_zero(difference), ZeroTest::Nonzero(_)));
}

#[test]
fn unknown_identities_stay_unknown() {
    let mut g = Graph::new();
    let (_, [x]) = symbols(&mut g, ["x"]);
    // ln(exp(x)) - x is zero, but the test does not know inverse functions.
    let e = g.apply(Function::Exp, &[x]);
    let logarithm = g.apply(Function::Ln, &[e]);
    let difference = g.subtract(logarithm, x);
    assert_eq!(g.test_zero(difference), ZeroTest::Unknown);
    // One opaque function on both sides is enough.
    let (product, xx) = (g.multiply(logarithm, x), square(&mut g, logarithm));
    let sum = g.add(logarithm, x);
    let sum = g.multiply(sum, logarithm);
    let difference = g.linear_combination(&[
        (sum, Rational::ONE),
        (product, Rational::MINUS_ONE),
        (xx, Rational::MINUS_ONE),
    ]);
    assert_eq!(g.test_zero(difference), ZeroTest::Zero);
}

const LINKS: usize = 10_000;
/// The most nodes that an operation below visits per link of the chain: 102 for the derivative of a sum. A
/// quadratic algorithm would visit 10 000.
const NODES_OF_LINK: u64 = 120;

fn check_linear(what: &str, nodes: u64) {
    println!("{what}: {:.1} nodes per link", nodes as f64 / LINKS as f64);
    assert!(nodes <= NODES_OF_LINK * LINKS as u64, "{what}: {nodes} nodes");
}

/// Builds, differentiates, substitutes and evaluates a long chain.
fn deep(link: impl Fn(&mut Graph, Expr, usize) -> Expr) {
    let mut g = Graph::new();
    let ([s], [x]) = symbols(&mut g, ["x"]);
    let (nodes, chain) = effort::of(|| (0..LINKS).fold(x, |chain, i| link(&mut g, chain, i)));
    check_linear("build", nodes);
    let (nodes, slope) = effort::of(|| g.derivative(chain, s));
    check_linear("differentiate", nodes);
    check_linear("evaluate", effort::of(|| g.evaluate(&[chain, slope], &|_| 0.5)).0);
    let two = g.integer(2);
    let substituted = std::collections::HashMap::from([(s, two)]);
    check_linear("substitute", effort::of(|| g.substitute(&[chain], &substituted)).0);
    check_linear("display", effort::of(|| g.display(slope)).0);
    check_linear("test", effort::of(|| g.test_zero(chain)).0);
}

#[test]
fn deep_sines_are_linear() {
    deep(|g, chain, _| g.apply(Function::Sin, &[chain]));
}

#[test]
fn deep_sums_are_linear() {
    let mut g = Graph::new();
    let symbols: Vec<_> = (0..LINKS).map(|i| g.new_symbol(SymbolKind::Coordinate, format!("x{i}"))).collect();
    let (nodes, chain) = effort::of(|| {
        symbols.iter().fold(g.integer(1), |chain, &symbol| {
            let x = g.symbol(symbol);
            g.add(chain, x)
        })
    });
    check_linear("a sum of symbols", nodes);
    assert!(g.depends_on(chain, &symbols[..1]));
    deep(|g, chain, i| {
        let x = g.integer(i as i32);
        let shifted = g.add(chain, x);
        let root = g.apply(Function::Atan, &[shifted]);
        g.add(chain, root)
    });
}

#[test]
fn bounds_survive_large_intermediate_values() {
    let mut g = Graph::new();
    let (_, [x]) = symbols(&mut g, ["x"]);
    let third = g.scale(x, Rational::THIRD);
    let cosine = g.apply(Function::Cosh, &[third]);
    let inverse = g.power(cosine, Rational::MINUS_ONE);
    // cosh(630) = 1e273 is finite, its square is not; the rounding of the argument is amplified 630 times.
    let bounded = g.evaluate_bounded(&[inverse], &|_| 1890.5)[0];
    assert!(bounded.error > 100.0 * f64::EPSILON * bounded.value && bounded.excludes_zero(), "{bounded:?}");
}

#[test]
fn the_slope_of_a_power_of_a_root_exists_at_zero() {
    let mut graph = Graph::new();
    let symbol = graph.new_symbol(SymbolKind::Coordinate, "x");
    let x = graph.symbol(symbol);
    for (exponent, slopes) in [((3, 2), [0.0, 3.0]), ((5, 2), [0.0, 20.0])] {
        let power = graph.power(x, Rational::new(exponent.0, exponent.1).unwrap());
        let slope = graph.derivative(power, symbol);
        let at = |x: f64| graph.evaluate(&[slope], &|_| x)[0];
        assert_eq!([at(0.0), at(4.0)], slopes, "{}", graph.display(slope));
    }
}
