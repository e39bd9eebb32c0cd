use wzvi::prelude::*;

#[hamiltonian(drift = |q: Vec<f64>, p: Vec<f64>| q[0] * p[0], embedding = Midpoint)]
struct Vectors;

fn main() {}
