//! The modes of a friction matrix: `A = Cᵀ Γ C = V Λ Vᵀ` and `W = N V`, as in
//! [`relaxation`](super::relaxation).

use super::matrix::{cholesky, diagonalise, inverse_transposed, triangularise};
use crate::algebra::scalar::{ComputesWith, Constant, Mask, Scalar};
use crate::error::BathError;

/// The decay factor `E` of a mode with the rate `λ` over the time `s`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decay {
    /// `e^{-s λ}`, exact.
    Exponential,
    /// `(1 - s λ/2)/(1 + s λ/2)`
    Cayley,
}

impl Decay {
    /// The factor at `s λ = share`.
    pub(super) fn factor(self, share: f64) -> f64 {
        match self {
            Self::Exponential => Scalar::exp(-share),
            Self::Cayley => (1.0 - 0.5 * share) / (1.0 + 0.5 * share),
        }
    }
}

/// Time and temperature of an O part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bath<K = f64> {
    /// `s`
    pub(super) time: K,
    /// `kT`, where it is one constant.
    pub(super) temperature: K,
    /// `1 / √h` of the whole step: the step is driven by `√h ξ`.
    pub(super) unit: K,
    pub(super) decay: Decay,
}

impl<K: Constant> Bath<K> {
    /// `E` and `R √(M⁻¹) / √h` of a mode with this rate.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn mode<S: ComputesWith<K>>(&self, rate: S) -> (S, S) {
        match self.decay {
            Decay::Exponential => {
                let x = -(rate * self.time);
                (x.exp(), (-(x * 2.0).exp_m1() * self.temperature).sqrt() * self.unit)
            }
            // 1 - E² = 4 x/(1 + x)² with x = s λ/2.
            Decay::Cayley => {
                let (x, one) = (rate * (self.time * 0.5), S::from_f64(1.0));
                let sum = one + x;
                ((one - x) / sum, (x * (self.temperature * 4.0)).sqrt() / sum * self.unit)
            }
        }
    }

    /// `E` of a mode, and the weights of the temperatures at the start and at the end of the O part in the
    /// variance of its noise, `R² M⁻¹ / h`. With `c = e^{-x}`, `x = s λ`, and a temperature that is linear in
    /// between,
    ///
    /// ```text
    /// ∫ 2 λ T(u) e^{-2 λ (s - u)} du = T_0 ((1 - c²)/(2 x) - c²) + T_1 (1 - (1 - c²)/(2 x))
    /// ```
    ///
    /// Cayley's map takes the temperature in the middle, which is then the one at the start.
    pub(super) fn ramp<S: ComputesWith<K>>(&self, rate: S) -> (S, [S; 2]) {
        let square = self.unit * self.unit;
        match self.decay {
            Decay::Exponential => {
                let x = rate * self.time;
                let (all, last) = (-(x * -2.0).exp_m1(), averaged(x * 2.0));
                ((-x).exp(), [(all - last) * square, last * square])
            }
            Decay::Cayley => {
                let (x, one) = (rate * (self.time * 0.5), S::from_f64(1.0));
                let sum = one + x;
                ((one - x) / sum, [x * 4.0 / (sum * sum) * square, S::from_f64(0.0)])
            }
        }
    }

    /// `1 - E` of a mode.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lost<S: ComputesWith<K>>(&self, rate: S) -> S {
        match self.decay {
            Decay::Exponential => -(-(rate * self.time)).exp_m1(),
            Decay::Cayley => {
                let x = rate * (self.time * 0.5);
                x * 2.0 / (S::from_f64(1.0) + x)
            }
        }
    }
}

/// `1 - (1 - e^{-y})/y` for `y` that is not negative: below 1 by its series, since the difference would lose
/// digits.
fn averaged<S: Scalar>(y: S) -> S {
    // y/2! - y²/3! + y³/4! - ...: the first term that is left out is below 1/20!.
    let (mut series, mut term) = (S::from_f64(0.0), y * 0.5);
    for n in 3..20 {
        series = series + term;
        term = -(term * y) / f64::from(n);
    }
    let one = S::from_f64(1.0);
    S::select(y.less(one), series, one + (-y).exp_m1() / y)
}

/// Factors of the masses; empty where rates and masses are lists.
#[derive(Clone, Debug, Default)]
pub(super) struct Factors<K = f64> {
    /// `C`
    pub(super) lower: Vec<K>,
    /// `N`
    pub(super) upper: Vec<K>,
    /// The lower triangular `L` with `M = L Lᵀ`.
    pub(super) mass: Vec<K>,
}

impl<K: Constant> Factors<K> {
    pub(super) fn of(inverse_mass: &[K], d: usize) -> Result<Self, BathError> {
        let mut lower = inverse_mass.to_vec();
        if !cholesky(&mut lower, d) {
            return Err(BathError::Masses);
        }
        let upper = inverse_transposed(&lower, d);
        let mut mass = upper.clone();
        triangularise(&mut mass, d);
        Ok(Self { lower, upper, mass })
    }
}

/// `Γ` and its modes, in place in three matrices.
pub(super) struct FrictionModes<'r, K> {
    /// `Γ`, then `Λ` on the diagonal.
    pub(super) rates: &'r mut [K],
    /// `V`
    pub(super) vectors: &'r mut [K],
    /// `W`
    pub(super) modes: &'r mut [K],
}

impl<K: Constant> FrictionModes<'_, K> {
    /// Solves for the modes of the friction in `rates`.
    ///
    /// # Errors
    /// The smallest rate, if it is negative.
    pub(super) fn solve(&mut self, mass: &Factors<K>, d: usize) -> Result<(), f64> {
        let Self { rates, vectors, modes } = self;
        let zero = K::from_f64(0.0);
        // Γ C, then Cᵀ Γ C.
        for i in 0..d {
            for k in 0..d {
                modes[i * d + k] = (k..d).fold(zero, |sum, j| sum + rates[i * d + j] * mass.lower[j * d + k]);
            }
        }
        for i in 0..d {
            for k in 0..=i {
                let entry = (i..d).fold(zero, |sum, j| sum + modes[j * d + k] * mass.lower[j * d + i]);
                (rates[i * d + k], rates[k * d + i]) = (entry, entry);
            }
        }
        diagonalise(rates, vectors, d);
        let largest = (0..d).fold(zero, |largest, k| largest.larger(rates[k * (d + 1)]));
        // The rounding of the products where the exact rate is zero.
        let rounding = largest * (4.0 * d as f64 * f64::EPSILON);
        for k in 0..d {
            let rate = &mut rates[k * (d + 1)];
            refuse_negative(*rate + rounding).map_err(|_| lowest(*rate))?;
            *rate = rate.max(zero);
        }
        for i in 0..d {
            for k in 0..d {
                modes[i * d + k] =
                    (i..d).fold(zero, |sum, j| sum + vectors[j * d + k] * mass.upper[i * d + j]);
            }
        }
        Ok(())
    }

    /// The smallest rate `μ` and the common factor `e^{-s μ}`; 0 and 1 for [`Decay::Cayley`].
    pub(super) fn slowest(&self, bath: &Bath<K>, d: usize) -> (K, K) {
        if bath.decay == Decay::Cayley {
            return (K::from_f64(0.0), K::from_f64(1.0));
        }
        let smallest = (1..d).fold(self.rates[0], |least, k| least.min(self.rates[k * (d + 1)]));
        (smallest, (-(smallest * bath.time)).exp())
    }

    /// `1 - E` of the rate `λ_k - μ`
    pub(super) fn faster(&self, bath: &Bath<K>, smallest: K, k: usize, d: usize) -> K {
        bath.lost(self.rates[k * (d + 1)] - smallest)
    }

    /// `W⁻¹` at row `k` and column `j`
    pub(super) fn inverse(&self, mass: &Factors<K>, [k, j]: [usize; 2], d: usize) -> K {
        let zero = K::from_f64(0.0);
        (0..=j).fold(zero, |sum, i| sum + self.vectors[i * d + k] * mass.lower[j * d + i])
    }

    /// Replaces `W` by `R / √h`.
    pub(super) fn deviation(&mut self, bath: &Bath<K>, d: usize) {
        for k in 0..d {
            let deviation = bath.mode(self.rates[k * (d + 1)]).1;
            for row in self.modes.chunks_exact_mut(d) {
                row[k] = row[k] * deviation;
            }
        }
        triangularise(self.modes, d);
    }
}

/// The smallest lane of a number.
fn lowest<S: Scalar>(number: S) -> f64 {
    (0..S::LANES).map(|lane| number.lane(lane)).fold(f64::INFINITY, f64::min)
}

/// # Errors
/// The number, if it is negative in any lane.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn refuse_negative<S: Scalar>(number: S) -> Result<(), f64> {
    let is_negative = number.less(S::from_f64(0.0));
    if (!is_negative).all() { Ok(()) } else { Err(lowest(number)) }
}
