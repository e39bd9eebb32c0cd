//! Stores sums, and checks whether all of them are finite.

use std::array::from_fn;

use crate::algebra::state_sum::{FixedCompensatedSum, StateSum as _};

/// One compensated sum.
type EntrySum = FixedCompensatedSum<f64, 1>;

/// Number of lanes of the check.
const LANES: usize = 16;

/// Number of lanes of compensated sums, which use four registers for one of plain sums.
const LANES_COMPENSATED: usize = 8;

/// Whether all numbers are finite: zero times any of them is zero.
#[derive(Default)]
pub(super) struct Check([f64; LANES]);

/// Zero for each finite number.
#[cfg_attr(not(debug_assertions), inline(always))]
fn add_zeros(zeros: &mut [f64; LANES], numbers: &[f64; LANES]) {
    for i in 0..LANES {
        zeros[i] += numbers[i] * 0.0;
    }
}

impl Check {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn include(&mut self, numbers: &[f64]) {
        let (groups, rest) = numbers.as_chunks::<LANES>();
        let mut zeros = self.0;
        for group in groups {
            add_zeros(&mut zeros, group);
        }
        self.0 = zeros;
        for (zero, number) in self.0.iter_mut().zip(rest) {
            *zero += number * 0.0;
        }
    }

    /// `into = sum(base, term)`, one by one; without a base `into = sum(into, term)`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn store(
        &mut self,
        into: &mut [f64],
        base: Option<&[f64]>,
        terms: &[f64],
        sum: impl Fn(f64, f64) -> f64,
    ) {
        match base {
            Some(base) => self.combine::<false>(into, base, terms, sum),
            None => self.combine::<true>(into, &[], terms, sum),
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn combine<const IN_PLACE: bool>(
        &mut self,
        into: &mut [f64],
        base: &[f64],
        terms: &[f64],
        sum: impl Fn(f64, f64) -> f64,
    ) {
        let len = into.len();
        let (base, terms) = (if IN_PLACE { base } else { &base[..len] }, &terms[..len]);
        let (into, into_rest) = into.as_chunks_mut::<LANES>();
        let ((base, base_rest), (terms, terms_rest)) =
            (base.as_chunks::<LANES>(), terms.as_chunks::<LANES>());
        // A local copy, which stays in registers.
        let mut zeros = self.0;
        for (k, (into, terms)) in into.iter_mut().zip(terms).enumerate() {
            let base = if IN_PLACE { *into } else { base[k] };
            let mut new = [0.0; LANES];
            for i in 0..LANES {
                new[i] = sum(base[i], terms[i]);
            }
            *into = new;
            add_zeros(&mut zeros, &new);
        }
        self.0 = zeros;
        for (k, (into, &term)) in into_rest.iter_mut().zip(terms_rest).enumerate() {
            *into = sum(if IN_PLACE { *into } else { base_rest[k] }, term);
        }
        self.include(into_rest);
    }

    /// As [`Check::store`] of `base + term`, with compensated sums.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn store_compensated(
        &mut self,
        into: &mut [f64],
        base: Option<&[f64]>,
        terms: &[f64],
        lost: &mut [f64],
        term: impl Fn(f64) -> f64,
    ) {
        match base {
            Some(base) => self.compensate::<false>(into, base, terms, lost, term),
            None => self.compensate::<true>(into, &[], terms, lost, term),
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn compensate<const IN_PLACE: bool>(
        &mut self,
        into: &mut [f64],
        base: &[f64],
        terms: &[f64],
        lost: &mut [f64],
        term: impl Fn(f64) -> f64,
    ) {
        let len = into.len();
        let (base, terms) = (if IN_PLACE { base } else { &base[..len] }, &terms[..len]);
        let (into, into_rest) = into.as_chunks_mut::<LANES_COMPENSATED>();
        let (lost, lost_rest) = lost[..len].as_chunks_mut::<LANES_COMPENSATED>();
        let ((base, base_rest), (terms, terms_rest)) =
            (base.as_chunks::<LANES_COMPENSATED>(), terms.as_chunks::<LANES_COMPENSATED>());
        let mut zeros = [0.0; LANES_COMPENSATED];
        for (k, ((into, lost), terms)) in into.iter_mut().zip(lost).zip(terms).enumerate() {
            let (base, carried) = (if IN_PLACE { *into } else { base[k] }, *lost);
            // Each operation on all numbers before the next one, so that they stay in vector registers.
            let addend: [f64; LANES_COMPENSATED] = from_fn(|i| term(terms[i]) + carried[i]);
            let new: [f64; LANES_COMPENSATED] = from_fn(|i| base[i] + addend[i]);
            let taken_in: [f64; LANES_COMPENSATED] = from_fn(|i| new[i] - base[i]);
            let of_base: [f64; LANES_COMPENSATED] = from_fn(|i| base[i] - (new[i] - taken_in[i]));
            *lost = from_fn(|i| of_base[i] + (addend[i] - taken_in[i]));
            *into = new;
            for i in 0..LANES_COMPENSATED {
                zeros[i] += new[i] * 0.0;
            }
        }
        self.include(&zeros);
        for (k, ((into, lost), &number)) in into_rest.iter_mut().zip(lost_rest).zip(terms_rest).enumerate() {
            (*into, *lost) = EntrySum::add(if IN_PLACE { *into } else { base_rest[k] }, term(number), *lost);
        }
        self.include(into_rest);
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn is_finite(&self) -> bool {
        self.0.iter().sum::<f64>() == 0.0
    }
}
