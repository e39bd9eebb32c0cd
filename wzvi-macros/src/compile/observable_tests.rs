//! Observables change nothing but the values that they add: the golden systems expand to the same steps,
//! facts and text with and without them.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use quote::{ToTokens, quote};
use syn::{Expr, ImplItem, Item, Stmt};

use super::expand;
use super::golden_tests::SCENES;

/// Items of `Elements` that describe observables, too.
const OF_OBSERVABLES: [&str; 6] = ["value", "variables", "observables", "parameter", "PLACES", "entries"];

/// An observable of the phase space of a scene: it jumps, and it reads a nonlinear function of a sum.
fn observable(attribute: &str) -> &'static str {
    match attribute {
        _ if attribute.contains("|[x, y]") => {
            "|[x, y], [px, py]| (x * py).tanh() + y.signum() * px + if x > y { 1.0 } else { x / y }"
        }
        _ if attribute.contains("f64; 2]") => {
            "|q, p| (0..q.len()).map(|i| (q[i][0] * q[i][1]).tanh()).sum::<f64>().abs().sqrt() - p[0][1]"
        }
        _ if attribute.contains("&[f64]") => {
            "|q, p| (0..q.len()).map(|i| (1.0 + q[i]).ln()).sum::<f64>().signum() / p[0]"
        }
        _ => "|q, p| (q * p).tanh() * q.signum() + if p > 0.25 { q.exp() } else { 1.0 / p }",
    }
}

/// The parts of an expansion by their names: documentation, implementations, items of `Elements`.
fn parts(attribute: &str, item: &str) -> BTreeMap<String, String> {
    let file: syn::File = syn::parse2(expand(attribute.parse().unwrap(), item.parse().unwrap())).unwrap();
    let mut parts = BTreeMap::new();
    for item in file.items {
        if let Item::Struct(item) = &item {
            parts.insert("struct".to_owned(), item.to_token_stream().to_string());
        }
        let Item::Const(constant) = item else { continue };
        let Expr::Block(block) = *constant.expr else { continue };
        for statement in block.block.stmts {
            let Stmt::Item(Item::Impl(implementation)) = statement else { continue };
            let Some((of, _)) = &implementation.trait_ else { continue };
            let of = of.to_token_stream().to_string();
            if !of.ends_with("Elements") {
                parts.insert(of, implementation.to_token_stream().to_string());
                continue;
            }
            for item in implementation.items {
                let name = match &item {
                    ImplItem::Fn(function) => function.sig.ident.to_string(),
                    ImplItem::Const(constant) => constant.ident.to_string(),
                    ImplItem::Type(ty) => ty.ident.to_string(),
                    other => quote!(#other).to_string(),
                };
                if !OF_OBSERVABLES.contains(&name.as_str()) {
                    parts.insert(format!("{of} {name}"), item.to_token_stream().to_string());
                }
            }
        }
    }
    parts
}

#[test]
fn observables_leave_steps_facts_and_text_as_they_are() {
    for (name, attribute, item) in SCENES {
        let observed = format!("{attribute}, observe = [size = {}]", observable(attribute));
        let [without, with] = [attribute, &observed].map(|attribute| parts(attribute, item));
        assert!(without.len() > 8, "{name}: {:?}", without.keys());
        for (part, without) in &without {
            assert_eq!(with.get(part), Some(without), "{name}: {part}");
        }
        assert_eq!(with.len(), without.len(), "{name}");
    }
}

#[test]
fn long_observables_keep_their_loops_beside_straight_lines() {
    let (attribute, item) =
        ("drift = |q, p| 0.5 * p * p - q.cos(), embedding = Midpoint", "struct Pendulum;");
    let long = "(0..100_000).map(|k| (q * k as f64).cos()).sum::<f64>().abs()";
    let observed = format!("{attribute}, observe = [long = |q, _| {long}]");
    assert_eq!(parts(attribute, item), parts(&observed, item));
}
