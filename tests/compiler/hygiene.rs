//! Generated code in the worst surroundings: `tests/hygiene` is a crate without a prelude, with `wzvi` under another
//! name, with everything shadowed and with every lint denied. Clippy reads it where there is a clippy.
//!
//! One of its modules is written here: every word of the expansions in `golden` is a field, a coordinate, a constant, a type and a
//! generic parameter in it.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

const KEYWORDS: [&str; 34] = [
    "_", "as", "break", "const", "continue", "crate", "else", "enum", "extern", "false", "fn", "for", "if",
    "impl", "in", "let", "loop", "match", "mod", "move", "mut", "pub", "ref", "return", "self", "Self",
    "static", "struct", "trait", "true", "type", "use", "where", "while",
];

/// The words of all expansions that may be names, without those of comments and literals.
fn golden_words() -> BTreeSet<String> {
    let mut words = BTreeSet::new();
    for file in
        std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/golden")).expect("there are expansions")
    {
        let text = std::fs::read_to_string(file.expect("a file").path()).expect("a text");
        // The documentation of the struct.
        let code = text.split("/**").map(|part| part.split_once("*/").map_or(part, |(_, code)| code));
        for line in code.flat_map(str::lines) {
            let line = line.split("//").next().unwrap_or_default();
            let spoken = line
                .split('"')
                .step_by(2)
                .flat_map(|part| part.split(|c: char| !c.is_alphanumeric() && c != '_'));
            words.extend(
                spoken
                    .filter(|word| word.starts_with(|c: char| c == '_' || c.is_alphabetic()))
                    .map(str::to_owned),
            );
        }
    }
    words.retain(|word| !KEYWORDS.contains(&word.as_str()));
    words
}

/// Systems with all of the words.
fn systems(words: &[&str]) -> String {
    let all = |wrap: &dyn Fn(&str) -> String, separator: &str| {
        words.iter().map(|word| wrap(word)).collect::<Vec<_>>().join(separator)
    };
    let (real, schemes) = (
        "::core::primitive::f64",
        "embedding = [::renamed::embedding::Midpoint, ::renamed::embedding::Verlet, \
        ::renamed::embedding::Gauss<2>], crate = ::renamed",
    );
    let fields = all(&|word| format!("{word}: {real}"), ", ");
    let sum = all(&|word| word.to_owned(), " + ");
    let small = |rate: &str| {
        format!(
            "drift = |coordinate, momentum| 0.5 * momentum * momentum * (1.0 + coordinate * coordinate) + ({rate}) * coordinate.sin(), \
             noise = [|coordinate, momentum| ({rate}) * coordinate * momentum]"
        )
    };
    let large = |rate: &str| {
        format!(
            "drift = |all_q: &[{real}], all_p: &[{real}]| all_p.iter().map(|each| 0.5 * each * each).sum::<{real}>() \
             + (1..all_q.len()).map(|each| ({rate}) * (all_q[each] - all_q[each - 1]).powi(4)).sum::<{real}>(), \
             noise = [|all_q: &[{real}], all_p: &[{real}], each| ({rate}) * all_q[each]; 3]"
        )
    };
    let mut text = String::from("use ::core::iter::Iterator as _;\n\n");
    for (name, declared) in [("Small", small(&sum)), ("Large", large(&sum))] {
        text += &format!(
            "#[::renamed::hamiltonian({declared}, {schemes})]\nstruct {name}Fields {{ {fields} }}\n\n"
        );
    }
    for (n, part) in words.chunks(32).filter(|part| part.len() > 1).enumerate() {
        let (q, p) = part.split_at(part.len() / 2);
        let p = &p[..q.len()];
        let squares = |list: &[&str]| {
            list.iter().map(|word| format!("{word} * {word} * {word}")).collect::<Vec<_>>().join(" + ")
        };
        text += &format!(
            "#[::renamed::hamiltonian(drift = |[{}], [{}]| {} + {}, {schemes})]\nstruct Coordinates{n};\n\n",
            q.join(", "),
            p.join(", "),
            squares(q),
            squares(p),
        );
    }
    // Names that the generated code derives from those of its coordinates and fields.
    let derived =
        ["node_momentum", "delta_momentum", "delta_coordinate", "coordinate_squared", "rate_squared"];
    let constant = |word: &&str| format!("const {word}: {real} = 1.0; struct {word} {{}}\n");
    let around: String = words.iter().chain(&derived).map(constant).collect();
    let timed = small("rate * (1.0 + time)").replace("momentum|", "momentum, time|");
    let corrected = "[::renamed::embedding::Corrected<::renamed::embedding::DeltaPlus>, ";
    let more = schemes.replace('[', corrected);
    text += &format!(
        "mod around {{\nuse ::core::iter::Iterator as _;\n{around}\n\
         #[::renamed::hamiltonian({timed}, invariant = |_, _| 1.0, {more})]\nstruct Small0 {{ rate: {real} }}\n\
         #[::renamed::hamiltonian({}, {more})]\nstruct Large0 {{ rate: {real} }}\n}}\n\n",
        large("rate"),
    );
    let types = all(&|word| word.to_owned(), ", ");
    let sizes = all(&|word| format!("const {word}: ::core::primitive::usize"), ", ");
    for (name, declared) in [("Small", small("rate")), ("Large", large("rate"))] {
        text += &format!(
            "#[::renamed::hamiltonian({declared}, {schemes})]\nstruct {name}Types<{types}> {{ rate: {real}, types: \
             ::core::marker::PhantomData<fn() -> ({types})> }}\n\n#[::renamed::hamiltonian({declared}, {schemes})]\nstruct {name}Sizes<{sizes}> \
             {{ rate: {real} }}\n\n",
        );
    }
    text
}

#[test]
#[ignore = "calls Cargo, for minutes: part of .ci/release"]
fn generated_code_depends_on_nothing_around_it() {
    let words = golden_words();
    let text = systems(&words.iter().map(String::as_str).collect::<Vec<_>>());
    let names = Path::new(env!("CARGO_TARGET_TMPDIR")).join("golden_names.rs");
    std::fs::write(&names, text).expect("a file can be written");
    let folder = super::root().join("tests/hygiene");
    // The versions of the workspace: nothing is downloaded.
    std::fs::copy(super::root().join("Cargo.lock"), folder.join("Cargo.lock"))
        .expect("a file can be written");
    let cargo = || Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    let has_clippy =
        cargo().args(["clippy", "--version"]).output().is_ok_and(|output| output.status.success());
    let output = cargo()
        .arg(if has_clippy { "clippy" } else { "check" })
        .args(["--offline", "--quiet", "--manifest-path"])
        .arg(folder.join("Cargo.toml"))
        // That of clippy for the workspace, where most of the dependencies are.
        .arg("--target-dir")
        .arg(concat!(env!("CARGO_TARGET_TMPDIR"), "/.."))
        .env("GOLDEN_NAMES", &names)
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
