//! Friction and masses of any sum of elements, for thermostats.

use super::{Elements, Point, Slopes};
use crate::scalar::Scalar;
use crate::system::Hamiltonian;

/// `M⁻¹`, which velocities are in terms of momenta and nothing else: its diagonal, or its rows. NaN for a list that does not fit.
pub fn inverse_mass<H: Hamiltonian, const IS_DIAGONAL: bool>(system: &H, into: &mut [f64]) {
    let degrees = if IS_DIAGONAL { into.len() } else { into.len().isqrt() };
    let zeros = vec![0.0; degrees];
    let (mut p, mut by_q, mut velocity) = (zeros.clone(), zeros.clone(), zeros.clone());
    if IS_DIAGONAL {
        p.fill(1.0);
        system.differentiate(0, &zeros, &p, 0.0, &mut by_q, into);
        return;
    }
    for column in 0..degrees {
        p.fill(0.0);
        p[column] = 1.0;
        system.differentiate(0, &zeros, &p, 0.0, &mut by_q, &mut velocity);
        for (row, &v) in velocity.iter().enumerate() {
            into[row * degrees + column] = v;
        }
    }
}

/// `Γ = γ M` on the diagonal, from the rates of part number `part`, where masses are diagonal.
pub fn damping<H: Elements, S: Scalar>(system: &H, part: usize, q: &[S], gamma: &mut [S]) {
    let ones = vec![S::from_f64(1.0); gamma.len()];
    along(system, part, [q, &ones], gamma);
    let mut inverse = vec![0.0; gamma.len()];
    inverse_mass::<H, true>(system, &mut inverse);
    gamma.iter_mut().zip(inverse).for_each(|(gamma, inverse)| *gamma = *gamma / S::from_f64(inverse));
}

/// `Γ` by rows, from part number `part`.
pub fn damping_matrix<H: Elements, S: Scalar>(system: &H, part: usize, gamma: &mut [S]) {
    let degrees = gamma.len().isqrt();
    let zeros = vec![S::from_f64(0.0); degrees];
    let (mut p, mut column) = (zeros.clone(), zeros.clone());
    for j in 0..degrees {
        p.fill(S::from_f64(0.0));
        p[j] = S::from_f64(1.0);
        along(system, part, [&zeros, &p], &mut column);
        for (i, &entry) in column.iter().enumerate() {
            gamma[i * degrees + j] = entry;
        }
    }
}

/// `Γ = γ M` by rows, from the one rate of part number `part`.
pub fn damping_by_masses<H: Elements, S: Scalar>(system: &H, part: usize, gamma: &mut [S]) {
    let degrees = gamma.len().isqrt();
    let (zeros, ones) = (vec![S::from_f64(0.0); degrees], vec![S::from_f64(1.0); degrees]);
    let mut rates = zeros.clone();
    along(system, part, [&zeros, &ones], &mut rates);
    let rate = rates.first().copied().unwrap_or(S::from_f64(f64::NAN));
    rate_times_masses(system, rate, gamma);
}

/// `γ M` by rows; NaN where `M⁻¹` is singular.
pub fn rate_times_masses<H: Hamiltonian, S: Scalar>(system: &H, rate: S, gamma: &mut [S]) {
    let degrees = gamma.len().isqrt();
    let mut inverse = vec![0.0; degrees * degrees];
    inverse_mass::<H, false>(system, &mut inverse);
    let masses = nalgebra::DMatrix::from_row_slice(degrees, degrees, &inverse).try_inverse();
    for (at, entry) in gamma.iter_mut().enumerate() {
        let mass = masses.as_ref().map_or(f64::NAN, |masses| {
            // Symmetric to the last bit.
            let (i, j) = (at / degrees, at % degrees);
            0.5 * (masses[(i, j)] + masses[(j, i)])
        });
        *entry = rate * mass;
    }
}

/// What part number `part` is in the direction of the momenta `p`.
fn along<H: Elements, S: Scalar>(system: &H, part: usize, [q, p]: [&[S]; 2], into: &mut [S]) {
    let at = Point { q, p, t: 0.0, h: 1.0, dw: &[], acting: 0..0, scale: 1.0 };
    into.fill(S::from_f64(0.0));
    system.slopes(part, 1.0, &at, Slopes::BY_COORDINATES, into, &mut []);
    // As those of a covector `f` these are those of `-f`.
    into.iter_mut().for_each(|entry| *entry = -*entry);
}
