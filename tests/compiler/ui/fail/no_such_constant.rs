use wzvi::prelude::*;

#[hamiltonian(drift = |q, p| q * p + STIFFNESS, embedding = Midpoint)]
struct System;

fn main() {}
