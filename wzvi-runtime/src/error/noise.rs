//! Errors of noises.

use crate::ground::digits::ShortestDecimal;

/// The reason why a source has no increments.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum NoiseError {
    /// The time is NaN, infinite, or too far from zero to be told from its neighbours.
    Time {
        /// The requested time.
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
    /// Given increments ended before the run did.
    Exhausted {
        /// The step without increments, from 0.
        step: u64,
        /// The number of steps with increments.
        available: usize,
    },
    /// The source has another number of processes than the system has noises.
    Processes {
        /// Noises of the system.
        expected: usize,
        /// Processes of the source.
        got: usize,
    },
    /// One row of given increments has another length than the first.
    Ragged {
        /// The row, from 0.
        row: usize,
        /// Length of the first row.
        expected: usize,
        /// Its length.
        got: usize,
    },
    /// An invalid setting of the source; the message says what to do.
    Setting(String),
    /// An increment is NaN or infinite.
    NonFinite {
        /// Number of the step, from 0.
        step: u64,
        /// Index of the noise.
        process: usize,
        /// The increment.
        value: f64,
    },
}

messages! { NoiseError:
    Self::Time { t, limit } =>
        "there is no noise at t = {}: times must be finite and less than {limit:.1e} from zero", ShortestDecimal(*t);
    Self::StepSize(h) => "the step size is {}; it must be finite and not zero", ShortestDecimal(*h);
    Self::Window(eps) =>
        "the width of the Wong-Zakai window is {}; it must be finite and positive", ShortestDecimal(*eps);
    Self::Unit(unit) => "the unit of time is {}; it must be finite and positive", ShortestDecimal(*unit);
    Self::Truncation(k) =>
        "the truncation parameter is {}; it must be finite and at least 1 (take twice the strong order or more)",
        ShortestDecimal(*k);
    Self::Exhausted { step, available } =>
        "step {step} has no increments: {available} steps were given; give more or end earlier";
    Self::Processes { expected, got } =>
        "the system has {expected} noises, but the increments are those of {got} processes";
    Self::Ragged { row, expected, got } =>
        "row {row} of the increments has length {got}, but the first row has length {expected}";
    Self::Setting(what) => "{}", what;
    Self::NonFinite { step, process, value } =>
        "the increment of step {step} and noise {process} is {value}";
}
