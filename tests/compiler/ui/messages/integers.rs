#[hamiltonian(
    drift = |q, p| 2 * q + n * p + q.powf(2) + (n + 1) as f64 + (1 / 0) as f64 + q.powi(3_000_000_000)
        + (0..).map(|i| q * i as f64).sum::<f64>() + (300 as u8) as f64,
    embedding = Midpoint,
)]
struct System {
    n: i32,
}
