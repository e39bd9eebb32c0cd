//! What exponents and indicators of chaos cost, in plain steps of the same run.
//!
//! `cargo bench -p wzvi-benches --bench chaos`

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a bench stops at the first error"
)]
#![allow(missing_docs, reason = "a bench")]

use std::time::Instant;

use fixtures::small::HenonHeiles;
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

/// Seconds of the fastest of several runs.
fn seconds(mut run: impl FnMut()) -> f64 {
    let time = |_| {
        let clock = Instant::now();
        run();
        clock.elapsed().as_secs_f64()
    };
    (0..5).map(time).fold(f64::INFINITY, f64::min)
}

fn paths<E>(name: &str, h: f64)
where
    HenonHeiles: Discretized<E, Vector = SVector<f64, 2>>,
{
    let (end, start) = (2000.0, State::new([0.0, -0.25], [0.42, 0.0]));
    let run = || HenonHeiles.simulate::<E>(h).start(start).until(end).record_every(0);
    let plain = seconds(|| drop(run().run().unwrap()));
    let lyapunov = seconds(|| drop(run().copies(0).lyapunov().unwrap())) / plain;
    let indicators = seconds(|| drop(run().indicators().unwrap())) / plain;
    println!("| {name}, h = {h} | {:.0} ns | {lyapunov:.1} | {indicators:.1} |", plain / (end / h) * 1e9);
}

/// A map of 250 000 starts to t = 1000 takes so many times what is measured of a part of it.
fn map() {
    let (side, end, h) = (64_usize, 200.0, 0.1);
    let starts = (0..side * side).map(|k| {
        let (y, py) = (0.4 * (k / side) as f64 / side as f64, 0.2 * (k % side) as f64 / side as f64);
        let square = 0.25 - y * y - py * py + 2.0 / 3.0 * y.powi(3);
        State::new([0.0, y], [square.sqrt(), py])
    });
    let starts: Vec<State<SVector<f64, 2>>> = starts.collect();
    let run = || HenonHeiles.ensemble::<Verlet>(h).starts_from(starts.clone()).until(end).threads(1).quiet();
    let of_step = 1e9 / (starts.len() as f64 * end / h);
    let plain = seconds(|| drop(run().observe("q", |state| state.q[0]).run().unwrap())) * of_step;
    let map = seconds(|| drop(run().indicators().unwrap())) * of_step;
    println!(
        "map by `Verlet`, h = {h}, one thread: {map:.1} ns for each step of a path, a plain one {plain:.1} ns"
    );
    println!("250 000 starts to t = 1000: {:.0} s of one thread", 250_000.0 * 1000.0 / h * map * 1e-9);
}

fn main() {
    map();
    paths::<Verlet>("`Verlet`", 0.1);
    paths::<Composed<Verlet, KahanLi8>>("`Composed<Verlet, KahanLi8>`", 0.25);
    paths::<Midpoint>("`Midpoint`", 0.1);
    paths::<Gauss<8>>("`Gauss<8>`", 0.5);
}
