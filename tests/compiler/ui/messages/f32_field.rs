#[hamiltonian(drift = |q, p| a * q * q + b[0] * p + 1.0f32 * (q as f32), embedding = Midpoint)]
struct System {
    a: f32,
    b: [f32; 2],
}
