//! The equations of a block of a step, written once for numbers of all kinds.
#![expect(clippy::needless_range_loop, reason = "plain loops over arrays are what becomes vector code")]

use std::marker::PhantomData;

use super::dense::{FactoredMatrix, set_derivatives};
use super::effort::Effort;
use super::newton::{Equations, newton, solve_pair};
use crate::algebra::scalar::{ComputesWith, Constant, Mask, Rounded, Scalar};
use crate::error::StepFailure;

/// Inputs of the equations of a block besides their unknowns: numbers and truths of the state, then those of
/// constants.
pub type Inputs<S, K, const G: usize, const M: usize, const C: usize, const T: usize> =
    ([S; G], [<S as Scalar>::Mask; M], [K; C], [<K as Scalar>::Mask; T]);

/// The equations of `N` unknowns; generated.
pub trait Block<const G: usize, const M: usize, const C: usize, const T: usize, const N: usize>:
    Sized
{
    /// The residuals, and their Jacobian by rows.
    fn equations<S: ComputesWith<K>, K: Constant>(
        given: Inputs<S, K, G, M, C, T>,
        x: [S; N],
    ) -> ([S; N], [[S; N]; N]);

    /// Solves `r(x) = 0` from `x`, which becomes the solution; of a `SYMMETRIC` Jacobian only the lower
    /// triangle is read. `GUESS`: whether a start other than zero may come from past steps.
    ///
    /// # Errors
    /// [`StepFailure::NotConverged`], [`StepFailure::Singular`] or [`StepFailure::NonFinite`]; unless
    /// `CAREFUL`, of any iteration whose corrections do not shrink fast. In lanes, paths without a
    /// solution have NaN instead, unless `CAREFUL`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn newton<
        S: ComputesWith<K>,
        K: Constant,
        const SYMMETRIC: bool,
        const GUESS: bool,
        const CAREFUL: bool,
    >(
        given: Inputs<S, K, G, M, C, T>,
        x: &mut [S; N],
    ) -> Result<Effort, StepFailure> {
        if const { S::DERIVATIVES > 0 } {
            return Self::differentiate::<S, K, SYMMETRIC, GUESS, CAREFUL>(given, x);
        }
        let posed = BlockWithInputs::<Self, S, K, G, M, C, T> { given, block: PhantomData };
        newton::<S, N, SYMMETRIC, GUESS, CAREFUL>(x, posed)
    }

    /// [`Block::newton`] for numbers with derivatives: `r(x; z) = 0` is solved for the values alone, and
    /// `x' = -J⁻¹ r'` there, where `r'` are the derivatives of the residuals at unknowns without any.
    ///
    /// # Errors
    /// The errors of the values, and of a Jacobian that has no inverse there.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn differentiate<
        S: ComputesWith<K>,
        K: Constant,
        const SYMMETRIC: bool,
        const GUESS: bool,
        const CAREFUL: bool,
    >(
        given: Inputs<S, K, G, M, C, T>,
        x: &mut [S; N],
    ) -> Result<Effort, StepFailure> {
        let (numbers, masks, constants, truths) = given;
        let values = (values_of(&numbers), masks, of_lane(constants, 0), truths_of_lane(truths, 0));
        let mut solution = values_of(x);
        let effort = Self::newton::<S::Value, f64, SYMMETRIC, GUESS, CAREFUL>(values, &mut solution)?;
        for i in 0..N {
            x[i] = S::of_value(solution[i]);
        }
        let (residual, jacobian) = Self::equations(given, *x);
        let mut matrix = [[S::Value::from_f64(0.0); N]; N];
        for i in 0..N {
            for j in 0..N {
                // The lower triangle of a symmetric matrix is given.
                let (i_given, j_given) = if SYMMETRIC && j > i { (j, i) } else { (i, j) };
                matrix[i][j] = jacobian[i_given][j_given].value();
            }
        }
        let solver = if is_small(&matrix) { None } else { Some(FactoredMatrix::new(matrix)?) };
        for number in 0..S::DERIVATIVES {
            let mut side = [S::Value::from_f64(0.0); N];
            for i in 0..N {
                side[i] = -residual[i].derivative(number);
            }
            let slopes = match &solver {
                Some(solver) => solver.solve(side),
                None => solve_small(&matrix, side),
            };
            set_derivatives(x, number, slopes);
        }
        Ok(effort)
    }
}

/// Whether [`solve_small`] solves with this matrix: for one unknown, and for two by Cramer's rule where that
/// is safe. In lanes, each path would take the latter or not on account of the others.
#[cfg_attr(not(debug_assertions), inline(always))]
fn is_small<S: Scalar, const N: usize>(matrix: &[[S; N]; N]) -> bool {
    N == 1 || (N == 2 && !S::LANES_ARE_PATHS && solve_pair::<S, N, false>(matrix, &matrix[0]).1.all())
}

/// `A⁻¹ b`
#[cfg_attr(not(debug_assertions), inline(always))]
fn solve_small<S: Scalar, const N: usize>(matrix: &[[S; N]; N], b: [S; N]) -> [S; N] {
    if N == 1 {
        let mut x = b;
        x[0] = b[0] / matrix[0][0];
        return x;
    }
    solve_pair::<S, N, false>(matrix, &b).0
}

/// A block with its inputs.
struct BlockWithInputs<
    B,
    S: Scalar,
    K: Scalar,
    const G: usize,
    const M: usize,
    const C: usize,
    const T: usize,
> {
    given: Inputs<S, K, G, M, C, T>,
    block: PhantomData<B>,
}

impl<B, S: Scalar, K: Scalar, const G: usize, const M: usize, const C: usize, const T: usize> Clone
    for BlockWithInputs<B, S, K, G, M, C, T>
{
    fn clone(&self) -> Self {
        *self
    }
}

impl<B, S: Scalar, K: Scalar, const G: usize, const M: usize, const C: usize, const T: usize> Copy
    for BlockWithInputs<B, S, K, G, M, C, T>
{
}

impl<B, S, K, const G: usize, const M: usize, const C: usize, const T: usize, const N: usize> Equations<S, N>
    for BlockWithInputs<B, S, K, G, M, C, T>
where
    B: Block<G, M, C, T, N>,
    S: ComputesWith<K>,
    K: Constant,
{
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn evaluate(&self, x: &[S; N]) -> ([S; N], [[S; N]; N]) {
        B::equations(self.given, *x)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn rounded(&self, x: &[S; N], lane: usize) -> [Rounded; N] {
        let (numbers, masks, constants, truths) = self.given;
        let (numbers, masks) = (of_lane(numbers, lane), truths_of_lane(masks, lane));
        let given = (numbers, masks, of_lane(constants, lane), truths_of_lane(truths, lane));
        rounded::<B, G, M, C, T, N>(given, of_lane(*x, lane))
    }
}

/// Numbers without their derivatives.
#[cfg_attr(not(debug_assertions), inline(always))]
fn values_of<S: Scalar, const N: usize>(numbers: &[S; N]) -> [S::Value; N] {
    let mut values = [S::Value::from_f64(0.0); N];
    for i in 0..N {
        values[i] = numbers[i].value();
    }
    values
}

// Functions of the numbers alone: a closure would be compiled again for every block.
#[cfg_attr(not(debug_assertions), inline(always))]
fn of_lane<S: Scalar, const N: usize>(numbers: [S; N], lane: usize) -> [f64; N] {
    numbers.map(|number| number.lane(lane))
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn truths_of_lane<M: Mask, const N: usize>(masks: [M; N], lane: usize) -> [bool; N] {
    masks.map(|mask| mask.lane(lane))
}

/// The residuals at all numbers that round to `x`. The inputs count as exact.
#[cold]
#[inline(never)]
fn rounded<B, const G: usize, const M: usize, const C: usize, const T: usize, const N: usize>(
    (numbers, masks, constants, truths): Inputs<f64, f64, G, M, C, T>,
    x: [f64; N],
) -> [Rounded; N]
where
    B: Block<G, M, C, T, N>,
{
    let given = (numbers.map(Rounded::exact), masks, constants, truths);
    B::equations::<Rounded, f64>(given, x.map(Rounded::nearest)).0
}
