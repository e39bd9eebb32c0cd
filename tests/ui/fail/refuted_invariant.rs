use wzvi::prelude::*;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p - a * q.cos(),
    noise = [|q, _| q.sin()],
    embedding = Midpoint,
    invariant = [|q, p| 0.5 * p * p - a * q.cos(), |q, p| q * p, |_, _, t| t],
)]
struct Pendulum {
    a: f64,
}

fn main() {
    let _ = Pendulum { a: 1.0 }.stepper::<Midpoint>(0.1);
}
