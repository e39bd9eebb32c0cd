//! The cost of an expansion, in nodes of expressions: `cargo test -p wzvi-macros effort_of -- --nocapture` prints the table.

#![allow(clippy::unwrap_used)]

use super::expand;
use crate::symbolic::tests::effort;

/// Nodes for each embedding: twice those of the largest scene here.
const ALLOWED: u64 = 50_000;

const ALL: &str = "[Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Midpoint, Uncorrected<Lambda<1, 4>>, \
                   Corrected<DeltaPlus>, Mixed<DeltaPlus, Midpoint>]";

/// Name, the Hamiltonians, the embeddings and how many they are, and the struct.
const SCENES: [(&str, &str, &str, u64, &str); 8] = [
    (
        "kubo",
        "drift = |q, p| 0.5 * a * (q * q + p * p), noise = [|q, p| 0.5 * sigma * (q * q + p * p)], \
         invariant = [|q, p| q * q + p * p]",
        ALL,
        6,
        "struct Kubo { a: f64, sigma: f64 }",
    ),
    (
        "linear_sde",
        "drift = |q, p| a * q * p, noise = [|q, p| sigma * q * p]",
        ALL,
        6,
        "struct Linear { a: f64, sigma: f64 }",
    ),
    (
        "additive_noise",
        "drift = |q, p| 0.5 * (q * q + p * p), noise = [|_, p| sigma * p, |q, _| -gamma * q]",
        ALL,
        6,
        "struct Additive { sigma: f64, gamma: f64 }",
    ),
    (
        "double_well",
        "drift = |q, p| 0.5 * p * p + 0.25 * (q * q - 1.0).powi(2), noise = [|q, p| sigma * q * p]",
        ALL,
        6,
        "struct Well { sigma: f64 }",
    ),
    (
        "pendulum",
        "drift = |q, p| p * p / (2.0 * m * l * l) - m * g * l * q.cos()",
        "[DeltaPlus, Midpoint, DeltaMinus]",
        3,
        "struct Pendulum { m: f64, l: f64, g: f64 }",
    ),
    (
        "kepler",
        "drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - mu / (x * x + y * y).sqrt(), \
         invariant = [|[x, y], [px, py]| x * py - y * px]",
        "[DeltaPlus, Midpoint]",
        2,
        "struct Kepler { mu: f64 }",
    ),
    (
        "henon_heiles",
        "drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y) + x * x * y - y.powi(3) / 3.0",
        "[DeltaPlus, Midpoint]",
        2,
        "struct HenonHeiles;",
    ),
    (
        "double_pendulum",
        "drift = |[a, b], [pa, pb]| (m2 * l2 * l2 * pa * pa + (m1 + m2) * l1 * l1 * pb * pb \
             - 2.0 * m2 * l1 * l2 * pa * pb * (a - b).cos()) \
             / (2.0 * m2 * l1 * l1 * l2 * l2 * (m1 + m2 * (a - b).sin().powi(2))) \
             - (m1 + m2) * g * l1 * a.cos() - m2 * g * l2 * b.cos()",
        "[DeltaPlus, Midpoint]",
        2,
        "struct DoublePendulum { m1: f64, m2: f64, l1: f64, l2: f64, g: f64 }",
    ),
];

#[test]
fn effort_of_every_scene() {
    println!("{:18}{:>11}{:>17}{:>11}", "scene", "embeddings", "nodes/embedding", "characters");
    let mut slow = Vec::new();
    for (name, hamiltonians, embeddings, count, item) in SCENES {
        let attribute = format!("{hamiltonians}, embedding = {embeddings}");
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
