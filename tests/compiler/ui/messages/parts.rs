#[hamiltonian(drift = [|q, p| p * p * (1.0 + q * q), |q, _| q.cos()], embedding = Verlet)]
struct Geodesic;

#[hamiltonian(drift = [|q, p, t| 0.5 * p * p * t, |q, _, t| q * t], embedding = Verlet)]
struct Twice;

#[hamiltonian(drift = [|q, p| 0.5 * p * p, |q, _| q * q], noise = [|q, _| q], embedding = Verlet)]
struct Noisy;

#[hamiltonian(
    drift = [|q: &[f64], p: &[f64]| (0..q.len()).map(|i| p[i] * p[i] + q[i] * q[i]).sum::<f64>(), |q, _| q[0].cos()],
    embedding = Verlet,
)]
struct Unsized;

#[hamiltonian(drift = [|_, p| p, |q, _| q, |q, _| q], embedding = Verlet)]
struct Three;

#[hamiltonian(drift = [|q, p| q * p, |[x, y], _| x * y], embedding = Verlet)]
struct OtherShape;

#[hamiltonian(
    drift = [|q, p| 0.5 * p * p + q * q, |_, p| 0.1 * p.powi(4)],
    force = |q, _| -q.powi(3),
    embedding = Verlet,
)]
struct NowhereToAct;

#[hamiltonian(drift = [|_, p| 0.5 * p * p, |q, _| q * q], force = |_, p| -p.abs() * p, embedding = Verlet)]
struct Drag;

#[hamiltonian(drift = [|_, p| 0.5 * p * p, |q, p| q * q + 0.1 * p * p], friction = 0.2, embedding = Verlet)]
struct TwoRotations;

#[hamiltonian(drift = [|_, p, t| 0.5 * p * p * t.cos(), |q, _| q * q], force = |_, _, t| t.sin(), embedding = Verlet)]
struct TwoClocks;

#[hamiltonian(drift = [kinetic = |_, p| 0.5 * p * p, potential = |q, _| q * q], embedding = Verlet)]
struct Named;

#[hamiltonian(
    drift = [
        |[x, y], [u, v]| 0.5 * (u * u + v * v) - 1.0 / (x * x + y * y + soft).sqrt(),
        |[x, y], _| x * y,
    ],
    embedding = Verlet,
)]
struct Softened {
    soft: f64,
}

#[hamiltonian(
    drift = [
        |q: [[f64; 2]; 2], p: [[f64; 2]; 2]| {
            let kinetic: f64 = p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1])).sum();
            kinetic - 1.0 / q[0][0].hypot(q[0][1]) - 0.1 / (q[0][0] - q[1][0]).hypot(q[0][1] - q[1][1])
        },
        |q, _| q[0][0],
    ],
    embedding = Verlet,
)]
struct Attracted;

#[hamiltonian(
    drift = [|[x, y], [u, v]| 0.5 * u * u / m + 0.5 * v * v / n - k / x.hypot(y), |[x, y], _| x * y],
    embedding = Verlet,
)]
struct TwoMasses {
    m: f64,
    n: f64,
    k: f64,
}

#[hamiltonian(
    drift = [|[x, a, y, b], [u, c, v, d]| 0.5 * (u * u + v * v + c * c + d * d) - 1.0 / x.hypot(y) - 1.0 / a.hypot(b), |[x, a, _, _], _| x * a],
    embedding = Verlet,
)]
struct Interleaved;

#[hamiltonian(
    drift = [|[x, y], [u, v], t| 0.5 * (u * u + v * v) - t.exp() / x.hypot(y), |[x, y], _| x * y],
    embedding = Verlet,
)]
struct GrowingSun;

#[hamiltonian(
    drift = [|[x, y], [u, v]| 0.5 * (u * u + v * v) - 1.0 / x.hypot(y), |[x, y], _| x * y],
    friction = 0.1,
    embedding = Verlet,
)]
struct Braked;
