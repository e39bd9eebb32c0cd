//! Facts that are proven of closures, whatever the spelling.

use std::collections::HashMap;

use super::drift;
use crate::compile::expand;
use crate::symbolic::{Node, ZeroTest};

#[test]
fn identities_of_roots_and_angles_are_known() {
    let zero = [
        "x.hypot(y).powi(2) - x * x - y * y",
        "x.hypot(y) - (x * x + y * y).sqrt()",
        "x.hypot(y) * x / x.hypot(y).powi(2) - x / (x * x + y * y).sqrt()",
        "x.hypot(y).hypot(u).powi(2) - x * x - y * y - u * u",
        "2.0 * (x / 2.0).sin().powi(2) + x.cos() - 1.0",
        "(x / 2.0).sin() * (x / 2.0).cos() - x.sin() / 2.0",
        "x.sin() - 3.0 * (x / 3.0).sin() + 4.0 * (x / 3.0).sin().powi(3)",
        "(a * x / 2.0).exp().powi(2) - (a * x / 3.0).exp().powi(3)",
        "(x / 2.0).tan() - x.sin() / (1.0 + x.cos())",
        "x.erf() + x.erfc() - 1.0",
        "(x - y).erf() + (y - x).erf()",
        "(-x).erfc() + x.erfc() - 2.0",
        "(x - y).sinc() - (y - x).sinc()",
        "x.sinc() * x - x.sin()",
        "(x * y).j0() - (-x * y).j0()",
        "(x - y).j1() + (y - x).j1()",
        "((x + y) / 2.0).cos() * ((x - y) / 2.0).cos() - (x.cos() + y.cos()) / 2.0",
        "x.powf(a) * x.powf(1.0 - a) - x",
        "x.powf(a).powi(2) - x.powf(2.0 * a)",
        "x.powf(4.0 / 3.0) - x * x.powf(1.0 / 3.0)",
        "(1.0 + x * x).powf(4.0 / 3.0) - (1.0 + x * x) * (x * x + 1.0).powf(1.0 / 3.0)",
        "(x * x + y * y).powf(a) - (y * y + x.hypot(y).powi(2) - y * y).powf(a)",
        "(a * x.ln()).exp() - x.powf(a)",
        "(2.0 * x.ln()).exp() - x * x",
        "(x + y).exp2() - x.exp2() * y.exp2()",
        "(x + 1.0).exp2() - 2.0 * x.exp2()",
        "x.exp2().powi(2) - (2.0 * x).exp2()",
        "(x / 2.0).exp2().powi(2) - x.exp2()",
        "x.exp2() - (2.0_f64).powf(x)",
        "x.log2() * 2.0_f64.ln() - x.ln()",
        "x.log10() * 10.0_f64.ln() - x.ln()",
        "(1.0 + x).ln() - x.ln_1p()",
        "x.exp2() - (x * std::f64::consts::LN_2).exp()",
        "(x * x * y / 3.0).exp2() - (x * std::f64::consts::LN_2 * y * x / 3.0).exp()",
        "((x + y) * std::f64::consts::LN_2).exp() - x.exp2() * y.exp2()",
        "(x + 1.0).exp2() - 2.0 * (std::f64::consts::LN_2 * x).exp()",
        "(x * std::f64::consts::LN_10).exp() - 10.0_f64.powf(x)",
        "(x * std::f64::consts::LN_2).sinh() - (x.exp2() - (-x).exp2()) / 2.0",
        "((x + y) * u.ln()).exp() - u.powf(x) * u.powf(y)",
        "(x * std::f64::consts::LOG2_E).exp2() - x.exp()",
        "(y * x.log2()).exp2() - x.powf(y)",
        "10.0_f64.powf(x * std::f64::consts::LOG10_2) - x.exp2()",
        "x.log2() - x.ln() / std::f64::consts::LN_2",
        "x.log2() - x.ln() * std::f64::consts::LOG2_E",
        "x.log10() - x.ln() * std::f64::consts::LOG10_E",
        "x.log10() - x.log2() * std::f64::consts::LOG10_2",
        "x.log2() - x.log10() * std::f64::consts::LOG2_10",
    ];
    for closure in zero {
        let model = drift(&format!("|[x, y], [u, v]| {closure} + 0.0 * (u + v)"));
        assert_eq!(model.graph.test_zero(model.drift), ZeroTest::Zero, "{closure}");
    }
    for closure in [
        "x.hypot(y) - x",
        "(x / 2.0).sin() - x.sin() / 2.0",
        "(x * x).sqrt() - x",
        "x.erf() - x.erfc()",
        "x.sinc() - x.j0()",
        "x.powf(a) - x.powf(2.0 * a)",
        "x.powf(1.0 / 3.0) - x.powf(2.0 / 3.0)",
        "x.powf(a) - y.powf(a)",
        "x.exp2() - x.exp()",
        "x.exp2() - (x * std::f64::consts::LN_10).exp()",
        "x.exp2() - (x * 0.693).exp()",
        "(x * x).exp2() - (x * std::f64::consts::LN_2).exp()",
        "x.log2() - x.ln() * std::f64::consts::LOG10_E",
        "x.log2() - x.log10()",
    ] {
        let model = drift(&format!("|[x, y], [u, v]| {closure} + 0.0 * (u + v)"));
        assert!(matches!(model.graph.test_zero(model.drift), ZeroTest::Nonzero(_)), "{closure}");
    }
}

/// The vector of Laplace, Runge and Lenz, with each spelling of the distance; the energy of a pendulum with
/// half its angle.
#[test]
fn first_integrals_are_proven_in_each_spelling() {
    let item = "struct S { a: f64 }";
    for r in ["x.hypot(y)", "(x * x + y * y).sqrt()", "(x.powi(2) + y.powi(2)).powf(0.5)"] {
        let attribute = format!(
            "drift = |[x, y], [u, v]| 0.5 * (u * u + v * v) - 1.0 / {r}, \
             invariant = [|[x, y], [u, v]| (x * v - y * u) * v - x / {r}, \
             |[x, y], [u, v]| (y * u - x * v) * u - y / {r}], embedding = Midpoint"
        );
        let text = expand(attribute.parse().unwrap(), item.parse().unwrap()).to_string();
        assert!(!text.contains("compile_error"), "{r}");
    }
    let pendulum = "drift = |q, p| 0.5 * p * p + a * (1.0 - q.cos()), \
                    invariant = |q, p| 0.25 * p * p + a * (0.5 * q).sin().powi(2), embedding = Midpoint";
    let text = expand(pendulum.parse().unwrap(), item.parse().unwrap()).to_string();
    assert!(!text.contains("compile_error"), "{text}");
    let inverse = "drift = |q, p| 0.5 * (p * p + a * q * q), \
                     invariant = |q, p| 0.5 * (p * p + a * q.sinh().asinh().powi(2)), embedding = Midpoint";
    let text = expand(inverse.parse().unwrap(), item.parse().unwrap()).to_string();
    for part in ["could not be proven", "`hypot`", "fractions of angles", "not of sums of logarithms"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// Members of a family that read coordinates or momenta, not both, have no defect at any size.
#[test]
fn families_with_branches_are_consistent_at_all_sizes() {
    for (state, size) in [
        ("[f64; 3]", "3"),
        ("[f64; 16]", "16"),
        ("[f64; 17]", "17"),
        ("[f64; N]", "N"),
        ("&[f64]", "q.len()"),
    ] {
        for noise in [
            "if k == 0 { a * q[0] * q[0] } else { a * p[0] }",
            "if k > 1 { a * p[k] * p[k] } else { a * q[k].sin() }",
        ] {
            let count = if size == "q.len()" { "self.n" } else { size };
            let attribute = format!(
                "drift = |q: {state}, p: {state}| (0..{size}).map(|i| 0.5 * (p[i] * p[i] + q[i] * q[i])).sum::<f64>(), \
                 noise = [|q, p, k| {noise}; {count}], embedding = DeltaPlus"
            );
            let item = "struct S<const N: usize> { a: f64, n: usize }";
            let text = expand(attribute.parse().unwrap(), item.parse().unwrap()).to_string();
            let at = text.find("compile_error").unwrap_or(text.len());
            assert_eq!(at, text.len(), "{state} {noise}: {}", &text[at..(at + 300).min(text.len())]);
        }
    }
}

/// Bessel's equations of `j0` and `j1`, those of `sinc` and `erf`: derivatives do not leave the functions
/// that proofs know. `u` stands for the first derivative and `v` for the second.
#[test]
fn special_functions_solve_their_equations() {
    for (function, equation) in [
        ("x.j0()", "x * x * v + x * u + x * x * x.j0()"),
        ("x.j1()", "x * x * v + x * u + (x * x - 1.0) * x.j1()"),
        ("x.sinc()", "x * v + 2.0 * u + x * x.sinc()"),
        ("x.erf()", "v + 2.0 * x * u"),
        ("x.erfc()", "v + 2.0 * x * u"),
    ] {
        // Both in one graph: the function where y is positive, else the equation.
        let closure = format!("|[x, y], [u, v]| if y > 0.0 {{ {function} }} else {{ {equation} }}");
        let mut model = drift(&closure);
        let Node::Select { then, otherwise, .. } = *model.graph.node(model.drift) else {
            panic!("{closure}")
        };
        let (x, u, v) = (model.phase.q[0], model.phase.p[0], model.phase.p[1]);
        let slope = model.graph.derivative(then, x);
        let curvature = model.graph.derivative(slope, x);
        let by = HashMap::from([(u, slope), (v, curvature)]);
        let defect = model.graph.substitute(&[otherwise], &by)[0];
        assert_eq!(model.graph.test_zero(defect), ZeroTest::Zero, "{function}");
    }
}

/// An angle jumps where its point crosses the negative axis, which a sum with a bounded function does not
/// reach.
#[test]
fn bounded_functions_do_not_outweigh_larger_numbers() {
    let item = "struct S { a: f64 }";
    for (bounded, may_jump) in
        [("q.sinc()", false), ("q.j0()", false), ("q.erf()", false), ("q.erfc()", true)]
    {
        let attribute =
            format!("drift = |q, p| 0.5 * p * p + p.atan2(1.5 - {bounded}), embedding = Midpoint");
        let text = expand(attribute.parse().unwrap(), item.parse().unwrap()).to_string();
        assert_eq!(text.contains("< 0"), may_jump, "{bounded}: {text}");
    }
}
