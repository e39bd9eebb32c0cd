//! Quantiles of Student's t, and how far means of one law lie apart.

use crate::algebra::scalar::Scalar;

/// The quantile 0.975 of a normal.
pub(crate) const NORMAL: f64 = 1.959_963_984_540_054;

/// The quantile 0.975 of Student's t with so many degrees of freedom: exact for one and two, otherwise by its
/// expansion about that of a normal (M. Abramowitz, I. A. Stegun, *Handbook of Mathematical Functions*,
/// 26.7.5), to 1 % from three on and to 1e-4 from ten on.
pub(crate) fn quantile(degrees: f64) -> f64 {
    if degrees <= 1.0 {
        return Scalar::tan(0.475 * std::f64::consts::PI);
    }
    if degrees <= 2.0 {
        return 0.95 * f64::sqrt(2.0 / (1.0 - 0.95 * 0.95));
    }
    let (x, y) = (NORMAL, NORMAL * NORMAL);
    let terms = [
        x,
        x * (y + 1.0) / 4.0,
        x * ((5.0 * y + 16.0) * y + 3.0) / 96.0,
        x * (((3.0 * y + 19.0) * y + 17.0) * y - 15.0) / 384.0,
    ];
    terms.iter().rev().fold(0.0, |sum, term| term + sum / degrees)
}

/// A ratio of two variances with so many degrees of freedom as a normal number, large where the first is too
/// large (E. Paulson, "An approximate normalization of the analysis of variance distribution", Ann. Math.
/// Statist. 13, 1942).
pub(crate) fn normal_of_ratio(ratio: f64, [first, second]: [f64; 2]) -> f64 {
    let (a, b, root) = (2.0 / (9.0 * first), 2.0 / (9.0 * second), Scalar::cbrt(ratio));
    ((1.0 - b) * root - (1.0 - a)) / (a + b * root * root).sqrt()
}

#[cfg(test)]
mod tests {
    use super::{normal_of_ratio, quantile};

    #[test]
    fn quantiles_are_those_of_tables() {
        for (degrees, t, error) in [
            (1.0, 12.706, 1e-3),
            (2.0, 4.303, 1e-3),
            (3.0, 3.182, 0.03),
            (13.0, 2.1604, 1e-4),
            (1e9, 1.95996, 1e-5),
        ] {
            assert!((quantile(degrees) - t).abs() < error, "{degrees} {}", quantile(degrees));
        }
        // The quantile 0.95 of F.
        for (ratio, degrees) in [(4.24, [1.0, 25.0]), (2.49, [5.0, 30.0]), (2.87, [4.0, 20.0])] {
            assert!(
                (normal_of_ratio(ratio, degrees) - 1.645).abs() < 0.03,
                "{}",
                normal_of_ratio(ratio, degrees)
            );
        }
    }
}
