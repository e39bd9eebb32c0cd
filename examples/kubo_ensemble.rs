//! A million Kubo oscillators in seconds: the decay of the mean against its exact value.
//!
//! `E z(t) = e^{-σ² t / 2} R(a t) z(0)`, where `R` turns by `a t`; and what a path-step costs.
//!
//! `cargo run --release --example kubo_ensemble`

use std::time::Instant;

use wzvi::prelude::*;

/// A rotation whose angle diffuses.
#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
    embedding = [Midpoint],
)]
pub struct Kubo {
    /// Mean angular frequency.
    pub a: f64,
    /// Intensity of the noise.
    pub sigma: f64,
}

fn main() -> Result<(), wzvi::Error> {
    let (h, steps, paths) = (0.02, 100, 1_000_000);
    let kubo = Kubo { a: 1.5, sigma: 1.0 };
    let began = Instant::now();
    let statistics = kubo
        .ensemble::<Midpoint>(h)
        .start(State::new([0.0], [1.0]))
        .paths(paths)
        .seed(7)
        .steps(steps)
        .record_every(20)
        .observe(|state| state.q[0])
        .observe(|state| state.p[0])
        .run()?;
    let seconds = began.elapsed().as_secs_f64();
    println!(
        "   t   mean q   exact    error in standard errors   mean p   exact    error in standard errors"
    );
    for node in statistics.nodes() {
        let t = node.time();
        let decay = (-0.5 * kubo.sigma.powi(2) * t).exp();
        let exact = [decay * (kubo.a * t).sin(), decay * (kubo.a * t).cos()];
        let column = |i: usize| {
            let deviation = if node.standard_error(i) > 0.0 {
                (node.mean(i) - exact[i]) / node.standard_error(i)
            } else {
                0.0
            };
            format!("{:8.5} {:8.5} {deviation:26.2}", node.mean(i), exact[i])
        };
        println!("{t:5.2} {}  {}", column(0), column(1));
    }
    println!(
        "{paths} paths of {steps} steps in {seconds:.2} s: {:.2} ns per path-step",
        1e9 * seconds / (paths * steps) as f64
    );
    Ok(())
}
