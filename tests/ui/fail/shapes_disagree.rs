use wzvi::prelude::*;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + x * y,
    noise = [|q, p| q, |q: [f64; 3], p: [f64; 3]| q[0], |[x, y], [px]| x],
    embedding = Midpoint,
)]
struct Plane;

#[hamiltonian(drift = |[x, y], p| x * y * p, embedding = Midpoint)]
struct Mismatched;

#[hamiltonian(drift = |q: [f64; 2], p: [[f64; 2]; 2]| 0.0, embedding = Midpoint)]
struct Points;

fn main() {
    let _ = Plane.stepper::<Midpoint>(0.1);
}
