//! The systems, each with its gradients by hand.

pub(crate) use fixtures::small::{DoubleWell, KUBO, Kubo};
use wzvi::prelude::*;

use super::real::Real;
use super::reference::{Gradients, Terms};

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * omega * omega * q * q,
    embedding = [DeltaPlus, Midpoint, DeltaMinus],
)]
pub(crate) struct Oscillator {
    pub(crate) omega: f64,
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p / m + k * (1.0 - q.cos()),
    embedding = [DeltaPlus, Midpoint, DeltaMinus],
)]
pub(crate) struct Pendulum {
    pub(crate) m: f64,
    pub(crate) k: f64,
}

#[hamiltonian(
    drift = |[x, y], [u, v]| (u * u + v * v) / 2.0 - 1.0 / x.hypot(y),
    embedding = Midpoint,
)]
pub(crate) struct Kepler;

/// A light and a heavy mass on a stiff spring with a soft wall.
#[hamiltonian(
    drift = |[x, y], [u, v]| u * u / (2.0 * light) + v * v / (2.0 * heavy)
        + 0.5 * stiff * (y - x).powi(2) + 0.25 * soft * x.powi(4),
    embedding = Midpoint,
)]
pub(crate) struct Masses {
    pub(crate) light: f64,
    pub(crate) heavy: f64,
    pub(crate) stiff: f64,
    pub(crate) soft: f64,
}

/// `q' = (1 + c/2)/(1 - c/2) q` with `c = a h + σ ΔW`, and the inverse factor for `p`.
#[hamiltonian(
    drift = |q, p| a * q * p,
    noise = [|q, p| sigma * q * p],
    embedding = Midpoint,
)]
pub(crate) struct Growth {
    pub(crate) a: f64,
    pub(crate) sigma: f64,
}

fn gradients(q: Vec<Real>, p: Vec<Real>) -> Gradients {
    Gradients { q, p }
}

impl Terms for Oscillator {
    fn term(&self, _: usize, q: &[Real], p: &[Real]) -> Gradients {
        let omega = Real::from(self.omega);
        gradients(vec![&omega * &omega * &q[0]], vec![p[0].clone()])
    }
}

impl Terms for Pendulum {
    fn term(&self, _: usize, q: &[Real], p: &[Real]) -> Gradients {
        gradients(vec![q[0].sin() * self.k], vec![&p[0] / self.m])
    }
}

impl Terms for Kubo {
    fn term(&self, m: usize, q: &[Real], p: &[Real]) -> Gradients {
        let rate = [self.a, self.sigma][m];
        gradients(vec![&q[0] * rate], vec![&p[0] * rate])
    }
}

impl Terms for Kepler {
    fn term(&self, _: usize, q: &[Real], p: &[Real]) -> Gradients {
        let square = &q[0] * &q[0] + &q[1] * &q[1];
        let cube = &square * square.sqrt();
        gradients(q.iter().map(|x| x / &cube).collect(), p.to_vec())
    }
}

impl Terms for DoubleWell {
    fn term(&self, m: usize, q: &[Real], p: &[Real]) -> Gradients {
        match m {
            0 => gradients(vec![&q[0] * (&q[0] * &q[0] - 1.0)], vec![p[0].clone()]),
            _ => gradients(vec![&p[0] * self.sigma], vec![&q[0] * self.sigma]),
        }
    }
}

impl Terms for Masses {
    fn term(&self, _: usize, q: &[Real], p: &[Real]) -> Gradients {
        let pull = (&q[1] - &q[0]) * self.stiff;
        gradients(
            vec![&q[0] * &q[0] * &q[0] * self.soft - &pull, pull],
            vec![&p[0] / self.light, &p[1] / self.heavy],
        )
    }
}

impl Terms for Growth {
    fn term(&self, m: usize, q: &[Real], p: &[Real]) -> Gradients {
        let rate = [self.a, self.sigma][m];
        gradients(vec![&p[0] * rate], vec![&q[0] * rate])
    }
}
