//! The arrangement of the Jacobian `G` of constraints and of the matrix `G W Gᵀ`: as arrays, or by the graph
//! of constraints that share a coordinate.

use std::fmt::Debug;

use super::Constrained;
use crate::algebra::scalar::{Mask, Scalar};
use crate::algebra::shape::Shape;

/// A pivot of `G_1 W G_0ᵀ` below this fraction of the terms of its diagonal entry is none: rows of `G` are
/// dependent to half of the digits, or the step is longer than the radius of curvature.
const LEAST_PIVOT: f64 = 1e-8;

/// The arrangement of matrices of constraints.
///
/// Matrices are factored without exchanges: `G W Gᵀ` is symmetric and positive definite, and `G_1 W G_0ᵀ` is
/// near to it, or the step is refused.
pub trait ConstraintLayout: Debug + Clone + Copy + 'static {
    /// Lists of one entry for each constraint.
    type Multipliers: Shape;
    /// The places of entries, found once.
    type Pattern: Clone + Debug + Default;
    /// The matrix `G`.
    type Jacobian<S: Scalar>: Clone + Debug;
    /// The matrix `G_1 W G_0ᵀ`, or its factors.
    type Factors<S: Scalar>: Clone + Debug;

    /// The places of the entries in a system with so many degrees of freedom.
    fn pattern<F: Constrained<Layout = Self>>(system: &F, degrees: usize) -> Self::Pattern;

    /// Room for a Jacobian.
    fn jacobian<S: Scalar>(pattern: &Self::Pattern) -> Self::Jacobian<S>;

    /// Room for factors.
    fn factors<S: Scalar>(pattern: &Self::Pattern) -> Self::Factors<S>;

    /// Makes all entries zero.
    fn clear<S: Scalar>(jacobian: &mut Self::Jacobian<S>);

    /// Adds the slope number `number` of an evaluation, that of a constraint by a coordinate.
    fn add<S: Scalar>(
        pattern: &Self::Pattern,
        jacobian: &mut Self::Jacobian<S>,
        number: usize,
        at: [usize; 2],
        slope: S,
    );

    /// `G v`
    fn product<S: Scalar>(pattern: &Self::Pattern, jacobian: &Self::Jacobian<S>, v: &[S], into: &mut [S]);

    /// `|G| |v|`, entry by entry.
    fn absolute_product<S: Scalar>(
        pattern: &Self::Pattern,
        jacobian: &Self::Jacobian<S>,
        v: &[S],
        into: &mut [S],
    );

    /// `Gᵀ ν`
    fn transposed_product<S: Scalar>(
        pattern: &Self::Pattern,
        jacobian: &Self::Jacobian<S>,
        nu: &[S],
        into: &mut [S],
    );

    /// Factors `G_1 W G_0ᵀ` with the diagonal matrix `W`; returns where all pivots are positive.
    fn factor<S: Scalar>(
        pattern: &Self::Pattern,
        later: &Self::Jacobian<S>,
        w: &[S],
        earlier: &Self::Jacobian<S>,
        into: &mut Self::Factors<S>,
    ) -> S::Mask;

    /// The diagonal of `G W Gᵀ`.
    fn diagonal<S: Scalar>(pattern: &Self::Pattern, jacobian: &Self::Jacobian<S>, w: &[S], into: &mut [S]);

    /// The pivots of factors, constraint by constraint.
    fn pivots<S: Scalar>(pattern: &Self::Pattern, factors: &Self::Factors<S>, into: &mut [S]);

    /// `b` becomes `(G_1 W G_0ᵀ)⁻¹ b`.
    fn solve<S: Scalar>(pattern: &Self::Pattern, factors: &Self::Factors<S>, b: &mut [S]);
}

/// Whether a pivot can be divided by; `terms`: the absolute values of the terms of its diagonal entry.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn is_pivot<S: Scalar>(pivot: S, terms: S) -> S::Mask {
    (terms * LEAST_PIVOT).less(pivot) & pivot.is_finite()
}

/// Whether all of several truths hold, lane by lane.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn truth<M: Mask>() -> M {
    M::from_bool(true)
}
