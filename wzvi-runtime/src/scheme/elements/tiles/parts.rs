//! The parts of a word, as they move tiles.

use std::ops::Range;

use super::{NewState, TilePlan, advance};
use crate::algebra::scalar::{Number, Scalar};
use crate::error::StepFailure;
use crate::scheme::elements::{ElementInput, Elements, Partials, Sums};
use crate::scheme::word::Substep;

/// A flow of the step Hamiltonian `h H_0 + Σ_k ΔW_k H_k`, or of a part of it, as the force or the velocity
/// that it adds.
#[derive(Clone, Copy, Debug)]
pub struct Flow<'a, S: Scalar> {
    /// The time at which it is evaluated.
    pub t: S::Constant,
    /// The increment of the drift, negative for a kick.
    pub h: S::Constant,
    /// As in [`EvaluationPoint`](crate::scheme::elements::EvaluationPoint).
    pub parameters: &'a [S::Constant],
    /// The increments of the noises, negative for a kick.
    pub dw: &'a [S],
}

/// The arguments of a force other than the coordinates.
#[derive(Clone, Copy, Debug)]
pub struct ForceArguments {
    /// The time, if the force reads it.
    pub t: Option<f64>,
    /// The increment of the drift.
    pub h: f64,
}

/// Compares all bits.
impl PartialEq for ForceArguments {
    fn eq(&self, other: &Self) -> bool {
        self.h.to_bits() == other.h.to_bits() && self.t.map(f64::to_bits) == other.t.map(f64::to_bits)
    }
}

/// How the parts of a word move tiles, on several threads at once: each has its own places.
pub trait TileParts: Copy + Send + Sync {
    /// Whether derivatives have the sign with which they are added. If not, the first kick is `p - sum` and a
    /// later one `p + (0 - sum)`.
    const ADDS_TERMS: bool = true;
    /// Whether there are O parts, and possibly several drifts between two kicks.
    const RELAXES: bool = false;
    /// Whether sums are compensated, of kicks and drifts with `p + sum` and `q + sum` alone.
    const CARRIES: bool = false;

    /// The parts of the word.
    fn substeps(&self) -> &[Substep];

    /// The arguments of the force of a kick other than the coordinates, if the kick is at an end of the step,
    /// where the force may be reused.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn origin(&self, kick: &Substep) -> Option<ForceArguments> {
        let _ = kick;
        None
    }

    /// Adds the derivatives by `state` of a kick or a drift: the coordinates for a kick, the momenta for a
    /// drift.
    fn add_gradient<H, T, V, A>(&self, system: &H, flow: &Substep, state: &V, wanted: Partials, into: &mut A)
    where
        H: Elements + Sync,
        T: Number<f64>,
        V: ElementInput<f64> + ?Sized,
        A: Sums<f64>;

    /// The rounding errors of coordinates and of momenta before the step, if sums are compensated.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lost(&self) -> [&[f64]; 2] {
        [&[]; 2]
    }

    /// Takes an O part, `Part::O` with the momenta of some places, and what rounding took from them if sums
    /// are compensated, or `Part::AOA`, which also moves the coordinates `q`; may be called again.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn relax(&self, substep: &Substep, places: Range<usize>, q: &mut [f64], p: &mut [f64], lost: &mut [f64]) {
        let _ = (substep, places, q, p, lost);
    }
}

/// Takes all parts of a step from `q` and `p`, if the system [has
/// tiles](crate::scheme::plan::Facts::has_tiles).
///
/// # Errors
/// [`StepFailure::NonFinite`] if the new state is not finite.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn take_tiles<'p, H: Elements + Sync, W: TileParts>(
    system: &H,
    word: &mut W,
    q: &[f64],
    p: &[f64],
    plan: &'p mut TilePlan,
) -> Option<Result<NewState<'p>, StepFailure>> {
    H::FACTS.has_tiles.then(|| advance(system, *word, [q, p], plan))
}
