//! Systems whose solutions are known.

use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

pub(crate) type V1 = SVector<f64, 1>;

/// `q = cos t`, `p = -sin t` from (1, 0).
#[hamiltonian(drift = |q, p| 0.5 * (p * p + q * q), embedding = [Midpoint, Verlet, Gauss<4>, Gauss<8>])]
pub(crate) struct Oscillator;

#[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), embedding = [Verlet, Gauss<8>, Gauss<16>])]
pub(crate) struct Pendulum;

impl Pendulum {
    /// A quarter of the period from the amplitude `q`: `K(sin(q/2))`, by the arithmetic-geometric mean.
    pub(crate) fn quarter(amplitude: f64) -> f64 {
        let (mut a, mut b) = (1.0, (0.5 * amplitude).cos());
        for _ in 0..8 {
            (a, b) = (0.5 * (a + b), (a * b).sqrt());
        }
        std::f64::consts::FRAC_PI_2 / a
    }
}

/// A rotation whose angle diffuses, and a noise that kicks.
#[hamiltonian(
    drift = |q, p| 0.5 * (p * p + q * q),
    noise = [|q, p| 0.2 * (p * p + q * q), |q, p| 0.3 * q],
    embedding = [Midpoint, Gauss<2>],
)]
pub(crate) struct Shaken;

pub(crate) fn start() -> State<V1> {
    State::new([1.0], [0.0])
}
