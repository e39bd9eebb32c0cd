//! Discrete differential and integral calculus on uniform time scales (the paper's section 2).
//!
//! On `[a, b]` with `N` steps `h = (b - a)/N`, `t_i = a + i h` and `t_{i+1/2} = (t_i + t_{i+1})/2`, the [time
//! scales](scale) are
//!
//! | paper | here | points |
//! |---|---|---|
//! | T | [`Nodes`] | `t_0 … t_N` |
//! | T⁺, T⁻, T^± | [`Plus<Nodes>`](Plus), [`Minus<Nodes>`](Minus), [`Interior`] | T without `b`, without `a`, without both |
//! | T_½ | [`Midpoints`] | `t_{1/2} … t_{N-1/2}` |
//! | T_∘ | [`Whole`] | T ∪ T_½ |
//!
//! and a [`Function<S, V>`] is a function on the scale `S` with values in `V`. Its scale is part of its type,
//! so a derivative can only be evaluated where it is defined:
//!
//! | paper | here |
//! |---|---|
//! | `Δ₊ f`, `Δ₋ f` (also with ∘, ½) | [`Function::delta_plus`], [`Function::delta_minus`] on any scale |
//! | `f_∘` | [`Function::extension`] |
//! | `[f]_{½,-}` | [`Function::mean_minus`] |
//! | `[f]_∘` | [`Function::mean_around`] |
//! | `∫ f Δ_λ t` | [`Lambda::antiderivative`]; [`Function::integral`] where the scale says λ |
//!
//! Sums are taken from left to right and nothing is rearranged: on data whose sums are exact (dyadic numbers)
//! every identity holds exactly.
//!
//! ```
//! use wzvi_runtime::calculus::{Nodes, TimeScale};
//!
//! let scale = TimeScale::new(0.0, 1.0, 4)?;
//! let square = scale.sample::<Nodes, _>(|t| t * t);
//! // The mid-point rule and Δ₊ undo each other: ∫ Δ_{∘,+}[f_∘] Δ_½ t = f(b) - f(a).
//! let slope = square.extension().delta_plus().restrict::<wzvi_runtime::calculus::Midpoints>()?;
//! assert_eq!(slope.integral(), Ok(1.0));
//! # Ok::<(), wzvi_runtime::calculus::DomainError>(())
//! ```
//!
//! Tested by `wzvi-runtime/src/calculus/tests.rs`.

pub mod function;
mod lambda;
pub mod scale;
#[cfg(test)]
mod tests;

use std::fmt;

pub use function::Function;
pub use lambda::Lambda;
pub use scale::{Interior, Midpoints, Minus, Nodes, Plus, Point, Scale, TimeScale, Whole};

/// A value was requested where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DomainError {
    /// `[a, b]` with `N` steps is no uniform time scale: `a` and `b` must be finite and far enough apart,
    /// `N > 0`.
    Interval {
        /// `a`
        a: f64,
        /// `b`
        b: f64,
        /// `N`
        steps: usize,
    },
    /// The point is not on the time scale.
    Point {
        /// The point.
        point: Point,
        /// Name of the scale.
        scale: &'static str,
        /// `N`
        steps: usize,
    },
    /// Another number of values than the time scale has points.
    Length {
        /// Points.
        expected: usize,
        /// Values.
        got: usize,
    },
    /// Two functions on different intervals or with different steps were combined.
    Different,
    /// `λ` is not in `[0, 1]`.
    Lambda(f64),
}

impl fmt::Display for DomainError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Interval { a, b, steps } => {
                write!(f, "[{a}, {b}] in {steps} steps is no uniform time scale")
            }
            Self::Point { point, scale, steps } => {
                write!(f, "{point} is not on {scale} with N = {steps}")
            }
            Self::Length { expected, got } => write!(f, "{got} values for {expected} points"),
            Self::Different => f.write_str("the functions are on different time scales"),
            Self::Lambda(lambda) => write!(f, "λ = {lambda} is not in [0, 1]"),
        }
    }
}

impl std::error::Error for DomainError {}
