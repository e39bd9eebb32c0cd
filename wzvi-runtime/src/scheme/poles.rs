//! Poles of implicit steps within the reach of truncated increments.
//!
//! A step with one `P` solves, at its point `m`, with `F = h H_0 + ΔW H_k`,
//!
//! ```text
//! Q = q_i + m F_p(Q, P),   P = p_i - (1 - m) F_q(Q, P)
//! ```
//!
//! which has no unique solution where `I - h A_0 - ΔW A_k` is singular, with the Jacobians
//!
//! ```text
//! A = [ m H_pq, m H_pp; -(1 - m) H_qq, -(1 - m) H_qp ]
//! ```
//!
//! If `H_k` is quadratic, `A_k` is constant, and the poles in `ΔW` are one over the real eigenvalues of
//! `(I - h A_0)⁻¹ A_k`. For `H_k = s q p`, `m = 1/2` and no drift they are `±2/s`. Increments are truncated
//! at `A_h √h`, so that a step size below which none is reached always exists. `check` refuses longer steps.
//! It takes the drift at the start, and each noise by itself: increments of independent noises that are all
//! near their bounds at once do not occur.

use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{DMatrix, Schur};

use super::system::{Discretized, Hamiltonian};
use crate::algebra::scalar::{Dual, Scalar};
use crate::algebra::state::{State, Vector as _};
use crate::error::ConfigError;

/// The poles of the steps of a scheme in linear systems.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Poles {
    /// The points `m` of the parts of a step.
    pub points: [f64; 2],
    /// The largest fraction of the step, in absolute value, that a part takes; for stages that are solved at
    /// once, 2 over the real pole of their stability function.
    pub fraction: f64,
}

/// Twice the real zeros of the reversed Bessel polynomials of odd degrees, from degree 1 on: the poles of the
/// stability functions of Gauss's collocation, the diagonal Padé approximants of `e^z`. Polynomials of even
/// degrees have none.
const OF_STAGES: [f64; 8] = [
    2.0,
    4.644_370_709_252_171,
    7.293_477_190_659_287,
    9.943_573_717_055_871,
    12.594_038_363_429_936,
    15.244_679_691_592_859,
    17.895_419_348_783_584,
    20.546_219_332_644_956,
];

impl Poles {
    /// The poles of a step with one `P`.
    pub(crate) const fn at(point: f64) -> Self {
        Self { points: [point; 2], fraction: 1.0 }
    }

    /// The poles of Gauss's collocation; none on the real axis for an even number of stages.
    pub(crate) const fn of_stages(stages: usize) -> Option<Self> {
        if stages % 2 == 1 && stages / 2 < OF_STAGES.len() {
            Some(Self { points: [0.5; 2], fraction: 2.0 / OF_STAGES[stages / 2] })
        } else {
            None
        }
    }
}

/// Systems with more degrees of freedom are looked at where each noise acts.
const WHOLE: usize = 16;
/// The number of noises times degrees of freedom up to which every noise is looked at, and beyond which as
/// many as make it up.
const MOST: usize = 1 << 16;

/// Refuses steps in which an increment within `bound(h)` reaches a pole.
///
/// # Errors
/// [`ConfigError::Pole`]
pub(crate) fn check<H: Discretized<E>, E>(
    system: &H,
    start: &State<H::Vector>,
    h: f64,
    bound: &dyn Fn(f64) -> f64,
) -> Result<(), ConfigError> {
    if const { !H::PLAN.truncates_increments() || H::PROPERTIES.poles.is_none() } {
        return Ok(());
    }
    let Some(poles) = H::PROPERTIES.poles else { return Ok(()) };
    if !bound(h).is_finite() {
        return Ok(());
    }
    let at = [start.q.components(), start.p.components()];
    let curvature: HessianOf<'_> = &|term, shift, direction, into| {
        along(system, term, at, start.t, (shift, direction), into);
    };
    refuse([at[0].len(), system.noises()], h, (poles, bound), curvature)
}

/// Writes the derivative of the derivatives of a term, `(H_q, H_p)`, in a direction of the phase space, at
/// the start or at a state shifted from it.
type HessianOf<'c> = &'c dyn Fn(usize, bool, &dyn Fn(usize) -> f64, &mut [f64]);

fn along<H: Hamiltonian>(
    system: &H,
    term: usize,
    [q, p]: [&[f64]; 2],
    t: f64,
    (is_shifted, direction): (bool, &dyn Fn(usize) -> f64),
    into: &mut [f64],
) {
    let d = q.len();
    let dual = |component: usize, value: f64| {
        let shift = if is_shifted { (1.0 + value.abs()) * generic(component) } else { 0.0 };
        Dual { value: value + shift, derivative: [direction(component)] }
    };
    let [q, p]: [Vec<Dual<1>>; 2] =
        [(0, q), (d, p)].map(|(first, list)| (first..).zip(list).map(|(i, value)| dual(i, *value)).collect());
    let mut slopes = vec![Dual::<1>::from_f64(0.0); 2 * d];
    let (by_q, by_p) = slopes.split_at_mut(d);
    system.differentiate(term, &q, &p, t, by_q, by_p);
    if term == 0 && H::KIND.is_forced {
        let mut force = vec![Dual::<1>::from_f64(0.0); d];
        system.force(&q, &p, t, &mut force);
        by_q.iter_mut().zip(force).for_each(|(slope, force)| *slope = *slope - force);
    }
    into.iter_mut().zip(slopes).for_each(|(into, slope)| *into = slope.derivative[0]);
}

/// Numbers between 0.1 and 0.6 without a pattern.
fn generic(component: usize) -> f64 {
    0.1 + 0.5 * (0.618_033_988_749_894_9 * (component + 1) as f64).fract()
}

/// A quadratic noise and the drift, by the degrees of freedom that the noise acts on.
struct QuadraticNoise {
    /// `A_0` and `A_k`, for the points of both parts.
    of: [[DMatrix<f64>; 2]; 2],
}

fn refuse(
    [degrees, noises]: [usize; 2],
    h: f64,
    (poles, bound): (Poles, &dyn Fn(f64) -> f64),
    curvature: HessianOf<'_>,
) -> Result<(), ConfigError> {
    let stride = (noises * degrees).div_ceil(MOST).max(1);
    let mut found: Option<(f64, usize, f64)> = None;
    for number in (0..noises).step_by(stride) {
        let Some(noise) = QuadraticNoise::of(degrees, number, poles, curvature) else { continue };
        let reaches = |h: f64| noise.pole(h) <= bound(h);
        if !reaches(h) {
            continue;
        }
        let largest = largest(h, &reaches);
        if found.is_none_or(|(least, ..): (f64, _, _)| largest.abs() < least.abs()) {
            found = Some((largest, number, noise.pole(h)));
        }
    }
    match found {
        Some((largest, noise, increment)) => {
            Err(ConfigError::Pole { noise, h, increment, bound: bound(h), largest })
        }
        None => Ok(()),
    }
}

/// A step size of at most three digits that does not reach a pole, and is near the largest one; its sign is
/// that of `h`.
fn largest(h: f64, reaches: &dyn Fn(f64) -> bool) -> f64 {
    let (mut short, mut long) = (0.5 * h, h);
    while reaches(short) && short.abs() > f64::MIN_POSITIVE {
        (short, long) = (0.5 * short, short);
    }
    for _ in 0..40 {
        let middle = 0.5 * (short + long);
        if reaches(middle) { long = middle } else { short = middle }
    }
    let unit = Scalar::powf(10.0, Scalar::log10(short.abs()).floor() - 2.0);
    let rounded = (short / unit).trunc() * unit;
    // As it is printed.
    let rounded = format!("{rounded:.2e}").parse().unwrap_or(rounded);
    if rounded != 0.0 && !reaches(rounded) { rounded } else { short }
}

impl QuadraticNoise {
    /// `None` unless it is quadratic, and acts on few enough degrees of freedom.
    fn of(degrees: usize, number: usize, poles: Poles, curvature: HessianOf<'_>) -> Option<Self> {
        let (term, n) = (number + 1, 2 * degrees);
        let [mut here, mut there] = [vec![0.0; n], vec![0.0; n]];
        curvature(term, false, &generic, &mut here);
        curvature(term, true, &generic, &mut there);
        let size = here.iter().map(|number| number.abs()).fold(0.0, f64::max);
        // Not so for NaN. Both sums round by a few units in the last place per degree of freedom.
        let rounding = 64.0 * f64::EPSILON * n as f64 * size;
        if size == 0.0 || !here.iter().zip(&there).all(|(a, b)| (a - b).abs() <= rounding) {
            return None;
        }
        let acts = |degree: &usize| here[*degree] != 0.0 || here[degrees + degree] != 0.0;
        let on: Vec<usize> = (0..degrees).filter(|degree| degrees <= WHOLE || acts(degree)).collect();
        if on.len() > WHOLE {
            return None;
        }
        let b = on.len();
        let place = |row: usize| if row < b { on[row] } else { degrees + on[row - b] };
        let mut hessian = |term: usize| {
            let mut matrix = DMatrix::<f64>::zeros(2 * b, 2 * b);
            for column in 0..2 * b {
                let only = |component: usize| f64::from(u8::from(component == place(column)));
                curvature(term, false, &only, &mut here);
                (0..2 * b).for_each(|row| matrix[(row, column)] = here[place(row)]);
            }
            matrix
        };
        let [drift, noise] = [0, term].map(&mut hessian);
        let jacobian = |hessian: &DMatrix<f64>, m: f64| {
            let weight = |row: usize| poles.fraction * if row < b { m } else { m - 1.0 };
            DMatrix::from_fn(2 * b, 2 * b, |row, column| weight(row) * hessian[((row + b) % (2 * b), column)])
        };
        let of = poles.points.map(|m| [jacobian(&drift, m), jacobian(&noise, m)]);
        of.iter()
            .flatten()
            .all(|matrix| matrix.iter().all(|number| number.is_finite()))
            .then_some(Self { of })
    }

    /// The least increment, in absolute value, for which a step of size `h` has no unique solution; infinite
    /// if there is none.
    fn pole(&self, h: f64) -> f64 {
        let of_part = |[drift, noise]: &[DMatrix<f64>; 2]| {
            let n = drift.nrows();
            let step = DMatrix::identity(n, n) - drift * h;
            let Some(mut rates) = step.lu().solve(noise) else { return f64::INFINITY };
            if !rates.iter().all(|rate| rate.is_finite()) {
                return f64::INFINITY;
            }
            // The largest rate is between 1 and 2 in units of `unit`; what is nothing beside it, is zero. Balancing
            // does not end where numbers overflow or underflow.
            let unit =
                f64::from_bits(rates.amax().to_bits() & f64::INFINITY.to_bits()).max(f64::MIN_POSITIVE);
            rates.apply(|rate| {
                let scaled = *rate / unit;
                *rate = if scaled.abs() < NOTHING { 0.0 } else { scaled };
            });
            // Coordinates and momenta in units of like size.
            balance_parlett_reinsch(&mut rates);
            let size = rates.amax();
            let Some(schur) = Schur::try_new(rates, f64::EPSILON, 1000) else { return f64::INFINITY };
            let eigenvalues = schur.complex_eigenvalues();
            // Two equal real eigenvalues are found as a pair with imaginary parts of the root of the
            // rounding.
            let real =
                eigenvalues.iter().filter(|rate| rate.im.abs() <= 1e-7 * size).map(|rate| rate.re.abs());
            // Below that root, an eigenvalue of a nilpotent matrix is zero.
            let largest = real.filter(|rate| *rate > 1e-7 * size).fold(0.0, f64::max);
            (largest * unit).recip()
        };
        self.of.iter().map(of_part).fold(f64::INFINITY, f64::min)
    }
}

/// A rate beside 1 that has no influence: its products with others underflow.
const NOTHING: f64 = 1e-150;

#[cfg(test)]
mod tests {
    use super::*;

    /// `θ_n(s) = Σ_k (2n - k)! / (2^{n-k} k! (n-k)!) s^k` vanishes at minus half of each pole.
    #[test]
    fn poles_of_stages_are_zeros_of_bessel_polynomials() {
        let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
        for (number, pole) in OF_STAGES.iter().enumerate() {
            let n = 2 * number + 1;
            let term = |k: usize| {
                let coefficient =
                    factorial(2 * n - k) / (2f64.powi((n - k) as i32) * factorial(k) * factorial(n - k));
                coefficient * (-0.5 * pole).powi(k as i32)
            };
            let sizes: f64 = (0..=n).map(|k| term(k).abs()).sum();
            let sum: f64 = (0..=n).map(term).sum();
            assert!(sum.abs() < 1e-15 * sizes, "{n}: {sum} {sizes}");
        }
        assert_eq!((Poles::of_stages(2), Poles::of_stages(1)), (None, Some(Poles::at(0.5))));
    }

    /// In closed form: `s q p` without drift, beside an oscillator (`±2 √(1 + x²)/s`, `x = ω h / 2`), and a
    /// fluctuating force constant `s q²/2`, whose matrix is nilpotent and whose pole comes with the drift:
    /// `4 (1 + x²) / (s h)`.
    #[test]
    fn poles_are_those_of_closed_forms() {
        let (s, h) = (0.7, 0.3);
        let hessian = |of: [[f64; 2]; 2]| {
            move |direction: &dyn Fn(usize) -> f64, into: &mut [f64]| {
                into.iter_mut()
                    .zip(of)
                    .for_each(|(into, row)| *into = row[0] * direction(0) + row[1] * direction(1));
            }
        };
        for omega in [0.0, 1.0, 20.0] {
            let x = 0.5 * omega * h;
            let drift = hessian([[omega * omega, 0.0], [0.0, 1.0]]);
            for (noise, exact) in [
                ([[0.0, s], [s, 0.0]], 2.0 * f64::sqrt(1.0 + x * x) / s),
                ([[s, 0.0], [0.0, 0.0]], 4.0 * (1.0 + x * x) / (s * h)),
                // A rotation has none.
                ([[s * omega * omega, 0.0], [0.0, s]], f64::INFINITY),
            ] {
                let noise = hessian(noise);
                let curvature: HessianOf<'_> = &|term, _, direction, into| {
                    if term == 0 { drift(direction, into) } else { noise(direction, into) }
                };
                if omega == 0.0 && exact.is_infinite() {
                    continue;
                }
                let noise = QuadraticNoise::of(1, 0, Poles::at(0.5), curvature).unwrap();
                let found = noise.pole(h);
                assert!(found == exact || (found / exact - 1.0).abs() < 1e-12, "{omega}: {found} {exact}");
            }
        }
    }

    /// Rates of any size, as of parameters in any units: the search ends, and the pole of `s q p` is `2/s`.
    #[test]
    fn poles_of_extreme_rates_are_found() {
        let hessian = |of: [[f64; 2]; 2]| {
            move |direction: &dyn Fn(usize) -> f64, into: &mut [f64]| {
                into.iter_mut()
                    .zip(of)
                    .for_each(|(into, row)| *into = row[0] * direction(0) + row[1] * direction(1));
            }
        };
        let pole = |noise: [[f64; 2]; 2], mass: f64, stiffness: f64| {
            let drift = hessian([[stiffness, 0.0], [0.0, mass.recip()]]);
            let noise = hessian(noise);
            let curvature: HessianOf<'_> = &|term, _, direction, into| {
                if term == 0 { drift(direction, into) } else { noise(direction, into) }
            };
            // Second derivatives beyond all numbers have none.
            QuadraticNoise::of(1, 0, Poles::at(0.5), curvature).map(|noise| noise.pole(1e-3))
        };
        let sizes = [1e-320, 1e-300, 1e-155, 1e-9, 1.0, 1e9, 1e155, 1e300];
        let all = sizes.into_iter().flat_map(|s| sizes.map(|mass| (s, mass)));
        for (s, mass, stiffness) in all.flat_map(|(s, mass)| sizes.map(|stiffness| (s, mass, stiffness))) {
            assert!(!pole([[s, 0.0], [0.0, s]], mass, stiffness).is_some_and(f64::is_nan), "{s:e} {mass:e}");
            let Some(found) = pole([[0.0, s], [s, 0.0]], mass, stiffness) else { continue };
            assert!(!found.is_nan(), "{s:e} {mass:e} {stiffness:e}");
            // Without the drift, up to its rounding, and where products of matrix entries do not underflow.
            if stiffness / mass * 1e-6 < 1e-16 && stiffness < 1e100 && mass > 1e-100 && s > 1e-307 {
                assert!((found / (2.0 / s) - 1.0).abs() < 1e-12, "{s:e} {mass:e} {stiffness:e}: {found:e}");
            }
        }
    }
}
