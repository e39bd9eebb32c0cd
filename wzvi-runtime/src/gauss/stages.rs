//! The numbers of all stages of a step beside each other.

use std::fmt::Debug;

use super::Field;
use crate::lanes::Lanes;
use crate::numbers::Numbers;
use crate::scalar::Scalar;

/// Where the slopes of all stages are taken, and by what they are weighted.
#[derive(Clone, Copy, Debug)]
pub struct At<'a, T> {
    /// Times of the stages.
    pub t: T,
    /// The increment of the drift.
    pub h: T,
    /// The increments of the noises.
    pub dw: &'a [T],
}

/// The largest changes of each stage, relative to its size; infinite for NaN.
#[derive(Clone, Copy, Debug)]
pub struct Changes<const N: usize>([f64; N]);

impl<const N: usize> Default for Changes<N> {
    #[inline(always)]
    fn default() -> Self {
        Self([0.0; N])
    }
}

impl<const N: usize> Changes<N> {
    /// The larger of these and `changes` relative to `sizes`.
    #[inline(always)]
    fn or(self, changes: [f64; N], sizes: [f64; N]) -> Self {
        let mut largest = self.0;
        for i in 0..N {
            let relative = (changes[i] * nearly_inverse(sizes[i])).abs();
            let relative = if relative < f64::INFINITY { relative } else { f64::INFINITY };
            largest[i] = if largest[i] > relative { largest[i] } else { relative };
        }
        Self(largest)
    }

    /// The largest of all, and whether it is at most so large. As integers, which have the order of the numbers where these are not
    /// negative: the largest of many is found in any order, so in lanes.
    #[inline(always)]
    pub(super) fn largest(self, bound: f64) -> (f64, bool) {
        let largest = in_pairs(self.0.map(f64::to_bits), u64::max);
        (f64::from_bits(largest), largest <= bound.to_bits())
    }
}

/// `1 / size` within an eighth, by the bits of the number, which are nearly its logarithm: sizes are no more exact than that.
#[inline(always)]
fn nearly_inverse(size: f64) -> f64 {
    const TWICE_ONE: u64 = 0x7fde_6238_22fc_16e6;
    f64::from_bits(TWICE_ONE.wrapping_sub(size.to_bits()))
}

/// What learns of the stages that [`place`](super::advance::Step::place) replaces. (A trait: a closure that is called in several places
/// would not be inlined, and so not be compiled for the instructions of its caller.)
pub(super) trait Observer<T> {
    /// Half of the phase space, degree of freedom, old stages and new ones.
    fn see(&mut self, half: usize, d: usize, old: T, new: T);
}

impl<T> Observer<T> for () {
    #[inline(always)]
    fn see(&mut self, _half: usize, _d: usize, _old: T, _new: T) {}
}

impl<T, F: FnMut(usize, usize, T, T)> Observer<T> for (F,) {
    #[inline(always)]
    fn see(&mut self, half: usize, d: usize, old: T, new: T) {
        self.0(half, d, old, new);
    }
}

/// One number per stage.
pub trait Stages<S: Scalar, const N: usize>: Copy + Debug + Numbers {
    /// The same for each stage.
    fn splat(number: S) -> Self;
    /// The number of stage `i`.
    fn get(self, i: usize) -> S;
    /// Replaces the number of stage `i`.
    fn set(&mut self, i: usize, number: S);
    /// The larger of the changes before and that from `old` to `self`, stage by stage, relative to the sizes of `self` and `start`.
    fn changes(self, old: Self, start: S, before: Changes<N>) -> Changes<N>;

    /// `Σ_j matrix[j] self_j`: column `j` of a matrix times the number of stage `j`.
    #[inline(always)]
    fn product(self, matrix: &[[f64; N]; N]) -> Self {
        // In four sums, so that few additions wait for one another. They have names: arrays would be in memory.
        let zero = Self::splat(S::from_f64(0.0));
        let (mut a, mut b, mut c, mut d) = (zero, zero, zero, zero);
        for (j, column) in matrix.iter().enumerate() {
            let term = Self::splat(self.get(j)).times(column);
            match j {
                0 => a = term,
                1 => b = term,
                2 => c = term,
                3 => d = term,
                _ if j % 4 == 0 => a = a.plus(term),
                _ if j % 4 == 1 => b = b.plus(term),
                _ if j % 4 == 2 => c = c.plus(term),
                _ => d = d.plus(term),
            }
        }
        match N {
            1 => a,
            2 => a.plus(b),
            3 => a.plus(b).plus(c),
            _ => a.plus(b).plus(c.plus(d)),
        }
    }

    /// `self + other`
    fn plus(self, other: Self) -> Self;
    /// `self - other`
    fn minus(self, other: Self) -> Self;
    /// `self` times a number for each stage.
    fn times(self, factors: &[f64; N]) -> Self;
    /// The sum over the stages.
    #[inline(always)]
    fn total(self) -> S {
        let mut list = [S::from_f64(0.0); N];
        for (i, number) in list.iter_mut().enumerate() {
            *number = self.get(i);
        }
        in_pairs(list, |a, b| a + b)
    }

    /// The slopes of the step Hamiltonian at all stages.
    fn slopes<F: Field, const BY_Q: bool, const BY_P: bool>(
        system: &F,
        at: &At<'_, Self>,
        q: &[Self],
        p: &[Self],
        by_q: &mut [Self],
        by_p: &mut [Self],
        scratch: &mut Scratch<S>,
    );
}

/// All of a list as one, in pairs, so that few operations wait for one another.
#[inline(always)]
fn in_pairs<T: Copy, const N: usize>(mut list: [T; N], join: impl Fn(T, T) -> T) -> T {
    let mut length = N;
    while length > 1 {
        let half = length / 2;
        for i in 0..half {
            list[i] = join(list[i], list[i + length - half]);
        }
        length -= half;
    }
    list[0]
}

/// Room for one stage.
#[derive(Clone, Debug)]
pub struct Scratch<S> {
    one: [Vec<S>; 4],
    dw: Vec<S>,
}

impl<S> Default for Scratch<S> {
    fn default() -> Self {
        Self { one: std::array::from_fn(|_| Vec::new()), dw: Vec::new() }
    }
}

impl<S> Scratch<S> {
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
    at: &At<'_, T>,
    [q, p]: [&[T]; 2],
    by_q: &mut [T],
    by_p: &mut [T],
    scratch: &mut Scratch<S>,
) {
    let Scratch { one: [own_q, own_p, own_by_q, own_by_p], dw: own_dw, .. } = scratch;
    let zero = S::from_f64(0.0);
    for own in [&mut *own_q, own_p, own_by_q, own_by_p] {
        own.resize(q.len(), zero);
    }
    own_dw.resize(at.dw.len(), zero);
    for i in 0..N {
        for (own, all) in own_q.iter_mut().chain(&mut *own_p).zip(q.iter().chain(p)) {
            *own = all.get(i);
        }
        own_dw.iter_mut().zip(at.dw).for_each(|(own, all)| *own = all.get(i));
        let (t, h) = (at.t.get(i), at.h.get(i));
        system.slopes::<S, BY_Q, BY_P>(t, h, own_q, own_p, own_dw, own_by_q, own_by_p);
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
    /// A loop over the stages with all columns in it: as many small loops each would be unrolled before they become vector code.
    #[inline(always)]
    fn product(self, matrix: &[[f64; N]; N]) -> Self {
        let factors = self.to_array();
        let mut products = [0.0; N];
        for (i, product) in products.iter_mut().enumerate() {
            let mut sums = (0.0, 0.0, 0.0, 0.0);
            for (j, (column, factor)) in matrix.iter().zip(factors).enumerate() {
                let term = column[i] * factor;
                match j % 4 {
                    0 => sums.0 += term,
                    1 => sums.1 += term,
                    2 => sums.2 += term,
                    _ => sums.3 += term,
                }
            }
            *product = (sums.0 + sums.1) + (sums.2 + sums.3);
        }
        Self::new(products)
    }
    #[inline(always)]
    fn changes(self, old: Self, start: f64, before: Changes<N>) -> Changes<N> {
        before.or((self - old).to_array(), (self.abs() + start.abs()).to_array())
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
        at: &At<'_, Self>,
        q: &[Self],
        p: &[Self],
        by_q: &mut [Self],
        by_p: &mut [Self],
        scratch: &mut Scratch<f64>,
    ) {
        if F::IN_LANES {
            system.slopes::<Self, BY_Q, BY_P>(at.t, at.h, q, p, at.dw, by_q, by_p);
        } else {
            one_by_one::<F, f64, Self, N, BY_Q, BY_P>(system, at, [q, p], by_q, by_p, scratch);
        }
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
    fn changes(self, old: Self, start: S, before: Changes<N>) -> Changes<N> {
        let changes = std::array::from_fn(|i| (self[i] - old[i]).magnitude());
        before.or(changes, self.map(|number| number.magnitude() + start.magnitude()))
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
        at: &At<'_, Self>,
        q: &[Self],
        p: &[Self],
        by_q: &mut [Self],
        by_p: &mut [Self],
        scratch: &mut Scratch<S>,
    ) {
        one_by_one::<F, S, Self, N, BY_Q, BY_P>(system, at, [q, p], by_q, by_p, scratch);
    }
}
