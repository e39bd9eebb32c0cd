//! The numbers of all stages of a step, and the parts of them that are computed with at once.

use std::fmt::Debug;

use super::Field;
use super::shape::Shape;
use crate::lanes::Lanes;
use crate::numbers::Numbers;
use crate::scalar::Scalar;

/// What learns of the stages that [`place`](super::advance::Step::place) replaces. (A trait: a closure that is called in several places
/// would not be inlined, and so not be compiled for the instructions of its caller.)
pub(super) trait Observer<T> {
    /// Half of the phase space, degree of freedom, a part of the old stages and the same of the new ones.
    fn see(&mut self, half: usize, d: usize, old: T, new: T);
}

impl<T> Observer<T> for () {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn see(&mut self, _half: usize, _d: usize, _old: T, _new: T) {}
}

/// What is computed with at once in numbers `S`: all stages of one path in the lanes of a register, or one stage.
pub(super) type Part<S, const N: usize> = <<S as Scalar>::Stages<N> as Stages<S, N>>::Part;

/// One number per stage.
pub trait Stages<S: Scalar, const N: usize>: Copy + Debug + Numbers {
    /// The numbers of some stages, as one.
    type Part: Scalar;
    /// How many of them there are.
    const PARTS: usize;

    /// The same for each stage.
    fn splat(number: S) -> Self;
    /// The number of stage `i`.
    fn get(&self, i: usize) -> S;
    /// Replaces the number of stage `i`.
    fn set(&mut self, i: usize, number: S);
    /// A part of them.
    fn part(&self, part: usize) -> Self::Part;
    /// Replaces a part of them.
    fn set_part(&mut self, part: usize, numbers: Self::Part);

    /// The same for each stage of a part.
    fn same(number: S) -> Self::Part;
    /// A constant for each stage of a part.
    fn constants(constants: &[f64; N], part: usize) -> Self::Part;
    /// Each stage of a part times a constant of its own.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn weighted(numbers: Self::Part, constants: &[f64; N], part: usize) -> Self::Part {
        numbers * Self::constants(constants, part)
    }
    /// The largest of a part, of which none is negative.
    fn largest(numbers: Self::Part) -> S;

    /// A part of each of a list, in the list itself or in the room.
    fn parts<'a>(list: &'a [Self], part: usize, room: &'a mut [Self::Part]) -> &'a [Self::Part];
    /// Where to write that: [`Stages::store`] brings it to the list.
    fn parts_mut<'a>(list: &'a mut [Self], room: &'a mut [Self::Part]) -> &'a mut [Self::Part];
    /// Replaces a part of each of a list by what [`Stages::parts_mut`] has, if that was the room; but not where they are to stay.
    fn store(list: &mut [Self], part: usize, room: &[Self::Part], stay: S::Mask);

    /// A part of `Σ_j matrix[j] self_j`: of column `j` of a matrix times the number of stage `j`.
    fn product(&self, matrix: &[[f64; N]; N], part: usize) -> Self::Part;

    /// `self + other`
    fn plus(mut self, other: Self) -> Self {
        (0..Self::PARTS).for_each(|part| self.set_part(part, self.part(part) + other.part(part)));
        self
    }
    /// `self - other`
    fn minus(mut self, other: Self) -> Self {
        (0..Self::PARTS).for_each(|part| self.set_part(part, self.part(part) - other.part(part)));
        self
    }
    /// `self` times a number for each stage.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn times(mut self, factors: &[f64; N]) -> Self {
        for part in 0..Self::PARTS {
            self.set_part(part, Self::weighted(self.part(part), factors, part));
        }
        self
    }
    /// `Σ_j matrix[j] self_j`
    fn products(&self, matrix: &[[f64; N]; N]) -> Self {
        let mut products = *self;
        (0..Self::PARTS).for_each(|part| products.set_part(part, self.product(matrix, part)));
        products
    }
    /// The sum over the stages.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn total(&self) -> S {
        let mut list = [S::from_f64(0.0); N];
        for (i, number) in list.iter_mut().enumerate() {
            *number = self.get(i);
        }
        in_pairs(list, |a, b| a + b)
    }

    /// The slopes of the step Hamiltonian at the stages of a part.
    #[expect(clippy::too_many_arguments, reason = "as `Field::step_slopes`")]
    fn slopes<F: Field, const BY_Q: bool, const BY_P: bool>(
        system: &F,
        t: Self::Part,
        h: Self::Part,
        q: &[Self::Part],
        p: &[Self::Part],
        dw: &[Self::Part],
        by_q: &mut [Self::Part],
        by_p: &mut [Self::Part],
        one: &mut One,
    );
}

/// All of a list as one, in pairs, so that few operations wait for one another.
#[cfg_attr(not(debug_assertions), inline(always))]
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

/// `Σ_j matrix[j][i] numbers[j]` in four sums, so that few additions wait for one another. They have names: arrays would be in memory.
#[cfg_attr(not(debug_assertions), inline(always))]
fn row<S: Scalar, const N: usize>(numbers: &[S; N], matrix: &[[f64; N]; N], i: usize) -> S {
    let term = |j: usize| numbers[j] * matrix[j][i];
    match N {
        1 => return term(0),
        2 => return term(0) + term(1),
        3 => return term(0) + term(1) + term(2),
        _ => {}
    }
    let (mut a, mut b, mut c, mut d) = (term(0), term(1), term(2), term(3));
    // Four at a time: a choice of the sum in each term would keep a compiler from writing many of them out.
    let mut j = 4;
    while j + 4 <= N {
        (a, b, c, d) = (a + term(j), b + term(j + 1), c + term(j + 2), d + term(j + 3));
        j += 4;
    }
    if j < N {
        a = a + term(j);
    }
    if j + 1 < N {
        b = b + term(j + 1);
    }
    if j + 2 < N {
        c = c + term(j + 2);
    }
    (a + b) + (c + d)
}

/// Room for one stage of a path whose stages are not evaluated at once.
#[derive(Clone, Debug, Default)]
pub struct One {
    lists: [Vec<f64>; 4],
    dw: Vec<f64>,
}

/// Room of a sweep.
#[derive(Debug)]
pub(super) struct Scratch<S: Scalar, H: Shape, W: Shape, const N: usize> {
    pub(super) parts: Parts<S, H, W, N>,
    pub(super) one: One,
}

/// Room for a part of the stages of each degree of freedom and noise.
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct Parts<S: Scalar, H: Shape, W: Shape, const N: usize> {
    pub(super) q: H::Of<Part<S, N>>,
    pub(super) p: H::Of<Part<S, N>>,
    pub(super) by_q: H::Of<Part<S, N>>,
    pub(super) by_p: H::Of<Part<S, N>>,
    pub(super) dw: W::Of<Part<S, N>>,
}

impl<S: Scalar, H: Shape, W: Shape, const N: usize> Scratch<S, H, W, N> {
    /// For so many degrees of freedom and noises. Where all stages are one part, it is the lists themselves that are computed with.
    pub(super) fn of_length(degrees: usize, noises: usize) -> Self {
        let is_needed = <S::Stages<N> as Stages<S, N>>::PARTS > 1;
        let (degrees, noises) = if is_needed { (degrees, noises) } else { (0, 0) };
        let zero = Part::<S, N>::from_f64(0.0);
        let list = || H::list(degrees, zero);
        let parts = Parts { q: list(), p: list(), by_q: list(), by_p: list(), dw: W::list(noises, zero) };
        Self { parts, one: One::default() }
    }

    /// Makes room for steps whose stages are evaluated one by one.
    pub(super) fn reserve(&mut self, degrees: usize, noises: usize) {
        self.one.lists.iter_mut().for_each(|list| list.reserve(degrees));
        self.one.dw.reserve(noises);
    }
}

impl<S: Scalar, H: Shape, W: Shape, const N: usize> Parts<S, H, W, N> {
    /// The room, for the duration of a sweep.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn take(&mut self) -> Self {
        let zero = Part::<S, N>::from_f64(0.0);
        let Self { q, p, by_q, by_p, dw } = self;
        Self {
            q: H::take(q, zero),
            p: H::take(p, zero),
            by_q: H::take(by_q, zero),
            by_p: H::take(by_p, zero),
            dw: W::take(dw, zero),
        }
    }

    /// Takes it back.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn give_back(&mut self, room: Self) {
        H::give_back(&mut self.q, room.q);
        H::give_back(&mut self.p, room.p);
        H::give_back(&mut self.by_q, room.by_q);
        H::give_back(&mut self.by_p, room.by_p);
        W::give_back(&mut self.dw, room.dw);
    }
}

/// All stages of one path.
impl<const N: usize> Stages<f64, N> for Lanes<N> {
    type Part = Self;
    const PARTS: usize = 1;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn splat(number: f64) -> Self {
        Self::new([number; N])
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn get(&self, i: usize) -> f64 {
        self[i]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set(&mut self, i: usize, number: f64) {
        Lanes::set(self, i, number);
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn part(&self, _part: usize) -> Self {
        *self
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_part(&mut self, _part: usize, numbers: Self) {
        *self = numbers;
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn same(number: f64) -> Self {
        Self::new([number; N])
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn constants(constants: &[f64; N], _part: usize) -> Self {
        Self::new(*constants)
    }
    /// As integers, which have the order of the numbers where these are not negative: the largest of many is found in any order, so in
    /// lanes.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn largest(numbers: Self) -> f64 {
        f64::from_bits(in_pairs(numbers.to_array().map(f64::to_bits), u64::max))
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn parts<'a>(list: &'a [Self], _part: usize, _room: &'a mut [Self]) -> &'a [Self] {
        list
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn parts_mut<'a>(list: &'a mut [Self], _room: &'a mut [Self]) -> &'a mut [Self] {
        list
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn store(_list: &mut [Self], _part: usize, _room: &[Self], _stay: bool) {}
    /// A loop over the stages with all columns in it: as many small loops each would be unrolled before they become vector code.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn product(&self, matrix: &[[f64; N]; N], _part: usize) -> Self {
        let numbers = self.to_array();
        let mut products = [0.0; N];
        for (i, product) in products.iter_mut().enumerate() {
            *product = row(&numbers, matrix, i);
        }
        Self::new(products)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn slopes<F: Field, const BY_Q: bool, const BY_P: bool>(
        system: &F,
        t: Self,
        h: Self,
        q: &[Self],
        p: &[Self],
        dw: &[Self],
        by_q: &mut [Self],
        by_p: &mut [Self],
        one: &mut One,
    ) {
        if F::IN_LANES {
            return system.step_slopes::<Self, BY_Q, BY_P>(t, h, q, p, dw, by_q, by_p);
        }
        let One { lists: [own_q, own_p, own_by_q, own_by_p], dw: own_dw } = one;
        for own in [&mut *own_q, own_p, own_by_q, own_by_p] {
            own.resize(q.len(), 0.0);
        }
        own_dw.resize(dw.len(), 0.0);
        for i in 0..N {
            for (own, all) in own_q.iter_mut().chain(&mut *own_p).zip(q.iter().chain(p)) {
                *own = all[i];
            }
            own_dw.iter_mut().zip(dw).for_each(|(own, all)| *own = all[i]);
            system.step_slopes::<f64, BY_Q, BY_P>(t[i], h[i], own_q, own_p, own_dw, own_by_q, own_by_p);
            if BY_Q {
                by_q.iter_mut().zip(&*own_by_q).for_each(|(all, own)| Lanes::set(all, i, *own));
            }
            if BY_P {
                by_p.iter_mut().zip(&*own_by_p).for_each(|(all, own)| Lanes::set(all, i, *own));
            }
        }
    }
}

/// Stage after stage: of paths beside each other, and of numbers that carry more than their value.
impl<S: Scalar, const N: usize> Stages<S, N> for [S; N] {
    type Part = S;
    const PARTS: usize = N;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn splat(number: S) -> Self {
        [number; N]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn get(&self, i: usize) -> S {
        self[i]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set(&mut self, i: usize, number: S) {
        self[i] = number;
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn part(&self, part: usize) -> S {
        self[part]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_part(&mut self, part: usize, numbers: S) {
        self[part] = numbers;
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn same(number: S) -> S {
        number
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn constants(constants: &[f64; N], part: usize) -> S {
        S::from_f64(constants[part])
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn weighted(numbers: S, constants: &[f64; N], part: usize) -> S {
        numbers * constants[part]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn largest(numbers: S) -> S {
        numbers
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn parts<'a>(list: &'a [Self], part: usize, room: &'a mut [S]) -> &'a [S] {
        for (own, all) in room.iter_mut().zip(list) {
            *own = all[part];
        }
        room
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn parts_mut<'a>(_list: &'a mut [Self], room: &'a mut [S]) -> &'a mut [S] {
        room
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn store(list: &mut [Self], part: usize, room: &[S], stay: S::Mask) {
        for (all, own) in list.iter_mut().zip(room) {
            all[part] = if S::IS_BESIDE { S::select(stay, all[part], *own) } else { *own };
        }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn product(&self, matrix: &[[f64; N]; N], part: usize) -> S {
        row(self, matrix, part)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn times(self, factors: &[f64; N]) -> Self {
        S::weighted(self, factors)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn slopes<F: Field, const BY_Q: bool, const BY_P: bool>(
        system: &F,
        t: S,
        h: S,
        q: &[S],
        p: &[S],
        dw: &[S],
        by_q: &mut [S],
        by_p: &mut [S],
        _one: &mut One,
    ) {
        system.step_slopes::<S, BY_Q, BY_P>(t, h, q, p, dw, by_q, by_p);
    }
}
