//! The discrete Lagrangian of a step with internal stages.

use super::Field;
use super::advance::{FrictionScaling, GaussConstants, GaussConstantsOf};
use super::memory::{GaussMemory, GaussMemoryOf};
use super::stages::Stages;
use crate::algebra::lanes::Lanes;
use crate::algebra::stages::minus;
use crate::algebra::state::Vector;
use crate::algebra::state_sum::PlainSum;
use crate::scheme::elements::PairColumns;
use crate::scheme::system::{Hamiltonian as _, Segment};

/// `L_d(q_i, q_{i+1}, P) = A(q_i, P) + R · (q_{i+1} - Q)`, where the step from `(q_i, P)` leads to `(Q, R)`
/// and `A` is the sum of `b_i [P_i · V_i - F(P_i, Q_i)]` over its stages: the same extension as that of
/// compositions. NaN where the step has no solution.
pub(super) fn value<F: Field, const N: usize>(
    system: &F,
    GaussConstants { parameters, friction, common, .. }: &GaussConstantsOf<F, f64, N>,
    segment: &Segment<F::Vector>,
    dw: &[f64],
) -> f64 {
    let (q, p) = (segment.q0.components(), segment.p.components());
    let degrees = q.len();
    let fits = p.len() == degrees && segment.q1.components().len() == degrees && dw.len() == system.noises();
    if !fits || system.check(degrees).is_err() {
        return f64::NAN;
    }
    let mut memory = GaussMemoryOf::<F, f64, N>::default();
    memory.fit(degrees, dw.len());
    let table = common.table();
    let GaussMemory { mut given, mut lists, mut left } = memory;
    given.read(common, q, p, dw, &PlainSum);
    let step = given.step(system, (parameters, friction, common), [segment.t, segment.h]);
    if step.solve::<true>(&mut lists, &mut left).is_err() || !step.finish([q, p], dw, &mut lists, &PlainSum) {
        return f64::NAN;
    }
    // The momenta of the stages, eliminated in the Nyström form: `P_i = p - Σ_j a_ij ∂F/∂q (j)`.
    let slopes = lists.slopes[1].as_ref();
    let momenta: Vec<_> = (0..degrees)
        .map(|d| minus::<_, f64, N>(Lanes::<N>::splat(p[d]), slopes[d].products(&table.mu)))
        .collect();
    let mut action = 0.0;
    for i in 0..N {
        let own_q: Vec<f64> = lists.at[0].as_ref().iter().map(|stage| stage.get(i)).collect();
        let FrictionScaling { scale, inverse, .. } = friction;
        let own_p: Vec<f64> = momenta.iter().map(|stage| stage.get(i) * inverse[i]).collect();
        let (mut by_q, mut by_p) = (vec![0.0; degrees], vec![0.0; degrees]);
        let t = segment.t + table.c[i] * segment.h;
        let (at, into) = (([t, segment.h], [&own_q[..], &own_p], dw), [&mut by_q[..], &mut by_p]);
        system.step_gradient::<f64, f64, false, true>(parameters, at, into, &mut PairColumns::default());
        let pairing: f64 = own_p.iter().zip(&by_p).map(|(p, v)| p * v).sum();
        let drift = segment.h * system.evaluate(0, &own_q, &own_p, t);
        let noise = dw.iter().enumerate().map(|(k, dw)| dw * system.evaluate(k + 1, &own_q, &own_p, t));
        // With friction these are terms of `e^{γ τ} H(q, e^{-γ τ} π)`.
        action += table.b[i] * scale[i] * (pairing - drift - noise.sum::<f64>());
    }
    let scale = 1.0 / (1.0 + friction.decay);
    let [next_q, next_p] = &lists.next;
    let ends = segment.q1.components().iter().zip(next_q.as_ref()).zip(next_p.as_ref());
    action + ends.map(|((end, reached), momentum)| scale * momentum * (end - reached)).sum::<f64>()
}
