use wzvi::prelude::*;

#[hamiltonian(drift = |q, p| q * p, embedding = Midpoint)]
enum Choice {
    One,
}

#[hamiltonian(drift = |q, p| q * p, embedding = Midpoint)]
fn energy(q: f64) -> f64 {
    q
}

#[hamiltonian(drift = |q, p| q * p, embedding = Midpoint)]
union Bits {
    a: f64,
    b: u64,
}

#[hamiltonian(drift = |q, p| q * p, embedding = Midpoint)]
impl Choice {}

#[hamiltonian(drift = |q, p| q * p, embedding = Midpoint)]
mod inner {}

#[hamiltonian(drift = |q, p| q * p, embedding = Midpoint)]
const HALF: f64 = 0.5;

#[hamiltonian(drift = |q, p| q * p, embedding = Midpoint)]
type Alias = f64;

fn main() {
    let _ = (Choice::One, energy(1.0), Bits { b: 0 }, HALF, 1.0 as Alias);
}
