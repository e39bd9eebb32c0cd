//! The gradient of the discrete Lagrangian of a step that leads from `(q_i, P)` to `(Q, R)`.
//!
//! The sum `A` of the discrete Lagrangians of its parts has `dA = R · dQ - P · dq_i`. Therefore
//!
//! ```text
//! L_d(q_i, q_{i+1}, P) = A(q_i, P) + R(q_i, P) · (q_{i+1} - Q(q_i, P))
//! D_1 L_d = -P + (∂R/∂q_i)ᵀ (q_{i+1} - Q),   D_2 L_d = R,   ∂L_d/∂P = (∂R/∂P)ᵀ (q_{i+1} - Q)
//! ```
//!
//! whose discrete Euler-Lagrange equations say that `q_{i+1} = Q` and that the momenta of a node agree: `P = p_i` is the
//! momentum with which the step starts.

use super::anew::advance;
use super::{At, Hamiltonian, LagrangianGradient, Scheme, Segment, as_they_are};
use crate::algebra::scalar::{Dual, Scalar};
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
        let lift = |offset: usize, values: &[f64]| -> Vec<Dual<1>> {
            let numbered = values.iter().enumerate();
            numbered
                .map(|(i, &x)| Dual { value: x, derivative: [f64::from(varied == Some(offset + i))] })
                .collect()
        };
        let (mut q, mut p) = (lift(0, start[0]), lift(d, start[1]));
        let dw: Vec<Dual<1>> = dw.iter().map(|&dw| Dual::from_f64(dw)).collect();
        let mut memory = T::Memory::<Dual<1>>::default();
        let at = At { t: segment.t, h: segment.h, q: &mut q, p: &mut p, dw: &dw };
        advance::<H, T, f64, _>(system, prepared, at, &mut memory).ok()?;
        Some([q, p])
    };
    let Some([reached, left_with]) = step(None) else { return nowhere() };
    let gap: Vec<f64> = segment.q1.components().iter().zip(&reached).map(|(q1, q)| q1 - q.value).collect();
    let mut gradient =
        LagrangianGradient { q0: segment.p.clone(), q1: segment.p.clone(), p: H::Vector::zeros(d) };
    gradient.q0.components_mut().iter_mut().for_each(|p| *p = -*p);
    for (q1, momentum) in gradient.q1.components_mut().iter_mut().zip(&left_with) {
        *q1 = momentum.value;
    }
    for i in 0..d {
        for (offset, slope) in [(0, &mut gradient.q0), (d, &mut gradient.p)] {
            let Some([_, momenta]) = step(Some(offset + i)) else { return nowhere() };
            let pulled: f64 =
                momenta.iter().zip(&gap).map(|(momentum, gap)| momentum.derivative[0] * gap).sum();
            slope.components_mut()[i] += pulled;
        }
    }
    gradient
}
