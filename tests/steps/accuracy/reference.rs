//! The discrete Euler-Lagrange equations of one step, solved to 150 digits.
//!
//! With quadrature point `l` in every term, `c_0 = h`, `c_k = ΔW_k` and `Q = q_i + l Δq`:
//!
//! ```text
//! Δq = Σ c_m ∂H_m/∂p(P, Q)      P - p_i = -(1 - l) Σ c_m ∂H_m/∂q(P, Q)      Δp = -Σ c_m ∂H_m/∂q(P, Q)
//! ```

pub(crate) use fixtures::extremes::state;
/// With one quadrature point.
pub(crate) use fixtures::schemes::Scheme as Point;
use wzvi::error::StepFailure;
use wzvi::prelude::*;
use wzvi::system::{Discretized, Scheme, SchemeOf, StepArguments};
use wzvi_runtime::algebra::state_sum::StateSum;

use super::real::{Real, error_in_ulps, with_precision};

/// Binary digits of the solution: more than the squares of the smallest differences that appear in the tests need.
const BITS: usize = 512;
/// A difference quotient with this step has 150 digits of error; an iteration gains as many.
const QUOTIENT: i32 = -170;
const MOST_ITERATIONS: u32 = 40;

/// `∂H_m/∂q` and `∂H_m/∂p`.
pub(crate) struct Gradients {
    pub(crate) q: Vec<Real>,
    pub(crate) p: Vec<Real>,
}

/// A system by its gradients.
pub(crate) trait Terms: Hamiltonian {
    /// Of the drift for `m = 0`, of noise `m - 1` otherwise.
    fn term(&self, m: usize, q: &[Real], p: &[Real]) -> Gradients;
}

/// One step to compare.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) h: f64,
    pub(crate) q: Vec<f64>,
    pub(crate) p: Vec<f64>,
    pub(crate) dw: Vec<f64>,
}

/// How far a generated step is from the exact one: the largest over its components.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Errors {
    /// Of the new state, in units in the last place.
    pub(crate) state: f64,
    /// Of the increments before they are added to the state, in units in the last place.
    pub(crate) increment: f64,
    /// Of the increments, in units in the last place and what the exact increment changes by when every input (state,
    /// step size, noise) is moved by one such unit: no arithmetic on rounded numbers can promise less.
    pub(crate) conditioned: f64,
}

/// The step of `case` by the generated code, against the equations solved from its own result.
pub(crate) fn compare<E: Point, H: Discretized<E> + Terms>(
    system: &H,
    case: &Case,
) -> Result<Errors, StepFailure> {
    let prepared = system.prepare(case.h).map_err(|_| StepFailure::NonFinite)?;
    let (mut q, mut p) = (case.q.clone(), case.p.clone());
    let mut carry = <SchemeOf<H, E> as Scheme<H>>::CompensatedSum::<f64>::default();
    let mut memory = Default::default();
    let at = StepArguments { t: 0.0, h: case.h, q: &mut q[..], p: &mut p[..], dw: &case.dw };
    SchemeOf::<H, E>::advance::<f64, f64, _, true>(system, &prepared, at, &mut memory, &mut carry)?;
    Ok(with_precision(BITS, || {
        let d = q.len();
        let computed: Vec<Real> = (0..d)
            .map(|i| Real::from(q[i]) - case.q[i] + carry.of_coordinate(i))
            .chain((0..d).map(|i| Real::from(p[i]) - case.p[i] + carry.of_momentum(i)))
            .collect();
        let exact = solve::<E, H>(system, case, &computed);
        let moved: Vec<Vec<Real>> =
            neighbours(case).iter().map(|case| solve::<E, H>(system, case, &exact)).collect();
        let mut errors = Errors::default();
        for (i, (computed, exact)) in computed.iter().zip(&exact).enumerate() {
            let (before, after) = if i < d { (case.q[i], q[i]) } else { (case.p[i - d], p[i - d]) };
            let increment = error_in_ulps(computed.to_f64(), exact);
            // One unit is 2^(exponent - 53), where the exact increment has an exponent.
            let unit = exact.exponent().map_or(-1074, |exponent| (exponent - 53).max(-1074));
            let inherent: f64 = moved.iter().map(|moved| (&moved[i] - exact).scaled(-unit).abs()).sum();
            errors.state = errors.state.max(error_in_ulps(after, &(Real::from(before) + exact)));
            errors.increment = errors.increment.max(increment);
            errors.conditioned = errors.conditioned.max(increment / (1.0 + inherent));
        }
        errors
    }))
}

/// `case` with one input moved by a unit in the last place, for every input.
fn neighbours(case: &Case) -> Vec<Case> {
    let mut moved = vec![Case { h: case.h.next_up(), ..case.clone() }];
    let places = [case.q.len(), case.p.len(), case.dw.len()];
    for (part, count) in places.into_iter().enumerate() {
        for i in 0..count {
            let mut neighbour = case.clone();
            let x = &mut [&mut neighbour.q, &mut neighbour.p, &mut neighbour.dw][part][i];
            *x = x.next_up();
            moved.push(neighbour);
        }
    }
    moved
}

/// `Δq` and `Δp`, by Newton's method from `start` with difference quotients.
fn solve<E: Point, H: Terms>(system: &H, case: &Case, start: &[Real]) -> Vec<Real> {
    let (d, l) = (case.q.len(), E::L[0]);
    // The unknowns are Δq and Δp, with P = p_i + (1 - l) Δp.
    let mut x = start.to_vec();
    let residual = |x: &[Real]| -> Vec<Real> {
        let q: Vec<Real> = (0..d).map(|i| &x[i] * l + case.q[i]).collect();
        let p: Vec<Real> = (0..d).map(|i| &x[d + i] * (1.0 - l) + case.p[i]).collect();
        let mut rest = x.to_vec();
        for (m, c) in [case.h].iter().chain(&case.dw).enumerate() {
            let term = system.term(m, &q, &p);
            for i in 0..d {
                rest[i] = &rest[i] - &term.p[i] * *c;
                rest[d + i] = &rest[d + i] + &term.q[i] * *c;
            }
        }
        rest
    };
    for _ in 0..MOST_ITERATIONS {
        let at = residual(&x);
        let mut columns = Vec::new();
        for j in 0..2 * d {
            let size = if x[j].is_zero() { Real::from(1.0) } else { x[j].abs() };
            let gap = size * 2.0_f64.powi(QUOTIENT);
            let mut moved = x.clone();
            moved[j] = &moved[j] + &gap;
            let column: Vec<Real> = residual(&moved).iter().zip(&at).map(|(a, b)| (a - b) / &gap).collect();
            columns.push(column);
        }
        let correction = eliminate(columns, at);
        let mut is_done = true;
        for (x, correction) in x.iter_mut().zip(&correction) {
            is_done &= match (correction.exponent(), x.exponent()) {
                (None, _) => true,
                (Some(correction), Some(size)) => correction < size - 200,
                (Some(_), None) => false,
            };
            *x = &*x - correction;
        }
        if is_done {
            return x;
        }
    }
    panic!("no reference for {case:?}")
}

/// `x` with `Σ_j columns_j x_j = b`, by elimination with pivoting.
fn eliminate(columns: Vec<Vec<Real>>, mut b: Vec<Real>) -> Vec<Real> {
    let n = b.len();
    let mut rows: Vec<Vec<Real>> =
        (0..n).map(|i| columns.iter().map(|column| column[i].clone()).collect()).collect();
    for k in 0..n {
        let pivot = (k..n).max_by(|&a, &b| rows[a][k].abs().partial_cmp(&rows[b][k].abs()).unwrap()).unwrap();
        rows.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..n {
            let factor = &rows[i][k] / &rows[k][k];
            let above = rows[k].clone();
            for (entry, above) in rows[i].iter_mut().zip(&above) {
                *entry = &*entry - &factor * above;
            }
            b[i] = &b[i] - &factor * &b[k];
        }
    }
    for k in (0..n).rev() {
        for j in k + 1..n {
            b[k] = &b[k] - &rows[k][j] * &b[j];
        }
        b[k] = &b[k] / &rows[k][k];
    }
    b
}

/// The value of which `percent` of `errors` are not above.
pub(crate) fn percentile(errors: &[f64], percent: usize) -> f64 {
    let mut sorted = errors.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[(sorted.len() - 1) * percent / 100]
}
