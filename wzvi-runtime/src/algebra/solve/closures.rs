//! Equations for tests.

use super::newton::Equations;
use crate::algebra::scalar::Rounded;

/// [`Equations`] of two closures.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closures<E, R> {
    /// [`Equations::evaluate`]
    pub(super) evaluate: E,
    /// [`Equations::rounded`]
    pub(super) rounded: R,
}

impl<S, E, R, const N: usize> Equations<S, N> for Closures<E, R>
where
    E: Fn(&[S; N]) -> ([S; N], [[S; N]; N]) + Copy,
    R: Fn(&[S; N], usize) -> [Rounded; N] + Copy,
{
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn evaluate(&self, x: &[S; N]) -> ([S; N], [[S; N]; N]) {
        (self.evaluate)(x)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn rounded(&self, x: &[S; N], lane: usize) -> [Rounded; N] {
        (self.rounded)(x, lane)
    }
}
