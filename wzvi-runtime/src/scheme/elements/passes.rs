//! Passes over whole vectors: corrections, their sizes, sums.

use super::Unknowns;
use super::lanes::{is_in_lanes, subtract_in_lanes};
use crate::algebra::scalar::{Mask, Scalar};
use crate::algebra::solve::relative_to;

/// `x -= correction`; returns the largest correction relative to the largest unknown of its kind, NaN if a
/// correction is not finite: of all parts of the numbers, or of each path side by side.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn subtract<S: Scalar>(kind: Unknowns, x: &mut [S], correction: &[S]) -> S {
    if const { is_in_lanes::<S>() } {
        return subtract_in_lanes(kind, x, correction);
    }
    let (mut size, mut change) = (Largest::<LANES>::default(), Largest::<LANES>::default());
    let (chunks, rest) = x.as_chunks_mut::<LANES>();
    let (corrections, other) = correction.as_chunks::<LANES>();
    for (x, c) in chunks.iter_mut().zip(corrections) {
        let (old, c) = (*x, *c);
        let new = std::array::from_fn(|lane| old[lane] - c[lane]);
        *x = new;
        // A number that is not finite comes from the correction, or is found in the new state.
        size.take_finite(&new);
        change.include(&c);
    }
    // With both kinds of unknowns the rest is even, so that pairs stay together.
    let (pairs, single) = rest.as_chunks_mut::<2>();
    let (other, last) = other.as_chunks::<2>();
    for (x, c) in pairs.iter_mut().zip(other) {
        *x = [x[0] - c[0], x[1] - c[1]];
        size.take_finite(x);
        change.include(c);
    }
    for (x, &c) in single.iter_mut().zip(last) {
        *x = *x - c;
        size.take_finite(&[*x]);
        change.include(&[c]);
    }
    S::from_f64(relate(kind, x, correction, [size.by_kind(kind), change.by_kind(kind)]))
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn relate<S: Scalar>(kind: Unknowns, x: &[S], correction: &[S], [sizes, changes]: [[f64; 2]; 2]) -> f64 {
    if !changes.iter().all(|change| change.is_finite()) {
        return f64::NAN;
    }
    let mut relative = relative_to(changes[0], sizes[0]);
    if kind == Unknowns::Both {
        relative = relative.max(relative_to(changes[1], sizes[1]));
    }
    if size_of::<S>() != size_of::<f64>() {
        // Numbers that carry derivatives or lanes must converge in every part.
        for (k, (&x, &c)) in x.iter().zip(correction).enumerate() {
            if c.magnitude() != 0.0 || !(relative_to(c, x) == 0.0) {
                let part = relative_to(c, x.abs() + sizes[k % 2]);
                relative = if part > relative || part.is_nan() { part } else { relative };
            }
        }
    }
    relative
}

/// Work on `N` adjacent entries of lists.
///
/// It first reads all its input, then applies each operation to all entries, and stores last, so that the
/// compiler keeps the entries in vector registers. Several operations on one entry after the other would be
/// split into scalars.
pub(super) trait LoopBody {
    /// The work on the entries from `first` on.
    fn apply<const N: usize>(&mut self, first: usize);
}

/// Does the work on all `length` entries: `L` at a time, and the rest one by one.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn in_blocks<const L: usize>(length: usize, block: &mut impl LoopBody) {
    for number in 0..length / L {
        block.apply::<L>(number * L);
    }
    for first in length / L * L..length {
        block.apply::<1>(first);
    }
}

/// Reads adjacent entries of a list.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn load<S: Copy, const N: usize>(list: &[S], first: usize) -> [S; N] {
    let list = &list[first..first + N];
    let mut entries = [list[0]; N];
    entries.copy_from_slice(list);
    entries
}

/// Writes adjacent entries of a list.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn store<S: Copy, const N: usize>(list: &mut [S], first: usize, entries: [S; N]) {
    list[first..first + N].copy_from_slice(&entries);
}

/// The numbers, padded with zeros.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn widened<const N: usize, const L: usize>(numbers: [f64; N]) -> [f64; L] {
    std::array::from_fn(|i| if i < N { numbers[i] } else { 0.0 })
}

/// Zero for a finite magnitude. As bits, because the compiler would otherwise interleave these sums with
/// others and split the lanes of both.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn poisoned(magnitude: f64) -> u64 {
    (magnitude * 0.0).to_bits()
}

/// Number of lanes, few enough for the registers of x86-64.
const LANES: usize = 4;

/// The largest magnitude, in independent lanes.
pub(super) struct Largest<const L: usize> {
    most: [f64; L],
    /// Non-zero after a number that is not finite, which a maximum may lose.
    poison: [u64; L],
}

impl<const L: usize> Default for Largest<L> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn default() -> Self {
        Self { most: [0.0; L], poison: [0; L] }
    }
}

impl<const L: usize> Largest<L> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn include<S: Scalar, const N: usize>(&mut self, numbers: &[S; N]) {
        self.take_finite(numbers);
        let (numbers, mut poison): ([f64; L], _) = (widened(numbers.map(S::magnitude)), self.poison);
        for i in 0..L {
            poison[i] |= poisoned(numbers[i]);
        }
        self.poison = poison;
    }

    /// [`Largest::take`] without the check for finite numbers.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn take_finite<S: Scalar, const N: usize>(&mut self, numbers: &[S; N]) {
        let (sizes, mut most): ([f64; L], _) = (widened(numbers.map(S::magnitude)), self.most);
        for i in 0..L {
            most[i] = if sizes[i] > most[i] { sizes[i] } else { most[i] };
        }
        self.most = most;
    }

    /// NaN if any was NaN or infinite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn get(self) -> f64 {
        self.by_kind(Unknowns::Momenta)[0]
    }

    /// The maxima over coordinates and over momenta, which have different units, if the list alternates
    /// between them; otherwise twice the overall maximum. NaN if any number was NaN or infinite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn by_kind(self, kind: Unknowns) -> [f64; 2] {
        let larger = |a: f64, b: f64| if a > b { a } else { b };
        if self.poison.iter().any(|&poison| poison != 0) {
            return [f64::NAN; 2];
        }
        // Opaque, since the compiler else cuts the lanes of the pass as the pairs below would have them, down
        // to two numbers.
        let most = std::hint::black_box(self.most);
        let (mut even, mut odd) = (0.0, 0.0);
        for pair in most.as_chunks::<2>().0 {
            (even, odd) = (larger(even, pair[0]), larger(odd, pair[1]));
        }
        if kind == Unknowns::Both { [even, odd] } else { [larger(even, odd); 2] }
    }
}

/// The largest magnitude of each kind; NaN if any is not finite.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn largest<S: Scalar>(kind: Unknowns, x: &[S]) -> [f64; 2] {
    let mut largest = Largest::<LANES>::default();
    let (chunks, rest) = x.as_chunks::<LANES>();
    chunks.iter().for_each(|chunk| largest.include(chunk));
    let (pairs, single) = rest.as_chunks::<2>();
    pairs.iter().for_each(|pair| largest.include(pair));
    single.iter().for_each(|&x| largest.include(&[x]));
    largest.by_kind(kind)
}

/// Whether numbers have several parts, which already are adjacent: arrays of such numbers would be copied in
/// memory.
#[cfg_attr(not(debug_assertions), inline(always))]
fn has_parts<S>() -> bool {
    size_of::<S>() != size_of::<f64>()
}

/// `sums += base`, and whether every part of every sum is finite.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn add<S: Scalar>(sums: &mut [S], base: &[S]) -> bool {
    if has_parts::<S>() {
        let mut zero = S::from_f64(0.0);
        for (sum, &base) in sums.iter_mut().zip(base) {
            *sum = base + *sum;
            zero = zero + *sum * 0.0;
        }
        return zero.is_finite().all();
    }
    let mut zeros = [S::from_f64(0.0); LANES];
    let (chunks, rest) = sums.as_chunks_mut::<LANES>();
    let (bases, other) = base.as_chunks::<LANES>();
    for (sum, base) in chunks.iter_mut().zip(bases) {
        let new = std::array::from_fn(|lane| base[lane] + sum[lane]);
        *sum = new;
        zeros = std::array::from_fn(|lane| zeros[lane] + new[lane] * 0.0);
    }
    for (sum, &base) in rest.iter_mut().zip(other) {
        *sum = base + *sum;
    }
    are_zero(zeros, rest)
}

/// Whether every part of every number is finite.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn are_finite<S: Scalar>(numbers: &[S]) -> bool {
    // Loops: in `fold` the closure would be compiled without the instructions of the lanes.
    if has_parts::<S>() {
        let mut zero = S::from_f64(0.0);
        for &number in numbers {
            zero = zero + number * 0.0;
        }
        return zero.is_finite().all();
    }
    // Integers may be combined in any order, sums of numbers not. One more in the exponent sets the sign of
    // what is not finite, and of nothing else.
    let mut overflow = 0;
    for &number in numbers {
        overflow |= number.magnitude().to_bits() + (1 << (f64::MANTISSA_DIGITS - 1));
    }
    overflow >> 63 == 0
}

/// Whether the sums of products with zero are zero and the rest is finite: infinity or NaN times zero is NaN.
#[cfg_attr(not(debug_assertions), inline(always))]
fn are_zero<S: Scalar>([a, b, c, d]: [S; LANES], rest: &[S]) -> bool {
    let zero = rest.iter().fold((a + b) + (c + d), |zero, &number| zero + number * 0.0);
    zero.is_finite().all()
}
