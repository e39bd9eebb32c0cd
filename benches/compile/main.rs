//! How long a system takes to compile: expansion and `rustc` together, by the size of the system and scene by scene.
//!
//! `cargo bench --bench compile` builds a chain of N = 32, 1024 and 10^6 sites, a constant of the program, that takes one
//! step of each of two schemes, and the scenes of `examples/` with many bodies or sites. What they depend on is built
//! before; the best of two counts. Each build is forced by a `--cfg` that nothing asks for.
//!
//! On Linux the seconds are those of the processor, over all threads of `rustc`, so that other programs do not count;
//! elsewhere those of the clock.
//!
//! A name after `--` picks: `cargo bench --bench compile -- chain`.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

const SCENES: [&str; 6] = ["fput", "sine_gordon", "solar_system", "lattice_2d", "lennard_jones", "network"];
const REPETITIONS: u32 = 2;

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let only = std::env::args().skip(1).find(|argument| !argument.starts_with("--"));
    let wanted = |name: &str| only.as_ref().is_none_or(|only| name.contains(only.as_str()));
    println!("Release build of one program, seconds (expansion and rustc; best of {REPETITIONS})\n");
    let mut first = None;
    for sites in [32, 1024, 1_000_000].into_iter().filter(|_| wanted("chain")) {
        let folder = chain(root, sites)?;
        let took = best(|again| {
            let mut cargo = cargo("rustc", &folder);
            cargo.arg("--target-dir").arg(root.join("target/wzvi/compile/target")).args(forced(again));
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
            let mut cargo = cargo("rustc", root);
            cargo.args(["--example", scene]).args(forced(again));
            cargo
        })?;
        println!("  examples/{:24} {took:>8.2}", format!("{scene}.rs"));
    }
    Ok(())
}

fn cargo(command: &str, folder: &Path) -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(folder).args([command, "--release", "--offline", "--quiet"]);
    cargo
}

fn forced(again: u32) -> [String; 3] {
    ["--".into(), "--cfg".into(), format!("again_{}_{again}", std::process::id())]
}

/// Seconds of the fastest of some builds, after one that builds what it depends on.
fn best(mut build: impl FnMut(u32) -> Command) -> Result<f64, Box<dyn Error>> {
    let mut fastest = f64::INFINITY;
    for again in 0..=REPETITIONS {
        let (start, before) = (Instant::now(), processor());
        let status = build(again).status()?;
        if !status.success() {
            return Err(format!("a build failed: {status}").into());
        }
        if again > 0 {
            let clock = start.elapsed().as_secs_f64();
            fastest = fastest.min(before.zip(processor()).map_or(clock, |(before, after)| after - before));
        }
    }
    Ok(fastest)
}

/// Seconds of the processor that the children of this process took: fields 16 and 17 of `/proc/self/stat`, in hundredths.
fn processor() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let (_, fields) = stat.rsplit_once(')')?;
    let ticks = fields.split_whitespace().skip(13).take(2).map(|field| field.parse::<f64>().ok());
    Some(0.01 * ticks.sum::<Option<f64>>()?)
}

/// A package with a chain of `sites` particles under `target/wzvi/compile`.
fn chain(root: &Path, sites: usize) -> Result<PathBuf, Box<dyn Error>> {
    let folder = root.join("target/wzvi/compile").join(format!("chain_{sites}"));
    std::fs::create_dir_all(folder.join("src"))?;
    let manifest = format!(
        "[package]\nname = \"chain_{sites}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[workspace]\n\n\
         [dependencies]\nwzvi = {{ path = {root:?}, default-features = false }}\n"
    );
    std::fs::write(folder.join("Cargo.toml"), manifest)?;
    std::fs::copy(root.join("Cargo.lock"), folder.join("Cargo.lock"))?;
    std::fs::write(folder.join("src/main.rs"), PROGRAM.replace("1_000", &sites.to_string()))?;
    Ok(folder)
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
