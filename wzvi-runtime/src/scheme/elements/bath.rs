//! Friction of any sum of elements, for thermostats.

use super::step::nothing;
use super::{Elements, EvaluationPoint, HessianBlock, PairColumns, Partials, slopes};
use crate::algebra::scalar::Scalar;

/// The friction rates, from the derivatives of part number `part`, a covector.
pub(crate) fn rates<H: Elements, S: Scalar>(
    system: (&H, &[S::Constant]),
    part: usize,
    q: &[S],
    into: &mut [S],
    columns: &mut PairColumns,
) {
    if into.len() != q.len() {
        return into.fill(S::from_f64(f64::NAN));
    }
    let (system, parameters) = system;
    let at = EvaluationPoint::new([q, q], Scalar::from_f64(0.0), parameters, &[]);
    into.fill(S::from_f64(0.0));
    slopes(system, (part, 1.0), &at, Partials::BY_COORDINATES, into, &mut [], columns);
    // A covector `f` has the derivatives `-f`.
    into.iter_mut().for_each(|entry| *entry = -*entry);
}

/// The entries of part number `part`, a covector of the time alone.
pub(crate) fn covector<H: Elements, S: Scalar>(
    (system, parameters): (&H, &[S::Constant]),
    part: usize,
    t: S::Constant,
    into: &mut [S],
) {
    // Nothing reads coordinates or momenta.
    let zeros = vec![nothing(); into.len()];
    let at = EvaluationPoint::new([&*zeros, &*zeros], t, parameters, &[]);
    into.fill(S::from_f64(0.0));
    slopes(system, (part, 1.0), &at, Partials::BY_COORDINATES, into, &mut [], &mut PairColumns::default());
    // A covector `f` has the derivatives `-f`.
    into.iter_mut().for_each(|entry| *entry = -*entry);
}

/// `Γ` by rows, the matrix of part number `part`, a covector that is linear in the momenta.
pub(crate) fn damping<H: Elements, S: Scalar>(
    (system, parameters): (&H, &[S::Constant]),
    part: usize,
    q: &[S],
    into: &mut [S],
) {
    let degrees = q.len();
    if into.len() != degrees * degrees {
        return into.fill(S::from_f64(f64::NAN));
    }
    into.fill(S::from_f64(0.0));
    // The momenta do not matter.
    let at = EvaluationPoint::new([q, q], Scalar::from_f64(0.0), parameters, &[]);
    let mut add = |by, [i, j]: [usize; 2], _: bool, value| {
        // A covector `f` has the derivatives of `-f`.
        if by == HessianBlock::QP {
            into[i * degrees + j] = into[i * degrees + j] - value;
        }
    };
    system.hessian(part, 1.0, &at, Partials::BY_COORDINATES, &mut add);
}
