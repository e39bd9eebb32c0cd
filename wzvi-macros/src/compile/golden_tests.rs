//! Golden expansions: what the compiler writes for representative systems, pretty-printed, to be reviewed as
//! differences. `GOLDEN=overwrite cargo test -p wzvi-macros golden` renews the files;
//! `cargo test --workspace --test compiler golden` compiles and runs them.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use super::expand;

/// The folder of the files: beside the tests of the facade, which compile them.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/compiler/golden");

/// Name, the attribute's arguments, the struct.
pub(super) const SCENES: [(&str, &str, &str); 17] = [
    (
        "pendulum",
        "drift = |q, p| 0.5 * p * p - omega * omega * q.cos(), embedding = Midpoint",
        "pub struct Pendulum { pub omega: f64 }",
    ),
    (
        "flows",
        "drift = [|q, p, t| 0.5 * p * p + 0.5 * omega * omega * q * q, |q, _, t| epsilon * q.powi(3) * t.cos()], \
         embedding = Verlet",
        "pub struct Perturbed { pub omega: f64, pub epsilon: f64 }",
    ),
    (
        "newton_block",
        "drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y) + x * x * y - y.powi(3) / 3.0, \
         embedding = Midpoint",
        "pub struct HenonHeiles;",
    ),
    (
        "noise",
        "drift = |q, p| 0.5 * a * (q * q + p * p), noise = [|q, p| 0.5 * sigma * (q * q + p * p)], \
         embedding = [Midpoint, Uncorrected<DeltaPlus>], invariant = |q, p| q * q + p * p",
        "pub struct Kubo { pub a: f64, pub sigma: f64 }",
    ),
    (
        "corrected",
        "drift = |q, p| 0.5 * p * p + 0.5 * q * q, noise = |q, p| sigma * q * p, embedding = Corrected<DeltaPlus>",
        "pub struct Multiplicative { pub sigma: f64 }",
    ),
    (
        "oscillators",
        "drift = |[x, y], [px, py]| 0.5 * (px * px / m + py * py / n) + 0.5 * k * (x * x + y * y) + c * x * y, \
         embedding = Midpoint",
        "pub struct Oscillators { pub m: f64, pub n: f64, pub k: f64, pub c: f64 }",
    ),
    (
        "branch",
        "drift = |q, p| 0.5 * p * p + 0.5 * q * q \
            + if q > edge && stiffness > 0.0 { 0.5 * stiffness * (q - edge).powi(2) } else { 0.0 }, \
         embedding = Midpoint",
        "pub struct Wall { pub edge: f64, pub stiffness: f64 }",
    ),
    (
        "forced",
        "drift = |q, p| 0.5 * p * p - q.cos(), force = |_q, _p, t| push * (2.0 * t).cos(), friction = gamma, \
         embedding = Midpoint",
        "pub struct Driven { pub push: f64, pub gamma: f64 }",
    ),
    (
        "bath",
        "drift = |[x, y], [px, py]| 0.5 * (px * px / m + py * py) + 0.25 * (x - y).powi(4), \
         damping = [[gamma, 0.1], [0.1, gamma]], temperature = kt, embedding = Baoab",
        "pub struct Heated { pub m: f64, pub gamma: f64, pub kt: f64 }",
    ),
    (
        "chain",
        "drift = |q: &[f64], p: &[f64]| { \
            let v = |d: f64| 0.5 * d * d + 0.25 * beta * d.powi(4); \
            p.iter().map(|p| 0.5 * p * p).sum::<f64>() \
                + (0..q.len() - 1).map(|i| v(q[i + 1] - q[i])).sum::<f64>() + v(q[0]) \
         }, embedding = Midpoint",
        "pub struct Chain { pub beta: f64 }",
    ),
    (
        "lattice",
        "drift = |q: [[f64; 2]; N], p: [[f64; 2]; N]| { \
            p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1])).sum::<f64>() \
                + (0..N).map(|i| { \
                    let [x, y] = [q[(i + 1) % N][0] - q[i][0], q[(i + 1) % N][1] - q[i][1]]; \
                    1.0 - (k * x).cos() + 0.5 * y * y \
                }).sum::<f64>() \
         }, embedding = DeltaPlus",
        "pub struct Lattice<const N: usize> { pub k: f64 }",
    ),
    (
        "all_pairs",
        "drift = |q: &[[f64; 2]], p: &[[f64; 2]]| { \
            (0..q.len()).map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]) / mass[i]).sum::<f64>() \
                - (0..q.len()).map(|i| (0..i).map(|j| { \
                    let (x, y) = (q[i][0] - q[j][0], q[i][1] - q[j][1]); \
                    g * mass[i] * mass[j] / (x * x + y * y).sqrt() \
                }).sum::<f64>()).sum::<f64>() \
         }, embedding = DeltaPlus",
        "pub struct Bodies { pub g: f64, pub mass: Vec<f64> }",
    ),
    (
        "network",
        "drift = |q: &[f64], p: &[f64]| { \
            p.iter().map(|p| 0.5 * p * p).sum::<f64>() \
                + bonds.iter().zip(strength).map(|(&[a, b], k)| k * (1.0 - (q[a] - q[b]).cos())).sum::<f64>() \
         }, embedding = DeltaPlus",
        "pub struct Network { pub bonds: Vec<[usize; 2]>, pub strength: Vec<f64> }",
    ),
    (
        "noise_family",
        "drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| 0.5 * (p[i] * p[i] + q[i] * q[i])).sum::<f64>(), \
         noise = [|q, p, k| sigma * q[k]; self.sites], embedding = Midpoint",
        "pub struct Bath { pub sigma: f64, pub sites: usize }",
    ),
    (
        "clock",
        "drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) / m - k / (x * x + y * y).sqrt(), clock = curvature, \
         embedding = Clocked<Verlet>",
        "pub struct Kepler { pub m: f64, pub k: f64 }",
    ),
    (
        "rod",
        "drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + g * y, \
         constraint = [|[x, y]| 0.5 * (x * x + y * y - l * l)], embedding = Rattle",
        "pub struct Rod { pub g: f64, pub l: f64 }",
    ),
    (
        "rods",
        "drift = |q: &[[f64; 2]], p: &[[f64; 2]]| \
            (0..N).map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]) + g * q[i][1]).sum(), \
         noise = [|q, p, k| sigma * q[k][0]; N], \
         constraint = [|q| 0.5 * (q[0][0] * q[0][0] + q[0][1] * q[0][1] - l * l), \
            [|q, k| 0.5 * ((q[k + 1][0] - q[k][0]).powi(2) + (q[k + 1][1] - q[k][1]).powi(2) - l * l); N - 1]], \
         embedding = Rattle",
        "pub struct Rods<const N: usize> { pub g: f64, pub l: f64, pub sigma: f64 }",
    ),
];

/// The expansion as a file that compiles by itself.
fn text(name: &str, attribute: &str, item: &str) -> String {
    let expansion = expand(attribute.parse().unwrap(), item.parse().unwrap());
    let file = syn::parse2(expansion).unwrap_or_else(|error| panic!("{name}: {error}"));
    let attribute: String = attribute.split("         ").map(str::trim).collect::<Vec<_>>().join(" ");
    format!(
        "// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from\n\
         //\n// #[hamiltonian({attribute})]\n// {item}\n\nuse wzvi::prelude::*;\n\n{}",
        prettyplease::unparse(&file)
    )
}

#[test]
fn golden_expansions_are_what_was_reviewed() {
    let overwrite = std::env::var("GOLDEN").is_ok_and(|wish| wish == "overwrite");
    let mut changed = Vec::new();
    for (name, attribute, item) in SCENES {
        let path = Path::new(FOLDER).join(format!("{name}.rs"));
        let now = text(name, attribute, item);
        let before = std::fs::read_to_string(&path).unwrap_or_default();
        if now == before {
            continue;
        }
        if overwrite {
            std::fs::create_dir_all(FOLDER).unwrap();
            std::fs::write(path, now).unwrap();
            continue;
        }
        let line =
            now.lines().zip(before.lines()).position(|(now, before)| now != before).unwrap_or_default();
        let excerpt = |text: &str| text.lines().skip(line).take(3).collect::<Vec<_>>().join("\n");
        changed.push(format!("{name}.rs:{}\nwas\n{}\nis\n{}\n", line + 1, excerpt(&before), excerpt(&now)));
    }
    assert!(
        changed.is_empty(),
        "{}\n`GOLDEN=overwrite cargo test -p wzvi-macros golden` renews them",
        changed.join("\n")
    );
}
