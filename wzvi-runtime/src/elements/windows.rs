//! Steps that solve nothing, of large systems: window by window, in the best vector instructions of the machine.
//!
//! A window of the vectors stays in the first cache while its slopes are taken, added to the momenta, and the velocities that
//! follow to the coordinates:
//!
//! ```text
//! P[i] = p[i] - (Σ ∂V/∂q)[i],   q'[i] = q[i] + (Σ ∂T/∂p)(P)[i]
//! ```
//!
//! A step is a few such [rounds](order) in turn: one of `DeltaPlus`, two of `Verlet`. The new state goes beside the old one, which
//! neighbours still read, and replaces it when all of it is known to be finite. Every loop is over neighbours and without branches,
//! so that it becomes vector code. Each sum gets its terms in the order of one pass over all placements, no operation is fused and
//! no sum is parted, so that bits depend neither on windows nor on instructions.

mod check;
mod explicit;
mod layout;
mod order;
mod sums;
mod sweep;
mod word;

use std::ops::Range;

pub(super) use explicit::takes_windows;
pub(super) use sweep::Sweeps;
pub use word::{Flow, Letter, Origin, Word, take_windows};

use check::Check;
use layout::{Recorder, Windows};
use order::{Turn, order};
use sums::{Moved, Window};

use super::step::nothing;
use super::sums::Sums;
use crate::error::StepFailure;
use crate::lanes::instructions::{InstructionSet, Kernel};
use crate::scalar::Number;
use crate::state::Vector;

/// Degrees of freedom from which windows are taken: those of smaller systems are one anyway.
pub const LEAST_IN_WINDOWS: usize = 96;

/// Places of a window. Five stretches of it are used at one time: forces, and both halves of the state before and after.
const SIZE: usize = 512;

/// Windows begin at multiples of it.
pub(crate) const BLOCK: usize = 64;

/// Numbers in a line of the cache: sums start with one.
const LINE: usize = 8;

/// Degrees of freedom up to which the last force is kept for the next step. Of more, it would go through the memory of the machine
/// with the coordinates that it belongs to, which takes longer than its evaluation.
const MOST_KEPT: usize = 1 << 15;

/// How the sum of the slopes by the coordinates of a site, or its terms, come to its momentum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kick {
    /// `p - sum`
    Minus,
    /// `p + (0 - sum)`
    MinusFromZero,
    /// `p + sum`
    Plus,
    /// `((p + term) + term) + ...`
    Terms,
}

/// What is done to every site.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Move {
    Kick(Kick),
    /// Adds velocities to coordinates: their sum, or term by term.
    Drift {
        by_terms: bool,
    },
    /// Changes momenta, one by one.
    Momenta,
    /// Changes coordinates and momenta, one by one.
    State,
}

/// The moves of a step.
trait Moves {
    /// What slopes are computed with, as [`Elements::Exact`](super::Elements::Exact).
    type Exact: Number<f64>;
    /// As [`Elements::Usual`](super::Elements::Usual).
    type Usual: Number<f64>;
    /// Whether each velocity has one term.
    const HAVE_ONE_VELOCITY: bool;
    /// Whether there may be several drifts between two kicks.
    const DRIFT_TWICE: bool;

    fn degrees(&self) -> usize;

    /// Tells where the elements of the system add what, each of them once.
    fn record(&self, recorder: &Recorder);

    /// How many moves there are.
    fn count(&self) -> usize;

    fn kind(&self, number: usize) -> Move;

    /// What the force of a kick depends on besides the coordinates, if it is one at the end of a step, which the next begins with.
    fn origin(&self, number: usize) -> Option<Origin>;

    /// Adds slopes by the coordinates `q`.
    fn add_forces<T: Number<f64>, A: Sums<f64>>(&self, number: usize, q: &[f64], into: &mut A);

    /// Adds slopes by the momenta `p`.
    fn add_velocities<T: Number<f64>, A: Sums<f64>>(&self, number: usize, p: &[f64], into: &mut A);

    /// [`Move::Momenta`] of some places. It may be done again.
    fn change_momenta(&mut self, number: usize, places: Range<usize>, p: &mut [f64]);

    /// [`Move::State`] of some places. It may be done again.
    fn change_state(&mut self, number: usize, places: Range<usize>, q: &mut [f64], p: &mut [f64]);
}

/// Windows of a system, what is needed for one of them, and the new state.
#[derive(Debug)]
pub struct Plan {
    windows: Windows,
    /// The moves of each round.
    rounds: Vec<Range<usize>>,
    turns: Vec<Turn>,
    sums: Vec<f64>,
    instructions: InstructionSet,
    /// Coordinates after the rounds with even and with odd numbers.
    coordinates: [Vec<f64>; 2],
    momenta: Vec<f64>,
    kept: Kept,
}

/// The plan of a system, from the first step on.
pub type WindowPlan = Option<Box<Plan>>;

/// The force that the last step ended with, and where it acted.
#[derive(Debug, Default)]
struct Kept {
    origin: Option<Origin>,
    /// Empty where nothing is kept.
    q: Vec<f64>,
    force: Vec<f64>,
}

impl Kept {
    /// Whether it is the force at `q`.
    #[inline(always)]
    fn is_at(&self, q: &[f64]) -> bool {
        let mut is_same = true;
        for (a, b) in self.q.iter().zip(q) {
            is_same &= a.to_bits() == b.to_bits();
        }
        is_same
    }
}

/// The moves of each round: a kick after a drift begins a new one.
fn rounds(moves: &impl Moves) -> Vec<Range<usize>> {
    let (mut rounds, mut start, mut has_drifted) = (Vec::new(), 0, false);
    for number in 0..moves.count() {
        match moves.kind(number) {
            Move::Kick(_) if has_drifted => {
                rounds.push(start..number);
                (start, has_drifted) = (number, false);
            }
            Move::Drift { .. } | Move::State => has_drifted = true,
            Move::Kick(_) | Move::Momenta => {}
        }
    }
    rounds.push(start..moves.count());
    rounds
}

impl Plan {
    /// Takes down where the elements of a system add what.
    #[cold]
    #[inline(never)]
    fn new(moves: &impl Moves) -> Self {
        let degrees = moves.degrees();
        let recorder = Recorder::default();
        moves.record(&recorder);
        let windows = Windows::new(degrees, SIZE, recorder);
        let sums = vec![nothing(); windows.room() + LINE];
        let rounds = rounds(moves);
        let turns = order(windows.neighbours(), rounds.len());
        let list = |is_needed: bool| vec![0.0; if is_needed { degrees } else { 0 }];
        let is_kept = degrees <= MOST_KEPT && (0..moves.count()).any(|number| moves.origin(number).is_some());
        Self {
            coordinates: [list(true), list(rounds.len() > 2)],
            momenta: list(true),
            kept: Kept { origin: None, q: list(is_kept), force: list(is_kept) },
            windows,
            rounds,
            turns,
            sums,
            instructions: InstructionSet::best(),
        }
    }

    /// The degrees of freedom of the system that it is for.
    pub(crate) fn degrees(&self) -> usize {
        self.momenta.len()
    }

    /// Whether it is one for such moves.
    fn fits(&self, moves: &impl Moves) -> bool {
        self.degrees() == moves.degrees() && self.rounds.last().is_some_and(|last| last.end == moves.count())
    }

    /// The coordinates that the step has led to: no round but the last is without a drift.
    #[inline(always)]
    fn last(&self, moves: &impl Moves) -> usize {
        let drifts = |number| !matches!(moves.kind(number), Move::Kick(_) | Move::Momenta);
        let last_drifts = self.rounds.last().is_some_and(|last| last.clone().any(drifts));
        (self.rounds.len() + usize::from(last_drifts)) % 2
    }
}

/// A step whose numbers are in its plan.
#[derive(Debug)]
pub struct Taken<'p> {
    q: &'p mut Vec<f64>,
    p: &'p mut Vec<f64>,
}

impl Taken<'_> {
    /// Copies the new state.
    pub(crate) fn copy(self, q: &mut [f64], p: &mut [f64]) {
        q.copy_from_slice(self.q);
        p.copy_from_slice(self.p);
    }

    /// Exchanges the vectors of the state for the new ones.
    pub(crate) fn exchange<V: Vector>(self, q: &mut V, p: &mut V) {
        q.exchange(self.q);
        p.exchange(self.p);
    }
}

/// All moves of a step from `q` and `p`.
///
/// # Errors
/// [`StepFailure::NonFinite`] if the new state is not finite.
#[inline(never)]
fn advance<'p, M: Moves>(
    moves: &mut M,
    q: &[f64],
    p: &[f64],
    plan: &'p mut WindowPlan,
) -> Result<Taken<'p>, StepFailure> {
    if plan.as_ref().is_none_or(|plan| !plan.fits(moves)) {
        *plan = Some(Box::new(Plan::new(moves)));
    }
    let plan = plan.get_or_insert_with(|| Box::new(Plan::new(moves)));
    let (instructions, known) = (plan.instructions, plan.kept.origin.take());
    let mut step = InWindows { moves: &mut *moves, q, p, plan: &mut *plan, known };
    if !(instructions.run(&mut step) || step.take_exactly()) {
        return Err(StepFailure::NonFinite);
    }
    if !plan.kept.q.is_empty()
        && let Some(last) = plan.rounds.last()
    {
        plan.kept.origin = last.clone().find_map(|number| moves.origin(number));
    }
    let last = plan.last(moves);
    Ok(Taken { q: &mut plan.coordinates[last], p: &mut plan.momenta })
}

/// One step, window by window.
struct InWindows<'a, M> {
    moves: &'a mut M,
    q: &'a [f64],
    p: &'a [f64],
    plan: &'a mut Plan,
    /// Where the force acted that is kept.
    known: Option<Origin>,
}

/// The output is whether all of the new state is finite.
impl<M: Moves> Kernel for &mut InWindows<'_, M> {
    type Output = bool;

    #[inline(always)]
    fn run<const L: usize, const HALF: usize>(self) -> bool {
        let reuses = self.known.is_some_and(|known| {
            let mut first = self.plan.rounds[0].clone();
            first.find_map(|number| self.moves.origin(number)) == Some(known)
        });
        let reuses = reuses && self.plan.kept.is_at(self.q);
        self.all_turns::<M::Usual>(reuses)
    }
}

impl<M: Moves> InWindows<'_, M> {
    /// The same where a function has an argument that is not usual, or to no avail.
    #[cold]
    #[inline(never)]
    fn take_exactly(&mut self) -> bool {
        self.all_turns::<M::Exact>(false)
    }

    /// The new state; whether it is finite.
    #[inline(always)]
    fn all_turns<T: Number<f64>>(&mut self, reuses: bool) -> bool {
        let Self { moves, q, p, plan, .. } = self;
        let Plan { windows, rounds, turns, sums, coordinates: [even, odd], momenta, kept, .. } = &mut **plan;
        let first = sums[windows.margin()..].as_ptr().align_offset(LINE * size_of::<f64>()).min(LINE);
        let sums = &mut sums[first..];
        let last = rounds.len() - 1;
        let keeps = !kept.q.is_empty() && last > 0;
        let mut check = Check::default();
        for &Turn { round, window } in &*turns {
            let strip = windows.strip(window);
            let places = strip.start..strip.end;
            let (from, to) = match round {
                0 => (*q, &mut **even),
                round if round % 2 == 1 => (&**even, &mut **odd),
                _ => (&**odd, &mut **even),
            };
            // Until something is stored, momenta are those of the state.
            let mut base = (round == 0).then(|| &p[places.clone()]);
            let mut has_drifted = false;
            for number in rounds[round].clone() {
                let kind = moves.kind(number);
                if !matches!(kind, Move::Kick(_))
                    && let Some(base) = base.take()
                {
                    momenta[places.clone()].copy_from_slice(base);
                }
                match kind {
                    Move::Kick(_) if reuses && round == 0 => {
                        let (p, force) = (&mut momenta[places.clone()], &kept.force[places.clone()]);
                        check.store(p, base.take(), force, |p, force| p + force);
                    }
                    Move::Kick(kick) => {
                        let p = &mut momenta[places.clone()];
                        let mut into = match kick {
                            Kick::Terms => Window::onto(strip, sums, base.unwrap_or(p)),
                            _ => Window::empty(strip, sums),
                        };
                        moves.add_forces::<T, _>(number, from, &mut into);
                        let (base, sums) = (base.take(), into.finish());
                        match kick {
                            Kick::Minus => check.store(p, base, sums, |p, sum| p - sum),
                            Kick::MinusFromZero => check.store(p, base, sums, |p, sum| p + (0.0 - sum)),
                            Kick::Plus => check.store(p, base, sums, |p, sum| p + sum),
                            Kick::Terms => check.store(p, base, sums, |_, sum| sum),
                        }
                        if keeps && round == last {
                            kept.force[places.clone()].copy_from_slice(sums);
                            kept.q[places.clone()].copy_from_slice(&from[places.clone()]);
                        }
                    }
                    Move::Drift { .. } if M::HAVE_ONE_VELOCITY && !(M::DRIFT_TWICE && has_drifted) => {
                        let mut moved = Moved { strip, base: from, next: &mut *to };
                        moves.add_velocities::<T, _>(number, momenta, &mut moved);
                        check.look(&to[places.clone()]);
                        has_drifted = true;
                    }
                    Move::Drift { by_terms } => {
                        let base = (!has_drifted).then(|| &from[places.clone()]);
                        let q = &mut to[places.clone()];
                        let mut into = match by_terms {
                            true => Window::onto(strip, sums, base.unwrap_or(q)),
                            false => Window::empty(strip, sums),
                        };
                        moves.add_velocities::<T, _>(number, momenta, &mut into);
                        let sums = into.finish();
                        match by_terms {
                            true => check.store(q, base, sums, |_, sum| sum),
                            false => check.store(q, base, sums, |q, sum| q + sum),
                        }
                        has_drifted = true;
                    }
                    Move::Momenta => {
                        moves.change_momenta(number, places.clone(), &mut momenta[places.clone()]);
                        check.look(&momenta[places.clone()]);
                    }
                    Move::State => {
                        let (q, p) = (&mut to[places.clone()], &mut momenta[places.clone()]);
                        if !has_drifted {
                            q.copy_from_slice(&from[places.clone()]);
                        }
                        moves.change_state(number, places.clone(), q, p);
                        check.look(q);
                        check.look(p);
                        has_drifted = true;
                    }
                }
            }
        }
        check.is_finite()
    }
}
