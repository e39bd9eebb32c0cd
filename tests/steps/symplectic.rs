//! The one-step map: symplectic for every embedding, and the one that the discrete Euler-Lagrange equations define.
//!
//! The Jacobian `M` of a generated step comes from running it on dual numbers; `MᵀJM = J` then holds to the rounding of
//! `M`, a few units per entry of a product with at most 6 terms: 1e-12 `|M|²` leaves some thousand units, which is what
//! Newton's method (accurate to a few units times the condition of its Jacobian) and long Hamiltonians need.

use std::array::from_fn;

use fixtures::schemes::Scheme;
use fixtures::steps::{advance, asymmetry, distance};
use fixtures::{Uniform as Random, larger};
use wzvi::nalgebra::{DMatrix, DVector};
use wzvi::prelude::*;
use wzvi::scalar::Dual;

use crate::random::every_random_system;
use crate::random::literal::*;

const SYMPLECTIC: f64 = 1e-12;
const GRADIENT: f64 = 1e-12;
const STEP: f64 = 1e-11;

/// Quadratures of this program.
struct Trapezoidal;
struct Third;

impl Scheme for Trapezoidal {
    const POINTS: [&'static [(f64, f64)]; 2] = [&[(0.0, 0.5), (1.0, 0.5)]; 2];
}
impl Scheme for Third {
    const POINTS: [&'static [(f64, f64)]; 2] = [&[(0.0, 0.25), (1.0 / 3.0, 0.75)]; 2];
}

fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |largest, x| if x.abs() <= largest { largest } else { x.abs() })
}

/// `z` with the infinitesimal in direction `j`. One direction at a time: code for `N` at once takes minutes to compile.
fn along<const N: usize>(z: [f64; N], j: usize) -> [Dual<1>; N] {
    from_fn(|i| if i == j { Dual::variable(z[i], 0) } else { Dual::constant(z[i]) })
}

fn draws<const N: usize>(random: &mut Random, scale: f64) -> [f64; N] {
    from_fn(|_| scale * random.draw())
}

fn increments(random: &mut Random, h: f64, noises: usize) -> Vec<f64> {
    (0..noises).map(|_| h.abs().sqrt() * random.draw()).collect()
}

/// The matrix whose columns `column` gives.
fn by_columns<const N: usize>(column: &dyn Fn(usize) -> [Dual<1>; N]) -> [[f64; N]; N] {
    let columns: [[Dual<1>; N]; N] = from_fn(column);
    from_fn(|i| from_fn(|j| columns[j][i].derivative[0]))
}

/// `∂H_m` by dual numbers through `evaluate`: `(∂q, ∂p)` in one row.
#[inline(never)]
fn gradient<const N: usize, H: Hamiltonian>(system: &H, term: usize, z: [f64; N], t: f64) -> [f64; N] {
    from_fn(|j| {
        let z = along(z, j);
        system.evaluate(term, &z[..N / 2], &z[N / 2..], t).derivative[0]
    })
}

/// The generated gradient and its derivative by dual numbers: the Hessian.
#[inline(never)]
fn hessian<const N: usize, H: Hamiltonian>(
    system: &H,
    term: usize,
    z: [f64; N],
    t: f64,
) -> ([f64; N], [[f64; N]; N]) {
    let slopes = |j: usize| {
        let z = along(z, j);
        let mut slopes = [Dual::constant(0.0); N];
        let (dq, dp) = slopes.split_at_mut(N / 2);
        system.differentiate(term, &z[..N / 2], &z[N / 2..], t, dq, dp);
        slopes
    };
    (slopes(0).map(|x| x.value), by_columns(&slopes))
}

/// Gradients of all terms, generated against dual numbers, at rounding level of the value and the gradient.
fn check_gradient<const N: usize, H: Hamiltonian>(system: &H, random: &mut Random) {
    for _ in 0..20 {
        let (z, t): ([f64; N], f64) = (draws(random, 2.0), random.draw());
        for term in 0..=system.noises() {
            let (expected, (got, hessian)) = (gradient(system, term, z, t), hessian(system, term, z, t));
            let value = system.evaluate(term, &z[..N / 2], &z[N / 2..], t);
            let scale = 1.0 + value.abs() + largest(&expected);
            for i in 0..N {
                assert!(
                    (got[i] - expected[i]).abs() <= GRADIENT * scale,
                    "term {term} at {z:?}, {t}: {got:?} {expected:?}"
                );
                for j in 0..i {
                    let scale = 1.0 + largest(hessian.iter().flatten());
                    assert!((hessian[i][j] - hessian[j][i]).abs() <= GRADIENT * scale, "{hessian:?}");
                }
            }
        }
    }
}

/// Gradient and Hessian of `H_term` at `((q, p), t)`: what the oracle knows of a system. One copy of it serves all.
type Derivatives<'a, const N: usize> = &'a dyn Fn(usize, [f64; N], f64) -> ([f64; N], [[f64; N]; N]);

/// One term of the step Hamiltonian: gradient in `(Q_l, P)` with its derivative, and `l`.
struct Term<const N: usize> {
    l: f64,
    gradient: [f64; N],
    slopes: [[f64; N]; N],
}

/// The equations of docs/guide/theory.md, section 3, for one step.
struct Equations<'a, const N: usize> {
    of: Derivatives<'a, N>,
    points: [&'static [(f64, f64)]; 2],
    is_corrected: bool,
    t: f64,
    h: f64,
    dw: &'a [f64],
}

impl<const N: usize> Equations<'_, N> {
    /// The terms `c_m H_m(P, Q_l)` of docs/guide/theory.md, section 2, and the counter-term of section 4, at `x = (q_{i+1}, P)`.
    fn terms(&self, z: &[f64; N], x: &[f64; N]) -> Vec<Term<N>> {
        let d = N / 2;
        let point =
            |l: f64| -> [f64; N] { from_fn(|i| if i < d { (1.0 - l) * z[i] + l * x[i] } else { x[i] }) };
        let mut terms = Vec::new();
        for term in 0..=self.dw.len() {
            let (points, c) = match term {
                0 => (self.points[0], self.h),
                _ => (self.points[1], self.dw[term - 1]),
            };
            for &(l, share) in points {
                let (gradient, slopes) = (self.of)(term, point(l), self.t + l * self.h);
                let slopes = slopes.map(|row| row.map(|x| share * c * x));
                terms.push(Term { l, gradient: gradient.map(|x| share * c * x), slopes });
            }
        }
        let defect = 0.5 - self.points[1].iter().map(|(l, share)| l * share).sum::<f64>();
        for &(l, share) in self.points[1] {
            if !self.is_corrected || defect == 0.0 {
                continue;
            }
            let (z, weight) = (point(l), share * defect);
            // By differences: the slopes only steer the iteration.
            let columns: [[f64; N]; N] = from_fn(|j| {
                let [ahead, behind] = [1e-5, -1e-5]
                    .map(|e| self.counter_term(l, weight, from_fn(|i| z[i] + if i == j { e } else { 0.0 })));
                from_fn(|i| (ahead[i] - behind[i]) / 2e-5)
            });
            let slopes = from_fn(|i| from_fn(|j| columns[j][i]));
            terms.push(Term { l, gradient: self.counter_term(l, weight, z), slopes });
        }
        terms
    }

    /// `∇ Σ_jk w ΔW_j ΔW_k ∂q H_j · ∂p H_k` at a point `l`, with its share `w` of `1/2 - Σ w l`.
    fn counter_term(&self, l: f64, weight: f64, z: [f64; N]) -> [f64; N] {
        let d = N / 2;
        let parts: Vec<_> = (1..=self.dw.len()).map(|term| (self.of)(term, z, self.t + l * self.h)).collect();
        let mut total = [0.0; N];
        for (j, (first, first_slopes)) in parts.iter().enumerate() {
            for (k, (second, second_slopes)) in parts.iter().enumerate() {
                let c = weight * self.dw[j] * self.dw[k];
                for (i, total) in total.iter_mut().enumerate() {
                    for a in 0..d {
                        *total += c * first_slopes[a][i] * second[d + a];
                        *total += c * first[a] * second_slopes[d + a][i];
                    }
                }
            }
        }
        total
    }

    /// `(q_{i+1}, p_{i+1})` by Newton's method in all of `q_{i+1}` and `P`.
    fn solve(&self, z: [f64; N]) -> Option<[f64; N]> {
        let d = N / 2;
        let mut x = z;
        let mut last = f64::INFINITY;
        for _ in 0..200 {
            let terms = self.terms(&z, &x);
            let mut residual: [f64; N] = from_fn(|i| x[i] - z[i]);
            let mut jacobian: [[f64; N]; N] = from_fn(|i| from_fn(|j| f64::from(i == j)));
            for Term { l, gradient, slopes } in &terms {
                for i in 0..d {
                    // q1 - q0 = Σ c ∂pH and P - p0 = -Σ (1 - l) c ∂qH, Q = (1 - l) q0 + l q1.
                    residual[i] -= gradient[d + i];
                    residual[d + i] += (1.0 - l) * gradient[i];
                    for j in 0..N {
                        let weight = if j < d { *l } else { 1.0 };
                        jacobian[i][j] -= weight * slopes[d + i][j];
                        jacobian[d + i][j] += (1.0 - l) * weight * slopes[i][j];
                    }
                }
            }
            let jacobian = DMatrix::from_fn(N, N, |i, j| jacobian[i][j]);
            let correction = jacobian.lu().solve(&DVector::from_row_slice(&residual))?;
            x = from_fn(|i| x[i] - correction[i]);
            // To rounding: corrections that have stopped shrinking are its size.
            let size = largest(&correction);
            let is_rounding = size <= 1e-13 * (1.0 + largest(&x)) && size >= 0.5 * last;
            last = size;
            if size == 0.0 || is_rounding {
                let terms = self.terms(&z, &x);
                let end =
                    |i: usize| x[i] - terms.iter().map(|term| term.l * term.gradient[i - d]).sum::<f64>();
                return Some(from_fn(|i| if i < d { x[i] } else { end(i) }));
            }
        }
        None
    }
}

fn check_scheme<E: Scheme, const N: usize, H: Discretized<E>>(
    system: &H,
    random: &mut Random,
    h: f64,
) -> [f64; 2] {
    let mut worst = [0.0_f64; 2];
    for case in 0..12 {
        let z: [f64; N] = draws(random, 1.0);
        let t = random.draw();
        let h = if case % 4 == 3 { -h } else { h };
        let dw = increments(random, h, system.noises());
        let defect = asymmetry::<E, H>(system, [&z[..N / 2], &z[N / 2..]], [t, h], &dw, 1.0);
        assert!(defect <= SYMPLECTIC, "not symplectic by {defect:.1e} at {z:?}, t = {t}, {dw:?}");

        let dual = along(z, 0);
        let dual = advance::<E, Dual<1>, H>(system, [&dual[..N / 2], &dual[N / 2..]], [t, h], &dw);
        let got = advance::<E, f64, H>(system, [&z[..N / 2], &z[N / 2..]], [t, h], &dw);
        let scale = 1.0_f64.max(largest(&got));
        // The residual comes from the values of the Hamiltonians alone; the slopes only steer the iteration (and enter
        // the counter-term; `check_gradient` has verified them).
        let of = |term, z, t| (gradient(system, term, z, t), hessian(system, term, z, t).1);
        let is_corrected = E::IS_CORRECTED;
        let equations = Equations { of: &of, points: E::POINTS, is_corrected, t, h, dw: &dw };
        let expected = equations.solve(z).unwrap();
        for i in 0..N {
            assert!(
                (got[i] - expected[i]).abs() <= STEP * scale,
                "{got:?} instead of {expected:?} at {z:?}, t = {t}, {dw:?}"
            );
            // The same step on another number type.
            assert!((got[i] - dual[i].value).abs() <= STEP * scale);
            worst[1] = larger(worst[1], (got[i] - expected[i]).abs() / scale);
        }
        worst[0] = worst[0].max(defect);
    }
    worst
}

macro_rules! check {
    ($test:ident, $system:expr, $n:literal, [$($scheme:ty),*]) => {
        #[test]
        fn $test() {
            let system = $system;
            let mut random = Random($n + stringify!($test).bytes().map(u64::from).sum::<u64>());
            check_gradient::<$n, _>(&system, &mut random);
            $({
                let [defect, error] = check_scheme::<$scheme, $n, _>(&system, &mut random, 1.0 / 64.0);
                println!("{}: not symplectic by {defect:.1e}, step off by {error:.1e}", stringify!($scheme));
            })*
        }
    };
}

every_random_system!(check);

/// A system with some schemes, and with points of the user's own, which move the counter-term too.
macro_rules! with_schemes {
    (
        $test:ident, $n:literal, $name:ident { $($field:ident: $value:expr),* }, [$($scheme:ty),*],
        $($hamiltonians:tt)*
    ) => {
        #[hamiltonian(
            $($hamiltonians)*
            embedding = [
                Trapezoidal = [(0, 1/2), (1, 1/2)], Corrected<Third> = [(0, 0.25), (1/3, 0.75)], $($scheme),*
            ],
        )]
        struct $name {
            $($field: f64,)*
        }

        check!($test, $name { $($field: $value),* }, $n, [$($scheme),*, Trapezoidal, Corrected<Third>]);
    };
}

with_schemes!(
    pendulum,
    2,
    Pendulum { omega: 1.3 },
    [Uncorrected<DeltaPlus>, Uncorrected<Mixed<Midpoint, DeltaMinus>>, Corrected<Lambda<2, 3>>],
    drift = |q, p| 0.5 * p * p - omega * omega * q.cos(),
    noise = [|q, p| 0.3 * q.sin() + 0.2 * p],
);
with_schemes!(
    metric,
    2,
    Metric { s: 0.5 },
    [
        Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Midpoint, Uncorrected<Lambda<1, 4>>,
        Uncorrected<Lambda<2, 3>>, Mixed<DeltaPlus, Midpoint>, Uncorrected<Mixed<Midpoint, DeltaMinus>>,
        Corrected<DeltaPlus>, Corrected<Lambda<2, 3>>, Corrected<Mixed<DeltaMinus, Lambda<1, 4>>>,
        Uncorrected<Mixed<Trapezoidal, Third>>
    ],
    drift = |q, p| (1.0 + q * q) * p * p / 2.0,
    noise = [|q, p| s * q * p, |q, p| s * (q * q + p * p) * p, |q, _| q.cos()],
);
with_schemes!(
    driven,
    2,
    Driven { s: 0.5 },
    [Uncorrected<DeltaMinus>, Uncorrected<Lambda<1, 4>>, Corrected<DeltaPlus>],
    drift = |q, p, t| 0.5 * p * p + (1.0 + 0.5 * (2.0 * t).cos()) * q.cosh(),
    noise = [|q, p, t| s * t.sin() * q * p, |q, _, t| (1.5 + t).ln() * q.powi(3)],
);
with_schemes!(
    kepler,
    4,
    Kepler { s: 0.2 },
    [Midpoint, Mixed<DeltaPlus, Midpoint>, Corrected<Mixed<DeltaMinus, Lambda<1, 4>>>],
    drift = |[x, y], [u, v]| 0.5 * (u * u + v * v) - 1.0 / (x * x + y * y + 0.5).sqrt(),
    noise = [|[x, y], [u, v]| s * (x * v - y * u), |[x, y], [_, v]| s * x * y * v.sin()],
);
with_schemes!(
    spherical,
    6,
    Spherical { s: 0.2 },
    [Uncorrected<DeltaPlus>, Midpoint, Corrected<DeltaPlus>],
    drift = |[x, y, z], [u, v, w]| (u * u + v * v * (1.0 + x * x) + w * w / (1.0 + y * y)) / 2.0
        + (x * y * z).sin(),
    noise =
        [|[x, y, _], [_, _, w]| s * x * y * w, |_, [u, v, w]| s * (u * v + v * w), |[x, _, z], _| s * x * z],
);
// Affine in the unknowns at l = 0, not at others; the drift reads each momentum once.
with_schemes!(
    charged,
    4,
    Charged { s: 0.3 },
    [Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Midpoint, Uncorrected<Lambda<2, 3>>, Corrected<Lambda<2, 3>>],
    drift = |[x, y], [u, v]| 0.5 * ((u + y * y).powi(2) + (v - x * y).powi(2)),
    noise = [|[x, y], [u, v]| s * (x * u + y * v)],
);

/// What all of these measure by.
#[test]
fn no_difference_hides_one_that_is_not_a_number() {
    assert_eq!(distance(&[1.0, 2.0, 5.0], &[1.0, 5.0, 4.0]), 3.0);
    for place in 0..3 {
        let mut numbers = [1.0; 3];
        numbers[place] = f64::NAN;
        assert!(distance(&numbers, &[0.0; 3]).is_nan(), "{place}");
    }
}
