use wzvi::prelude::*;

#[hamiltonian(
    drift = |q, p| 0.5 * omgea * q * q + self.mas * p * p,
    noise = [|q, _| sigma * q],
    embedding = Midpoint,
)]
struct System {
    omega: f64,
    mass: f64,
}

fn main() {
    let _ = System { omega: 1.0, mass: 1.0 }.stepper::<Midpoint>(0.1);
}
