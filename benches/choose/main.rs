//! What a system costs by its size, across the sizes at which the compiler changes from straight lines to loops.
//!
//! `cargo bench --workspace --bench choose` times steps: bodies in space, in nanoseconds per pair, and chains, per site.
//! `-- --build` builds a program with one system and one scheme for each size in release mode, and prints the seconds of
//! the processor that expansion and rustc take; what it depends on is built before. A name picks: `-- --build chain`.
//!
//! `cargo test -p wzvi-macros effort_by_size -- --nocapture` prints the expansions alone: processor time and characters.

#![allow(clippy::unwrap_used, reason = "a benchmark stops at the first error")]

#[path = "../compile/build.rs"]
mod build;

use std::hint::black_box;
use std::time::Instant;

use build::{best, cargo, forced, package, root};
use wzvi::prelude::*;
use wzvi::state::Vector;

const H: f64 = 0.02;

/// Bodies that attract each other, with softened forces.
macro_rules! bodies {
    ($name:ident, $n:literal, $($scheme:ty),*) => {
        #[hamiltonian(
            drift = |q: [[f64; 3]; $n], p: [[f64; 3]; $n]| {
                let kinetic: f64 = (0..$n)
                    .map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1] + p[i][2] * p[i][2]) / mass[i])
                    .sum();
                let pairs: f64 = (0..$n)
                    .map(|i| (0..i).map(|j| {
                        let [x, y, z] = [q[i][0] - q[j][0], q[i][1] - q[j][1], q[i][2] - q[j][2]];
                        mass[i] * mass[j] / (x * x + y * y + z * z + 0.01).sqrt()
                    }).sum::<f64>())
                    .sum();
                kinetic - pairs
            },
            embedding = [$($scheme),*],
        )]
        struct $name {
            mass: [f64; $n],
        }
    };
}

/// A Fermi-Pasta chain between walls.
macro_rules! chain {
    ($name:ident, $n:literal, $($scheme:ty),*) => {
        #[hamiltonian(
            drift = |q: [f64; $n], p: [f64; $n]| {
                let v = |d: f64| 0.5 * d * d + 0.25 * beta * d.powi(4);
                p.iter().map(|p| 0.5 * p * p).sum::<f64>()
                    + (1..$n).map(|i| v(q[i] - q[i - 1])).sum::<f64>()
                    + v(q[0])
                    + v(q[$n - 1])
            },
            embedding = [$($scheme),*],
        )]
        struct $name {
            beta: f64,
        }
    };
}

/// One system and one scheme.
struct Case {
    name: &'static str,
    size: usize,
    /// Pairs or sites.
    parts: usize,
    steps: fn(usize),
}

macro_rules! cases {
    ($(bodies: $($body:ident $bodies:literal),*;)? $(chains: $($chain:ident $sites:literal),*;)?) => {
        $($(bodies!($body, $bodies, Midpoint, Verlet, Gauss<4>);)*)?
        $($(chain!($chain, $sites, Midpoint, Verlet, Gauss<4>);)*)?

        fn cases() -> Vec<Case> {
            let mut cases = Vec::new();
            $($(
                cases.extend(cases!(@ "bodies", $bodies, $bodies * ($bodies - 1) / 2, 3 * $bodies,
                    $body { mass: black_box([1.0 / $bodies as f64; $bodies]) }));
            )*)?
            $($(
                cases.extend(cases!(@ "chain", $sites, $sites, $sites, $chain { beta: black_box(0.7) }));
            )*)?
            cases
        }
    };
    (@ $name:literal, $size:literal, $parts:expr, $degrees:expr, $system:expr) => {
        [
            Case {
                name: concat!($name, ", Midpoint"), size: $size, parts: $parts,
                steps: |steps| run::<Midpoint, _>(&$system, $degrees, steps),
            },
            Case {
                name: concat!($name, ", Verlet"), size: $size, parts: $parts,
                steps: |steps| run::<Verlet, _>(&$system, $degrees, steps),
            },
            Case {
                name: concat!($name, ", Gauss<4>"), size: $size, parts: $parts,
                steps: |steps| run::<Gauss<4>, _>(&$system, $degrees, steps),
            },
        ]
    };
}

cases! {
    bodies: Bodies2 2, Bodies4 4, Bodies6 6, Bodies8 8, Bodies9 9, Bodies12 12, Bodies16 16, Bodies17 17;
    chains: Chain4 4, Chain6 6, Chain8 8, Chain12 12, Chain16 16, Chain17 17, Chain24 24;
}

/// Some steps, from places on a helix that turns, so that bodies meet softly.
fn run<E, H: Discretized<E>>(system: &H, degrees: usize, steps: usize) {
    let mut stepper = system.stepper::<E>(self::H).unwrap();
    let mut state = State { q: H::Vector::zeros(degrees), p: H::Vector::zeros(degrees), t: 0.0 };
    for (i, q) in state.q.components_mut().iter_mut().enumerate() {
        let angle = (i / 3) as f64;
        *q = [angle.cos(), angle.sin(), 0.3 * angle][i % 3];
    }
    for (i, p) in state.p.components_mut().iter_mut().enumerate() {
        let angle = (i / 3) as f64;
        *p = [-angle.sin(), angle.cos(), 0.0][i % 3] * 3.0 / degrees as f64;
    }
    for _ in 0..steps {
        black_box(stepper.step(&mut state, &[]).unwrap());
    }
    black_box(state);
}

/// Nanoseconds per step and part: the shortest of some repetitions.
fn time(case: &Case) -> f64 {
    let steps = 20_000 / case.parts + 10;
    let once = || {
        let began = Instant::now();
        (case.steps)(steps);
        began.elapsed().as_secs_f64() * 1e9 / (steps * case.parts) as f64
    };
    (0..9).map(|_| once()).fold(f64::INFINITY, f64::min)
}

/// A program with the same system and one scheme.
fn program(case: &Case) -> String {
    let (kind, scheme) = case.name.split_once(", ").unwrap();
    let source = include_str!("main.rs");
    let of_macro = |name: &str| {
        let rest = source.split_once(&format!("\nmacro_rules! {name} {{")).unwrap().1;
        format!("macro_rules! {name} {{{}\n}}\n", rest.split_once("\n}\n").unwrap().0)
    };
    let (name, degrees, system) = match kind {
        "bodies" => ("bodies", 3 * case.size, format!("S {{ mass: [1.0; {}] }}", case.size)),
        _ => ("chain", case.size, "S { beta: 0.7 }".to_owned()),
    };
    format!(
        "use wzvi::prelude::*;\n{}\n{name}!(S, {}, {scheme});\n\nfn main() {{\n    let mut stepper = {system}.stepper::<{scheme}>(0.02).unwrap();\n    \
         let mut state = State::new([0.1; {degrees}], [0.0; {degrees}]);\n    stepper.step(&mut state, &[]).ok();\n    \
         println!(\"{{}}\", state.q[0]);\n}}\n",
        of_macro(name),
        case.size
    )
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let builds = arguments.iter().any(|argument| argument == "--build");
    let picked = arguments.iter().find(|argument| !argument.starts_with("--"));
    let cases = cases();
    let cases: Vec<&Case> =
        cases.iter().filter(|case| picked.is_none_or(|picked| case.name.contains(picked.as_str()))).collect();
    let mut names: Vec<&str> = cases.iter().map(|case| case.name).collect();
    names.sort_unstable();
    names.dedup();
    println!(
        "{}",
        if builds { "Seconds of the processor for a release build" } else { "ns per step and pair, or site" }
    );
    for name in names {
        print!("{name:18}");
        for case in cases.iter().filter(|case| case.name == name) {
            let cost = if builds {
                let folder = package(
                    &format!("choose_{}_{}", case.size, name.replace([',', ' ', '<', '>'], "")),
                    &program(case),
                )
                .unwrap();
                let build = |again| {
                    let mut cargo = cargo("rustc", &folder);
                    cargo
                        .arg("--target-dir")
                        .arg(root().join("target/wzvi/compile/target"))
                        .args(forced(again));
                    cargo
                };
                best(build).unwrap()
            } else {
                time(case)
            };
            print!("{:>12}", format!("{}: {cost:.1}", case.size));
        }
        println!();
    }
}
