//! Single rewrites: what they become, and where they could divide zero by zero.

use super::super::{Function, Graph, Rational, SymbolKind};

#[test]
fn a_common_factor_and_a_shared_constant_are_seen_through() {
    let mut graph = Graph::new();
    let [a, x, y] = ["a", "x", "y"].map(|name| {
        let symbol = graph.new_symbol(SymbolKind::Coordinate, name);
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
    let symbols = ["x", "y"].map(|name| graph.new_symbol(SymbolKind::Coordinate, name));
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
