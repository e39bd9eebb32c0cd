use wzvi::prelude::*;

const N: usize = 3;

#[hamiltonian(drift = |q, p| q * p + N, embedding = Midpoint)]
struct System;

fn main() {}
