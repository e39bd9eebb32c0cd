//! Friction of any sum of elements, for thermostats.

use super::{Curvature, Elements, Point, Slopes, slopes};
use crate::algebra::scalar::Scalar;

/// The friction rates, from the slopes of part number `part`, a covector.
pub(crate) fn rates<H: Elements, S: Scalar>(
    system: (&H, &[S::Constant]),
    part: usize,
    q: &[S],
    into: &mut [S],
) {
    if into.len() != q.len() {
        return into.fill(S::from_f64(f64::NAN));
    }
    let (system, parameters) = system;
    let at = Point::new([q, q], Scalar::from_f64(0.0), parameters, &[]);
    into.fill(S::from_f64(0.0));
    slopes(system, part, 1.0, &at, Slopes::BY_COORDINATES, into, &mut []);
    // A covector `f` has the slopes `-f`.
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
    let at = Point::new([q, q], Scalar::from_f64(0.0), parameters, &[]);
    system.curvature(part, 1.0, &at, Slopes::BY_COORDINATES, &mut Rows { degrees, into });
}

/// The matrix of a covector `f` that is linear in the momenta; its second derivatives are those of `-f`.
struct Rows<'a, S> {
    degrees: usize,
    into: &'a mut [S],
}

impl<S: Scalar> Curvature<S> for Rows<'_, S> {
    fn add_qq(&mut self, _: usize, _: usize, _: bool, _: S) {}
    fn add_qp(&mut self, _: usize, _: usize, _: bool, _: S) {}
    fn add_pp(&mut self, _: usize, _: usize, _: bool, _: S) {}
    fn add_force_by_q(&mut self, _: usize, _: usize, _: S) {}
    fn add_force_by_p(&mut self, i: usize, j: usize, value: S) {
        let entry = &mut self.into[i * self.degrees + j];
        *entry = *entry - value;
    }
}
