//! The text and the code of a formula depend on nothing but the formula: see `symbolic/order.rs`.

#![allow(clippy::unwrap_used, reason = "a test may stop")]

use std::collections::BTreeSet;

use quote::{ToTokens, quote};

use super::{expand, expand_lowered};
use crate::diagnostics::Diagnostics;
use crate::emit::Expansion;
use crate::input;
use crate::lower::lower;
use crate::model::System;
use crate::symbolic::{Expr, Graph, Rational};

/// Drift with what is beside it, the struct, and schemes: each is generated in the same way beside any other.
const SYSTEMS: [(&str, &str, &[&str]); 10] = [
    (
        "drift = |[x, y], [px, py]| 0.5 * (px * px / m + py * py / n) + 0.5 * k * (x * x + y * y) + c * x * x * y",
        "struct Oscillators { m: f64, n: f64, k: f64, c: f64 }",
        &["Midpoint", "Verlet", "Gauss<2>", "DeltaMinus"],
    ),
    (
        "drift = |q, p| 0.5 * p * p / (1.0 + q * q) - omega * omega * q.cos(), noise = |q, p| sigma * q * p",
        "struct Pendulum { omega: f64, sigma: f64 }",
        &["Uncorrected<DeltaPlus>", "Midpoint", "Corrected<DeltaPlus>", "Uncorrected<Lambda<1, 4>>"],
    ),
    (
        "drift = |q, p| 0.5 * p * p - q.cos(), force = |q, p, t| push * (2.0 * t).cos() * q, friction = gamma",
        "struct Driven { push: f64, gamma: f64 }",
        &["Midpoint", "DeltaPlus", "DeltaMinus"],
    ),
    (
        "drift = |q: [f64; 4], p: [f64; 4]| p.iter().map(|p| 0.5 * p * p).sum::<f64>() \
            + (1..4).map(|i| { let d = q[i] - q[i - 1]; 0.5 * d * d + 0.25 * beta * d.powi(4) }).sum::<f64>()",
        "struct Chain { beta: f64 }",
        &["Midpoint", "Verlet", "Gauss<2>"],
    ),
    (
        "drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p / m).sum::<f64>() \
            + (1..q.len()).map(|i| { let d = q[i] - q[i - 1]; k * d * d + 0.25 * beta * d.powi(4) }).sum::<f64>()",
        "struct Long { m: f64, k: f64, beta: f64 }",
        &["Midpoint", "Verlet", "DeltaPlus"],
    ),
    (
        "drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - mu / x.hypot(y) + y.atan2(x).cos()",
        "struct Kepler { mu: f64 }",
        &["Midpoint", "Verlet"],
    ),
    (
        "drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - mu / (x * x + y * y).sqrt(), \
            invariant = |[x, y], [px, py]| (x * py - y * px).powi(2)",
        "struct Kepler { mu: f64 }",
        &["Midpoint", "DeltaPlus", "Gauss<4>"],
    ),
    (
        "drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - mu / (x * x + y * y).sqrt(), clock = curvature(mu)",
        "struct Kepler { mu: f64 }",
        &["Midpoint", "Verlet", "Gauss<2>"],
    ),
    (
        "drift = |q: &[[f64; 2]], p: &[[f64; 2]]| \
            (0..q.len()).map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]) / mass[i]).sum::<f64>() \
            - (0..q.len()).map(|i| (0..i).map(|j| \
                mass[i] * mass[j] / (q[i][0] - q[j][0]).hypot(q[i][1] - q[j][1])).sum::<f64>()).sum::<f64>(), \
            clock = pairs",
        "struct Bodies { mass: Vec<f64> }",
        &["Midpoint", "Verlet", "Gauss<2>"],
    ),
    (
        "drift = |[x, y], [px, py]| 0.5 * (px * px / m + py * py) + 0.25 * k * (x - y).powi(4), \
            friction = gamma, temperature = kt",
        "struct Heated { m: f64, k: f64, gamma: f64, kt: f64 }",
        &["Baoab", "Gjf", "Thermostat<Midpoint>"],
    ),
];

/// The implementations of an expansion, as text.
fn implementations(drift: &str, item: &str, schemes: &[&str]) -> BTreeSet<String> {
    let attribute = format!("{drift}, embedding = [{}]", schemes.join(", "));
    let expansion = expand(attribute.parse().unwrap(), item.parse().unwrap());
    assert!(!expansion.to_string().contains("compile_error"), "{attribute}: {expansion}");
    let mut found = BTreeSet::new();
    collect_implementations(syn::parse2::<syn::File>(expansion).unwrap().items, &mut found);
    found
}

fn collect_implementations(items: Vec<syn::Item>, found: &mut BTreeSet<String>) {
    for item in items {
        match item {
            syn::Item::Const(constant) => {
                let syn::Expr::Block(block) = *constant.expr else { continue };
                let items = block.block.stmts.into_iter().filter_map(|statement| match statement {
                    syn::Stmt::Item(item) => Some(item),
                    _ => None,
                });
                collect_implementations(items.collect(), found);
            }
            // Inherent functions check the types of the user's closures and schemes, as listed.
            syn::Item::Impl(implementation) if implementation.trait_.is_some() => {
                found.insert(implementation.to_token_stream().to_string());
            }
            _ => {}
        }
    }
}

/// The equations and the step of one scheme.
fn of_scheme<'t>(all: &'t BTreeSet<String>, scheme: &str) -> Vec<&'t String> {
    let dense = |text: &str| text.replace(char::is_whitespace, "");
    let marks =
        [format!("StraightLine<{scheme},"), format!("Discretized<{scheme}>")].map(|mark| dense(&mark));
    all.iter().filter(|text| marks.iter().any(|mark| dense(text).contains(mark))).collect()
}

/// A clock changes neither the step of a scheme nor its text nor the forms that were chosen.
#[test]
fn schemes_are_those_of_the_system_without_clock() {
    let of_one =
        "drift = |[x, y], [px, py]| 0.5 * (px * px / m[0] + py * py / m[0]) - k / (x * x + y * y).sqrt()";
    let of_four = "drift = |q: [[f64; 2]; 4], p: [[f64; 2]; 4]| \
        (0..4).map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]) / m[i]).sum::<f64>() \
        - (0..4).map(|i| (0..i).map(|j| \
            m[i] * m[j] / (q[i][0] - q[j][0]).hypot(q[i][1] - q[j][1])).sum::<f64>()).sum::<f64>()";
    let (item, schemes) = ("struct Kepler { m: [f64; 4], k: f64 }", ["Midpoint", "Verlet", "Gauss<2>"]);
    let function = "|[x, y], [px, _]| (x * x + y * y).powf(0.75) / (k + m[0] * px * px)";
    for (drift, clocks) in
        [(of_one, ["curvature", "curvature(k)", function]), (of_four, ["curvature", "curvature(k)", "pairs"])]
    {
        let plain = implementations(drift, item, &schemes);
        for clock in clocks {
            let clocked = implementations(&format!("{drift}, clock = {clock}"), item, &schemes);
            for scheme in schemes {
                assert_eq!(of_scheme(&plain, scheme), of_scheme(&clocked, scheme), "{clock}");
            }
        }
    }
}

#[test]
fn schemes_are_generated_in_the_same_way_beside_others() {
    for (drift, item, schemes) in SYSTEMS {
        let forward = implementations(drift, item, schemes);
        let backward: Vec<&str> = schemes.iter().rev().copied().collect();
        let backward = implementations(drift, item, &backward);
        let different: Vec<&String> = forward.symmetric_difference(&backward).collect();
        assert!(different.is_empty(), "{drift}: {different:#?}");
        for scheme in schemes {
            let alone = implementations(drift, item, &[scheme]);
            let (alone, among) = (of_scheme(&alone, scheme), of_scheme(&forward, scheme));
            assert!(!alone.is_empty(), "{scheme}");
            assert_eq!(alone, among, "{scheme} of {drift}");
        }
    }
}

fn lowered(attribute: &str, item: &str) -> System {
    let mut diagnostics = Diagnostics::new();
    let container = input::read_struct(item.parse().unwrap(), &mut diagnostics).unwrap();
    let mut declaration = input::read_attribute(attribute.parse().unwrap(), &mut diagnostics).unwrap();
    let phase_space = input::read_phase_space(&mut declaration, &mut diagnostics).unwrap();
    let system = lower(container, declaration, &phase_space, &mut diagnostics).unwrap();
    assert!(diagnostics.finish().is_ok(), "{attribute}");
    system
}

fn written(system: System) -> String {
    let mut diagnostics = Diagnostics::new();
    let expansion = expand_lowered(system, &mut diagnostics);
    if let Err(errors) = diagnostics.finish() {
        panic!("{errors}");
    }
    let Expansion { doc, item, implementations } = expansion.unwrap();
    quote! { #doc #item #implementations }.to_string()
}

/// Makes derivatives, sums and products of the parts of an expression, from the last to the first: other
/// nodes, in another order than the compiler.
fn disturb(graph: &mut Graph, expr: Expr) {
    let (parts, symbols) = (graph.reachable(&[expr]), graph.symbols_in(expr));
    let is_real = |graph: &Graph, part: Expr| {
        graph.as_symbol(part).is_some() || !graph.display(part).contains(['<', '≤', '='])
    };
    let reals: Vec<Expr> = parts.into_iter().rev().filter(|&part| is_real(graph, part)).collect();
    for pair in reals.windows(2) {
        let product = graph.product(pair);
        graph.linear_combination(&[(pair[1], Rational::HALF), (pair[0], Rational::MINUS_ONE)]);
        for &symbol in symbols.iter().rev() {
            let slope = graph.derivative(product, symbol);
            graph.power(slope, Rational::integer(2));
        }
    }
}

#[test]
fn expansions_do_not_depend_on_what_was_made_before() {
    for (drift, item, schemes) in SYSTEMS {
        let attribute = format!("{drift}, embedding = [{}]", schemes.join(", "));
        let mut disturbed = lowered(&attribute, item);
        let expression = disturbed.drift.expression;
        disturb(&mut disturbed.graph, expression);
        assert_eq!(written(lowered(&attribute, item)), written(disturbed), "{drift}");
    }
}

/// `item` with its fields in the opposite order.
fn reordered(item: &str) -> String {
    let mut item: syn::ItemStruct = syn::parse_str(item).unwrap();
    let syn::Fields::Named(fields) = &mut item.fields else { return item.to_token_stream().to_string() };
    fields.named = fields.named.iter().rev().cloned().collect();
    item.to_token_stream().to_string()
}

#[test]
fn names_and_places_of_parameters_do_not_change_a_step() {
    let drift = |a: &str, b: &str| {
        format!(
            "drift = |[x, y], [px, py]| 0.5 * (px * px / {a} + py * py / {b}) + {b} * x * y * y + {a} * x * x"
        )
    };
    let item = |a: &str, b: &str| format!("struct S {{ {a}: f64, {b}: f64 }}");
    let schemes = ["Midpoint", "Verlet", "Gauss<2>"];
    let own = implementations(&drift("alpha", "omega"), &item("alpha", "omega"), &schemes);
    let renamed = implementations(&drift("zetas", "beta7"), &item("zetas", "beta7"), &schemes);
    let reordered = implementations(&drift("alpha", "omega"), &reordered(&item("alpha", "omega")), &schemes);
    for scheme in schemes {
        let steps = of_scheme(&own, scheme);
        let back = |text: &&String| text.replace("zetas", "alpha").replace("beta7", "omega");
        let renamed: Vec<String> = of_scheme(&renamed, scheme).iter().map(back).collect();
        assert_eq!(steps, renamed.iter().collect::<Vec<_>>(), "{scheme}");
        assert_eq!(steps, of_scheme(&reordered, scheme), "{scheme}");
    }
}
