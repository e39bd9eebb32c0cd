//! How long a system takes to compile: expansion and `rustc` together, by the size of the system and scene by scene.
//!
//! `cargo bench --workspace --bench compile` builds a chain of N = 32, 1024 and 10^6 sites, a constant of the program, that takes one
//! step of each of two schemes, and the scenes of `examples/` with many bodies or sites. What they depend on is built
//! before; the best of two counts. Each build is forced by a `--cfg` that nothing asks for.
//!
//! On Linux the seconds are those of the processor, over all threads of `rustc`, so that other programs do not count;
//! elsewhere those of the clock.
//!
//! A name after `--` picks: `cargo bench --workspace --bench compile -- chain`.

mod build;

use std::error::Error;

use build::{REPETITIONS, best, cargo, forced, package, root};

const SCENES: [&str; 6] = ["fput", "sine_gordon", "solar_system", "lattice_2d", "lennard_jones", "network"];

fn main() -> Result<(), Box<dyn Error>> {
    let only = std::env::args().skip(1).find(|argument| !argument.starts_with("--"));
    let wanted = |name: &str| only.as_ref().is_none_or(|only| name.contains(only.as_str()));
    println!("Release build of one program, seconds (expansion and rustc; best of {REPETITIONS})\n");
    let mut first = None;
    for sites in [32, 1024, 1_000_000].into_iter().filter(|_| wanted("chain")) {
        let folder = package(&format!("chain_{sites}"), &PROGRAM.replace("1_000", &sites.to_string()))?;
        let took = best(|again| {
            let mut cargo = cargo("rustc", &folder);
            cargo.arg("--target-dir").arg(root().join("target/wzvi/compile/target")).args(forced(again));
            cargo
        })?;
        let base = *first.get_or_insert(took);
        println!(
            "  chain of {sites:>9} sites, DeltaPlus and Midpoint {took:>8.2}   ({:.2} of N = 32)",
            took / base
        );
    }
    println!();
    for scene in SCENES.into_iter().filter(|scene| wanted(scene)) {
        let took = best(|again| {
            let mut cargo = cargo("rustc", &root());
            cargo.args(["--example", scene]).args(forced(again));
            cargo
        })?;
        println!("  examples/{:24} {took:>8.2}", format!("{scene}.rs"));
    }
    Ok(())
}

const PROGRAM: &str = r#"use wzvi::prelude::*;

const SITES: usize = 1_000;

#[hamiltonian(
    drift = |q: [f64; SITES], p: [f64; SITES]| {
        let v = |d: f64| 0.5 * d * d + 0.25 * beta * d.powi(4);
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (1..SITES).map(|i| v(q[i] - q[i - 1])).sum::<f64>()
            + v(q[0])
            + v(q[SITES - 1])
    },
    embedding = [DeltaPlus, Midpoint],
)]
struct Chain {
    beta: f64,
}

fn main() -> Result<(), wzvi::Error> {
    let chain = Chain { beta: 0.25 };
    let mut q = vec![0.01; SITES];
    let mut p = vec![0.0; SITES];
    let mut memory = Default::default();
    Discretized::<DeltaPlus>::advance(&chain, &(), 0.0, 0.05, &mut q, &mut p, &[], &mut memory).ok();
    let mut memory = Default::default();
    Discretized::<Midpoint>::advance(&chain, &(), 0.0, 0.05, &mut q, &mut p, &[], &mut memory).ok();
    println!("{}", q[0]);
    Ok(())
}
"#;
