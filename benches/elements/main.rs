//! Chains with sums that stay loops beside hand-written ones: nanoseconds per particle and step. FPUT-beta, fixed ends,
//! first mode of amplitude 1, h = 0.05.
//!
//! Run with `cargo bench --bench elements`.

mod by_hand;

use std::time::Instant;

use wzvi::prelude::*;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let v = |d: f64| 0.5 * d * d + 0.25 * beta * d.powi(4);
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (1..n).map(|i| v(q[i] - q[i - 1])).sum::<f64>()
            + v(q[0]) + v(q[n - 1])
    },
    embedding = [DeltaPlus, Midpoint],
)]
struct Fput {
    beta: f64,
}

const H: f64 = 0.05;
const BETA: f64 = 0.25;

fn first_mode(n: usize) -> Vec<f64> {
    (0..n).map(|i| (std::f64::consts::PI * (i + 1) as f64 / (n + 1) as f64).sin()).collect()
}

/// The best of five, in nanoseconds per particle and step.
fn time(n: usize, steps: usize, mut run: impl FnMut(usize)) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let start = Instant::now();
        run(steps);
        best = best.min(start.elapsed().as_nanos() as f64 / (n * steps) as f64);
    }
    best
}

fn generated<E>(n: usize, steps: usize) -> Result<(f64, f64), wzvi::Error>
where
    Fput: Discretized<E, Vector = wzvi::nalgebra::DVector<f64>>,
{
    let fput = Fput { beta: BETA };
    let mut stepper = fput.stepper::<E>(H)?;
    let mut state = State::new(first_mode(n), vec![0.0; n]);
    let (mut iterations, mut taken, mut failure) = (0_u64, 0_u64, None);
    let best = time(n, steps, |steps| {
        for _ in 0..steps {
            match stepper.step(&mut state, &[]) {
                Ok(info) => (iterations, taken) = (iterations + u64::from(info.iterations), taken + 1),
                Err(error) => failure = Some(error),
            }
        }
    });
    match failure {
        Some(error) => Err(error.into()),
        None => Ok((best, iterations as f64 / taken as f64)),
    }
}

fn main() -> Result<(), wzvi::Error> {
    println!("ns per particle and step (iterations per step)\n");
    println!("{:>8}  {:>10}  {:>16}  {:>16}", "N", "scheme", "generated", "by hand");
    for (n, steps) in [(32, 20_000), (1024, 1_000), (1_000_000, 3)] {
        let (own, _) = generated::<DeltaPlus>(n, 4 * steps)?;
        let (mut q, mut p) = (first_mode(n), vec![0.0; n]);
        let hand = time(n, 4 * steps, |steps| by_hand::delta_plus(&mut q, &mut p, BETA, H, steps));
        println!("{n:>8}  {:>10}  {own:>16.2}  {hand:>16.2}", "DeltaPlus");
        let (own, iterations) = generated::<Midpoint>(n, steps)?;
        let mut chain = by_hand::Midpoint::new(first_mode(n), vec![0.0; n], BETA, H);
        let hand = time(n, steps, |steps| chain.run(steps));
        let by_hand = chain.iterations as f64 / chain.steps as f64;
        println!(
            "{n:>8}  {:>10}  {:>16}  {:>16}",
            "Midpoint",
            format!("{own:.2} ({iterations:.1})"),
            format!("{hand:.2} ({by_hand:.1})")
        );
    }
    Ok(())
}
