//! A million Kubo oscillators in seconds: the decay of the mean, beside its exact values.
//!
//! The system has `E z(t) = e^{-σ² t / 2} R(a t) z(0)`, where `R` turns by `a t`. The scheme multiplies `p + iq` by
//! `(1 + iθ)/(1 - iθ)` with `θ = (a h + σ ΔW)/2`, whose mean is an integral; the two differ by its weak error of order
//! `h`, ten standard errors of so many paths. The printed deviation is that from the mean of the scheme.
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

/// `E (1 + iθ)/(1 - iθ)` as real and imaginary part, by Simpson's rule over eight standard deviations.
fn factor(kubo: &Kubo, h: f64) -> [f64; 2] {
    let intervals = 4000;
    let mut sum = [0.0; 3];
    for i in 0..=intervals {
        let x = 16.0 * f64::from(i) / f64::from(intervals) - 8.0;
        let weight = if i == 0 || i == intervals { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
        let density = weight * (-0.5 * x * x).exp();
        let theta = 0.5 * (kubo.a * h + kubo.sigma * h.sqrt() * x);
        let square = 1.0 + theta * theta;
        for (sum, value) in sum.iter_mut().zip([(2.0 - square) / square, 2.0 * theta / square, 1.0]) {
            *sum += density * value;
        }
    }
    [sum[0] / sum[2], sum[1] / sum[2]]
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
        .observe("observable0", |state| state.q[0])
        .observe("observable1", |state| state.p[0])
        .run()?;
    let seconds = began.elapsed().as_secs_f64();
    let [re, im] = factor(&kubo, h);
    println!("   t    mean q    scheme    system deviation    mean p    scheme    system deviation");
    for node in statistics.nodes() {
        let t = node.time();
        let (decay, n) = ((-0.5 * kubo.sigma.powi(2) * t).exp(), t / h);
        let (size, angle) = (re.hypot(im).powf(n), im.atan2(re) * n);
        let scheme = [size * angle.sin(), size * angle.cos()];
        let system = [decay * (kubo.a * t).sin(), decay * (kubo.a * t).cos()];
        print!("{t:4.1}");
        for i in 0..2 {
            let (mean, error) = (node.mean(i), node.standard_error(i));
            let deviation = if error > 0.0 { (mean - scheme[i]) / error } else { 0.0 };
            print!("  {mean:8.5}  {:8.5}  {:8.5} {deviation:6.2} se", scheme[i], system[i]);
        }
        println!();
    }
    println!(
        "{paths} paths of {steps} steps in {seconds:.2} s: {:.2} ns per path-step",
        1e9 * seconds / (paths * steps) as f64
    );
    Ok(())
}
