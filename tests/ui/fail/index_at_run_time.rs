use wzvi::prelude::*;

#[hamiltonian(
    drift = |q: [f64; 3], p: [f64; 3]| q[n] + p[bonds[0]] + (0..n).map(|i| q[i]).sum::<f64>() + q[M] + q[LAST]
        + weights.iter().sum::<f64>(),
    embedding = Midpoint,
)]
struct Network<const M: usize> {
    n: usize,
    bonds: [usize; 2],
    weights: Vec<f64>,
}

const LAST: usize = 2;

fn main() {}
