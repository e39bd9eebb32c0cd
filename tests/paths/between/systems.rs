//! Systems whose solutions are known.

use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

pub(crate) type V1 = SVector<f64, 1>;

/// `q = cos t`, `p = -sin t` from (1, 0).
#[hamiltonian(drift = |q, p| 0.5 * (p * p + q * q), embedding = [Midpoint, Verlet, Gauss<4>, Gauss<8>])]
pub(crate) struct Oscillator;

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
