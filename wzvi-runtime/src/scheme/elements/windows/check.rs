//! Stores sums, and checks whether all of them are finite.

use std::array::from_fn;

use crate::algebra::carry::{Carry as _, Compensation};

/// One compensated sum.
type Sum = Compensation<f64, 1>;

/// Number of lanes of the check.
const BESIDE: usize = 16;

/// Number of lanes of compensated sums, which use four registers for one of plain sums.
const FEWER: usize = 8;

/// Whether all numbers are finite: zero times any of them is zero.
#[derive(Default)]
pub(super) struct Check([f64; BESIDE]);

/// Zero for each finite number.
#[cfg_attr(not(debug_assertions), inline(always))]
fn add_zeros(zeros: &mut [f64; BESIDE], numbers: &[f64; BESIDE]) {
    for i in 0..BESIDE {
        zeros[i] += numbers[i] * 0.0;
    }
}

impl Check {
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn look(&mut self, numbers: &[f64]) {
        let (groups, rest) = numbers.as_chunks::<BESIDE>();
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
        let (into, into_rest) = into.as_chunks_mut::<BESIDE>();
        let ((base, base_rest), (terms, terms_rest)) =
            (base.as_chunks::<BESIDE>(), terms.as_chunks::<BESIDE>());
        // A local copy, which stays in registers.
        let mut zeros = self.0;
        for (k, (into, terms)) in into.iter_mut().zip(terms).enumerate() {
            let base = if IN_PLACE { *into } else { base[k] };
            let mut new = [0.0; BESIDE];
            for i in 0..BESIDE {
                new[i] = sum(base[i], terms[i]);
            }
            *into = new;
            add_zeros(&mut zeros, &new);
        }
        self.0 = zeros;
        for (k, (into, &term)) in into_rest.iter_mut().zip(terms_rest).enumerate() {
            *into = sum(if IN_PLACE { *into } else { base_rest[k] }, term);
        }
        self.look(into_rest);
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
        let (into, into_rest) = into.as_chunks_mut::<FEWER>();
        let (lost, lost_rest) = lost[..len].as_chunks_mut::<FEWER>();
        let ((base, base_rest), (terms, terms_rest)) =
            (base.as_chunks::<FEWER>(), terms.as_chunks::<FEWER>());
        let mut zeros = [0.0; FEWER];
        for (k, ((into, lost), terms)) in into.iter_mut().zip(lost).zip(terms).enumerate() {
            let (base, carried) = (if IN_PLACE { *into } else { base[k] }, *lost);
            // Each operation on all numbers before the next one, so that they stay in vector registers.
            let addend: [f64; FEWER] = from_fn(|i| term(terms[i]) + carried[i]);
            let new: [f64; FEWER] = from_fn(|i| base[i] + addend[i]);
            let taken_in: [f64; FEWER] = from_fn(|i| new[i] - base[i]);
            let of_base: [f64; FEWER] = from_fn(|i| base[i] - (new[i] - taken_in[i]));
            *lost = from_fn(|i| of_base[i] + (addend[i] - taken_in[i]));
            *into = new;
            for i in 0..FEWER {
                zeros[i] += new[i] * 0.0;
            }
        }
        self.look(&zeros);
        for (k, ((into, lost), &number)) in into_rest.iter_mut().zip(lost_rest).zip(terms_rest).enumerate() {
            (*into, *lost) = Sum::add(if IN_PLACE { *into } else { base_rest[k] }, term(number), *lost);
        }
        self.look(into_rest);
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn is_finite(&self) -> bool {
        self.0.iter().sum::<f64>() == 0.0
    }
}
