//! The systems of the pictures.

use wzvi::prelude::*;

/// A rotation whose angle diffuses.
#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
    embedding = [Uncorrected<DeltaPlus>, Corrected<DeltaPlus>, Mixed<DeltaPlus, Midpoint>, Midpoint],
)]
pub(crate) struct Kubo {
    pub(crate) a: f64,
    pub(crate) sigma: f64,
}

#[hamiltonian(drift = |angle, momentum| 0.5 * momentum * momentum - angle.cos(), embedding = [Midpoint, Verlet])]
pub(crate) struct Pendulum;

/// Free rotation.
#[hamiltonian(drift = |q, p| 0.5 * p * p, embedding = Verlet)]
pub(crate) struct Rotor;

/// A star in a galaxy (M. Hénon, C. Heiles, 1964).
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y) + x * x * y - y * y * y / 3.0,
    embedding = [Verlet, Gauss<8>],
)]
pub(crate) struct HenonHeiles;

/// A planet; the angular momentum is proven to be conserved.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - 1.0 / (x * x + y * y).sqrt(),
    embedding = [DeltaPlus, Midpoint, Verlet, Gauss<4>, Gauss<8>],
    invariant = [angular_momentum = |[x, y], [px, py]| x * py - y * px],
)]
pub(crate) struct Kepler;

/// Bodies of mass 1 that attract each other.
#[hamiltonian(
    drift = |q: [[f64; 2]; N], p: [[f64; 2]; N]| {
        let kinetic = (0..N).map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1])).sum::<f64>();
        let pairs = (0..N).map(|i| (0..i).map(|j| {
            let [x, y] = [q[i][0] - q[j][0], q[i][1] - q[j][1]];
            1.0 / (x * x + y * y).sqrt()
        }).sum::<f64>()).sum::<f64>();
        kinetic - pairs
    },
    embedding = Verlet,
)]
pub(crate) struct Bodies<const N: usize>;

/// A chain with nonlinear springs, fixed at both ends (E. Fermi, J. Pasta, S. Ulam, M. Tsingou, 1955).
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let spring = |d: f64| 0.5 * d * d + alpha * d * d * d / 3.0;
        let n = q.len();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>()
            + spring(q[0])
            + (1..n).map(|i| spring(q[i] - q[i - 1])).sum::<f64>()
            + spring(-q[n - 1])
    },
    embedding = Verlet,
)]
pub(crate) struct Chain {
    pub(crate) alpha: f64,
}

/// A particle in two wells that is pushed at random.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * (q * q - 1.0) * (q * q - 1.0),
    noise = [|q, _| -s * q],
    embedding = Midpoint,
)]
pub(crate) struct DoubleWell {
    pub(crate) s: f64,
}

/// Simpson's rule as an embedding.
pub(crate) struct Simpson;

#[hamiltonian(
    drift = |q, p| 0.5 * (p * p + q * q),
    embedding = [Verlet, Midpoint, Simpson = [(0, 1/6), (1/2, 2/3), (1, 1/6)]],
)]
pub(crate) struct Oscillator;

/// The same wells in a heat bath.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * (q * q - 1.0) * (q * q - 1.0),
    friction = gamma,
    temperature = kt,
    embedding = Baoab,
)]
pub(crate) struct WarmWells {
    pub(crate) gamma: f64,
    pub(crate) kt: f64,
}

/// A damped pendulum, driven with the angular frequency 2/3.
#[hamiltonian(
    drift = |angle, p| 0.5 * p * p - angle.cos(),
    force = |angle, p, t| amplitude * (t / 1.5).sin(),
    friction = 0.5,
    embedding = Verlet,
)]
pub(crate) struct Driven {
    pub(crate) amplitude: f64,
}

#[hamiltonian_fn]
fn product(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The spin of two oscillators.
#[hamiltonian_fn]
fn spin(q: [f64; 2], p: [f64; 2]) -> [f64; 3] {
    [
        0.5 * (q[0] * q[1] + p[0] * p[1]),
        0.5 * (q[0] * p[1] - q[1] * p[0]),
        0.25 * (q[0] * q[0] + p[0] * p[0] - q[1] * q[1] - p[1] * p[1]),
    ]
}

/// Neighbours in a Heisenberg ring, each as two oscillators.
#[hamiltonian(
    drift = |q: &[[f64; 2]], p: &[[f64; 2]]| {
        let n = q.len();
        (0..n).map(|i| -product(spin(q[i], p[i]), spin(q[(i + 1) % n], p[(i + 1) % n]))).sum::<f64>()
    },
    embedding = Midpoint,
)]
pub(crate) struct SpinRing;

/// The spin at an angle and a height.
#[hamiltonian_fn]
fn spin_at(angle: f64, height: f64) -> [f64; 3] {
    let radius = (1.0 - height * height).sqrt();
    [radius * angle.cos(), radius * angle.sin(), height]
}

/// The same ring in angles and heights.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let n = q.len();
        (0..n).map(|i| -product(spin_at(q[i], p[i]), spin_at(q[(i + 1) % n], p[(i + 1) % n]))).sum::<f64>()
    },
    embedding = Midpoint,
)]
pub(crate) struct AngleRing;

/// A symmetric top with the moment of inertia 1 across its axis, and weight times distance to the fixed point 1.
#[hamiltonian(
    drift = |q: Rotation, p| {
        let kinetic = |i: usize| (0..3).map(|a| p[i][a] * p[i][a] / (2.0 * d[a])).sum::<f64>();
        kinetic(0) + kinetic(1) + kinetic(2) + q[2][2]
    },
    embedding = Rattle,
)]
pub(crate) struct Top {
    pub(crate) d: [f64; 3],
}

/// Three bodies in the plane, with the clock of their pairs.
#[hamiltonian(
    drift = |q: [[f64; 2]; 3], p: [[f64; 2]; 3]| {
        let kinetic = |i: usize| 0.5 * (p[i][0].powi(2) + p[i][1].powi(2)) / m[i];
        let pair = |i: usize, j: usize| {
            -m[i] * m[j] / ((q[i][0] - q[j][0]).powi(2) + (q[i][1] - q[j][1]).powi(2)).sqrt()
        };
        kinetic(0) + kinetic(1) + kinetic(2) + pair(0, 1) + pair(1, 2) + pair(2, 0)
    },
    clock = pairs,
    embedding = Clocked<Gauss<8>>,
)]
pub(crate) struct Encounter {
    pub(crate) m: [f64; 3],
}
