//! The cost of a solution, and the doubts about it.

use std::ops::Add;

use crate::algebra::scalar::{Mask, Scalar};

/// Whether a careful solution belongs to its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Doubt {
    /// It does, as far as the iteration tells.
    #[default]
    None,
    /// The Jacobian at the solution does not lead back to the start.
    OneWay,
    /// Corrections reached unknowns one after the other, as along a chain of contacts that just touch: none
    /// can be expected to contract.
    Unbounded,
    /// The first corrections did not shrink as they do near a solution: there may be another one nearer to
    /// the start.
    Straying,
}

/// The cost of a solution, and the doubts about it: eight bytes, which a step returns in one register.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Newton iterations.
    pub iterations: u32,
    /// Only a careful solution reports this; the fast method gives up.
    pub doubt: Doubt,
    /// Whether the Jacobian at the start was not about the identity: of a careful solution. From zero there
    /// may be another solution along the step, then.
    pub is_far: bool,
    /// Whether the Jacobian at the solution has a negative determinant, if the solution was a careful one.
    pub is_reversed: bool,
    /// Whether that Jacobian is symmetric and not definite, if the solution was a careful one.
    pub is_indefinite: bool,
}

const _: () = assert!(size_of::<Effort>() == 8);

impl Effort {
    /// A solution by the short way, or (0) without iterations.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub const fn fast(iterations: u32) -> Self {
        Self { iterations, doubt: Doubt::None, is_far: false, is_reversed: false, is_indefinite: false }
    }

    /// The effort that `1 / pivot` of an unknown adds which was isolated in front of the iteration: the
    /// determinant of the whole Jacobian is that of the iterated part times the pivot.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn isolated<S: Scalar, const CAREFUL: bool>(inverse: S) -> Self {
        Self { is_reversed: CAREFUL && inverse.less(S::from_f64(0.0)).all(), ..Self::fast(0) }
    }

    /// Whether a careful solution from zero is the one that continues the state.
    pub(crate) fn is_certain(self) -> bool {
        self.doubt == Doubt::None && !(self.is_far || self.is_elsewhere())
    }

    /// Whether another solution may be nearer to the start.
    pub(crate) fn is_doubtful(self) -> bool {
        self.doubt >= Doubt::Unbounded
    }

    /// Whether corrections could not contract, whatever solution they lead to.
    pub(crate) fn is_unbounded(self) -> bool {
        self.doubt == Doubt::Unbounded
    }

    /// Whether the Jacobian says that a careful solution is not the one that continues the state.
    pub(crate) fn is_elsewhere(self) -> bool {
        self.is_reversed || self.is_indefinite
    }

    /// With that of other equations, each of which have a determinant of their own.
    #[cfg_attr(not(debug_assertions), inline(always))]
    #[must_use]
    pub fn and_block(self, other: Self) -> Self {
        Self { is_reversed: self.is_reversed | other.is_reversed, ..self + other }
    }
}

impl Add for Effort {
    type Output = Self;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add(self, other: Self) -> Self {
        Self {
            iterations: self.iterations + other.iterations,
            doubt: if self.doubt < other.doubt { other.doubt } else { self.doubt },
            is_far: self.is_far | other.is_far,
            is_reversed: self.is_reversed ^ other.is_reversed,
            is_indefinite: self.is_indefinite | other.is_indefinite,
        }
    }
}
