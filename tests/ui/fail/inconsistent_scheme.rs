use wzvi::prelude::*;

// Multiplicative noise: the limit of these schemes is another system.
#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
    embedding = [DeltaPlus, Midpoint, DeltaMinus, Mixed<Midpoint, Lambda<1, 4>>],
)]
struct Kubo {
    a: f64,
    sigma: f64,
}

fn main() {
    let kubo = Kubo { a: 1.0, sigma: 0.5 };
    let _ = kubo.stepper::<DeltaPlus>(0.1);
}
