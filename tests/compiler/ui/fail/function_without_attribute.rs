use wzvi::prelude::*;

fn potential(q: f64) -> f64 {
    q * q
}

#[hamiltonian(drift = |q, p| 0.5 * p * p + potential(q), embedding = Midpoint)]
struct Unmarked;

#[hamiltonian(drift = |q, p| 0.5 * p * p + self.energy_of(q), embedding = Midpoint)]
struct Method;

impl Method {
    fn energy_of(&self, q: f64) -> f64 {
        q * q
    }
}

fn main() {
    let _ = Unmarked.stepper::<Midpoint>(0.1);
    let _ = Method.stepper::<Midpoint>(0.1);
}
