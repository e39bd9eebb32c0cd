//! `expand` terminates on any input: no panic, no endless loop, no stack overflow.

use std::fmt::Write as _;

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};

use super::STRUCT;
use crate::compile::expand;

/// Attributes that together use all features.
const VALID: [&str; 7] = [
    // Momenta isolated by a prepared reciprocal, before an iteration on coordinates.
    "drift = |q: [f64; 3], p: [f64; 3]| p.iter().map(|p| 0.5 * p * p).sum::<f64>() \
     + (0..2).map(|i| 0.5 * (q[i + 1] - q[i]).powi(2)).sum::<f64>() \
     + (0..3).map(|i| 0.1 * q[2 - i] * p[i]).sum::<f64>() + 0.1 * q[1].cos(), embedding = Midpoint",
    "drift = |q, p| 0.5 * a * (q * q + p * p), noise = [|q, p| 0.5 * sigma * (q * q + p * p)], \
     embedding = [Uncorrected<DeltaPlus>, Corrected<DeltaPlus>, Midpoint], invariant = [|q, p| q * q + p * p]",
    "drift = |[x, y], [px, _]| { let (s, c) = x.sin_cos(); let f = move |u: f64, (v, w)| u * v - *w; \
     if s > c && !(x < 0.5) { f(x, (y, &px)) } else if y == 1.0 { f64::max(x, a) } else { masses[2].powi(n) } }, \
     embedding = Mixed<Lambda<1, 3>, DeltaMinus>, crate = ::wzvi",
    "drift = |q: [f64; 3], p: [f64; 3], t: f64| (0..3).map(|i| p[i].powi(2) / (2.0 * self.masses[i])).sum::<f64>() \
     + t * q.iter().zip(&q[1..]).enumerate().map(|(i, (x, y))| (y - x) * i as f64).fold(0.0, |s, x| s + x), \
     embedding = [Midpoint]",
    "drift = |q: [[f64; 2]; 2], p: [[f64; 2]; 2]| { let mut h = 0.0; for i in 0..2 { for j in 0..2 { \
     h += *a * p[i][j] * q[(i + 1) % 2][j]; } } h * PI + std::f64::consts::E }, embedding = Corrected<Mixed<Midpoint, \
     DeltaPlus>>, invariant = |q, p| 1.0",
    "drift = |q, p, _| { let v: Vec<f64> = (1..=4).rev().step_by(2).filter(|i| i % 2 == 0).map(|i| q.powi(i)) \
     .collect(); v[0] + v.len() as f64 + [q; 4].windows(2).map(|w| w[0] * w[1]).product::<f64>() + N as f64 }, \
     embedding = Lambda<1, 2>",
    "drift = |q, p| ({ let [x, rest @ ..] = [q, p, a]; rest[0] - x }).clamp(-1.0, 1e400) + table[3], embedding = \
     DeltaPlus, noise = [|q, p| q, |_, p| 1e-300 * p,]",
];

/// A small generator: the cases are the same on every machine.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % bound.max(1)
    }
}

fn expands(attribute: TokenStream, item: TokenStream) {
    let text = format!("#[hamiltonian({attribute})] {item}");
    let output = expand(attribute, item);
    let has_error = output.to_string().contains("compile_error");
    assert!(has_error || syn::parse2::<syn::File>(output).is_ok(), "neither code nor errors: {text}");
}

/// Applies one change at a place that is chosen among all tokens, nested ones too.
fn mutate(stream: TokenStream, random: &mut Random, donor: &[TokenTree]) -> TokenStream {
    let mut tokens: Vec<TokenTree> = stream.into_iter().collect();
    if tokens.is_empty() {
        return tokens.into_iter().collect();
    }
    let i = random.below(tokens.len());
    if let TokenTree::Group(group) = &tokens[i]
        && random.below(4) > 0
    {
        let delimiter = match random.below(20) {
            0 => Delimiter::None,
            1 => Delimiter::Bracket,
            _ => group.delimiter(),
        };
        tokens[i] = Group::new(delimiter, mutate(group.stream(), random, donor)).into();
        return tokens.into_iter().collect();
    }
    let j = random.below(tokens.len());
    match random.below(5) {
        0 => drop(tokens.remove(i)),
        1 => tokens.insert(i, tokens[j].clone()),
        2 => tokens.swap(i, j),
        3 => tokens[i] = donor[random.below(donor.len())].clone(),
        _ => tokens.insert(i, donor[random.below(donor.len())].clone()),
    }
    tokens.into_iter().collect()
}

fn flatten(stream: TokenStream, into: &mut Vec<TokenTree>) {
    for token in stream {
        if let TokenTree::Group(group) = &token {
            flatten(group.stream(), into);
        }
        into.push(token);
    }
}

#[test]
fn valid_inputs_expand_without_errors() {
    for attribute in VALID {
        let output = expand(attribute.parse().unwrap(), STRUCT.parse().unwrap());
        let text = output.to_string();
        let known = ["invariant = |q, p| 1.0", "1e400"];
        if !known.iter().any(|known| attribute.contains(known)) {
            assert!(!text.contains("compile_error"), "{attribute}: {text}");
        }
    }
}

#[test]
fn mutated_inputs_never_panic() {
    let mut random = Random(7);
    let mut donor = Vec::new();
    for attribute in VALID {
        flatten(attribute.parse().unwrap(), &mut donor);
    }
    flatten(
        "if else match return 0 -1 1.5f32 'a' \"s\" .. ..= => == != & && | || ? # ! Self self f32 usize \
             as while loop break x.0 99999999999999999999 1u8 % [f64; N] f64::foo() {} () [] mut ref dyn"
            .parse()
            .unwrap(),
        &mut donor,
    );
    for _ in 0..1000 {
        let mut attribute: TokenStream = VALID[random.below(VALID.len())].parse().unwrap();
        let mut item: TokenStream = STRUCT.parse().unwrap();
        for _ in 0..1 + random.below(4) {
            attribute = mutate(attribute, &mut random, &donor);
        }
        if random.below(8) == 0 {
            item = mutate(item, &mut random, &donor);
        }
        expands(attribute, item);
    }
}

/// Tokens in any order and nesting, as a whole attribute or as the body of a drift.
#[test]
fn arbitrary_token_streams_never_panic() {
    let mut random = Random(11);
    let mut donor = Vec::new();
    for attribute in VALID {
        flatten(attribute.parse().unwrap(), &mut donor);
    }
    for i in 0..1200 {
        let tokens = arbitrary(&mut random, &donor, 0);
        let attribute = match i % 4 {
            0 => tokens,
            1 => quote::quote! { drift = |q, p| { #tokens }, embedding = Midpoint },
            2 => quote::quote! { drift = |q, p| q * p, embedding = [Midpoint, #tokens] },
            _ => quote::quote! { drift = |[x, y], _| x, noise = [|#tokens| y], embedding = Midpoint },
        };
        let item = if i % 16 == 0 { arbitrary(&mut random, &donor, 0) } else { STRUCT.parse().unwrap() };
        expands(attribute, item);
    }
}

fn arbitrary(random: &mut Random, donor: &[TokenTree], depth: usize) -> TokenStream {
    (0..random.below(12))
        .map(|_| {
            if random.below(6) > 0 || depth > 4 {
                return donor[random.below(donor.len())].clone();
            }
            let delimiters = [Delimiter::Parenthesis, Delimiter::Bracket, Delimiter::Brace, Delimiter::None];
            let delimiter = delimiters[random.below(4)];
            Group::new(delimiter, arbitrary(random, donor, depth + 1)).into()
        })
        .collect()
}

/// Integers that may leave their lists, guarded or not, in all forms of a state: code or an error of the
/// user's.
#[test]
fn indices_reach_no_internal_error() {
    let indices = [
        "(i - 1) % SIZE",
        "(i - self.n as usize) % SIZE",
        "(2 * i) / 3",
        "i.abs_diff(3)",
        "(i * i) % SIZE",
        "(i - 1).max(0)",
        "self.order[i]",
        "self.order[(i - 1) % 3]",
    ];
    let terms = [
        "q[INDEX] * p[i]",
        "if a > 0.0 { q[INDEX] } else { p[i] }",
        "if i % 3 != 0 { q[INDEX] } else { p[i] }",
        "{ let f = |j: usize| q[j] * (0..j).map(|k| p[k] * q[INDEX]).sum::<f64>(); f(i) }",
        "q[1..].iter().map(|x| x * q[INDEX]).sum::<f64>()",
    ];
    let item = "struct S<const N: usize> { a: f64, n: u32, order: Vec<usize> }";
    for (state, size) in [("[f64; 3]", "3"), ("[f64; 20]", "20"), ("[f64; N]", "N"), ("&[f64]", "q.len()")] {
        for (index, term) in indices.iter().flat_map(|index| terms.map(|term| (index, term))) {
            let term = term.replace("INDEX", index).replace("SIZE", size);
            let sum = format!("(0..{size}).map(|i| 0.5 * p[i] * p[i] + {term}).sum::<f64>()");
            let attribute = format!("drift = |q: {state}, p: {state}| {sum}, embedding = Midpoint");
            let text = expand(attribute.parse().unwrap(), item.parse().unwrap()).to_string();
            assert!(!text.contains("this is a bug"), "{attribute}");
        }
    }
}

/// Hamiltonians at the edge of what numbers and graphs can hold, through the whole compiler, with every kind
/// of scheme. The result must be code or errors; `tests/accepted/constants_only.rs` runs the shorter ones.
#[test]
fn nasty_hamiltonians_compile_or_are_refused() {
    let unary = [
        "sqrt", "cbrt", "exp", "exp2", "exp_m1", "ln", "ln_1p", "log2", "log10", "sin", "cos", "tan", "asin",
        "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "abs", "signum", "recip", "erf",
        "erfc", "sinc", "j0", "j1",
    ];
    let mut bodies = twice(&unary);
    for f in unary {
        for number in ["0.0", "1.0", "(-1.0)", "1e308", "1e-320", "1e400", "0.5"] {
            bodies.push(format!("{number}.{f}() * q * p"));
        }
    }
    let sum: Vec<String> = (0..300).map(|i| format!("(q - {i}.25).powi(2) * p")).collect();
    bodies.push(sum.join(" + "));
    bodies.push(format!("{}q{}", "(1.0 + ".repeat(60), " * p).sin()".repeat(60)));
    bodies.push(format!("q{} + p", ".sin()".repeat(100)));
    bodies.push(format!("p * p + q{}", " / (1.0 + q * q)".repeat(100)));
    bodies.push((0..14).fold("q * p".to_owned(), |inner, _| format!("({inner}).powi(2)")));
    bodies.push(
        (0..8).fold("q".to_owned(), |inner, i| format!("if q > {i}.5 * p {{ {inner} }} else {{ p * q }}")),
    );
    bodies.extend(NASTY.iter().map(|&body| body.to_owned()));
    assert!(bodies.len() > 400);
    for (i, body) in bodies.iter().enumerate() {
        // All schemes for some, two of them for each.
        let schemes = match i % 24 {
            0 => "Corrected<DeltaPlus>, Midpoint, Uncorrected<Lambda<1, 3>>, Mixed<DeltaMinus, Midpoint>",
            i if i % 2 == 0 => "Uncorrected<DeltaPlus>",
            _ => "Midpoint",
        };
        let attribute = format!("drift = |q, p| {body}, embedding = [{schemes}]");
        expands(attribute.parse().unwrap(), STRUCT.parse().unwrap());
    }
    for body in NASTY {
        let attribute = format!(
            "drift = |q, p| 0.5 * p * p, noise = [|q, p| {body}], embedding = [DeltaPlus, Corrected<DeltaMinus>], \
             invariant = [|q, p| {body}]"
        );
        expands(attribute.parse().unwrap(), STRUCT.parse().unwrap());
    }
}

/// One function of another: each of them outside of every third, and inside of every third.
fn twice(unary: &[&str]) -> Vec<String> {
    let pairs = unary
        .iter()
        .enumerate()
        .flat_map(|(i, outer)| unary[i % 3..].iter().step_by(3).map(move |inner| (outer, inner)));
    pairs.map(|(outer, inner)| format!("0.5 * p * p + (q * q - 0.5).{inner}().{outer}()")).collect()
}

const NASTY: [&str; 38] = [
    "q / 0.0",
    "0.0 / 0.0",
    "q * p / (1.0 - 1.0)",
    "0.0.powi(-1) + q",
    "q.powi(0) + p.powf(0.0)",
    "q.powi(-2147483648) * p",
    "q.powi(2147483647) * p.powi(-2147483647)",
    "q.powf(1e300) + p",
    "q.powf(p) + p.powf(q)",
    "(-1.0).powf(0.5) * q",
    "1e400 * q",
    "1e-400 * q + p",
    "-1e400 + 1e400 * p",
    "1e308 * 1e308 * q * p",
    "f64::NAN * q + p",
    "f64::INFINITY + q",
    "(f64::MAX + f64::MIN_POSITIVE) * q",
    "0.1 + 0.2 - 0.3 + q * 1e16 - p * 1e-16",
    "170141183460469231731687303715884105727i128 as f64 * q",
    "(170141183460469231731687303715884105727 - 1) as f64 + q",
    "-170141183460469231731687303715884105728 as f64 + q",
    "9007199254740993 as f64 * q",
    "{}",
    "{ {} q }",
    "{ ; q }",
    "()",
    "1.0",
    "q",
    "p",
    "0.0 * q",
    "q - q + p - p",
    "if 1.0 < 2.0 { q } else { 1.0 / 0.0 }",
    "if f64::NAN < 1.0 { q } else { p }",
    "if q > 0.0 { 1.0 / q } else { if q == q { p } else { q } }",
    "if 0.1 + 0.2 == 0.3 { q } else { p * p }",
    "q.atan2(q) + p.hypot(p) + q.min(q) + p.max(-p) + q.clamp(1.0, 0.0)",
    "{ let r#type = q; let ω = p; let _x = r#type * ω; _x + r#a }",
    "{ let q = q; let q = q * q; let p = q; p * q }",
];

/// Exponents that double, or grow as Fibonacci's numbers, with each `let`: the factors are counted, never
/// written out. Each line adds a bounded number of nodes, and the whole expansion is as short as its text.
#[test]
fn towers_of_powers_stay_as_small_as_their_text() {
    for lines in [10, 32] {
        for (start, step) in [
            ("let v = q;", "let v = v * v;"),
            ("let v = 0.5 * q * p + 1.0;", "let v = v * v;"),
            ("let v = q * p;", "let v = v.powi(2);"),
            ("let v = 1.0 / (q * p);", "let v = v * v;"),
            ("let v = 3.0 * q;", "let v = v * v;"),
            ("let u = q; let v = p;", "let w = u * v; let u = v; let v = w;"),
            ("let u = 3.0 * q; let v = 7.0 * p;", "let w = u * v; let u = v; let v = w;"),
            ("let u = q + 1.0; let v = 2.0 * q;", "let w = u * v; let u = v; let v = w;"),
            ("let v = q + q.cos() * p;", "let v = 3.0 * v + v;"),
            ("let v = q + q.cos() * p;", "let v = a * v + sigma * v;"),
            ("let v = q + q.cos() * p;", "let v = a * v + q * v;"),
            (
                "let v = q + q.cos() * p; let u = p;",
                "let w = a * v + sigma * u; let u = sigma * v + a * u; let v = w;",
            ),
        ] {
            let attribute = format!(
                "drift = |q, p| {{ {start} {} p * p + v }}, embedding = Midpoint",
                step.repeat(lines)
            );
            let model = super::model_of(&attribute, STRUCT).unwrap();
            let nodes = model.graph.reachable(&[model.drift]).len();
            assert!(nodes <= 8 * lines + 40, "{lines} of {step}: {nodes} nodes");
            if lines == 32 {
                let output = expand(attribute.parse().unwrap(), STRUCT.parse().unwrap()).to_string();
                assert!(output.len() < 4_000_000, "{step}: {} characters", output.len());
            }
        }
    }
}

#[test]
fn malformed_inputs_never_panic() {
    for attribute in [
        "",
        ",",
        "=",
        "drift",
        "drift =",
        "drift = ,",
        "= |q, p| q",
        "drift = embedding = Midpoint",
        "drift = |",
        "drift = ||",
        "drift = || 1.0, embedding = Midpoint",
        "drift = |q, p|, embedding = []",
        "drift == |q, p| q",
        "drift => 1",
        "drift = |q, p| q embedding = Midpoint",
        "embedding = [,]",
        "embedding = Lambda<>",
        "embedding = Lambda<1, 0>",
        "embedding = Lambda<{ 1 }, 2>",
        "embedding = dyn Fn()",
        "noise = [|q, p, k| q; 3]",
        "crate = 5",
        "crate = ::",
        "drift = async |q, p| q, embedding = Midpoint",
        "drift = |q: [f64; 99999999999], p| 0.0, embedding = Midpoint",
        "drift = |q: [[[[f64; 99999999999]; 99999999999]; 99999999999]; 99], _| 0.0",
        "drift = |q: [f64; 0], p| 1.0",
        "drift = |q, p| (0..1000000000000).map(|i| q).sum()",
        "drift = |q, p| [q; 1000000000][3]",
        "drift = |q, p| { let f = |x| x + x; let f = |x| f(f(x)); let f = |x| f(f(x)); let f = |x| f(f(x)); let f = |x| \
         f(f(x)); let f = |x| f(f(x)); let f = |x| f(f(x)); let f = |x| f(f(x)); let f = |x| f(f(x)); f(q) }",
        "drift = |q, p| (0..).sum()",
        "drift = |q, p| i128::MAX + q.powi(9999999999)",
        "drift = |q, p| (0..=i)",
        "drift = |q, p| 170141183460469231731687303715884105727 + 1",
        "drift = |q, p| -(5 / 0) % 0",
        "drift = |q, p| q[18446744073709551616..2]",
        "drift = |q, p| [q][1..0]",
        "drift = |q, p| (9..0).windows(0)",
        "drift = |q, p| { let (a, .., b, ..) = (q, p); a }",
        "drift = |q, p| { let [a, b, .., c] = [q]; a }",
    ] {
        for item in [
            STRUCT,
            "enum E {}",
            "union U { a: u8 }",
            "fn f() {}",
            "struct U;",
            "struct T(f64, f32);",
            "",
            "struct",
        ] {
            expands(attribute.parse().unwrap(), item.parse().unwrap());
        }
    }
}

/// Integers that grow with each turn, families of any size, and names that are keywords.
#[test]
fn integers_are_bounded() {
    let repeated = |line: &str, times: usize| {
        format!(
            "(0..q.len()).map(|i| {{ let mut k = i; for _ in 0..{times} {{ {line} }} q[k] * p[i] }}).sum::<f64>()"
        )
    };
    let extremes = |by: &str| {
        let sum: Vec<String> = (2..24).map(|j| format!("(i + {j} * some).{by}(i * {j} + a_few)")).collect();
        format!("(0..q.len()).map(|i| if {} < i {{ q[i] }} else {{ p[i] }}).sum::<f64>()", sum.join(" + "))
    };
    let bodies = [
        repeated("k = k / 2;", 1500),
        repeated("k = next[k];", 1500),
        repeated("k = k * k;", 60),
        repeated("k = k.min(k / 3) + k.max(k % 5);", 60),
        repeated("k = k.pow(7);", 60),
        format!(
            "{{ let v = q; {} v.len() as f64 * p[0] }}",
            "let v = v.iter().skip(a_few).zip(v.iter().skip(some)).map(|(x, y)| x * y);".repeat(50)
        ),
        "(0..20000).map(|j| next[j] + 1).product::<usize>() as f64 * q[0] * p[0]".to_owned(),
        extremes("min"),
        extremes("max"),
        (0..24).fold("i".to_owned(), |k, j| format!("({k}).min(i / {} + some)", j + 2)),
        "(-170141183460469231731687303715884105727 - 1) as f64 * q[0]".to_owned(),
        "q[0] * (p.len() * (-170141183460469231731687303715884105727 - 1)) as f64".to_owned(),
        "(0..q.len()).map(|i| q[i * (-170141183460469231731687303715884105727 - 1)]).sum()".to_owned(),
        "q[0].r#match() + f64::r#type(q[0])".to_owned(),
        format!(
            "{{ let a = 1.0; {} a * p[0] }}",
            "let a = (0..q.len()).map(|i| a * q[i]).sum::<f64>();".repeat(400)
        ),
        format!(
            "{{ let f = |x| x; {} f(q[0]) * p[0] }}",
            "let f = |x| (0..q.len()).map(|i| f(x * q[i])).sum::<f64>();".repeat(400)
        ),
    ];
    let item = "struct System { n: i32, a_few: usize, some: usize, next: Vec<usize> }";
    for body in bodies {
        let attribute = format!("drift = |q: &[f64], p: &[f64]| {body}, embedding = Midpoint");
        expands(attribute.parse().unwrap(), item.parse().unwrap());
    }
    for (closure, count) in [("q * k as f64", "200000"), ("q.powi(k)", "9999999999"), ("q.powi(k)", "20001")]
    {
        let attribute =
            format!("drift = |q, p| q * p, noise = [|q, p, k| {closure}; {count}], embedding = Midpoint");
        expands(attribute.parse().unwrap(), item.parse().unwrap());
    }
}

/// Streams that nest as deeply as the guard lets through, or deeper, in a thread of the usual 2 MiB.
#[test]
fn deep_inputs_do_not_overflow_the_stack() {
    let mut cases: Vec<String> = Vec::new();
    for depth in [60, 100, 150, 2100, 4000, 8000] {
        let wrap = |open: &str, close: &str| format!("{}q{}", open.repeat(depth), close.repeat(depth));
        cases.push(wrap("- - - - (", ")"));
        cases.push(wrap("(- - |x| - ", ")"));
        cases.push(wrap("(return x = ", ")"));
        cases.push(wrap("{ fn f() { ", " } q }"));
        cases.push(wrap("{ let x: [u8; { ", " }] = q; }"));
        cases.push(wrap("match q { _ => ", " }"));
        cases.push(wrap("f::<{ ", " }>()"));
        cases.push(wrap("(", ")"));
        cases.push(wrap("[", "]"));
        cases.push(wrap("{", "}"));
        cases.push(wrap("(-", ")"));
        cases.push(wrap("f64::sin(", ")"));
        cases.push(wrap("q[", "]"));
        cases.push(wrap("{ let x = ", "; x }"));
        cases.push(wrap("(|x| ", ")(q)"));
        cases.push(wrap("q * (p + ", ")"));
        cases.push(wrap("if q > 0.0 { ", " } else { p }"));
        for unit in [
            "- ",
            "! ",
            "& ",
            "* ",
            "|x| ",
            "if q > 0.0 { q } else ",
            "return ",
            "x = ",
            ".. ",
            "q + ",
            "q * q + ",
            "x += ",
            "break ",
            "move || ",
        ] {
            cases.push(wrap(unit, ""));
        }
        for unit in [
            "- - - (",
            "- - |x| ",
            "x = - - ",
            "(- ",
            "fn() -> ",
            "dyn Fn(",
            "if ",
            "{ fn f() { ",
            "match ",
            "as Vec<",
        ] {
            cases.push(wrap(unit, ""));
            cases.push(format!("q as {}u8", unit.repeat(depth)));
            cases.push(format!("q as {}u8{}", unit.repeat(depth), ")".repeat(depth)));
        }
        for unit in [" + q", " - q * p", " as f64", ".sin()", ".0", "[0]", "?", "()", " < q", " && q", " ..q"]
        {
            cases.push(wrap("", unit));
        }
        let mut lets = String::from("{ let f = |x| x; let l = [q];");
        for _ in 0..depth {
            lets.push_str("let f = |x| f(x); let l = [l];");
        }
        write!(lets, " f(q) }}").unwrap();
        cases.push(lets);
        cases.push(format!("q as {}f64{}", "Vec<".repeat(depth), " >".repeat(depth)));
        cases.push(format!("|{}x{}| q", "(".repeat(depth), ")".repeat(depth)));
        cases.push(format!("*a{}", " + q".repeat(depth)));
        cases.push(format!("q, force = |q, p| q{}", " + q".repeat(depth)));
    }
    for case in cases {
        let attribute = format!("drift = |q, p| {case}, embedding = Midpoint");
        // The lexer of the tests recurses, too; `rustc` refuses what it cannot read.
        let Ok(tokens) = attribute.parse::<TokenStream>() else { continue };
        let output = expand(tokens, STRUCT.parse().unwrap());
        drop(output);
    }
}
