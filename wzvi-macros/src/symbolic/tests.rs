//! Invariants of the symbolic core.
#![allow(clippy::unwrap_used)]

use super::zero::ZeroTest;
use super::{Expr, Function, Graph, Rational, Symbol};

fn square(graph: &mut Graph, x: Expr) -> Expr {
    graph.power(x, Rational::integer(2))
}

fn symbols<const N: usize>(graph: &mut Graph, names: [&str; N]) -> ([Symbol; N], [Expr; N]) {
    let symbols = names.map(|name| graph.new_symbol(name));
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
