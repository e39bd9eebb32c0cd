//! Friction of any sum of elements, for thermostats.

use super::{Elements, Point, Slopes, slopes};
use crate::scalar::Scalar;

/// The rates of friction: part number `part`, whose slopes are those of a covector.
pub fn rates<H: Elements, S: Scalar>(system: &H, part: usize, q: &[S], into: &mut [S]) {
    if into.len() != q.len() {
        return into.fill(S::from_f64(f64::NAN));
    }
    along(system, part, [q, q], into);
}

/// `Γ` by rows: those of part number `part` with each unit momentum.
pub fn damping<H: Elements, S: Scalar>(system: &H, part: usize, q: &[S], into: &mut [S]) {
    let degrees = q.len();
    if into.len() != degrees * degrees {
        return into.fill(S::from_f64(f64::NAN));
    }
    let (mut p, mut column) = (vec![S::from_f64(0.0); degrees], vec![S::from_f64(0.0); degrees]);
    for j in 0..degrees {
        p.fill(S::from_f64(0.0));
        p[j] = S::from_f64(1.0);
        along(system, part, [q, &p], &mut column);
        for (i, &entry) in column.iter().enumerate() {
            into[i * degrees + j] = entry;
        }
    }
}

fn along<H: Elements, S: Scalar>(system: &H, part: usize, [q, p]: [&[S]; 2], into: &mut [S]) {
    let at = Point { q, p, t: 0.0, h: 1.0, dw: &[], acting: 0..0, scale: 1.0 };
    into.fill(S::from_f64(0.0));
    slopes(system, part, 1.0, &at, Slopes::BY_COORDINATES, into, &mut []);
    // Slopes of a covector `f` are those of `-f`.
    into.iter_mut().for_each(|entry| *entry = -*entry);
}
