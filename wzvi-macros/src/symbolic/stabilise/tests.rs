//! Single rewrites, at points where the original form loses its digits.

use super::super::{Expr, Function, Graph, Rational, Symbol};

fn value(graph: &Graph, expr: Expr, x: Symbol, at: f64) -> f64 {
    graph.evaluate(&[expr], &|symbol| if symbol == x { at } else { 2.0 })[0]
}

/// The stable form of `build(x)` has the value `exact` at `at`, to three roundings.
fn keeps_digits(build: impl Fn(&mut Graph, Expr) -> Expr, at: f64, exact: f64) {
    let mut graph = Graph::new();
    let symbol = graph.new_symbol("x");
    let x = graph.symbol(symbol);
    let written = build(&mut graph, x);
    let stable = graph.stabilise(&[written])[0];
    let got = value(&graph, stable, symbol, at);
    let error = (got - exact).abs() / exact.abs();
    assert!(error <= 3.0 * f64::EPSILON, "{}: {got} instead of {exact}", graph.display(stable));
    let naive = value(&graph, written, symbol, at);
    assert!(
        (naive - exact).abs() > 100.0 * f64::EPSILON * exact.abs(),
        "{} is no test",
        graph.display(written)
    );
}

#[test]
fn small_differences_keep_their_digits() {
    let one = |graph: &mut Graph| graph.integer(1);
    // Taylor series: the next term is below rounding at these points.
    let x = 1e-5_f64;
    keeps_digits(
        |graph, x| {
            let (one, cosine) = (one(graph), graph.apply(Function::Cos, &[x]));
            graph.subtract(one, cosine)
        },
        x,
        x * x / 2.0 * (1.0 - x * x / 12.0),
    );
    keeps_digits(
        |graph, x| {
            let (one, cosine) = (one(graph), graph.apply(Function::Cosh, &[x]));
            graph.subtract(cosine, one)
        },
        x,
        x * x / 2.0 * (1.0 + x * x / 12.0),
    );
    keeps_digits(
        |graph, x| {
            let (one, exponential) = (one(graph), graph.apply(Function::Exp, &[x]));
            graph.subtract(exponential, one)
        },
        x,
        x + x * x / 2.0 + x * x * x / 6.0 + x * x * x * x / 24.0,
    );
    keeps_digits(
        |graph, x| {
            let one = one(graph);
            let sum = graph.add(one, x);
            graph.apply(Function::Ln, &[sum])
        },
        x,
        x - x * x / 2.0 + x * x * x / 3.0 - x * x * x * x / 4.0,
    );
    keeps_digits(
        |graph, x| {
            let one = one(graph);
            let sum = graph.add(one, x);
            let root = graph.apply(Function::Sqrt, &[sum]);
            graph.subtract(root, one)
        },
        x,
        x / 2.0 - x * x / 8.0 + x * x * x / 16.0 - 5.0 / 128.0 * x * x * x * x,
    );
    keeps_digits(
        |graph, x| {
            let (one, square) = (one(graph), graph.power(x, Rational::integer(2)));
            graph.subtract(square, one)
        },
        1.0 + 2.0_f64.powi(-30),
        2.0_f64.powi(-29) + 2.0_f64.powi(-60),
    );
}

#[test]
fn a_common_factor_and_a_shared_constant_are_seen_through() {
    let mut graph = Graph::new();
    let [a, x, y] = ["a", "x", "y"].map(|name| {
        let symbol = graph.new_symbol(name);
        graph.symbol(symbol)
    });
    let [cos_x, cos_y] = [x, y].map(|angle| graph.apply(Function::Cos, &[angle]));
    let product = graph.multiply(a, cos_x);
    let difference = graph.subtract(a, product);
    let stable = graph.stabilise(&[difference])[0];
    assert_eq!(graph.display(stable), "2 a sin(x/2)²");
    let two = graph.integer(2);
    let minus = Rational::MINUS_ONE;
    let both = graph.linear_combination(&[(two, Rational::ONE), (cos_x, minus), (cos_y, minus)]);
    let stable = graph.stabilise(&[both])[0];
    assert_eq!(graph.display(stable), "2 sin(x/2)² + 2 sin(y/2)²");
}

#[test]
fn roots_that_may_both_vanish_do_not_become_zero_over_zero() {
    let mut graph = Graph::new();
    let symbols = ["x", "y"].map(|name| graph.new_symbol(name));
    let [x, y] = symbols.map(|symbol| graph.symbol(symbol));
    let sum = graph.add(x, y);
    let [first, second] = [sum, x].map(|radicand| graph.apply(Function::Sqrt, &[radicand]));
    let difference = graph.subtract(first, second);
    let stable = graph.stabilise(&[difference])[0];
    assert_ne!(stable, difference);
    assert_eq!(graph.evaluate(&[stable], &|_| 0.0), [0.0]);
    let at = |symbol| if symbol == symbols[0] { 1e16 } else { 1.0 };
    assert_eq!(graph.evaluate(&[stable], &at), [1.0 / (1e8 + 1e8)]);
}
