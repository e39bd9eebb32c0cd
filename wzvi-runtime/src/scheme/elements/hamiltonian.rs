//! What any sum of elements is as a Hamiltonian: values and slopes of one term, by those of the part that it belongs to.

use std::ops::Range;

use super::{Elements, Point, Slopes, check, slopes};
use crate::algebra::scalar::Scalar;
use crate::algebra::state::{State, Vector};
use crate::scheme::system::Gradient;

/// The part that is the drift, `h H_0`.
pub(super) const DRIFT: usize = 0;
/// The part that is the noises, `Σ_k ΔW_k H_k`.
pub(super) const NOISE: usize = 1;
/// The part that is the force beside the drift, with the slopes `-h f`.
pub(super) const FORCE: usize = 3;

/// Whether `q` and `p` are those of a state of the system.
pub(super) fn fits<H: Elements, S>(system: &H, q: &[S], p: &[S]) -> bool {
    q.len() == p.len() && check(system, q.len()).is_ok()
}

/// The part that Hamiltonian `term` belongs to, and the noises of it that act.
fn part_of(term: usize) -> (usize, Range<usize>) {
    match term.checked_sub(1) {
        None => (DRIFT, 0..0),
        Some(noise) => (NOISE, noise..term),
    }
}

/// [`Hamiltonian::evaluate`](crate::scheme::system::Hamiltonian::evaluate)
pub fn evaluate<H: Elements, S: Scalar>(system: &H, term: usize, q: &[S], p: &[S], t: f64) -> S {
    if term > system.noises() || !fits(system, q, p) {
        return S::from_f64(f64::NAN);
    }
    let (dw, (part, acting)) = ([S::from_f64(1.0)], part_of(term));
    system.value(part, 1.0, &Point { q, p, t, h: 1.0, dw: &dw, acting, scale: 1.0 })
}

/// [`Hamiltonian::differentiate`](crate::scheme::system::Hamiltonian::differentiate)
pub fn differentiate<H: Elements, S: Scalar>(
    system: &H,
    term: usize,
    q: &[S],
    p: &[S],
    t: f64,
    by_q: &mut [S],
    by_p: &mut [S],
) {
    let is_known =
        term <= system.noises() && fits(system, q, p) && by_q.len() == q.len() && by_p.len() == q.len();
    let start = S::from_f64(if is_known { 0.0 } else { f64::NAN });
    by_q.fill(start);
    by_p.fill(start);
    if is_known {
        let (dw, (part, acting)) = ([S::from_f64(1.0)], part_of(term));
        let at = Point { q, p, t, h: 1.0, dw: &dw, acting, scale: 1.0 };
        slopes(system, part, 1.0, &at, Slopes::ALL, by_q, by_p);
    }
}

/// [`Hamiltonian::differentiate_noises`](crate::scheme::system::Hamiltonian::differentiate_noises)
pub fn differentiate_noises<H: Elements>(
    system: &H,
    dw: &[f64],
    state: &State<H::Vector>,
    into: &mut Gradient<H::Vector>,
) {
    let (q, p) = (state.q.components(), state.p.components());
    let [by_q, by_p] = [&mut into.q, &mut into.p].map(Vector::components_mut);
    let is_known =
        dw.len() == system.noises() && fits(system, q, p) && by_q.len() == q.len() && by_p.len() == q.len();
    let start = if is_known { 0.0 } else { f64::NAN };
    by_q.fill(start);
    by_p.fill(start);
    if is_known {
        let at = Point { q, p, t: state.t, h: 1.0, dw, acting: 0..dw.len(), scale: 1.0 };
        slopes(system, NOISE, 1.0, &at, Slopes::ALL, by_q, by_p);
    }
}

/// [`Hamiltonian::force`](crate::scheme::system::Hamiltonian::force)
pub fn force<H: Elements, S: Scalar>(system: &H, q: &[S], p: &[S], t: f64, into: &mut [S]) {
    let is_known = fits(system, q, p) && into.len() == q.len();
    into.fill(S::from_f64(if is_known { 0.0 } else { f64::NAN }));
    if is_known && H::HAS_FORCE {
        let at = Point { q, p, t, h: 1.0, dw: &[], acting: 0..0, scale: 1.0 };
        slopes(system, FORCE, 1.0, &at, Slopes::BY_COORDINATES, into, &mut []);
        into.iter_mut().for_each(|slope| *slope = -*slope);
    }
}

/// [`Hamiltonian::invariant`](crate::scheme::system::Hamiltonian::invariant)
pub fn invariant<H: Elements>(system: &H, number: usize, state: &State<H::Vector>) -> f64 {
    let (q, p) = (state.q.components(), state.p.components());
    if number >= system.invariants() || !fits(system, q, p) {
        return f64::NAN;
    }
    let at = Point { q, p, t: state.t, h: 1.0, dw: &[], acting: 0..0, scale: 1.0 };
    system.value(H::INTEGRALS + number, 1.0, &at)
}
