//! The rounds of one thread.
//!
//! Each thread has a range of adjacent tiles and the part of the new state that belongs to them. It takes
//! those rounds that do not depend on the output of other threads. The rest, a few tiles at the borders, is
//! taken when all threads have finished. Every number is the same as on one thread: the order of the rounds
//! changes no term and no order of a sum.

use std::marker::PhantomData;
use std::ops::Range;

use super::check::Check;
use super::layout::{Tile, Tiling};
use super::sums::{OffsetSlice, OntoTile, TileSums};
use super::thread_tiles::{ThreadLists, ThreadTiles};
use super::wavefront::TileRound;
use super::{Elements, LINE, Partials, TileParts};
use crate::algebra::lanes::instructions::Kernel;
use crate::algebra::scalar::Number;
use crate::scheme::word::{Part, Substep};

/// The data of a step that all threads share.
#[derive(Clone, Copy)]
pub(super) struct TiledStepInput<'a> {
    pub(super) tiles: &'a Tiling,
    pub(super) rounds: &'a [Range<usize>],
    pub(super) q: &'a [f64],
    pub(super) p: &'a [f64],
    /// Whether the first force of the step is the kept one.
    pub(super) reuses: bool,
}

/// The rounds of a thread, and scratch for the sums of a tile.
pub(super) type ThreadRounds = ThreadTiles<Vec<TileRound>>;

/// Rounds of tiles, with derivatives in numbers `T`. `WHOLE`, for a part that covers the whole system, is a
/// compile-time constant because offsets into a smaller one take time.
pub(super) struct Wavefront<'a, H, W, T, const WHOLE: bool> {
    step: TiledStepInput<'a>,
    system: &'a H,
    word: W,
    tile_rounds: &'a [TileRound],
    sums: &'a mut [f64],
    /// The new state: coordinates after the rounds with even and with odd numbers, momenta, the coordinates
    /// at which the last force acts, and the force, and what rounding took from coordinates and from momenta.
    part: ThreadLists<'a, 7>,
    numbers: PhantomData<fn() -> T>,
}

impl<'a, H: Elements + Sync, W: TileParts, T: Number<f64>, const WHOLE: bool> Wavefront<'a, H, W, T, WHOLE> {
    pub(super) fn new(
        step: TiledStepInput<'a>,
        system: &'a H,
        word: W,
        share: &'a mut ThreadRounds,
        part: ThreadLists<'a, 7>,
    ) -> Self {
        let ThreadTiles { work: tile_rounds, sums, .. } = share;
        let first = sums[step.tiles.margin()..].as_ptr().align_offset(LINE * size_of::<f64>()).min(LINE);
        Self { step, system, word, tile_rounds, sums: &mut sums[first..], part, numbers: PhantomData }
    }
}

/// The output is whether all new numbers are finite.
impl<H: Elements + Sync, W: TileParts, T: Number<f64>, const WHOLE: bool> Kernel
    for Wavefront<'_, H, W, T, WHOLE>
{
    type Output = bool;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) -> bool {
        let mut part = self.part;
        let Self { step, system, word, tile_rounds, sums, .. } = self;
        let TiledStepInput { tiles, rounds, q, p, reuses } = step;
        // The positions of lists are read again for each part; otherwise the compiler computes offsets for
        // parts that never come.
        let ThreadLists { first, lists: [even, odd, momenta, kept_q, kept_force, lost_q, lost_p] } =
            &mut part;
        let (first, last) = (if WHOLE { 0 } else { *first }, rounds.len() - 1);
        let keeps = W::ADDS_TERMS && !kept_q.is_empty() && last > 0;
        let mut check = Check::default();
        for &TileRound { round, tile_index } in tile_rounds {
            let tile = tiles.tile(tile_index);
            let places = tile.start..tile.end;
            let own = tile.start - first..tile.end - first;
            let (from, to): (&[f64], &mut &mut [f64]) = match round {
                0 => (q, &mut *even),
                round if round % 2 == 1 => (*even, &mut *odd),
                _ => (*odd, &mut *even),
            };
            if W::CARRIES && round == 0 {
                let [of_q, of_p] = word.lost();
                lost_q[own.clone()].copy_from_slice(&of_q[places.clone()]);
                lost_p[own.clone()].copy_from_slice(&of_p[places.clone()]);
            }
            let mut taken = TileInRound::<'_, H, W, WHOLE> {
                system,
                word: &word,
                check: &mut check,
                tile,
                first,
                from: OffsetSlice {
                    numbers: from,
                    first: if WHOLE || round == 0 { 0 } else { first },
                    degrees: q.len(),
                },
                to,
                momenta,
                lost_q,
                lost_p,
                sums,
                base: (round == 0).then(|| &p[places.clone()]),
                has_drifted: false,
            };
            for substep in &word.substeps()[rounds[round].clone()] {
                if !substep.part.is_kick() {
                    taken.store_base();
                }
                match substep.part {
                    Part::B | Part::GradientB(_) if W::ADDS_TERMS && reuses && round == 0 => {
                        taken.kick_again(&kept_force[own.clone()]);
                    }
                    Part::B | Part::GradientB(_) => {
                        let force = taken.kick::<T>(substep);
                        if keeps && round == last {
                            kept_force[own.clone()].copy_from_slice(force);
                            kept_q[own.clone()].copy_from_slice(&taken.from[places.clone()]);
                        }
                    }
                    Part::A => taken.drift::<T>(substep),
                    Part::O if W::RELAXES => taken.relax(substep),
                    Part::AOA if W::RELAXES => taken.relax_and_drift(substep),
                    Part::O | Part::AOA => {}
                }
            }
        }
        check.is_finite()
    }
}

/// A tile in a round.
struct TileInRound<'t, H, W, const WHOLE: bool> {
    system: &'t H,
    word: &'t W,
    check: &'t mut Check,
    tile: Tile<'t>,
    /// The first place of the part.
    first: usize,
    /// Coordinates before the round (`from`) and after it (`to`).
    from: OffsetSlice<'t>,
    to: &'t mut [f64],
    momenta: &'t mut [f64],
    /// The rounding errors of coordinates and momenta, if sums are compensated.
    lost_q: &'t mut [f64],
    lost_p: &'t mut [f64],
    sums: &'t mut [f64],
    /// The momenta of the state, until new ones are stored.
    base: Option<&'t [f64]>,
    has_drifted: bool,
}

impl<H: Elements + Sync, W: TileParts, const WHOLE: bool> TileInRound<'_, H, W, WHOLE> {
    /// The range of its places in the part.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn own(&self) -> Range<usize> {
        self.tile.start - self.first..self.tile.end - self.first
    }

    /// Copies the momenta of the state, unless a kick has stored new ones.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn store_base(&mut self) {
        if let Some(base) = self.base.take() {
            let own = self.own();
            self.momenta[own].copy_from_slice(base);
        }
    }

    /// Adds the kept force of the previous step to the momenta.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn kick_again(&mut self, force: &[f64]) {
        let own = self.own();
        let (p, base) = (&mut self.momenta[own.clone()], self.base.take());
        if W::CARRIES {
            return self.check.store_compensated(p, base, force, &mut self.lost_p[own], |force| force);
        }
        self.check.store(p, base, force, |p, force| p + force);
    }

    /// Adds forces to momenta; returns the sums of the tile.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn kick<T: Number<f64>>(&mut self, kick: &Substep) -> &[f64] {
        let own = self.own();
        let p = &mut self.momenta[own.clone()];
        // Forces at ends of steps are summed, since other steps may use them.
        let adds_in_turn = W::ADDS_TERMS && !W::CARRIES && !kick.force.is_at_end();
        let mut into = match adds_in_turn {
            true => TileSums::onto(self.tile, self.sums, self.base.unwrap_or(p)),
            false => TileSums::empty(self.tile, self.sums),
        };
        let (system, word, wanted) = (self.system, self.word, Partials::BY_COORDINATES);
        match WHOLE {
            true => word.add_gradient::<H, T, _, _>(system, kick, self.from.numbers, wanted, &mut into),
            false => word.add_gradient::<H, T, _, _>(system, kick, &self.from, wanted, &mut into),
        }
        let (base, sums) = (self.base.take(), into.finish());
        if W::CARRIES {
            let lost = &mut self.lost_p[own];
            match W::ADDS_TERMS {
                true => self.check.store_compensated(p, base, sums, lost, |sum| sum),
                false => self.check.store_compensated(p, base, sums, lost, |sum| 0.0 - sum),
            }
            return sums;
        }
        match W::ADDS_TERMS {
            true if adds_in_turn => self.check.store(p, base, sums, |_, sum| sum),
            true => self.check.store(p, base, sums, |p, sum| p + sum),
            false if kick.number == 0 => self.check.store(p, base, sums, |p, sum| p - sum),
            false => self.check.store(p, base, sums, |p, sum| p + (0.0 - sum)),
        }
        sums
    }

    /// Adds velocities to coordinates.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn drift<T: Number<f64>>(&mut self, drift: &Substep) {
        let own = self.own();
        let Self { system, word, tile, first, from, to, momenta, lost_q, has_drifted, .. } = self;
        let wanted = Partials::BY_MOMENTA;
        let stretch = &OffsetSlice { numbers: momenta, first: *first, degrees: from.degrees };
        if H::FACTS.has_one_velocity && !(W::RELAXES && *has_drifted) && !W::CARRIES {
            let mut moved = OntoTile { tile: *tile, base: *from, next: to, first: *first };
            match WHOLE {
                true => word.add_gradient::<H, T, _, _>(system, drift, stretch.numbers, wanted, &mut moved),
                false => word.add_gradient::<H, T, _, _>(system, drift, stretch, wanted, &mut moved),
            }
            self.check.include(&to[own]);
        } else {
            let base = (!*has_drifted).then(|| &from[tile.start..tile.end]);
            let q = &mut to[own.clone()];
            let mut into = match W::ADDS_TERMS && !W::CARRIES {
                true => TileSums::onto(*tile, self.sums, base.unwrap_or(q)),
                false => TileSums::empty(*tile, self.sums),
            };
            match WHOLE {
                true => word.add_gradient::<H, T, _, _>(system, drift, stretch.numbers, wanted, &mut into),
                false => word.add_gradient::<H, T, _, _>(system, drift, stretch, wanted, &mut into),
            }
            let sums = into.finish();
            match W::ADDS_TERMS {
                _ if W::CARRIES => {
                    self.check.store_compensated(q, base, sums, &mut lost_q[own], |sum| sum);
                }
                true => self.check.store(q, base, sums, |_, sum| sum),
                false => self.check.store(q, base, sums, |q, sum| q + sum),
            }
        }
        *has_drifted = true;
    }

    /// Friction and noise of the bath.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn relax(&mut self, substep: &Substep) {
        let own = self.own();
        let lost = if W::CARRIES { &mut self.lost_p[own.clone()] } else { &mut [] };
        let p = &mut self.momenta[own];
        self.word.relax(substep, self.tile.start..self.tile.end, &mut [], p, lost);
        self.check.include(p);
    }

    /// Friction and noise between two drifts.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn relax_and_drift(&mut self, substep: &Substep) {
        let places = self.tile.start..self.tile.end;
        let own = self.own();
        let (q, p) = (&mut self.to[own.clone()], &mut self.momenta[own]);
        if !self.has_drifted {
            q.copy_from_slice(&self.from[places.clone()]);
        }
        self.word.relax(substep, places, q, p, &mut []);
        self.check.include(q);
        self.check.include(p);
        self.has_drifted = true;
    }
}
