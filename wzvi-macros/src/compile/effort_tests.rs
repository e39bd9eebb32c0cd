//! The cost of an expansion, in nodes of expressions: `cargo test -p wzvi-macros effort_of -- --nocapture` prints the table.

#![allow(clippy::unwrap_used)]

use super::{expand, golden_tests};
use crate::symbolic::tests::effort;

/// Nodes for each embedding: more than twice those of the largest scene.
const ALLOWED: u64 = 50_000;

/// Beside the golden scenes, a long Hamiltonian and all kinds of embeddings of one with noise: name, the attribute's arguments, the struct,
/// the number of embeddings.
const MORE: [(&str, &str, &str, u64); 3] = [
    (
        "double_well",
        "drift = |q, p| 0.5 * p * p + 0.25 * (q * q - 1.0).powi(2), noise = [|q, p| sigma * q * p], \
         embedding = [Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Midpoint, Uncorrected<Lambda<1, 4>>, \
             Corrected<DeltaPlus>, Mixed<DeltaPlus, Midpoint>]",
        "struct Well { sigma: f64 }",
        6,
    ),
    (
        "kepler",
        "drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - mu / (x * x + y * y).sqrt(), \
         invariant = [|[x, y], [px, py]| x * py - y * px], embedding = [DeltaPlus, Midpoint]",
        "struct Kepler { mu: f64 }",
        2,
    ),
    (
        "double_pendulum",
        "drift = |[a, b], [pa, pb]| (m2 * l2 * l2 * pa * pa + (m1 + m2) * l1 * l1 * pb * pb \
             - 2.0 * m2 * l1 * l2 * pa * pb * (a - b).cos()) \
             / (2.0 * m2 * l1 * l1 * l2 * l2 * (m1 + m2 * (a - b).sin().powi(2))) \
             - (m1 + m2) * g * l1 * a.cos() - m2 * g * l2 * b.cos(), embedding = [DeltaPlus, Midpoint]",
        "struct DoublePendulum { m1: f64, m2: f64, l1: f64, l2: f64, g: f64 }",
        2,
    ),
];

#[test]
fn effort_of_every_scene() {
    println!("{:18}{:>11}{:>17}{:>11}", "scene", "embeddings", "nodes/embedding", "characters");
    let mut slow = Vec::new();
    // One embedding each, as far as the bound is concerned.
    let golden = golden_tests::SCENES.map(|(name, attribute, item)| (name, attribute, item, 1));
    for (name, attribute, item, count) in golden.into_iter().chain(MORE) {
        let (nodes, expansion) = effort::of(|| expand(attribute.parse().unwrap(), item.parse().unwrap()));
        let text = expansion.to_string();
        assert!(!text.contains("compile_error"), "{name}: {text}");
        let each = nodes / count;
        println!("{name:18}{count:>11}{each:>17}{:>11}", text.len());
        if each >= ALLOWED {
            slow.push((name, each));
        }
    }
    assert!(slow.is_empty(), "more than {ALLOWED} nodes per embedding: {slow:?}");
}

/// No increment, no noise term, no solver that an explicit step does not need.
#[test]
fn a_deterministic_scene_mentions_no_noise() {
    let attribute = "drift = |q, p| 0.5 * p * p - q.cos(), embedding = DeltaPlus";
    let text = expand(attribute.parse().unwrap(), "struct Pendulum;".parse().unwrap()).to_string();
    for word in ["let dw =", "Wiener", "noise_energy", "newton", "Factor", "Extrapolation"] {
        assert!(!text.contains(word), "{word} in {text}");
    }
}
