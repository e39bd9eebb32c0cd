//! The systems of the suite.

use wzvi::prelude::*;

/// A mass on a stiff spring under gravity, in Cartesian coordinates: the stiff direction turns.
#[hamiltonian(
    drift = |[x, y], [px, py]| {
        let stretch = (x * x + y * y).sqrt() - 1.0;
        0.5 * (px * px + py * py) + y + 0.5 * stiffness * stretch * stretch
    },
    embedding = [Midpoint, Verlet, Gauss<4>],
)]
pub(crate) struct Spring {
    pub(crate) stiffness: f64,
}

/// The same in polar coordinates (length minus one, angle from below): the stiff direction is a coordinate.
#[hamiltonian(
    drift = |[s, angle], [ps, l]| {
        let r = 1.0 + s;
        0.5 * (ps * ps + l * l / (r * r)) - r * angle.cos() + 0.5 * stiffness * s * s
    },
    embedding = Midpoint,
)]
pub(crate) struct PolarSpring {
    pub(crate) stiffness: f64,
}

/// A linear oscillator of angular frequency `omega`.
#[hamiltonian(drift = |q, p| 0.5 * omega * (q * q + p * p), embedding = [DeltaPlus, Midpoint, Verlet, Gauss<8>])]
pub(crate) struct Oscillator {
    pub(crate) omega: f64,
}

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) - 1.0 / (x * x + y * y).sqrt(),
    embedding = Midpoint,
    invariant = [|[x, y], [px, py]| x * py - y * px],
)]
pub(crate) struct Kepler;

/// Two atoms on a line, by their distance.
#[hamiltonian(drift = |r, p| 0.5 * p * p + 4.0 * (r.powi(-12) - r.powi(-6)), embedding = [DeltaPlus, Midpoint])]
pub(crate) struct LennardJones;

#[hamiltonian(drift = |q, p| 0.5 * p * p + 1.0 - q.cos(), embedding = [DeltaPlus, Midpoint])]
pub(crate) struct Pendulum;

#[hamiltonian(drift = |q, p| 0.5 * p * p + 0.25 * (q * q - 1.0) * (q * q - 1.0), embedding = [DeltaPlus, Midpoint])]
pub(crate) struct DoubleWell;

#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y) + x * x * y - y * y * y / 3.0,
    embedding = [DeltaPlus, Midpoint],
)]
pub(crate) struct HenonHeiles;

#[hamiltonian(
    drift = |q, p| 0.5 * a * (q * q + p * p),
    noise = [|q, p| 0.5 * sigma * (q * q + p * p)],
    embedding = [Corrected<DeltaPlus>, Midpoint],
    invariant = [|q, p| q * q + p * p],
)]
pub(crate) struct Kubo {
    pub(crate) a: f64,
    pub(crate) sigma: f64,
}

/// `H_1 = σ q p`: the mid-point of a step has a pole at `σ ΔW = ±2`.
#[hamiltonian(
    drift = |q, p| 0.5 * (q * q + p * p),
    noise = [|q, p| sigma * q * p],
    embedding = Midpoint,
)]
pub(crate) struct Squeeze {
    pub(crate) sigma: f64,
}

/// A light and a heavy mass on springs, with a weak quartic coupling.
#[hamiltonian(
    drift = |[x, y], [px, py]| {
        let d = x - y;
        0.5 * (px * px / light + py * py / heavy) + 0.5 * (light * x * x + heavy * y * y) + 0.25 * light * d * d * d * d
    },
    embedding = Midpoint,
)]
pub(crate) struct TwoMasses {
    pub(crate) light: f64,
    pub(crate) heavy: f64,
}

/// Two minima at `±√a`.
#[hamiltonian(drift = |q, p| 0.5 * p * p + 0.25 * q * q * q * q - 0.5 * a * q * q, embedding = Midpoint)]
pub(crate) struct Well {
    pub(crate) a: f64,
}

/// Two minima at `±scale`, in any unit of length.
#[hamiltonian(
    drift = |q, p| {
        let x = q / scale;
        0.5 * p * p + 0.25 * scale * scale * (x * x - 1.0) * (x * x - 1.0)
    },
    embedding = Midpoint,
)]
pub(crate) struct ScaledWell {
    pub(crate) scale: f64,
}

/// A chain of masses, each on a spring to the next, of a size that is known at run time.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        (0..q.len()).map(|i| p[i] * p[i] / (2.0 * mass[i]) + 0.5 * mass[i] * q[i] * q[i]).sum::<f64>()
            + (1..q.len()).map(|i| 0.5 * k * (q[i] - q[i - 1]) * (q[i] - q[i - 1])).sum::<f64>()
    },
    embedding = Midpoint,
)]
pub(crate) struct MixedChain {
    pub(crate) mass: Vec<f64>,
    pub(crate) k: f64,
}
