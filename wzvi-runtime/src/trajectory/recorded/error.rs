//! Questions that a recorded path cannot answer.

use crate::calculus::DomainError;
use crate::error::messages;
use crate::ground::digits::ShortestDecimal;
use crate::trajectory::series::SeriesError;

/// A question that a recorded path cannot answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathError {
    /// Not every step was recorded, but the answer depends on every one.
    Gaps {
        /// The value of `record_every`.
        every: u64,
    },
    /// The recorded nodes are not evenly spaced: the last is not a multiple of `record_every` steps from the
    /// start, other nodes are recorded, or the last step is shorter.
    Uneven {
        /// The value of `record_every`.
        every: u64,
        /// Steps of the path.
        steps: u64,
    },
    /// The path has no step.
    Empty,
    /// The time is not on the path.
    Outside {
        /// The requested time.
        t: f64,
        /// The first time of the path.
        start: f64,
        /// The last time of the path.
        end: f64,
    },
    /// The node before this time was not recorded.
    Unrecorded {
        /// The requested time.
        t: f64,
        /// The value of `record_every`.
        every: u64,
    },
    /// The path is one of another system: degrees of freedom and noises differ.
    System {
        /// Degrees of freedom and noises of the path.
        path: (usize, usize),
        /// Degrees of freedom and noises of the system asked about.
        system: (usize, usize),
    },
    /// The system has no first integral of this number.
    Invariant {
        /// Number asked for, from 0.
        index: usize,
        /// How many it has.
        known: usize,
    },
    /// The nodes do not form a time scale.
    Domain(DomainError),
    /// The values along the path have no such estimate.
    Series(SeriesError),
}

messages! { PathError:
    Self::Gaps { every } =>
        "this needs every step of the path, but it was run with record_every({every}); use 1";
    Self::Uneven { every, steps } =>
        "the recorded nodes are not evenly spaced: record_every({every}) does not divide the {steps} steps, `record_at` added others, \
         or the last step is shorter, which `whole_steps` prevents";
    Self::Empty => "the path has no step";
    Self::Outside { t, start, end } =>
        "t = {} is not on the path, which goes from {} to {}", ShortestDecimal(*t), ShortestDecimal(*start), ShortestDecimal(*end);
    Self::Unrecorded { t, every } =>
        "the node before t = {} was not recorded (record_every({every})): run with `record_every(1)`, or ask the run for this time, \
         `record_at([{}])`", ShortestDecimal(*t), ShortestDecimal(*t);
    Self::System { path, system } =>
        "the path has {} degrees of freedom and {} noises, but the system has {} and {}",
        path.0, path.1, system.0, system.1;
    Self::Invariant { index, known: 0 } =>
        "there is no invariant {index}: the system lists none in `invariant = [...]`";
    Self::Invariant { index, known } =>
        "there is no invariant {index}: the system has {known}, counted from 0";
    Self::Domain(error) => "{error}";
    Self::Series(error) => "{error}";
}

impl From<DomainError> for PathError {
    fn from(error: DomainError) -> Self {
        Self::Domain(error)
    }
}
