//! Programs that use systems with mistakes: `rustc` adds nothing to the messages.

use wzvi::prelude::*;

#[hamiltonian(embedding = Midpoint)]
struct NoDrift;

#[hamiltonian(drift = |q, p| q * p)]
struct NoEmbedding;

#[hamiltonian(drift = |q, p| q * p, embedding = [Midpiont, DeltaPlus, Corected<DeltaPlus>, Euler])]
struct Misspelt;

#[hamiltonian(
    drift = |q, p| 0.5 * omgea * q * q + self.mas * p * p,
    noise = [|q, _| sigma * q],
    embedding = Midpoint,
)]
struct Fields {
    omega: f64,
    mass: f64,
}

#[hamiltonian(drfit = |q, p| q * p, noises = [|q, p| q], scheme = Midpoint, potential = 1.0)]
struct Keys;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p - a * q.cos(),
    noise = [|q, _| q.sin()],
    embedding = Midpoint,
    invariant = [|q, p| 0.5 * p * p - a * q.cos(), |q, p| q * p, |_, _, t| t],
)]
struct Refuted {
    a: f64,
}

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

// Multiplicative noise: the limit of these schemes is another system.
#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
    embedding = [DeltaPlus, Midpoint, DeltaMinus, Mixed<Midpoint, Lambda<1, 4>>],
)]
struct Kubo {
    a: f64,
    sigma: f64,
}

#[hamiltonian(
    drift = |q, p| 0.5 * omega * q * q + p.sinn(),
    noise = [|q, p| sigm * q, |q, p| q[0]],
    embedding = [Midpoint, DeltaPuls],
    invariant = [|q, p| qq + p],
    verbose = true,
)]
struct Independent {
    sigma: f64,
}

fn main() {
    let _ = NoDrift.stepper::<Midpoint>(0.1);
    let _ = NoEmbedding.stepper::<Midpoint>(0.1);
    let _ = Misspelt.stepper::<DeltaPlus>(0.1);
    let _ = Fields { omega: 1.0, mass: 1.0 }.stepper::<Midpoint>(0.1);
    let _ = Keys.stepper::<Midpoint>(0.1);
    let _ = Refuted { a: 1.0 }.stepper::<Midpoint>(0.1);
    let _ = Plane.stepper::<Midpoint>(0.1);
    let _ = Kubo { a: 1.0, sigma: 0.5 }.stepper::<DeltaPlus>(0.1);
    let system = Independent { sigma: 1.0 };
    let _ = system.stepper::<Midpoint>(0.1);
    let _ = system.energy(&State::new([0.0], [0.0]));
}
