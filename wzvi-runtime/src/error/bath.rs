//! Errors of friction, temperatures and masses.

use crate::ground::digits::ShortestDecimal;

/// Why a system has no Langevin equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BathError {
    /// A temperature is negative, NaN or infinite.
    Temperature {
        /// `kT`, in units of energy.
        temperature: f64,
        /// The index of the degree of freedom, from 0, if they have temperatures of their own.
        degree: Option<usize>,
        /// The time, if the temperature depends on it.
        t: Option<f64>,
    },
    /// A rate of the friction is negative, NaN or infinite: it would heat without bound.
    Friction {
        /// In 1/time: an eigenvalue of `Γ M⁻¹`, or an entry of `Γ` that is NaN.
        rate: f64,
    },
    /// The friction matrix is not symmetric.
    Asymmetric {
        /// Row and column, from 0, of an entry that differs from the one across the diagonal.
        entry: [usize; 2],
    },
    /// The temperatures of the degrees of freedom differ, but the friction matrix is not diagonal.
    Coupled {
        /// Row and column, from 0, of an entry beside the diagonal that is not zero.
        entry: [usize; 2],
    },
    /// The mass of a degree of freedom with friction is not positive.
    Mass {
        /// Its index, from 0.
        degree: usize,
        /// `1 / m`
        inverse: f64,
    },
    /// The matrix of the kinetic energy is not positive definite.
    Masses,
    /// `GjI` needs one rate of friction for all degrees of freedom.
    Rates,
    /// Steps backwards in time, which a system with friction cannot take.
    Backwards {
        /// Step size.
        h: f64,
    },
}

messages! { BathError:
    Self::Temperature { temperature, degree, t } =>
        "the temperature{}{} is {}; it must be finite and not negative",
        degree.map(|degree| format!(" of degree of freedom {degree} (from 0)")).unwrap_or_default(),
        t.map(|t| format!(" at t = {}", ShortestDecimal(t))).unwrap_or_default(), ShortestDecimal(*temperature);
    Self::Friction { rate } =>
        "the friction has the rate {}; it must be finite and not negative", ShortestDecimal(*rate);
    Self::Asymmetric { entry: [i, j] } =>
        "the damping matrix is not symmetric at row {i}, column {j} (from 0)";
    Self::Coupled { entry: [i, j] } =>
        "the temperatures of the degrees of freedom differ, but the damping matrix couples two of them, at row {i}, column {j} (from 0); \
         take a diagonal matrix, or one temperature";
    Self::Mass { degree, inverse } =>
        "degree of freedom {degree} (from 0) has friction, but its inverse mass is {}; it must be positive",
        ShortestDecimal(*inverse);
    Self::Masses =>
        "the system has friction, but the masses of its kinetic energy are not a positive definite matrix";
    Self::Rates => "`GjI` needs one rate of friction for all degrees of freedom; use `Gjf` for different rates";
    Self::Backwards { h } =>
        "the step size is {}: a system with friction cannot run backwards in time; take a positive one", ShortestDecimal(*h);
}

impl BathError {
    /// The error as three words: its kind, and two values.
    pub(super) fn words(self) -> [u64; 3] {
        match self {
            Self::Temperature { temperature, degree, t } => {
                let which = degree.map_or(0, |degree| DEGREES + degree as u64);
                [which, temperature.to_bits(), t.map_or(UNTIMED, f64::to_bits)]
            }
            Self::Friction { rate } => [1, rate.to_bits(), 0],
            Self::Asymmetric { entry: [i, j] } => [2, i as u64, j as u64],
            Self::Mass { degree, inverse } => [3, degree as u64, inverse.to_bits()],
            Self::Masses => [4, 0, 0],
            Self::Backwards { h } => [5, h.to_bits(), 0],
            Self::Rates => [6, 0, 0],
            Self::Coupled { entry: [i, j] } => [7, i as u64, j as u64],
        }
    }

    pub(super) fn from_words([which, a, b]: [u64; 3]) -> Option<Self> {
        let x = f64::from_bits(a);
        Some(match which {
            0 => Self::Temperature { temperature: x, degree: None, t: timed(b) },
            1 => Self::Friction { rate: x },
            2 => Self::Asymmetric { entry: [usize::try_from(a).ok()?, usize::try_from(b).ok()?] },
            3 => Self::Mass { degree: usize::try_from(a).ok()?, inverse: f64::from_bits(b) },
            4 => Self::Masses,
            5 => Self::Backwards { h: x },
            6 => Self::Rates,
            7 => Self::Coupled { entry: [usize::try_from(a).ok()?, usize::try_from(b).ok()?] },
            _ => {
                let degree = which.checked_sub(DEGREES).filter(|degree| *degree < MOST_DEGREES)?;
                let degree = usize::try_from(degree).ok()?;
                Self::Temperature { temperature: x, degree: Some(degree), t: timed(b) }
            }
        })
    }
}

/// The first word for temperatures of degrees of freedom.
const DEGREES: u64 = 8;
/// More degrees than any state has; greater words are other failures.
const MOST_DEGREES: u64 = 1 << 48;

/// Instead of the bits of a time.
const UNTIMED: u64 = u64::MAX;

fn timed(bits: u64) -> Option<f64> {
    (bits != UNTIMED).then(|| f64::from_bits(bits))
}
