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
use super::memory::{StepLists, StepScratch};
use super::step::LoopStep;
use super::{Elements, Quadrature, Unknowns};
use crate::algebra::scalar::Scalar;
use crate::algebra::solve::Banded;
use crate::error::StepFailure;

/// `U` and `V`, one row for each term.
#[derive(Clone, Debug, Default)]
pub(super) struct RankOneTerms<S> {
    unknowns: usize,
    u: Vec<S>,
    v: Vec<S>,
    part: CollectiveHessian<S>,
}

impl<S: Scalar> RankOneTerms<S> {
    fn rows<'a>(&'a self, list: &'a [S]) -> impl Iterator<Item = &'a [S]> {
        list.chunks_exact(self.unknowns.max(1))
    }

    /// `y += U Vᵀ x`
    pub(super) fn multiply(&self, x: &[S], y: &mut [S]) {
        for (u, v) in self.rows(&self.u).zip(self.rows(&self.v)) {
            add_multiple(y, u, dot(v, x));
        }
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
    room: Vec<S>,
}

impl<S: Scalar> Bordered<S> {
    /// A band with so many terms, at least one.
    pub(super) fn new(band: Banded<S>, terms: usize) -> Self {
        let small = Banded::dense(terms);
        Self { band, terms: RankOneTerms::default(), small, room: Vec::new() }
    }

    /// The number of terms.
    pub(super) fn count(&self) -> usize {
        self.small.half_width() + 1
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
        let Self { band, terms, small, room } = self;
        band.solve(b);
        room.clear();
        room.extend(terms.rows(&terms.v).map(|v| dot(v, &*b)));
        small.solve(room);
        for (w, &dot) in terms.rows(&terms.u).zip(&*room) {
            add_multiple(b, w, -dot);
        }
    }

    /// [`Bordered::solve`] for numbers with derivatives.
    pub(super) fn solve_in_room<T: Scalar + Mul<S, Output = T>>(&self, b: &mut [T], x: &mut Vec<T>) {
        self.band.solve_in_room(b, x);
        let mut dots: Vec<T> = self.terms.rows(&self.terms.v).map(|v| dot(v, &*b)).collect();
        self.small.solve_in_room(&mut dots, x);
        for (w, &dot) in self.terms.rows(&self.terms.u).zip(&dots) {
            add_multiple(b, w, -dot);
        }
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
        let RankOneTerms { unknowns, u, v, part: terms } = into;
        let degrees = self.degrees();
        *unknowns = self.scheme.unknowns.count(degrees);
        u.clear();
        v.clear();
        for (s, stage) in self.scheme.stages.iter().enumerate() {
            let (q, p): (&[S], &[S]) = (stages.at(s).0, momentum);
            let at = self.at(stage, q, p);
            let (point, start) = (stage.point, stage.start);
            for &(part, weight) in stage.parts {
                terms.begin(0, 0);
                self.system.collective_hessian(part, weight, &at, terms);
                for [[a_q, a_p], [b_q, b_p]] in terms.terms() {
                    // All four lists, and the diagonal, have an entry for each degree of freedom.
                    if self.scheme.unknowns == Unknowns::Both {
                        for i in 0..degrees {
                            u.extend([-b_p[i], b_q[i] * start]);
                            v.extend([a_q[i] * point, a_p[i]]);
                        }
                    } else {
                        u.extend(b_q.iter().map(|&b| b * start));
                        v.extend((0..degrees).map(|j| a_q[j] * diagonal[j] * point + a_p[j]));
                    }
                }
            }
        }
    }
}

/// The number of terms of rank one in the Jacobian of a scheme.
pub(super) fn count_terms<H: Elements>(system: &H, scheme: &Quadrature, degrees: usize) -> usize {
    if !H::IS_COLLECTIVE || scheme.unknowns == Unknowns::None || degrees == 0 {
        return 0;
    }
    let (zeros, dw) = (vec![0.0; degrees], vec![0.0; system.noises()]);
    let (q, p, dw) = (&*zeros, &*zeros, &*dw);
    let step = LoopStep { system, scheme, t: 0.0, h: 1.0, parameters: &[], q, p, dw, increment: None };
    let (mut work, diagonal) =
        (StepScratch::new(scheme, degrees), vec![0.0; scheme.unknowns.diagonals(degrees)]);
    let mut terms = RankOneTerms::default();
    step.rank_one_terms(&work.lists(scheme, degrees), &diagonal, &mut terms);
    terms.u.len() / scheme.unknowns.count(degrees)
}
