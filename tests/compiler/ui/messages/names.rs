#[hamiltonian(
    drift = |q, p| (q + p)**0.5 + a * sqrt(q * q + p * p) + atan2(q, p),
    ito = true,
    embedding = [midpoint, ImplicitMidpoint, SymplecticEuler, EulerMaruyama],
)]
struct Elsewhere {
    a: f64,
}

#[hamiltonian(drift = |q, p| self, noise = [|q, p, k| q; 2.5], embedding = Midpoint)]
struct Whole;

#[hamiltonian(drift = |q, p| self.0 * q + self.2, embedding = Midpoint)]
struct Tuple(f64, u8);

#[hamiltonian(drift = |q, p| p * p / mass, noise = [|x, y, t| x * t], embedding = Midpoint)]
struct Charged {
    q: f64,
    t: f64,
    mass: f64,
}
