//! The coefficients of the Gauss methods, for any number of stages.
//!
//! With `y_i = 2 c_i - 1` the roots of the Legendre polynomial `P_s`, and since
//! `l_j(x) / b_j = Σ_k (2k+1) P_k(y_j) P_k(2x-1)`, every coefficient is a sum over `k < s` of `P_k(y_j)`
//! times integrals of `P_k`, which are differences of Legendre polynomials (E. Hairer, G. Wanner, *Solving
//! Ordinary Differential Equations II*, section IV.5). All of it is computed with twice the digits and
//! rounded once.

use std::sync::OnceLock;

use super::double_double::DoubleDouble;
use crate::algebra::scalar::Scalar;

/// The most stages.
pub(super) const MOST_STAGES: usize = 16;

/// The coefficients of `N` stages. Matrices are column-major: `mu[j][i]` is `μ_ij`, so that all `i` are
/// contiguous.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Tableau<const N: usize> {
    /// Nodes.
    pub(super) c: [f64; N],
    /// Weights.
    pub(super) b: [f64; N],
    /// `a_ij / b_j`, with `μ_ij + μ_ji = 1` exactly: then the step is symplectic with the rounded
    /// coefficients.
    pub(super) mu: [[f64; N]; N],
    /// `(A²)_ij / b_j = (1/b_j) Σ_k a_ik a_kj`, with `η_ij - η_ji = c_i - c_j` exactly: the same for the
    /// Nyström form.
    pub(super) eta: [[f64; N]; N],
    /// `∫_1^{1 + c_i} l_j / b_j`: the stages of the next step from the derivatives of this one.
    pub(super) nu: [[f64; N]; N],
    /// `∫_1^{1 + c_i} (1 + c_i - x) l_j(x) dx / b_j`
    pub(super) kappa: [[f64; N]; N],
}

/// `(2k+1) P_k(2 c_j - 1)` by rows `k`: what starting values for steps of all sizes have in common.
pub(super) type NodePolynomials<const N: usize> = [[f64; N]; N];

impl<const N: usize> Tableau<N> {
    /// The polynomials at the nodes, for [`Tableau::extrapolate`].
    pub(super) fn node_polynomials(&self) -> NodePolynomials<N> {
        let mut rows = [[0.0; N]; N];
        for (j, c) in self.c.iter().enumerate() {
            let (p, _) = legendre_to::<N>(2.0 * c - 1.0);
            for (k, row) in rows.iter_mut().enumerate() {
                row[j] = (2.0 * k as f64 + 1.0) * if k == 0 { 1.0 } else { p[k - 1] };
            }
        }
        rows
    }

    /// Makes `ν` and `κ` those for a next step that is `ratio` times as long as this one:
    ///
    /// ```text
    /// ν_ij = ∫_1^{1 + r c_i} l_j / b_j,   κ_ij = (1/r) ∫_1^{1 + r c_i} (1 + r c_i - x) l_j(x) dx / b_j
    /// ```
    ///
    /// in sums over Legendre polynomials, as the others. They are starting values, which nothing multiplies
    /// to the last digit.
    pub(super) fn extrapolate(&mut self, polynomials: &NodePolynomials<N>, ratio: f64) {
        for i in 0..N {
            let (p, beyond) = legendre_to::<N>(2.0 * ratio * self.c[i] + 1.0);
            let at = |k: usize| match k {
                0 => 1.0,
                k if k > N => beyond,
                k => p[k - 1],
            };
            // `∫ P_k` from `x = 1`, where `P_{-1}` is the constant 1, as `P_0` is; and `∫∫ P_k`.
            let once = |k: usize| 0.5 * ODD_RECIPROCAL[k] * (at(k + 1) - at(k.saturating_sub(1)));
            let (mut first, mut second) = ([0.0; N], [0.0; N]);
            for (k, row) in polynomials.iter().enumerate() {
                let single = once(k);
                let double = match k {
                    0 => 0.5 * single * single,
                    _ => 0.5 * ODD_RECIPROCAL[k] * (once(k + 1) - once(k - 1)),
                };
                for j in 0..N {
                    first[j] += single * row[j];
                    second[j] += double * row[j];
                }
            }
            for j in 0..N {
                self.nu[j][i] = first[j];
                self.kappa[j][i] = second[j] / ratio;
            }
        }
    }
}

/// `1/(2k + 1)`
const ODD_RECIPROCAL: [f64; MOST_STAGES + 2] = {
    let (mut list, mut k) = ([0.0; MOST_STAGES + 2], 0);
    while k < list.len() {
        list[k] = 1.0 / (2.0 * k as f64 + 1.0);
        k += 1;
    }
    list
};

/// `1/k`, but for `k = 0`.
const RECIPROCAL: [f64; MOST_STAGES + 2] = {
    let (mut list, mut k) = ([0.0; MOST_STAGES + 2], 1);
    while k < list.len() {
        list[k] = 1.0 / k as f64;
        k += 1;
    }
    list
};

/// `P_1(y) ... P_N(y)`, and `P_{N+1}(y)`.
fn legendre_to<const N: usize>(y: f64) -> ([f64; N], f64) {
    let (mut p, mut before, mut now) = ([0.0; N], 1.0, y);
    for (k, entry) in (1..).zip(p.iter_mut()) {
        *entry = now;
        let next = ((2.0 * k as f64 + 1.0) * y * now - k as f64 * before) * RECIPROCAL[k + 1];
        (before, now) = (now, next);
    }
    (p, now)
}

/// The coefficients for a number of stages known at run time only.
struct Coefficients {
    c: Vec<f64>,
    b: Vec<f64>,
    matrices: [Vec<Vec<f64>>; 4],
}

impl<const N: usize> Tableau<N> {
    /// The coefficients; computed once per program.
    pub(super) fn get() -> Self {
        static KNOWN: [OnceLock<Coefficients>; MOST_STAGES + 1] =
            [const { OnceLock::new() }; MOST_STAGES + 1];
        const { assert!(N >= 1 && N <= MOST_STAGES, "`Gauss<S>` has 1 to 16 stages") }
        let known = KNOWN[N].get_or_init(|| Coefficients::new(N));
        let list = |numbers: &[f64]| -> [f64; N] { std::array::from_fn(|i| numbers[i]) };
        let matrix = |k: usize| -> [[f64; N]; N] { std::array::from_fn(|j| list(&known.matrices[k][j])) };
        let [mu, eta, nu, kappa] = std::array::from_fn(matrix);
        Self { c: list(&known.c), b: list(&known.b), mu, eta, nu, kappa }
    }
}

/// Nodes and weights of so many stages, on the interval from 0 to 1.
pub(crate) fn quadrature(stages: usize) -> (Vec<f64>, Vec<f64>) {
    let Coefficients { c, b, .. } = Coefficients::new(stages.clamp(1, MOST_STAGES));
    (c, b)
}

/// `P_0(y) ... P_top(y)`
fn legendre(y: DoubleDouble, top: usize) -> Vec<DoubleDouble> {
    let mut p = vec![DoubleDouble::from(1.0), y];
    for k in 1..top {
        let next = (y * p[k] * (2.0 * k as f64 + 1.0) - p[k - 1] * k as f64) / (k as f64 + 1.0);
        p.push(next);
    }
    p.truncate(top + 1);
    p
}

/// Root number `i` of `P_s`, from the smallest, by Newton's method.
fn root(s: usize, i: usize) -> DoubleDouble {
    let angle = std::f64::consts::PI * (4.0 * (s - i) as f64 - 1.0) / (4.0 * s as f64 + 2.0);
    let mut y = DoubleDouble::from(Scalar::cos(angle));
    for _ in 0..8 {
        let p = legendre(y, s);
        let slope = (p[s - 1] - y * p[s]) * s as f64 / (DoubleDouble::from(1.0) - y * y);
        y = y - p[s] / slope;
    }
    y
}

/// `(2k+1) ∫ P_k(2x - 1) dx` and its integral, `(2k+1) ∫∫ P_k`, from `2x - 1 = end` to `y`, for `k < s`;
/// `end` is -1 or 1. If `sampled`, the inner one of the double integral is replaced by its interpolant at the
/// nodes, where `P_s` vanishes.
fn integrals(y: DoubleDouble, end: f64, s: usize, sampled: bool) -> Vec<[DoubleDouble; 2]> {
    let p = legendre(y, s + 1);
    // `P_{-1}` is the constant that makes the integral of `P_0` vanish at the end.
    let at = |k: isize| if k < 0 { DoubleDouble::from(end) } else { p[k.unsigned_abs()] };
    // `∫ P_k`
    let once = |k: isize| (at(k + 1) - at(k - 1)) / (2.0 * (2.0 * k as f64 + 1.0));
    (0..s as isize)
        .map(|k| {
            let twice = match k {
                0 if s > 1 || !sampled => once(0) * once(0) * 0.5,
                0 => once(0) * 0.5,
                _ if sampled && k + 1 == s as isize => once(k - 1) * -0.5,
                _ => (once(k + 1) - once(k - 1)) * 0.5,
            };
            [once(k) * (2.0 * k as f64 + 1.0), twice]
        })
        .collect()
}

impl Coefficients {
    fn new(s: usize) -> Self {
        let half = DoubleDouble::from(0.5);
        let y: Vec<DoubleDouble> = (0..s).map(|i| root(s, i)).collect();
        let c: Vec<DoubleDouble> = y.iter().map(|&y| (y + 1.0) * half).collect();
        let polynomials: Vec<Vec<DoubleDouble>> = y.iter().map(|&y| legendre(y, s)).collect();
        let weight = |i: usize| {
            let slope = polynomials[i][s - 1] * s as f64 / (DoubleDouble::from(1.0) - y[i] * y[i]);
            DoubleDouble::from(1.0) / ((DoubleDouble::from(1.0) - y[i] * y[i]) * slope * slope)
        };
        let from_start: Vec<_> = y.iter().map(|&y| integrals(y, -1.0, s, true)).collect();
        // The stages of the next step are at `1 + c_i`.
        let from_end: Vec<_> = y.iter().map(|&y| integrals(y + 2.0, 1.0, s, false)).collect();
        let matrix = |of: &[Vec<[DoubleDouble; 2]>], times: usize| -> Vec<Vec<DoubleDouble>> {
            let entry = |i: usize, j: usize| {
                let terms = of[i].iter().zip(&polynomials[j]).map(|(integral, p)| integral[times] * *p);
                terms.fold(DoubleDouble::from(0.0), |sum, term| sum + term)
            };
            (0..s).map(|j| (0..s).map(|i| entry(i, j)).collect()).collect()
        };
        let round = |wide: Vec<Vec<DoubleDouble>>, round: fn(DoubleDouble) -> f64| -> Vec<Vec<f64>> {
            wide.into_iter().map(|column| column.into_iter().map(round).collect()).collect()
        };
        // Numbers linked by an identity are rounded to a grid on which it is exact: some |μ_ij| exceed 1,
        // no |η_ij| or c_i does.
        let mut mu = round(matrix(&from_start, 0), |mu| mu.on_grid(52));
        let mut eta = round(matrix(&from_start, 1), |eta| eta.on_grid(53));
        let c: Vec<f64> = c.into_iter().map(|c| c.on_grid(53)).collect();
        for j in 0..s {
            mu[j][j] = 0.5;
            for i in 0..j {
                // `μ_ij` above the diagonal, from `μ_ji` below it.
                mu[j][i] = 1.0 - mu[i][j];
                eta[j][i] = eta[i][j] - (c[j] - c[i]);
            }
        }
        Self {
            b: (0..s).map(|i| weight(i).rounded()).collect(),
            c,
            matrices: [
                mu,
                eta,
                round(matrix(&from_end, 0), DoubleDouble::rounded),
                round(matrix(&from_end, 1), DoubleDouble::rounded),
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against published tables with 42 digits, for 2, 3, 4, 6, 8 and 16 stages.
    #[test]
    fn coefficients_are_those_of_the_tables() {
        let file: serde_json::Value =
            serde_json::from_str(include_str!("../../../tests/data/gauss.json")).unwrap();
        let mut compared = 0;
        for (s, known) in file.as_object().unwrap() {
            let ours = Coefficients::new(s.parse().unwrap());
            let number = |value: &serde_json::Value| value.as_str().unwrap().parse::<f64>().unwrap();
            let mut compare = |ours: f64, exact: f64, scale: f64| {
                assert!((ours - exact).abs() <= 2.0 * f64::EPSILON * scale, "{s}: {ours} {exact}");
                compared += 1;
            };
            for (i, (c, b)) in ours.c.iter().zip(&ours.b).enumerate() {
                compare(*c, number(&known["c"][i]), 1.0);
                compare(*b, number(&known["b"][i]), 1.0);
            }
            for (name, matrix) in ["mu", "eta", "nu"].iter().zip(&ours.matrices) {
                for (j, column) in matrix.iter().enumerate() {
                    for (i, &ours) in column.iter().enumerate() {
                        let exact = number(&known[name][i][j]);
                        compare(ours, exact, exact.abs().max(1.0));
                    }
                }
            }
        }
        assert!(compared > 1000);
    }

    /// Starting values for a step of the same size are those of the table, and for another one they integrate
    /// polynomials exactly.
    #[test]
    fn starting_values_follow_the_size() {
        let table = Tableau::<8>::get();
        for ratio in [1.0, 0.7, 1.6] {
            let mut other = table;
            other.extrapolate(&table.node_polynomials(), ratio);
            for i in 0..8 {
                // `∫_1^{1 + r c} x^4 dx` and its second integral, divided by `r`.
                let end = 1.0 + ratio * table.c[i];
                let once = (end.powi(5) - 1.0) / 5.0;
                let twice = ((end.powi(6) - 1.0) / 30.0 - (end - 1.0) / 5.0) / ratio;
                let sum = |of: &[[f64; 8]; 8]| -> f64 {
                    (0..8).map(|j| of[j][i] * table.b[j] * table.c[j].powi(4)).sum()
                };
                // Entries reach 1e5 at the last node of the longest step.
                assert!((sum(&other.nu) - once).abs() < 1e-10 * once, "{ratio}: {i}");
                assert!((sum(&other.kappa) - twice).abs() < 1e-10 * twice, "{ratio}: {i}");
                for j in (0..8).filter(|_| ratio == 1.0) {
                    assert!((other.nu[j][i] - table.nu[j][i]).abs() < 1e-11 * table.nu[j][i].abs().max(1.0));
                    assert!(
                        (other.kappa[j][i] - table.kappa[j][i]).abs()
                            < 1e-11 * table.kappa[j][i].abs().max(1.0)
                    );
                }
            }
        }
    }

    /// Checked in integers, without rounding.
    #[test]
    fn coefficients_are_symplectic_to_the_last_bit() {
        let whole = |number: f64, bits: i32| {
            let scaled = number * 2.0_f64.powi(bits);
            assert!(scaled == scaled.round() && number.abs() <= 2.0_f64.powi(53 - bits), "{number}");
            scaled as i64
        };
        for s in 1..=MOST_STAGES {
            let Coefficients { b, c, matrices: [mu, eta, ..] } = Coefficients::new(s);
            for i in 0..s {
                for j in 0..=i {
                    assert_eq!(whole(mu[i][j], 52) + whole(mu[j][i], 52), 1 << 52, "{s}: {i}, {j}");
                    let difference = whole(eta[j][i], 53) - whole(eta[i][j], 53);
                    assert_eq!(difference, whole(c[i], 53) - whole(c[j], 53), "{s}: {i}, {j}");
                }
            }
            let sum: f64 = b.iter().sum();
            assert!((sum - 1.0).abs() < 1e-15, "{s}: {sum}");
        }
    }

    /// A step back undoes a step if, with `i' = s + 1 - i`: `c_i' = 1 - c_i`, `b_i' = b_i`,
    /// `μ_i'j' = 1 - μ_ij` and `η_i'j' = η_ji`.
    #[test]
    fn coefficients_are_symmetric_to_the_last_bit() {
        for s in 1..=MOST_STAGES {
            let Coefficients { b, c, matrices: [mu, eta, ..] } = Coefficients::new(s);
            let opposite = |i: usize| s - 1 - i;
            for i in 0..s {
                assert_eq!(c[opposite(i)], 1.0 - c[i], "{s}: {i}");
                assert_eq!(b[opposite(i)], b[i], "{s}: {i}");
                for j in 0..s {
                    assert_eq!(mu[opposite(j)][opposite(i)], 1.0 - mu[j][i], "{s}: {i}, {j}");
                    assert_eq!(eta[opposite(j)][opposite(i)], eta[i][j], "{s}: {i}, {j}");
                }
            }
        }
    }
}
