use wzvi::prelude::*;

#[hamiltonian(drift = |q| q, embedding = Midpoint)]
struct One;

#[hamiltonian(drift = |q, p, t, s| q, embedding = Midpoint)]
struct Four;

#[hamiltonian(drift = |(x, y), (px, py)| x, embedding = Midpoint)]
struct Tuples;

#[hamiltonian(drift = |mut q, p| q, embedding = Midpoint)]
struct Mutable;

#[hamiltonian(drift = |q: f32, p: i32| q, embedding = Midpoint)]
struct Types;

#[hamiltonian(drift = |[], []| 0.0, embedding = Midpoint)]
struct Nothing;

#[hamiltonian(drift = |q, p, [t]| 0.0, embedding = Midpoint)]
struct Times;

#[hamiltonian(drift = |[x, ..], p: [f64; 3]| x, embedding = Midpoint)]
struct Rest;

fn main() {}
