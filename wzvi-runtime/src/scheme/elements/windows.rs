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
mod share;
mod sums;
mod sweep;
mod word;

use std::ops::Range;

pub(super) use explicit::takes_windows;
pub(super) use sweep::Sweeps;
pub use word::{Flow, Letter, Origin, Word, take_windows};

use layout::{Recorder, Windows};
use order::{Turn, divided};
use share::{Job, Room, Taking};

use super::step::nothing;
use super::sums::{Given, Sums};
use crate::algebra::lanes::instructions::{InstructionSet, Kernel};
use crate::algebra::scalar::Number;
use crate::algebra::state::Vector;
use crate::algebra::threads::Threads;
use crate::error::StepFailure;

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

/// Degrees of freedom that are worth a thread of their own: a step of so many takes some 200 µs, and to begin a thread and to wait for it
/// some 50 µs, up to 100 where the machine does something else besides (`cargo bench --bench elements -- memory`).
const LEAST_OF_THREAD: usize = 1 << 17;

/// How the sum of the slopes by the coordinates of a site, or its terms, come to its momentum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kick {
    /// `p - sum`
    Minus,
    /// `p + (0 - sum)`
    MinusFromZero,
    /// `p + sum`, in a word
    Plus,
    /// `((p + term) + term) + ...`, in a word
    Terms,
}

/// What is done to every site.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Move {
    Kick(Kick),
    /// Adds velocities to coordinates: their sum, or term by term in a word.
    Drift,
    /// Changes momenta, one by one.
    Momenta,
    /// Changes coordinates and momenta, one by one.
    State,
}

/// The moves of a step.
trait Moves {
    /// The same for the time of a step, which threads may have.
    type Share<'s>: Moves + Send
    where
        Self: 's;
    /// What slopes are computed with, as [`Elements::Exact`](super::Elements::Exact).
    type Exact: Number<f64>;
    /// As [`Elements::Usual`](super::Elements::Usual).
    type Usual: Number<f64>;
    /// Whether each velocity has one term.
    const HAVE_ONE_VELOCITY: bool;
    /// Whether it is a [`Word`].
    const IS_WORD: bool;
    /// Whether there are [`Move::Momenta`] or [`Move::State`], and several drifts may be between two kicks.
    const CHANGES: bool;

    /// All places.
    fn share(&mut self) -> Self::Share<'_>;

    /// Those before a place, and those from it on.
    fn divide(self, place: usize) -> [Self; 2]
    where
        Self: Sized;

    fn degrees(&self) -> usize;

    /// Tells where the elements of the system add what, each of them once.
    fn record(&self, recorder: &Recorder);

    /// How many moves there are.
    fn count(&self) -> usize;

    fn kind(&self, number: usize) -> Move;

    /// What the force of a kick depends on besides the coordinates, if it is one at the end of a step, which the next begins with.
    fn origin(&self, number: usize) -> Option<Origin>;

    /// Adds slopes by the coordinates `q`.
    fn add_forces<T, V, A>(&self, number: usize, q: &V, into: &mut A)
    where
        T: Number<f64>,
        V: Given<f64> + ?Sized,
        A: Sums<f64>;

    /// Adds slopes by the momenta `p`.
    fn add_velocities<T, V, A>(&self, number: usize, p: &V, into: &mut A)
    where
        T: Number<f64>,
        V: Given<f64> + ?Sized,
        A: Sums<f64>;

    /// [`Move::Momenta`] of some places. It may be done again.
    fn change_momenta(&mut self, number: usize, places: Range<usize>, p: &mut [f64]);

    /// [`Move::State`] of some places. It may be done again.
    fn change_state(&mut self, number: usize, places: Range<usize>, q: &mut [f64], p: &mut [f64]);
}

/// The windows of a system from the first step on, and on how many threads they are to be taken.
#[derive(Debug, Default)]
pub struct WindowPlan {
    threads: Threads,
    plan: Option<Box<Plan>>,
}

impl WindowPlan {
    /// One for as many threads, of a system that is not known yet.
    pub(crate) fn alike(&self) -> Self {
        Self { threads: self.threads, plan: None }
    }

    /// What [`StepMemory::share`](crate::algebra::memory::StepMemory::share) says.
    pub(crate) fn share(&mut self, threads: Threads) {
        *self = Self { threads, plan: None };
    }

    /// On how many threads windows are to be taken.
    pub(crate) fn threads(&self) -> Threads {
        self.threads
    }

    /// The degrees of freedom of the system, if it is known.
    pub(crate) fn degrees(&self) -> Option<usize> {
        self.plan.as_deref().map(Plan::degrees)
    }
}

/// Windows of a system, what is needed for one of them at a time, and the new state.
#[derive(Debug)]
struct Plan {
    windows: Windows,
    /// The moves of each round.
    rounds: Vec<Range<usize>>,
    /// Windows that a thread each takes, as far as it can; none if there is one thread.
    shares: Vec<Share>,
    /// The turns that come then.
    rest: Share,
    instructions: InstructionSet,
    /// Coordinates after the rounds with even and with odd numbers.
    coordinates: [Vec<f64>; 2],
    momenta: Vec<f64>,
    kept: Kept,
}

/// The turns of a thread, and room for the sums of a window.
#[derive(Debug)]
struct Share {
    /// Where its windows end.
    end: usize,
    turns: Vec<Turn>,
    sums: Vec<f64>,
}

/// The force that the last step ended with, and where it acted.
#[derive(Debug, Default)]
struct Kept {
    origin: Option<Origin>,
    /// Empty where nothing is kept.
    q: Vec<f64>,
    force: Vec<f64>,
}

/// Whether all bits are the same.
struct IsSame<'a>(&'a [f64], &'a [f64]);

impl Kernel for IsSame<'_> {
    type Output = bool;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) -> bool {
        let mut is_same = true;
        for (a, b) in self.0.iter().zip(self.1) {
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
            Move::Drift | Move::State => has_drifted = true,
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
    fn new(moves: &impl Moves, threads: Threads) -> Self {
        let degrees = moves.degrees();
        let recorder = Recorder::default();
        moves.record(&recorder);
        let windows = Windows::new(degrees, SIZE, recorder);
        let rounds = rounds(moves);
        let (shares, rest) = Self::shares(&windows, rounds.len(), threads.number(degrees / LEAST_OF_THREAD));
        let list = |is_needed: bool| vec![0.0; if is_needed { degrees } else { 0 }];
        let is_kept = degrees <= MOST_KEPT && (0..moves.count()).any(|number| moves.origin(number).is_some());
        Self {
            coordinates: [list(true), list(rounds.len() > 2)],
            momenta: list(true),
            kept: Kept { origin: None, q: list(is_kept), force: list(is_kept) },
            windows,
            rounds,
            shares,
            rest,
            instructions: InstructionSet::best(),
        }
    }

    /// The turns of each thread, and those that come then.
    fn shares(windows: &Windows, rounds: usize, threads: usize) -> (Vec<Share>, Share) {
        let all = windows.neighbours().len();
        let parts = if threads.min(all) < 2 { Vec::new() } else { windows.portions(threads).collect() };
        let share = |windows_of: &Range<usize>, turns| {
            let end = windows_of.end.checked_sub(1).map_or(0, |last| windows.strip(last).end);
            Share { end, turns, sums: vec![nothing(); windows.room() + LINE] }
        };
        let (turns, rest) = divided(windows.neighbours(), rounds, &parts);
        let shares = parts.iter().zip(turns).map(|(windows_of, turns)| share(windows_of, turns)).collect();
        (shares, share(&(0..all), rest))
    }

    /// The degrees of freedom of the system that it is for.
    fn degrees(&self) -> usize {
        self.momenta.len()
    }

    /// Whether it is one for such moves.
    fn fits(&self, moves: &impl Moves) -> bool {
        self.degrees() == moves.degrees() && self.rounds.last().is_some_and(|last| last.end == moves.count())
    }

    /// The coordinates that the step has led to: no round but the last is without a drift.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn last(&self, moves: &impl Moves) -> usize {
        let drifts = |number| !matches!(moves.kind(number), Move::Kick(_) | Move::Momenta);
        let last_drifts = self.rounds.last().is_some_and(|last| last.clone().any(drifts));
        (self.rounds.len() + usize::from(last_drifts)) % 2
    }

    /// Whether the first force is the one that is kept.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn reuses(&mut self, moves: &impl Moves, q: &[f64]) -> bool {
        let Some(known) = self.kept.origin.take() else { return false };
        let first = self.rounds[0].clone().find_map(|number| moves.origin(number));
        first == Some(known) && self.instructions.run(IsSame(&self.kept.q, q))
    }

    /// What all turns of a step from `q` and `p` need: of all threads, of each, of those that come then, and where they write.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn parts<'a>(
        &'a mut self,
        [q, p]: [&'a [f64]; 2],
        reuses: bool,
    ) -> (Taking<'a>, &'a mut [Share], &'a mut Share, Room<'a>) {
        let Self { windows, rounds, shares, rest, coordinates: [even, odd], momenta, kept, .. } = self;
        let room = Room { first: 0, even, odd, momenta, kept: [&mut kept.q, &mut kept.force] };
        (Taking { windows, rounds, q, p, reuses }, shares, rest, room)
    }

    /// All turns of a step; whether the new state is finite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take<M: Moves>(&mut self, moves: &mut M, state: [&[f64]; 2], reuses: bool) -> bool {
        let instructions = self.instructions;
        let (step, shares, rest, mut room) = self.parts(state, reuses);
        let of_threads =
            shares.is_empty() || step.on_threads::<M, M::Usual>(moves, shares, room.lend(), instructions);
        of_threads && Job::<_, M::Usual, true>::new(step, moves.share(), rest, room).run_in(instructions)
    }

    /// The same on one thread where a function has an argument that is not usual, or to no avail.
    #[cold]
    #[inline(never)]
    fn take_exactly<M: Moves>(&mut self, moves: &mut M, state: [&[f64]; 2]) -> bool {
        let (step, shares, rest, mut room) = self.parts(state, false);
        shares
            .iter_mut()
            .chain([rest])
            .all(|share| Job::<_, M::Exact, true>::new(step, moves.share(), share, room.lend()).run::<1, 1>())
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
    WindowPlan { threads, plan }: &'p mut WindowPlan,
) -> Result<Taken<'p>, StepFailure> {
    if plan.as_ref().is_none_or(|plan| !plan.fits(moves)) {
        *plan = None;
    }
    let plan = plan.get_or_insert_with(|| Box::new(Plan::new(moves, *threads)));
    let reuses = plan.reuses(moves, q);
    if !(plan.take(moves, [q, p], reuses) || plan.take_exactly(moves, [q, p])) {
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
