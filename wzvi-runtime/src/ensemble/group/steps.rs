//! The ways to take the steps of the paths of a group: [`InLanes`](super::in_lanes::InLanes), or
//! [`BySteppers`](super::by_steppers::BySteppers).

use super::paths::LanePaths;
use crate::algebra::state::State;
use crate::algebra::state_sum::PlainSum;
use crate::ensemble::increments::LaneIncrements;
use crate::error::{InternalError, StepError};
use crate::scheme::system::Discretized;
use crate::trajectory::Error;
use crate::trajectory::step::Stepper;

/// Takes the steps of `L` paths, and has their states.
pub(in crate::ensemble) trait StepPaths<'j, H: Discretized<E>, E, const L: usize> {
    /// From step `step` on, steps have this size, and know nothing of those before.
    ///
    /// # Errors
    /// The errors of a system that cannot be prepared.
    fn restart(&mut self, step: u64, size: f64, paths: &LanePaths<L>) -> Result<(), Error>;

    /// Puts the path of a lane into a state.
    fn put(&mut self, lane: usize, q: &H::Vector, p: &H::Vector);

    /// Begins this step of a lane without a guide in its earlier steps.
    ///
    /// # Errors
    /// [`InternalError`] if lanes cannot have memories of their own.
    fn forget(&mut self, _lane: usize, _step: u64) -> Result<(), InternalError> {
        // A stepper compares the state with the one that its last step led to.
        Ok(())
    }

    /// Takes a step of all paths that have not failed.
    ///
    /// # Errors
    /// [`NotTaken`]
    fn step(&mut self, step: GroupStep<'_, 'j, L>) -> Result<(), NotTaken>;

    /// The state of a lane; its time is not set.
    fn state(&mut self, lane: usize) -> &mut State<H::Vector>;

    /// The state of a lane, at this time.
    fn state_at(&mut self, lane: usize, t: f64) -> &mut State<H::Vector> {
        let state = self.state(lane);
        state.t = t;
        state
    }

    /// The stepper of a lane, if it has one.
    fn stepper(&self, _lane: usize) -> Option<&Stepper<'j, H, E, PlainSum>> {
        None
    }
}

/// A step that all paths of a group take.
pub(in crate::ensemble) struct GroupStep<'s, 'j, const L: usize> {
    pub(super) number: u64,
    /// When it begins.
    pub(super) t: f64,
    /// The increments of this step have been drawn.
    pub(super) increments: &'s mut LaneIncrements<'j, L>,
    pub(super) lanes: &'s mut LanePaths<L>,
}

impl<'j, const L: usize> GroupStep<'_, 'j, L> {
    /// A copy of the references for another function: a value whose address is passed does not stay in
    /// registers.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn lend(&mut self) -> GroupStep<'_, 'j, L> {
        let Self { number, t, increments, lanes } = self;
        GroupStep { number: *number, t: *t, increments, lanes }
    }
}

/// A path that cannot take a step, and is where it was.
pub(in crate::ensemble) struct RefusedPath {
    pub(super) lane: usize,
    pub(super) error: StepError,
}

/// Why paths have not taken a step.
pub(in crate::ensemble) enum NotTaken {
    /// Some paths have not, each for a reason of its own; all others have.
    Paths(Vec<RefusedPath>),
    /// The run cannot go on.
    Run(Error),
}

impl NotTaken {
    /// # Errors
    /// The refusal by these paths, if there are any.
    pub(super) fn by(refused: Vec<RefusedPath>) -> Result<(), Self> {
        if refused.is_empty() { Ok(()) } else { Err(Self::Paths(refused)) }
    }
}

impl From<Error> for NotTaken {
    fn from(error: Error) -> Self {
        Self::Run(error)
    }
}

impl From<InternalError> for NotTaken {
    fn from(error: InternalError) -> Self {
        Self::Run(error.into())
    }
}
