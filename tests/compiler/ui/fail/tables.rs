use wzvi::prelude::*;

#[hamiltonian(drift = |q, p| p.cosh() + 0.5 * q * q, embedding = [Verlet, Midpoint])]
struct Relativistic;

#[hamiltonian(drift = |q, p| 0.5 * p * p * (1.0 + q * q), embedding = Verlet)]
struct Geodesic;

fn main() {
    let _ = Relativistic.stepper::<Composed<Verlet, Srkn6>>(0.1);
    let _ = Geodesic.stepper::<Composed<Verlet, Aba864>>(0.1);
    let _ = Relativistic.stepper::<Composed<Midpoint, BlanesMoan4>>(0.1);
}
