use wzvi::prelude::*;

#[hamiltonian(drift = |q, p| 0.5 * (q * q + p * p), embedding = [Midpoint])]
struct Oscillator;

fn main() {
    let _ = Oscillator.stepper::<DeltaPlus>(0.1);
}
