//! Systems that are compiled already: `pip install wzvi-gallery`.
#![forbid(unsafe_code)]

use wzvi::prelude::*;

/// A pendulum: q is its angle from rest in radians, p its angular momentum in units of m l².
#[hamiltonian(
    drift = |q, p| 0.5 * p * p - w * w * q.cos(),
    embedding = [Verlet, Gauss<4>],
    export = [],
)]
pub struct Pendulum {
    /// The angular frequency of small oscillations, 1/time.
    pub w: f64,
}

/// Kepler's problem in the plane.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - k / (x * x + y * y).sqrt(),
    invariant = [momentum = |[x, y], [px, py]| x * py - y * px],
    observe = [distance = |[x, y], [px, py]| (x * x + y * y).sqrt()],
    embedding = Verlet,
    export = [Composed<Verlet, KahanLi8>],
)]
pub struct Kepler {
    /// The strength of the attraction, length³/time².
    pub k: f64,
}

/// The galactic potential of Hénon and Heiles.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y) + l * (x * x * y - y * y * y / 3.0),
    embedding = Verlet,
    export = [Composed<Verlet, KahanLi8>],
)]
pub struct HenonHeiles {
    /// The strength of the cubic term; 1 in the paper.
    pub l: f64,
}

/// Two rods of one length and two masses: q are their angles from rest in radians.
#[hamiltonian(
    drift = |[q1, q2], [p1, p2]| {
        let (s, c) = (q1 - q2).sin_cos();
        let kinetic = (m2 * p1 * p1 + (m1 + m2) * p2 * p2 - 2.0 * m2 * p1 * p2 * c) / (2.0 * m2 * l * l * (m1 + m2 * s * s));
        kinetic - (m1 + m2) * g * l * q1.cos() - m2 * g * l * q2.cos()
    },
    embedding = Midpoint,
    export = [],
)]
pub struct DoublePendulum {
    /// The upper mass.
    pub m1: f64,
    /// The lower mass.
    pub m2: f64,
    /// The length of each rod.
    pub l: f64,
    /// The acceleration of gravity.
    pub g: f64,
}

/// An oscillator whose frequency is white noise around a mean.
#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = |q, p| 0.5 * sigma * (q * q + p * p),
    invariant = [action = |q, p| q * q + p * p],
    embedding = Midpoint,
    export = [],
)]
pub struct Kubo {
    /// The mean frequency, 1/time.
    pub a: f64,
    /// The strength of the noise, 1/√time.
    pub sigma: f64,
}

/// A particle in a double well, with friction in a heat bath.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p / m + barrier * (q * q - 1.0) * (q * q - 1.0),
    friction = gamma,
    temperature = kt,
    embedding = [Baoab, Gjf],
    export = [],
)]
pub struct DoubleWell {
    /// The mass.
    pub m: f64,
    /// The height of the barrier between the wells at -1 and 1, an energy.
    pub barrier: f64,
    /// The rate of friction, 1/time.
    pub gamma: f64,
    /// The temperature of the bath, an energy.
    pub kt: f64,
}

/// The chain of Fermi, Pasta, Ulam and Tsingou with fixed ends, of as many masses as the state has.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        let kinetic = p.iter().map(|p| 0.5 * p * p).sum::<f64>();
        let bond = |d: f64| 0.5 * d * d + alpha * d * d * d / 3.0 + 0.25 * beta * d * d * d * d;
        kinetic + bond(q[0]) + bond(-q[q.len() - 1]) + q.windows(2).map(|pair| bond(pair[1] - pair[0])).sum::<f64>()
    },
    embedding = Verlet,
    export = [],
)]
pub struct Chain {
    /// The strength of the cubic term of a bond.
    pub alpha: f64,
    /// The strength of the quartic term of a bond.
    pub beta: f64,
}

wzvi_c::export!(Pendulum, Kepler, HenonHeiles, DoublePendulum, Kubo, DoubleWell, Chain);
