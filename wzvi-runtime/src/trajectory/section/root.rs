//! Zeros and minima of a function of one variable between two points.

use crate::algebra::scalar::Scalar;

/// Zeros are found to this absolute error of a variable between 0 and 1.
const TOLERANCE: f64 = f64::EPSILON;
/// A minimum is where the function differs from it by rounding only.
const FLAT: f64 = 1e-8;
/// The golden section.
const GOLDEN: f64 = 0.381_966_011_250_105_1;

/// The zero of `f` between two points of `0 ≤ x ≤ 1` at which it has values of different signs.
///
/// By the method ITP, which is as fast as the secant method and never takes more steps than one more than
/// bisection (I. F. D. Oliveira, R. H. C. Takahashi, "An enhancement of the bisection method average
/// performance preserving minmax optimality", ACM Trans. Math. Softw. 47, 2020).
pub(crate) fn root(
    [mut a, mut b]: [f64; 2],
    [mut at_a, mut at_b]: [f64; 2],
    mut f: impl FnMut(f64) -> f64,
) -> f64 {
    let length = b - a;
    let sign = at_b.signum();
    let mut radius = TOLERANCE * Scalar::exp2(Scalar::log2(length / TOLERANCE).ceil() + 1.0);
    while b - a > 2.0 * TOLERANCE {
        let middle = a + 0.5 * (b - a);
        let secant = (at_b * a - at_a * b) / (at_b - at_a);
        let truncation = 0.2 / length * (b - a) * (b - a);
        let (side, distance) = ((middle - secant).signum(), (middle - secant).abs());
        // Also where the secant is NaN.
        let towards = if truncation <= distance { secant + side * truncation } else { middle };
        let allowed = radius - 0.5 * (b - a);
        let x = if (towards - middle).abs() <= allowed { towards } else { middle - side * allowed };
        // The rest of the interval may be shorter than the distance of two numbers.
        let x = if x > a && x < b { x } else { middle };
        if !(x > a && x < b) {
            break;
        }
        let at_x = f(x);
        if sign * at_x > 0.0 {
            (b, at_b) = (x, at_x);
        } else if sign * at_x < 0.0 {
            (a, at_a) = (x, at_x);
        } else {
            // Zero; or NaN, between two numbers, and then nothing is nearer.
            return x;
        }
        radius *= 0.5;
    }
    if at_a.abs() < at_b.abs() { a } else { b }
}

/// A point inside at which `f` is negative, and its value there; `None` if there is none near its minimum, by
/// golden sections.
pub(super) fn lowest([mut a, mut b]: [f64; 2], mut f: impl FnMut(f64) -> f64) -> Option<(f64, f64)> {
    let (mut x, mut y) = (a + GOLDEN * (b - a), b - GOLDEN * (b - a));
    let (mut at_x, mut at_y) = (f(x), f(y));
    loop {
        for (point, value) in [(x, at_x), (y, at_y)] {
            if value < 0.0 {
                return Some((point, value));
            }
        }
        if b - a < FLAT {
            return None;
        }
        if at_x < at_y {
            (b, y, at_y) = (y, x, at_x);
            x = a + GOLDEN * (b - a);
            at_x = f(x);
        } else {
            (a, x, at_x) = (x, y, at_y);
            y = b - GOLDEN * (b - a);
            at_y = f(y);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_are_found_in_few_steps() {
        type Case<'f> = (&'f dyn Fn(f64) -> f64, f64, u32);
        let cases: [Case<'_>; 6] = [
            (&|x| x - 0.3, 0.3, 12),
            (&|x| x * x - 0.5, 0.5_f64.sqrt(), 16),
            (&|x| (3.0 * x).cos(), std::f64::consts::PI / 6.0, 16),
            (&|x| (x - 0.7).powi(9), 0.7, 55),
            (&|x| if x < 0.123 { -1.0 } else { 1.0 }, 0.123, 55),
            (&|x| (1e300 * (x - 0.6)).clamp(-1e300, f64::INFINITY), 0.6, 55),
        ];
        for (number, (f, zero, most)) in cases.into_iter().enumerate() {
            for sign in [1.0, -1.0] {
                let mut calls = 0;
                let found = root([0.0, 1.0], [sign * f(0.0), sign * f(1.0)], |x| {
                    calls += 1;
                    sign * f(x)
                });
                // A ninth power is zero up to rounding in a wide interval.
                let tolerance = if number == 3 { 1e-30_f64.powf(1.0 / 9.0) } else { 4.0 * f64::EPSILON };
                assert!((found - zero).abs() <= tolerance, "{number}: {found}");
                assert!(calls <= most, "{number}: {calls}");
            }
        }
    }

    #[test]
    fn what_dips_below_zero_is_found() {
        let dip = |depth: f64| move |x: f64| (x - 0.3).powi(2) - depth;
        let (x, value) = lowest([0.0, 1.0], dip(1e-12)).unwrap();
        assert!((x - 0.3).abs() < 1e-6 && value < 0.0);
        assert_eq!(lowest([0.0, 1.0], dip(-1e-15)), None);
        assert_eq!(lowest([0.0, 1.0], |_| f64::NAN), None);
    }
}
