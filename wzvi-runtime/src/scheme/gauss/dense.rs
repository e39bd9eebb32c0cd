//! The collocation polynomial of a Gauss method, from the derivatives at its stages.
//!
//! The polynomial `u` of degree `S` with `u'(c_i) = J∇F(U_i)` has `u' = Σ_k a_k P_k(2θ - 1)` with
//! `a_k = (2k + 1) Σ_i b_i P_k(2c_i - 1) J∇F(U_i)`: the quadrature is exact for products of two such
//! polynomials.
//!
//! In the Nyström form the momenta of the stages are eliminated, and the coordinates follow from the
//! polynomial `u_p = p + Σ_k a_k ∫ P_k` of the momenta by `u'_q = ∂F/∂p(u_p)`, with degree `S + 1`. Since
//! `∂F/∂p` is linear, it maps the coefficients `c_k` of `u_p` to those of `u'_q`,
//!
//! ```text
//! c_0 = p + a_0/2 - a_1/6,   c_k = a_{k-1} / (2(2k - 1)) - a_{k+1} / (2(2k + 3)),   a_k = 0 for k ≥ S
//! ```

use super::Field;
use super::advance::{GaussConstants, GaussConstantsOf};
use super::memory::GaussMemory;
use super::stages::Stages;
use crate::algebra::scalar::ConstantsIn;
use crate::algebra::state::{State, Vector};
use crate::scheme::dense::{RateCoefficients, hermite_order};
use crate::scheme::elements::PairColumns;
use crate::scheme::plan::Plan;

/// The order of the collocation polynomial. With one stage it is a straight line, and the cubic of the
/// mid-point step replaces it.
pub(super) const fn dense_order(stages: u32, plan: &Plan) -> u32 {
    if stages == 1 { hermite_order(plan) } else { stages + 1 }
}

/// The derivatives of the collocation polynomial of the last step.
pub(super) fn slopes_between<F: Field, const N: usize>(
    system: &F,
    GaussConstants { parameters, common, .. }: &GaussConstantsOf<F, f64, N>,
    memory: &GaussMemory<f64, F::Shape, F::Noises, N>,
    before: &State<F::Vector>,
    h: f64,
    dw: &[f64],
    slopes: &mut RateCoefficients,
) {
    let [by_p, by_q] = &memory.left.past;
    let (by_p, by_q) = (by_p.as_ref(), by_q.as_ref());
    let degrees = before.q.components().len();
    debug_assert_eq!(by_q.len(), degrees, "a step has left its slopes");
    slopes.resize(if F::IS_NYSTROM { N + 1 } else { N }, degrees);
    let projection = slopes.projection(&common.table().c);
    let factors = projection.as_chunks::<N>().0;
    for d in 0..degrees {
        for (slope, factors) in slopes.of_mut(degrees + d).iter_mut().zip(factors) {
            *slope = -by_q[d].times(factors).total();
        }
        if F::IS_NYSTROM {
            slopes.of_mut(degrees + d)[N] = 0.0;
            continue;
        }
        for (slope, factors) in slopes.of_mut(d).iter_mut().zip(factors) {
            *slope = by_p[d].times(factors).total();
        }
    }
    slopes.keep_projection(projection);
    if F::IS_NYSTROM {
        drift(system, parameters, before, h, dw, slopes);
    }
}

/// The coefficients of the coordinates from those of the momenta.
fn drift<F: Field>(
    system: &F,
    parameters: &ConstantsIn<F::Parameters, f64>,
    before: &State<F::Vector>,
    h: f64,
    dw: &[f64],
    slopes: &mut RateCoefficients,
) {
    let (q, p) = (before.q.components(), before.p.components());
    let (degrees, rows) = (q.len(), slopes.rows());
    let [mut momenta, mut spare, mut of_q] = slopes.take_room();
    for k in 0..rows {
        let n = k as f64;
        for (d, momentum) in momenta.iter_mut().enumerate() {
            let a = slopes.of_mut(degrees + d);
            let before = if k == 0 { p[d] + 0.5 * a[0] } else { 0.5 * a[k - 1] / (2.0 * n - 1.0) };
            let after = a.get(k + 1).map_or(0.0, |a| 0.5 * a / (2.0 * n + 3.0));
            *momentum = before - after;
        }
        let (at, into) = (([before.t, h], [q, &momenta], dw), [&mut spare[..], &mut of_q]);
        system.step_gradient::<f64, f64, false, true>(parameters, at, into, &mut PairColumns::default());
        for (d, slope) in of_q.iter().enumerate() {
            slopes.of_mut(d)[k] = *slope;
        }
    }
    slopes.give_back([momenta, spare, of_q]);
}
