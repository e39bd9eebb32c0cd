//! The numbers of all stages of a step, and the parts that are processed at once.

use std::fmt::Debug;

use super::lanes::Lanes;
use super::scalar::Scalar;
use crate::ground::numbers::Numbers;

/// One number per stage.
pub trait Stages<S: Scalar, const N: usize>: Copy + Debug + Numbers {
    /// The numbers of some stages, as one.
    type Part: Scalar;
    /// How many of them there are.
    const PARTS: usize;

    /// One number for all stages.
    fn splat(number: S) -> Self;
    /// The number of stage `i`.
    fn get(&self, i: usize) -> S;
    /// Replaces the number of stage `i`.
    fn set(&mut self, i: usize, number: S);
    /// A part of them.
    fn part(&self, part: usize) -> Self::Part;
    /// Replaces a part of them.
    fn set_part(&mut self, part: usize, numbers: Self::Part);

    /// Parts as numbers, if they are: one stage each.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn numbers(_parts: &[Self::Part]) -> Option<&[S]> {
        None
    }
    /// The numbers of the stages, to be written.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn numbers_mut(_parts: &mut [Self::Part]) -> Option<&mut [S]> {
        None
    }

    /// One number for all stages of a part.
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
    /// The place to write such parts to: [`Stages::store`] brings them to the list.
    fn parts_mut<'a>(list: &'a mut [Self], room: &'a mut [Self::Part]) -> &'a mut [Self::Part];
    /// Writes a part of each of a list back from [`Stages::parts_mut`], if that used the work space; not
    /// where they are to stay.
    fn store(list: &mut [Self], part: usize, room: &[Self::Part], stay: S::Mask);

    /// A part of `Σ_j matrix[j] self_j`: of column `j` of a matrix times the number of stage `j`.
    fn product(&self, matrix: &[[f64; N]; N], part: usize) -> Self::Part;

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
        in_pairs::<_, Added, N>(list)
    }
}

/// `a + b`
pub fn plus<T: Stages<S, N>, S: Scalar, const N: usize>(mut a: T, b: T) -> T {
    (0..T::PARTS).for_each(|part| a.set_part(part, a.part(part) + b.part(part)));
    a
}

/// `a - b`
pub fn minus<T: Stages<S, N>, S: Scalar, const N: usize>(mut a: T, b: T) -> T {
    (0..T::PARTS).for_each(|part| a.set_part(part, a.part(part) - b.part(part)));
    a
}

/// Joins two numbers to one. A closure, which is called for each pair, would be compiled for the baseline.
trait Join<T> {
    fn join(a: T, b: T) -> T;
}

/// `a + b`
struct Added;

impl<S: Scalar> Join<S> for Added {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn join(a: S, b: S) -> S {
        a + b
    }
}

/// The larger one of two numbers.
struct Larger;

impl Join<f64> for Larger {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn join(a: f64, b: f64) -> f64 {
        if a > b { a } else { b }
    }
}

/// All of a list as one, in pairs, so that few operations wait for one another.
#[cfg_attr(not(debug_assertions), inline(always))]
fn in_pairs<T: Copy, J: Join<T>, const N: usize>(mut list: [T; N]) -> T {
    let mut length = N;
    while length > 1 {
        let half = length / 2;
        for i in 0..half {
            list[i] = J::join(list[i], list[i + length - half]);
        }
        length -= half;
    }
    list[0]
}

/// `matrix[j][i] numbers[j]`. A closure, which is called in many places, would be compiled for the baseline.
#[cfg_attr(not(debug_assertions), inline(always))]
fn term<S: Scalar, const N: usize>(numbers: &[S; N], matrix: &[[f64; N]; N], i: usize, j: usize) -> S {
    numbers[j] * matrix[j][i]
}

/// `Σ_j matrix[j][i] numbers[j]` in four sums, so that few additions wait for one another. They have names:
/// arrays would be in memory.
#[cfg_attr(not(debug_assertions), inline(always))]
fn row<S: Scalar, const N: usize>(numbers: &[S; N], matrix: &[[f64; N]; N], i: usize) -> S {
    match N {
        1 => return term(numbers, matrix, i, 0),
        2 => return term(numbers, matrix, i, 0) + term(numbers, matrix, i, 1),
        3 => return term(numbers, matrix, i, 0) + term(numbers, matrix, i, 1) + term(numbers, matrix, i, 2),
        _ => {}
    }
    let (mut a, mut b, mut c, mut d) = (
        term(numbers, matrix, i, 0),
        term(numbers, matrix, i, 1),
        term(numbers, matrix, i, 2),
        term(numbers, matrix, i, 3),
    );
    // Four at a time: a choice of the sum in each term would prevent unrolling.
    let mut j = 4;
    while j + 4 <= N {
        (a, b, c, d) = (
            a + term(numbers, matrix, i, j),
            b + term(numbers, matrix, i, j + 1),
            c + term(numbers, matrix, i, j + 2),
            d + term(numbers, matrix, i, j + 3),
        );
        j += 4;
    }
    if j < N {
        a = a + term(numbers, matrix, i, j);
    }
    if j + 1 < N {
        b = b + term(numbers, matrix, i, j + 1);
    }
    if j + 2 < N {
        c = c + term(numbers, matrix, i, j + 2);
    }
    (a + b) + (c + d)
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
    /// By one instruction for several pairs, in every set of instructions, unlike the maximum of integers.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn largest(numbers: Self) -> f64 {
        in_pairs::<_, Larger, N>(numbers.to_array())
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
    /// A loop over the stages with all columns in it: as many small loops each would be unrolled before they
    /// become vector code. Five to eight stages are unrolled in any case, and then the compiler takes the
    /// terms of one stage for a vector, which it gathers; so their four sums come first, each for all stages.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn product(&self, matrix: &[[f64; N]; N], _part: usize) -> Self {
        let numbers = self.to_array();
        let mut products = [0.0; N];
        if N > 4 && N <= 8 {
            let mut sums = [[0.0; N]; 4];
            for (j, sum) in sums.iter_mut().enumerate() {
                for i in 0..N {
                    sum[i] = numbers[j] * matrix[j][i];
                    if j + 4 < N {
                        sum[i] += numbers[j + 4] * matrix[j + 4][i];
                    }
                }
            }
            // No instruction: a point that the compiler moves no vector across.
            std::hint::black_box(());
            for (i, product) in products.iter_mut().enumerate() {
                *product = (sums[0][i] + sums[1][i]) + (sums[2][i] + sums[3][i]);
            }
            return Self::new(products);
        }
        for (i, product) in products.iter_mut().enumerate() {
            *product = row(&numbers, matrix, i);
        }
        Self::new(products)
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
    fn numbers(parts: &[S]) -> Option<&[S]> {
        Some(parts)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn numbers_mut(parts: &mut [S]) -> Option<&mut [S]> {
        Some(parts)
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
            all[part] = if S::LANES_ARE_PATHS { S::select(stay, all[part], *own) } else { *own };
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
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The stages of one path are summed in the order in which those of paths beside each other are, to the
    /// last bit, for each number of stages: the sums of five to eight stages are written in another way.
    #[test]
    fn products_of_stages_are_those_of_paths() {
        fn check<const N: usize>() {
            // Numbers of all sizes, so that another order of a sum rounds differently.
            let number = |k: usize| (0.7 * k as f64).sin() * 10_f64.powi((k * k % 7) as i32 - 3);
            let numbers: [f64; N] = std::array::from_fn(|j| number(j + 1));
            let matrix: [[f64; N]; N] =
                std::array::from_fn(|j| std::array::from_fn(|i| number(17 * j + i + 3)));
            let product = Lanes::new(numbers).product(&matrix, 0);
            for i in 0..N {
                let own = Stages::<f64, N>::product(&numbers, &matrix, i);
                assert_eq!(Stages::get(&product, i).to_bits(), own.to_bits(), "{N} stages, stage {i}");
            }
            let sizes = Lanes::new(numbers.map(f64::abs));
            let largest = numbers.iter().fold(0.0, |largest: f64, number| largest.max(number.abs()));
            assert_eq!(<Lanes<N> as Stages<f64, N>>::largest(sizes), largest, "{N} stages");
        }
        check::<1>();
        check::<2>();
        check::<3>();
        check::<4>();
        check::<5>();
        check::<6>();
        check::<7>();
        check::<8>();
        check::<9>();
        check::<12>();
        check::<16>();
    }
}
