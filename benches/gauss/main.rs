//! `Gauss<S>` against the same steps written by hand for one system ([`by_hand`]), and how rounding grows over a million of them.
//!
//! `cargo bench --workspace --bench gauss`; `-- hand`, `-- fused` and `-- brouwer` run one of these.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a benchmark talks, and stops at the first error"
)]

mod by_hand;
#[allow(dead_code, reason = "the scenes of another benchmark, of which some serve here")]
#[path = "../order/scenes.rs"]
mod scenes;

use std::time::Instant;

use by_hand::{Coefficients, Force};
use scenes::{Scene, distance};
use wzvi::lanes::instructions::InstructionSet;
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

/// `Gauss<S>` against the same by hand, in turns.
fn beside<E, F: Force<D>, H, const D: usize, const S: usize>(
    name: &str,
    scene: &Scene<H>,
    steps: u32,
    unit: f64,
) where
    H: Discretized<E, Vector = SVector<f64, D>>,
{
    let coefficients = Coefficients::<S>::new();
    let h = scene.end / f64::from(steps);
    let (q, p): ([f64; D], [f64; D]) = (scene.start.q.into(), scene.start.p.into());
    let (mut ours, mut by_hand) = ([f64::INFINITY, 0.0, 0.0], [f64::INFINITY, 0.0, 0.0]);
    let per_step = |sweeps: u64| sweeps as f64 / f64::from(steps);
    for _ in 0..60 {
        let mut stepper = scene.system.stepper::<E>(h).unwrap();
        let (mut state, mut sweeps) = (scene.start, 0);
        let clock = Instant::now();
        for _ in 0..steps {
            sweeps += u64::from(stepper.step(&mut state, &[]).unwrap().iterations);
        }
        let seconds = clock.elapsed().as_secs_f64();
        ours = [ours[0].min(seconds), per_step(sweeps), distance(&state, &scene.exact)];
        let clock = Instant::now();
        let (q, p, sweeps) = by_hand::run::<F, D, S>(&coefficients, std::hint::black_box([q, p]), h, steps);
        let seconds = clock.elapsed().as_secs_f64();
        by_hand = [by_hand[0].min(seconds), per_step(sweeps), distance(&State::new(q, p), &scene.exact)];
    }
    for (who, [seconds, sweeps, error]) in [("Gauss", ours), ("by hand", by_hand)] {
        let ratio = seconds / by_hand[0];
        println!(
            "{name:24}{who:10}{:>12.2}{:>10.1}{sweeps:>9.2}{error:>11.1e}{ratio:>8.2}",
            seconds * 1e9 * unit / scene.end,
            seconds * 1e9 / f64::from(steps),
        );
    }
}

fn hand() {
    let fused = if cfg!(target_feature = "fma") { "with" } else { "without" };
    println!(
        "Gauss<S> against the same loop written by hand, which is built {fused} fused products and sums\n"
    );
    println!("{:34}{:>12}{:>10}{:>9}{:>11}{:>8}", "", "ns/unit", "ns/step", "sweeps", "error", "ratio");
    let (pendulum, kepler) = (scenes::pendulum(), scenes::kepler());
    let orbit = 2.0 * std::f64::consts::PI;
    beside::<Gauss<8>, by_hand::Pendulum, _, 1, 8>("pendulum, S = 8, 0.1", &pendulum, 100, 0.1);
    beside::<Gauss<8>, by_hand::Pendulum, _, 1, 8>("pendulum, S = 8, 0.1", &pendulum, 180, 0.1);
    beside::<Gauss<16>, by_hand::Pendulum, _, 1, 16>("pendulum, S = 16, 0.1", &pendulum, 40, 0.1);
    beside::<Gauss<16>, by_hand::Pendulum, _, 1, 16>("pendulum, S = 16, 0.1", &pendulum, 50, 0.1);
    beside::<Gauss<8>, by_hand::Kepler, _, 2, 8>("Kepler, S = 8, orbit", &kepler, 5000, orbit);
    beside::<Gauss<16>, by_hand::Kepler, _, 2, 16>("Kepler, S = 16, orbit", &kepler, 1500, orbit);
}

/// Nanoseconds per sweep of the loop by hand without fused sums over the stages, and the ratio with them, for each
/// set of instructions. Fused operations are instructions with AVX-512 and in a build with
/// `RUSTFLAGS="-C target-feature=+fma"`, and else calls of the C library.
fn fused_sums<F: Force<D>, H, const D: usize, const S: usize>(name: &str, scene: &Scene<H>, steps: u32)
where
    H: Hamiltonian<Vector = SVector<f64, D>>,
{
    let coefficients = Coefficients::<S>::new();
    let h = scene.end / f64::from(steps);
    let start: [[f64; D]; 2] = [scene.start.q.into(), scene.start.p.into()];
    print!("{name:20}");
    for set in [InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Avx512] {
        let mut best = [f64::INFINITY; 2];
        for _ in 0..60 {
            for (best, is_fused) in best.iter_mut().zip([false, true]) {
                let (clock, start) = (Instant::now(), std::hint::black_box(start));
                let (_, _, sweeps) = match is_fused {
                    false => by_hand::run_with::<F, D, S, false>(set, &coefficients, start, h, steps),
                    true => by_hand::run_with::<F, D, S, true>(set, &coefficients, start, h, steps),
                };
                *best = best.min(clock.elapsed().as_secs_f64() * 1e9 / sweeps as f64);
            }
        }
        print!("{:>12.1}{:>8.2}", best[0], best[1] / best[0]);
    }
    println!();
}

fn fused() {
    let by = if cfg!(target_feature = "fma") { "" } else { ", which are calls unless AVX-512 is there" };
    println!("\nA sweep by hand, ns, and the ratio with fused sums over the stages{by}\n");
    println!("{:20}{:>20}{:>20}{:>20}", "", "baseline", "AVX2", "AVX-512");
    let (pendulum, kepler) = (scenes::pendulum(), scenes::kepler());
    let henon_heiles = scenes::henon_heiles();
    fused_sums::<by_hand::Pendulum, _, 1, 8>("pendulum, S = 8", &pendulum, 180);
    fused_sums::<by_hand::Pendulum, _, 1, 16>("pendulum, S = 16", &pendulum, 50);
    fused_sums::<by_hand::HenonHeiles, _, 2, 8>("Hénon-Heiles, S = 8", &henon_heiles, 400);
    fused_sums::<by_hand::HenonHeiles, _, 2, 16>("Hénon-Heiles, S = 16", &henon_heiles, 160);
    fused_sums::<by_hand::Kepler, _, 2, 8>("Kepler, S = 8", &kepler, 5000);
    fused_sums::<by_hand::Kepler, _, 2, 16>("Kepler, S = 16", &kepler, 1500);
}

/// Brouwer's law: a million steps of `Gauss<8>`, short enough that rounding is all of the error, from a hundred ellipses that are turned against
/// each other, in steps that are no part of the period. The error of the energy is that of a random walk if its mean is zero within
/// three standard errors, and its spread grows like the square root of the number of steps.
fn brouwer() {
    const STARTS: u32 = 100;
    let (h, e) = (0.0617, 0.5_f64);
    let nodes = [10_000, 100_000, 1_000_000];
    let mut drifts = [const { Vec::new() }; 3];
    for start in 0..STARTS {
        let (sin, cos) = (2.0 * std::f64::consts::PI * f64::from(start) / f64::from(STARTS)).sin_cos();
        let speed = ((1.0 + e) / (1.0 - e)).sqrt();
        let mut state = State::new([(1.0 - e) * cos, (1.0 - e) * sin], [-speed * sin, speed * cos]);
        let energy = scenes::Kepler.energy(&state);
        let mut stepper = scenes::Kepler.stepper::<Gauss<8>>(h).unwrap().compensated();
        let mut taken = 0;
        for (node, drifts) in nodes.into_iter().zip(&mut drifts) {
            while taken < node {
                stepper.step(&mut state, &[]).unwrap();
                taken += 1;
            }
            drifts.push((scenes::Kepler.energy(&state) - energy) / energy.abs());
        }
    }
    println!("\nBrouwer's law: relative error of the energy, Kepler e = 0.5, Gauss<8>, {STARTS} starts\n");
    println!("{:>10}{:>14}{:>18}{:>14}", "steps", "mean", "standard error", "spread");
    for (steps, drifts) in nodes.into_iter().zip(&drifts) {
        let number = f64::from(STARTS);
        let mean = drifts.iter().sum::<f64>() / number;
        let variance = drifts.iter().map(|drift| (drift - mean).powi(2)).sum::<f64>() / (number - 1.0);
        println!("{steps:>10}{mean:>14.2e}{:>18.2e}{:>14.2e}", (variance / number).sqrt(), variance.sqrt());
    }
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let is_wanted = |name: &str| wanted.is_empty() || wanted.iter().any(|wanted| wanted == name);
    if is_wanted("hand") {
        hand();
    }
    if is_wanted("fused") {
        fused();
    }
    if is_wanted("brouwer") {
        brouwer();
    }
}
