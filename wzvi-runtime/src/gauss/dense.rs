//! The collocation polynomial of a Gauss method, from the slopes at its stages.
//!
//! The polynomial `u` of degree `S` with `u'(c_i) = J∇F(U_i)` has `u' = Σ_k a_k P_k(2θ - 1)` with `a_k = (2k + 1) Σ_i b_i P_k(2c_i - 1) J∇F(U_i)`: the
//! quadrature is exact for products of two such polynomials.
//!
//! In the Nyström form the momenta of the stages are eliminated, and the coordinates are those that the polynomial `p + Σ_k a_k ∫ P_k` of the
//! momenta moves, `u'_q = ∂F/∂p(u_p)`, of degree `S + 1`. Since `∂F/∂p` is linear, it makes their coefficients of those of the polynomial itself,
//!
//! ```text
//! c_0 = p + a_0/2 - a_1/6,   c_k = a_{k-1} / (2(2k - 1)) - a_{k+1} / (2(2k + 3)),   a_k = 0 for k ≥ S
//! ```

use super::Field;
use super::advance::Prepared;
use super::kept::Memory;
use super::stages::Stages;
use crate::dense::{Slopes, hermite_order, legendre};
use crate::plan::Plan;
use crate::state::{State, Vector};

/// The order of the collocation polynomial. That of one stage is a straight line: the cubic of the mid-point step is taken instead.
pub const fn dense_order(stages: u32, plan: &Plan) -> u32 {
    if stages == 1 { hermite_order(plan) } else { stages + 1 }
}

/// The slopes of the collocation polynomial of the last step.
pub fn slopes_between<F: Field, const N: usize>(
    system: &F,
    prepared: &Prepared<N>,
    memory: &Memory<f64, F::Shape, F::Noises, N>,
    before: &State<F::Vector>,
    h: f64,
    dw: &[f64],
    slopes: &mut Slopes,
) {
    let [by_p, by_q] = &memory.past;
    let (by_p, by_q) = (by_p.as_ref(), by_q.as_ref());
    let degrees = before.q.components().len();
    debug_assert_eq!(by_q.len(), degrees, "a step has left its slopes");
    slopes.resize(if F::IS_NYSTROM { N + 1 } else { N }, degrees);
    // `(2k + 1) P_k(2c_i - 1)` by `k`.
    let mut factors = [[0.0; N]; N];
    for (i, c) in prepared.table().c.iter().enumerate() {
        let mut values = [0.0; N];
        legendre(2.0 * c - 1.0, &mut values);
        for (k, (factors, value)) in factors.iter_mut().zip(values).enumerate() {
            factors[i] = (2.0 * k as f64 + 1.0) * value;
        }
    }
    for (k, factors) in factors.iter().enumerate() {
        let (of_q, of_p) = slopes.row_mut(k).split_at_mut(degrees);
        for d in 0..degrees {
            of_p[d] = -by_q[d].times(factors).total();
            if !F::IS_NYSTROM {
                of_q[d] = by_p[d].times(factors).total();
            }
        }
    }
    if F::IS_NYSTROM {
        slopes.row_mut(N).fill(0.0);
        drift(system, before, h, dw, slopes);
    }
}

/// The coefficients of the coordinates from those of the momenta.
fn drift<F: Field>(system: &F, before: &State<F::Vector>, h: f64, dw: &[f64], slopes: &mut Slopes) {
    let (q, p) = (before.q.components(), before.p.components());
    let (degrees, rows) = (q.len(), slopes.rows());
    let [mut momenta, mut spare] = slopes.take_room();
    for k in 0..rows {
        let n = k as f64;
        for (d, momentum) in momenta.iter_mut().enumerate() {
            *momentum = if k == 0 { p[d] } else { 0.0 };
            let mut add = |row: usize, factor: f64| *momentum += factor * slopes.row_mut(row)[degrees + d];
            add(k.saturating_sub(1), if k == 0 { 0.5 } else { 0.5 / (2.0 * n - 1.0) });
            if k + 1 < rows {
                add(k + 1, -0.5 / (2.0 * n + 3.0));
            }
        }
        let of_q = &mut slopes.row_mut(k)[..degrees];
        system.slopes::<f64, false, true>(before.t, h, q, &momenta, dw, &mut spare, of_q);
    }
    slopes.give_back([momenta, spare]);
}
