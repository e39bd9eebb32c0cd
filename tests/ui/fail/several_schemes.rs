use wzvi::prelude::*;

#[hamiltonian(drift = |q, p| 0.5 * (q * q + p * p), embedding = [Midpoint, Verlet])]
struct Oscillator;

fn main() {
    let _ = Oscillator.stepper(0.1);
    let _ = Oscillator.simulate(0.1);
}
