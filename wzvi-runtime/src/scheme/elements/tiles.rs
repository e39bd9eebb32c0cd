//! Explicit steps of large systems, tile by tile, in the best vector instructions of the machine.
//!
//! A tile of the vectors stays in the first-level cache while its forces are added to the momenta and the
//! resulting velocities to the coordinates:
//!
//! ```text
//! P[i] = p[i] - (Σ ∂V/∂q)[i],   q'[i] = q[i] + (Σ ∂T/∂p)(P)[i]
//! ```
//!
//! This is the executor of words (`scheme/word.rs`) for large systems. A word is a sequence of rounds: one
//! for `DeltaPlus`, two for `Verlet`; [`wavefront`] orders those of all tiles. The new state is written to
//! separate vectors, as neighbours still read the old one, and replaces it once all of it is known to be
//! finite. Every loop runs over adjacent entries without branches, so that it is vectorised. Each sum gets
//! its terms in the order of one pass over all placements, no operation is fused and no sum is split, so that
//! the bits depend neither on tiles nor on instructions.

mod check;
mod explicit;
mod layout;
mod parts;
mod rounds;
mod sums;
mod sweep;
mod thread_tiles;
mod wavefront;

use std::ops::Range;

pub(super) use explicit::takes_tiles;
pub use parts::{Flow, ForceArguments, TileParts, take_tiles};
pub(super) use sweep::TiledSweeps;

use layout::{PlacementRecorder, Tiling};
use rounds::{ThreadRounds, TiledStepInput, Wavefront};
use thread_tiles::{ThreadLists, TileResult, on_threads};
use wavefront::divided;

use super::{Elements, Partials};
use crate::algebra::lanes::instructions::{InstructionSet, Kernel};
use crate::algebra::scalar::Scalar;
use crate::algebra::state_sum::StateSum;
use crate::algebra::threads::Threads;
use crate::error::StepFailure;
use crate::scheme::system::Movable;
use crate::scheme::word::{Part, Substep};

/// Degrees of freedom from which steps other than those of kicks and drifts go tile by tile; a smaller system
/// is a single tile anyway.
pub const LEAST_IN_TILES: usize = 96;

/// Degrees of freedom up to which kicks and drifts go over the whole state at once: it is a single tile, and
/// a step in tiles has an overhead of some 150 ns. Measured for chains of 8 to 512 sites, with and without
/// functions and baths; at 512 both take the same time. `cargo bench --workspace --bench speed -- chain`,
/// with this constant and with zero, shows it for those without.
pub(crate) const MOST_IN_ONE_TILE: usize = SIZE;

/// Number of places of a tile. Five slices of this length are in use at a time: forces, and both halves of
/// the state before and after.
const SIZE: usize = 512;

/// Tiles begin at multiples of this.
pub(crate) const BLOCK: usize = 64;

/// Numbers in a cache line; sums are aligned to one.
const LINE: usize = 8;

/// Degrees of freedom up to which the last force is kept for the next step. In larger systems the force and
/// its coordinates would go through main memory, which takes longer than a new evaluation.
const MOST_KEPT: usize = 1 << 15;

/// Least number of degrees of freedom for each thread: a step of this size takes some 200 µs, and starting
/// and joining a thread some 50 µs, up to 100 µs on a busy machine
/// (`cargo bench --workspace --bench elements -- memory`).
const LEAST_OF_THREAD: usize = 1 << 17;

/// The tiles of a system, made by the first step, and the threads that share them.
#[derive(Debug, Default)]
pub struct TilePlan {
    threads: Threads,
    plan: Option<Box<TiledStep>>,
}

impl TilePlan {
    /// A plan for the same threads, without tiles yet.
    pub(crate) fn alike(&self) -> Self {
        Self { threads: self.threads, plan: None }
    }

    /// Goes tile by tile on this many threads:
    /// [`MemoryRequest::Share`](crate::algebra::memory::MemoryRequest::Share).
    pub(crate) fn share(&mut self, threads: Threads) {
        *self = Self { threads, plan: None };
    }

    /// The threads that share the tiles.
    pub(crate) fn threads(&self) -> Threads {
        self.threads
    }

    /// The degrees of freedom of the system, if it is known.
    pub(crate) fn degrees(&self) -> Option<usize> {
        self.plan.as_deref().map(TiledStep::degrees)
    }
}

/// The tiles of a system, scratch for one tile at a time, and the new state.
#[derive(Debug)]
struct TiledStep {
    tiles: Tiling,
    /// The parts of each round.
    rounds: Vec<Range<usize>>,
    /// The rounds that each thread takes independently of the others; empty for a single thread.
    shares: Vec<ThreadRounds>,
    /// The remaining rounds.
    rest: ThreadRounds,
    instructions: InstructionSet,
    /// Coordinates after the rounds with even and with odd numbers.
    coordinates: [Vec<f64>; 2],
    momenta: Vec<f64>,
    /// The rounding errors of coordinates and momenta; empty for plain sums.
    lost: [Vec<f64>; 2],
    kept: ForceCache,
}

/// The force at the end of the last step, and where it acted.
#[derive(Debug, Default)]
struct ForceCache {
    origin: Option<ForceArguments>,
    /// Empty if no force is kept.
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

/// The parts of each round: a kick after a drift begins a new one.
fn rounds(substeps: &[Substep]) -> Vec<Range<usize>> {
    let (mut rounds, mut start, mut has_drifted) = (Vec::new(), 0, false);
    for (number, substep) in substeps.iter().enumerate() {
        if substep.part.is_kick() && has_drifted {
            rounds.push(start..number);
            (start, has_drifted) = (number, false);
        }
        has_drifted |= substep.part.drifts();
    }
    rounds.push(start..substeps.len());
    rounds
}

impl TiledStep {
    /// Records the places that the elements of a system add to, each element once.
    #[cold]
    #[inline(never)]
    fn new<H: Elements + Sync, W: TileParts>(
        system: &H,
        word: &W,
        [q, p]: [&[f64]; 2],
        threads: Threads,
    ) -> Self {
        let (degrees, recorder) = (q.len(), PlacementRecorder::default());
        for (state, wanted) in [(q, Partials::BY_COORDINATES), (p, Partials::BY_MOMENTA)] {
            let adds = |substep: &&Substep| match substep.part {
                Part::B | Part::GradientB(_) => wanted.by_q,
                Part::A => wanted.by_p,
                Part::O | Part::AOA => false,
            };
            // The first kick of a scheme may add nothing.
            if let Some(flow) = word.substeps().iter().rfind(adds) {
                word.add_gradient::<H, f64, _, _>(system, flow, state, wanted, &mut &recorder);
            }
        }
        let tiles = Tiling::new(degrees, SIZE, recorder);
        let rounds = rounds(word.substeps());
        let (shares, rest) = Self::shares(&tiles, rounds.len(), threads.number(degrees / LEAST_OF_THREAD));
        let list = |is_needed: bool| vec![0.0; if is_needed { degrees } else { 0 }];
        let is_kept =
            degrees <= MOST_KEPT && word.substeps().iter().any(|substep| word.origin(substep).is_some());
        Self {
            coordinates: [list(true), list(rounds.len() > 2)],
            momenta: list(true),
            lost: [list(W::CARRIES), list(W::CARRIES)],
            kept: ForceCache { origin: None, q: list(is_kept), force: list(is_kept) },
            tiles,
            rounds,
            shares,
            rest,
            instructions: InstructionSet::best(),
        }
    }

    /// The rounds of each thread, and the remaining ones.
    fn shares(tiles: &Tiling, rounds: usize, threads: usize) -> (Vec<ThreadRounds>, ThreadRounds) {
        let all = tiles.neighbours().len();
        let parts = if threads.min(all) < 2 { Vec::new() } else { tiles.by_thread(threads).collect() };
        let (tile_rounds, rest) = divided(tiles.neighbours(), rounds, &parts);
        let shares = parts
            .iter()
            .zip(tile_rounds)
            .map(|(own, tile_rounds)| ThreadRounds::new(tiles, own, tile_rounds))
            .collect();
        (shares, ThreadRounds::new(tiles, &(0..all), rest))
    }

    /// The degrees of freedom of the system of this plan.
    fn degrees(&self) -> usize {
        self.momenta.len()
    }

    /// Whether the plan is for the parts of `word` and this number of degrees of freedom.
    fn fits<W: TileParts>(&self, word: &W, degrees: usize) -> bool {
        let carries = !self.lost[0].is_empty();
        self.degrees() == degrees
            && carries == W::CARRIES
            && self.rounds.last().is_some_and(|last| last.end == word.substeps().len())
    }

    /// The index of the list with the new coordinates: only the last round may be without a drift.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn last(&self, word: &impl TileParts) -> usize {
        let drifts = |last: &Range<usize>| word.substeps()[last.clone()].iter().any(|s| s.part.drifts());
        let last_drifts = self.rounds.last().is_some_and(drifts);
        (self.rounds.len() + usize::from(last_drifts)) % 2
    }

    /// Whether the first force of the step is the kept one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn reuses(&mut self, word: &impl TileParts, q: &[f64]) -> bool {
        let Some(known) = self.kept.origin.take() else { return false };
        let first = word.substeps()[self.rounds[0].clone()].iter().find_map(|substep| word.origin(substep));
        first == Some(known) && self.instructions.run(IsSame(&self.kept.q, q))
    }

    /// The data of a step from `q` and `p`: common to all rounds, of each thread, of the remaining rounds,
    /// and the output lists.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn parts<'a>(
        &'a mut self,
        [q, p]: [&'a [f64]; 2],
        reuses: bool,
    ) -> (TiledStepInput<'a>, &'a mut [ThreadRounds], &'a mut ThreadRounds, [&'a mut [f64]; 7]) {
        let Self { tiles, rounds, shares, rest, coordinates: [even, odd], momenta, lost, kept, .. } = self;
        let [lost_q, lost_p] = lost;
        let lists = [even, odd, momenta, &mut kept.q, &mut kept.force, lost_q, lost_p].map(Vec::as_mut_slice);
        (TiledStepInput { tiles, rounds, q, p, reuses }, shares, rest, lists)
    }

    /// Takes all rounds of a step; returns whether the new state is finite.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn take_rounds<H: Elements + Sync, W: TileParts>(
        &mut self,
        system: &H,
        word: W,
        state: [&[f64]; 2],
        reuses: bool,
    ) -> bool {
        let instructions = self.instructions;
        let (step, shares, rest, mut lists) = self.parts(state, reuses);
        let of_threads = on_threads(shares, lend(&mut lists), |share, part| {
            let job = Wavefront::<_, _, H::CommonRange, false>::new(step, system, word, share, part);
            TileResult::finite(instructions.run(job))
        });
        let all = ThreadLists { first: 0, lists };
        of_threads.is_finite
            && instructions.run(Wavefront::<_, _, H::CommonRange, true>::new(step, system, word, rest, all))
    }

    /// Takes all rounds on one thread in exact numbers, for arguments that vectorised functions do not cover.
    /// Fails if the state is not finite.
    #[cold]
    #[inline(never)]
    fn take_exactly<H: Elements + Sync, W: TileParts>(
        &mut self,
        system: &H,
        word: W,
        state: [&[f64]; 2],
    ) -> bool {
        let (step, shares, rest, mut lists) = self.parts(state, false);
        shares.iter_mut().chain([rest]).all(|share| {
            let all = ThreadLists { first: 0, lists: lend(&mut lists) };
            Wavefront::<_, _, f64, true>::new(step, system, word, share, all).run::<1, 1>()
        })
    }
}

/// Lends the lists for a part of their use.
fn lend<'a, const N: usize>(lists: &'a mut [&mut [f64]; N]) -> [&'a mut [f64]; N] {
    lists.each_mut().map(|list| &mut **list)
}

/// The new state of a step, stored in its plan.
#[derive(Debug)]
pub struct NewState<'p> {
    q: &'p mut Vec<f64>,
    p: &'p mut Vec<f64>,
    lost: &'p mut [Vec<f64>; 2],
}

impl NewState<'_> {
    /// Moves lists or vectors to the new state, and keeps what rounding took from it.
    pub(crate) fn store<S: Scalar, C: StateSum<S>>(
        self,
        q: &mut (impl Movable<S> + ?Sized),
        p: &mut (impl Movable<S> + ?Sized),
        carry: &mut C,
    ) {
        q.exchange(self.q);
        p.exchange(self.p);
        carry.exchange(self.lost.each_mut());
    }
}

/// Takes all parts of a step from `q` and `p`.
///
/// # Errors
/// [`StepFailure::NonFinite`] if the new state is not finite.
#[inline(never)]
fn advance<'p, H: Elements + Sync, W: TileParts>(
    system: &H,
    word: W,
    state: [&[f64]; 2],
    TilePlan { threads, plan }: &'p mut TilePlan,
) -> Result<NewState<'p>, StepFailure> {
    if plan.as_ref().is_none_or(|plan| !plan.fits(&word, state[0].len())) {
        *plan = None;
    }
    let plan = plan.get_or_insert_with(|| Box::new(TiledStep::new(system, &word, state, *threads)));
    let reuses = plan.reuses(&word, state[0]);
    if !(plan.take_rounds(system, word, state, reuses) || plan.take_exactly(system, word, state)) {
        return Err(StepFailure::NonFinite);
    }
    if !plan.kept.q.is_empty()
        && let Some(last) = plan.rounds.last()
    {
        plan.kept.origin = word.substeps()[last.clone()].iter().find_map(|substep| word.origin(substep));
    }
    let last = plan.last(&word);
    Ok(NewState { q: &mut plan.coordinates[last], p: &mut plan.momenta, lost: &mut plan.lost })
}
