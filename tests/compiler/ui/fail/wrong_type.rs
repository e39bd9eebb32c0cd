use wzvi::prelude::*;

#[hamiltonian(
    drift = |q, p| {
        let n: i32 = q;
        q * p
    },
    embedding = Midpoint,
)]
struct System;

fn main() {}
