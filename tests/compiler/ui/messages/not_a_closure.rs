fn energy(q: f64, p: f64) -> f64 {
    q * p
}

#[hamiltonian(drift = energy, embedding = Midpoint, noise = [1.0], invariant = "q")]
struct System;

#[hamiltonian(drift = async |q, p| q * p, noise = [|q, p| -> f32 { q }], embedding = Midpoint)]
struct Async;
