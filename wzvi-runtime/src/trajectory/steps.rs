//! The loop over the steps of a path: there is one.
//!
//! [`take_steps`] takes steps, each with its increments from a source, and stops at the nodes at which
//! somebody wants to look. What a step is, and what is wanted of the nodes, is the business of [`Advance`]:
//! for one path ([`SinglePath`]), for paths in the lanes of vector registers, or coupled pairs of those.

use std::ops::Range;

use crate::algebra::state::State;
use crate::algebra::state_sum::StateSum;
use crate::increments::{Interval, Noise};
use crate::scheme::system::Discretized;
use crate::trajectory::Error;
use crate::trajectory::step::{StepInfo, Stepper};

/// One path or several, whose nodes are looked at.
pub(crate) trait Advance {
    /// Draws the increments of the step with this number, and takes it. Steps are taken in order.
    ///
    /// # Errors
    /// If the run cannot go on; where it was before, it still is.
    fn advance(&mut self, step: u64) -> Result<(), Error>;

    /// The next node, after this one, to look at. The last node of the run is looked at in any case.
    fn next_node(&self, node: u64) -> u64;

    /// Looks at the node that was reached, and says whether the run goes on.
    ///
    /// # Errors
    /// To end the run there, before its end.
    fn at_node(&mut self, node: u64) -> Result<NodeOutcome, Error>;
}

/// Whether a run goes on from a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NodeOutcome {
    GoesOn,
    /// The run is over: at the end that its clock has reached, or at an event.
    Ends,
}

/// Takes the steps with these numbers, and looks at the nodes that are wanted.
///
/// # Errors
/// The first one, of a step or of a look.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn take_steps<A: Advance>(run: &mut A, steps: Range<u64>) -> Result<(), Error> {
    let mut node = steps.start;
    while node < steps.end {
        let until = run.next_node(node).min(steps.end);
        loop {
            run.advance(node)?;
            node += 1;
            if node >= until {
                break;
            }
        }
        if run.at_node(node)? == NodeOutcome::Ends {
            break;
        }
    }
    Ok(())
}

/// A step to take.
pub(crate) struct StepToTake<'s, V, N> {
    /// The state, which the step replaces.
    pub(crate) state: &'s mut State<V>,
    pub(crate) interval: Interval,
    /// `None` for a system without noise, which is asked for nothing.
    pub(crate) noise: &'s mut Option<N>,
    /// The increments of the step, one per process, which are to be filled in: those of the noises, then
    /// those of a bath.
    pub(crate) dw: &'s mut [f64],
}

/// One path.
pub(crate) struct SinglePath<'r, T, V, N> {
    pub(crate) stepper: &'r mut T,
    pub(crate) state: &'r mut State<V>,
    /// As of a [`StepToTake`].
    pub(crate) noise: &'r mut Option<N>,
    /// Increments of the last step.
    pub(crate) dw: &'r mut [f64],
    /// The first step, number 0.
    pub(crate) first: Interval,
}

impl<T, V, N> SinglePath<'_, T, V, N> {
    /// The stepper, and the step with this number.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn step(&mut self, step: u64) -> (&mut T, StepToTake<'_, V, N>) {
        let Self { stepper, state, noise, dw, first } = self;
        (stepper, StepToTake { state, interval: Interval { step, ..*first }, noise, dw })
    }
}

impl<H: Discretized<E>, E, C: StateSum<f64>> Stepper<'_, H, E, C> {
    /// Fills in the increments of a step, and takes it.
    ///
    /// # Errors
    /// [`Error::Noise`] or [`Error::Step`]; the state is then what it was.
    #[inline]
    pub(crate) fn take_step<N: Noise>(
        &mut self,
        step: StepToTake<'_, H::Vector, N>,
    ) -> Result<StepInfo, Error> {
        let StepToTake { state, interval, noise, dw } = step;
        if let Some(noise) = noise {
            noise.increments(&interval, dw)?;
        }
        Ok(self.step(state, dw)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::ConfigError;

    /// The steps that were taken, and the nodes that were looked at.
    struct Seen {
        steps: Vec<u64>,
        /// Fails at this step.
        bad: Option<u64>,
        stride: u64,
        nodes: Vec<u64>,
        /// Fails at this node.
        last: u64,
        /// Is over at this node.
        over: u64,
    }

    fn wrong(what: &str) -> Error {
        ConfigError::Setting(what.into()).into()
    }

    impl Advance for Seen {
        fn advance(&mut self, step: u64) -> Result<(), Error> {
            if self.bad == Some(step) {
                return Err(wrong("step"));
            }
            self.steps.push(step);
            Ok(())
        }

        fn next_node(&self, node: u64) -> u64 {
            (node / self.stride + 1).saturating_mul(self.stride)
        }

        fn at_node(&mut self, node: u64) -> Result<NodeOutcome, Error> {
            assert_eq!(self.steps.last(), Some(&(node - 1)));
            self.nodes.push(node);
            match node {
                _ if node == self.last => Err(wrong("node")),
                _ if node == self.over => Ok(NodeOutcome::Ends),
                _ => Ok(NodeOutcome::GoesOn),
            }
        }
    }

    #[test]
    fn every_step_is_taken_once_and_every_wanted_node_seen() {
        let run = |steps: Range<u64>, stride, bad, last| {
            let mut path = Seen { steps: vec![], bad, stride, nodes: vec![], last, over: 98 };
            let outcome = take_steps(&mut path, steps);
            (path.steps, path.nodes, outcome)
        };
        assert_eq!(run(0..7, 3, None, 99), ((0..7).collect(), vec![3, 6, 7], Ok(())));
        assert_eq!(run(5..9, 3, None, 99), ((5..9).collect(), vec![6, 9], Ok(())));
        assert_eq!(run(0..3, u64::MAX, None, 99), ((0..3).collect(), vec![3], Ok(())));
        assert_eq!(run(4..4, 1, None, 99), (vec![], vec![], Ok(())));
        assert_eq!(run(0..7, 2, Some(3), 99), (vec![0, 1, 2], vec![2], Err(wrong("step"))));
        assert_eq!(run(0..7, 2, None, 4), (vec![0, 1, 2, 3], vec![2, 4], Err(wrong("node"))));
        assert_eq!(run(95..u64::MAX, 1, None, 99), (vec![95, 96, 97], vec![96, 97, 98], Ok(())));
    }
}
