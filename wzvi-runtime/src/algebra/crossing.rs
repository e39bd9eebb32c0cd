//! A point at which a path crosses a section.

use super::state::State;

/// The direction in which a path crosses a section, in the order of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Direction {
    /// From negative values to positive ones.
    Rising,
    /// From positive values to negative ones.
    Falling,
}

impl Direction {
    /// The sign of the values behind a crossing.
    pub(crate) fn sign(self) -> f64 {
        match self {
            Self::Rising => 1.0,
            Self::Falling => -1.0,
        }
    }
}

/// A point at which a path crosses a section.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Crossing<V> {
    /// Number of the section, from 0, in the order of the calls.
    pub section: usize,
    /// To which side.
    pub direction: Direction,
    /// The state there, with its time.
    pub state: State<V>,
}
