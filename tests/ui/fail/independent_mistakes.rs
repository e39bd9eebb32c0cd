use wzvi::prelude::*;

#[hamiltonian(
    drift = |q, p| 0.5 * omega * q * q + p.sinn(),
    noise = [|q, p| sigm * q, |q, p| q[0]],
    embedding = [Midpoint, DeltaPuls],
    invariant = [|q, p| qq + p],
    verbose = true,
)]
struct System {
    sigma: f64,
}

fn main() {
    let system = System { sigma: 1.0 };
    let _ = system.stepper::<Midpoint>(0.1);
    let _ = system.energy(&State::new([0.0], [0.0]));
}
