//! One fixed-point iteration `x ← φ(x)`; for large systems tile by tile, in the best vector instructions
//! of the machine.
//!
//! A tile of the vectors stays in the first-level cache while its forces are computed, then the new
//! unknowns, the velocities that follow from them, and the coordinates for the forces of the next iteration:
//!
//! ```text
//! v' = v - (v + start Σ ∂V/∂q (Q)),   P' = p + v',   u' = Σ ∂T/∂p (P'),   Q' = q + c u'
//! ```
//!
//! Every loop runs over adjacent entries without branches, so that it is vectorised. Each number is computed
//! as in one pass over all placements ([`LoopStep::residual`]), no operation is fused and no sum is split, so
//! that the bits depend neither on tiles nor on instructions.

mod blocks;
mod diagonal;

use std::any::TypeId;
use std::ops::Range;

use blocks::{ComparedUpdate, CoordinateUpdate, ExtrapolatedStart, StoreState, VelocityUpdate};

use super::LEAST_IN_TILES;
use super::layout::{PlacementRecorder, Tile, Tiling};
use super::sums::{OffsetSlice, TileSums};
use super::thread_tiles::{ThreadLists, ThreadTiles, TileResult, on_threads};
use crate::algebra::lanes::instructions::{InstructionSet, Kernel};
use crate::algebra::scalar::{Number, Scalar};
use crate::algebra::solve::relative_to;
use crate::algebra::threads::Threads;
use crate::error::{StepFailure, StepPromise};
use crate::scheme::elements::change::{Change, LargestChange};
use crate::scheme::elements::lanes::{hold, is_in_lanes};
use crate::scheme::elements::memory::{LoopScratch, StepLists};
use crate::scheme::elements::passes::{Largest, in_blocks, subtract};
use crate::scheme::elements::step::LoopStep;
use crate::scheme::elements::sums::ElementInput;
use crate::scheme::elements::{Elements, MomentumUpdate, Partials, Quadrature, Unknowns};
use crate::scheme::system::Hamiltonian as _;

/// Number of places of a tile. Ten slices of this length are in use at a time.
const SIZE: usize = 256;

/// Least number of degrees of freedom for each thread in each pass: the three or more passes of a step of
/// this size take some 500 µs (`cargo bench --workspace --bench elements -- memory`).
const LEAST_OF_THREAD: usize = 1 << 16;

/// An applied correction.
pub(in crate::scheme::elements) struct TileCorrection<S> {
    /// The largest correction relative to the largest unknown; NaN if any is not finite.
    pub(in crate::scheme::elements) relative: S,
    /// The change of the points at which the equations are evaluated, if it costs less than another
    /// iteration.
    pub(in crate::scheme::elements) change: Option<Change>,
}

/// The tiles of a system, and the tiles of each thread.
#[derive(Debug)]
pub(in crate::scheme::elements) struct TiledSweeps {
    tiles: Tiling,
    by_thread: Vec<ThreadTiles<Range<usize>>>,
    instructions: InstructionSet,
    /// Whether the last iteration used tiles, so that the coordinates at its unknowns are stored for the
    /// next one.
    is_ready: bool,
    /// Whether the state after the step is known to be finite.
    is_finite: bool,
}

impl TiledSweeps {
    /// Records the places that the elements of a system add to.
    #[cold]
    #[inline(never)]
    fn new<H: Elements + Sync>(step: &LoopStep<'_, H, f64>, threads: Threads) -> Self {
        let recorder = PlacementRecorder::default();
        for (state, wanted) in [(step.q, Partials::BY_COORDINATES), (step.p, Partials::BY_MOMENTA)] {
            step.gradient_of::<f64, _, _>(|_| 1.0, state, wanted, &mut &recorder);
        }
        let degrees = step.degrees();
        let tiles = Tiling::new(degrees, SIZE, recorder);
        let threads = threads.number(degrees / LEAST_OF_THREAD);
        let by_thread =
            tiles.by_thread(threads).map(|own| ThreadTiles::new(&tiles, &own, own.clone())).collect();
        Self { tiles, by_thread, instructions: InstructionSet::best(), is_ready: false, is_finite: false }
    }
}

impl<H: Elements + Sync, S: Scalar> LoopStep<'_, H, S> {
    /// The start extrapolated from `known` past steps, with its `u` and `P`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::scheme::elements) fn start(&self, scratch: &mut LoopScratch<'_, S>, known: u8) {
        if const { H::FACTS.has_tiles && S::MAY_BE_F64 }
            && self.takes_vectors(scratch)
            && self.start_in_vectors(scratch, known)
        {
            return;
        }
        scratch.guess(known);
        self.refresh(&mut scratch.lists);
    }

    /// `x ← φ(x)`, but for the paths side by side that are `solved`; updates `u` and `P`, which must be those
    /// at `x`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::scheme::elements) fn sweep(
        &self,
        scratch: &mut LoopScratch<'_, S>,
        solved: S::Mask,
    ) -> TileCorrection<S> {
        if const { H::FACTS.has_tiles && S::MAY_BE_F64 }
            && self.takes_vectors(scratch)
            && let Some(swept) = self.sweep_in_vectors(scratch)
        {
            return swept;
        }
        let lists = &mut scratch.lists;
        self.residual_at(lists);
        if const { is_in_lanes::<S>() } {
            hold(lists.correction, solved);
        }
        let relative = subtract(self.scheme.unknowns, lists.x, lists.correction);
        if self.scheme.unknowns == Unknowns::Momenta {
            std::mem::swap(&mut lists.u, &mut lists.by_p);
        }
        self.refresh(lists);
        TileCorrection { relative, change: None }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn takes_vectors(&self, scratch: &LoopScratch<'_, S>) -> bool {
        H::FACTS.has_tiles
            && S::as_f64s(&[]).is_some()
            && self.scheme.unknowns == Unknowns::Momenta
            && self.scheme.stages.len() == 1
            && self.degrees() >= LEAST_IN_TILES
            && !scratch.is_exact
    }

    /// Whether an iteration may have failed because of arguments that vectorised functions do not cover.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::scheme::elements) fn may_have_been_unusual(&self, scratch: &LoopScratch<'_, S>) -> bool {
        TypeId::of::<H::CommonRange>() != TypeId::of::<f64>() && self.takes_vectors(scratch)
    }

    /// This step, if its numbers are `f64`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn plain(&self) -> Option<LoopStep<'_, H, f64>> {
        let &Self { system, scheme, t, h, q, p, dw, increment, .. } = self;
        let ([t, h], parameters) = ([t, h].map(|constant| constant.lane(0)), &[][..]);
        let (q, p, dw, increment) =
            (S::as_f64s(q)?, S::as_f64s(p)?, S::as_f64s(dw)?, increment.and_then(S::as_f64s));
        Some(LoopStep { system, scheme, t, h, parameters, q, p, dw, increment })
    }

    /// [`LoopStep::start`] in vector instructions; returns whether that was possible.
    #[inline(never)]
    fn start_in_vectors(&self, scratch: &mut LoopScratch<'_, S>, known: u8) -> bool {
        let Some(step) = self.plain() else { return false };
        let threads = scratch.threads;
        let sweeps = scratch.solver.sweeps.get_or_insert_with(|| Box::new(TiledSweeps::new(&step, threads)));
        let [Some(a), Some(b), Some(c)] = scratch.solver.past.lists.each_ref().map(|past| S::as_f64s(past))
        else {
            return false;
        };
        let Some(mut lists) = scratch.lists.plain() else { return false };
        let (TiledSweeps { tiles, by_thread, instructions, .. }, past) = (&mut **sweeps, [a, b, c]);
        on_threads(by_thread, lists.parted().0, |thread_tiles, part| {
            instructions.run(TileStart { step, tiles, thread_tiles, part, past, known });
            TileResult::NOTHING
        });
        (sweeps.is_ready, sweeps.is_finite) = (true, false);
        true
    }

    /// [`LoopStep::sweep`] in vector instructions; `None` if that is not possible.
    #[inline(never)]
    fn sweep_in_vectors(&self, scratch: &mut LoopScratch<'_, S>) -> Option<TileCorrection<S>> {
        let (step, sweeps) = (self.plain()?, scratch.solver.sweeps.as_deref_mut()?);
        if !std::mem::replace(&mut sweeps.is_ready, false) {
            return None;
        }
        let lists = &mut scratch.lists;
        lists.stages.turn();
        std::mem::swap(&mut lists.u, &mut lists.by_p);
        let mut lists = lists.plain()?;
        let TiledSweeps { tiles, by_thread, instructions, .. } = &mut *sweeps;
        let (part, now, before) = lists.parted();
        let found = on_threads(by_thread, part, |thread_tiles, part| {
            instructions.run(TileSweep { step, tiles, thread_tiles, part, now, before })
        });
        (sweeps.is_ready, sweeps.is_finite) = (true, found.is_finite);
        let relative = match found.change {
            Change::Unknown => f64::NAN,
            _ => relative_to(found.corrected, found.size),
        };
        Some(TileCorrection { relative: S::from_f64(relative), change: Some(found.change) })
    }
}

impl<H: Elements + Sync> LoopStep<'_, H, f64> {
    /// The sums of derivatives of a tile, at coordinates or momenta.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn gradient_in_tile<'w, T: Number<f64>, V: ElementInput<f64> + ?Sized>(
        &self,
        tile: Tile<'w>,
        state: &V,
        wanted: Partials,
        sums: &'w mut [f64],
    ) -> &'w [f64] {
        let mut in_tile = TileSums::empty(tile, sums);
        self.gradient_of::<T, V, _>(|_| 1.0, state, wanted, &mut in_tile);
        in_tile.finish()
    }

    /// `c` in `Q = q + c u`, and the weight of forces.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn weights(&self) -> [f64; 2] {
        self.scheme.stages.first().map_or([0.0; 2], |stage| [stage.point, stage.start])
    }

    /// The ratio of the change of the momenta to `v`; zero if there is none, so that a finite `p + factor v`
    /// only says that `v` is.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn multiple(&self) -> f64 {
        match self.scheme.update {
            MomentumUpdate::Multiple(factor) => factor,
            MomentumUpdate::Slopes => 0.0,
        }
    }
}

impl StepLists<'_, f64> {
    /// The lists that an iteration writes, the coordinates for its forces, and the previous `u`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn parted(&mut self) -> ([&mut [f64]; 5], &[f64], &[f64]) {
        let Self { x, correction, u, by_p: before, momentum, stages, .. } = self;
        let (now, next) = stages.at_mut(0);
        ([x, correction, momentum, u, next], now, before)
    }
}

impl<H: Elements + Sync, S: Scalar> LoopStep<'_, H, S> {
    /// Whether the last iteration used tiles and leads to a finite state. [`LoopScratch::store_in_tiles`]
    /// then ends the step.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::scheme::elements) fn is_in_tiles(&self, scratch: &mut LoopScratch<'_, S>) -> bool {
        let is_a_multiple = matches!(self.scheme.update, MomentumUpdate::Multiple(_));
        let is_known = |sweeps: &mut Box<TiledSweeps>| {
            std::mem::replace(&mut sweeps.is_ready, false) && sweeps.is_finite
        };
        H::FACTS.has_tiles
            && !H::KIND.is_conformal
            && is_a_multiple
            && scratch.solver.sweeps.as_mut().is_some_and(is_known)
    }
}

impl<S: Scalar> LoopScratch<'_, S> {
    /// Notes that the unknowns change outside of tiles.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(in crate::scheme::elements) fn leave_tiles(&mut self) {
        if let Some(sweeps) = self.solver.sweeps.as_deref_mut() {
            sweeps.is_ready = false;
        }
    }

    /// Adds the increments of a step to the state, and keeps its unknowns if later steps start from them
    /// (`remembers`).
    ///
    /// # Errors
    /// [`StepFailure::Internal`] if the step was not taken in tiles.
    #[inline(never)]
    pub(in crate::scheme::elements) fn store_in_tiles(
        &mut self,
        scheme: &Quadrature,
        remembers: bool,
        q: &mut [S],
        p: &mut [S],
    ) -> Result<(), StepFailure> {
        let missing = Err(StepFailure::Internal(StepPromise::Tiles));
        let (Some(sweeps), MomentumUpdate::Multiple(factor)) =
            (self.solver.sweeps.as_deref_mut(), scheme.update)
        else {
            return missing;
        };
        let (Some(q), Some(p), Some(lists)) = (S::as_f64s_mut(q), S::as_f64s_mut(p), self.lists.plain())
        else {
            return missing;
        };
        let past = if remembers {
            self.solver.past.lists.rotate_right(1);
            S::as_f64s_mut(&mut self.solver.past.lists[0]).unwrap_or_default()
        } else {
            &mut []
        };
        let TiledSweeps { by_thread, instructions, .. } = sweeps;
        on_threads(by_thread, [q, p, lists.u, lists.x, past], |_, part| {
            let [q, p, u, x, past] = part.lists;
            instructions.run(StoreState { q, p, u, x, past, factor });
            TileResult::NOTHING
        });
        Ok(())
    }
}

/// [`LoopStep::start`] in the tiles of one thread.
struct TileStart<'a, 's, H> {
    step: LoopStep<'s, H, f64>,
    tiles: &'a Tiling,
    thread_tiles: &'a mut ThreadTiles<Range<usize>>,
    part: ThreadLists<'a, 5>,
    past: [&'a [f64]; 3],
    known: u8,
}

impl<H: Elements + Sync> Kernel for TileStart<'_, '_, H> {
    type Output = ();

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) {
        let Self { step, tiles, thread_tiles, part: ThreadLists { first, lists }, past, known } = self;
        let [all_x, _, momenta, all_u, all_next] = lists;
        let [point, _] = step.weights();
        for number in thread_tiles.work.clone() {
            let tile = tiles.tile(number);
            let (places, own) = (tile.start..tile.end, tile.start - first..tile.end - first);
            let p = &step.p[places.clone()];
            let past = past.map(|past| past.get(places.clone()).unwrap_or(&[]));
            let (x, momentum) = (&mut all_x[own.clone()], &mut momenta[own.clone()]);
            in_blocks::<L>(p.len(), &mut ExtrapolatedStart { past, known, p, x, momentum });
            let momenta = OffsetSlice { numbers: momenta, first, degrees: step.degrees() };
            let velocities = step.gradient_in_tile::<H::CommonRange, _>(
                tile,
                &momenta,
                Partials::BY_MOMENTA,
                &mut thread_tiles.sums,
            );
            let (u, next) = (&mut all_u[own.clone()], &mut all_next[own]);
            in_blocks::<L>(
                places.len(),
                &mut CoordinateUpdate::new(&step, &places, velocities, point, u, next),
            );
        }
    }
}

/// [`LoopStep::sweep`] in the tiles of one thread.
struct TileSweep<'a, 's, H> {
    step: LoopStep<'s, H, f64>,
    tiles: &'a Tiling,
    thread_tiles: &'a mut ThreadTiles<Range<usize>>,
    part: ThreadLists<'a, 5>,
    /// Coordinates of all places for the forces.
    now: &'a [f64],
    /// `u` of the previous iteration.
    before: &'a [f64],
}

impl<H: Elements + Sync> Kernel for TileSweep<'_, '_, H> {
    type Output = TileResult;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) -> TileResult {
        let Self { step, tiles, thread_tiles, part: ThreadLists { first, lists }, now, before } = self;
        let [all_x, corrections, momenta, all_u, all_next] = lists;
        let ([point, weight], factor, mut zeros) = (step.weights(), step.multiple(), [0.0; HALF]);
        let (mut size, mut corrected, mut seen) =
            (Largest::<HALF>::default(), Largest::<HALF>::default(), LargestChange::<HALF>::new());
        for number in thread_tiles.work.clone() {
            let tile = tiles.tile(number);
            let (places, own) = (tile.start..tile.end, tile.start - first..tile.end - first);
            let p = &step.p[places.clone()];
            let forces = step.gradient_in_tile::<H::CommonRange, _>(
                tile,
                now,
                Partials::BY_COORDINATES,
                &mut thread_tiles.sums,
            );
            let (x, correction) = (&mut all_x[own.clone()], &mut corrections[own.clone()]);
            let momentum = &mut momenta[own.clone()];
            let mut kick = VelocityUpdate { forces, weight, p, x, correction, momentum, size, corrected };
            in_blocks::<HALF>(places.len(), &mut kick);
            (size, corrected) = (kick.size, kick.corrected);
            let momenta = OffsetSlice { numbers: momenta, first, degrees: step.degrees() };
            let velocities = step.gradient_in_tile::<H::CommonRange, _>(
                tile,
                &momenta,
                Partials::BY_MOMENTA,
                &mut thread_tiles.sums,
            );
            let (u, next) = (&mut all_u[own.clone()], &mut all_next[own.clone()]);
            let follow = CoordinateUpdate::new(&step, &places, velocities, point, u, next);
            let (x, before) = (&all_x[own], &before[places.clone()]);
            let compared = &mut ComparedUpdate { p, x, factor, zeros, follow, before, seen: &mut seen };
            in_blocks::<HALF>(places.len(), compared);
            zeros = compared.zeros;
        }
        let (size, corrected, change) = (size.get(), corrected.get(), seen.finish());
        TileResult { size, corrected, change, is_finite: zeros.iter().sum::<f64>() == 0.0 }
    }
}
