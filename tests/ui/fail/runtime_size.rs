use wzvi::prelude::*;

#[hamiltonian(drift = |q: &[f64], p: &[f64]| q[0] * p[0], embedding = Midpoint)]
struct Slices;

#[hamiltonian(drift = |q: Vec<f64>, p: Vec<f64>| q[0] * p[0], embedding = Midpoint)]
struct Vectors;

const N: usize = 3;

#[hamiltonian(drift = |q: [f64; N], p: [f64; N]| q[0] * p[0], embedding = Midpoint)]
struct Constant;

#[hamiltonian(
    drift = |q: [f64; 3], p: [f64; 3]| q[0] * p[0],
    noise = [|q, p, k| q[k]; 3],
    embedding = Midpoint,
)]
struct Family;

fn main() {}
