//! Which iteration a step takes: the chosen one against sweeps of the fixed point alone and Newton's method
//! alone, in microseconds per step.
//!
//! `cargo bench --workspace --bench iteration`; names of systems, schemes and sizes select rows: `-- spin
//! Gauss<4> 22`.
//!
//! Each row is one step size, as a fraction of the fastest period. The ratio is that of the chosen iteration
//! to the better of the other two; `-` stands for a run that was refused. Times are minima over runs in
//! turns, from a new stepper each. The first step is not counted: it is checked against other solutions,
//! which a pinned fixed point is not.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a benchmark talks, and stops at the first error"
)]

use std::time::{Duration, Instant};

use wzvi::prelude::*;

/// A spin in the two oscillators of Schwinger, coupled to harmonic modes of frequencies from 1 to 2: not
/// separable, and an arrow of a Jacobian.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let spin = q[0] * q[0] + p[0] * p[0] - q[1] * q[1] - p[1] * p[1];
        0.5 * (q[0] * q[1] + p[0] * p[1])
            + (2..q.len()).map(|j| 0.5 * p[j] * p[j] + 0.5 * frequency[j] * frequency[j] * q[j] * q[j]).sum::<f64>()
            + (2..q.len()).map(|j| coupling * q[j] * spin).sum::<f64>()
    },
    embedding = [Midpoint, Gauss<2>, Gauss<4>, Gauss<8>, Gauss<16>],
)]
struct Spin {
    frequency: Vec<f64>,
    coupling: f64,
}

/// A chain of springs with a quartic term, separable and with a band as its Jacobian; its fastest frequency
/// is 2.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + (1..q.len()).map(|i| 0.5 * (q[i] - q[i - 1]) * (q[i] - q[i - 1])).sum::<f64>()
            + (1..q.len()).map(|i| 0.25 * beta * (q[i] - q[i - 1]) * (q[i] - q[i - 1]) * (q[i] - q[i - 1]) * (q[i] - q[i - 1])).sum::<f64>()
    },
    embedding = [Midpoint, Gauss<2>, Gauss<4>, Gauss<8>, Gauss<16>],
)]
struct Chain {
    beta: f64,
}

const SIZES: [usize; 6] = [2, 6, 12, 22, 64, 200];
/// Step sizes over the fastest period.
const FRACTIONS: [f64; 7] = [0.01, 0.03, 0.1, 0.3, 0.5, 1.0, 2.0];
const FASTEST: f64 = std::f64::consts::PI;
/// The longest run, in steps and in time.
const STEPS: u32 = 200;
const LONG: Duration = Duration::from_millis(20);
const RUNS: u32 = 5;
/// From this many unknowns on a step of Newton's method alone takes seconds, and is left out.
const MOST_UNKNOWNS: usize = 800;

/// Microseconds per step; `None` where a step is refused.
fn measure<E, H>(system: &H, start: &State<H::Vector>, h: f64, iteration: Iteration) -> Option<f64>
where
    H: Discretized<E>,
{
    let mut stepper = system.stepper::<E>(h).unwrap().iteration(iteration);
    let mut state = start.clone();
    stepper.step(&mut state, &[]).ok()?;
    let (clock, mut steps) = (Instant::now(), 0);
    while steps < STEPS && clock.elapsed() < LONG {
        stepper.step(&mut state, &[]).ok()?;
        steps += 1;
    }
    Some(clock.elapsed().as_secs_f64() * 1e6 / f64::from(steps))
}

fn row<E, H>(system: &H, [name, scheme]: [&str; 2], n: usize, unknowns: usize, worst: &mut f64)
where
    H: Discretized<E, Vector = wzvi::nalgebra::DVector<f64>>,
{
    let wave = |shift: usize| (0..n).map(|i| 0.5 * (1.3 * (i + shift) as f64).sin()).collect::<Vec<_>>();
    let start = State::new(wave(0), wave(40));
    for fraction in FRACTIONS {
        let mut best = [Some(f64::INFINITY); 3];
        for _ in 0..RUNS {
            let ways = [Iteration::Automatic, Iteration::FixedPoint, Iteration::Newton];
            for (best, iteration) in best.iter_mut().zip(ways) {
                let is_long = iteration == Iteration::Newton && unknowns > MOST_UNKNOWNS;
                let measured = || measure::<E, H>(system, &start, fraction * FASTEST, iteration);
                *best = best.filter(|_| !is_long).and_then(|best| Some(best.min(measured()?)));
            }
        }
        let [chosen, sweeps, newton] = best;
        let better = [sweeps, newton].into_iter().flatten().fold(f64::INFINITY, f64::min);
        let ratio = chosen.map(|chosen| chosen / better);
        *worst = ratio.filter(|ratio| ratio.is_finite()).map_or(*worst, |ratio| worst.max(ratio));
        let [chosen, sweeps, newton, ratio] = [chosen, sweeps, newton, ratio]
            .map(|number| number.map_or("-".to_owned(), |number| format!("{number:.2}")));
        println!("{name:8}{scheme:10}{n:>5}{fraction:>7}{chosen:>12}{sweeps:>12}{newton:>12}{ratio:>8}");
    }
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let is_wanted = |words: &[String]| wanted.iter().all(|wanted| words.contains(wanted));
    println!(
        "{:8}{:10}{:>5}{:>7}{:>12}{:>12}{:>12}{:>8}",
        "", "", "size", "h/T", "chosen", "sweeps", "Newton", "ratio"
    );
    let mut worst = 0.0;
    macro_rules! rows {
        ($($scheme:ty, $stages:literal, $name:literal;)*) => {
            for n in SIZES {
                let frequency = (0..n).map(|j| 1.0 + (j + 1) as f64 / n as f64).collect();
                let spin = Spin { frequency, coupling: 0.2 / (n as f64).sqrt() };
                let chain = Chain { beta: 0.25 };
                $(
                    let is = |system: &str| is_wanted(&[system.to_owned(), $name.to_owned(), n.to_string()]);
                    if is("spin") {
                        row::<$scheme, _>(&spin, ["spin", $name], n, 2 * $stages * n, &mut worst);
                    }
                    if is("chain") {
                        row::<$scheme, _>(&chain, ["chain", $name], n, $stages * n, &mut worst);
                    }
                )*
            }
        };
    }
    rows! {
        Midpoint, 1, "Midpoint";
        Gauss<2>, 2, "Gauss<2>";
        Gauss<4>, 4, "Gauss<4>";
        Gauss<8>, 8, "Gauss<8>";
        Gauss<16>, 16, "Gauss<16>";
    }
    println!("\nthe largest ratio: {worst:.2}");
}
