#[hamiltonian(
    drift = |q: [f64; 3], p: [f64; 3]| [q[0], p[0]][n] + (0..n).map(|i| p[i]).product::<f64>()
        + (0..M).map(|i| [q[1], p[1]][i]).sum::<f64>() + { let [a, b] = weights; a + b },
    embedding = Midpoint,
)]
struct Network<const M: usize> {
    n: usize,
    weights: Vec<f64>,
}
