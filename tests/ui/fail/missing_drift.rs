use wzvi::prelude::*;

#[hamiltonian(embedding = Midpoint)]
struct System;

fn main() {
    let _ = System.stepper::<Midpoint>(0.1);
}
