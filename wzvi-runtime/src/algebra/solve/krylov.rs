//! GMRES: solves linear equations by products with their matrix.
//!
//! Y. Saad, M. H. Schultz, "GMRES: a generalized minimal residual algorithm for solving nonsymmetric linear
//! systems", SIAM J. Sci. Stat. Comput. 7, 1986; restarted, with a preconditioner from the right, so that the
//! residual that it watches is the true one.

use crate::algebra::scalar::{Scalar, larger};
use crate::error::StepFailure;

/// Vectors of the basis before a restart.
const BASIS: usize = 32;
/// Restarts before GMRES gives up.
const MOST_CYCLES: u32 = 32;
/// A cycle that reduces the residual to no less than this fraction is the last.
const PROGRESS: f64 = 0.95;
/// Images below this fraction of their terms are rounding.
const SINGULAR: f64 = 64.0 * f64::EPSILON;

/// Room for the basis, allocated once.
#[derive(Clone, Debug)]
pub struct Krylov<S> {
    n: usize,
    basis: Vec<S>,
    /// Columns of the triangular factor of the Hessenberg matrix.
    columns: Vec<[S; BASIS + 1]>,
    rotations: Vec<(S, S)>,
    /// The rotated right-hand side, then the coefficients of the solution.
    projection: [S; BASIS + 1],
    solution: Vec<S>,
    /// The preconditioner applied to a vector.
    conditioned: Vec<S>,
    image: Vec<S>,
}

/// A matrix and its preconditioner, by what they do with vectors.
#[expect(missing_debug_implementations, reason = "closures")]
pub struct Operator<'o, S> {
    /// `y = A x`
    pub product: &'o mut dyn FnMut(&[S], &mut [S]),
    /// `x` becomes an approximation of `A⁻¹ x`.
    pub precondition: &'o mut dyn FnMut(&mut [S]),
    /// The largest number of restarts.
    pub most_cycles: u32,
}

impl<S: Scalar> Krylov<S> {
    /// Vectors of the basis before a restart.
    pub const BASIS: usize = BASIS;
    /// Restarts before GMRES gives up.
    pub const MOST_CYCLES: u32 = MOST_CYCLES;

    /// Room for `n` unknowns.
    pub fn new(n: usize) -> Self {
        let zero = S::from_f64(0.0);
        let vector = || vec![zero; n];
        Self {
            n,
            basis: vec![zero; n * (BASIS + 1)],
            columns: vec![[zero; BASIS + 1]; BASIS],
            rotations: vec![(zero, zero); BASIS],
            projection: [zero; BASIS + 1],
            solution: vector(),
            conditioned: vector(),
            image: vector(),
        }
    }

    /// Replaces `b` by `A⁻¹ b` up to a residual of `tolerance` times its norm, and returns the number of
    /// products. On an error `b` is unchanged.
    ///
    /// # Errors
    /// [`StepFailure::NotConverged`] with the number of products and the relative residual that is left,
    /// [`StepFailure::NonFinite`].
    pub fn solve(
        &mut self,
        b: &mut [S],
        tolerance: f64,
        operator: &mut Operator<'_, S>,
    ) -> Result<u32, StepFailure> {
        self.solution.fill(S::from_f64(0.0));
        let largest = b.iter().fold(0.0, |most, b| larger(most, b.magnitude()));
        if largest == 0.0 {
            return Ok(0);
        }
        // Norms are sums of squares: exactly the same in any unit, they neither over- nor underflow in this
        // one.
        let unit = power_of_two(largest);
        b.iter_mut().for_each(|b| *b = *b / unit);
        let solved = self.solve_scaled(b, tolerance, operator);
        b.iter_mut().for_each(|x| *x = *x * unit);
        solved
    }

    /// [`Krylov::solve`] for a right-hand side of the size of 1.
    fn solve_scaled(
        &mut self,
        b: &mut [S],
        tolerance: f64,
        operator: &mut Operator<'_, S>,
    ) -> Result<u32, StepFailure> {
        let size = norm(b);
        let enough = tolerance * size.magnitude();
        let (mut residual, mut products) = (size, 0);
        self.basis[..self.n].copy_from_slice(b);
        for _ in 0..operator.most_cycles {
            if !residual.magnitude().is_finite() {
                return Err(StepFailure::NonFinite);
            }
            let dimension = self.cycle(residual, enough, operator);
            products += dimension as u32;
            self.combine(dimension, operator.precondition);
            // The residual of the recurrence is the true one but for rounding: where it is small enough, so
            // is that.
            if self.projection_residual(dimension) <= enough {
                b.copy_from_slice(&self.solution);
                return Ok(products);
            }
            (operator.product)(&self.solution, &mut self.image);
            products += 1;
            for ((r, &b), &image) in self.basis[..self.n].iter_mut().zip(&*b).zip(&self.image) {
                *r = b - image;
            }
            let left = norm(&self.basis[..self.n]);
            let is_stuck = left.magnitude() > PROGRESS * residual.magnitude();
            residual = left;
            if is_stuck {
                break;
            }
        }
        let correction = residual.magnitude() / size.magnitude();
        match correction.is_nan() {
            true => Err(StepFailure::NonFinite),
            false => Err(StepFailure::NotConverged { iterations: products, correction }),
        }
    }

    /// The basis from the residual in its first vector; its dimension at the end.
    fn cycle(&mut self, residual: S, enough: f64, operator: &mut Operator<'_, S>) -> usize {
        let n = self.n;
        let zero = S::from_f64(0.0);
        self.projection.fill(zero);
        self.projection[0] = residual;
        let inverse = residual.recip();
        self.basis[..n].iter_mut().for_each(|v| *v = *v * inverse);
        for k in 0..BASIS {
            let (known, next) = self.basis.split_at_mut((k + 1) * n);
            let next = &mut next[..n];
            let last = &known[k * n..];
            self.conditioned.copy_from_slice(last);
            (operator.precondition)(&mut self.conditioned);
            (operator.product)(&self.conditioned, next);
            let column = &mut self.columns[k];
            for (v, entry) in known.chunks_exact(n).zip(column.iter_mut()) {
                *entry = dot(v, next);
                for (w, &v) in next.iter_mut().zip(v) {
                    *w = *w - *entry * v;
                }
            }
            let rest = norm(next);
            let size = column[..=k].iter().fold(rest.magnitude(), |most, entry| most.max(entry.magnitude()));
            for (i, &(c, s)) in self.rotations[..k].iter().enumerate() {
                let (a, b) = (column[i], column[i + 1]);
                (column[i], column[i + 1]) = (c * a + s * b, c * b - s * a);
            }
            let radius = column[k].hypot(rest);
            // The matrix maps the basis to itself and is singular there.
            if radius.magnitude() <= SINGULAR * size {
                return k;
            }
            let (c, s) = (column[k] / radius, rest / radius);
            self.rotations[k] = (c, s);
            column[k] = radius;
            let before = self.projection[k];
            (self.projection[k], self.projection[k + 1]) = (c * before, -(s * before));
            let is_done = self.projection[k + 1].magnitude() <= enough || rest.magnitude() == 0.0;
            if is_done || !rest.magnitude().is_finite() {
                return k + 1;
            }
            let inverse = rest.recip();
            next.iter_mut().for_each(|w| *w = *w * inverse);
        }
        BASIS
    }

    fn projection_residual(&self, dimension: usize) -> f64 {
        self.projection[dimension].magnitude()
    }

    /// Adds the best combination of the first `dimension` vectors to the solution.
    fn combine(&mut self, dimension: usize, precondition: &mut dyn FnMut(&mut [S])) {
        let mut coefficients = self.projection;
        for i in (0..dimension).rev() {
            let mut value = coefficients[i];
            for (column, &known) in self.columns[..dimension].iter().zip(&coefficients).skip(i + 1) {
                value = value - column[i] * known;
            }
            coefficients[i] = value / self.columns[i][i];
        }
        self.conditioned.fill(S::from_f64(0.0));
        for (v, &coefficient) in self.basis.chunks_exact(self.n).zip(&coefficients[..dimension]) {
            for (sum, &v) in self.conditioned.iter_mut().zip(v) {
                *sum = *sum + coefficient * v;
            }
        }
        precondition(&mut self.conditioned);
        for (x, &step) in self.solution.iter_mut().zip(&self.conditioned) {
            *x = *x + step;
        }
    }
}

/// The largest power of two that is not above `size`, for normal numbers.
pub(crate) fn power_of_two(size: f64) -> f64 {
    f64::from_bits(size.to_bits() & f64::INFINITY.to_bits()).clamp(f64::MIN_POSITIVE, f64::MAX)
}

fn dot<S: Scalar>(a: &[S], b: &[S]) -> S {
    a.iter().zip(b).fold(S::from_f64(0.0), |sum, (&a, &b)| sum + a * b)
}

fn norm<S: Scalar>(a: &[S]) -> S {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The torus of `side²` sites: `(4 c + 1) x_i - c Σ neighbours`, with a slope that makes it unsymmetric.
    fn torus(side: usize, c: f64, slope: f64) -> impl Fn(&[f64], &mut [f64]) {
        move |x, y| {
            for i in 0..side {
                for j in 0..side {
                    let at = |i: usize, j: usize| x[(i % side) * side + j % side];
                    let sides = at(i + 1, j) + at(i + side - 1, j) + at(i, j + 1) + at(i, j + side - 1);
                    y[i * side + j] =
                        (4.0 * c + 1.0) * at(i, j) - c * sides + slope * (at(i + 1, j) - at(i, j + 1));
                }
            }
        }
    }

    /// The solution for a product, with the diagonal of its matrix.
    fn solve(
        x: &mut [f64],
        tolerance: f64,
        mut product: impl FnMut(&[f64], &mut [f64]),
        diagonal: f64,
    ) -> Result<u32, StepFailure> {
        let precondition = &mut |x: &mut [f64]| x.iter_mut().for_each(|x| *x /= diagonal);
        let operator = &mut Operator { product: &mut product, precondition, most_cycles: MOST_CYCLES };
        Krylov::new(x.len()).solve(x, tolerance, operator)
    }

    #[test]
    fn solutions_have_the_residual_that_was_asked_for() {
        for (c, slope, tolerance) in [(0.5, 0.0, 1e-3), (3.0, 0.2, 1e-10), (30.0, 1.0, 1e-6)] {
            let side = 20;
            let product = torus(side, c, slope);
            let b: Vec<f64> = (0..side * side).map(|k| (1.7 * k as f64).sin()).collect();
            let mut x = b.clone();
            solve(&mut x, tolerance, &product, 4.0 * c + 1.0).unwrap();
            let mut image = vec![0.0; side * side];
            product(&x, &mut image);
            let rest: Vec<f64> = image.iter().zip(&b).map(|(a, b)| a - b).collect();
            // The recurrence rounds: 1 % of the tolerance.
            assert!(norm(&rest) <= 1.01 * tolerance * norm(&b), "{c}: {}", norm(&rest) / norm(&b));
            assert!(norm(&rest) > 0.0);
        }
    }

    #[test]
    fn solutions_scale_with_the_right_hand_side() {
        let (side, c) = (12, 3.0);
        let scaled = |scale: f64| {
            let mut x: Vec<f64> = (0..side * side).map(|k| (1.7 * k as f64).sin() * scale).collect();
            solve(&mut x, 1e-10, torus(side, c, 0.2), 4.0 * c + 1.0).unwrap();
            x
        };
        let one = scaled(1.0);
        for exponent in [-1000, -500, 500, 1000] {
            let scale = 2.0_f64.powi(exponent);
            let expected: Vec<f64> = one.iter().map(|x| x * scale).collect();
            assert_eq!(scaled(scale), expected, "2^{exponent}");
        }
    }

    #[test]
    fn a_singular_matrix_is_given_up() {
        let projection = |x: &[f64], y: &mut [f64]| (y[0], y[1]) = (x[0], 0.0);
        let mut b = [1.0, 1.0];
        let outcome = solve(&mut b, 1e-10, projection, 1.0);
        assert!(matches!(outcome, Err(StepFailure::NotConverged { .. })), "{outcome:?}");
        assert_eq!(b, [1.0, 1.0]);
        let outcome = solve(&mut b, 1e-10, |_: &[f64], y: &mut [f64]| y.fill(f64::NAN), 1.0);
        assert_eq!(outcome, Err(StepFailure::NonFinite));
    }
}
