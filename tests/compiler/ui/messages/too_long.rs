#[hamiltonian(drift = |q, p| p * p + (0..1_000_000).map(|i| q * i as f64).product::<f64>(), embedding = Midpoint)]
struct Long;
