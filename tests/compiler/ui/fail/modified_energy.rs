//! What has no modified energy, or none that is known, says so.
use wzvi::prelude::*;

#[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), embedding = [Gauss<4>, Verlet])]
struct Pendulum;

#[hamiltonian(drift = |q, p, t| 0.5 * p * p - q.cos() * t.sin(), embedding = Verlet)]
struct Driven;

#[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), noise = [|q, p| 0.1 * q], embedding = Verlet)]
struct Shaken;

fn main() {
    let state = State::new([0.0], [1.0]);
    let _ = Pendulum.shadow_energy::<Gauss<4>>(&state, 0.1);
    let _ = Driven.shadow_energy::<Verlet>(&state, 0.1);
    let path = Shaken.simulate::<Verlet>(0.1).start(state).steps(1).run().unwrap();
    let _ = path.shadow_energy_drift(&Shaken);
}
