use wzvi::prelude::*;

// The rest of the program has an error of its own: it is the only other one.
#[hamiltonian(drift = |q, p| q * p + b, embedding = Midpoint)]
#[derive(Clone, Debug)]
pub struct System {
    a: f64,
}

fn main() {
    let system = System { a: 1.0 };
    let copy = system.clone();
    let stepper = copy.stepper::<Midpoint>(0.1).unwrap();
    let length: String = 1;
}
