//! Every message, at the tokens it should point at.

use proc_macro2::TokenStream;

use super::STRUCT;
use crate::diagnostics::Diagnostics;
use crate::input;

/// The messages about `attribute` on `item`, each with the source text it points at.
fn messages(attribute: &str, item: &str) -> Vec<(String, String)> {
    let mut diagnostics = Diagnostics::new();
    let attribute: TokenStream = attribute.parse().unwrap();
    let system = input::read_struct(item.parse().unwrap(), &mut diagnostics);
    let declaration = input::read_attribute(attribute, &mut diagnostics);
    if let (Some(system), Some(mut declaration)) = (system, declaration)
        && let Some(phase_space) = input::read_phase_space(&mut declaration, &mut diagnostics)
    {
        let _ = crate::lower::lower(system, declaration, &phase_space, &mut diagnostics);
    }
    let found = diagnostics
        .errors()
        .iter()
        .map(|error| (error.span().source_text().unwrap_or_default(), error.to_string()))
        .collect();
    drop(diagnostics.finish());
    found
}

#[track_caller]
fn assert_messages(attribute: &str, item: &str, expected: &[(&str, &str)]) {
    let found = messages(attribute, item);
    let matches = found.len() == expected.len()
        && expected.iter().all(|(span, text)| found.iter().any(|(s, t)| s == span && t.contains(text)));
    assert!(matches, "{attribute}\nfound {found:#?}\nexpected {expected:#?}");
}

/// The messages about the body of a drift with one degree of freedom.
#[track_caller]
fn body(body: &str, expected: &[(&str, &str)]) {
    assert_messages(&format!("drift = |q, p| {body}, embedding = Midpoint"), STRUCT, expected);
}

/// The messages about an attribute.
#[track_caller]
fn attribute(attribute: &str, expected: &[(&str, &str)]) {
    assert_messages(attribute, STRUCT, expected);
}

#[test]
fn keys() {
    attribute("drfit = |q, p| q, embedding = Midpoint", &[("drfit", "did you mean `drift`?")]);
    attribute("drift = |q, p| q, scheme = Midpoint", &[("scheme", "did you mean `embedding`?")]);
    attribute("drift = |q, p| q, drift = |q, p| p, embedding = Midpoint", &[("drift", "given twice")]);
    attribute("drift = , embedding = Midpoint", &[("drift", "`drift =` has no value")]);
    attribute("drift = |q, p| q, x = 1", &[("x", "unknown key"), ("", "`embedding` is missing")]);
    attribute("drift = |q, p| q embedding = Midpoint", &[("embedding", "expected `,` before `embedding`")]);
    attribute("5, drift = |q, p| q, embedding = Midpoint", &[("5,", "expected `key = value`")]);
    attribute("drift = q + p, embedding = Midpoint", &[("q", "expected a closure")]);
    attribute("drift = |q, p| q, noise = [], embedding = Midpoint", &[("[]", "leave `noise` out")]);
    attribute("drift = |q, p| q, noise = [|q, p, k| q; 2.5], embedding = Midpoint", &[("2.5", "an integer")]);
    attribute("drift = |q, p| q * , embedding = Midpoint", &[("*", "expected an expression")]);
}

#[test]
fn habits_from_elsewhere_are_recognised() {
    body("[p, -q]", &[("[p, -q]", "a Hamiltonian is one number, the energy")]);
    body("(p, -q)", &[("(p, -q)", "a Hamiltonian is one number, the energy")]);
    attribute("drift = |(q, p)| p, embedding = Midpoint", &[("(q, p)", "two parameters, not a tuple")]);
    attribute(
        "drift = |q, p| p, embedding = ImplicitMidpoint",
        &[("ImplicitMidpoint", "did you mean `Midpoint`?")],
    );
    attribute(
        "drift = |q, p| p, embedding = SymplecticEuler",
        &[("SymplecticEuler", "did you mean `DeltaPlus`?")],
    );
}

#[test]
fn operators_and_functions_of_other_languages_are_recognised() {
    body("p**2", &[("p**2", "write `p.powi(2)`")]);
    body("0.5 * p**2 + q", &[("p**2", "write `p.powi(2)`")]);
    body("(q + p)**0.5", &[("(q + p)**0.5", "write `(q + p).powf(0.5)`")]);
    body("p^2", &[("p^2", "write `p.powi(2)`")]);
    body("0.5 * p^2 + a * q^2 / 2.0", &[("p^2", "write `p.powi(2)`"), ("q^2", "write `q.powi(2)`")]);
    body("sin(q)", &[("sin", "write `q.sin()`")]);
    body("a * sqrt(q * q + p * p)", &[("sqrt", "write `(q * q + p * p).sqrt()`")]);
    body("atan2(q, p)", &[("atan2", "write `q.atan2(p)`")]);
    attribute("drift = |q, p| p, ito = true, embedding = Midpoint", &[("ito", "docs/guide/noise.md")]);
    attribute("drift = |q, p| p, embedding = EulerMaruyama", &[("EulerMaruyama", "sense of Stratonovich")]);
    body("stiffness * q", &[("stiffness", "cannot use outside variables: make it a field")]);
    body("sgma * q", &[("sgma", "did you mean `sigma`?")]);
}

#[test]
fn fields_with_the_names_of_variables_are_refused() {
    let item = "struct Charged { q: f64, t: f64, mass: f64 }";
    let (drift, noise) = ("drift = |q, p| p * p / mass", "noise = [|x, y, t| x * t]");
    assert_messages(
        &format!("{drift}, embedding = Midpoint"),
        item,
        &[("q", "the struct has a field `q`, too")],
    );
    assert_messages(
        &format!("{drift}, {noise}, embedding = Midpoint"),
        item,
        &[("q", "the struct has a field `q`"), ("t", "the struct has a field `t`")],
    );
    assert_messages("drift = |x, y| q * y / mass + self.t * x, embedding = Midpoint", item, &[]);
}

#[test]
fn names_belong_to_first_integrals() {
    attribute("drift = |q, p| p, invariant = [momentum = |q, p| p, |q, p| p * p], embedding = Midpoint", &[]);
    attribute(
        "drift = |q, p| p, noise = [kick = |q, p| q], embedding = Midpoint",
        &[("kick", "leave it out")],
    );
}

#[test]
fn momenta_before_coordinates_are_refused() {
    attribute("drift = |p, q| p, embedding = Midpoint", &[("p, q", "write `|q, p|`")]);
    attribute(
        "drift = |p: f64, q: f64, t| p * t, embedding = Midpoint",
        &[("p: f64, q: f64", "come before momenta")],
    );
    attribute(
        "drift = |[px, py], [x, y]| x, embedding = Midpoint",
        &[("[px, py], [x, y]", "come before momenta")],
    );
    attribute(
        "drift = |[p1, p2], [q1, q2]| q1, embedding = Midpoint",
        &[("[p1, p2], [q1, q2]", "come before")],
    );
    let noise = "drift = |q, p| p, noise = [|p, q| p, |q, p| q], embedding = Midpoint";
    attribute(noise, &[("p, q", "come before momenta")]);
    // Names that say nothing, or the right thing.
    for names in ["x, v", "phi, p_phi", "p, s", "_, p", "p, _", "psi, q", "p, psi"] {
        attribute(&format!("drift = |{names}| 1.0, embedding = Midpoint"), &[]);
    }
}

#[test]
fn schemes() {
    let cases = [
        ("midpoint", "midpoint", "did you mean `Midpoint`?"),
        ("[DeltaPlus, DeltaPlus]", "DeltaPlus", "listed twice"),
        ("[]", "[]", "at least one scheme"),
        ("Lambda<3, 2>", "Lambda<3, 2>", "0 <= N <= D"),
        ("Lambda<1, 0>", "Lambda<1, 0>", "D > 0"),
        ("Lambda<N, 2>", "N", "integer literals"),
        ("Lambda<1>", "Lambda<1>", "`Lambda<1, 3>`"),
        ("Midpoint<1>", "Midpoint<1>", "`Midpoint`"),
        ("Corrected<Uncorrected<DeltaPlus>>", "Uncorrected<DeltaPlus>", "wrap a whole scheme"),
        ("Mixed<Corrected<DeltaPlus>, Midpoint>", "Corrected<DeltaPlus>", "wrap a whole scheme"),
        ("Mixed<Mixed<DeltaPlus, Midpoint>, Midpoint>", "Mixed<DeltaPlus, Midpoint>", "arguments of `Mixed`"),
        ("[u8; 3]", "[u8; 3]", "expected an embedding"),
    ];
    for (scheme, span, text) in cases {
        let scheme = if scheme == "[u8; 3]" { "[[u8; 3]]" } else { scheme };
        attribute(&format!("drift = |q, p| q, embedding = {scheme}"), &[(span, text)]);
    }
}

#[test]
fn items() {
    let good = "drift = |q, p| q, embedding = Midpoint";
    assert_messages(good, "enum E {}", &[("enum", "goes on a struct")]);
    assert_messages(good, "union U { a: u8 }", &[("union", "goes on a struct")]);
    assert_messages(good, "fn f() {}", &[("fn f()", "goes on a struct")]);
    assert_messages(
        "drift = |q, p| self.0 * q + self.2, embedding = Midpoint",
        "struct T(f64, u8);",
        &[("2", "no field `2`")],
    );
}

#[test]
fn phase_spaces() {
    let patterns = [
        ("|q| q", "|q|", "this takes 1 parameter:"),
        ("|q, mut p| q", "mut p", "cannot declare a phase space"),
        ("|(x, y), p| x", "(x, y)", "two parameters, not a tuple"),
        ("|[x, y], p| x", "p", "the momenta are `f64`, but the coordinates are `[f64; 2]`"),
        ("|q: [[f64; N]; 2], p: [[f64; N]; 2]| 0.0", "[f64; N]", "only the outermost size"),
        ("|q: Vec<f64>, p: Vec<f64>| 0.0", "Vec<f64>", "arrays of them or `&[f64]`"),
        ("|q: f32, p: f32| 0.0", "f32", "`f64`, arrays"),
        ("|q: [f64; 0], p| 0.0", "[f64; 0]", "at least one degree"),
        ("|q, p, t: [f64; 2]| q", "t: [f64; 2]", "the third parameter is time"),
        ("|q, p| -> f32 { q }", "f32", "is an `f64`"),
    ];
    for (closure, span, text) in patterns {
        attribute(&format!("drift = {closure}, embedding = Midpoint"), &[(span, text)]);
    }
    attribute(
        "drift = |q: [f64; 2], p: [f64; 2]| 0.0, noise = [|_, p: f64| 1.0, |q: f64, _| 1.0], embedding = Midpoint",
        &[
            ("p: f64", "this is `f64`, but the phase space of the drift is `[f64; 2]`"),
            ("q: f64", "this is `f64`, but the phase space of the drift is `[f64; 2]`"),
        ],
    );
}

#[test]
fn names() {
    body("sigam * q", &[("sigam", "did you mean `sigma`?")]);
    body("self.sgma * q", &[("sgma", "did you mean `sigma`?")]);
    body("single * q", &[("single", "`f64`: all arithmetic")]);
    body("name * q", &[("name", "has the type `String`")]);
    body("q * n", &[("n", "write `n as f64`")]);
    body("potential(q)", &[("potential", "local closure")]);
    body("self.potential(q)", &[("potential", "local closure")]);
    body("crate::v::potential(q)", &[("crate::v::potential", "local closure")]);
    body("self", &[("self", "the struct as a whole")]);
    body("masses * q", &[("masses", "found a list")]);
}

#[test]
fn expressions() {
    body("2 * q", &[("2", "write `2.0`")]);
    body("q / 2", &[("2", "write `2.0`")]);
    body("1", &[("1", "write `1.0`")]);
    body("q * 2f32", &[("2f32", "`f32` is not supported")]);
    body("q / 0.0", &[("0.0", "divides by zero")]);
    body("q * p / (1.0 - 1.0)", &[("(1.0 - 1.0)", "divides by zero")]);
    body("(q - q) / (p - p) + q", &[("(p - p)", "divides by zero")]);
    body("{ let mut s = q; s /= 0.0; s }", &[("0.0", "divides by zero")]);
    body("q % p", &[("q % p", "`%` on real numbers")]);
    body("q as usize as f64", &[("q as usize", "differentiable")]);
    body("(q as f32) * p", &[("f32", "`f32` is not supported")]);
    body("q.floor()", &[("floor", "is not supported on `f64`")]);
    body("q.sine()", &[("sine", "did you mean `sin`?")]);
    body("q.powi(1, 2)", &[("powi", "expected 1 argument, found 2")]);
    body("f64::atan2(q)", &[("f64::atan2", "expected 2 arguments, found 1")]);
    body("match q { _ => p }", &[("q", "use `if` and `else`")]);
    body("match n { k => q * k as f64 }", &[("k", "in the place of a name write `_`")]);
    body("match n { 0.5 => q, _ => p }", &[("0.5", "does not fit an integer")]);
    body("match n { 0 if q => q, _ => p }", &[("q", "expected a condition, found a real number")]);
    body("match n { 0 => (q, p), _ => p }", &[("(q, p)", "both branches")]);
    body("match n { 0 => sgma, _ => q.floor() }", &[("sgma", "no field"), ("floor", "not supported")]);
    body("{ let mut s = q; match n { 0 => s = p, _ => {} }; s }", &[("s", "assignment inside a branch")]);
    body("{ return q; }", &[("return", "`return`"), ("{ return q; }", "found `()`")]);
    body("{ while q > p {} q }", &[("while", "known number of iterations")]);
    body("vec![q, p][0]", &[("vec![q, p]", "a macro call")]);
    body("if q > p { q }", &[("if", "needs an `else`")]);
    body("if q > p { (q, p).0 } else { 1 }", &[("(q, p).0", "both branches")]);
    body("if q { q } else { p }", &[("q", "expected a condition, found a real number")]);
    body("{ let mut s = q; if q > p { s += 1.0; } s }", &[("s", "assignment inside a branch")]);
    body("{ a = 1.0; q }", &[("a", "only local variables")]);
    body("{ let (x, y) = q; x + y }", &[("(x, y)", "does not fit a real number")]);
    body("{ let f = |x| x; f(q, p) }", &[("f(q, p)", "expected 1 argument, found 2")]);
    body("{ fn f() {} q }", &[("fn f() {}", "move it out of the closure")]);
}

#[test]
fn lists() {
    body("masses[3] * q", &[("3", "index 3 is out of range: there are 3 elements")]);
    body("[q, p][2]", &[("2", "out of range")]);
    body("(0..3).map(|i| [q, p][i]).sum::<f64>()", &[("i", "index 2 is out of range")]);
    body("[q, p][n]", &[("n", "known at compile time")]);
    body("(0..N).map(|i| [q, p][i]).sum::<f64>()", &[("i", "known at compile time")]);
    body("{ let [x, y] = table; x + y + q }", &[("[x, y]", "length of this list is not known")]);
    body("(0..).map(|i| q * i as f64).sum::<f64>()", &[("(0..)", "has no end")]);
    body("(0..300_000).map(|_| q).product::<f64>()", &[("(0..300_000)", "more than 200000 operations")]);
    body(
        "[q, p].iter().filter(|x| **x > 0.0).product::<f64>()",
        &[("|x| **x > 0.0", "known at compile time")],
    );
    body("[q, p].iter().positions().sum::<f64>()", &[("positions", "not supported on lists")]);
}

#[test]
fn independent_mistakes_are_reported_together() {
    body(
        "{ let x = sgma * q; let y = 2 * x; x * y + q.floor() + self.nope }",
        &[("sgma", "no field or variable"), ("floor", "not supported"), ("nope", "no field")],
    );
    attribute(
        "drift = |q, p| 2 * q, noise = [|q| q, |q, p| 3 * p], invariant = |q, p| foo(q), embedding = Midpont, x = 1",
        &[
            ("2", "write `2.0`"),
            ("3", "write `3.0`"),
            ("|q|", "this takes 1 parameter:"),
            ("foo", "local closure"),
            ("Midpont", "did you mean `Midpoint`?"),
            ("x", "unknown key"),
        ],
    );
}

#[test]
fn sums_in_sums() {
    let nested = |times: usize| {
        let line = "let a = (0..q.len()).map(|i| a * q[i] * p[i]).sum::<f64>();";
        format!(
            "drift = |q: &[f64], p: &[f64]| {{ let a = 1.0; {} a }}, embedding = Midpoint",
            line.repeat(times)
        )
    };
    assert_messages(&nested(16), STRUCT, &[]);
    let found = messages(&nested(40), STRUCT);
    assert!(
        found.iter().any(|(_, text)| text.contains("inside of each other more than 16 times")),
        "{found:?}"
    );
}
