use wzvi::exported::Exported;
use wzvi::prelude::*;

/// A field that no numbers make.
#[hamiltonian(drift = |q, p| 0.5 * (p * p + k * q * q), embedding = Verlet, export = [])]
struct Labelled {
    k: f64,
    label: String,
}

/// A mistake: `rustc` does not add that the system is not exported.
#[hamiltonian(drift = |q, p| 0.5 * (p * p + q.cosine()), embedding = Verlet, export = [])]
struct Mistaken;

fn name<H: Exported>() -> &'static str {
    H::NAME
}

fn main() {
    name::<Mistaken>();
    name::<Labelled>();
}
