//! Deviations at the start of a run.

use super::frame::{dot, orthogonalise};
use crate::error::{ConfigError, wrong};

/// Orthonormal deviations in directions without symmetry, after a projection.
pub(super) fn generic(
    number: usize,
    length: usize,
    project: impl FnMut(&mut Vec<f64>),
) -> Result<Vec<Vec<f64>>, ConfigError> {
    let mut list: Vec<Vec<f64>> = (0..number).map(|k| direction(k as u64, length)).collect();
    list.iter_mut().for_each(project);
    let mut deviations = checked(list, length)?;
    for k in 0..number {
        let (before, [deviation, ..]) = deviations.split_at_mut(k) else { continue };
        orthogonalise(before, deviation);
        normalise(deviation);
    }
    Ok(deviations)
}

/// A direction of its own for each number: entries in `(-1, 1)` by the mixing function of SplitMix64 (G. L.
/// Steele, D. Lea, C. H. Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014).
pub(super) fn direction(number: u64, length: usize) -> Vec<f64> {
    let entry = |place: usize| {
        let mut x = (number << 32 | place as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^= x >> 31;
        // An odd number over 2^53: never zero.
        ((x >> 11) as f64 + 0.5) / (1_u64 << 52) as f64 - 1.0
    };
    (0..length).map(entry).collect()
}

/// Divides by the length; zeros stay.
fn normalise(deviation: &mut [f64]) {
    // First by the largest entry, whose square may be out of range.
    for size in [
        |list: &[f64]| list.iter().fold(0.0, |size: f64, x| size.max(x.abs())),
        |list: &[f64]| dot(list, list).sqrt(),
    ] {
        let size = size(deviation);
        if size > 0.0 {
            deviation.iter_mut().for_each(|x| *x /= size);
        }
    }
}

/// These deviations, of length one.
///
/// # Errors
/// [`ConfigError::Setting`] for one of another length, that is not finite, zero, or a sum of those before it.
pub(super) fn checked(mut deviations: Vec<Vec<f64>>, length: usize) -> Result<Vec<Vec<f64>>, ConfigError> {
    let mut frame: Vec<Vec<f64>> = Vec::new();
    for (number, deviation) in deviations.iter_mut().enumerate() {
        if deviation.len() != length {
            return wrong(format!(
                "deviation {number} has {} entries: it needs {length}, one for each coordinate and then one for each momentum",
                deviation.len()
            ));
        }
        if let Some(entry) = deviation.iter().find(|entry| !entry.is_finite()) {
            return wrong(format!("deviation {number} has the entry {entry}: take finite numbers"));
        }
        if deviation.iter().all(|entry| *entry == 0.0) {
            return wrong(format!("deviation {number} is zero, and has no direction: leave it out"));
        }
        normalise(deviation);
        let mut own = deviation.clone();
        let rest = orthogonalise(&frame, &mut own);
        // Rounding leaves so much of a unit vector whose parts along as many others are subtracted.
        if rest <= 4.0 * f64::EPSILON * length as f64 {
            return wrong(format!(
                "deviation {number} is a sum of multiples of those before it: leave it out"
            ));
        }
        own.iter_mut().for_each(|x| *x /= rest);
        frame.push(own);
    }
    Ok(deviations)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn generic_deviations_are_orthonormal_and_full() {
        for (number, length) in [(1, 2), (2, 2), (4, 4), (6, 6), (4, 2000)] {
            let deviations = generic(number, length, |_| {}).unwrap();
            for (i, a) in deviations.iter().enumerate() {
                assert!(a.iter().all(|x| x.abs() > 1e-6 / (length as f64).sqrt()));
                for (j, b) in deviations.iter().enumerate() {
                    assert!((dot(a, b) - f64::from(i == j)).abs() < 1e-14, "{i} {j}");
                }
            }
        }
    }

    #[test]
    fn deviations_that_are_none_are_refused() {
        let checked = |list: &[[f64; 2]]| checked(list.iter().map(|d| d.to_vec()).collect(), 2);
        let refused = |list: &[[f64; 2]], part: &str| {
            let message = checked(list).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        };
        refused(&[[1.0, f64::NAN]], "deviation 0 has the entry NaN");
        refused(&[[1.0, 0.0], [0.0, 0.0]], "deviation 1 is zero");
        refused(&[[1.0, 0.3], [-2.0, -0.6]], "deviation 1 is a sum");
        refused(&[[1e300, 3e299], [1e-300, 3e-301]], "deviation 1 is a sum");
        let lengths = [[3e200, 4e200], [1e-310, 0.0]];
        assert!(checked(&lengths).unwrap().iter().all(|d| (dot(d, d) - 1.0).abs() < 1e-15));
    }
}
