//! Errors of paths of multilevel runs.

use crate::error::{StepError, messages};

/// Why a path has no value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelFailure {
    /// A step failed.
    Step(StepError),
    /// The observable at its end is not finite.
    NonFinite(f64),
}

/// A path of a multilevel run without a value at its end. It cannot be left out: two neighbouring levels
/// would then average over different paths, and their differences would not add up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelError {
    /// The level, 0 the coarsest.
    pub level: u32,
    /// Number of the path on this level, from 0.
    pub path: u64,
    /// Step size of the path: that of the level, or twice that for the coarse path beside it.
    pub h: f64,
    /// Why.
    pub cause: LevelFailure,
}

messages! { LevelFailure:
    Self::Step(error) => "{error}";
    Self::NonFinite(value) => "its observable is {value}";
}

messages! { LevelError:
    Self { level, path, h, cause } =>
        "path {path} of level {level}, in steps of {h}, has no value: {cause}; begin the levels with a smaller step size";
}
