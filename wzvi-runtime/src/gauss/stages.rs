//! The numbers of all stages of a step beside each other.

use std::fmt::Debug;

use super::Field;
use crate::lanes::Lanes;
use crate::numbers::Numbers;
use crate::scalar::Scalar;

/// Where the field is evaluated: the start of the step, its size, its increments, and the nodes.
#[derive(Clone, Copy, Debug)]
pub struct At<'a, S, const N: usize> {
    /// Start of the step.
    pub t: f64,
    /// Step size.
    pub h: f64,
    /// Increments of the step.
    pub dw: &'a [S],
    /// Nodes.
    pub c: &'a [f64; N],
}

/// One number per stage.
pub trait Stages<S: Scalar, const N: usize>: Copy + Debug + Numbers {
    /// The same for each stage.
    fn splat(number: S) -> Self;
    /// The number of stage `i`.
    fn get(self, i: usize) -> S;
    /// Replaces the number of stage `i`.
    fn set(&mut self, i: usize, number: S);
    /// The sum of the absolute values.
    fn size(self) -> f64;

    /// `self + Σ_j matrix[j] other_j`: column `j` of a matrix times the number of stage `j`.
    #[inline(always)]
    fn plus_product(self, matrix: &[[f64; N]; N], other: Self) -> Self {
        // Two sums, so that an addition does not wait for the one before.
        let (mut even, mut odd) = (self, Self::splat(S::from_f64(0.0)));
        for (j, column) in matrix.iter().enumerate() {
            let factor = other.get(j);
            let sum = if j % 2 == 0 { &mut even } else { &mut odd };
            *sum = sum.plus_scaled(column, factor);
        }
        even.plus(odd)
    }

    /// `self + column factor`
    fn plus_scaled(self, column: &[f64; N], factor: S) -> Self;
    /// `self + other`
    fn plus(self, other: Self) -> Self;
    /// `self - other`
    fn minus(self, other: Self) -> Self;
    /// `self` times a number for each stage.
    fn times(self, factors: &[f64; N]) -> Self;
    /// The sum over the stages, each times a number.
    #[inline(always)]
    fn total(self, factors: &[f64; N]) -> S {
        let terms = self.times(factors);
        let mut list = [S::from_f64(0.0); N];
        for (i, term) in list.iter_mut().enumerate() {
            *term = terms.get(i);
        }
        sum(list)
    }

    /// The slopes of the step Hamiltonian at all stages.
    fn slopes<F: Field, const BY_Q: bool, const BY_P: bool>(
        system: &F,
        at: &At<'_, S, N>,
        q: &[Self],
        p: &[Self],
        by_q: &mut [Self],
        by_p: &mut [Self],
        scratch: &mut Scratch<S, Self>,
    );
}

/// The sum, in pairs, so that few additions wait for one another.
#[inline(always)]
fn sum<S: Scalar, const N: usize>(mut list: [S; N]) -> S {
    let mut length = N;
    while length > 1 {
        let half = length / 2;
        for i in 0..half {
            list[i] = list[i] + list[length - 1 - i];
        }
        length -= half;
    }
    list[0]
}

/// Room for one stage, and for the increments in all stages.
#[derive(Clone, Debug)]
pub struct Scratch<S, T> {
    one: [Vec<S>; 4],
    dw: Vec<T>,
}

impl<S, T> Default for Scratch<S, T> {
    fn default() -> Self {
        Self { one: std::array::from_fn(|_| Vec::new()), dw: Vec::new() }
    }
}

impl<S, T> Scratch<S, T> {
    /// Makes room for so many degrees of freedom and noises.
    pub(super) fn reserve(&mut self, degrees: usize, noises: usize) {
        self.one.iter_mut().for_each(|list| list.reserve(degrees));
        self.dw.reserve(noises);
    }
}

/// Stage by stage.
#[inline(always)]
fn one_by_one<F: Field, S: Scalar, T: Stages<S, N>, const N: usize, const BY_Q: bool, const BY_P: bool>(
    system: &F,
    at: &At<'_, S, N>,
    [q, p]: [&[T]; 2],
    by_q: &mut [T],
    by_p: &mut [T],
    scratch: &mut Scratch<S, T>,
) {
    let [own_q, own_p, own_by_q, own_by_p] = &mut scratch.one;
    for own in [&mut *own_q, own_p, own_by_q, own_by_p] {
        own.resize(q.len(), S::from_f64(0.0));
    }
    for (i, c) in at.c.iter().enumerate() {
        for (own, all) in own_q.iter_mut().chain(&mut *own_p).zip(q.iter().chain(p)) {
            *own = all.get(i);
        }
        let t = S::from_f64(at.t + c * at.h);
        system.slopes::<S, BY_Q, BY_P>(t, at.h, own_q, own_p, at.dw, own_by_q, own_by_p);
        if BY_Q {
            by_q.iter_mut().zip(&*own_by_q).for_each(|(all, own)| all.set(i, *own));
        }
        if BY_P {
            by_p.iter_mut().zip(&*own_by_p).for_each(|(all, own)| all.set(i, *own));
        }
    }
}

impl<const N: usize> Stages<f64, N> for Lanes<N> {
    #[inline(always)]
    fn splat(number: f64) -> Self {
        Self::new([number; N])
    }
    #[inline(always)]
    fn get(self, i: usize) -> f64 {
        self[i]
    }
    #[inline(always)]
    fn set(&mut self, i: usize, number: f64) {
        Lanes::set(self, i, number);
    }
    #[inline(always)]
    fn size(self) -> f64 {
        sum(self.abs().to_array())
    }
    #[inline(always)]
    fn plus_scaled(self, column: &[f64; N], factor: f64) -> Self {
        self + Self::new(*column) * factor
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self + other
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self - other
    }
    #[inline(always)]
    fn times(self, factors: &[f64; N]) -> Self {
        self * Self::new(*factors)
    }

    #[inline(always)]
    fn slopes<F: Field, const BY_Q: bool, const BY_P: bool>(
        system: &F,
        at: &At<'_, f64, N>,
        q: &[Self],
        p: &[Self],
        by_q: &mut [Self],
        by_p: &mut [Self],
        scratch: &mut Scratch<f64, Self>,
    ) {
        if !F::IN_LANES {
            return one_by_one::<F, f64, Self, N, BY_Q, BY_P>(system, at, [q, p], by_q, by_p, scratch);
        }
        scratch.dw.clear();
        scratch.dw.extend(at.dw.iter().map(|&dw| Self::splat(dw)));
        let t = Self::new(*at.c) * at.h + at.t;
        system.slopes::<Self, BY_Q, BY_P>(t, at.h, q, p, &scratch.dw, by_q, by_p);
    }
}

impl<S: Scalar, const N: usize> Stages<S, N> for [S; N] {
    fn splat(number: S) -> Self {
        [number; N]
    }
    fn get(self, i: usize) -> S {
        self[i]
    }
    fn set(&mut self, i: usize, number: S) {
        self[i] = number;
    }
    fn size(self) -> f64 {
        sum(self.map(Scalar::magnitude))
    }
    fn plus_scaled(self, column: &[f64; N], factor: S) -> Self {
        std::array::from_fn(|i| self[i] + factor * column[i])
    }
    fn plus(self, other: Self) -> Self {
        std::array::from_fn(|i| self[i] + other[i])
    }
    fn minus(self, other: Self) -> Self {
        std::array::from_fn(|i| self[i] - other[i])
    }
    fn times(self, factors: &[f64; N]) -> Self {
        std::array::from_fn(|i| self[i] * factors[i])
    }

    fn slopes<F: Field, const BY_Q: bool, const BY_P: bool>(
        system: &F,
        at: &At<'_, S, N>,
        q: &[Self],
        p: &[Self],
        by_q: &mut [Self],
        by_p: &mut [Self],
        scratch: &mut Scratch<S, Self>,
    ) {
        one_by_one::<F, S, Self, N, BY_Q, BY_P>(system, at, [q, p], by_q, by_p, scratch);
    }
}
