use wzvi::prelude::*;

#[hamiltonian(drift = |q, p| q * p, embedding = [Midpiont, DeltaPlus, Corected<DeltaPlus>, Euler])]
struct System;

fn main() {
    let _ = System.stepper::<DeltaPlus>(0.1);
}
