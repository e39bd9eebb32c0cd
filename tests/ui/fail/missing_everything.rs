use wzvi::prelude::*;

#[hamiltonian]
struct Bare;

#[hamiltonian()]
struct Empty;

#[hamiltonian(|q, p| q * p)]
struct Positional;

fn main() {}
