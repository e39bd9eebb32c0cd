//! Stores sums, and checks whether all of them are finite.

/// Number of lanes of the check.
const BESIDE: usize = 16;

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

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn is_finite(&self) -> bool {
        self.0.iter().sum::<f64>() == 0.0
    }
}
