//! The equations of a block of a step, written once for numbers of all kinds.

use std::marker::PhantomData;

use super::effort::Effort;
use super::newton::Equations;
use crate::algebra::scalar::{Constant, Mask, Over, Rounded, Scalar};
use crate::error::StepFailure;

/// Inputs of the equations of a block besides their unknowns: numbers and truths of the state, then those of constants.
pub type Inputs<S, K, const G: usize, const M: usize, const C: usize, const T: usize> =
    ([S; G], [<S as Scalar>::Mask; M], [K; C], [<K as Scalar>::Mask; T]);

/// The equations of `N` unknowns; generated.
pub trait Block<const G: usize, const M: usize, const C: usize, const T: usize, const N: usize>:
    Sized
{
    /// The residuals, and their Jacobian by rows.
    fn equations<S: Over<K>, K: Constant>(
        given: Inputs<S, K, G, M, C, T>,
        x: [S; N],
    ) -> ([S; N], [[S; N]; N]);

    /// See [`Scalar::newton`].
    ///
    /// # Errors
    /// The errors of [`Scalar::newton`].
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn newton<S: Over<K>, K: Constant, const SYMMETRIC: bool, const GUESS: bool, const CAREFUL: bool>(
        given: Inputs<S, K, G, M, C, T>,
        x: &mut [S; N],
    ) -> Result<Effort, StepFailure> {
        let posed = Posed::<Self, S, K, G, M, C, T> { given, block: PhantomData };
        S::newton::<N, SYMMETRIC, GUESS, CAREFUL>(x, posed)
    }
}

/// A block with its inputs.
struct Posed<B, S: Scalar, K: Scalar, const G: usize, const M: usize, const C: usize, const T: usize> {
    given: Inputs<S, K, G, M, C, T>,
    block: PhantomData<B>,
}

impl<B, S: Scalar, K: Scalar, const G: usize, const M: usize, const C: usize, const T: usize> Clone
    for Posed<B, S, K, G, M, C, T>
{
    fn clone(&self) -> Self {
        *self
    }
}

impl<B, S: Scalar, K: Scalar, const G: usize, const M: usize, const C: usize, const T: usize> Copy
    for Posed<B, S, K, G, M, C, T>
{
}

impl<B, S, K, const G: usize, const M: usize, const C: usize, const T: usize, const N: usize> Equations<S, N>
    for Posed<B, S, K, G, M, C, T>
where
    B: Block<G, M, C, T, N>,
    S: Over<K>,
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
