//! A run that can be stopped at any moment: Kepler's problem for a hundred million steps, with a checkpoint per second.
//!
//! ```sh
//! cargo run --release --example long_run            # press ^C, run it again: it resumes
//! cargo run --release --example long_run -- cost    # measures the cost of checkpoints
//! ```
//!
//! The last line is the same, bit for bit, however often the run was stopped. It resumes from
//! `target/wzvi/long_run.wzvi`; remove that file to start again.

use std::error::Error;
use std::path::Path;
use std::time::{Duration, Instant};

use wzvi::nalgebra::SVector;
use wzvi::prelude::*;
use wzvi::simulate::Simulation;

#[hamiltonian(
    drift = |[x, y], [px, py]| (px * px + py * py) / 2.0 - 1.0 / x.hypot(y),
    embedding = Midpoint,
)]
struct Kepler;

const STEPS: u64 = 100_000_000;

/// Eccentricity 0.5, semi-major axis 1, at perihelion.
fn kepler(steps: u64, every: u64) -> Simulation<'static, Kepler, Midpoint> {
    let start = State::<SVector<f64, 2>>::new([0.5, 0.0], [0.0, 3.0_f64.sqrt()]);
    Kepler.simulate(0.01).start(start).steps(steps).record_every(every)
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new("target/wzvi");
    std::fs::create_dir_all(folder)?;
    if std::env::args().nth(1).as_deref() == Some("cost") {
        return cost(folder);
    }
    let started = Instant::now();
    let file = folder.join("long_run.wzvi");
    let path = kepler(STEPS, 0).checkpoint(Checkpoint::to(file).every(Duration::from_secs(1))).run()?;
    println!("{:.1} s since it was started this time", started.elapsed().as_secs_f64());
    let bits: Vec<String> =
        path.last().q.iter().chain(&path.last().p).map(|x| format!("{:016x}", x.to_bits())).collect();
    println!("after {} steps: {}", path.steps(), bits.join(" "));
    Ok(())
}

/// Times runs of ten million steps, the best of five each.
fn cost(folder: &Path) -> Result<(), Box<dyn Error>> {
    const STEPS: u64 = 10_000_000;
    type Wants = fn(Checkpoint) -> Checkpoint;
    let cases: [(&str, u64, Option<Wants>); 7] = [
        ("no checkpoint", 0, None),
        ("at the end only", 0, Some(|to| to.every_steps(u64::MAX))),
        ("once a second", 0, Some(|to| to.every_steps(u64::MAX).every(Duration::from_secs(1)))),
        ("every million steps", 0, Some(|to| to.every_steps(1_000_000))),
        ("every thousand steps", 0, Some(|to| to.every_steps(1000))),
        ("no checkpoint, every tenth node recorded", 10, None),
        ("every million steps, every tenth node recorded", 10, Some(|to| to.every_steps(1_000_000))),
    ];
    println!("{:<48} {:>8} {:>12}", "checkpoint", "ns/step", "file, bytes");
    for (name, every, wants) in cases {
        let file = folder.join("cost.wzvi");
        let (mut best, mut size) = (f64::INFINITY, 0);
        for _ in 0..5 {
            let started = Instant::now();
            let run = kepler(STEPS, every);
            match wants {
                None => run.run()?,
                Some(wants) => run.checkpoint(wants(Checkpoint::to(&file))).run()?,
            };
            best = best.min(started.elapsed().as_secs_f64());
            size = std::fs::metadata(&file).map_or(0, |file| file.len());
            // Not every run has one.
            let _ = std::fs::remove_file(&file);
        }
        println!("{name:<48} {:>8.1} {size:>12}", best / STEPS as f64 * 1e9);
    }
    Ok(())
}
