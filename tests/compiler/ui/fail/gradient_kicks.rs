//! Kicks with the square of the force need constant masses.
use wzvi::prelude::*;

#[hamiltonian(drift = |q, p| p.cosh() + 0.5 * q * q, embedding = Verlet)]
struct Relativistic;

fn main() {
    let _ = Relativistic.stepper::<Composed<Verlet, Chin4>>(0.1);
}
