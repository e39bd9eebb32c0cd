use wzvi::prelude::*;

#[hamiltonian(drift = |q, p| p * p + (0..1_000_000).map(|i| q * i as f64).sum::<f64>(), embedding = Midpoint)]
struct Long;

#[hamiltonian(drift = |q: [f64; 4096], p: [f64; 4096]| q[0] * p[0], embedding = Midpoint)]
struct Wide;

fn main() {}
