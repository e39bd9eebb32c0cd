//! Systems with forces, in straight lines and in loops.

use wzvi::prelude::*;

/// A damped pendulum that is driven: `f` reads coordinates, momenta and time.
macro_rules! driven {
    ($name:ident, [$($generics:tt)*], $state:ty) => {
        #[hamiltonian(
            drift = |q: $state, p: $state| 0.5 * p[0] * p[0] - q[0].cos(),
            force = |q: $state, p: $state, t| (0..q.len()).map(|i| -self.drag * p[i] * p[i].abs() + self.push * (1.3 * t).cos() * q[i].cos()),
            embedding = [DeltaPlus, DeltaMinus, Midpoint, Lambda<1, 3>, Verlet, Gauss<2>, Gauss<3>],
        )]
        #[derive(Clone, Debug)]
        pub(crate) struct $name$($generics)* {
            pub(crate) drag: f64,
            pub(crate) push: f64,
        }
    };
}

driven!(DrivenInline, [], [f64; 1]);
driven!(DrivenInLoops, [<const N: usize>], [f64; N]);
pub(crate) type DrivenLoops = DrivenInLoops<1>;

/// A harmonic oscillator with drag and a periodic force: solved exactly.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    force = |_q, p, t| -drag * p + push * (2.0 * t).cos(),
    embedding = [DeltaPlus, DeltaMinus, Midpoint, Verlet, Gauss<2>, Gauss<3>, Gauss<4>],
)]
#[derive(Clone, Debug)]
pub(crate) struct Oscillator {
    pub(crate) drag: f64,
    pub(crate) push: f64,
}

/// A chain with drag between neighbours, a wind that blows in time, and noise on every site.
#[hamiltonian(
    drift = |q: [f64; 5], p: [f64; 5]| (0..5).map(|i| 0.5 * p[i] * p[i] / self.mass[i]).sum::<f64>()
        + (0..4).map(|i| 1.0 - (q[i + 1] - q[i]).cos()).sum::<f64>(),
    force = |q: [f64; 5], p: [f64; 5], t| (0..5).map(|i| {
        let left = if i > 0 { p[i - 1] - p[i] } else { -p[i] };
        self.drag * left + 0.3 * (t + q[i]).sin()
    }),
    noise_force = [|q: [f64; 5], p: [f64; 5], k| (0..5).map(|i| if i == k { self.sigma * q[i].cos() } else { 0.0 }); 5],
    embedding = [DeltaPlus, DeltaMinus, Midpoint, Verlet, Gauss<2>],
)]
#[derive(Clone, Debug)]
pub(crate) struct ChainInline {
    pub(crate) mass: [f64; 5],
    pub(crate) drag: f64,
    pub(crate) sigma: f64,
}

/// The same in loops, and of any length.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| 0.5 * p[i] * p[i] / self.mass[i]).sum::<f64>()
        + (0..q.len() - 1).map(|i| 1.0 - (q[i + 1] - q[i]).cos()).sum::<f64>(),
    force = |q: &[f64], p: &[f64], t| (0..q.len()).map(|i| {
        let left = if i > 0 { p[i - 1] - p[i] } else { -p[i] };
        self.drag * left + 0.3 * (t + q[i]).sin()
    }),
    noise_force = [|q: &[f64], p: &[f64], k| (0..q.len()).map(|i| if i == k { self.sigma * q[i].cos() } else { 0.0 }); 5],
    embedding = [DeltaPlus, DeltaMinus, Midpoint, Verlet, Gauss<2>],
)]
#[derive(Clone, Debug)]
pub(crate) struct ChainLoops {
    pub(crate) mass: Vec<f64>,
    pub(crate) drag: f64,
    pub(crate) sigma: f64,
}
