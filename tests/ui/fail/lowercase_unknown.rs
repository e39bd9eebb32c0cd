use wzvi::prelude::*;

const stiffness: f64 = 2.0;

#[hamiltonian(drift = |q, p| stiffness * q * p, embedding = Midpoint)]
struct System;

fn main() {}
