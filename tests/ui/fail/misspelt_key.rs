use wzvi::prelude::*;

#[hamiltonian(drfit = |q, p| q * p, noises = [|q, p| q], scheme = Midpoint, potential = 1.0)]
struct System;

fn main() {
    let _ = System.stepper::<Midpoint>(0.1);
}
