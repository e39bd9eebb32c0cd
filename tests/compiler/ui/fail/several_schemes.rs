use wzvi::prelude::*;

#[hamiltonian(drift = |q, p| 0.5 * (q * q + p * p), embedding = [Midpoint, Verlet])]
struct Oscillator;

fn main() {
    let _ = Oscillator.stepper(0.1);
    let _ = Oscillator.simulate(0.1);
}

// The return type of `stepper` names a type of the scheme, that of `simulate` does not: rustc reports a type that it cannot project and a bound
// that it cannot decide each with an error of its own, and has no attribute that merges them. Both say what to write.
