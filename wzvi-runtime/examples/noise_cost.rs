//! Cost of an increment, in nanoseconds, for several step sizes, noises and orders of access.
//!
//! `cargo run --release -p wzvi-runtime --example noise_cost`

#![allow(clippy::disallowed_methods, reason = "powers of two are exact")]

use std::f64::consts::PI;
use std::time::Instant;

use wzvi_runtime::noise::{Interval, Noise, NoiseError, Wiener, WongZakai};

fn cost(noise: &mut impl Noise, start: f64, h: f64, processes: usize) -> Result<f64, NoiseError> {
    let mut dw = vec![0.0; processes];
    let steps = 100_000 / processes as u64;
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let clock = Instant::now();
        let mut square = 0.0;
        for step in 0..steps {
            noise.increments(&Interval { start, h, step }, &mut dw)?;
            square += dw[0] * dw[0];
        }
        assert!(square > 0.0);
        best = best.min(clock.elapsed().as_secs_f64() * 1e9 / (steps * processes as u64) as f64);
    }
    Ok(best)
}

fn main() -> Result<(), NoiseError> {
    println!("Wiener, sequential from t = 0 (ns per increment)");
    for (name, h) in [
        ("1", 1.0),
        ("0.1", 0.1),
        ("0.02", 0.02),
        ("0.01", 0.01),
        ("1e-3", 1e-3),
        ("1e-4", 1e-4),
        ("2^-4", 2f64.powi(-4)),
        ("2^-7", 2f64.powi(-7)),
        ("2^-10", 2f64.powi(-10)),
        ("2^-14", 2f64.powi(-14)),
        ("1/3", 1.0 / 3.0),
        ("1/7", 1.0 / 7.0),
        ("pi/100", PI / 100.0),
    ] {
        let plain = cost(&mut Wiener::seed(7), 0.0, h, 1)?;
        let far = cost(&mut Wiener::seed(7), 1e6, h, 1)?;
        let unit = cost(&mut Wiener::seed(7).unit(h), 0.0, h, 1)?;
        let many = cost(&mut Wiener::seed(7), 0.0, h, 100)?;
        println!(
            "  h = {name:7} {plain:7.1}   from t = 1e6 {far:7.1}   unit(h) {unit:7.1}   100 processes {many:7.1}"
        );
    }
    println!("Wong-Zakai, h = 0.02");
    for eps in [0.02, 0.04, 0.05, 0.2, 1.0] {
        let left = cost(&mut WongZakai::averaged(eps).seed(7), 0.0, 0.02, 1)?;
        let centred = cost(&mut WongZakai::averaged(eps).seed(7).centred(), 0.0, 0.02, 1)?;
        let exact = cost(&mut WongZakai::averaged(eps).seed(7).exact(), 0.0, 0.02, 1)?;
        println!("  eps = {eps:5} left {left:7.1}   centred {centred:7.1}   exact {exact:7.1}");
    }
    Ok(())
}
