//! Powers, functions, senses of the integral and variables as other languages have them.

#[hamiltonian(drift = |q, p| 0.5 * p**2 + q^2, embedding = Midpoint)]
struct Powers;

#[hamiltonian(drift = |q, p| 0.5 * p * p - cos(q), embedding = Midpoint)]
struct Functions;

#[hamiltonian(drift = |q, p| 0.5 * p * p, noise = [|q, p| q], interpretation = Ito, embedding = Midpoint)]
struct Sense;

#[hamiltonian(drift = |q, p| 0.5 * p * p, noise = [kick = |q, p| q], embedding = Midpoint)]
struct Named;

/// A charge that is no coordinate.
#[hamiltonian(drift = |q, p| 0.5 * p * p + field * q, embedding = Midpoint)]
struct Charged {
    q: f64,
    field: f64,
}

fn main() {
    let stiffness = 2.0;

    #[hamiltonian(drift = |q, p| 0.5 * (p * p + stiffness * q * q), embedding = Midpoint)]
    struct Captures {
        mass: f64,
    }
}
