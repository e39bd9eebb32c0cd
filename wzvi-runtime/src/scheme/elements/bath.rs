//! Friction of any sum of elements, for thermostats.

use super::step::nothing;
use super::{Elements, EvaluationPoint, HessianBlock, PairColumns, Partials, Role, slopes};
use crate::algebra::scalar::Scalar;

/// The friction rates, from the derivatives of a covector.
pub(crate) fn rates<H: Elements, S: Scalar>(
    system: (&H, &[S::Constant]),
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
    slopes(system, Role::Friction.times(1.0), &at, Partials::BY_COORDINATES, into, &mut [], columns);
    // A covector `f` has the derivatives `-f`.
    into.iter_mut().for_each(|entry| *entry = -*entry);
}

/// The temperatures by degree of freedom, a covector of the time alone.
pub(crate) fn temperatures<H: Elements, S: Scalar>(
    system: &H,
    parameters: &[S::Constant],
    t: S::Constant,
    into: &mut [S],
) {
    // Nothing reads coordinates or momenta.
    let zeros = vec![nothing(); into.len()];
    let at = EvaluationPoint::new([&*zeros, &*zeros], t, parameters, &[]);
    into.fill(S::from_f64(0.0));
    let columns = &mut PairColumns::default();
    slopes(system, Role::Temperature.times(1.0), &at, Partials::BY_COORDINATES, into, &mut [], columns);
    // A covector `f` has the derivatives `-f`.
    into.iter_mut().for_each(|entry| *entry = -*entry);
}

/// `Γ` by rows, from the friction, a covector that is linear in the momenta.
pub(crate) fn damping<H: Elements, S: Scalar>(
    (system, parameters): (&H, &[S::Constant]),
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
    system.hessian(Role::Friction, 1.0, &at, Partials::BY_COORDINATES, &mut add);
}
