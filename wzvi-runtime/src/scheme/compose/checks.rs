//! Checks of weights at compile time.

use super::{Partitioned, Weights};

/// Stops the compiler with an error message unless the weights make a composition.
///
/// `const _: () = check_weights::<Own>();` runs the check where the weights are defined.
///
/// # Panics
/// At compile time, unless the weights are a palindrome, sum to 1, and the sums of their odd powers below the
/// order vanish.
pub const fn check_weights<W: Weights>() {
    assert!(is_palindrome(W::GAMMA), "the weights of a composition must be a palindrome");
    assert!(has_sum_one(W::GAMMA), "the weights of a composition must sum to 1");
    assert!(
        has_order(W::GAMMA, W::ORDER),
        "the sums of the odd powers of the weights below their order must vanish"
    );
}

/// Checks the coefficients of a splitting.
///
/// # Panics
/// At compile time, unless the coefficients are a palindrome of odd length, and those of drifts and those of
/// kicks each sum to 1.
pub const fn check_table<W: Partitioned>() {
    assert!(is_palindrome(W::SEQUENCE), "the coefficients of a splitting must be a palindrome");
    assert!(W::SEQUENCE.len() % 2 == 1, "a splitting starts and ends with the same part");
    assert!(have_sums_one(W::SEQUENCE), "the coefficients of drifts and of kicks must sum to 1 each");
}

/// Whether a list reads the same backwards, to the last bit.
const fn is_palindrome(list: &[f64]) -> bool {
    let mut i = 0;
    while i < list.len() {
        if list[i].to_bits() != list[list.len() - 1 - i].to_bits() {
            return false;
        }
        i += 1;
    }
    !list.is_empty()
}

/// `Σ γ^power` and `Σ |γ|^power`.
const fn power_sums(list: &[f64], power: u32) -> (f64, f64) {
    let (mut sum, mut size) = (0.0, 0.0);
    let mut i = 0;
    while i < list.len() {
        let mut term = 1.0;
        let mut k = 0;
        while k < power {
            term *= list[i];
            k += 1;
        }
        sum += term;
        size += if term < 0.0 { -term } else { term };
        i += 1;
    }
    (sum, size)
}

/// Bound on the rounding error of `length` weights, their powers and their sum, relative to the sum of
/// magnitudes.
const fn rounding(length: usize, power: u32) -> f64 {
    (length as f64 + 2.0 * power as f64) * f64::EPSILON
}

/// Whether the sum is 1 up to rounding.
const fn has_sum_one(list: &[f64]) -> bool {
    let (sum, size) = power_sums(list, 1);
    is_one(sum, size, list.len())
}

/// Whether the numbers with even index, and those with odd index, each sum to 1 up to rounding.
const fn have_sums_one(list: &[f64]) -> bool {
    let (mut sums, mut sizes) = ([0.0; 2], [0.0; 2]);
    let mut i = 0;
    while i < list.len() {
        sums[i % 2] += list[i];
        sizes[i % 2] += if list[i] < 0.0 { -list[i] } else { list[i] };
        i += 1;
    }
    is_one(sums[0], sizes[0], list.len()) && is_one(sums[1], sizes[1], list.len())
}

const fn is_one(sum: f64, size: f64, length: usize) -> bool {
    let error = if sum < 1.0 { 1.0 - sum } else { sum - 1.0 };
    error <= rounding(length, 1) * size
}

/// `Σ γ^3 = 0` for order 4, `Σ γ^5 = 0` as well for order 6, and so on.
const fn has_order(list: &[f64], order: u32) -> bool {
    let mut power = 3;
    while power < order {
        let (sum, size) = power_sums(list, power);
        let error = if sum < 0.0 { -sum } else { sum };
        if error > rounding(list.len(), power) * size {
            return false;
        }
        power += 2;
    }
    order >= 1
}
