//! Systems with friction at a temperature.

use wzvi::prelude::*;

/// `p²/2m + k q²/2 + b q⁴/4`
#[hamiltonian(
    drift = |q, p| 0.5 * p * p / m + 0.5 * k * q * q + 0.25 * b * q.powi(4),
    friction = gamma,
    temperature = kt,
    embedding = [
        Baoab, Obabo,
        Thermostat<Verlet>, Thermostat<Midpoint>, Thermostat<Gauss<2>>, Thermostat<Gauss<3>>,
    ],
)]
#[derive(Clone, Debug)]
pub(crate) struct Oscillator {
    pub(crate) m: f64,
    pub(crate) k: f64,
    pub(crate) b: f64,
    /// Rate of the friction.
    pub(crate) gamma: f64,
    pub(crate) kt: f64,
}

/// The same without temperature.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p / m + 0.5 * k * q * q + 0.25 * b * q.powi(4),
    friction = gamma,
    embedding = Baoab,
)]
#[derive(Clone, Debug)]
pub(crate) struct Damped {
    pub(crate) m: f64,
    pub(crate) k: f64,
    pub(crate) b: f64,
    pub(crate) gamma: f64,
}

/// The same without friction.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p / m + 0.5 * k * q * q + 0.25 * b * q.powi(4),
    embedding = [Verlet, Midpoint, Gauss<2>],
)]
pub(crate) struct Free {
    pub(crate) m: f64,
    pub(crate) k: f64,
    pub(crate) b: f64,
}

/// Two coupled masses with a friction matrix.
#[hamiltonian(
    drift = |[x, y], [px, py]| {
        0.5 * (px * px / m + py * py / n) + k * (0.5 * (x * x + 2.0 * y * y) + 0.25 * (x - y).powi(4))
    },
    damping = damping, temperature = kt, embedding = [Baoab, Obabo, Thermostat<Midpoint>],
)]
#[derive(Clone, Debug)]
pub(crate) struct Coupled {
    pub(crate) m: f64,
    pub(crate) n: f64,
    pub(crate) k: f64,
    pub(crate) damping: [[f64; 2]; 2],
    pub(crate) kt: f64,
}

/// Friction that depends on the place: `γ(q) = γ (1 + q²)`.
#[hamiltonian(drift = |q, p| 0.5 * p * p / m + 0.5 * q * q, friction = |q| if q < edge { gamma * (1.0 + q * q) } else { -gamma * (1.0 + q * q) }, temperature = kt, embedding = [Baoab, Obabo, Thermostat<Midpoint>])]
#[derive(Clone, Debug)]
pub(crate) struct Rough {
    pub(crate) m: f64,
    pub(crate) gamma: f64,
    /// Makes the friction negative above `q = edge`.
    pub(crate) edge: f64,
    pub(crate) kt: f64,
}

/// Two masses, with a friction matrix that depends on the place.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (px * px / m + py * py / n) + 0.5 * k * (x * x + 2.0 * y * y),
    damping = |[x, y]| [[1.0 + x * x, 0.5 + 0.1 * y], [0.5 + 0.1 * y, 0.5 + 0.3 * y * y]], temperature = kt, embedding = [Baoab, Thermostat<Midpoint>],
)]
#[derive(Clone, Debug)]
pub(crate) struct RoughPlane {
    pub(crate) m: f64,
    pub(crate) n: f64,
    pub(crate) k: f64,
    pub(crate) kt: f64,
}

impl RoughPlane {
    /// `Γ` at a place: of rank one where `x = 0`.
    pub(crate) fn friction(x: f64, y: f64) -> [[f64; 2]; 2] {
        [[1.0 + x * x, 0.5 + 0.1 * y], [0.5 + 0.1 * y, 0.5 + 0.3 * y * y]]
    }
}

/// A chain of any length, thermostatted at its first site only.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        (0..q.len()).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i]).sum::<f64>()
            + (0..q.len() - 1).map(|i| 0.25 * (q[i + 1] - q[i]).powi(4)).sum::<f64>()
    },
    friction = |q: &[f64]| (0..q.len()).map(|i| if i == 0 { gamma } else { 0.0 }), temperature = kt, embedding = [Baoab, Obabo, Thermostat<Midpoint>],
)]
#[derive(Clone, Debug)]
pub(crate) struct Chain {
    pub(crate) gamma: f64,
    pub(crate) kt: f64,
}

/// The same chain without a bath.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        (0..q.len()).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i]).sum::<f64>()
            + (0..q.len() - 1).map(|i| 0.25 * (q[i + 1] - q[i]).powi(4)).sum::<f64>()
    },
    embedding = Verlet,
)]
pub(crate) struct FreeChain;

/// Multiplicative noise of its own beside the bath.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    noise = [|q, p| sigma * q],
    friction = gamma, temperature = kt, embedding = [Baoab, Obabo, Thermostat<Midpoint>],
)]
#[derive(Clone, Debug)]
pub(crate) struct Driven {
    pub(crate) sigma: f64,
    pub(crate) gamma: f64,
    pub(crate) kt: f64,
}

/// Masses that are no diagonal matrix, and one rate, which may depend on the place: `γ (1 + s x²)`.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (a * px * px + 2.0 * b * px * py + c * py * py) + 0.5 * k * (x * x + y * y),
    friction = gamma, temperature = kt, embedding = [Baoab, Thermostat<Midpoint>],
)]
#[derive(Clone, Debug)]
pub(crate) struct Linked {
    pub(crate) a: f64,
    pub(crate) b: f64,
    pub(crate) c: f64,
    pub(crate) k: f64,
    pub(crate) gamma: f64,
    pub(crate) kt: f64,
}

/// The same with a rate that depends on the place.
#[hamiltonian(
    drift = |[x, y], [px, py]| 0.5 * (a * px * px + 2.0 * b * px * py + c * py * py) + 0.5 * k * (x * x + y * y),
    friction = |[x, y]| gamma * (1.0 + x * x), temperature = kt, embedding = [Baoab, Thermostat<Midpoint>],
)]
#[derive(Clone, Debug)]
pub(crate) struct RoughLinked {
    pub(crate) a: f64,
    pub(crate) b: f64,
    pub(crate) c: f64,
    pub(crate) k: f64,
    pub(crate) gamma: f64,
    pub(crate) kt: f64,
}

/// A wall at `q = 0`, where energies are undefined.
#[hamiltonian(drift = |q, p| 0.5 * p * p + q + 2.0 / q.sqrt(), friction = gamma, temperature = kt, embedding = [Baoab])]
#[derive(Clone, Debug)]
pub(crate) struct Wall {
    pub(crate) gamma: f64,
    pub(crate) kt: f64,
}

/// A chain in a bath of which every site is kicked.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() + q.windows(2).map(|w| 0.5 * (w[1] - w[0]).powi(2)).sum::<f64>()
    },
    noise = [|q, p, k| 0.3 * q[k]; self.sites],
    friction = gamma, temperature = kt, embedding = [Baoab],
)]
#[derive(Clone, Debug)]
pub(crate) struct Kicked {
    pub(crate) sites: usize,
    pub(crate) gamma: f64,
    pub(crate) kt: f64,
}

/// Sites with a rate each, from a list that may be too short.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        (0..q.len()).map(|i| 0.5 * p[i] * p[i]).sum::<f64>() + (0..q.len()).map(|i| 0.5 * q[i] * q[i]).sum::<f64>()
    },
    friction = |q: &[f64]| (0..q.len()).map(|i| self.rates[i]),
    temperature = kt,
    embedding = [Baoab, Obabo, Thermostat<Midpoint>],
)]
#[derive(Clone, Debug)]
pub(crate) struct Rated {
    pub(crate) rates: Vec<f64>,
    pub(crate) kt: f64,
}
