//! Problems and figures that others published, run here.
//!
//! `cargo bench --workspace --bench peers` prints the tables of `docs/guide/peers.md`; a name after `--` picks, as in `-- pendulum`. Times of others are those of their machines.

#![allow(clippy::print_stdout, reason = "a benchmark talks")]

#[path = "../compile/build.rs"]
mod build;
#[path = "../order/planets.rs"]
mod planets;

use std::error::Error;
use std::time::Instant;

use build::{REPETITIONS, best, cargo, forced, package, root};
use wzvi::prelude::*;
use wzvi::report::duration;
use wzvi::section::Direction;
use wzvi::state::Vector;

/// `H = p²/2 - cos q`
#[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), embedding = [Verlet, Gauss<8>, Gauss<16>])]
struct Pendulum;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y) + x * x * y - y * y * y / 3.0,
    embedding = [Verlet, Gauss<8>, Gauss<16>],
)]
struct HenonHeiles;

#[hamiltonian(
    drift = |q: [[f64; 3]; 6], p: [[f64; 3]; 6]| {
        (0..6).map(|i| (0..3).map(|k| p[i][k] * p[i][k]).sum::<f64>() / (2.0 * mass[i])).sum::<f64>()
            - (0..6).map(|i| (0..i).map(|j| {
                let square: f64 = (0..3).map(|k| (q[i][k] - q[j][k]).powi(2)).sum();
                2.959_122_082_86e-4 * mass[i] * mass[j] / square.sqrt()
            }).sum::<f64>()).sum::<f64>()
    },
    embedding = [Verlet, Gauss<8>],
)]
struct SolarSystem {
    mass: [f64; 6],
}

/// Repetitions of a run, of which the fastest counts.
const REPETITIONS_OF_RUNS: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let only = std::env::args().skip(1).find(|argument| !argument.starts_with("--"));
    let wanted = |name: &str| only.as_ref().is_none_or(|only| name.contains(only.as_str()));
    if wanted("henon_heiles") {
        println!("\nHénon and Heiles from (0.1, 0; 0, 0.5) to t = 5e4: largest energy error");
        let start = State::new([0.1, 0.0], [0.0, 0.5]);
        row::<Composed<Verlet, KahanLi8>, _>("KahanLi8", &HenonHeiles, &start, 0.01, 5e4)?;
        row::<Composed<Verlet, KahanLi8>, _>("KahanLi8", &HenonHeiles, &start, 0.1, 5e4)?;
        row::<Gauss<8>, _>("Gauss<8>", &HenonHeiles, &start, 0.5, 5e4)?;
        row::<Gauss<16>, _>("Gauss<16>", &HenonHeiles, &start, 1.25, 5e4)?;
    }
    if wanted("pendulum") {
        println!("\nPendulum from (1.3, 0) to t = 1e4: largest energy error");
        let start = State::new([1.3], [0.0]);
        row::<Gauss<8>, _>("Gauss<8>", &Pendulum, &start, 0.625, 1e4)?;
        row::<Gauss<16>, _>("Gauss<16>", &Pendulum, &start, 1.25, 1e4)?;
    }
    if wanted("planets") {
        println!("\nOuter solar system over 1e7 days: largest relative energy error");
        let (mass, q, p) = planets::outer();
        let (system, start) = (SolarSystem { mass }, State::new(q, p));
        row::<Gauss<8>, _>("Gauss<8>", &system, &start, 400.0, 1e7)?;
        row::<Composed<Verlet, Srkn6>, _>("Srkn6", &system, &start, 100.0, 1e7)?;
    }
    if wanted("section") {
        println!("\nSection x = 0 of Hénon and Heiles from (0.1, 0; 0, 0.5) to t = 2000");
        let run = || -> Result<usize, wzvi::Error> {
            let run = HenonHeiles
                .simulate::<Gauss<8>>(0.25)
                .start(State::new([0.1, 0.0], [0.0, 0.5]))
                .until(2000.0);
            let run = run.record_every(0).section_towards(Direction::Rising, |state| state.q[0]);
            Ok(run.run()?.crossings().len())
        };
        println!("  Gauss<8>, h = 0.25: {}, {} crossings", duration(fastest(&run)?), run()?);
    }
    if wanted("toda") {
        println!("\nToda lattice of 200 sites: release build of one program (best of {REPETITIONS})");
        let folder = package("toda_200", TODA)?;
        let target = root().join("target/wzvi/compile/target");
        let took = best(|again| {
            let mut cargo = cargo("rustc", &folder);
            cargo.arg("--target-dir").arg(&target).args(forced(again));
            cargo
        })?;
        let program = target.join("release").join(format!("toda_200{}", std::env::consts::EXE_SUFFIX));
        println!("  {took:.2} s of a processor, {} kB of program", std::fs::metadata(program)?.len() / 1000);
    }
    Ok(())
}

/// Time of a run and its energy error, over the energy at the start.
fn row<E, H>(scheme: &str, system: &H, start: &State<H::Vector>, h: f64, end: f64) -> Result<(), wzvi::Error>
where
    H: Discretized<E>,
    H::Vector: Vector,
{
    let run = || system.simulate::<E>(h).start(start.clone()).until(end);
    let seconds = fastest(&|| run().record_every(0).run().map(|_| ()))?;
    let energy = system.energy(start);
    let error = run().run()?.iter().map(|state| (system.energy(state) - energy).abs()).fold(0.0, f64::max);
    println!(
        "  {scheme}, h = {h}: {}, energy off by {error:.1e}, relative {:.1e}",
        duration(seconds),
        error / energy.abs()
    );
    Ok(())
}

fn fastest<T>(run: &dyn Fn() -> Result<T, wzvi::Error>) -> Result<f64, wzvi::Error> {
    let mut fastest = f64::INFINITY;
    for _ in 0..REPETITIONS_OF_RUNS {
        let began = Instant::now();
        run()?;
        fastest = fastest.min(began.elapsed().as_secs_f64());
    }
    Ok(fastest)
}

const TODA: &str = r#"use wzvi::prelude::*;

#[hamiltonian(
    drift = |q: [f64; 200], p: [f64; 200]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() + (0..200).map(|i| (q[i] - q[(i + 1) % 200]).exp()).sum::<f64>()
    },
    embedding = [Midpoint, Verlet],
)]
struct Toda;

fn main() -> Result<(), wzvi::Error> {
    let q: [f64; 200] = std::array::from_fn(|i| 0.1 * (i as f64).sin());
    let start = State::new(q, [0.0; 200]);
    let path = Toda.simulate::<Midpoint>(0.1).start(start).until(10.0).run()?;
    println!("{} {:.1e}", path.last().q[0], path.energy_drift(&Toda));
    Ok(())
}
"#;
