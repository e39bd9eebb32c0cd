//! Numbers that the state does not enter: one for all lanes of a step, or one for each.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Sub};

use super::{Mask, Scalar};
use crate::algebra::lanes::{LaneMask, Lanes};
use crate::algebra::solve::{Factor, FactorsByLane};

/// What is prepared of a system: `f64` where all lanes of a step are of one system, [`Lanes`] where each is of its own.
pub trait Constant: Scalar<Mask: Send + Sync> + Send + Sync {
    /// A factored matrix of such numbers.
    type Factor<const N: usize>: Clone + Debug + Send + Sync;
}

impl Constant for f64 {
    type Factor<const N: usize> = Factor<f64, N>;
}

impl<const L: usize> Constant for Lanes<L> {
    type Factor<const N: usize> = FactorsByLane<L, N>;
}

/// Numbers that are computed with constants `K`.
#[rustfmt::skip]
pub trait Over<K: Constant>:
    Scalar + Add<K, Output = Self> + Sub<K, Output = Self> + Mul<K, Output = Self> + Div<K, Output = Self>
{
    /// A constant as such a number.
    fn constant(constant: K) -> Self;
    /// The truth of a comparison of constants.
    fn truth(truth: K::Mask) -> Self::Mask;
    /// The first number where a comparison of constants is true, else the second: no more than one of them is computed where it is the same for
    /// all lanes.
    fn choose(truth: K::Mask, then: impl FnOnce() -> Self, otherwise: impl FnOnce() -> Self) -> Self;
    /// `A⁻¹ b` for a matrix of constants.
    fn solve_factored<const N: usize>(factor: &K::Factor<N>, b: [Self; N]) -> [Self; N];
}

impl<S: Scalar> Over<f64> for S {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn constant(constant: f64) -> S {
        S::from_f64(constant)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn truth(truth: bool) -> S::Mask {
        Mask::from_bool(truth)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn choose(truth: bool, then: impl FnOnce() -> S, otherwise: impl FnOnce() -> S) -> S {
        if truth { then() } else { otherwise() }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn solve_factored<const N: usize>(factor: &Factor<f64, N>, b: [S; N]) -> [S; N] {
        factor.apply(b)
    }
}

impl<const L: usize> Over<Lanes<L>> for Lanes<L> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn constant(constant: Self) -> Self {
        constant
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn truth(truth: LaneMask<L>) -> LaneMask<L> {
        truth
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn choose(truth: LaneMask<L>, then: impl FnOnce() -> Self, otherwise: impl FnOnce() -> Self) -> Self {
        Self::select(truth, then(), otherwise())
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn solve_factored<const N: usize>(factor: &FactorsByLane<L, N>, b: [Self; N]) -> [Self; N] {
        factor.apply(b)
    }
}

/// What is made of `L` values of `T`, each of which becomes a lane.
pub trait Beside<T, const L: usize> {
    /// All of them, in the order of the lanes.
    fn beside(lanes: [&T; L]) -> Self;
}

impl<const L: usize> Beside<f64, L> for Lanes<L> {
    fn beside(lanes: [&f64; L]) -> Self {
        Self::new(lanes.map(|number| *number))
    }
}

impl<const L: usize> Beside<bool, L> for LaneMask<L> {
    fn beside(lanes: [&bool; L]) -> Self {
        let mut mask = Self::from_bool(false);
        lanes.iter().enumerate().for_each(|(lane, truth)| mask.set(lane, **truth));
        mask
    }
}

impl<T, B: Beside<T, L>, const N: usize, const L: usize> Beside<[T; N], L> for [B; N] {
    fn beside(lanes: [&[T; N]; L]) -> Self {
        std::array::from_fn(|i| B::beside(lanes.map(|lane| &lane[i])))
    }
}

/// As long as those of [`Numbers`](crate::ground::numbers::Numbers).
macro_rules! tuples {
    ($(($($part:ident $lane:ident $place:tt)+))+) => {$(
        impl<$($part,)+ $($lane: Beside<$part, L>,)+ const L: usize> Beside<($($part,)+), L> for ($($lane,)+) {
            fn beside(lanes: [&($($part,)+); L]) -> Self {
                ($($lane::beside(lanes.map(|lane| &lane.$place)),)+)
            }
        }
    )+};
}

tuples! {
    (A Z 0)
    (A Z 0 B Y 1)
    (A Z 0 B Y 1 C X 2)
    (A Z 0 B Y 1 C X 2 D W 3)
    (A Z 0 B Y 1 C X 2 D W 3 E V 4)
    (A Z 0 B Y 1 C X 2 D W 3 E V 4 F U 5)
    (A Z 0 B Y 1 C X 2 D W 3 E V 4 F U 5 G T 6)
    (A Z 0 B Y 1 C X 2 D W 3 E V 4 F U 5 G T 6 H S 7)
    (A Z 0 B Y 1 C X 2 D W 3 E V 4 F U 5 G T 6 H S 7 I R 8)
    (A Z 0 B Y 1 C X 2 D W 3 E V 4 F U 5 G T 6 H S 7 I R 8 J Q 9)
    (A Z 0 B Y 1 C X 2 D W 3 E V 4 F U 5 G T 6 H S 7 I R 8 J Q 9 K P 10)
    (A Z 0 B Y 1 C X 2 D W 3 E V 4 F U 5 G T 6 H S 7 I R 8 J Q 9 K P 10 M O 11)
}
