//! Sweeps with the linear part of a stiff force split off.
//!
//! With `V = q · K q / 2 + U(q, t)` and constant `K`, sweeps contract like `h² ρ(A²) |U''|` if the linear
//! force is solved implicitly:
//!
//! ```text
//! Q ← Q + (1 + h² A² ⊗ M⁻¹K)⁻¹ (φ(Q) - Q)
//! ```
//!
//! In the eigenvectors of `M⁻¹K`, which are those of the symmetric `Lᵀ K L` with `M⁻¹ = L Lᵀ`, that is one
//! matrix over the stages for each eigenvalue, computed once per step size.

use nalgebra::{DMatrix, SymmetricEigen};

use super::Field;
use super::stages::Stages;
use super::tableau::Tableau;
use crate::algebra::scalar::{ConstantsIn, Scalar};
use crate::algebra::stages::{minus, plus};
use crate::scheme::elements::PairColumns;

/// Sweeps with a smaller contraction factor remain as they are.
const FAST: f64 = 0.1;

/// The eigenvectors of `M⁻¹K`, and for each eigenvalue `λ` the matrix `(1 + h² λ A²)⁻¹` by columns.
#[derive(Clone, Debug)]
pub(super) struct StiffModes<const N: usize> {
    filters: Vec<[[f64; N]; N]>,
    /// The matrix with the eigenvectors as columns and its inverse, both row-major; `None` if degrees of
    /// freedom are not coupled.
    basis: Option<[Vec<f64>; 2]>,
}

/// The stages before a sweep, and their changes in the eigenbasis.
#[derive(Debug)]
pub(super) struct ModalStages<T> {
    before: Vec<T>,
    changes: Vec<T>,
}

impl<T> Default for ModalStages<T> {
    fn default() -> Self {
        Self { before: Vec::new(), changes: Vec::new() }
    }
}

impl<T: Copy> ModalStages<T> {
    pub(super) fn reserve(&mut self, degrees: usize) {
        self.before.reserve(degrees);
        self.changes.reserve(degrees);
    }

    /// Stores the stages before a sweep.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn remember(&mut self, stages: &[T]) {
        self.before.clear();
        self.before.extend_from_slice(stages);
    }

    /// The stages before the last sweep.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn before(&self) -> &[T] {
        &self.before
    }
}

/// The eigenvalues of `M⁻¹K` and its eigenvectors: what modes have in common at any step size.
#[derive(Clone, Debug)]
pub(super) struct StiffSpectrum {
    eigenvalues: Vec<f64>,
    basis: Option<[Vec<f64>; 2]>,
    /// The largest eigenvalue.
    stiffest: f64,
    /// `ρ(A²)`
    radius: f64,
}

impl StiffSpectrum {
    /// The spectrum of a system with a stiff force; `None` for others.
    pub(super) fn new<F: Field, const N: usize>(
        system: &F,
        parameters: &ConstantsIn<F::Parameters, f64>,
        table: &Tableau<N>,
    ) -> Option<Self> {
        let degrees = system.degrees();
        if !F::IS_STIFF || !F::IS_NYSTROM || degrees == 0 {
            return None;
        }
        let mut stiffness = vec![0.0; degrees * degrees];
        system.stiffness(&[], &mut stiffness);
        let stiffness = DMatrix::from_row_slice(degrees, degrees, &stiffness);
        Self::of(stiffness, inverse_mass(system, parameters, degrees), &square(table))
    }

    fn of(stiffness: DMatrix<f64>, inverse_mass: DMatrix<f64>, square: &DMatrix<f64>) -> Option<Self> {
        let degrees = stiffness.nrows();
        if !stiffness.iter().chain(inverse_mass.iter()).all(|number| number.is_finite()) {
            return None;
        }
        let off_diagonal = |matrix: &DMatrix<f64>| {
            (0..degrees).any(|i| (0..degrees).any(|j| i != j && matrix[(i, j)] != 0.0))
        };
        let is_coupled = off_diagonal(&stiffness) || off_diagonal(&inverse_mass);
        let (eigenvalues, basis) = if is_coupled {
            let factor = inverse_mass.cholesky()?.unpack();
            let eigen = SymmetricEigen::new(product(&product(&factor.transpose(), &stiffness), &factor));
            let vectors = product(&factor, &eigen.eigenvectors);
            let inverse = vectors.clone().try_inverse()?;
            let rows = |matrix: DMatrix<f64>| matrix.transpose().as_slice().to_vec();
            (eigen.eigenvalues.as_slice().to_vec(), Some([rows(vectors), rows(inverse)]))
        } else {
            ((0..degrees).map(|d| stiffness[(d, d)] * inverse_mass[(d, d)]).collect(), None)
        };
        let stiffest = eigenvalues.iter().copied().fold(0.0, f64::max);
        Some(Self { eigenvalues, basis, stiffest, radius: spectral_radius(square) })
    }

    /// The modes of steps of this size; `None` if they do not pay.
    pub(super) fn modes<const N: usize>(&self, table: &Tableau<N>, h: f64) -> Option<StiffModes<N>> {
        let Self { eigenvalues, basis, stiffest, radius } = self;
        if h * h * stiffest * radius < FAST {
            return None;
        }
        let square = square(table);
        let filter = |eigenvalue: &f64| -> Option<[[f64; N]; N]> {
            // Unstable modes are not stiff.
            let matrix = DMatrix::identity(N, N) + &square * (h * h * eigenvalue.max(0.0));
            let inverse = matrix.try_inverse()?;
            Some(std::array::from_fn(|j| std::array::from_fn(|i| inverse[(i, j)])))
        };
        Some(StiffModes {
            filters: eigenvalues.iter().map(filter).collect::<Option<_>>()?,
            basis: basis.clone(),
        })
    }
}

/// `A²`
fn square<const N: usize>(table: &Tableau<N>) -> DMatrix<f64> {
    DMatrix::from_fn(N, N, |i, j| table.eta[j][i] * table.b[j])
}

impl<const N: usize> StiffModes<N> {
    /// Replaces the change by a sweep by that with the linear force solved implicitly.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn filter<S: Scalar>(
        &self,
        stages: &mut [S::Stages<N>],
        modal: &mut ModalStages<S::Stages<N>>,
    ) {
        let ModalStages { before, changes } = modal;
        let Self { filters, basis } = self;
        let degrees = stages.len();
        let zero = S::Stages::<N>::splat(S::from_f64(0.0));
        changes.clear();
        match basis {
            None => {
                let moved =
                    stages.iter().zip(&*before).map(|(after, before)| minus::<_, S, N>(*after, *before));
                changes.extend(moved.zip(filters).map(|(change, filter)| change.products(filter)));
                for ((stages, before), change) in stages.iter_mut().zip(&*before).zip(&*changes) {
                    *stages = plus::<_, S, N>(*before, *change);
                }
            }
            Some([vectors, inverse]) => {
                for (row, filter) in inverse.chunks_exact(degrees).zip(filters) {
                    let moved =
                        stages.iter().zip(&*before).map(|(after, before)| minus::<_, S, N>(*after, *before));
                    let mode = row
                        .iter()
                        .zip(moved)
                        .fold(zero, |sum, (entry, change)| plus::<_, S, N>(sum, change.times(&[*entry; N])));
                    changes.push(mode.products(filter));
                }
                for ((stages, before), row) in
                    stages.iter_mut().zip(&*before).zip(vectors.chunks_exact(degrees))
                {
                    *stages = row
                        .iter()
                        .zip(&*changes)
                        .fold(*before, |sum, (entry, mode)| plus::<_, S, N>(sum, mode.times(&[*entry; N])));
                }
            }
        }
    }
}

/// `M⁻¹`: the derivatives of the kinetic energy at the unit momenta.
pub(super) fn inverse_mass<F: Field>(
    system: &F,
    parameters: &ConstantsIn<F::Parameters, f64>,
    degrees: usize,
) -> DMatrix<f64> {
    let (q, dw) = (vec![0.0; degrees], vec![0.0; system.noises()]);
    let [mut p, mut by_q, mut by_p] = [q.clone(), q.clone(), q.clone()];
    let mut matrix = DMatrix::zeros(degrees, degrees);
    for column in 0..degrees {
        p.fill(0.0);
        p[column] = 1.0;
        let (at, into) = (([0.0, 1.0], [&q[..], &p], &dw[..]), [&mut by_q[..], &mut by_p]);
        system.step_gradient::<f64, f64, false, true>(parameters, at, into, &mut PairColumns::default());
        (0..degrees).for_each(|row| matrix[(row, column)] = by_p[row]);
    }
    matrix
}

/// `a b`, summed in one order on every machine: nalgebra's product of large matrices is fused where the
/// machine can do that.
fn product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(a.nrows(), b.ncols(), |i, j| (0..a.ncols()).map(|k| a[(i, k)] * b[(k, j)]).sum())
}

/// `|B^4096|^(1/4096)`, by squaring: the spectral radius up to a factor of at most `κ^(1/4096)`, `κ` the
/// condition of the eigenvectors of `B`.
fn spectral_radius(matrix: &DMatrix<f64>) -> f64 {
    let (mut power, mut logarithm) = (matrix.clone(), 0.0);
    for doubling in 0..=12 {
        let norm = power.norm();
        if norm == 0.0 {
            return 0.0;
        }
        power /= norm;
        logarithm += Scalar::ln(norm) / f64::from(1 << doubling);
        power = product(&power, &power);
    }
    Scalar::exp(logarithm)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `ρ(A²)` for 2, 4, 8 and 16 stages.
    #[test]
    fn spectral_radii_are_those_of_the_methods() {
        fn check<const N: usize>(exact: f64) {
            let table = Tableau::<N>::get();
            let radius = spectral_radius(&square(&table));
            // The condition of the eigenvectors is at most 2.9e8 (16 stages), and 2.9e8^(1/4096) = 1.0048.
            assert!((radius / exact - 1.0).abs() < 0.005, "{N}: {radius}");
        }
        check::<2>(0.083_333_3);
        check::<4>(0.027_351_9);
        check::<8>(0.007_818_1);
        check::<16>(0.002_086_4);
    }
}
