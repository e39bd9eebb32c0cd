//! Small symmetric matrices of numbers of any type, row-major, without allocation.

use crate::algebra::scalar::{Mask as _, Scalar};
use crate::algebra::solve::relative_to;

/// The most sweeps of rotations, more than enough: convergence is quadratic from the third on.
const MOST_SWEEPS: usize = 30;

/// The rotation that makes the entry `between` of a symmetric matrix zero, as cosine and sine: the smaller of
/// the two angles.
#[cfg_attr(not(debug_assertions), inline(always))]
fn rotation<S: Scalar>(first: S, between: S, second: S) -> (S, S) {
    let (zero, one) = (S::from_f64(0.0), S::from_f64(1.0));
    let ratio = (second - first) / (between * 2.0);
    let sign = S::select(ratio.less(zero), -one, one);
    let tangent = sign / (ratio.abs() + ratio.hypot(one));
    let tangent = S::select(between.vanishes(), zero, tangent);
    let cosine = tangent.hypot(one).recip();
    (cosine, tangent * cosine)
}

/// Rotates the columns `j` and `k` of a matrix.
#[cfg_attr(not(debug_assertions), inline(always))]
fn turn_columns<S: Scalar>(matrix: &mut [S], d: usize, [j, k]: [usize; 2], (cosine, sine): (S, S)) {
    for row in matrix.chunks_exact_mut(d) {
        let (x, y) = (row[j], row[k]);
        row[j] = cosine * x - sine * y;
        row[k] = sine * x + cosine * y;
    }
}

/// `A = V Λ Vᵀ` by cyclic rotations (C. G. J. Jacobi; G. H. Golub, C. F. Van Loan, *Matrix Computations*,
/// section 8.5): `a` becomes diagonal, `v` gets the eigenvectors as columns. Zero rows of `a` remain exactly
/// zero, with a unit vector as eigenvector.
pub(super) fn diagonalise<S: Scalar>(a: &mut [S], v: &mut [S], d: usize) {
    let (zero, one) = (S::from_f64(0.0), S::from_f64(1.0));
    v.fill(zero);
    v.iter_mut().step_by(d + 1).for_each(|entry| *entry = one);
    for _ in 0..MOST_SWEEPS {
        let mut largest = zero;
        let mut beside = zero;
        for (i, row) in a.chunks_exact(d).enumerate() {
            for (j, &entry) in row.iter().enumerate() {
                largest = largest.larger(entry);
                if j > i {
                    beside = beside.larger(entry);
                }
            }
        }
        // The remaining off-diagonal part changes no digit of an eigenvalue or eigenvector.
        if relative_to(beside, largest) <= f64::EPSILON * f64::EPSILON {
            break;
        }
        for j in 0..d {
            for k in j + 1..d {
                let turn = rotation(a[j * d + j], a[j * d + k], a[k * d + k]);
                turn_columns(a, d, [j, k], turn);
                let (cosine, sine) = turn;
                for column in 0..d {
                    let (x, y) = (a[j * d + column], a[k * d + column]);
                    a[j * d + column] = cosine * x - sine * y;
                    a[k * d + column] = sine * x + cosine * y;
                }
                // Set exactly, so that rounding causes no further rotation.
                (a[j * d + k], a[k * d + j]) = (zero, zero);
                turn_columns(v, d, [j, k], turn);
            }
        }
    }
}

/// The lower triangular `R` with a diagonal that is not negative and `R Rᵀ = G Gᵀ`, in place of `G`: the
/// Cholesky factor without forming the product, accurate even where the product is singular.
pub(super) fn triangularise<S: Scalar>(g: &mut [S], d: usize) {
    let (zero, one) = (S::from_f64(0.0), S::from_f64(1.0));
    for i in 0..d {
        for j in i + 1..d {
            let (x, y) = (g[i * d + i], g[i * d + j]);
            let length = x.hypot(y);
            let is_zero = length.vanishes();
            let cosine = S::select(is_zero, one, x / length);
            let sine = S::select(is_zero, zero, -(y / length));
            turn_columns(g, d, [i, j], (cosine, sine));
            g[i * d + j] = zero;
        }
        let sign = S::select(g[i * d + i].less(zero), -one, one);
        for row in i..d {
            g[row * d + i] = g[row * d + i] * sign;
        }
    }
}

/// The lower triangular `C` with `A = C Cᵀ`, in place of `A`; `false` unless `A` is positive definite.
/// Entries above the diagonal become zero.
pub(super) fn cholesky<S: Scalar>(a: &mut [S], d: usize) -> bool {
    let zero = S::from_f64(0.0);
    for j in 0..d {
        for i in j..d {
            let known = (0..j).fold(zero, |sum, k| sum + a[i * d + k] * a[j * d + k]);
            let left = a[i * d + j] - known;
            if i == j {
                if !zero.less(left).all() {
                    return false;
                }
                a[j * d + j] = left.sqrt();
            } else {
                a[i * d + j] = left / a[j * d + j];
            }
        }
        a[j * d + j + 1..(j + 1) * d].fill(zero);
    }
    true
}

/// `C⁻ᵀ` of a lower triangular `C`.
pub(super) fn inverse_transposed<S: Scalar>(c: &[S], d: usize) -> Vec<S> {
    let zero = S::from_f64(0.0);
    let mut inverse = vec![zero; d * d];
    // Row `i` of the result is column `i` of `C⁻¹`.
    for i in 0..d {
        for j in i..d {
            let known = (i..j).fold(zero, |sum, k| sum + c[j * d + k] * inverse[i * d + k]);
            let unit = S::from_f64(if i == j { 1.0 } else { 0.0 });
            inverse[i * d + j] = (unit - known) / c[j * d + j];
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `A Bᵀ`
    fn product(a: &[f64], b: &[f64], d: usize) -> Vec<f64> {
        let entry = |i: usize, j: usize| (0..d).map(|k| a[i * d + k] * b[j * d + k]).sum();
        (0..d * d).map(|at| entry(at / d, at % d)).collect()
    }

    fn close(a: &[f64], b: &[f64], bound: f64) {
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() <= bound, "{a} {b}");
        }
    }

    const A: [f64; 9] = [4.0, 1.0, -2.0, 1.0, 3.0, 0.5, -2.0, 0.5, 2.0];

    #[test]
    fn a_matrix_is_what_it_is_made_of() {
        let (mut a, mut v) = (A, [0.0; 9]);
        diagonalise(&mut a, &mut v, 3);
        let scaled: Vec<f64> = (0..9).map(|at| v[at] * a[(at % 3) * 4]).collect();
        // A dozen roundings of entries below 4.
        close(&product(&scaled, &v, 3), &A, 12.0 * 4.0 * f64::EPSILON);
        close(&product(&v, &v, 3), &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], 12.0 * f64::EPSILON);
    }

    #[test]
    fn what_is_not_coupled_is_not_touched() {
        let (mut a, mut v) = ([2.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 2.0], [0.0; 9]);
        diagonalise(&mut a, &mut v, 3);
        assert_eq!([v[1], v[3], v[4], v[5], v[7], a[4]], [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn the_triangular_factor_is_that_of_cholesky() {
        let mut c = A;
        assert!(cholesky(&mut c, 3));
        close(&product(&c, &c, 3), &A, 12.0 * 4.0 * f64::EPSILON);
        // Any rotation of the columns, here by the eigenvectors, has the same triangular factor.
        let (mut a, mut g) = (A, [0.0; 9]);
        diagonalise(&mut a, &mut g, 3);
        for (at, entry) in g.iter_mut().enumerate() {
            *entry *= a[(at % 3) * 4].sqrt();
        }
        triangularise(&mut g, 3);
        close(&g, &c, 50.0 * f64::EPSILON);
        let unit = product(&inverse_transposed(&c, 3), &c, 3);
        close(&unit, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], 50.0 * f64::EPSILON);
        assert!(!cholesky(&mut [1.0, 2.0, 2.0, 1.0], 2));
    }

    #[test]
    fn singular_products_have_a_factor_too() {
        let mut g = [1.0, 2.0, 0.0, 2.0, 4.0, 0.0, 0.0, 0.0, 0.0];
        let product_before = product(&g, &g, 3);
        triangularise(&mut g, 3);
        close(&product(&g, &g, 3), &product_before, 20.0 * 20.0 * f64::EPSILON);
        assert_eq!([g[1], g[2], g[5]], [0.0; 3]);
    }
}
