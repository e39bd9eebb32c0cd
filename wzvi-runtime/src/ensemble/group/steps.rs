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

    /// Takes the step with this number, whose increments have been drawn, of all paths that have not failed.
    ///
    /// # Errors
    /// [`NotTaken`]
    fn step(&mut self, number: u64, paths: &mut DrivenPaths<'j, L>) -> Result<(), Box<NotTaken>>;

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

/// The paths of a group, and what drives them.
pub(in crate::ensemble) struct DrivenPaths<'j, const L: usize> {
    pub(in crate::ensemble) lanes: LanePaths<L>,
    pub(super) increments: LaneIncrements<'j, L>,
}

/// A path that cannot take a step, and is where it was.
pub(in crate::ensemble) struct RefusedPath {
    pub(super) lane: usize,
    pub(super) error: StepError,
}

/// Why paths have not taken a step. It is returned in a box: a result that fits into a register costs nothing
/// where it is passed on.
pub(in crate::ensemble) enum NotTaken {
    /// Some paths have not, each for a reason of its own; all others have.
    Paths(Vec<RefusedPath>),
    /// The run cannot go on.
    Run(Error),
}

impl NotTaken {
    /// # Errors
    /// The refusal by these paths, if there are any.
    pub(super) fn by(refused: Vec<RefusedPath>) -> Result<(), Box<Self>> {
        if refused.is_empty() { Ok(()) } else { Err(Self::Paths(refused).into()) }
    }
}

impl From<Error> for Box<NotTaken> {
    fn from(error: Error) -> Self {
        NotTaken::Run(error).into()
    }
}

impl From<InternalError> for Box<NotTaken> {
    fn from(error: InternalError) -> Self {
        NotTaken::Run(error.into()).into()
    }
}
