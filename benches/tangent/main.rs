//! What the derivative of a step costs: the instructions of `tangent` over those of the path alone, step by step.
//!
//! `cargo bench --workspace --bench tangent` runs every case under `valgrind --tool=callgrind`, twice with different length, so that everything outside
//! of the steps cancels. All columns are taken: four of Hénon-Heiles, twenty of a chain of ten sites.

#![allow(clippy::unwrap_used, reason = "a benchmark stops at the first error")]

use std::process::Command;

use wzvi::prelude::*;

#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * (u * u + v * v + x * x + y * y) + x * x * y - y * y * y / 3.0,
    embedding = [Midpoint, Gauss<2>, Gauss<4>, Gauss<8>]
)]
struct HenonHeiles;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>()
        + q.iter().map(|q| 0.5 * q * q + 0.25 * q.powi(4)).sum::<f64>()
        + q.windows(2).map(|w| 0.5 * (w[1] - w[0]).powi(2)).sum::<f64>(),
    embedding = [Midpoint, Gauss<2>, Gauss<4>]
)]
struct Chain;

/// A name, and so many steps with derivatives or without.
type Case = (&'static str, fn(u64, bool));

const CASES: &[Case] = &[
    ("Hénon-Heiles, Midpoint, h = 0.1", |steps, derives| few::<Midpoint>(0.1, steps, derives)),
    ("Hénon-Heiles, Gauss<2>, h = 0.1", |steps, derives| few::<Gauss<2>>(0.1, steps, derives)),
    ("Hénon-Heiles, Gauss<4>, h = 0.25", |steps, derives| few::<Gauss<4>>(0.25, steps, derives)),
    ("Hénon-Heiles, Gauss<8>, h = 0.25", |steps, derives| few::<Gauss<8>>(0.25, steps, derives)),
    ("Hénon-Heiles, Gauss<8>, h = 0.5", |steps, derives| few::<Gauss<8>>(0.5, steps, derives)),
    ("Hénon-Heiles, Gauss<8>, h = 1", |steps, derives| few::<Gauss<8>>(1.0, steps, derives)),
    ("chain of 10, Midpoint, h = 0.1", |steps, derives| many::<Midpoint>(0.1, steps, derives)),
    ("chain of 10, Gauss<2>, h = 0.1", |steps, derives| many::<Gauss<2>>(0.1, steps, derives)),
    ("chain of 10, Gauss<4>, h = 0.2", |steps, derives| many::<Gauss<4>>(0.2, steps, derives)),
];

fn few<E>(h: f64, steps: u64, derives: bool)
where
    HenonHeiles: Discretized<E, Vector = wzvi::nalgebra::SVector<f64, 2>>,
{
    run::<E, _>(&HenonHeiles, h, State::new([0.0, 0.1], [0.35, 0.0]), steps, derives);
}

fn many<E>(h: f64, steps: u64, derives: bool)
where
    Chain: Discretized<E, Vector = wzvi::nalgebra::DVector<f64>>,
{
    let list = |of: fn(f64) -> f64| (0..10).map(|i| 0.3 * of(f64::from(i))).collect::<Vec<_>>();
    run::<E, _>(&Chain, h, State::new(list(f64::sin), list(f64::cos)), steps, derives);
}

fn run<E, H: Discretized<E>>(system: &H, h: f64, start: State<H::Vector>, steps: u64, derives: bool) {
    let run = system.simulate::<E>(h).start(start).steps(steps);
    match derives {
        true => drop(std::hint::black_box(run.tangent().unwrap())),
        false => drop(std::hint::black_box(run.run().unwrap())),
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [flag, case, steps, derives] = arguments.as_slice()
        && flag == "--run"
    {
        return CASES[case.parse::<usize>().unwrap()].1(steps.parse().unwrap(), derives == "true");
    }
    println!("{:36}{:>14}{:>14}{:>8}", "instructions of a step", "path", "tangent", "ratio");
    for (number, (name, _)) in CASES.iter().enumerate() {
        let [path, tangent] = [false, true].map(|derives| {
            let counts = [200, 400].map(|steps| instructions(number, steps, derives));
            counts[0].zip(counts[1]).map_or(f64::NAN, |(short, long)| (long - short) / 200.0)
        });
        println!("{name:36}{path:>14.0}{tangent:>14.0}{:>8.2}", tangent / path);
    }
}

fn instructions(case: usize, steps: u64, derives: bool) -> Option<f64> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe().ok()?)
        .args(["--run", &case.to_string(), &steps.to_string(), &derives.to_string()])
        .output()
        .ok()?;
    let report = String::from_utf8_lossy(&output.stderr);
    let (_, collected) = report.split_once("Collected :")?;
    collected.split_whitespace().next()?.parse().ok()
}
