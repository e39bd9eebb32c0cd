//! What can be wrong with a noise.

use std::fmt;

/// Why there are no increments.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum NoiseError {
    /// The time is NaN, infinite, or too far from zero to be told from its neighbours.
    Time {
        /// The time asked for.
        t: f64,
        /// Times from here on are too far.
        limit: f64,
    },
    /// The step size is zero, NaN or infinite.
    StepSize(f64),
    /// The width of the Wong-Zakai window is not positive and finite.
    Window(f64),
    /// The unit of time is not positive and finite.
    Unit(f64),
    /// The truncation parameter is not a finite number >= 1.
    Truncation(f64),
    /// The run has more steps than increments were given.
    Exhausted {
        /// Number of the step, from 0.
        step: u64,
        /// Number of steps with increments.
        given: usize,
    },
    /// The increments given for a step do not fit the number of noises.
    Width {
        /// Number of the step, from 0.
        step: u64,
        /// Number of noises.
        expected: usize,
        /// Increments given.
        got: usize,
    },
    /// A given increment is NaN or infinite.
    NonFinite {
        /// Number of the step, from 0.
        step: u64,
        /// Index of the noise.
        process: usize,
        /// The increment.
        value: f64,
    },
}

impl fmt::Display for NoiseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Time { t, limit } => {
                write!(
                    f,
                    "there is no Wiener path at t = {t}: times must be finite and less than {limit:.1e} from zero"
                )
            }
            Self::StepSize(h) => write!(f, "the step size is {h}; it must be finite and not zero"),
            Self::Window(eps) => {
                write!(f, "the width of the Wong-Zakai window is {eps}; it must be finite and positive")
            }
            Self::Unit(unit) => write!(f, "the unit of time is {unit}; it must be finite and positive"),
            Self::Truncation(k) => write!(
                f,
                "the truncation parameter is {k}; it must be finite and at least 1 (take twice the strong order or more)"
            ),
            Self::Exhausted { step, given } => {
                write!(f, "step {step} has no increments: they were given for {given} steps")
            }
            Self::Width { step, expected, got } => {
                write!(f, "the system has {expected} noises, but {got} increments were given for step {step}")
            }
            Self::NonFinite { step, process, value } => {
                write!(f, "the increment given for step {step} and noise {process} is {value}")
            }
        }
    }
}

impl std::error::Error for NoiseError {}
