#[hamiltonian(
    drift = |q: [f64; 3], p: [f64; 3]| q[3] + p[1] + self.k[2] + (0..3).map(|i| q[i + 1]).sum::<f64>(),
    embedding = Midpoint,
)]
struct Chain {
    k: [f64; 2],
}
