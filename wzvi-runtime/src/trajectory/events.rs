//! Events: what happens to a path at a crossing or at a time.
//!
//! [`Simulation::on`](crate::trajectory::simulate::Simulation::on) locates the crossings of a function of the
//! state, as a [section](crate::trajectory::section) does, and changes the state there;
//! [`Simulation::on_time`](crate::trajectory::simulate::Simulation::on_time) does so at a given time. A
//! bouncing ball, a kicked rotor, a staged rocket and a reset are events:
//!
//! ```ignore
//! // A ball that keeps 0.9 of its speed at the floor.
//! let path = ball.simulate::<Verlet>(0.01).start(start)
//!     .on_towards(Direction::Falling, |s| s.q[0], |s| s.p[0] *= -0.9)
//!     .until(3.0).run()?;
//! assert_eq!(path.events()[0].before.p[0] * -0.9, path.events()[0].after.p[0]);
//! ```
//!
//! **What an event does.** It divides its step: a single step of the scheme leads from the node before to the
//! crossing, where Newton's method on the length of this step puts the function to zero; another one leads
//! from the changed state to the end of the step. The nodes stay where they are, so that recorded nodes,
//! checkpoints and the numbers of increments are those of a run without events. With noise the parts of a
//! step take the Brownian bridge of its increments. The energy is monitored anew after an event, and the work
//! of the path includes the change of energy there. A path by a [clock](crate::scheme::clock) starts its
//! clock anew at the next node.
//!
//! **What counts.** A change of sign, in one direction or in both, as for sections. After its event a path is
//! on the side to which it moves, and behind the crossing if the action changed nothing. For the other events
//! it stays on the side on which it was, unless the action changed their values. With noise only signs at
//! nodes and at events are compared. Several events in one step happen in the order of time; a path that is
//! asked for its state at the time of an event has the one after it. With constraints, an action leads to the
//! manifold by a projection. More than a thousand in one step end the run
//! ([`StepFailure::TooManyEvents`](crate::error::StepFailure::TooManyEvents)): a ball that comes to rest
//! bounces infinitely often in finite time.
//!
//! An action that returns [`Terminal`] ends the run at the event.
//!
//! Tested by `tests/paths/events.rs`.

use std::fmt;
use std::sync::Arc;

use crate::algebra::state::{State, Vector};
use crate::ground::numbers::Tape;
use crate::trajectory::options::Observable;
use crate::trajectory::section::Direction;

/// Ends a run at an event: `.on(|s| s.q[0] - 1.0, |_| Terminal)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terminal;

/// Whether a run goes on after an event: what an action returns. `()` goes on, [`Terminal`] ends the run, and
/// `Option<Terminal>` decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AfterEvent {
    /// The run goes on from the changed state.
    GoOn,
    /// The run ends there.
    End,
}

impl From<()> for AfterEvent {
    fn from((): ()) -> Self {
        Self::GoOn
    }
}

impl From<Terminal> for AfterEvent {
    fn from(Terminal: Terminal) -> Self {
        Self::End
    }
}

impl From<Option<Terminal>> for AfterEvent {
    fn from(terminal: Option<Terminal>) -> Self {
        terminal.map_or(Self::GoOn, Self::from)
    }
}

/// An event of a path.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Event<V> {
    /// Its number, in the order in which `on`, `on_towards` and `on_time` were called, from 0.
    pub event: usize,
    /// The state where it happened, at its time.
    pub before: State<V>,
    /// The state that the action made of it, at the same time.
    pub after: State<V>,
}

impl<V: Vector> Event<V> {
    /// To be replaced by what a tape says.
    pub(crate) fn like(state: &State<V>) -> Self {
        Self { event: 0, before: state.clone(), after: state.clone() }
    }

    pub(crate) fn pass(&mut self, tape: &mut Tape) {
        let mut event = self.event as u64;
        tape.word(&mut event);
        self.event = usize::try_from(event).unwrap_or(usize::MAX);
        self.before.pass(tape);
        self.after.pass(tape);
    }
}

/// When an event happens.
pub(crate) enum EventPlace<'a, V> {
    /// Where a function of the state changes its sign, in one direction or in both.
    Crossing(Option<Direction>, Observable<'a, V>),
    /// At a time.
    Time(f64),
}

/// A change of the state.
pub(crate) type Action<'a, V> = Arc<dyn Fn(&mut State<V>) -> AfterEvent + Send + Sync + 'a>;

/// A requested event.
pub(crate) struct EventRule<'a, V> {
    pub(crate) place: EventPlace<'a, V>,
    pub(crate) action: Action<'a, V>,
}

/// The requested events, by number.
pub(crate) struct EventRules<'a, V>(pub(crate) Vec<EventRule<'a, V>>);

impl<V> Clone for EventPlace<'_, V> {
    fn clone(&self) -> Self {
        match self {
            Self::Crossing(direction, value) => Self::Crossing(*direction, value.clone()),
            Self::Time(t) => Self::Time(*t),
        }
    }
}

impl<V> Clone for EventRule<'_, V> {
    fn clone(&self) -> Self {
        Self { place: self.place.clone(), action: self.action.clone() }
    }
}

impl<V> Clone for EventRules<'_, V> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<V> Default for EventRules<'_, V> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<V> fmt::Debug for EventRules<'_, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let places = self.0.iter().map(|rule| match &rule.place {
            EventPlace::Crossing(direction, _) => format!("crossing {direction:?}"),
            EventPlace::Time(t) => format!("t = {t}"),
        });
        f.debug_list().entries(places).finish()
    }
}

impl<'a, V> EventRules<'a, V> {
    pub(crate) fn push<R: Into<AfterEvent>>(
        &mut self,
        place: EventPlace<'a, V>,
        action: impl Fn(&mut State<V>) -> R + Send + Sync + 'a,
    ) {
        self.0.push(EventRule { place, action: Arc::new(move |state| action(state).into()) });
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The crossings, each with its number among all events.
    pub(crate) fn crossings(&self) -> impl Iterator<Item = (usize, Option<Direction>, &Observable<'a, V>)> {
        self.0.iter().enumerate().filter_map(|(number, rule)| match &rule.place {
            EventPlace::Crossing(direction, value) => Some((number, *direction, value)),
            EventPlace::Time(_) => None,
        })
    }

    /// The times, each with its number among all events.
    pub(crate) fn times(&self) -> impl Iterator<Item = (usize, f64)> {
        self.0.iter().enumerate().filter_map(|(number, rule)| match rule.place {
            EventPlace::Time(t) => Some((number, t)),
            EventPlace::Crossing(..) => None,
        })
    }

    /// The events in words, for checkpoints.
    pub(crate) fn in_words(&self) -> String {
        let words = self.0.iter().map(|rule| match &rule.place {
            EventPlace::Crossing(Some(Direction::Rising), _) => "rising".to_owned(),
            EventPlace::Crossing(Some(Direction::Falling), _) => "falling".to_owned(),
            EventPlace::Crossing(None, _) => "both".to_owned(),
            EventPlace::Time(t) => format!("t = {t:?}"),
        });
        words.collect::<Vec<_>>().join(", ")
    }
}
