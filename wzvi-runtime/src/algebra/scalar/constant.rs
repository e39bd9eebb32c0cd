//! Numbers that do not depend on the state: one for all lanes of a step, one for each, or one with its
//! derivatives.

use std::array::from_fn;
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Sub};

use super::{Dual, Mask, Scalar};
use crate::algebra::lanes::{LaneMask, Lanes};
use crate::algebra::solve::{Factor, FactorsByLane};
use crate::error::StepFailure;
use crate::ground::numbers::for_tuples;

/// The type of prepared numbers: `f64` where all lanes of a step have one system, [`Lanes`] where each has
/// its own, [`Dual`] for derivatives with respect to parameters and the step size.
pub trait Constant: ComputesWith<Self> + Scalar<Mask: Send + Sync> + Send + Sync {
    /// A factored matrix of such numbers.
    type Factor<const N: usize>: Clone + Debug + Send + Sync;
    /// The constants of numbers with one more derivative, [`ComputesWith::Along`]. Systems in lanes share the
    /// constants of the first.
    type Lifted: Constant;

    /// Factors a matrix, given by rows.
    ///
    /// # Errors
    /// The errors of [`Factor::new`].
    fn factor<const N: usize>(matrix: [[Self; N]; N]) -> Result<Self::Factor<N>, StepFailure>;

    /// As a constant of numbers with one more derivative.
    fn lifted(self) -> Self::Lifted;

    /// A parameter of a system: the entry of the list of all parameters where they have derivatives, else the
    /// value.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn parameter(varied: &[Self], number: usize, value: f64) -> Self {
        let _ = (varied, number);
        Self::from_f64(value)
    }
}

impl Constant for f64 {
    type Factor<const N: usize> = Factor<f64, N>;
    type Lifted = f64;

    fn lifted(self) -> f64 {
        self
    }
    fn factor<const N: usize>(matrix: [[f64; N]; N]) -> Result<Factor<f64, N>, StepFailure> {
        Factor::new(matrix)
    }
}

impl<const D: usize, C: Constant<Mask = bool, Constant = C>> Constant for Dual<D, C> {
    type Factor<const N: usize> = Factor<Self, N>;
    type Lifted = Dual<1, Self>;

    fn lifted(self) -> Dual<1, Self> {
        Dual::constant(self)
    }
    fn factor<const N: usize>(matrix: [[Self; N]; N]) -> Result<Factor<Self, N>, StepFailure> {
        Factor::new(matrix)
    }

    fn parameter(varied: &[Self], number: usize, value: f64) -> Self {
        varied.get(number).copied().unwrap_or(Self::from_f64(value))
    }
}

impl<const L: usize> Constant for Lanes<L> {
    type Factor<const N: usize> = FactorsByLane<L, N>;
    type Lifted = f64;

    fn lifted(self) -> f64 {
        self.lane(0)
    }
    fn factor<const N: usize>(matrix: [[Self; N]; N]) -> Result<FactorsByLane<L, N>, StepFailure> {
        FactorsByLane::new(matrix)
    }
}

/// Numbers that are computed with constants `K`.
#[rustfmt::skip]
pub trait ComputesWith<K: Constant>:
    Scalar + Add<K, Output = Self> + Sub<K, Output = Self> + Mul<K, Output = Self> + Div<K, Output = Self>
{
    /// [`Dual<1, Self>`](Dual).
    type Along: ComputesWith<K::Lifted>;
    /// The lists as lists of [`ComputesWith::Along`].
    fn along<const N: usize>(lists: [&mut [Dual<1, Self>]; N]) -> [&mut [Self::Along]; N];
    /// A constant as such a number.
    fn constant(constant: K) -> Self;
    /// The list of all parameters, where they have derivatives; others do not read it.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn varied(parameters: &[K]) -> &[Self::Constant] {
        let _ = parameters;
        &[]
    }
    /// The truth of a comparison of constants.
    fn truth(truth: K::Mask) -> Self::Mask;
    /// The first number where a comparison of constants is true, else the second. Only one of them is
    /// computed where the comparison is the same for all lanes.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn choose(truth: K::Mask, then: impl FnOnce() -> Self, otherwise: impl FnOnce() -> Self) -> Self {
        if truth.all() { then() } else { otherwise() }
    }
    /// `A⁻¹ b` for a matrix of constants.
    fn solve_factored<const N: usize>(factor: &K::Factor<N>, b: [Self; N]) -> [Self; N];
}

impl<S: Scalar> ComputesWith<f64> for S {
    type Along = Dual<1, Self>;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn along<const N: usize>(lists: [&mut [Dual<1, Self>]; N]) -> [&mut [Dual<1, Self>]; N] {
        lists
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn constant(constant: f64) -> S {
        S::from_f64(constant)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn truth(truth: bool) -> S::Mask {
        Mask::from_bool(truth)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn solve_factored<const N: usize>(factor: &Factor<f64, N>, b: [S; N]) -> [S; N] {
        factor.apply(b)
    }
}

impl<const D: usize, C: Constant<Mask = bool, Constant = C>> ComputesWith<Self> for Dual<D, C> {
    type Along = Dual<1, Self>;
    #[inline]
    fn along<const N: usize>(lists: [&mut [Dual<1, Self>]; N]) -> [&mut [Dual<1, Self>]; N] {
        lists
    }
    #[inline]
    fn constant(constant: Self) -> Self {
        constant
    }
    #[inline]
    fn varied(parameters: &[Self]) -> &[Self] {
        parameters
    }
    #[inline]
    fn truth(truth: bool) -> bool {
        truth
    }
    #[inline]
    fn solve_factored<const N: usize>(factor: &Factor<Self, N>, b: [Self; N]) -> [Self; N] {
        factor.solve(b)
    }
}

impl<const L: usize> ComputesWith<Self> for Lanes<L> {
    type Along = Dual<1, Self>;
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn along<const N: usize>(lists: [&mut [Dual<1, Self>]; N]) -> [&mut [Dual<1, Self>]; N] {
        lists
    }
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

/// Constants of a step, in numbers of any type.
pub trait Constants {
    /// In numbers of one type.
    type In<K: Constant>: Clone + Debug + Send + Sync;

    /// The constants of `L` systems, one in each lane.
    fn gather<const L: usize>(of_lanes: [&Self::In<f64>; L]) -> Self::In<Lanes<L>>;
}

/// Constants in numbers of one type.
pub type ConstantsIn<C, K> = <C as Constants>::In<K>;

/// `N` numbers.
#[derive(Clone, Copy, Debug)]
pub struct Reals<const N: usize>;

/// Constants that are numbers and nothing else.
pub trait Parameters: Constants {
    /// The constants of one lane, without derivatives.
    fn lane<K: Constant>(of: &Self::In<K>, lane: usize) -> Self::In<f64>;
    /// The list of all parameters, where these are [`Varied`].
    fn varied<K: Constant>(of: &Self::In<K>) -> &[K];
}

/// All parameters where they have derivatives, else none: what elements read as [`Constant::parameter`].
#[derive(Clone, Copy, Debug)]
pub struct Varied;

impl Constants for Varied {
    type In<K: Constant> = Vec<K>;

    fn gather<const L: usize>(_: [&Vec<f64>; L]) -> Vec<Lanes<L>> {
        Vec::new()
    }
}

impl Parameters for Varied {
    fn lane<K: Constant>(_: &Vec<K>, _: usize) -> Vec<f64> {
        Vec::new()
    }
    fn varied<K: Constant>(of: &Vec<K>) -> &[K] {
        of
    }
}

impl<const N: usize> Parameters for Reals<N> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lane<K: Constant>(of: &[K; N], lane: usize) -> [f64; N] {
        of.map(|number| number.lane(lane))
    }
    fn varied<K: Constant>(_: &[K; N]) -> &[K] {
        &[]
    }
}

impl<const N: usize> Constants for Reals<N> {
    type In<K: Constant> = [K; N];

    fn gather<const L: usize>(of_lanes: [&[f64; N]; L]) -> [Lanes<L>; N] {
        from_fn(|i| Lanes::new(of_lanes.map(|numbers| numbers[i])))
    }
}

/// `N` comparisons.
#[derive(Clone, Copy, Debug)]
pub struct Truths<const N: usize>;

impl<const N: usize> Constants for Truths<N> {
    type In<K: Constant> = [K::Mask; N];

    fn gather<const L: usize>(of_lanes: [&[bool; N]; L]) -> [LaneMask<L>; N] {
        from_fn(|i| LaneMask::of_lanes(|lane| of_lanes[lane][i]))
    }
}

/// A factored matrix.
#[derive(Clone, Copy, Debug)]
pub struct Factored<const N: usize>;

impl<const N: usize> Constants for Factored<N> {
    type In<K: Constant> = K::Factor<N>;

    fn gather<const L: usize>(of_lanes: [&Factor<f64, N>; L]) -> FactorsByLane<L, N> {
        FactorsByLane::gather(of_lanes)
    }
}

/// As long as those of [`Numbers`](crate::ground::numbers::Numbers).
macro_rules! tuples {
    ($(($($part:ident $place:tt)+))+) => {$(
        impl<$($part: Constants,)+> Constants for ($($part,)+) {
            type In<Number: Constant> = ($($part::In<Number>,)+);

            fn gather<const LANES: usize>(of_lanes: [&Self::In<f64>; LANES]) -> Self::In<Lanes<LANES>> {
                ($($part::gather(of_lanes.map(|parts| &parts.$place)),)+)
            }
        }
    )+};
}

for_tuples!(tuples);
