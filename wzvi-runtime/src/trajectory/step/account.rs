//! The account of the energy that forces and friction exchange, if they are parts of a scheme's steps.
//!
//! Along the dense output of a step, with the nodes `θ_i` and weights `b_i` of Gauss,
//!
//! ```text
//! work = Σ_i b_i (h f · v + h ∂H/∂t + Σ_k ΔW_k {H_k, H})(z(θ_i)),   heat = -h Σ_i b_i γ p · v,   v = ∂H/∂p
//! ```
//!
//! With a bath, whose noise makes momenta rough inside the step, the force is that in the middle and works
//! along the way `Δq`, and explicit time is `H(t + h) - H(t)` there.

use crate::algebra::scalar::Scalar;
use crate::algebra::state::{State, Vector, copy_state, dot};
use crate::scheme::dense::DenseOutput;
use crate::scheme::gauss::quadrature;
use crate::scheme::system::{Discretized, Exchange, Gradient, Hamiltonian};

/// The accountant of a stepper.
#[derive(Clone, Debug)]
pub(super) struct EnergyLedger<V> {
    /// The state at the start of the step.
    pub(super) before: State<V>,
    pub(super) dense: DenseOutput<V>,
    at: State<V>,
    force: V,
    drift: Gradient<V>,
    noise: Gradient<V>,
    /// Nodes and weights: those of the stages of a Gauss method, so that work is of the order that its steps
    /// have.
    quadrature: (Vec<f64>, Vec<f64>),
}

/// Whether steps of a system exchange energy by more than what their scheme accounts for.
pub(super) fn is_wanted<H: Discretized<E>, E>(system: &H) -> bool {
    H::KIND.is_forced
        || H::KIND.is_conformal
        || (H::PROPERTIES.exchanges && (system.noises() > 0 || H::KIND.reads_time))
}

impl<V: Vector> EnergyLedger<V> {
    /// For a scheme of this order.
    pub(super) fn of(state: &State<V>, order: u32) -> Self {
        let zeros = || V::zeros(state.q.components().len());
        let [drift, noise] = [(); 2].map(|()| Gradient { q: zeros(), p: zeros() });
        let (dense, quadrature) = (DenseOutput::of(state), quadrature(order.div_ceil(2) as usize));
        Self { before: state.clone(), dense, at: state.clone(), force: zeros(), drift, noise, quadrature }
    }

    /// The energy that the step of `dense` exchanged, besides the energy that its scheme accounts for.
    pub(super) fn exchanged<H: Discretized<E, Vector = V>, E>(
        &mut self,
        system: &H,
        after: &State<V>,
        h: f64,
        dw: &[f64],
    ) -> Exchange {
        if H::PROPERTIES.exchanges {
            return self.along_the_way(system, after, dw);
        }
        let mut exchange = Exchange::default();
        for stage in 0..self.quadrature.0.len() {
            let (node, weight) = (self.quadrature.0[stage], self.quadrature.1[stage]);
            self.dense.write(node, &mut self.at);
            exchange += self.power(system, h, dw, weight);
        }
        exchange
    }

    /// The share of one node.
    fn power<H: Hamiltonian<Vector = V>>(&mut self, system: &H, h: f64, dw: &[f64], weight: f64) -> Exchange {
        let by_noise = self.differentiate(system, dw);
        let Self { at, force, drift: Gradient { p: velocity, .. }, .. } = self;
        system.force(at.q.components(), at.p.components(), at.t, force.components_mut());
        let work = h * dot(force, velocity) + by_time(system, at, h) + by_noise;
        let heat =
            if H::KIND.is_conformal { -h * system.friction_rate() * dot(&at.p, velocity) } else { 0.0 };
        Exchange { work: weight * work, heat: weight * heat }
    }

    /// With the middle of both nodes, along `Δq`.
    fn along_the_way<H: Hamiltonian<Vector = V>>(
        &mut self,
        system: &H,
        after: &State<V>,
        dw: &[f64],
    ) -> Exchange {
        let Self { before, at, .. } = self;
        copy_state(at, before);
        at.t = 0.5 * (before.t + after.t);
        for (middle, after) in [(&mut at.q, &after.q), (&mut at.p, &after.p)] {
            let pairs = middle.components_mut().iter_mut().zip(after.components());
            pairs.for_each(|(middle, after)| *middle = 0.5 * (*middle + after));
        }
        let by_noise = if system.noises() > 0 { self.differentiate(system, dw) } else { 0.0 };
        let Self { before, at, force, .. } = self;
        system.force(at.q.components(), at.p.components(), at.t, force.components_mut());
        let moved =
            after.q.components().iter().zip(before.q.components()).map(|(after, before)| after - before);
        let by_force: f64 = moved.zip(force.components()).map(|(moved, force)| moved * force).sum();
        let (q, p) = (at.q.components(), at.p.components());
        let by_time = match H::KIND.reads_time {
            true => system.evaluate(0, q, p, after.t) - system.evaluate(0, q, p, before.t),
            false => 0.0,
        };
        let work = by_force + by_time + by_noise;
        Exchange { work, heat: 0.0 }
    }

    /// The gradient of the energy where it is looked at, and what noises gain it there, `Σ_k ΔW_k {H_k, H}`.
    /// After these increments come those of a bath.
    fn differentiate<H: Hamiltonian<Vector = V>>(&mut self, system: &H, dw: &[f64]) -> f64 {
        let Self { at, drift, noise, .. } = self;
        let [by_q, by_p] = [&mut drift.q, &mut drift.p].map(Vector::components_mut);
        system.differentiate(0, at.q.components(), at.p.components(), at.t, by_q, by_p);
        let of_noises = &dw[..dw.len().min(system.noises())];
        if of_noises.is_empty() {
            return 0.0;
        }
        system.differentiate_noises(of_noises, at, noise);
        noise.bracket(drift)
    }
}

/// `h ∂H/∂t`, by a difference over the part of a step that makes truncation and rounding alike: exactly zero
/// without explicit time.
fn by_time<H: Hamiltonian>(system: &H, at: &State<H::Vector>, h: f64) -> f64 {
    let apart = Scalar::cbrt(f64::EPSILON);
    let (q, p) = (at.q.components(), at.p.components());
    let energy = |t: f64| system.evaluate(0, q, p, t);
    (energy(at.t + apart * h) - energy(at.t - apart * h)) / (2.0 * apart)
}
