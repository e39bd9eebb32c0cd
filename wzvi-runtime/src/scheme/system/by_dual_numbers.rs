//! The gradient of the discrete Lagrangian of a step that leads from `(q_i, P)` to `(Q, R)`.
//!
//! The sum `A` of the discrete Lagrangians of its parts has `dA = R · dQ - P · dq_i`. Therefore
//!
//! ```text
//! L_d(q_i, q_{i+1}, P) = A(q_i, P) + R(q_i, P) · (q_{i+1} - Q(q_i, P))
//! D_1 L_d = -P + (∂R/∂q_i)ᵀ (q_{i+1} - Q),   D_2 L_d = R,   ∂L_d/∂P = (∂R/∂P)ᵀ (q_{i+1} - Q)
//! ```
//!
//! whose discrete Euler-Lagrange equations say that `q_{i+1} = Q` and that the momenta of a node agree:
//! `P = p_i` is the momentum with which the step starts.

use super::anew::advance;
use super::{Hamiltonian, LagrangianGradient, Scheme, Segment, StepArguments, as_they_are};
use crate::algebra::scalar::Dual;
use crate::algebra::state::Vector;

/// The gradient, by dual numbers; NaN where the step has no solution or no Lagrangian.
pub(crate) fn gradient<H: Hamiltonian, T: Scheme<H> + ?Sized>(
    system: &H,
    segment: &Segment<H::Vector>,
    dw: &[f64],
) -> LagrangianGradient<H::Vector> {
    let d = segment.q0.components().len();
    let nowhere = || LagrangianGradient::nowhere(d);
    if !T::PROPERTIES.is_variational {
        return nowhere();
    }
    let Ok(prepared) = &T::prepare(system, &as_they_are, segment.h) else { return nowhere() };
    if segment.p.components().len() != d || segment.q1.components().len() != d {
        return nowhere();
    }
    let start = [segment.q0.components(), segment.p.components()];
    let step = |varied: Option<usize>| {
        let (mut q, mut p) = (lift(start[0], varied, 0), lift(start[1], varied, d));
        let dw = lift(dw, None, 0);
        let mut memory = T::Memory::<Dual<1>>::default();
        let at = StepArguments { t: segment.t, h: segment.h, q: &mut q[..], p: &mut p[..], dw: &dw };
        advance::<H, T, f64, _>(system, prepared, at, &mut memory).ok()?;
        Some([q, p])
    };
    let Some([reached, left_with]) = step(None) else { return nowhere() };
    let gap = gap(segment.q1.components(), &reached);
    let mut gradient =
        LagrangianGradient { q0: segment.p.clone(), q1: segment.p.clone(), p: H::Vector::zeros(d) };
    for p in gradient.q0.components_mut() {
        *p = -*p;
    }
    for (q1, momentum) in gradient.q1.components_mut().iter_mut().zip(&left_with) {
        *q1 = momentum.value;
    }
    for i in 0..d {
        for (offset, slope) in [(0, &mut gradient.q0), (d, &mut gradient.p)] {
            let Some([_, momenta]) = step(Some(offset + i)) else { return nowhere() };
            slope.components_mut()[i] += pulled(&momenta, &gap);
        }
    }
    gradient
}

/// The numbers from the place `offset` on, with an infinitesimal at the place `varied`.
fn lift(values: &[f64], varied: Option<usize>, offset: usize) -> Vec<Dual<1>> {
    let lift = |(i, &value)| Dual { value, derivative: [f64::from(varied == Some(offset + i))] };
    values.iter().enumerate().map(lift).collect()
}

fn gap(to: &[f64], from: &[Dual<1>]) -> Vec<f64> {
    to.iter().zip(from).map(|(to, from)| to - from.value).collect()
}

fn pulled(momenta: &[Dual<1>], gap: &[f64]) -> f64 {
    momenta.iter().zip(gap).map(|(momentum, gap)| momentum.derivative[0] * gap).sum()
}
