//! Jacobians with terms of rank one, one for each collective variable at each stage.
//!
//! ```text
//! J = B + U Vᵀ,   J⁻¹ = B⁻¹ - W (1 + Vᵀ W)⁻¹ Vᵀ B⁻¹,   W = B⁻¹ U
//! ```
//!
//! (Sherman, Morrison and Woodbury; G. H. Golub, C. F. Van Loan, *Matrix Computations*, section 2.1.4.) `B`
//! has the entries of sites alone, so that a band remains one, and `k` variables cost `k` more solutions with
//! its factors. Krylov's method needs products alone, and takes the factors of `B` as its preconditioner.

use std::ops::Mul;

use super::collective::CollectiveHessian;
use super::memory::StepLists;
use super::step::LoopStep;
use super::{Elements, Quadrature, Unknowns, WeightedRole};
use crate::algebra::scalar::Scalar;
use crate::algebra::solve::Banded;
use crate::error::StepFailure;

/// `U` and `V`, one row for each term.
#[derive(Clone, Debug, Default)]
pub(super) struct RankOneTerms<S> {
    unknowns: usize,
    u: Vec<S>,
    v: Vec<S>,
    of_role: CollectiveHessian<S>,
}

impl<S: Scalar> RankOneTerms<S> {
    /// Room for the terms in the Jacobian of a scheme, and for those of each role.
    pub(super) fn new<H: Elements>(scheme: &Quadrature, degrees: usize) -> Self {
        let unknowns = scheme.unknowns.count(degrees);
        let zeros = vec![S::from_f64(0.0); count_terms::<H>(scheme) * unknowns];
        let mut of_role = CollectiveHessian::default();
        if !zeros.is_empty() {
            H::FACTS.collective_variables.iter().for_each(|variables| of_role.begin(degrees, variables));
        }
        Self { unknowns, u: zeros.clone(), v: zeros, of_role }
    }

    /// The number of terms.
    pub(super) fn count(&self) -> usize {
        self.rows(&self.u).len()
    }

    fn rows<'a>(&'a self, list: &'a [S]) -> impl ExactSizeIterator<Item = &'a [S]> {
        list.chunks_exact(self.unknowns.max(1))
    }

    /// `y += U Vᵀ x`
    pub(super) fn multiply(&self, x: &[S], y: &mut [S]) {
        for (u, v) in self.rows(&self.u).zip(self.rows(&self.v)) {
            add_multiple(y, u, dot(v, x));
        }
    }

    /// `y = Vᵀ x`
    fn multiply_transposed<T: Scalar + Mul<S, Output = T>>(&self, x: &[T], y: &mut [T]) {
        y.iter_mut().zip(self.rows(&self.v)).for_each(|(y, v)| *y = dot(v, x));
    }

    /// `y -= U x`
    fn subtract<T: Scalar + Mul<S, Output = T>>(&self, x: &[T], y: &mut [T]) {
        x.iter().zip(self.rows(&self.u)).for_each(|(&x, u)| add_multiple(y, u, -x));
    }

    /// Removes the terms that are not finite; returns their number.
    pub(super) fn leave_out(&mut self) -> usize {
        let (size, mut left_out) = (self.unknowns.max(1), 0);
        for (u, v) in self.u.chunks_exact_mut(size).zip(self.v.chunks_exact_mut(size)) {
            if !u.iter().chain(&*v).all(|entry| entry.magnitude().is_finite()) {
                u.fill(S::from_f64(0.0));
                v.fill(S::from_f64(0.0));
                left_out += 1;
            }
        }
        left_out
    }
}

/// `v · x`
fn dot<S: Scalar + Copy, T: Scalar + Mul<S, Output = T>>(v: &[S], x: &[T]) -> T {
    x.iter().zip(v).fold(T::from_f64(0.0), |sum, (&x, &v)| sum + x * v)
}

/// `y += factor u`
fn add_multiple<S: Scalar, T: Scalar + Mul<S, Output = T>>(y: &mut [T], u: &[S], factor: T) {
    y.iter_mut().zip(u).for_each(|(y, &u)| *y = *y + factor * u);
}

/// A band with terms of rank one, and its factors.
#[derive(Clone, Debug)]
pub(super) struct Bordered<S> {
    pub(super) band: Banded<S>,
    /// `U`, then `W`, with `V`.
    pub(super) terms: RankOneTerms<S>,
    /// `1 + Vᵀ W`
    small: Banded<S>,
    /// `Vᵀ B⁻¹ b`
    dots: Vec<S>,
}

/// Scratch for a solution in numbers with derivatives, allocated by its first use.
#[derive(Debug, Default)]
pub(super) struct SubstitutionScratch<T> {
    pub(super) solved: Vec<T>,
    dots: Vec<T>,
}

impl<S: Scalar> Bordered<S> {
    /// A band with terms, at least one.
    pub(super) fn new(band: Banded<S>, terms: RankOneTerms<S>) -> Self {
        let count = terms.count();
        Self { band, terms, small: Banded::dense(count), dots: vec![S::from_f64(0.0); count] }
    }

    /// Factors the band and then the small matrix.
    ///
    /// # Errors
    /// As [`Banded::factor`] of either.
    pub(super) fn factor(&mut self) -> Result<(), StepFailure> {
        let Self { band, terms, small, .. } = self;
        band.factor()?;
        let size = terms.unknowns.max(1);
        terms.u.chunks_exact_mut(size).for_each(|u| band.solve(u));
        small.reset();
        for (row, v) in terms.rows(&terms.v).enumerate() {
            for (column, w) in terms.rows(&terms.u).enumerate() {
                small.add(row, column, dot(v, w));
            }
        }
        small.factor()
    }

    /// `b` becomes `J⁻¹ b`.
    pub(super) fn solve(&mut self, b: &mut [S]) {
        let Self { band, terms, small, dots } = self;
        band.solve(b);
        terms.multiply_transposed(b, dots);
        small.solve(dots);
        terms.subtract(dots, b);
    }

    /// [`Bordered::solve`] for numbers with derivatives.
    pub(super) fn solve_in_room<T: Scalar + Mul<S, Output = T>>(
        &self,
        b: &mut [T],
        scratch: &mut SubstitutionScratch<T>,
    ) {
        let SubstitutionScratch { solved, dots } = scratch;
        self.band.solve_in_room(b, solved);
        dots.resize(self.terms.count(), T::from_f64(0.0));
        self.terms.multiply_transposed(b, dots);
        self.small.solve_in_room(dots, solved);
        self.terms.subtract(dots, b);
    }

    /// Whether the determinant is known to be negative: the blocks of the band are not uncoupled here.
    pub(super) fn is_reversed(&self) -> bool {
        let of_band =
            (0..self.terms.unknowns).fold(false, |known, unknown| known ^ self.band.reverses(unknown));
        of_band ^ self.small.is_reversed()
    }
}

impl<H: Elements, S: Scalar> LoopStep<'_, H, S> {
    /// The terms of rank one of the Jacobian at the current stages: the rows of `u` are those of the
    /// equations, the columns of `v` those of the unknowns.
    pub(super) fn rank_one_terms(
        &self,
        lists: &StepLists<'_, S>,
        diagonal: &[S],
        into: &mut RankOneTerms<S>,
    ) {
        let StepLists { stages, momentum, .. } = lists;
        let RankOneTerms { unknowns, u, v, of_role: terms } = into;
        let degrees = self.degrees();
        let size = (*unknowns).max(1);
        let mut rows = u.chunks_exact_mut(size).zip(v.chunks_exact_mut(size));
        for (s, stage) in self.scheme.stages.iter().enumerate() {
            let (q, p): (&[S], &[S]) = (stages.at(s).0, momentum);
            let at = self.at(stage, q, p);
            let (point, start) = (stage.point, stage.start);
            for &WeightedRole { role, weight } in stage.roles {
                let Some(variables) = H::FACTS.collective_variables_of(role) else { continue };
                terms.begin(degrees, variables);
                self.system.collective_hessian(role, weight, &at, terms);
                for ([[a_q, a_p], [b_q, b_p]], (u, v)) in terms.terms().zip(&mut rows) {
                    // All four lists, and the diagonal, have an entry for each degree of freedom.
                    if self.scheme.unknowns == Unknowns::Both {
                        let pairs = u.as_chunks_mut().0.iter_mut().zip(v.as_chunks_mut().0);
                        for (i, (u, v)) in pairs.enumerate() {
                            *u = [-b_p[i], b_q[i] * start];
                            *v = [a_q[i] * point, a_p[i]];
                        }
                    } else {
                        for (i, (u, v)) in u.iter_mut().zip(v).enumerate() {
                            *u = b_q[i] * start;
                            *v = a_q[i] * diagonal[i] * point + a_p[i];
                        }
                    }
                }
            }
        }
    }
}

/// The number of terms of rank one in the Jacobian of a scheme.
fn count_terms<H: Elements>(scheme: &Quadrature) -> usize {
    let roles = scheme.stages.iter().flat_map(|stage| stage.roles);
    let known = roles.filter_map(|weighted| H::FACTS.collective_variables_of(weighted.role));
    known.map(|known| known.read.len()).sum()
}
