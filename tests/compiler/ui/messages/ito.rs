//! Systems in the sense of Ito that have no Hamiltonian and forces in that of Stratonovich, or not with this scheme.

/// Kubo's oscillator: phase space expands.
#[hamiltonian(drift = |q, p| 0.5 * (q * q + p * p), noise = [|q, p| 0.5 * s * (q * q + p * p)], calculus = Ito, embedding = Midpoint)]
struct Kubo {
    s: f64,
}

/// The same of a chain, in loops.
#[hamiltonian(drift = |q: &[f64], p: &[f64]| q.iter().zip(p).map(|(q, p)| 0.5 * (q * q + p * p)).sum::<f64>(), noise = [|q, p| q.iter().zip(p).map(|(q, p)| s * q * p).sum::<f64>()], calculus = Ito, embedding = Midpoint)]
struct Chain {
    s: f64,
}

/// A force of the momenta comes from the conversion, and kicks take none.
#[hamiltonian(drift = |q, p| 0.5 * p * p, noise_force = [|q, p| s * p], friction = g, temperature = kt, calculus = Ito, embedding = Baoab)]
struct Kicked {
    s: f64,
    g: f64,
    kt: f64,
}

#[hamiltonian(drift = [|q, p| 0.5 * p * p, |q, p| q.cos()], noise_force = [|q, p| s * p], calculus = Ito, embedding = Midpoint)]
struct Parts {
    s: f64,
}

#[hamiltonian(drift = [|q, p| 0.5 * p * p, |q, p| q.cos()], noise = [|q, p| s * (p + q * q)], calculus = Ito, embedding = Midpoint)]
struct Shifted {
    s: f64,
}

#[hamiltonian(drift = |q, p| 0.5 * p * p, noise = [|q, p| q], calculus = Itoh, embedding = Midpoint)]
struct Misspelt;

#[hamiltonian(drift = |q, p| 0.5 * p * p, noise = [|q, p| q], calculus = 1, embedding = Midpoint)]
struct Number;
