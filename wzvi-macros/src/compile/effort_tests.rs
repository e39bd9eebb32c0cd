//! The cost of an expansion, in nodes of expressions: `cargo test -p wzvi-macros effort_of -- --nocapture`
//! prints the table.

#![allow(clippy::unwrap_used)]

use proc_macro2::TokenStream;

use super::{expand, golden_tests};
use crate::symbolic::tests::effort;

/// Nodes for each embedding: more than twice those of the largest scene.
const ALLOWED: u64 = 50_000;

/// Beside the golden scenes, a long Hamiltonian and all kinds of embeddings of one with noise: name, the
/// attribute's arguments, the struct, the number of embeddings.
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

const SIZES: [(&str, &[usize]); 2] =
    [("bodies", &[2, 4, 6, 8, 9, 12, 16, 17]), ("chain", &[4, 6, 8, 12, 16, 17, 24])];

/// The systems of `cargo bench --workspace --bench choose`: attribute and struct.
fn sized(kind: &str, n: usize, scheme: &str) -> (String, String) {
    let (drift, fields) = match kind {
        "bodies" => (
            format!(
                "|q: [[f64; 3]; {n}], p: [[f64; 3]; {n}]| \
                 (0..{n}).map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1] + p[i][2] * p[i][2]) / mass[i]).sum::<f64>() \
                 - (0..{n}).map(|i| (0..i).map(|j| {{ \
                     let [x, y, z] = [q[i][0] - q[j][0], q[i][1] - q[j][1], q[i][2] - q[j][2]]; \
                     mass[i] * mass[j] / (x * x + y * y + z * z + 0.01).sqrt() }}).sum::<f64>()).sum::<f64>()"
            ),
            format!("mass: [f64; {n}]"),
        ),
        _ => (
            format!(
                "|q: [f64; {n}], p: [f64; {n}]| {{ let v = |d: f64| 0.5 * d * d + 0.25 * beta * d.powi(4); \
                 p.iter().map(|p| 0.5 * p * p).sum::<f64>() + (1..{n}).map(|i| v(q[i] - q[i - 1])).sum::<f64>() \
                 + v(q[0]) + v(q[{n} - 1]) }}"
            ),
            "beta: f64".to_owned(),
        ),
    };
    (format!("drift = {drift}, embedding = {scheme}"), format!("struct Sized {{ {fields} }}"))
}

/// Milliseconds of the processor that this thread took so far, where the system tells.
fn processor() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').next().and_then(|time| time.parse::<f64>().ok()).map_or(f64::NAN, |time| time * 1e-6)
}

/// An expansion costs at most half more than that of any larger size, or is that of a short system: below
/// this effort it takes some hundredths of a second, most of them for what does not depend on the size.
#[test]
fn effort_by_size() {
    const SHORT: u64 = 60_000;
    println!("size: nodes, characters, milliseconds of the processor");
    for (kind, sizes) in SIZES {
        for scheme in ["Midpoint", "Verlet", "Gauss<4>"] {
            let mut efforts = Vec::new();
            print!("{kind:8}{scheme:10}");
            for &n in sizes {
                let (attribute, item) = sized(kind, n, scheme);
                let (attribute, item): (TokenStream, TokenStream) =
                    (attribute.parse().unwrap(), item.parse().unwrap());
                let before = processor();
                let (nodes, expansion) = effort::of(|| expand(attribute, item));
                let (text, time) = (expansion.to_string(), processor() - before);
                assert!(!text.contains("compile_error"), "{kind} {n} {scheme}: {text}");
                print!("  {n}: {nodes}, {}, {time:.0}", text.len());
                efforts.push((n, nodes));
            }
            println!();
            for (at, &(n, nodes)) in efforts.iter().enumerate() {
                for &(larger, most) in &efforts[at..] {
                    let allowed = SHORT.max(most + most / 2);
                    assert!(
                        nodes <= allowed,
                        "{scheme}: {n} {kind} cost {nodes} nodes, {larger} cost {most}"
                    );
                }
            }
        }
    }
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
