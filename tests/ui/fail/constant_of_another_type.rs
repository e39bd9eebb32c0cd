use wzvi::prelude::*;

const SMOOTH: bool = true;

#[hamiltonian(drift = |q, p| q * p.max(SMOOTH), embedding = Midpoint)]
struct System;

fn main() {}
