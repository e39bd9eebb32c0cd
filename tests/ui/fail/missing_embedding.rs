use wzvi::prelude::*;

#[hamiltonian(drift = |q, p| q * p)]
struct System;

fn main() {
    let _ = System.stepper::<Midpoint>(0.1);
}
